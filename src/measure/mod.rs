//! Results: pictures, times, metrics, files and reports. Knows nothing upstream.

pub mod color_map;
pub mod exposure;
pub mod file;
pub mod html;
pub mod memory;
pub mod metrics;
pub mod picture;
pub mod plot;
pub mod read;
pub mod times;
pub mod views;
