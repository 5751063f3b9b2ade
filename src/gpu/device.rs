//! The logical device, its one queue, its allocator and names for its objects.

use std::ffi::CString;
use std::mem::ManuallyDrop;
use std::sync::Mutex;

use ash::{ext, khr, vk};
use gpu_allocator::AllocationSizes;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::features::{self, Facts};
use super::memory::Accounts;
use super::{Instance, Options, failed};
use crate::error::{Error, Result};

/// Everything that Vulkan objects are made with.
pub struct Device {
    /// Functions.
    pub raw: ash::Device,
    /// Graphics and compute.
    pub queue: vk::Queue,
    /// Its family.
    pub queue_family: u32,
    /// What was found out about the physical device.
    pub facts: Facts,
    /// Labels and names, where the loader has them.
    pub debug: Option<ext::debug_utils::Device>,
    /// Bytes by resource.
    pub accounts: Mutex<Accounts>,
    pub(super) allocator: ManuallyDrop<Mutex<Allocator>>,
    /// Dropped last.
    pub instance: Instance,
}

impl Device {
    /// Allocations and pipelines made so far: what a frame must not add to.
    pub fn objects_made(&self) -> u64 {
        self.accounts.lock().map(|accounts| accounts.made).unwrap_or_default()
    }

    /// Opens the device that `options` chooses.
    ///
    /// # Errors
    /// See [`Instance::create`] and [`features::choose`].
    pub fn create(options: &Options) -> Result<Self> {
        let instance = Instance::create(options)?;
        let facts = features::choose(&instance, options.driver.as_deref())?;
        let queue_family = facts.queue_family.unwrap_or(0);
        let priorities = [1.0];
        let queues =
            [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&priorities)];
        let mut f12 = vk::PhysicalDeviceVulkan12Features::default().timeline_semaphore(true).scalar_block_layout(true);
        let mut f13 = vk::PhysicalDeviceVulkan13Features::default().synchronization2(true).dynamic_rendering(true);
        // SAFETY: the handle comes from this instance.
        let offered = unsafe { instance.raw.enumerate_device_extension_properties(facts.physical) }.unwrap_or_default();
        let has = |name| offered.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        let mut extensions = Vec::new();
        if has(khr::portability_subset::NAME) {
            extensions.push(khr::portability_subset::NAME.as_ptr());
        }
        let core = vk::PhysicalDeviceFeatures::default()
            .full_draw_index_uint32(facts.full_draw_index)
            .depth_clamp(facts.depth_clamp)
            .fragment_stores_and_atomics(facts.fragment_stores)
            .texture_compression_bc(facts.block_compression);
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&core)
            .push_next(&mut f12)
            .push_next(&mut f13);
        // SAFETY: every pointer in `info` lives until the call returns; features were checked by `choose`.
        let raw = unsafe { instance.raw.create_device(facts.physical, &info, None) }
            .map_err(failed("opening the Vulkan device"))?;
        // SAFETY: one queue of that family was asked for above.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: facts.physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            // The smallest blocks there are: large resources have memory of their own, small ones share.
            allocation_sizes: AllocationSizes::new(4 << 20, 4 << 20),
        })
        .map_err(|e| {
            // SAFETY: nothing has been made with the device yet.
            unsafe { raw.destroy_device(None) };
            Error::new(format!("starting the memory allocator failed: {e}"))
        })?;
        let debug = instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        Ok(Self {
            raw,
            queue,
            queue_family,
            facts,
            debug,
            accounts: Mutex::default(),
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            instance,
        })
    }

    /// Gives an object the name that validation messages and captures show.
    pub fn name<T: vk::Handle>(&self, handle: T, name: &str) {
        let (Some(debug), Ok(text)) = (&self.debug, CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&text);
        // SAFETY: the handle is alive; a failure to name changes nothing.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: owners of children hold a reference to the device, so none is left; the allocator goes before the device.
        unsafe {
            let _ = self.raw.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.raw.destroy_device(None);
        }
    }
}
