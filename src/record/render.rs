//! Records a rendering scope: attachments, state, draws. What is logged comes from the commands' own arguments.

use ash::vk;
use ash::vk::ImageLayout;

use super::Recorder;
use crate::gpu::pipeline::Pipeline;
use crate::gpu::realize::{NodeObjects, Realized};
use crate::graph::access::Access;
use crate::graph::{
    Blend, ColorAttachment, Cull, DepthAttachment, Draw, DrawView, Geometry, GraphicsPipeline, Render, Resource,
};

type Attachment = vk::RenderingAttachmentInfo<'static>;

impl Recorder<'_> {
    pub(super) fn render(&mut self, name: &str, render: &Render, objects: &NodeObjects, realized: &Realized) {
        let colors: Vec<_> = render.colors.iter().map(|c| color_attachment(c, realized)).collect();
        let depth = render.depth.as_ref().map(|d| depth_attachment(d, render.depth_access(d), realized));
        let [width, height] = render.extent;
        let area = vk::Rect2D::default().extent(vk::Extent2D { width, height });
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth {
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
        self.log_draws(name, render);
        self.log_attachments(name, render, &colors, depth.as_ref());
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
        let (mut bound_pipeline, mut bound_material, mut bound_view) = (None, None, None);
        for draw in &render.draws {
            let made = &realized.pipelines[objects.pipelines[draw.pipeline]];
            let sets = &objects.sets[draw.pipeline];
            let front = if draw.mirrored { vk::FrontFace::CLOCKWISE } else { vk::FrontFace::COUNTER_CLOCKWISE };
            // SAFETY: inside the rendering scope; every handle is alive.
            unsafe {
                if bound_pipeline != Some(draw.pipeline) {
                    device.cmd_bind_pipeline(self.commands, point, made.raw);
                    if let Some(set) = sets.shared {
                        device.cmd_bind_descriptor_sets(self.commands, point, made.layout, 0, &[set], &[]);
                    }
                    (bound_pipeline, bound_material, bound_view) = (Some(draw.pipeline), None, None);
                }
                if let Some(material) = draw.material.filter(|m| bound_material != Some(*m))
                    && let Some(&set) = sets.by_material.get(material)
                {
                    device.cmd_bind_descriptor_sets(self.commands, point, made.layout, 1, &[set], &[]);
                    bound_material = Some(material);
                }
                device.cmd_set_cull_mode(self.commands, cull_mode(draw.cull));
                device.cmd_set_front_face(self.commands, front);
            }
            if let Some(view) = draw.view.filter(|view| bound_view != Some(*view)) {
                self.enter(&view, made);
                bound_view = Some(view);
            }
            self.draw(draw, render, made.program.inputs, realized);
        }
    }

    /// Draws go to a part of the attachments from now on.
    fn enter(&self, view: &DrawView, made: &Pipeline) {
        let (device, [x, y, width, height]) = (&self.device.raw, view.area);
        let [left, top, across, down] = view.area.map(|pixels| pixels as f32);
        let viewport = vk::Viewport { x: left, y: top, width: across, height: down, min_depth: 0.0, max_depth: 1.0 };
        let scissor =
            vk::Rect2D { offset: vk::Offset2D { x: x as i32, y: y as i32 }, extent: vk::Extent2D { width, height } };
        let stages = made.program.stages.iter().fold(vk::ShaderStageFlags::empty(), |s, stage| s | stage.stage);
        // SAFETY: inside the rendering scope, the area lies in its attachments; the pipeline's layout has a matrix of push constants in these stages.
        unsafe {
            device.cmd_set_viewport(self.commands, 0, &[viewport]);
            device.cmd_set_scissor(self.commands, 0, &[scissor]);
            device.cmd_push_constants(self.commands, made.layout, stages, 0, bytemuck::bytes_of(&view.to_clip));
        }
    }

    fn draw(&self, draw: &Draw, render: &Render, inputs: &[u32], realized: &Realized) {
        let (device, commands) = (&self.device.raw, self.commands);
        let (instances, first_instance) = (draw.instance_count, draw.instance_offset);
        let mesh = match draw.geometry {
            Geometry::Mesh(mesh) => mesh,
            Geometry::Procedural { vertex_count } => {
                // SAFETY: inside the rendering scope, pipeline and sets are bound; the program reads no vertex buffer.
                unsafe { device.cmd_draw(commands, vertex_count, instances, 0, first_instance) };
                return;
            }
        };
        for &location in inputs {
            let Some(vertices) = render.vertices else { break };
            let stream = mesh.streams[location as usize];
            let (raw, offset, stride) = ([realized.buffer(vertices).raw], [stream.offset], [stream.stride]);
            // SAFETY: the buffer is alive and has vertex usage; the stream lies in it.
            unsafe { device.cmd_bind_vertex_buffers2(commands, location, &raw, &offset, None, Some(&stride)) };
        }
        let (count, first) = (mesh.index_count, mesh.index_offset);
        // SAFETY: inside the rendering scope, pipeline and sets are bound; ranges lie within the shared buffers.
        unsafe { device.cmd_draw_indexed(commands, count, instances, first, 0, first_instance) };
    }

    /// Pipelines that drew, with what their programs can reach.
    fn log_draws(&mut self, name: &str, render: &Render) {
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
        let indexed = render.draws.iter().any(|d| matches!(d.geometry, Geometry::Mesh(_)));
        if let Some(indices) = render.indices.filter(|_| indexed) {
            self.log_as(name, "indices", Resource::Buffer(indices), Access::Index);
        }
    }

    /// Attachments as they were given: a load reads, a clear or a store writes, and so do the pipelines that drew.
    fn log_attachments(&mut self, name: &str, render: &Render, colors: &[Attachment], depth: Option<&Attachment>) {
        let drew =
            |test: fn(&GraphicsPipeline) -> bool| render.draws.iter().any(|d| test(&render.pipelines[d.pipeline]));
        let blended = drew(|p| p.blend != Blend::Replace);
        let wrote_depth = drew(|p| p.depth.is_some_and(|d| d.write));
        for (color, info) in render.colors.iter().zip(colors) {
            let read = blended || info.load_op == vk::AttachmentLoadOp::LOAD;
            let access = if read { Access::ColorAttachmentReadWrite } else { Access::ColorAttachmentWrite };
            let scope = (access.stages(), access.flags(), info.image_layout);
            self.log_access(name, "color", Resource::Image(color.image), scope);
        }
        if let (Some(depth), Some(info)) = (&render.depth, depth) {
            let kept = info.load_op == vk::AttachmentLoadOp::LOAD && info.store_op == vk::AttachmentStoreOp::NONE;
            let read = kept && !wrote_depth;
            let access = if read { Access::DepthAttachmentRead } else { Access::DepthAttachmentWrite };
            let scope = (access.stages(), access.flags(), info.image_layout);
            self.log_access(name, "depth", Resource::Image(depth.image), scope);
        }
    }
}

fn cull_mode(cull: Cull) -> vk::CullModeFlags {
    match cull {
        Cull::None => vk::CullModeFlags::NONE,
        Cull::Back => vk::CullModeFlags::BACK,
        Cull::Front => vk::CullModeFlags::FRONT,
    }
}

fn color_attachment(color: &ColorAttachment, realized: &Realized) -> Attachment {
    let base = vk::RenderingAttachmentInfo::default()
        .image_view(realized.image(color.image).view)
        .image_layout(ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
        .store_op(vk::AttachmentStoreOp::STORE);
    match color.clear {
        Some(float32) => base
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .clear_value(vk::ClearValue { color: vk::ClearColorValue { float32 } }),
        None => base.load_op(vk::AttachmentLoadOp::LOAD),
    }
}

fn depth_attachment(depth: &DepthAttachment, access: Access, realized: &Realized) -> Attachment {
    let store = if access.writes() { vk::AttachmentStoreOp::STORE } else { vk::AttachmentStoreOp::NONE };
    let base = vk::RenderingAttachmentInfo::default()
        .image_view(realized.image(depth.image).view)
        .image_layout(access.layout())
        .store_op(store);
    match depth.clear {
        Some(depth) => base
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .clear_value(vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } }),
        None => base.load_op(vk::AttachmentLoadOp::LOAD),
    }
}
