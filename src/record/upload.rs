//! Fills static resources through a staging buffer, once, before the first frame.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;

use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::gpu::memory::{Buffer, Image};
use crate::submit::Queue;

/// Bytes staged at a time: large enough to hide a submission, small enough not to be seen in the peak.
const STAGING_BYTES: u64 = 8 << 20;

/// Small uploads share one buffer.
const SMALLEST_STAGING_BYTES: u64 = 64 << 10;

/// Copies host bytes to device resources; every call ends with the data in place.
pub struct Uploader {
    device: Arc<Device>,
    staging: Option<Buffer>,
}

impl Uploader {
    /// Nothing is allocated before the first upload.
    pub fn new(device: &Arc<Device>) -> Self {
        Self { device: device.clone(), staging: None }
    }

    /// With room for uploads of so many bytes from the start: those allocate nothing.
    ///
    /// # Errors
    /// Out of memory.
    pub fn with_room(device: &Arc<Device>, bytes: u64) -> Result<Self> {
        let mut uploader = Self::new(device);
        uploader.staging(bytes.min(STAGING_BYTES))?;
        Ok(uploader)
    }

    fn staging(&mut self, bytes: u64) -> Result<&mut Buffer> {
        if self.staging.as_ref().is_none_or(|s| s.bytes < bytes) {
            self.staging = None;
            let usage = vk::BufferUsageFlags::TRANSFER_SRC;
            let size = bytes.max(SMALLEST_STAGING_BYTES);
            let buffer = Buffer::create(&self.device, "staging", size, usage, MemoryLocation::CpuToGpu)?;
            self.staging = Some(buffer);
        }
        self.staging.as_mut().ok_or_else(|| Error::new("no staging buffer"))
    }

    fn fill(&mut self, bytes: &[u8]) -> Result<vk::Buffer> {
        let staging = self.staging(bytes.len() as u64)?;
        let raw = staging.raw;
        let mapped = staging.mapped_mut().ok_or_else(|| Error::new("the staging buffer is not mapped"))?;
        mapped[..bytes.len()].copy_from_slice(bytes);
        Ok(raw)
    }

    /// Fills a buffer from its start.
    pub fn buffer(&mut self, queue: &mut Queue, target: &Buffer, bytes: &[u8]) -> Result<()> {
        let device = self.device.clone();
        for (index, chunk) in bytes.chunks(STAGING_BYTES as usize).enumerate() {
            let source = self.fill(chunk)?;
            let offset = index as u64 * STAGING_BYTES;
            let region = [vk::BufferCopy::default().dst_offset(offset).size(chunk.len() as u64)];
            queue.once(|commands| {
                // SAFETY: the region lies in both buffers; the queue is waited for before staging is written again.
                unsafe { device.raw.cmd_copy_buffer(commands, source, target.raw, &region) };
                make_visible(&device, commands, target);
            })?;
        }
        Ok(())
    }

    /// Fills every level of an image and leaves it in `SHADER_READ_ONLY_OPTIMAL`.
    pub fn image(&mut self, queue: &mut Queue, target: &Image, levels: &[(u32, u32, &[u8])]) -> Result<()> {
        let device = self.device.clone();
        let mut first = true;
        let last_level = levels.len().saturating_sub(1);
        for (level, &(width, height, bytes)) in levels.iter().enumerate() {
            // Rows of blocks where texels are compressed.
            let unit = rows_of_block(target.format);
            let row_bytes = (bytes.len() / height.div_ceil(unit).max(1) as usize).max(1);
            let rows = unit * (STAGING_BYTES as usize / row_bytes).max(1) as u32;
            for top in (0..height).step_by(rows as usize) {
                let count = rows.min(height - top);
                let from = (top / unit) as usize * row_bytes;
                let source = self.fill(&bytes[from..from + count.div_ceil(unit) as usize * row_bytes])?;
                let layers = vk::ImageSubresourceLayers::default()
                    .aspect_mask(target.aspect)
                    .mip_level(level as u32)
                    .layer_count(1);
                let region = [vk::BufferImageCopy::default()
                    .image_subresource(layers)
                    .image_offset(vk::Offset3D { x: 0, y: top as i32, z: 0 })
                    .image_extent(vk::Extent3D { width, height: count, depth: 1 })];
                let (enter, leave) = (first, level == last_level && top + count == height);
                first = false;
                let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
                queue.once(|commands| {
                    if enter {
                        transition(&device, commands, target, Step::Enter);
                    }
                    // SAFETY: the region lies in the image; staging is not written before the wait.
                    unsafe { device.raw.cmd_copy_buffer_to_image(commands, source, target.raw, layout, &region) };
                    if leave {
                        transition(&device, commands, target, Step::Leave);
                    }
                })?;
            }
        }
        Ok(())
    }
}

/// Rows of texels that lie in one row of what is copied.
fn rows_of_block(format: vk::Format) -> u32 {
    match format {
        vk::Format::BC1_RGB_UNORM_BLOCK | vk::Format::BC4_UNORM_BLOCK => 4,
        _ => 1,
    }
}

/// A copied buffer becomes visible to every kind of read that static buffers are declared with.
fn make_visible(device: &Device, commands: vk::CommandBuffer, buffer: &Buffer) {
    use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
    let readers =
        S::VERTEX_ATTRIBUTE_INPUT | S::INDEX_INPUT | S::VERTEX_SHADER | S::FRAGMENT_SHADER | S::COMPUTE_SHADER;
    let reads =
        A::VERTEX_ATTRIBUTE_READ | A::INDEX_READ | A::UNIFORM_READ | A::SHADER_STORAGE_READ | A::SHADER_SAMPLED_READ;
    let barrier = [vk::BufferMemoryBarrier2::default()
        .src_stage_mask(S::COPY)
        .src_access_mask(A::TRANSFER_WRITE)
        .dst_stage_mask(readers)
        .dst_access_mask(reads)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .buffer(buffer.raw)
        .size(vk::WHOLE_SIZE)];
    let info = vk::DependencyInfo::default().buffer_memory_barriers(&barrier);
    // SAFETY: the command buffer is recording, the buffer is alive.
    unsafe { device.raw.cmd_pipeline_barrier2(commands, &info) };
}

impl Drop for Uploader {
    fn drop(&mut self) {
        // SAFETY: the device is alive. A wait that ran out of time leaves a copy that still reads the staging buffer.
        let _ = unsafe { self.device.raw.device_wait_idle() };
    }
}

enum Step {
    Enter,
    Leave,
}

/// Layout changes round the copies; the submission is waited for, so nothing else needs to be ordered.
fn transition(device: &Device, commands: vk::CommandBuffer, image: &Image, step: Step) {
    use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
    let (src, dst, layouts) = match step {
        Step::Enter => ((S::NONE, A::NONE), (S::COPY, A::TRANSFER_WRITE), (L::UNDEFINED, L::TRANSFER_DST_OPTIMAL)),
        Step::Leave => (
            (S::COPY, A::TRANSFER_WRITE),
            (S::FRAGMENT_SHADER | S::COMPUTE_SHADER, A::SHADER_SAMPLED_READ),
            (L::TRANSFER_DST_OPTIMAL, L::SHADER_READ_ONLY_OPTIMAL),
        ),
    };
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(src.0)
        .src_access_mask(src.1)
        .dst_stage_mask(dst.0)
        .dst_access_mask(dst.1)
        .old_layout(layouts.0)
        .new_layout(layouts.1)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw)
        .subresource_range(image.range())];
    let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
    // SAFETY: the command buffer is recording, the image is alive.
    unsafe { device.raw.cmd_pipeline_barrier2(commands, &info) };
}
