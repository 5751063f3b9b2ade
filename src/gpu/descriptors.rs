//! A descriptor pool sized exactly for a graph, samplers made once a distinct state, and the writing of sets.

use std::collections::HashMap;
use std::sync::Arc;

use ash::vk;

use super::{Device, failed};
use crate::error::Result;
use crate::graph::SamplerState;

/// What a descriptor points at.
#[derive(Debug, Clone, Copy)]
pub enum Target {
    /// Whole buffer, or its first `range` bytes.
    Buffer {
        /// Handle.
        raw: vk::Buffer,
        /// Bytes.
        range: u64,
    },
    /// Texel view.
    Texel(vk::BufferView),
    /// Image in a layout, with a sampler where it is sampled.
    Image {
        /// All levels.
        view: vk::ImageView,
        /// Layout at the time of use.
        layout: vk::ImageLayout,
        /// Null for storage images.
        sampler: vk::Sampler,
    },
}

/// One descriptor to write.
#[derive(Debug, Clone, Copy)]
pub struct Write {
    /// Binding number.
    pub binding: u32,
    /// Type in the layout.
    pub kind: vk::DescriptorType,
    /// Resource.
    pub target: Target,
}

/// The pool and the samplers of a graph.
pub struct Descriptors {
    pool: vk::DescriptorPool,
    samplers: HashMap<SamplerState, vk::Sampler>,
    device: Arc<Device>,
}

impl Descriptors {
    /// A pool for `sets` sets with these counts by type.
    pub fn create(device: &Arc<Device>, sets: u32, counts: &HashMap<vk::DescriptorType, u32>) -> Result<Self> {
        let sizes: Vec<_> =
            counts.iter().map(|(&ty, &n)| vk::DescriptorPoolSize::default().ty(ty).descriptor_count(n)).collect();
        let mut pool = vk::DescriptorPool::null();
        if sets > 0 {
            let info = vk::DescriptorPoolCreateInfo::default().max_sets(sets).pool_sizes(&sizes);
            // SAFETY: plain creation.
            pool = unsafe { device.raw.create_descriptor_pool(&info, None) }
                .map_err(failed("creating a descriptor pool"))?;
        }
        Ok(Self { pool, samplers: HashMap::new(), device: device.clone() })
    }

    /// The sampler of a state.
    pub fn sampler(&mut self, state: SamplerState) -> Result<vk::Sampler> {
        if let Some(&sampler) = self.samplers.get(&state) {
            return Ok(sampler);
        }
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(state.mag)
            .min_filter(state.min)
            .mipmap_mode(state.mip)
            .address_mode_u(state.wrap[0])
            .address_mode_v(state.wrap[1])
            .address_mode_w(vk::SamplerAddressMode::REPEAT)
            // 0.25 keeps level 0 and still tells minification from magnification (VkSamplerCreateInfo, note on filtering).
            .max_lod(if state.mipmapped { vk::LOD_CLAMP_NONE } else { 0.25 });
        // SAFETY: plain creation.
        let sampler = unsafe { self.device.raw.create_sampler(&info, None) }.map_err(failed("creating a sampler"))?;
        self.samplers.insert(state, sampler);
        Ok(sampler)
    }

    /// Allocates a set and writes it.
    pub fn set(&self, layout: vk::DescriptorSetLayout, writes: &[Write]) -> Result<vk::DescriptorSet> {
        let layouts = [layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&layouts);
        // SAFETY: the pool was sized for every set of the graph.
        let set = unsafe { self.device.raw.allocate_descriptor_sets(&info) }
            .map_err(failed("allocating a descriptor set"))?[0];
        for write in writes {
            let base = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(write.binding)
                .descriptor_type(write.kind)
                .descriptor_count(1);
            let (buffers, texels, images);
            let base = match write.target {
                Target::Buffer { raw, range } => {
                    buffers = [vk::DescriptorBufferInfo::default().buffer(raw).range(range)];
                    base.buffer_info(&buffers)
                }
                Target::Texel(view) => {
                    texels = [view];
                    base.texel_buffer_view(&texels)
                }
                Target::Image { view, layout, sampler } => {
                    images =
                        [vk::DescriptorImageInfo::default().image_view(view).image_layout(layout).sampler(sampler)];
                    base.image_info(&images)
                }
            };
            // SAFETY: the set is not in use yet; everything it names outlives the graph's use.
            unsafe { self.device.raw.update_descriptor_sets(&[base], &[]) };
        }
        Ok(set)
    }
}

impl Drop for Descriptors {
    fn drop(&mut self) {
        // SAFETY: the graph's frames have been waited for.
        unsafe {
            self.device.raw.destroy_descriptor_pool(self.pool, None);
            for &sampler in self.samplers.values() {
                self.device.raw.destroy_sampler(sampler, None);
            }
        }
    }
}
