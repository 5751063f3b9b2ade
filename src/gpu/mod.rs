//! Thin owned Vulkan: instance, device, memory, pipelines, descriptors. Knows neither scenes nor plans.
#![allow(unsafe_code)]

pub mod descriptors;
pub mod device;
pub mod features;
pub mod instance;
pub mod memory;
pub mod pipeline;
pub mod pipeline_cache;
pub mod realize;
pub mod specialize;

pub use device::Device;
pub use instance::{Instance, Options};

use ash::vk;

use crate::error::Error;

/// A Vulkan error as a sentence.
pub fn failed(what: &str) -> impl Fn(vk::Result) -> Error + '_ {
    move |result| Error::new(format!("{what} failed: {result:?}"))
}
