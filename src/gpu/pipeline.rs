//! Pipelines and their layouts, made from the graph's plain descriptions.

use std::collections::BTreeSet;
use std::io::Cursor;
use std::sync::Arc;

use ash::{util, vk};

use super::pipeline_cache::PipelineCache;
use super::specialize::{specialize, used_bindings};
use super::{Device, failed};
use crate::error::{Error, Result};
use crate::graph::program::{Program, Slot};
use crate::graph::{Blend, ComputePipeline, DepthBias, GraphicsPipeline};

/// Attribute formats by location: position, normal, tangent, uv0, uv1, colour; each in a stream of its own.
pub const ATTRIBUTE_FORMATS: [vk::Format; 6] = [
    vk::Format::R32G32B32_SFLOAT,
    vk::Format::R32G32B32_SFLOAT,
    vk::Format::R32G32B32A32_SFLOAT,
    vk::Format::R32G32_SFLOAT,
    vk::Format::R32G32_SFLOAT,
    vk::Format::R32G32B32A32_SFLOAT,
];

/// Bytes of one element by location.
pub const ATTRIBUTE_BYTES: [u64; 6] = [12, 12, 16, 8, 8, 16];

/// A pipeline with its layout and set layouts.
pub struct Pipeline {
    /// Handle.
    pub raw: vk::Pipeline,
    /// Layout.
    pub layout: vk::PipelineLayout,
    /// By set number.
    pub set_layouts: Vec<vk::DescriptorSetLayout>,
    /// What it was made from.
    pub program: &'static Program,
    /// Bindings that its specialised stages reach: its sets have no others.
    pub slots: Vec<&'static Slot>,
    device: Arc<Device>,
}

/// Passed on as well: where `specialize` left a module as it was, the driver does it.
struct Constants {
    entries: Vec<vk::SpecializationMapEntry>,
    data: Vec<u8>,
}

impl Constants {
    fn new(values: &[(u32, u32)]) -> Self {
        let entry = |(i, &(id, _)): (usize, &(u32, u32))| {
            vk::SpecializationMapEntry::default().constant_id(id).offset(i as u32 * 4).size(4)
        };
        Self {
            entries: values.iter().enumerate().map(entry).collect(),
            data: values.iter().flat_map(|(_, bits)| bits.to_le_bytes()).collect(),
        }
    }

    fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(&self.data)
    }
}

/// Set and binding of everything that a stage reaches; `None` where that is not known.
type UsedBindings = Option<BTreeSet<(u32, u32)>>;

/// Shader modules of one pipeline, destroyed when it is made.
struct Modules<'a> {
    device: &'a Device,
    raw: Vec<(vk::ShaderStageFlags, vk::ShaderModule)>,
    /// What each stage reaches.
    used: Vec<(vk::ShaderStageFlags, UsedBindings)>,
}

impl<'a> Modules<'a> {
    fn create(device: &'a Device, program: &Program, values: &[(u32, u32)]) -> Result<Self> {
        let mut modules = Self { device, raw: Vec::new(), used: Vec::new() };
        for stage in program.stages {
            let code = util::read_spv(&mut Cursor::new(stage.spirv))
                .map_err(|e| Error::new(format!("SPIR-V of {} is damaged: {e}", program.name)))?;
            let code = specialize(&code, values);
            modules.used.push((stage.stage, used_bindings(&code)));
            let info = vk::ShaderModuleCreateInfo::default().code(&code);
            // SAFETY: the SPIR-V comes from our own build.
            let module =
                unsafe { device.raw.create_shader_module(&info, None) }.map_err(failed("creating a shader module"))?;
            device.name(module, program.name);
            modules.raw.push((stage.stage, module));
        }
        Ok(modules)
    }

    /// A stage declares the slot and may reach it.
    fn uses(&self, slot: &Slot) -> bool {
        let reaches = |used: &UsedBindings| used.as_ref().is_none_or(|used| used.contains(&(slot.set, slot.binding)));
        self.used.iter().any(|(stage, used)| slot.stages.contains(*stage) && reaches(used))
    }

    fn stages<'b>(&'b self, constants: &'b vk::SpecializationInfo<'b>) -> Vec<vk::PipelineShaderStageCreateInfo<'b>> {
        let stage = |&(stage, module): &(vk::ShaderStageFlags, vk::ShaderModule)| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(stage)
                .module(module)
                .name(c"main")
                .specialization_info(constants)
        };
        self.raw.iter().map(stage).collect()
    }
}

impl Drop for Modules<'_> {
    fn drop(&mut self) {
        for &(_, module) in &self.raw {
            // SAFETY: modules are not needed once their pipeline exists.
            unsafe { self.device.raw.destroy_shader_module(module, None) };
        }
    }
}

impl Pipeline {
    /// Layouts first, then the pipeline in place.
    fn with_layouts(device: &Arc<Device>, program: &'static Program, modules: &Modules) -> Result<Self> {
        if let Ok(mut accounts) = device.accounts.lock() {
            accounts.made += 1;
        }
        let mut pipeline = Self {
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layouts: Vec::new(),
            program,
            slots: program.slots.iter().filter(|slot| modules.uses(slot)).collect(),
            device: device.clone(),
        };
        let set_count = pipeline.slots.iter().map(|s| s.set + 1).max().unwrap_or(0);
        for set in 0..set_count {
            let bindings: Vec<_> = pipeline
                .slots
                .iter()
                .filter(|s| s.set == set)
                .map(|s| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(s.binding)
                        .descriptor_type(s.kind.descriptor_type())
                        .descriptor_count(1)
                        .stage_flags(s.stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: `bindings` lives through the call.
            let layout = unsafe { device.raw.create_descriptor_set_layout(&info, None) }
                .map_err(failed("creating a descriptor set layout"))?;
            pipeline.set_layouts.push(layout);
        }
        let all_stages = program.stages.iter().fold(vk::ShaderStageFlags::empty(), |s, stage| s | stage.stage);
        let push = [vk::PushConstantRange::default().stage_flags(all_stages).size(program.push_bytes)];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&pipeline.set_layouts);
        if program.push_bytes > 0 {
            info = info.push_constant_ranges(&push);
        }
        // SAFETY: set layouts are alive.
        let layout = unsafe { device.raw.create_pipeline_layout(&info, None) };
        pipeline.layout = layout.map_err(failed("creating a pipeline layout"))?;
        Ok(pipeline)
    }

    /// Makes a compute pipeline.
    pub fn compute(device: &Arc<Device>, cache: &PipelineCache, desc: &ComputePipeline) -> Result<Self> {
        let modules = Modules::create(device, desc.program, &desc.constants)?;
        let mut pipeline = Self::with_layouts(device, desc.program, &modules)?;
        let constants = Constants::new(&desc.constants);
        let specialization = constants.info();
        let stage = modules.stages(&specialization)[0];
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(pipeline.layout);
        // SAFETY: module, layout and constants live through the call.
        let raw = unsafe { device.raw.create_compute_pipelines(cache.raw, &[info], None) };
        pipeline.raw = raw.map_err(|(_, e)| failed(desc.program.name)(e))?[0];
        device.name(pipeline.raw, desc.program.name);
        Ok(pipeline)
    }

    /// Makes a graphics pipeline; viewport, scissor, culling, winding and strides are dynamic.
    ///
    /// # Errors
    /// The device lacks what the description asks for, or the driver refuses it.
    pub fn graphics(device: &Arc<Device>, cache: &PipelineCache, desc: &GraphicsPipeline) -> Result<Self> {
        check_features(device, desc)?;
        let modules = Modules::create(device, desc.program, &desc.constants)?;
        let mut pipeline = Self::with_layouts(device, desc.program, &modules)?;
        let constants = Constants::new(&desc.constants);
        let specialization = constants.info();
        let stages = modules.stages(&specialization);
        let (buffers, attributes) = vertex_input(desc.program.inputs);
        let input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&buffers)
            .vertex_attribute_descriptions(&attributes);
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let bias = desc.depth.map(|depth| depth.bias).unwrap_or_default();
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .line_width(1.0)
            .depth_clamp_enable(desc.depth_clamp)
            .depth_bias_enable(bias != DepthBias::default())
            .depth_bias_constant_factor(bias.constant as f32)
            .depth_bias_slope_factor(bias.slope as f32);
        let masks = [desc.sample_mask];
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::from_raw(desc.samples))
            .sample_mask(&masks);
        let mut depth = vk::PipelineDepthStencilStateCreateInfo::default();
        if let Some(state) = desc.depth {
            depth = depth.depth_test_enable(true).depth_write_enable(state.write).depth_compare_op(state.compare);
        }
        let blend = vec![blend_state(desc.blend); desc.colors.len()];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend);
        let mut dynamic = vec![
            vk::DynamicState::VIEWPORT,
            vk::DynamicState::SCISSOR,
            vk::DynamicState::CULL_MODE,
            vk::DynamicState::FRONT_FACE,
        ];
        if !buffers.is_empty() {
            dynamic.push(vk::DynamicState::VERTEX_INPUT_BINDING_STRIDE);
        }
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(&desc.colors)
            .depth_attachment_format(desc.depth.map_or(vk::Format::UNDEFINED, |d| d.format));
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(pipeline.layout)
            .push_next(&mut rendering);
        // SAFETY: everything `info` points to lives through the call.
        let raw = unsafe { device.raw.create_graphics_pipelines(cache.raw, &[info], None) };
        pipeline.raw = raw.map_err(|(_, e)| failed(desc.program.name)(e))?[0];
        device.name(pipeline.raw, desc.program.name);
        Ok(pipeline)
    }
}

/// What a description may ask for and a device need not have.
fn check_features(device: &Device, desc: &GraphicsPipeline) -> Result<()> {
    let (name, facts) = (desc.program.name, &device.facts);
    let most = facts.limits.max_color_attachments as usize;
    if desc.colors.len() > most {
        let wanted = desc.colors.len();
        return Err(Error::new(format!("{name} needs {wanted} colour attachments, this device grants {most}")));
    }
    if desc.depth_clamp && !facts.depth_clamp {
        return Err(Error::new(format!("{name} needs depthClamp, which this device lacks")));
    }
    if desc.blend == Blend::Replace {
        return Ok(());
    }
    for &format in &desc.colors {
        let instance = &device.instance.raw;
        // SAFETY: the physical device comes from this instance.
        let properties = unsafe { instance.get_physical_device_format_properties(facts.physical, format) };
        if !properties.optimal_tiling_features.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND) {
            return Err(Error::new(format!("{name} blends into {format:?}, which this device cannot")));
        }
    }
    Ok(())
}

/// Vertex buffers and attributes of a program's inputs: each attribute has a buffer binding of its own.
fn vertex_input(inputs: &[u32]) -> (Vec<vk::VertexInputBindingDescription>, Vec<vk::VertexInputAttributeDescription>) {
    let buffer =
        |&l: &u32| vk::VertexInputBindingDescription::default().binding(l).stride(ATTRIBUTE_BYTES[l as usize] as u32);
    let attribute = |&l: &u32| {
        let format = ATTRIBUTE_FORMATS[l as usize];
        vk::VertexInputAttributeDescription::default().location(l).binding(l).format(format)
    };
    (inputs.iter().map(buffer).collect(), inputs.iter().map(attribute).collect())
}

fn blend_state(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let replace = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
    match blend {
        Blend::Replace => replace,
        Blend::Add => replace
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::ONE)
            .dst_color_blend_factor(vk::BlendFactor::ONE)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE)
            .alpha_blend_op(vk::BlendOp::ADD),
        Blend::Over => replace
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .alpha_blend_op(vk::BlendOp::ADD),
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: whoever drops a pipeline has waited for the frames that use it; null handles are ignored.
        unsafe {
            self.device.raw.destroy_pipeline(self.raw, None);
            self.device.raw.destroy_pipeline_layout(self.layout, None);
            for &layout in &self.set_layouts {
                self.device.raw.destroy_descriptor_set_layout(layout, None);
            }
        }
    }
}
