//! Everything that light between patches needs and that does not depend on light: patches, their exchange matrix in the codec's form, its spectrum,
//! and where light of patches is mixed. Made once, kept in a folder (`files`), loaded by every picture.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::codec::bc1::Bc1;
use super::codec::bc4_chroma::Bc4Chroma;
use super::codec::half::Half;
use super::codec::thesis::{self, Holes, Thesis};
use super::codec::{Code, Dense, Summed, ZeroBlock, bounces};
use super::exchange::Exchange;
use super::factors::Report;
use super::judge::{Judge, after_bounces, product_of_sums, wide};
use super::order::{Order, Orders};
use super::patches::{PatchSource, Patches};
use super::spectrum::{self, Spectrum};
use super::transfer::Transfer;
use crate::error::{Error, Result};
use crate::scene::Scene;

/// Places of a patch at which direct light is looked at, at most.
pub const POINTS: u32 = 16;
/// How many patches, or how wide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PatchRule {
    /// About so many.
    Count(usize),
    /// Metres.
    Size(f64),
}

/// How the matrix is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CodecName {
    /// Form factors of 32 bits, gathered as often as light bounces.
    Classical,
    /// Bounces summed beforehand, 16 bits an element and channel.
    DenseF16,
    /// Bounces summed beforehand, as [`Thesis`] stores them.
    Thesis,
    /// Likewise, with holes filled.
    ThesisFilled,
    /// Bounces summed beforehand, see [`Bc1`].
    Bc1,
    /// Bounces summed beforehand, see [`Bc4Chroma`].
    Bc4Chroma,
    /// Form factors, see [`ZeroBlock`].
    ZeroBlock,
}

impl CodecName {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Classical,
        Self::DenseF16,
        Self::Thesis,
        Self::ThesisFilled,
        Self::Bc1,
        Self::Bc4Chroma,
        Self::ZeroBlock,
    ];

    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Classical => "classical",
            Self::DenseF16 => "dense-f16",
            Self::Thesis => "thesis",
            Self::ThesisFilled => "thesis-filled",
            Self::Bc1 => "bc1",
            Self::Bc4Chroma => "bc4-chroma",
            Self::ZeroBlock => "zero-block",
        }
    }

    /// Bounces are summed beforehand: reflectance is in the matrix, and light comes to rest in one gather.
    pub fn is_summed(self) -> bool {
        !matches!(self, Self::Classical | Self::ZeroBlock)
    }

    /// Bounces that are summed where nothing is said: three in the thesis, all of them in what came after.
    pub fn default_bounces(self) -> Option<u32> {
        matches!(self, Self::Thesis | Self::ThesisFilled).then_some(3)
    }

    /// Order where nothing is said.
    pub fn default_order(self) -> Order {
        match self {
            Self::Thesis | Self::ThesisFilled => Order::RowsColumns,
            Self::Bc1 | Self::Bc4Chroma => Order::Landmarks,
            _ => Order::None,
        }
    }
}

/// What is baked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// How many patches, or how wide.
    pub patches: PatchRule,
    /// What they are made from.
    pub patches_from: PatchSource,
    /// How the matrix is stored.
    pub codec: CodecName,
    /// Share of elements whose residual is stored beside the blocks of `zero-block`, 0 to 1.
    pub extract: f64,
    /// Bounces that are summed beforehand; none: all.
    pub bounces: Option<u32>,
    /// Of rows and columns.
    pub order: Order,
    /// Of rays and points.
    pub seed: u64,
}

impl Settings {
    /// The defaults for about so many patches.
    pub fn of_count(count: usize) -> Self {
        Self { patches: PatchRule::Count(count), ..Self::default() }
    }

    /// The defaults of a codec.
    pub fn of_codec(codec: CodecName) -> Self {
        Self { codec, bounces: codec.default_bounces(), order: codec.default_order(), ..Self::default() }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            patches: PatchRule::Count(1000),
            patches_from: PatchSource::Triangles,
            codec: CodecName::ZeroBlock,
            extract: 0.02,
            bounces: None,
            order: Order::None,
            seed: 1,
        }
    }
}

/// The exchange matrix as a device reads it.
#[derive(Debug, Clone, PartialEq)]
pub enum Operator {
    /// See [`Dense`].
    Dense(Dense),
    /// See [`ZeroBlock`].
    ZeroBlock(ZeroBlock),
    /// See [`Summed`].
    Summed(Box<Summed>),
}

impl Operator {
    /// Bytes on a device.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Dense(dense) => dense.bytes(),
            Self::ZeroBlock(blocks) => blocks.bytes(),
            Self::Summed(summed) => summed.bytes().total() as u64,
        }
    }

    /// One gather: what `sent` comes to in each row. It is exitance times area, or exitance alone where bounces are summed.
    pub fn product(&self, sent: &[[f32; 3]], lanes: usize) -> Vec<[f32; 3]> {
        match self {
            Self::Dense(dense) => dense.product(sent, lanes),
            Self::ZeroBlock(blocks) => blocks.product(sent, lanes),
            Self::Summed(summed) => summed.product(sent, lanes),
        }
    }
}

/// A baked scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Bake {
    /// [`Scene::surface_fingerprint`].
    pub fingerprint: String,
    /// What was asked for.
    pub settings: Settings,
    /// Patches and what was left out; their triangles are not kept in files.
    pub patches: Patches,
    /// [`POINTS`] places a patch with the unit normals there, world space.
    pub points: Vec<[DVec3; 2]>,
    /// The exchange matrix.
    pub operator: Operator,
    /// Where light of patches is mixed.
    pub transfer: Transfer,
    /// Of the operator times reflectance.
    pub spectrum: Spectrum,
    /// How the factors came to be.
    pub factors: Report,
    /// Relative L2 error of irradiance after all bounces (of those that are summed) that the codec makes: mean and largest over light set-ups.
    pub codec_error: [f64; 2],
    /// What everything stored was scaled by, so that no bounce adds energy: 1 where it need not be.
    pub norm_scale: f64,
}

impl Bake {
    /// All of it, without a file.
    ///
    /// # Errors
    /// See [`Exchange::of_scene`] and [`Bake::new`].
    pub fn of_scene(scene: &Scene, settings: Settings) -> Result<Self> {
        Self::new(Exchange::of_scene(scene, &settings)?, settings)
    }

    /// The matrix in the form of a codec.
    ///
    /// # Errors
    /// Bounces that cannot be summed.
    pub fn new(exchange: Exchange, settings: Settings) -> Result<Self> {
        let Exchange { patches, exact, .. } = &exchange;
        if settings.codec.is_summed() {
            let (summed, codec_error) = summed(exact, patches, settings)?;
            return Ok(Self { codec_error, ..Self::of_sums(exchange, settings, summed) });
        }
        let operator = match settings.codec {
            CodecName::Classical => Operator::Dense(exact.clone()),
            _ => Operator::ZeroBlock(ZeroBlock::encode(&exact.elements, &exchange.areas(), settings.extract)),
        };
        let (operator, spectrum, norm_scale) = kept_below_one(operator, patches, &exchange.spectrum);
        let judge = Judge::new(patches, &|b| after_bounces(&|sent| exact.product(sent, 32), patches, b));
        let found = judge.error(&|b| after_bounces(&|sent| operator.product(sent, 32), patches, b));
        let codec_error = [found.mean, found.worst];
        Ok(Self { spectrum, norm_scale, codec_error, ..Self::of_operator(exchange, settings, operator) })
    }

    /// With bounces that were summed and encoded before; what the codec makes of them is not measured.
    pub fn of_sums(exchange: Exchange, settings: Settings, summed: Summed) -> Self {
        Self::of_operator(exchange, settings, Operator::Summed(Box::new(summed)))
    }

    fn of_operator(exchange: Exchange, settings: Settings, operator: Operator) -> Self {
        let Exchange { fingerprint, patches, points, transfer, spectrum, factors, .. } = exchange;
        Self {
            fingerprint,
            settings,
            points,
            transfer,
            patches,
            operator,
            spectrum,
            factors,
            codec_error: [0.0; 2],
            norm_scale: 1.0,
        }
    }

    /// Bytes of the matrix an element.
    pub fn bytes_an_element(&self) -> f64 {
        let count = self.patches.list.len() as f64;
        if count > 0.0 { self.operator.bytes() as f64 / (count * count) } else { 0.0 }
    }
}

/// Bounces of the stored matrix end as those of the exact one do: no albedo of the scene passes a bound between that and 1.
fn kept_below_one(operator: Operator, patches: &Patches, exact: &Spectrum) -> (Operator, Spectrum, f64) {
    let found = spectrum::of(&|sent| operator.product(sent, 32), patches);
    let bound = 0.5 * (1.0 + exact.largest);
    if found.largest <= bound {
        return (operator, found, 1.0);
    }
    let factor = bound / found.largest;
    let operator = match operator {
        Operator::Dense(mut dense) => {
            dense.elements.iter_mut().for_each(|x| *x *= factor as f32);
            Operator::Dense(dense)
        }
        Operator::ZeroBlock(blocks) => Operator::ZeroBlock(blocks.scaled(factor as f32)),
        Operator::Summed(summed) => Operator::Summed(summed),
    };
    let spectrum = spectrum::of(&|sent| operator.product(sent, 32), patches);
    (operator, spectrum, factor)
}

/// Sums of bounces by channel, and what rows are multiplied by in the end.
pub type Sums = ([Vec<f32>; 3], Option<Vec<[f32; 3]>>);

/// Bounces of a scene, as many as are asked for, in the form that the codec stores: irradiance, or in the thesis' the exitance that it leads to.
///
/// # Errors
/// Light that does not come to rest.
pub fn sum_bounces(exact: &Dense, patches: &Patches, codec: CodecName, count: Option<u32>) -> Result<Sums> {
    let n = exact.count;
    let reflectance: Vec<[f32; 3]> = patches.list.iter().map(|p| p.reflectance.as_vec3().to_array()).collect();
    let area = |at: usize| patches.list[at % n].area;
    let factors: Vec<f32> =
        exact.elements.iter().enumerate().map(|(at, x)| (f64::from(*x) * area(at)) as f32).collect();
    let mut sums = match count {
        Some(count) => bounces::polynomial(&factors, n, &reflectance, count),
        None => bounces::resolvent(&factors, n, &reflectance),
    }
    .map_err(Error::new)?;
    if !matches!(codec, CodecName::Thesis | CodecName::ThesisFilled) {
        return Ok((sums, None));
    }
    for (c, sum) in sums.iter_mut().enumerate() {
        sum.iter_mut().enumerate().for_each(|(at, x)| *x *= reflectance[at / n][c]);
    }
    let inverse = |x: f32| if x > 0.0 { 1.0 / x } else { 0.0 };
    Ok((sums, Some(reflectance.iter().map(|r| r.map(inverse)).collect())))
}

/// Encodes sums of bounces in orders of their own.
///
/// # Errors
/// More patches than the codec's columns reach.
pub fn encode_sums(n: usize, (sums, scales): Sums, codec: CodecName, order: Order) -> Result<Summed> {
    let image = if order == Order::None { vec![0; 3 * n * n] } else { thesis::image(n, &sums).map_err(Error::new)? };
    let orders = Orders::new(order, &image, n, 3).map_err(Error::new)?;
    drop(image);
    let sums = match order {
        Order::None => sums,
        _ => {
            let [red, green, blue] = sums.map(|of| orders.apply(&of));
            [red.map_err(Error::new)?, green.map_err(Error::new)?, blue.map_err(Error::new)?]
        }
    };
    let code = match codec {
        CodecName::DenseF16 => Half::encode(n, &sums).map(Code::Half),
        CodecName::Thesis => Thesis::encode(n, &sums, Holes::Zero).map(Code::Thesis),
        CodecName::ThesisFilled => Thesis::encode(n, &sums, Holes::Filled).map(Code::Thesis),
        CodecName::Bc4Chroma => Bc4Chroma::encode(n, &sums).map(Code::Bc4Chroma),
        _ => Bc1::encode(n, &sums).map(Code::Bc1),
    };
    Ok(Summed { code: code.map_err(Error::new)?, orders, scales })
}

fn summed(exact: &Dense, patches: &Patches, settings: Settings) -> Result<(Summed, [f64; 2])> {
    let n = exact.count;
    let sums = sum_bounces(exact, patches, settings.codec, settings.bounces)?;
    let coded = encode_sums(n, sums.clone(), settings.codec, settings.order)?;
    let judge = Judge::new(patches, &|exitance| product_of_sums(&sums, exitance));
    let found = judge.error(&|exitance| wide(&coded.product(exitance, 32)));
    let error = [found.mean, found.worst];
    Ok((coded, error))
}

#[cfg(test)]
pub(crate) mod tests;
