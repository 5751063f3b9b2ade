//! Makes a graph concrete: resources with exactly the usage that its accesses ask for, pipelines, descriptor sets.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::Device;
use super::descriptors::{Descriptors, Target, Write};
use super::memory::{Buffer, Image, ImageDesc};
use super::pipeline::Pipeline;
use super::pipeline_cache::PipelineCache;
use crate::error::{Error, Result};
use crate::graph::access::Access;
use crate::graph::program::SlotKind;
use crate::graph::{Binding, BufferHandle, Graph, GraphicsPipeline, Groups, ImageHandle, Lifetime, Resource, Work};

/// Sets of one pipeline of a node: set 0, and set 1 by material.
#[derive(Debug, Default, Clone)]
pub struct Sets {
    /// Set 0, where the program has one.
    pub shared: Option<vk::DescriptorSet>,
    /// Set 1 by material; empty where the program has none.
    pub by_material: Vec<vk::DescriptorSet>,
}

/// A node's pipelines with their sets.
#[derive(Default)]
pub struct NodeObjects {
    /// In the order of the work's pipelines.
    pub pipelines: Vec<usize>,
    /// One a pipeline.
    pub sets: Vec<Sets>,
}

/// A graph with its Vulkan objects.
pub struct Realized {
    /// By handle.
    pub buffers: Vec<Buffer>,
    /// By handle.
    pub images: Vec<Image>,
    /// Every distinct pipeline.
    pub pipelines: Vec<Pipeline>,
    /// By node.
    pub nodes: Vec<NodeObjects>,
    /// Milliseconds spent making pipelines.
    pub pipeline_ms: f64,
    _descriptors: Descriptors,
}

fn buffer_usage(access: Access) -> vk::BufferUsageFlags {
    use vk::BufferUsageFlags as U;
    match access {
        Access::ComputeUniform | Access::VertexUniform | Access::FragmentUniform | Access::GraphicsUniform => {
            U::UNIFORM_BUFFER
        }
        Access::ComputeTexel | Access::FragmentTexel => U::UNIFORM_TEXEL_BUFFER,
        Access::VertexAttribute => U::VERTEX_BUFFER,
        Access::Index => U::INDEX_BUFFER,
        Access::IndirectRead => U::INDIRECT_BUFFER,
        Access::TransferRead => U::TRANSFER_SRC,
        Access::TransferWrite | Access::ClearWrite => U::TRANSFER_DST,
        Access::HostRead => U::empty(),
        _ => U::STORAGE_BUFFER,
    }
}

fn image_usage(access: Access) -> vk::ImageUsageFlags {
    use vk::ImageUsageFlags as U;
    match access {
        Access::ComputeSampled | Access::FragmentSampled | Access::FragmentDepthSampled => U::SAMPLED,
        Access::ColorAttachmentWrite | Access::ColorAttachmentReadWrite => U::COLOR_ATTACHMENT,
        Access::DepthAttachmentRead | Access::DepthAttachmentWrite => U::DEPTH_STENCIL_ATTACHMENT,
        Access::TransferRead => U::TRANSFER_SRC,
        Access::TransferWrite | Access::ClearWrite => U::TRANSFER_DST,
        _ => U::STORAGE,
    }
}

fn accesses(graph: &Graph, resource: Resource) -> impl Iterator<Item = Access> + '_ {
    graph.nodes.iter().flat_map(|n| &n.accesses).filter(move |d| d.resource == resource).map(|d| d.access)
}

/// Bytes of a texel, for the formats that graphs declare; every driver has both as uniform texels.
fn texel_bytes(format: vk::Format) -> Result<u64> {
    match format {
        vk::Format::R32G32B32A32_SFLOAT => Ok(16),
        vk::Format::R32_UINT => Ok(4),
        other => Err(Error::new(format!("{other:?} is no format of a texel buffer here"))),
    }
}

fn create_buffers(device: &Arc<Device>, graph: &Graph) -> Result<Vec<Buffer>> {
    let mut buffers = Vec::with_capacity(graph.buffers.len());
    for (index, info) in graph.buffers.iter().enumerate() {
        let resource = Resource::Buffer(BufferHandle(index as u32));
        let mut usage = accesses(graph, resource).fold(vk::BufferUsageFlags::empty(), |u, a| u | buffer_usage(a));
        if matches!(info.lifetime, Lifetime::Static | Lifetime::Kept) || usage.is_empty() {
            usage |= vk::BufferUsageFlags::TRANSFER_DST;
        }
        let location =
            if info.lifetime == Lifetime::ReadBack { MemoryLocation::GpuToCpu } else { MemoryLocation::GpuOnly };
        let texels = usage.contains(vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER);
        let texel_bytes = if texels { texel_bytes(info.texel_format)? } else { 1 };
        let mut buffer = Buffer::create(device, &info.name, info.bytes.max(texel_bytes), usage, location)?;
        if texels {
            let most = u64::from(device.facts.limits.max_texel_buffer_elements);
            buffer.add_texel_view(info.texel_format, (buffer.bytes / texel_bytes).min(most) * texel_bytes)?;
        }
        buffers.push(buffer);
    }
    Ok(buffers)
}

fn create_images(device: &Arc<Device>, graph: &Graph) -> Result<Vec<Image>> {
    let mut images = Vec::with_capacity(graph.images.len());
    for (index, info) in graph.images.iter().enumerate() {
        let resource = Resource::Image(ImageHandle(index as u32));
        let mut usage = accesses(graph, resource).fold(vk::ImageUsageFlags::empty(), |u, a| u | image_usage(a));
        if info.lifetime == Lifetime::Static {
            usage |= vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::SAMPLED;
        }
        let extent = [info.width, info.height];
        let desc = ImageDesc { format: info.format, extent, levels: info.levels, samples: info.samples, usage };
        images.push(Image::create(device, &info.name, desc)?);
    }
    Ok(images)
}

/// The bindings that a pipeline can choose from.
struct Wanted<'a> {
    bindings: &'a [Binding],
    material_bindings: &'a [Vec<Binding>],
}

impl Realized {
    /// Makes everything `graph` needs; static contents are uploaded afterwards.
    ///
    /// # Errors
    /// Out of memory, or a pipeline that the driver refuses.
    pub fn create(device: &Arc<Device>, graph: &Graph, cache: &PipelineCache) -> Result<Self> {
        let buffers = create_buffers(device, graph)?;
        let images = create_images(device, graph)?;
        let start = Instant::now();
        let (pipelines, mut nodes) = create_pipelines(device, graph, cache)?;
        let pipeline_ms = start.elapsed().as_secs_f64() * 1e3;
        let (sets, counts) = count_sets(graph, &pipelines, &nodes);
        let mut descriptors = Descriptors::create(device, sets, &counts)?;
        for (node, objects) in graph.nodes.iter().zip(&mut nodes) {
            for (wanted, &pipeline) in wanted_of(&node.work).iter().zip(&objects.pipelines) {
                let pipeline = &pipelines[pipeline];
                objects.sets.push(make_sets(&mut descriptors, device, wanted, pipeline, (&buffers, &images))?);
            }
        }
        Ok(Self { buffers, images, pipelines, nodes, pipeline_ms, _descriptors: descriptors })
    }

    /// Buffer by handle.
    pub fn buffer(&self, handle: BufferHandle) -> &Buffer {
        &self.buffers[handle.0 as usize]
    }

    /// Image by handle.
    pub fn image(&self, handle: ImageHandle) -> &Image {
        &self.images[handle.0 as usize]
    }
}

/// Whether all workgroups of a graph are within the device's limits.
///
/// # Errors
/// A dispatch that is not.
pub fn check_all_groups(device: &Device, graph: &Graph) -> Result<()> {
    graph.nodes.iter().try_for_each(|node| match &node.work {
        Work::Dispatch { groups, .. } => check_groups(device, &node.name, *groups),
        _ => Ok(()),
    })
}

fn check_groups(device: &Device, name: &str, groups: Groups) -> Result<()> {
    let most = device.facts.limits.max_compute_work_group_count;
    match groups {
        Groups::Fixed(groups) if groups.iter().zip(most).any(|(g, m)| *g > m) => {
            Err(Error::new(format!("{name} needs {groups:?} workgroups, this device takes {most:?}")))
        }
        _ => Ok(()),
    }
}

fn create_pipelines(
    device: &Arc<Device>,
    graph: &Graph,
    cache: &PipelineCache,
) -> Result<(Vec<Pipeline>, Vec<NodeObjects>)> {
    let mut pipelines = Vec::new();
    let mut nodes = Vec::new();
    // Passes that continue one another share theirs: drivers compile each anew.
    let mut drawn: Vec<(&GraphicsPipeline, usize)> = Vec::new();
    for node in &graph.nodes {
        let mut objects = NodeObjects::default();
        match &node.work {
            Work::Dispatch { pipeline, groups, .. } => {
                check_groups(device, &node.name, *groups)?;
                pipelines.push(Pipeline::compute(device, cache, pipeline)?);
                objects.pipelines.push(pipelines.len() - 1);
            }
            Work::Render(render) => {
                for pipeline in &render.pipelines {
                    if let Some(&(_, known)) = drawn.iter().find(|(known, _)| *known == pipeline) {
                        objects.pipelines.push(known);
                        continue;
                    }
                    drawn.push((pipeline, pipelines.len()));
                    objects.pipelines.push(pipelines.len());
                    pipelines.push(Pipeline::graphics(device, cache, pipeline)?);
                }
            }
            _ => {}
        }
        nodes.push(objects);
    }
    Ok((pipelines, nodes))
}

fn wanted_of(work: &Work) -> Vec<Wanted<'_>> {
    match work {
        Work::Dispatch { bindings, .. } => vec![Wanted { bindings, material_bindings: &[] }],
        Work::Render(render) => {
            let wanted = || Wanted { bindings: &render.bindings, material_bindings: &render.material_bindings };
            render.pipelines.iter().map(|_| wanted()).collect()
        }
        _ => Vec::new(),
    }
}

/// Sets by material that a pipeline takes.
fn material_sets<'a>(wanted: &Wanted<'a>, pipeline: &Pipeline) -> &'a [Vec<Binding>] {
    if pipeline.set_layouts.len() > 1 { wanted.material_bindings } else { &[] }
}

fn count_sets(graph: &Graph, pipelines: &[Pipeline], nodes: &[NodeObjects]) -> (u32, HashMap<vk::DescriptorType, u32>) {
    let (mut sets, mut counts) = (0, HashMap::new());
    for (node, objects) in graph.nodes.iter().zip(nodes) {
        for (wanted, &pipeline) in wanted_of(&node.work).iter().zip(&objects.pipelines) {
            let pipeline = &pipelines[pipeline];
            let materials = material_sets(wanted, pipeline).len() as u32;
            sets += u32::from(!pipeline.set_layouts.is_empty()) + materials;
            for slot in &pipeline.slots {
                *counts.entry(slot.kind.descriptor_type()).or_default() += if slot.set == 0 { 1 } else { materials };
            }
        }
    }
    (sets, counts)
}

fn make_sets(
    descriptors: &mut Descriptors,
    device: &Device,
    wanted: &Wanted<'_>,
    pipeline: &Pipeline,
    resources: (&[Buffer], &[Image]),
) -> Result<Sets> {
    let mut sets = Sets::default();
    let layouts = &pipeline.set_layouts;
    if let Some(&layout) = layouts.first() {
        let writes = writes_of(descriptors, device, pipeline, 0, wanted.bindings, resources)?;
        sets.shared = Some(descriptors.set(layout, &writes)?);
    }
    for bindings in material_sets(wanted, pipeline) {
        let writes = writes_of(descriptors, device, pipeline, 1, bindings, resources)?;
        sets.by_material.push(descriptors.set(layouts[1], &writes)?);
    }
    Ok(sets)
}

fn writes_of(
    descriptors: &mut Descriptors,
    device: &Device,
    pipeline: &Pipeline,
    set: u32,
    bindings: &[Binding],
    (buffers, images): (&[Buffer], &[Image]),
) -> Result<Vec<Write>> {
    let mut writes = Vec::new();
    for slot in pipeline.slots.iter().filter(|s| s.set == set) {
        let binding = bindings.iter().find(|b| b.set == set && b.name == slot.name);
        let binding = binding
            .ok_or_else(|| Error::new(format!("{}: nothing is bound to {}", pipeline.program.name, slot.name)))?;
        let target = match binding.resource {
            Resource::Buffer(handle) => {
                let buffer = &buffers[handle.0 as usize];
                let most = u64::from(device.facts.limits.max_uniform_buffer_range);
                match slot.kind {
                    SlotKind::UniformTexel => Target::Texel(buffer.texel_view.unwrap_or_default()),
                    SlotKind::Uniform => Target::Buffer { raw: buffer.raw, range: buffer.bytes.min(most) },
                    _ => Target::Buffer { raw: buffer.raw, range: buffer.bytes },
                }
            }
            Resource::Image(handle) => {
                let sampler = binding.sampler.map(|s| descriptors.sampler(s)).transpose()?.unwrap_or_default();
                let layout = binding.access.layout();
                Target::Image { view: images[handle.0 as usize].view, layout, sampler }
            }
        };
        writes.push(Write { binding: slot.binding, kind: slot.kind.descriptor_type(), target });
    }
    Ok(writes)
}
