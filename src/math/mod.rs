//! Small mathematics that no crate has.
pub mod random;
