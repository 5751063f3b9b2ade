//! What a device can do, as plain numbers.

use serde::Serialize;

use super::profile::Profile;

/// Limits that plans are checked against.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limits {
    /// `maxImageDimension2D`.
    pub max_image_dimension: u32,
    /// `maxBufferSize`.
    pub max_buffer_bytes: u64,
    /// `maxStorageBufferRange`.
    pub max_storage_bytes: u64,
    /// `maxUniformBufferRange`.
    pub max_uniform_bytes: u64,
    /// `maxTexelBufferElements`.
    pub max_texel_elements: u64,
    /// `maxDrawIndexedIndexValue`.
    pub max_index: u32,
    /// Loop iterations of one shader invocation that the driver carries out; it leaves its loops past them without a word.
    pub max_loop_iterations: u32,
    /// `subPixelPrecisionBits`.
    pub sub_pixel_bits: u32,
    /// `maxColorAttachments`.
    pub max_color_attachments: u32,
    /// `subgroupSize`: threads that run in step.
    pub subgroup_size: u32,
    /// `maxPerStageDescriptorStorageBuffers`.
    pub max_stage_storage_buffers: u32,
    /// RGBA32F colour attachments blend.
    pub float_blend: bool,
    /// Fragment shaders write storage buffers: `fragmentStoresAndAtomics`.
    pub fragment_stores: bool,
    /// Images of BC1 and BC4 blocks are sampled: `textureCompressionBC`.
    pub block_compression: bool,
    /// Bits of the numbers of samples a pixel that radiance and depth have, and G-buffers too.
    pub samples: [u32; 2],
    /// What the device takes for each step; `None`: not measured.
    pub profile: Option<Profile>,
}

impl Limits {
    /// What the specification guarantees ("Required Limits", Vulkan 1.3), with the 128 MiB storage binding of the baseline.
    pub const MINIMUM: Self = Self {
        max_image_dimension: 4096,
        max_buffer_bytes: 1 << 30,
        max_storage_bytes: 128 << 20,
        max_uniform_bytes: 16384,
        max_texel_elements: 65536,
        max_index: (1 << 24) - 1,
        max_loop_iterations: u32::MAX,
        sub_pixel_bits: 4,
        max_color_attachments: 4,
        max_stage_storage_buffers: 4,
        subgroup_size: 32,
        float_blend: false,
        fragment_stores: false,
        block_compression: false,
        samples: [1 | 4, 1],
        profile: None,
    };
}

impl Limits {
    /// For the CPU reference, which no device limits: a picture takes at most 4 GiB a layer.
    pub const UNLIMITED: Self = Self {
        max_image_dimension: 32768,
        max_buffer_bytes: 4 << 30,
        max_storage_bytes: 1 << 40,
        max_uniform_bytes: 0,
        max_texel_elements: 0,
        max_index: u32::MAX,
        max_loop_iterations: u32::MAX,
        sub_pixel_bits: 8,
        max_color_attachments: 0,
        max_stage_storage_buffers: 0,
        subgroup_size: 1,
        float_blend: false,
        fragment_stores: false,
        block_compression: false,
        samples: [1 | 2 | 4 | 8; 2],
        profile: None,
    };
}
