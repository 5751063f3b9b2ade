//! Rows of the table of hard cases that need a device: each makes its case happen in a small scene and lets f64 judge.

pub mod cones;
pub mod culling;
pub(super) mod fixtures;
pub mod nodes;
pub mod parts;
pub mod ranges;
pub mod sums;
pub mod surfaces;
pub mod tiles;
pub mod twins;
pub mod views;
