//! Turns nodes and barriers into commands: the only file with barrier, label and timestamp commands. Whatever it records it
//! also writes to a log, from the commands' own arguments and the shaders' reflection, which `graph/checker.rs` then judges.
#![allow(unsafe_code)]

pub mod upload;

use ash::vk;
use ash::vk::{AccessFlags2, ImageLayout, PipelineStageFlags2};

use crate::gpu::Device;
use crate::gpu::memory::{Buffer, Image};
use crate::gpu::realize::{NodeObjects, Realized};
use crate::graph::access::{Access, pipeline_stages};
use crate::graph::hazard::Barrier;
use crate::graph::log::{Accessed, Event, MemoryBarrier};
use crate::graph::program::Program;
use crate::graph::{Binding, Graph, Render, Resource, Work};

/// Where commands of one submission go.
pub struct Recorder<'a> {
    /// Functions, names.
    pub device: &'a Device,
    /// In recording state.
    pub commands: vk::CommandBuffer,
    /// Timestamps, one before the first node and one after each; `None` without a timer.
    pub timer: Option<vk::QueryPool>,
    /// What was recorded; `None` where nobody will judge it.
    pub log: Option<Vec<Event>>,
}

impl Recorder<'_> {
    /// Records nodes `range` of a graph with the barriers before them.
    pub fn nodes(&mut self, graph: &Graph, barriers: &[Barrier], realized: &Realized, range: std::ops::Range<usize>) {
        if let Some(pool) = self.timer {
            // SAFETY: the pool has a query for every node and one more.
            unsafe { self.device.raw.cmd_reset_query_pool(self.commands, pool, 0, range.len() as u32 + 1) };
            self.timestamp(PipelineStageFlags2::TOP_OF_PIPE, 0);
        }
        for (count, index) in range.enumerate() {
            let node = &graph.nodes[index];
            let labelled = self.begin_label(&node.name);
            self.barriers(barriers.iter().filter(|b| b.before == index), realized);
            let stage = self.work(&node.name, &node.work, &realized.nodes[index], realized);
            if matches!(node.work, Work::Host) {
                // The one access that no command performs: the host's, after it has waited.
                node.accesses.iter().for_each(|d| self.log_as(&node.name, &d.name, d.resource, d.access));
            }
            self.timestamp(stage, count as u32 + 1);
            if labelled {
                self.end_label();
            }
        }
    }

    fn timestamp(&self, stage: PipelineStageFlags2, query: u32) {
        let Some(pool) = self.timer else { return };
        // SAFETY: the query was reset in `nodes`; the stage is a single one of a graphics and compute queue.
        unsafe { self.device.raw.cmd_write_timestamp2(self.commands, stage, pool, query) };
    }

    fn begin_label(&self, name: &str) -> bool {
        let (Some(debug), Ok(name)) = (&self.device.debug, std::ffi::CString::new(name)) else { return false };
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: the command buffer is recording.
        unsafe { debug.cmd_begin_debug_utils_label(self.commands, &label) };
        true
    }

    fn end_label(&self) {
        let Some(debug) = &self.device.debug else { return };
        // SAFETY: follows a begin in this command buffer.
        unsafe { debug.cmd_end_debug_utils_label(self.commands) };
    }

    fn barriers<'b>(&mut self, barriers: impl Iterator<Item = &'b Barrier>, realized: &Realized) {
        let (mut buffers, mut images, mut logged) = (Vec::new(), Vec::new(), Vec::new());
        for b in barriers {
            match b.resource {
                Resource::Buffer(handle) => {
                    let barrier = buffer_barrier(b, realized.buffer(handle));
                    logged.push(logged_buffer(b.resource, &barrier));
                    buffers.push(barrier);
                }
                Resource::Image(handle) => {
                    let barrier = image_barrier(b, realized.image(handle));
                    logged.push(logged_image(b.resource, &barrier));
                    images.push(barrier);
                }
            }
        }
        if logged.is_empty() {
            return;
        }
        let info = vk::DependencyInfo::default().buffer_memory_barriers(&buffers).image_memory_barriers(&images);
        // SAFETY: outside a rendering scope; handles are alive.
        unsafe { self.device.raw.cmd_pipeline_barrier2(self.commands, &info) };
        if let Some(log) = &mut self.log {
            log.push(Event::Barrier(logged));
        }
    }

    fn log_access(
        &mut self,
        node: &str,
        what: &str,
        resource: Resource,
        scope: (PipelineStageFlags2, AccessFlags2, ImageLayout),
    ) {
        let (stages, flags, layout) = scope;
        let is_image = matches!(resource, Resource::Image(_));
        let layout = if is_image { layout } else { ImageLayout::UNDEFINED };
        let Some(log) = &mut self.log else { return };
        let event = Event::Access(Accessed { node: node.into(), what: what.into(), resource, stages, flags, layout });
        // Draws of one scope repeat themselves; the same access of the same node is proved once.
        let of_node = log.iter().rev().take_while(|e| matches!(e, Event::Access(a) if a.node == node));
        if of_node.into_iter().all(|e| *e != event) {
            log.push(event);
        }
    }

    fn log_as(&mut self, node: &str, what: &str, resource: Resource, access: Access) {
        self.log_access(node, what, resource, (access.stages(), access.flags(), access.layout()));
    }

    /// What a program can do through its bindings, by reflection and not by declaration.
    fn log_bindings(&mut self, node: &str, program: &Program, set: u32, bindings: &[Binding]) {
        for slot in program.slots.iter().filter(|s| s.set == set) {
            let Some(binding) = bindings.iter().find(|b| b.set == set && b.name == slot.name) else { continue };
            let scope = (pipeline_stages(slot.stages), slot.kind.access_flags(), binding.access.layout());
            self.log_access(node, slot.name, binding.resource, scope);
        }
    }

    /// Records one node's commands; the stage after which its timestamp is taken.
    fn work(&mut self, name: &str, work: &Work, objects: &NodeObjects, realized: &Realized) -> PipelineStageFlags2 {
        let device = &self.device.raw;
        match work {
            Work::Dispatch { pipeline, bindings, push, groups } => {
                let made = &realized.pipelines[objects.pipelines[0]];
                // SAFETY: pipeline, set and layout belong together; `Realized::create` checked groups against limits.
                unsafe {
                    device.cmd_bind_pipeline(self.commands, vk::PipelineBindPoint::COMPUTE, made.raw);
                    if let Some(set) = objects.sets[0].shared {
                        let point = vk::PipelineBindPoint::COMPUTE;
                        device.cmd_bind_descriptor_sets(self.commands, point, made.layout, 0, &[set], &[]);
                    }
                    if !push.is_empty() {
                        let stages = vk::ShaderStageFlags::COMPUTE;
                        device.cmd_push_constants(self.commands, made.layout, stages, 0, push);
                    }
                    device.cmd_dispatch(self.commands, groups[0], groups[1], groups[2]);
                }
                self.log_bindings(name, pipeline.program, 0, bindings);
                PipelineStageFlags2::COMPUTE_SHADER
            }
            Work::Render(render) => {
                self.render(name, render, objects, realized);
                if render.colors.is_empty() {
                    PipelineStageFlags2::LATE_FRAGMENT_TESTS
                } else {
                    PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT
                }
            }
            Work::CopyBuffer { from, to } => {
                let (source, target) = (realized.buffer(*from), realized.buffer(*to));
                let region = [vk::BufferCopy::default().size(source.bytes.min(target.bytes))];
                // SAFETY: both buffers hold the region.
                unsafe { device.cmd_copy_buffer(self.commands, source.raw, target.raw, &region) };
                self.log_as(name, "from", Resource::Buffer(*from), Access::TransferRead);
                self.log_as(name, "to", Resource::Buffer(*to), Access::TransferWrite);
                PipelineStageFlags2::COPY
            }
            Work::CopyImageToBuffer { from, to } => {
                copy_image_to_buffer(self, realized.image(*from), realized.buffer(*to));
                self.log_as(name, "from", Resource::Image(*from), Access::TransferRead);
                self.log_as(name, "to", Resource::Buffer(*to), Access::TransferWrite);
                PipelineStageFlags2::COPY
            }
            Work::Fill { buffer, word } => {
                let target = realized.buffer(*buffer);
                // SAFETY: the whole buffer, whose size is a multiple of 4.
                unsafe { device.cmd_fill_buffer(self.commands, target.raw, 0, vk::WHOLE_SIZE, *word) };
                self.log_as(name, "buffer", Resource::Buffer(*buffer), Access::ClearWrite);
                PipelineStageFlags2::CLEAR
            }
            Work::Host => PipelineStageFlags2::BOTTOM_OF_PIPE,
        }
    }

    fn render(&mut self, name: &str, render: &Render, objects: &NodeObjects, realized: &Realized) {
        let colors: Vec<_> = render
            .colors
            .iter()
            .map(|c| {
                let value = vk::ClearValue { color: vk::ClearColorValue { float32: c.clear } };
                vk::RenderingAttachmentInfo::default()
                    .image_view(realized.image(c.image).view)
                    .image_layout(ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
                    .load_op(vk::AttachmentLoadOp::CLEAR)
                    .store_op(vk::AttachmentStoreOp::STORE)
                    .clear_value(value)
            })
            .collect();
        let depth_info = render.depth.as_ref().map(|d| {
            let base = vk::RenderingAttachmentInfo::default().image_view(realized.image(d.image).view);
            match d.clear {
                Some(depth) => base
                    .image_layout(ImageLayout::DEPTH_ATTACHMENT_OPTIMAL)
                    .load_op(vk::AttachmentLoadOp::CLEAR)
                    .store_op(vk::AttachmentStoreOp::STORE)
                    .clear_value(vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } }),
                None => base
                    .image_layout(ImageLayout::DEPTH_READ_ONLY_OPTIMAL)
                    .load_op(vk::AttachmentLoadOp::LOAD)
                    .store_op(vk::AttachmentStoreOp::NONE),
            }
        });
        let [width, height] = render.extent;
        let area = vk::Rect2D::default().extent(vk::Extent2D { width, height });
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth_info {
            info = info.depth_attachment(depth);
        }
        let device = &self.device.raw;
        let viewport =
            vk::Viewport { x: 0.0, y: 0.0, width: width as f32, height: height as f32, min_depth: 0.0, max_depth: 1.0 };
        // SAFETY: attachments are alive and in the layouts named; the scope is closed below.
        unsafe {
            device.cmd_begin_rendering(self.commands, &info);
            device.cmd_set_viewport(self.commands, 0, &[viewport]);
            device.cmd_set_scissor(self.commands, 0, &[area]);
        }
        self.draws(render, objects, realized);
        // SAFETY: closes the scope opened above.
        unsafe { device.cmd_end_rendering(self.commands) };
        self.log_render(name, render);
    }

    fn draws(&self, render: &Render, objects: &NodeObjects, realized: &Realized) {
        let device = &self.device.raw;
        let point = vk::PipelineBindPoint::GRAPHICS;
        if let Some(indices) = render.indices {
            // SAFETY: the buffer has index usage and holds u32.
            unsafe {
                device.cmd_bind_index_buffer(self.commands, realized.buffer(indices).raw, 0, vk::IndexType::UINT32);
            }
        }
        let (mut bound_pipeline, mut bound_material) = (None, None);
        for draw in &render.draws {
            let made = &realized.pipelines[objects.pipelines[draw.pipeline]];
            let sets = &objects.sets[draw.pipeline];
            let cull = if draw.double_sided || draw.mesh.is_none() {
                vk::CullModeFlags::NONE
            } else {
                vk::CullModeFlags::BACK
            };
            let front = if draw.mirrored { vk::FrontFace::CLOCKWISE } else { vk::FrontFace::COUNTER_CLOCKWISE };
            // SAFETY: inside the rendering scope; every handle is alive, ranges lie within the shared buffers.
            unsafe {
                if bound_pipeline != Some(draw.pipeline) {
                    device.cmd_bind_pipeline(self.commands, point, made.raw);
                    if let Some(set) = sets.shared {
                        device.cmd_bind_descriptor_sets(self.commands, point, made.layout, 0, &[set], &[]);
                    }
                    (bound_pipeline, bound_material) = (Some(draw.pipeline), None);
                }
                if let Some(material) = draw.material.filter(|m| bound_material != Some(*m))
                    && let Some(&set) = sets.by_material.get(material)
                {
                    device.cmd_bind_descriptor_sets(self.commands, point, made.layout, 1, &[set], &[]);
                    bound_material = Some(material);
                }
                device.cmd_set_cull_mode(self.commands, cull);
                device.cmd_set_front_face(self.commands, front);
                match (draw.mesh, render.vertices) {
                    (Some(mesh), Some(vertices)) => {
                        let raw = realized.buffer(vertices).raw;
                        for &location in made.program.inputs {
                            let stream = mesh.streams[location as usize];
                            let (offset, stride) = ([stream.offset], stream.stride);
                            device.cmd_bind_vertex_buffers2(
                                self.commands,
                                location,
                                &[raw],
                                &offset,
                                None,
                                Some(&[stride]),
                            );
                        }
                        let (count, first) = (mesh.index_count, mesh.index_offset);
                        device.cmd_draw_indexed(
                            self.commands,
                            count,
                            draw.instance_count,
                            first,
                            0,
                            draw.instance_offset,
                        );
                    }
                    _ => device.cmd_draw(self.commands, 3, draw.instance_count, 0, draw.instance_offset),
                }
            }
        }
    }

    /// Pipelines that drew, with what their programs can reach, then the attachments as they were given.
    fn log_render(&mut self, name: &str, render: &Render) {
        let mut used: Vec<(usize, Option<usize>)> = render.draws.iter().map(|d| (d.pipeline, d.material)).collect();
        used.sort_unstable();
        used.dedup();
        for (pipeline, material) in used {
            let program = render.pipelines[pipeline].program;
            self.log_bindings(name, program, 0, &render.bindings);
            if let Some(bindings) = material.and_then(|m| render.material_bindings.get(m)) {
                self.log_bindings(name, program, 1, bindings);
            }
            if let Some(vertices) = render.vertices.filter(|_| !program.inputs.is_empty()) {
                self.log_as(name, "vertices", Resource::Buffer(vertices), Access::VertexAttribute);
            }
        }
        if let Some(indices) = render.indices.filter(|_| !render.draws.is_empty()) {
            self.log_as(name, "indices", Resource::Buffer(indices), Access::Index);
        }
        for color in &render.colors {
            self.log_as(name, "color", Resource::Image(color.image), Access::ColorAttachmentWrite);
        }
        if let Some(depth) = &render.depth {
            let access = if depth.clear.is_some() { Access::DepthAttachmentWrite } else { Access::DepthAttachmentRead };
            self.log_as(name, "depth", Resource::Image(depth.image), access);
        }
    }
}

fn buffer_barrier(b: &Barrier, buffer: &Buffer) -> vk::BufferMemoryBarrier2<'static> {
    vk::BufferMemoryBarrier2::default()
        .src_stage_mask(b.src_stages)
        .src_access_mask(b.src_access)
        .dst_stage_mask(b.dst_stages)
        .dst_access_mask(b.dst_access)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .buffer(buffer.raw)
        .size(vk::WHOLE_SIZE)
}

/// The log's entry, from the arguments that the command gets.
fn logged_buffer(resource: Resource, b: &vk::BufferMemoryBarrier2<'_>) -> MemoryBarrier {
    MemoryBarrier {
        resource,
        src_stages: b.src_stage_mask,
        src_access: b.src_access_mask,
        dst_stages: b.dst_stage_mask,
        dst_access: b.dst_access_mask,
        layouts: (ImageLayout::UNDEFINED, ImageLayout::UNDEFINED),
    }
}

fn logged_image(resource: Resource, b: &vk::ImageMemoryBarrier2<'_>) -> MemoryBarrier {
    MemoryBarrier {
        resource,
        src_stages: b.src_stage_mask,
        src_access: b.src_access_mask,
        dst_stages: b.dst_stage_mask,
        dst_access: b.dst_access_mask,
        layouts: (b.old_layout, b.new_layout),
    }
}

fn image_barrier(b: &Barrier, image: &Image) -> vk::ImageMemoryBarrier2<'static> {
    vk::ImageMemoryBarrier2::default()
        .src_stage_mask(b.src_stages)
        .src_access_mask(b.src_access)
        .dst_stage_mask(b.dst_stages)
        .dst_access_mask(b.dst_access)
        .old_layout(b.layouts.0)
        .new_layout(b.layouts.1)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw)
        .subresource_range(image.range())
}

fn copy_image_to_buffer(recorder: &Recorder<'_>, image: &Image, buffer: &Buffer) {
    let layers = vk::ImageSubresourceLayers::default().aspect_mask(image.aspect).layer_count(1);
    let extent = vk::Extent3D { width: image.extent[0], height: image.extent[1], depth: 1 };
    let region = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
    let layout = ImageLayout::TRANSFER_SRC_OPTIMAL;
    // SAFETY: the buffer was sized for level 0, tightly packed.
    unsafe {
        recorder.device.raw.cmd_copy_image_to_buffer(recorder.commands, image.raw, layout, buffer.raw, &region);
    }
}
