//! The arrays of each codec, and the way back.

use std::path::Path;

use super::ktx2::{self, Format};
use super::npy::{self, HalfBits, Number};
use crate::error::{Error, Result};
use crate::radiosity::bake::{CodecName, Operator};
use crate::radiosity::codec::bc1::Bc1;
use crate::radiosity::codec::bc4_chroma::{Bc4Chroma, Tables};
use crate::radiosity::codec::block::{Block, ZEROS, ZEROS_BC4};
use crate::radiosity::codec::half::Half;
use crate::radiosity::codec::skip::Stored;
use crate::radiosity::codec::sparse::{Residuals, Values};
use crate::radiosity::codec::thesis::Thesis;
use crate::radiosity::codec::{BLOCK, Code, Dense, Summed, ZeroBlock};
use crate::radiosity::order::Orders;

/// What 16-bit floats are multiplied by.
pub fn scale(operator: &Operator) -> Option<f32> {
    match operator {
        Operator::Dense(_) => None,
        Operator::ZeroBlock(of) => Some(of.residual_scale),
        Operator::Summed(summed) => match &summed.code {
            Code::Half(of) => Some(of.scale),
            Code::Thesis(_) => None,
            Code::Bc1(of) => Some(of.apart.scale),
            Code::Bc4Chroma(of) => Some(of.apart.scale),
        },
    }
}

/// Every array with its name.
pub fn arrays(operator: &Operator) -> Vec<(&'static str, Vec<u8>)> {
    match operator {
        Operator::Dense(dense) => vec![("matrix.npy", npy::write(&[dense.count; 2], &dense.elements))],
        Operator::ZeroBlock(of) => vec![
            ("block_ends.npy", npy::write(&[of.tables[0].len()], &of.tables[0])),
            ("block_steps.npy", npy::write(&[of.tables[1].len()], &of.tables[1])),
            ("block_offsets.npy", npy::write(&[of.offsets.len()], &of.offsets)),
            ("block_columns.npy", npy::write(&[of.columns.len()], &of.columns)),
            ("blocks.npy", npy::write(&[of.blocks.len()], &of.blocks)),
            ("residual_offsets.npy", npy::write(&[of.residual_offsets.len()], &of.residual_offsets)),
            ("residuals.npy", npy::write(&[of.residuals.len()], &of.residuals)),
        ],
        Operator::Summed(summed) => of_summed(summed),
    }
}

fn of_summed(summed: &Summed) -> Vec<(&'static str, Vec<u8>)> {
    let n = summed.count();
    let mut arrays = vec![
        ("order_rows.npy", npy::write(&[n], &summed.orders.rows)),
        ("order_columns.npy", npy::write(&[n], &summed.orders.columns)),
    ];
    if let Some(scales) = &summed.scales {
        arrays.push(("row_scales.npy", npy::write(&[n, 3], scales.as_flattened())));
    }
    let residuals = |of: &Residuals| {
        [
            ("residual_offsets.npy", npy::write(&[n + 1], &of.offsets)),
            ("residuals.npy", npy::write(&[of.elements.len(), 2], of.elements.as_flattened())),
        ]
    };
    match &summed.code {
        Code::Half(of) => {
            let halves: Vec<HalfBits> = of.halves().map(HalfBits).collect();
            arrays.push(("matrix.npy", npy::write(&[3, n, n], &halves)));
        }
        Code::Thesis(of) => {
            let counts: Vec<u32> = of.apart.iter().map(|values| values.values.len() as u32).collect();
            let offsets: Vec<u32> = of.apart.iter().flat_map(|values| values.offsets.iter().copied()).collect();
            let columns: Vec<u16> = of.apart.iter().flat_map(|values| values.columns.iter().copied()).collect();
            let values: Vec<f32> = of.apart.iter().flat_map(|values| values.values.iter().copied()).collect();
            arrays.extend([
                ("matrix.ktx2", ktx2::write(Format::Bc1, n, &of.blocks)),
                ("tables.npy", npy::write(&[3, 256], of.tables.as_flattened())),
                ("apart_counts.npy", npy::write(&[3], &counts)),
                ("apart_offsets.npy", npy::write(&[3, n + 1], &offsets)),
                ("apart_columns.npy", npy::write(&[columns.len()], &columns)),
                ("apart_values.npy", npy::write(&[values.len()], &values)),
            ]);
        }
        Code::Bc1(of) => {
            let blocks: Vec<Block> = of.stored.all(&of.blocks, n, ZEROS);
            arrays.push(("matrix.ktx2", ktx2::write(Format::Bc1, n, &blocks)));
            arrays.push(("tables.npy", npy::write(&[3, 256], of.tables.as_flattened())));
            arrays.extend(residuals(&of.apart));
        }
        Code::Bc4Chroma(of) => {
            let blocks: Vec<Block> = of.stored.all(&of.blocks, n, ZEROS_BC4);
            let tables = [of.tables.luminance, of.tables.red, of.tables.blue];
            arrays.push(("matrix.ktx2", ktx2::write(Format::Bc4, n, &blocks)));
            arrays.push(("chroma.npy", npy::write(&[of.chroma.len()], &of.chroma)));
            arrays.push(("tables.npy", npy::write(&[3, 256], tables.as_flattened())));
            arrays.extend(residuals(&of.apart));
        }
    }
    arrays
}

/// Where arrays are read from: bytes of a file whose checksum is right.
pub struct Arrays<'a> {
    /// The bake's folder.
    pub folder: &'a Path,
    /// By name.
    pub read: &'a dyn Fn(&str) -> Result<Vec<u8>>,
}

impl Arrays<'_> {
    fn within(&self, name: &str, why: &str) -> Error {
        Error::new(format!("{}: {why}", self.folder.join(name).display()))
    }

    fn get<T: Number>(&self, name: &str, shape: Option<&[usize]>) -> Result<Vec<T>> {
        npy::read(&(self.read)(name)?, shape).map_err(|e| self.within(name, &e))
    }

    fn blocks(&self, format: Format, n: usize) -> Result<Vec<Block>> {
        ktx2::read(format, n, &(self.read)("matrix.ktx2")?).map_err(|e| self.within("matrix.ktx2", &e))
    }

    /// Three or more tables of 256.
    fn tables(&self) -> Result<[[f32; 256]; 3]> {
        let all: Vec<f32> = self.get("tables.npy", Some(&[3, 256]))?;
        Ok(std::array::from_fn(|c| std::array::from_fn(|k| all[256 * c + k])))
    }

    fn order(&self, name: &str, n: usize) -> Result<Vec<u32>> {
        let order: Vec<u32> = self.get(name, Some(&[n]))?;
        let mut seen = vec![false; n];
        for (at, index) in order.iter().enumerate() {
            match seen.get_mut(*index as usize) {
                Some(seen) if !*seen => *seen = true,
                _ => return Err(self.within(name, &format!("[{at}] is {index}: no order of {n}"))),
            }
        }
        Ok(order)
    }

    /// Offsets that grow from 0 to `end`.
    fn grow(&self, name: &str, offsets: &[u32], end: usize) -> Result<()> {
        if let Some(at) = offsets.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(self.within(name, &format!("[{at}] passes the one behind it")));
        }
        if offsets.first() != Some(&0) || offsets.last().copied() != Some(end as u32) {
            return Err(self.within(name, &format!("does not go from 0 to {end}")));
        }
        Ok(())
    }

    fn residuals(&self, n: usize, scale: f32) -> Result<Residuals> {
        let offsets: Vec<u32> = self.get("residual_offsets.npy", Some(&[n + 1]))?;
        let count = offsets.last().copied().unwrap_or(0) as usize;
        let flat: Vec<u32> = self.get("residuals.npy", Some(&[count, 2]))?;
        let elements: Vec<[u32; 2]> = flat.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        self.grow("residual_offsets.npy", &offsets, count)?;
        match elements.iter().position(|element| (element[0] & 0xffff) as usize >= n) {
            Some(at) => Err(self.within("residuals.npy", &format!("[{at}] has no column of {n}"))),
            None => Ok(Residuals { offsets, elements, scale }),
        }
    }
}

/// The operator of a codec for `n` patches.
///
/// # Errors
/// A file that is missing or damaged, or whose numbers point out of what they belong to.
pub fn load(arrays: &Arrays, codec: CodecName, n: usize, scale: f32) -> Result<Operator> {
    match codec {
        CodecName::Classical => {
            return Ok(Operator::Dense(Dense { count: n, elements: arrays.get("matrix.npy", Some(&[n, n]))? }));
        }
        CodecName::ZeroBlock => return zero_block(arrays, n, scale).map(Operator::ZeroBlock),
        _ => {}
    }
    let code = match codec {
        CodecName::DenseF16 => {
            let halves: Vec<HalfBits> = arrays.get("matrix.npy", Some(&[3, n, n]))?;
            Code::Half(Half::of_halves(n, &halves.iter().map(|half| half.0).collect::<Vec<_>>(), scale))
        }
        CodecName::Thesis | CodecName::ThesisFilled => Code::Thesis(thesis(arrays, n)?),
        CodecName::Bc4Chroma => {
            let (stored, blocks) = Stored::of_all(&arrays.blocks(Format::Bc4, n)?, ZEROS_BC4);
            let [luminance, red, blue] = arrays.tables()?;
            let chroma = arrays.get("chroma.npy", Some(&[blocks.len()]))?;
            let tables = Tables { luminance, red, blue };
            Code::Bc4Chroma(Bc4Chroma { n, stored, blocks, chroma, tables, apart: arrays.residuals(n, scale)? })
        }
        _ => {
            let (stored, blocks) = Stored::of_all(&arrays.blocks(Format::Bc1, n)?, ZEROS);
            Code::Bc1(Bc1 { n, stored, blocks, tables: arrays.tables()?, apart: arrays.residuals(n, scale)? })
        }
    };
    let orders = Orders { rows: arrays.order("order_rows.npy", n)?, columns: arrays.order("order_columns.npy", n)? };
    let scales = match codec {
        CodecName::Thesis | CodecName::ThesisFilled => {
            let flat: Vec<f32> = arrays.get("row_scales.npy", Some(&[n, 3]))?;
            Some(flat.chunks_exact(3).map(|s| [s[0], s[1], s[2]]).collect())
        }
        _ => None,
    };
    Ok(Operator::Summed(Box::new(Summed { code, orders, scales })))
}

fn thesis(arrays: &Arrays, n: usize) -> Result<Thesis> {
    let counts: Vec<u32> = arrays.get("apart_counts.npy", Some(&[3]))?;
    let total = counts.iter().map(|count| *count as usize).sum();
    let offsets: Vec<u32> = arrays.get("apart_offsets.npy", Some(&[3, n + 1]))?;
    let columns: Vec<u16> = arrays.get("apart_columns.npy", Some(&[total]))?;
    let values: Vec<f32> = arrays.get("apart_values.npy", Some(&[total]))?;
    if let Some(at) = columns.iter().position(|column| usize::from(*column) >= n) {
        return Err(arrays.within("apart_columns.npy", &format!("[{at}] is {}, of {n} there are", columns[at])));
    }
    let mut apart: [Values; 3] = Default::default();
    let mut begin = 0;
    for (c, values_of) in apart.iter_mut().enumerate() {
        let count = counts[c] as usize;
        let offsets = offsets[c * (n + 1)..(c + 1) * (n + 1)].to_vec();
        arrays.grow("apart_offsets.npy", &offsets, count)?;
        let range = begin..begin + count;
        *values_of = Values { offsets, columns: columns[range.clone()].to_vec(), values: values[range].to_vec() };
        begin += count;
    }
    Ok(Thesis { n, blocks: arrays.blocks(Format::Bc1, n)?, tables: arrays.tables()?, apart })
}

fn zero_block(arrays: &Arrays, n: usize, residual_scale: f32) -> Result<ZeroBlock> {
    let side = n.div_ceil(BLOCK);
    let found = ZeroBlock {
        count: n,
        side,
        tables: [arrays.get("block_ends.npy", Some(&[256]))?, arrays.get("block_steps.npy", Some(&[256]))?],
        offsets: arrays.get("block_offsets.npy", Some(&[side + 1]))?,
        columns: arrays.get("block_columns.npy", None)?,
        blocks: arrays.get("blocks.npy", None)?,
        residual_offsets: arrays.get("residual_offsets.npy", Some(&[n + 1]))?,
        residuals: arrays.get("residuals.npy", None)?,
        residual_scale,
    };
    found.check().map_err(|e| Error::new(format!("{}: {e}", arrays.folder.display())))?;
    Ok(found)
}
