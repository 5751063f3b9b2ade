//! Buffers and images with their memory, freed on drop and counted by name.

use std::collections::BTreeMap;
use std::mem::ManuallyDrop;
use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::{Device, failed};
use crate::error::{Error, Result};

/// Live bytes by resource name, and the most there ever were.
#[derive(Debug, Clone, Default)]
pub struct Accounts {
    /// Name to live bytes.
    pub live: BTreeMap<String, u64>,
    /// Sum of `live`.
    pub total: u64,
    /// Largest `total` so far.
    pub peak: u64,
    /// Allocations and pipelines made so far.
    pub made: u64,
    /// `live` as it was when `total` was within 1 % of its peak.
    pub at_peak: BTreeMap<String, u64>,
    snapshot: u64,
}

impl Accounts {
    fn add(&mut self, name: &str, bytes: u64) {
        *self.live.entry(name.to_string()).or_default() += bytes;
        self.total += bytes;
        self.made += 1;
        self.peak = self.peak.max(self.total);
        // Not at every step: many small resources would be copied over and over.
        if self.total as f64 > self.snapshot as f64 * 1.01 {
            self.snapshot = self.total;
            self.at_peak.clone_from(&self.live);
        }
    }

    fn remove(&mut self, name: &str, bytes: u64) {
        if let Some(live) = self.live.get_mut(name) {
            *live = live.saturating_sub(bytes);
            if *live == 0 {
                self.live.remove(name);
            }
        }
        self.total = self.total.saturating_sub(bytes);
    }
}

/// From this size on a resource has an allocation of its own.
const DEDICATED_BYTES: u64 = 1 << 20;

fn allocate(
    device: &Device,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    scheme: AllocationScheme,
) -> Result<Allocation> {
    let linear = matches!(scheme, AllocationScheme::DedicatedBuffer(_));
    // Drivers may grant 4,096 allocations in all: only large resources get one of their own.
    let scheme = if requirements.size < DEDICATED_BYTES { AllocationScheme::GpuAllocatorManaged } else { scheme };
    let desc = AllocationCreateDesc { name, requirements, location, linear, allocation_scheme: scheme };
    let mut allocator = device.allocator.lock().map_err(|_| Error::new("the memory allocator is unusable"))?;
    let allocation = allocator.allocate(&desc).map_err(|e| {
        Error::new(format!("{} bytes of device memory for {name} could not be had: {e}", requirements.size))
    })?;
    if let Ok(mut accounts) = device.accounts.lock() {
        accounts.add(name, allocation.size());
    }
    Ok(allocation)
}

fn free(device: &Device, name: &str, allocation: Allocation) {
    if let Ok(mut accounts) = device.accounts.lock() {
        accounts.remove(name, allocation.size());
    }
    if let Ok(mut allocator) = device.allocator.lock() {
        let _ = allocator.free(allocation);
    }
}

/// A buffer and its memory.
pub struct Buffer {
    /// Handle.
    pub raw: vk::Buffer,
    /// Size asked for.
    pub bytes: u64,
    /// View for texel fetches, where made.
    pub texel_view: Option<vk::BufferView>,
    name: String,
    allocation: ManuallyDrop<Allocation>,
    device: Arc<Device>,
}

impl Buffer {
    /// Makes a buffer of at least 4 bytes.
    ///
    /// # Errors
    /// Out of memory, with the buffer's name and size.
    pub fn create(
        device: &Arc<Device>,
        name: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self> {
        let bytes = bytes.max(4);
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: plain creation; the handle is destroyed on drop or below.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.map_err(failed("creating a buffer"))?;
        // SAFETY: `raw` was made by this device.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        // SAFETY: the buffer is destroyed where its memory cannot be had; else bound once.
        let allocation = allocate(device, name, requirements, location, AllocationScheme::DedicatedBuffer(raw))
            .inspect_err(|_| unsafe {
                device.raw.destroy_buffer(raw, None);
            })?;
        let buffer = Self {
            raw,
            bytes,
            texel_view: None,
            name: name.into(),
            allocation: ManuallyDrop::new(allocation),
            device: device.clone(),
        };
        // SAFETY: memory and offset come from the allocator for these requirements.
        unsafe { device.raw.bind_buffer_memory(raw, buffer.allocation.memory(), buffer.allocation.offset()) }
            .map_err(failed("binding buffer memory"))?;
        device.name(raw, name);
        Ok(buffer)
    }

    /// Adds a view of the first `range` bytes, a multiple of the texel size of `format`.
    pub fn add_texel_view(&mut self, format: vk::Format, range: u64) -> Result<()> {
        let info = vk::BufferViewCreateInfo::default().buffer(self.raw).format(format).range(range);
        // SAFETY: the buffer is alive and has uniform texel usage.
        let view =
            unsafe { self.device.raw.create_buffer_view(&info, None) }.map_err(failed("creating a buffer view"))?;
        self.device.name(view, &self.name);
        self.texel_view = Some(view);
        Ok(())
    }

    /// Mapped bytes of a host-visible buffer.
    pub fn mapped(&self) -> Option<&[u8]> {
        self.allocation.mapped_slice().map(|s| &s[..self.bytes as usize])
    }

    /// Mapped bytes for writing.
    pub fn mapped_mut(&mut self) -> Option<&mut [u8]> {
        let bytes = self.bytes as usize;
        self.allocation.mapped_slice_mut().map(|s| &mut s[..bytes])
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: whoever drops a buffer has waited for the frames that use it.
        unsafe {
            if let Some(view) = self.texel_view {
                self.device.raw.destroy_buffer_view(view, None);
            }
            self.device.raw.destroy_buffer(self.raw, None);
            free(&self.device, &self.name, ManuallyDrop::take(&mut self.allocation));
        }
    }
}

/// An image, its memory and a view of all of it.
pub struct Image {
    /// Handle.
    pub raw: vk::Image,
    /// All levels.
    pub view: vk::ImageView,
    /// Format.
    pub format: vk::Format,
    /// Colour or depth.
    pub aspect: vk::ImageAspectFlags,
    /// Texels.
    pub extent: [u32; 2],
    /// Mip levels.
    pub levels: u32,
    name: String,
    allocation: ManuallyDrop<Allocation>,
    device: Arc<Device>,
}

/// What an image is made of.
#[derive(Debug, Clone, Copy)]
pub struct ImageDesc {
    /// Format.
    pub format: vk::Format,
    /// Texels.
    pub extent: [u32; 2],
    /// Mip levels.
    pub levels: u32,
    /// Samples a texel, a power of two.
    pub samples: u32,
    /// Every use.
    pub usage: vk::ImageUsageFlags,
}

/// Depth or colour, by format.
pub fn aspect_of(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D32_SFLOAT | vk::Format::X8_D24_UNORM_PACK32 | vk::Format::D16_UNORM => vk::ImageAspectFlags::DEPTH,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

impl Image {
    /// Makes a 2-D image with optimal tiling.
    ///
    /// # Errors
    /// Out of memory, with the image's name and size.
    pub fn create(device: &Arc<Device>, name: &str, desc: ImageDesc) -> Result<Self> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.extent[0], height: desc.extent[1], depth: 1 })
            .mip_levels(desc.levels)
            .array_layers(1)
            .samples(vk::SampleCountFlags::from_raw(desc.samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage);
        // SAFETY: plain creation; destroyed on drop or below.
        let raw = unsafe { device.raw.create_image(&info, None) }.map_err(failed("creating an image"))?;
        // SAFETY: `raw` was made by this device.
        let requirements = unsafe { device.raw.get_image_memory_requirements(raw) };
        let scheme = AllocationScheme::DedicatedImage(raw);
        // SAFETY: the image is destroyed where its memory cannot be had.
        let allocation = allocate(device, name, requirements, MemoryLocation::GpuOnly, scheme)
            .inspect_err(|_| unsafe { device.raw.destroy_image(raw, None) })?;
        let aspect = aspect_of(desc.format);
        let mut image = Self {
            raw,
            view: vk::ImageView::null(),
            format: desc.format,
            aspect,
            extent: desc.extent,
            levels: desc.levels,
            name: name.into(),
            allocation: ManuallyDrop::new(allocation),
            device: device.clone(),
        };
        // SAFETY: memory and offset come from the allocator for these requirements.
        unsafe { device.raw.bind_image_memory(raw, image.allocation.memory(), image.allocation.offset()) }
            .map_err(failed("binding image memory"))?;
        let range = vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(desc.levels).layer_count(1);
        let view = vk::ImageViewCreateInfo::default()
            .image(raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(desc.format)
            .subresource_range(range);
        // SAFETY: the image is bound and alive.
        image.view = unsafe { device.raw.create_image_view(&view, None) }.map_err(failed("creating an image view"))?;
        device.name(raw, name);
        device.name(image.view, name);
        Ok(image)
    }

    /// All levels of the one layer.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange::default().aspect_mask(self.aspect).level_count(self.levels).layer_count(1)
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: whoever drops an image has waited for the frames that use it; a null view is ignored.
        unsafe {
            self.device.raw.destroy_image_view(self.view, None);
            self.device.raw.destroy_image(self.raw, None);
            free(&self.device, &self.name, ManuallyDrop::take(&mut self.allocation));
        }
    }
}
