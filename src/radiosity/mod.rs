//! Diffuse bounced light between patches: which patches a scene comes to, what share of the light that leaves one meets another, and what light each
//! has in the end (C. Goral et al., "Modeling the Interaction of Light Between Diffuse Surfaces", 1984).

pub mod bake;
pub mod codec;
pub mod exchange;
pub mod factors;
pub mod files;
pub mod gather;
pub mod judge;
pub mod kernel;
pub mod order;
pub mod pair;
pub mod patches;
pub mod places;
pub mod sight;
pub mod solve;
pub mod spectrum;
pub mod transfer;

pub use bake::{Bake, Settings};
pub use exchange::Exchange;
pub use factors::Factors;
pub use patches::{Patch, Patches};
pub use transfer::Transfer;
