//! Turns nodes and barriers into commands: the only file with barrier, label and timestamp commands. Whatever it records it
//! also writes to a log, from the commands' own arguments and the shaders' reflection, which `graph/checker.rs` then judges.
#![allow(unsafe_code)]

mod render;
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
use crate::graph::{Binding, Graph, Groups, Resource, Work};

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
        let execution = execution_dependencies(&logged);
        let info = vk::DependencyInfo::default()
            .memory_barriers(&execution)
            .buffer_memory_barriers(&buffers)
            .image_memory_barriers(&images);
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

    fn dispatch(&mut self, name: &str, groups: Groups, realized: &Realized) {
        let device = &self.device.raw;
        match groups {
            Groups::Fixed([x, y, z]) => {
                // SAFETY: pipeline and set are bound; `Realized::create` checked groups against limits.
                unsafe { device.cmd_dispatch(self.commands, x, y, z) };
            }
            Groups::Indirect(buffer) => {
                // SAFETY: as above; the buffer holds three words, written by an earlier node that keeps them to every device's limits.
                unsafe { device.cmd_dispatch_indirect(self.commands, realized.buffer(buffer).raw, 0) };
                self.log_as(name, "groups", Resource::Buffer(buffer), Access::IndirectRead);
            }
        }
    }

    /// Records one node's commands; the stage after which its timestamp is taken.
    fn work(&mut self, name: &str, work: &Work, objects: &NodeObjects, realized: &Realized) -> PipelineStageFlags2 {
        let device = &self.device.raw;
        match work {
            Work::Dispatch { pipeline, bindings, push, groups } => {
                let made = &realized.pipelines[objects.pipelines[0]];
                // SAFETY: pipeline, set and layout belong together.
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
                }
                self.dispatch(name, *groups, realized);
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
}

/// The stages of buffer barriers once more, without any access. They order nothing that those do not order already: a dependency
/// between stages holds for all resources. Layers up to 2025 follow that only for global barriers, and would report writes after
/// reads that are ordered by another buffer's barrier (Vulkan-ValidationLayers, pull request 10524).
fn execution_dependencies(barriers: &[MemoryBarrier]) -> Vec<vk::MemoryBarrier2<'static>> {
    let of_buffers = barriers.iter().filter(|b| matches!(b.resource, Resource::Buffer(_)));
    let mut stages: Vec<_> = of_buffers.map(|b| (b.src_stages, b.dst_stages)).collect();
    stages.sort_unstable_by_key(|s| (s.0.as_raw(), s.1.as_raw()));
    stages.dedup();
    let barrier = |(src, dst)| vk::MemoryBarrier2::default().src_stage_mask(src).dst_stage_mask(dst);
    stages.into_iter().map(barrier).collect()
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
