//! Small mathematics that no crate has.
pub mod random;
pub mod srgb;
