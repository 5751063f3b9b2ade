//! The matrix as words and images of a device, by codec and path.

use crate::error::{Error, Result};
use crate::plan::{Limits, MatrixPath};
use crate::radiosity::Bake;
use crate::radiosity::bake::Operator;
use crate::radiosity::codec::block::{self, Block, ZEROS, ZEROS_BC4, to_bytes};
use crate::radiosity::codec::skip::Stored;
use crate::radiosity::codec::sparse::Residuals;
use crate::radiosity::codec::{Code, Summed, ZeroBlock};
use crate::shared::{self, GatherPush, ProductPush};

/// Formats of an image that holds a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatrixFormat {
    /// 32-bit floats.
    Float,
    /// Blocks of BC1.
    Bc1,
    /// Blocks of BC4.
    Bc4,
}

/// An image that holds a matrix, a texel an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MatrixImage {
    /// Of texels or blocks.
    pub format: MatrixFormat,
    /// Columns and rows: whole blocks.
    pub side: u32,
    /// As a device stores them.
    pub bytes: Vec<u8>,
}

/// What a pass is told of where parts of the words begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Parts {
    /// Of `patch_gather`, which is called for each bounce.
    Gather(GatherPush),
    /// Of `patch_product`, which is called once.
    Product(ProductPush),
}

/// See the module.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Value of CODEC.
    pub codec: u32,
    /// Value of MATRIX_PATH.
    pub path: u32,
    /// All of it, or what the image does not hold; never empty.
    pub words: Vec<u32>,
    /// Where it is sampled.
    pub image: Option<MatrixImage>,
    /// Where its parts are.
    pub parts: Parts,
}

/// Words with parts one behind the other.
#[derive(Default)]
struct Words(Vec<u32>);

impl Words {
    fn add(&mut self, part: impl IntoIterator<Item = u32>) -> u32 {
        let at = self.0.len() as u32;
        self.0.extend(part);
        at
    }

    fn add_pairs(&mut self, part: &[u16]) -> u32 {
        self.add(part.chunks(2).map(|two| u32::from(two[0]) | u32::from(two.get(1).copied().unwrap_or(0)) << 16))
    }

    fn add_floats(&mut self, part: impl IntoIterator<Item = f32>) -> u32 {
        self.add(part.into_iter().map(f32::to_bits))
    }
}

impl Matrix {
    /// Of a bake.
    ///
    /// # Errors
    /// A path that the codec or the device does not have, or more than the device binds at once.
    pub fn new(bake: &Bake, path: MatrixPath, limits: &Limits) -> Result<Self> {
        let count = bake.patches.list.len();
        let refuse = |why: String| Err(Error::new(format!("--gi-path {}: {why}", path.name())));
        let sampled = path == MatrixPath::Sampled;
        if sampled && count > limits.max_image_dimension as usize {
            return refuse(format!("{count} patches pass this device's largest image, {}", limits.max_image_dimension));
        }
        let mut matrix = match &bake.operator {
            Operator::Dense(dense) => {
                let push = GatherPush { count: count as u32, ..GatherPush::default() };
                let bits = || dense.elements.iter().map(|x| x.to_bits());
                let image = sampled.then(|| MatrixImage {
                    format: MatrixFormat::Float,
                    side: count as u32,
                    bytes: bits().flat_map(u32::to_le_bytes).collect(),
                });
                let words = if sampled { vec![0] } else { bits().collect() };
                Self { codec: shared::CODEC_DENSE, path: 0, words, image, parts: Parts::Gather(push) }
            }
            Operator::ZeroBlock(_) if sampled => {
                return refuse("zero-block is no texture; buffer and texel read it".into());
            }
            Operator::ZeroBlock(of) => zero_block(of),
            Operator::Summed(summed) => product(summed, sampled),
        };
        matrix.path = match path {
            // On lavapipe quicker than a storage buffer by an eighth (docs/RADIOSITY.md), elsewhere not measured.
            MatrixPath::Auto if matrix.words.len() as u64 <= limits.max_texel_elements => shared::PATH_TEXEL,
            MatrixPath::Auto | MatrixPath::Buffer => shared::PATH_BUFFER,
            MatrixPath::Texel => shared::PATH_TEXEL,
            MatrixPath::Sampled => shared::PATH_SAMPLED,
        };
        if sampled && matrix.image.is_none() {
            return refuse(format!("{} is no texture; buffer and texel read it", bake.settings.codec.name()));
        }
        let blocks = matrix.image.as_ref().is_some_and(|image| image.format != MatrixFormat::Float);
        if blocks && !limits.block_compression {
            return refuse("this device does not sample images of BC1 or BC4 blocks".into());
        }
        if path == MatrixPath::Texel && matrix.words.len() as u64 > limits.max_texel_elements {
            let (words, most) = (matrix.words.len(), limits.max_texel_elements);
            return refuse(format!("the matrix has {words} words, this device's texel buffers have {most}"));
        }
        let bytes = (matrix.words.len() * 4) as u64;
        if bytes > limits.max_storage_bytes {
            return Err(Error::new(format!(
                "--gi radiosity: the matrix has {bytes} bytes, this device binds at most {} at once",
                limits.max_storage_bytes
            )));
        }
        Ok(matrix)
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        (self.words.len() * 4 + self.image.as_ref().map_or(0, |image| image.bytes.len())) as u64
    }
}

fn zero_block(of: &ZeroBlock) -> Matrix {
    let mut words = Words::default();
    let push = GatherPush {
        count: of.count as u32,
        tables_at: words.add_floats(of.tables.iter().flatten().copied()),
        offsets_at: words.add(of.offsets.iter().copied()),
        columns_at: words.add_pairs(&of.columns),
        blocks_at: words.add(of.blocks.iter().flat_map(|b| [*b as u32, (*b >> 32) as u32])),
        residual_offsets_at: words.add(of.residual_offsets.iter().copied()),
        residuals_at: words.add(of.residuals.iter().copied()),
        residual_scale: of.residual_scale,
        ..GatherPush::default()
    };
    Matrix { codec: shared::CODEC_ZERO_BLOCK, path: 0, words: words.0, image: None, parts: Parts::Gather(push) }
}

fn product(summed: &Summed, sampled: bool) -> Matrix {
    let n = summed.count();
    let mut words = Words::default();
    let mut push = ProductPush {
        count: n as u32,
        rows_at: words.add(summed.orders.rows.iter().copied()),
        columns_at: words.add(summed.orders.columns.iter().copied()),
        ..ProductPush::default()
    };
    if let Some(scales) = &summed.scales {
        push.scales_at = words.add_floats(scales.iter().flatten().copied());
    }
    let mut image = None;
    let mut put_blocks = |words: &mut Words, format, stored: Option<&Stored>, blocks: &[Block], zeros| {
        if sampled {
            let all = stored.map_or_else(|| blocks.to_vec(), |stored| stored.all(blocks, n, zeros));
            image = Some(MatrixImage { format, side: 4 * block::side(n) as u32, bytes: to_bytes(&all) });
            return 0;
        }
        words.add(blocks.iter().flatten().copied())
    };
    let put_stored = |words: &mut Words, push: &mut ProductPush, stored: &Stored| {
        push.mask_at = words.add(stored.mask.iter().copied());
        push.counts_at = words.add(stored.counts.iter().copied());
    };
    let put_residuals = |words: &mut Words, push: &mut ProductPush, of: &Residuals| {
        push.offsets_at = words.add(of.offsets.iter().copied());
        push.apart_at = words.add(of.elements.iter().flatten().copied());
        push.scale = of.scale;
    };
    let codec = match &summed.code {
        Code::Half(of) => {
            push.blocks_at = words.add(of.words.iter().copied());
            push.scale = of.scale;
            shared::CODEC_HALF
        }
        Code::Thesis(of) => {
            push.tables_at = words.add_floats(of.tables.iter().flatten().copied());
            push.blocks_at = put_blocks(&mut words, MatrixFormat::Bc1, None, &of.blocks, ZEROS);
            // Lists of channels lie one behind the other.
            let mut before = 0;
            let offsets: Vec<u32> = of
                .apart
                .iter()
                .flat_map(|values| {
                    let begin = before;
                    before += values.values.len() as u32;
                    values.offsets.iter().map(move |offset| begin + offset)
                })
                .collect();
            push.offsets_at = words.add(offsets);
            let columns: Vec<u16> = of.apart.iter().flat_map(|values| values.columns.iter().copied()).collect();
            push.apart_at = words.add_pairs(&columns);
            push.values_at = words.add_floats(of.apart.iter().flat_map(|values| values.values.iter().copied()));
            shared::CODEC_THESIS
        }
        Code::Bc1(of) => {
            push.tables_at = words.add_floats(of.tables.iter().flatten().copied());
            put_stored(&mut words, &mut push, &of.stored);
            push.blocks_at = put_blocks(&mut words, MatrixFormat::Bc1, Some(&of.stored), &of.blocks, ZEROS);
            put_residuals(&mut words, &mut push, &of.apart);
            shared::CODEC_BC1
        }
        Code::Bc4Chroma(of) => {
            let tables = [of.tables.luminance, of.tables.red, of.tables.blue];
            push.tables_at = words.add_floats(tables.iter().flatten().copied());
            put_stored(&mut words, &mut push, &of.stored);
            push.blocks_at = put_blocks(&mut words, MatrixFormat::Bc4, Some(&of.stored), &of.blocks, ZEROS_BC4);
            push.chroma_at = words.add_pairs(&of.chroma);
            put_residuals(&mut words, &mut push, &of.apart);
            shared::CODEC_BC4_CHROMA
        }
    };
    Matrix { codec, path: 0, words: words.0, image, parts: Parts::Product(push) }
}
