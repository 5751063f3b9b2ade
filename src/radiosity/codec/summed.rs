//! Bounces summed beforehand, in the form of one of the codecs of coloured operators: light comes to rest in one product.
//!
//! Position p of the stored matrix holds row `rows[p]`, position q column `columns[q]` ([`crate::radiosity::order`]). What a row comes to is irradiance;
//! in the thesis' form it is exitance, and divided by the row's reflectance.

use super::bc1::Bc1;
use super::bc4_chroma::Bc4Chroma;
use super::half::Half;
use super::thesis::Thesis;
use super::{Bytes, Coded};
use crate::radiosity::order::{Orders, gather, scatter};

/// A codec of coloured operators.
#[derive(Debug, Clone, PartialEq)]
pub enum Code {
    /// See [`Half`].
    Half(Half),
    /// See [`Thesis`].
    Thesis(Thesis),
    /// See [`Bc1`].
    Bc1(Bc1),
    /// See [`Bc4Chroma`].
    Bc4Chroma(Bc4Chroma),
}

impl Code {
    /// As what all of them can do.
    pub fn coded(&self) -> &dyn Coded {
        match self {
            Self::Half(of) => of,
            Self::Thesis(of) => of,
            Self::Bc1(of) => of,
            Self::Bc4Chroma(of) => of,
        }
    }
}

/// An operator that takes what patches send at first to irradiance after all its bounces.
#[derive(Debug, Clone, PartialEq)]
pub struct Summed {
    /// In its orders.
    pub code: Code,
    /// Of rows and columns.
    pub orders: Orders,
    /// What each row (of the matrix, not of what is stored) is multiplied by in the end; none: by nothing.
    pub scales: Option<Vec<[f32; 3]>>,
}

impl Summed {
    /// Rows and columns.
    pub fn count(&self) -> usize {
        self.orders.rows.len()
    }

    /// What it takes on a device.
    pub fn bytes(&self) -> Bytes {
        let bytes = self.code.coded().bytes();
        let scales = self.scales.as_ref().map_or(0, |scales| 12 * scales.len());
        Bytes { tables: bytes.tables + scales + 4 * (self.orders.rows.len() + self.orders.columns.len()), ..bytes }
    }

    /// Irradiance of all patches from their exitance, as `lanes` threads for four rows add it.
    pub fn product(&self, exitance: &[[f32; 3]], lanes: usize) -> Vec<[f32; 3]> {
        let rows = self.code.coded().product(&gather(exitance, &self.orders.columns), lanes);
        let mut irradiance = scatter(&rows, &self.orders.rows);
        if let Some(scales) = &self.scales {
            irradiance.iter_mut().zip(scales).for_each(|(e, scale)| (0..3).for_each(|c| e[c] *= scale[c]));
        }
        irradiance
    }

    /// Row i of the matrix, before it is scaled.
    pub fn row(&self, i: usize) -> Vec<[f32; 3]> {
        let place = self.orders.rows.iter().position(|row| *row as usize == i);
        place.map_or(Vec::new(), |place| scatter(&self.code.coded().decode_row(place), &self.orders.columns))
    }
}
