//! CPU twins and f64 oracles: what is right, against which every picture of the device is judged.
//!
//! [`render::Reference`] casts one ray through each pixel's centre and gives the surface there, [`shade::Shader`]
//! lights a surface. Everything is in view space and f64; the inputs (vertices, factors, texels) are the same as the
//! device's.

pub mod bvh;
pub mod cell_volume;
pub mod cluster_assign;
pub mod cluster_index;
pub mod cluster_keys;
pub mod depth_reduce;
pub mod light_pairs;
pub mod light_tree;
pub mod list_sort;
pub mod octahedral;
pub mod radix_sort;
pub mod ray;
pub mod render;
pub mod scan;
pub mod shade;
pub mod smooth;
pub mod surface;
pub mod texture;
pub mod tile_cull;
