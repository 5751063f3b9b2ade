//! What physical devices offer: the baseline that is required and the features that have a way out.

use ash::vk;

use super::Instance;
use super::instance::NO_DRIVER;
use crate::error::{Error, Result};

/// A feature beyond the baseline, and what happens without it.
#[derive(Debug, Clone, PartialEq)]
pub struct Optional {
    /// Short name.
    pub name: &'static str,
    /// There or not.
    pub there: bool,
    /// What the renderer does without it.
    pub without: &'static str,
}

/// One physical device, described.
#[derive(Debug, Clone)]
pub struct Facts {
    /// Handle.
    pub physical: vk::PhysicalDevice,
    /// `deviceName`.
    pub name: String,
    /// `driverName` and `driverInfo`.
    pub driver: String,
    /// Vulkan version, major.minor.patch.
    pub api: (u32, u32, u32),
    /// Discrete, integrated, virtual, cpu, other.
    pub kind: &'static str,
    /// Missing baseline features; empty for a usable device.
    pub missing: Vec<&'static str>,
    /// Features with a way out.
    pub optional: Vec<Optional>,
    /// Core limits.
    pub limits: vk::PhysicalDeviceLimits,
    /// Lanes of a subgroup.
    pub subgroup_size: u32,
    /// Identifies driver and device for caches.
    pub cache_uuid: [u8; 16],
    /// `driverVersion`.
    pub driver_version: u32,
    /// Bits of valid timestamps on the graphics queue; 0: none.
    pub timestamp_bits: u32,
    /// Queue family with graphics and compute.
    pub queue_family: Option<u32>,
    /// `maxBufferSize`.
    pub max_buffer_bytes: u64,
    /// Iterations after which the driver silently leaves a shader's loops, all of them together; `None`: it does not.
    pub loop_iterations: Option<u32>,
    /// Indices pass 2^24 - 1; asked for where offered.
    pub full_draw_index: bool,
    /// Depth is clamped instead of clipped where a pipeline asks for it; asked for where offered.
    pub depth_clamp: bool,
    /// RGBA32F colour attachments blend.
    pub float_blend: bool,
    /// Fragment shaders write storage buffers; asked for where offered.
    pub fragment_stores: bool,
    /// Images of BC1 and BC4 blocks are sampled by compute passes; asked for where offered.
    pub block_compression: bool,
    /// Bits of the numbers of samples that radiance and depth have, and G-buffers too.
    pub samples: [u32; 2],
}

impl Facts {
    /// Device and driver in one line.
    pub fn line(&self) -> String {
        if self.driver.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.driver) }
    }
}

/// Every device the loader shows, in its order.
pub fn enumerate(instance: &Instance) -> Result<Vec<Facts>> {
    // SAFETY: the instance is alive.
    let devices = unsafe { instance.raw.enumerate_physical_devices() }.map_err(super::failed("listing devices"))?;
    if devices.is_empty() {
        return Err(Error::new(NO_DRIVER));
    }
    Ok(devices.into_iter().map(|physical| describe(instance, physical)).collect())
}

/// Chooses by name, else the most capable kind.
///
/// # Errors
/// No device of that name, or the one chosen is below the baseline: the sentence names what is missing.
pub fn choose(instance: &Instance, driver: Option<&str>) -> Result<Facts> {
    let all = enumerate(instance)?;
    let wanted = driver.map(str::to_lowercase);
    let matches =
        |f: &Facts| wanted.as_ref().is_none_or(|w| format!("{} {}", f.name, f.driver).to_lowercase().contains(w));
    let rank = |f: &Facts| {
        let kind = ["discrete", "integrated", "virtual", "cpu"].iter().position(|k| *k == f.kind).unwrap_or(4);
        (!f.missing.is_empty(), kind)
    };
    let names: Vec<_> = all.iter().map(|f| f.name.clone()).collect();
    let chosen = all.into_iter().filter(matches).min_by_key(rank).ok_or_else(|| {
        Error::new(format!("no device matches --driver {}; found: {}", driver.unwrap_or(""), names.join(", ")))
    })?;
    if !chosen.missing.is_empty() {
        return Err(Error::new(format!(
            "{} is below the baseline: it lacks {}",
            chosen.line(),
            chosen.missing.join(", ")
        )));
    }
    Ok(chosen)
}

fn text(bytes: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = bytes.iter().take_while(|&&c| c != 0).map(|&c| c as u8).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn describe(instance: &Instance, physical: vk::PhysicalDevice) -> Facts {
    // SAFETY: the handle comes from this instance.
    let core = unsafe { instance.raw.get_physical_device_properties(physical) };
    let api = core.api_version;
    let version = (vk::api_version_major(api), vk::api_version_minor(api), vk::api_version_patch(api));
    let mut facts = Facts {
        physical,
        name: text(&core.device_name),
        driver: String::new(),
        api: version,
        kind: match core.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
            vk::PhysicalDeviceType::CPU => "cpu",
            _ => "other",
        },
        missing: Vec::new(),
        optional: Vec::new(),
        limits: core.limits,
        subgroup_size: 0,
        cache_uuid: core.pipeline_cache_uuid,
        driver_version: core.driver_version,
        timestamp_bits: 0,
        queue_family: None,
        max_buffer_bytes: 0,
        full_draw_index: false,
        depth_clamp: false,
        float_blend: false,
        fragment_stores: false,
        block_compression: false,
        samples: [1; 2],
        loop_iterations: None,
    };
    // SAFETY: as above.
    let families = unsafe { instance.raw.get_physical_device_queue_family_properties(physical) };
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let family = families.iter().position(|f| f.queue_flags.contains(both));
    facts.queue_family = family.map(|f| f as u32);
    facts.timestamp_bits = family.map_or(0, |f| families[f].timestamp_valid_bits);
    if family.is_none() {
        facts.missing.push("a queue with graphics and compute");
    }
    if version < (1, 3, 0) {
        facts.missing.push("Vulkan 1.3");
        return facts;
    }
    describe_1_3(instance, physical, &mut facts);
    facts
}

/// Properties and features that only a 1.3 device can be asked for.
fn describe_1_3(instance: &Instance, physical: vk::PhysicalDevice, facts: &mut Facts) {
    let mut v11 = vk::PhysicalDeviceVulkan11Properties::default();
    let mut v12 = vk::PhysicalDeviceVulkan12Properties::default();
    let mut v13 = vk::PhysicalDeviceVulkan13Properties::default();
    let mut properties =
        vk::PhysicalDeviceProperties2::default().push_next(&mut v11).push_next(&mut v12).push_next(&mut v13);
    // SAFETY: the chain lives through the call and the device is of version 1.3.
    unsafe { instance.raw.get_physical_device_properties2(physical, &mut properties) };
    facts.subgroup_size = v11.subgroup_size;
    // llvmpipe counts down from 65,535 over all loops of an invocation and then leaves them (Mesa, gallivm, LP_MAX_TGSI_LOOP_ITERATIONS).
    facts.loop_iterations = (v12.driver_id == vk::DriverId::MESA_LLVMPIPE).then_some(65_535);
    facts.driver = format!("{} {}", text(&v12.driver_name), text(&v12.driver_info)).trim().to_string();
    facts.max_buffer_bytes = v13.max_buffer_size;
    let mut f12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut f13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut f12).push_next(&mut f13);
    // SAFETY: as above.
    unsafe { instance.raw.get_physical_device_features2(physical, &mut features) };
    let core = features.features;
    facts.full_draw_index = core.full_draw_index_uint32 != vk::FALSE;
    facts.depth_clamp = core.depth_clamp != vk::FALSE;
    facts.fragment_stores = core.fragment_stores_and_atomics != vk::FALSE;
    // SwiftShader offers the feature and decodes blocks for draws alone: what a dispatch samples of such an image is memory that nothing has written.
    facts.block_compression =
        core.texture_compression_bc != vk::FALSE && v12.driver_id != vk::DriverId::GOOGLE_SWIFTSHADER;
    if !facts.full_draw_index {
        facts.limits.max_draw_indexed_index_value = (1 << 24) - 1;
    }
    let baseline = [
        (f13.synchronization2, "synchronization2"),
        (f13.dynamic_rendering, "dynamicRendering"),
        (f12.timeline_semaphore, "timelineSemaphore"),
        (f12.scalar_block_layout, "scalarBlockLayout"),
    ];
    facts.missing.extend(baseline.iter().filter(|b| b.0 == vk::FALSE).map(|b| b.1));
    let limits = &facts.limits;
    if limits.max_compute_work_group_invocations < 256 {
        facts.missing.push("256 invocations a workgroup");
    }
    if limits.max_compute_shared_memory_size < 32 << 10 {
        facts.missing.push("32 KiB of shared memory");
    }
    // SAFETY: as above.
    let rgba32f =
        unsafe { instance.raw.get_physical_device_format_properties(physical, vk::Format::R32G32B32A32_SFLOAT) };
    facts.samples = sample_counts(instance, physical);
    // SAFETY: as above.
    let d32f = unsafe { instance.raw.get_physical_device_format_properties(physical, vk::Format::D32_SFLOAT) };
    if !d32f.optimal_tiling_features.contains(vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT) {
        facts.missing.push("32-bit float depth");
    }
    facts.float_blend = rgba32f.optimal_tiling_features.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND);
    if !rgba32f.optimal_tiling_features.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT) {
        facts.missing.push("RGBA32F colour attachments");
    }
    let timestamps = facts.timestamp_bits > 0;
    let optional = [
        ("timestamps", timestamps, "frames are timed by the host, passes are not, said in the report"),
        (
            "writes of fragment shaders",
            facts.fragment_stores,
            "every slice of every tile is a cluster of blended surfaces, instead of those that hold fragments",
        ),
        (
            "blending of 32-bit floats",
            facts.float_blend,
            "a pass over the full screen stands in for light volumes, blended surfaces are mixed in a 16-bit layer",
        ),
        ("4 samples a pixel", facts.samples[0] & 4 != 0, "--msaa takes the nearest number of samples there is"),
        (
            "4 samples in a G-buffer",
            facts.samples[1] & 4 != 0,
            "deferred techniques take the nearest number of samples there is",
        ),
        (
            "BC1 and BC4 images in compute passes",
            facts.block_compression,
            "--gi-path sampled is refused for matrices of blocks; buffers hold the same blocks",
        ),
        ("32-bit indices", facts.full_draw_index, "meshes of more than 2^24 vertices are refused"),
    ];
    facts.optional = optional.iter().map(|&(name, there, without)| Optional { name, there, without }).collect();
}

/// Bits of the numbers of samples that attachments which shaders read later have: radiance with depth, and these with a compact G-buffer.
fn sample_counts(instance: &Instance, physical: vk::PhysicalDevice) -> [u32; 2] {
    use vk::ImageUsageFlags as U;
    let of = |format: vk::Format, attachment: U| {
        // SAFETY: the physical device comes from this instance.
        let properties = unsafe {
            instance.raw.get_physical_device_image_format_properties(
                physical,
                format,
                vk::ImageType::TYPE_2D,
                vk::ImageTiling::OPTIMAL,
                attachment | U::SAMPLED,
                vk::ImageCreateFlags::empty(),
            )
        };
        properties.map_or(1, |properties| properties.sample_counts.as_raw())
    };
    let lit = of(vk::Format::R32G32B32A32_SFLOAT, U::COLOR_ATTACHMENT)
        & of(vk::Format::D32_SFLOAT, U::DEPTH_STENCIL_ATTACHMENT);
    let stored = [
        vk::Format::R8G8_UINT,
        vk::Format::A2B10G10R10_UNORM_PACK32,
        vk::Format::A2B10G10R10_UINT_PACK32,
        vk::Format::R16G16_UINT,
        vk::Format::R16G16B16A16_UINT,
        vk::Format::R8G8B8A8_UNORM,
        vk::Format::R16G16B16A16_SFLOAT,
    ];
    [lit, stored.iter().fold(lit, |counts, &format| counts & of(format, U::COLOR_ATTACHMENT))]
}
