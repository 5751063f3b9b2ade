//! Small mathematics that no crate has.
pub mod cull;
pub mod icosphere;
pub mod random;
pub mod samples;
pub mod srgb;
