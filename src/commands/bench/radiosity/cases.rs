//! The ways to gather that are compared.

use std::sync::Arc;
use std::time::Instant;

use serde_json::{Value, json};

use super::paths::Traced;
use crate::commands::bench::cell::Cell;
use crate::error::Result;
use crate::measure::times::Spread;
use crate::plan::bounced::steps;
use crate::plan::{Gathering, Iteration, MatrixPath};
use crate::radiosity::bake::{self, Bake, CodecName, Settings};
use crate::radiosity::gather::{gathered, gathered_each};
use crate::radiosity::judge::{Found, Judge, after_bounces, product_of_sums, wide};
use crate::radiosity::order::Order;
use crate::radiosity::{Exchange, Patches};
use crate::shared::GATHER_LANES;

/// Error of the whole that iterations are run to where they are compared, relative L2.
const TARGET: f64 = 0.005;
const MOST_STEPS: u32 = 20;
/// Frames after which light has settled.
const SETTLED: u32 = 40;

/// A way to gather, and how good it is.
pub(super) struct Row {
    pub name: String,
    pub kind: &'static str,
    pub bake: Arc<Bake>,
    pub gathering: Gathering,
    /// Products with the matrix.
    pub steps: u32,
    /// That the codec took.
    pub seconds: f64,
    pub found: Found,
    /// Of bounces that are summed beforehand: relative L2 against their exact sum, which leaves out what is cut off.
    pub codec_alone: Option<f64>,
    /// Root mean square over patches against paths, over their mean.
    pub against_paths: f64,
}

impl Row {
    /// What the machine form says beside the cell.
    pub fn facts(&self) -> Value {
        let mut facts = super::facts(self.kind, &self.name);
        if let Some(fields) = facts.as_object_mut() {
            fields.insert("patches".into(), json!(self.bake.patches.list.len()));
            fields.insert("gathers".into(), json!(self.steps));
            fields.insert("bytes_an_element".into(), json!(self.bake.bytes_an_element()));
            fields.insert("matrix_bytes".into(), json!(self.bake.operator.bytes()));
            fields.insert("codec_seconds".into(), json!(self.seconds));
            fields.insert("relative_l2".into(), json!({ "mean": self.found.mean, "worst": self.found.worst }));
            fields.insert("codec_relative_l2".into(), json!(self.codec_alone));
            fields.insert("energy".into(), json!(self.found.energy));
            fields.insert("rms_against_paths".into(), json!(self.against_paths));
        }
        facts
    }
}

/// Milliseconds of a frame: direct light of patches, and all gathers; medians.
pub(super) fn gi_ms(cell: &Cell) -> Option<[f64; 2]> {
    let times = cell.times()?;
    let of = |gather: bool| {
        let sums = times.node_ms.iter().filter(|row| !row.is_empty()).map(|row| {
            let own = times.names.iter().zip(row).filter(|(name, _)| {
                let gathers = name.starts_with("patch_gather") || name.starts_with("patch_product");
                if gather { gathers } else { *name == "patch_light" }
            });
            own.map(|(_, ms)| ms).sum::<f64>()
        });
        Spread::of(&sums.collect::<Vec<f64>>()).median
    };
    (!times.node_ms.iter().all(Vec::is_empty)).then(|| [of(false), of(true)])
}

/// What judges rows, and what they are made from.
struct Maker<'a> {
    patches: &'a Patches,
    areas: Vec<f32>,
    reflectance: Vec<[f32; 3]>,
    judge: Judge,
    traced: &'a Traced,
}

impl Maker<'_> {
    /// Irradiance as the device gathers it.
    fn light(&self, bake: &Bake, first: &[[f32; 3]], iteration: Iteration, count: u32) -> Vec<[f32; 3]> {
        let steps = steps(iteration, bake.spectrum.smallest, bake.spectrum.largest, count);
        gathered(&bake.operator, &self.areas, &self.reflectance, first, &steps, GATHER_LANES as usize)
    }

    /// After each of so many gathers.
    fn found(&self, bake: &Bake, iteration: Iteration, count: u32) -> Vec<Found> {
        let steps = steps(iteration, bake.spectrum.smallest, bake.spectrum.largest, count);
        let mut by_step: Vec<Vec<Vec<[f64; 3]>>> = vec![Vec::new(); steps.len()];
        for first in self.judge.lights() {
            let mut step = 0;
            let patches = [self.areas.as_slice(), self.reflectance.as_flattened()];
            gathered_each(&bake.operator, patches, first, &steps, GATHER_LANES as usize, &mut |light| {
                by_step[step].push(wide(light));
                step += 1;
            });
        }
        by_step.iter().filter(|lights| !lights.is_empty()).map(|lights| self.judge.score(lights)).collect()
    }

    fn row(
        &self,
        name: String,
        bake: &Arc<Bake>,
        gathering: Gathering,
        (found, count): (Found, u32),
        seconds: f64,
    ) -> Row {
        let light = self.light(bake, &self.traced.exitance(self.patches), gathering.iteration, count);
        Row {
            name,
            kind: bake.settings.codec.name(),
            bake: Arc::clone(bake),
            gathering: Gathering { gathers: Some(count), ..gathering },
            steps: count,
            seconds,
            found,
            codec_alone: None,
            against_paths: self.traced.rms(&wide(&light)),
        }
    }
}

/// As few gathers as the target needs, or as come near to what the codec itself is off by.
fn enough(found: &[Found]) -> u32 {
    let target = TARGET.max(1.1 * found.last().map_or(0.0, |last| last.mean));
    found.iter().position(|of| of.mean <= target).map_or(found.len(), |at| at + 1) as u32
}

/// All rows.
///
/// # Errors
/// Bounces that cannot be summed.
pub(super) fn rows(exchange: &Exchange, traced: &Traced) -> Result<Vec<Row>> {
    let patches = &exchange.patches;
    let exact = |sent: &[[f32; 3]]| exchange.exact.product(sent, GATHER_LANES as usize);
    let maker = Maker {
        patches,
        areas: patches.list.iter().map(|patch| patch.area as f32).collect(),
        reflectance: patches.list.iter().map(|patch| patch.reflectance.as_vec3().to_array()).collect(),
        judge: Judge::new(patches, &|first| after_bounces(&exact, patches, first)),
        traced,
    };
    let mut rows = Vec::new();
    iterated(exchange, &maker, &mut rows)?;
    summed(exchange, &maker, &mut rows)?;
    Ok(rows)
}

/// Codecs whose bounces are gathered one by one.
fn iterated(exchange: &Exchange, maker: &Maker, rows: &mut Vec<Row>) -> Result<()> {
    let base = Gathering::default();
    let bake = Arc::new(Bake::new(exchange.clone(), Settings::of_codec(CodecName::Classical))?);
    let by_neumann = maker.found(&bake, Iteration::Neumann, MOST_STEPS);
    let by_chebyshev = maker.found(&bake, Iteration::Chebyshev, MOST_STEPS);
    let (neumann, chebyshev) = (enough(&by_neumann), enough(&by_chebyshev));
    let of =
        |path: MatrixPath, thread_rows: bool, iteration: Iteration| Gathering { path, thread_rows, iteration, ..base };
    let ways = [
        ("a thread a row, Neumann", of(MatrixPath::Buffer, true, Iteration::Neumann), 3),
        ("a thread a row, Neumann", of(MatrixPath::Buffer, true, Iteration::Neumann), neumann),
        ("buffer, Neumann", of(MatrixPath::Buffer, false, Iteration::Neumann), neumann),
        ("texel, Neumann", of(MatrixPath::Texel, false, Iteration::Neumann), neumann),
        ("sampled, Neumann", of(MatrixPath::Sampled, false, Iteration::Neumann), neumann),
        ("buffer, Chebyshev", of(MatrixPath::Buffer, false, Iteration::Chebyshev), chebyshev),
        ("texel, Chebyshev", of(MatrixPath::Texel, false, Iteration::Chebyshev), chebyshev),
    ];
    for (way, gathering, count) in ways {
        let found = if gathering.iteration == Iteration::Neumann { &by_neumann } else { &by_chebyshev };
        let scored = (found[count as usize - 1], count);
        rows.push(maker.row(format!("classical, {way}, {count} gathers"), &bake, gathering, scored, 0.0));
    }
    let start = Instant::now();
    let bake = Arc::new(Bake::new(exchange.clone(), Settings::of_codec(CodecName::ZeroBlock))?);
    let seconds = start.elapsed().as_secs_f64();
    let found = maker.found(&bake, Iteration::Chebyshev, MOST_STEPS);
    let enough = enough(&found);
    let mut counts: Vec<u32> = (2..=6).chain([enough]).collect();
    counts.sort_unstable();
    counts.dedup();
    let buffer = of(MatrixPath::Buffer, false, Iteration::Chebyshev);
    for count in counts {
        let scored = (found[count as usize - 1], count);
        rows.push(maker.row(format!("zero-block, buffer, {count} gathers"), &bake, buffer, scored, seconds));
    }
    // Light that has settled has all bounces; each frame gathers once.
    let feedback = Gathering { feedback: true, iteration: Iteration::Neumann, path: MatrixPath::Texel, ..base };
    let by_neumann = maker.found(&bake, Iteration::Neumann, SETTLED);
    let settled = maker.row(
        "zero-block, texel, one gather and feedback, settled".into(),
        &bake,
        Gathering { feedback: false, ..feedback },
        (by_neumann[SETTLED as usize - 1], SETTLED),
        seconds,
    );
    rows.push(Row { steps: 1, gathering: Gathering { gathers: Some(1), ..feedback }, ..settled });
    let texel = of(MatrixPath::Texel, false, Iteration::Chebyshev);
    let scored = (found[enough as usize - 1], enough);
    rows.push(maker.row(format!("zero-block, texel, {enough} gathers"), &bake, texel, scored, seconds));
    Ok(())
}

/// Codecs whose bounces are summed beforehand.
fn summed(exchange: &Exchange, maker: &Maker, rows: &mut Vec<Row>) -> Result<()> {
    let n = exchange.exact.count;
    let base = Gathering { path: MatrixPath::Buffer, ..Gathering::default() };
    let texel = Gathering { path: MatrixPath::Texel, ..base };
    let groups: [&[(CodecName, Order, &str)]; 2] = [
        &[
            (CodecName::Thesis, Order::RowsColumns, "thesis"),
            (CodecName::Thesis, Order::Rows, "thesis, one pass of ordering"),
            (CodecName::Thesis, Order::None, "thesis, not ordered"),
            (CodecName::ThesisFilled, Order::RowsColumns, "thesis-filled"),
        ],
        &[
            (CodecName::DenseF16, Order::None, "dense-f16"),
            (CodecName::Bc1, Order::Landmarks, "bc1"),
            (CodecName::Bc4Chroma, Order::Landmarks, "bc4-chroma"),
        ],
    ];
    for group in groups {
        let Some((first, ..)) = group.first() else { continue };
        let start = Instant::now();
        let sums = bake::sum_bounces(&exchange.exact, &exchange.patches, *first, first.default_bounces())?;
        let summing = start.elapsed().as_secs_f64();
        let own = Judge::new(maker.patches, &|first| product_of_sums(&sums, first));
        for &(codec, order, name) in group {
            let start = Instant::now();
            let coded = bake::encode_sums(n, sums.clone(), codec, order)?;
            let seconds = summing + start.elapsed().as_secs_f64();
            let settings = Settings { order, ..Settings::of_codec(codec) };
            let bake = Arc::new(Bake::of_sums(exchange.clone(), settings, coded));
            let alone = own.error(&|first| wide(&bake.operator.product(first, GATHER_LANES as usize))).mean;
            let scored = (maker.found(&bake, Iteration::Chebyshev, 1)[0], 1);
            let with = |row: Row| Row { codec_alone: Some(alone), ..row };
            rows.push(with(maker.row(format!("{name}, buffer"), &bake, base, scored, seconds)));
            if order == codec.default_order() {
                rows.push(with(maker.row(format!("{name}, texel"), &bake, texel, scored, seconds)));
            }
            if codec != CodecName::DenseF16 && order == codec.default_order() {
                let sampled = Gathering { path: MatrixPath::Sampled, ..base };
                rows.push(with(maker.row(format!("{name}, sampled"), &bake, sampled, scored, seconds)));
            }
        }
    }
    Ok(())
}
