//! Rasterisation as plain data: pipelines, attachments and draws of one rendering scope.

use ash::vk;

use super::program::Program;
use super::{Access, Binding, BufferHandle, ImageHandle};

/// A graphics pipeline as plain data.
#[derive(Debug, Clone, PartialEq)]
pub struct GraphicsPipeline {
    /// Shader stages.
    pub program: &'static Program,
    /// Specialization constants, (id, bits).
    pub constants: Vec<(u32, u32)>,
    /// Formats of the colour attachments.
    pub colors: Vec<vk::Format>,
    /// Of every attachment.
    pub samples: u32,
    /// Bit s: sample s is written.
    pub sample_mask: u32,
    /// Of every colour attachment.
    pub blend: Blend,
    /// Format and use of the depth attachment.
    pub depth: Option<DepthState>,
    /// What lies before the near or behind the far plane is drawn at that plane's depth instead of being clipped. Needs
    /// the device feature `depthClamp`; making the pipeline fails without it.
    pub depth_clamp: bool,
}

impl GraphicsPipeline {
    /// Replaces every texel of one attachment of one sample, whatever its depth.
    pub fn full_screen(program: &'static Program, constants: Vec<(u32, u32)>, format: vk::Format) -> Self {
        Self {
            program,
            constants,
            colors: vec![format],
            samples: 1,
            sample_mask: u32::MAX,
            blend: Blend::Replace,
            depth: None,
            depth_clamp: false,
        }
    }
}

/// How a fragment's colour meets what the attachment holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Blend {
    /// It takes its place.
    #[default]
    Replace,
    /// It is added, alpha included, in the order of instances and their triangles. Making the pipeline fails where the
    /// device does not blend the formats.
    Add,
    /// It takes its alpha's share: colour times alpha, plus what is there times the rest; alphas add up to at most 1. Fails likewise.
    Over,
}

/// What is added to the depth of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DepthBias {
    /// In steps of the format at the triangle's largest depth.
    pub constant: i32,
    /// In changes of depth from pixel to pixel.
    pub slope: i32,
}

/// Depth test of a pipeline; depth is reversed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthState {
    /// Attachment format.
    pub format: vk::Format,
    /// Fragment against attachment: `GREATER` passes what is nearer.
    pub compare: vk::CompareOp,
    /// Depth is written.
    pub write: bool,
    /// Of each triangle before the test.
    pub bias: DepthBias,
}

impl DepthState {
    /// Tested and left as it is.
    pub fn read(format: vk::Format, compare: vk::CompareOp) -> Self {
        Self { format, compare, write: false, bias: DepthBias::default() }
    }

    /// Tested and written.
    pub fn write(format: vk::Format, compare: vk::CompareOp) -> Self {
        Self { write: true, ..Self::read(format, compare) }
    }
}

/// A rendering scope with its draws.
#[derive(Debug)]
pub struct Render {
    /// Colour attachments.
    pub colors: Vec<ColorAttachment>,
    /// Depth attachment.
    pub depth: Option<DepthAttachment>,
    /// Pixels.
    pub extent: [u32; 2],
    /// Set 0, shared by all pipelines of the scope.
    pub bindings: Vec<Binding>,
    /// Set 1 by material; empty where no pipeline of the scope has a set 1.
    pub material_bindings: Vec<Vec<Binding>>,
    /// Pipelines that draws refer to.
    pub pipelines: Vec<GraphicsPipeline>,
    /// In order.
    pub draws: Vec<Draw>,
    /// One buffer holds every attribute of every mesh.
    pub vertices: Option<BufferHandle>,
    /// 32-bit indices of every mesh.
    pub indices: Option<BufferHandle>,
}

impl Render {
    /// One triangle over `image`, cleared before, by each of the pipelines in turn.
    pub fn full_screen(
        image: ImageHandle,
        extent: [u32; 2],
        bindings: Vec<Binding>,
        pipelines: Vec<GraphicsPipeline>,
    ) -> Self {
        Self {
            colors: vec![ColorAttachment { image, clear: Some([0.0; 4]) }],
            depth: None,
            extent,
            bindings,
            material_bindings: Vec::new(),
            draws: (0..pipelines.len()).map(Draw::full_screen).collect(),
            pipelines,
            vertices: None,
            indices: None,
        }
    }

    /// How the scope uses one of its colour attachments.
    pub fn color_access(&self, color: &ColorAttachment) -> Access {
        let blends = self.pipelines.iter().any(|p| p.blend != Blend::Replace);
        if color.clear.is_none() || blends { Access::ColorAttachmentReadWrite } else { Access::ColorAttachmentWrite }
    }

    /// How the scope uses its depth attachment.
    pub fn depth_access(&self, depth: &DepthAttachment) -> Access {
        let writes = self.pipelines.iter().any(|p| p.depth.is_some_and(|d| d.write));
        if depth.clear.is_some() || writes { Access::DepthAttachmentWrite } else { Access::DepthAttachmentRead }
    }
}

/// A colour attachment.
#[derive(Debug, Clone, Copy)]
pub struct ColorAttachment {
    /// Target.
    pub image: ImageHandle,
    /// Cleared to this RGBA at the start (an integer format: to zeros only); `None`: loaded.
    pub clear: Option<[f32; 4]>,
}

/// The depth attachment.
#[derive(Debug, Clone, Copy)]
pub struct DepthAttachment {
    /// Target.
    pub image: ImageHandle,
    /// Cleared to this at the start; `None`: loaded, and only tested where no pipeline of the scope writes depth.
    pub clear: Option<f32>,
}

/// One draw call.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draw {
    /// Index into [`Render::pipelines`].
    pub pipeline: usize,
    /// Index into [`Render::material_bindings`].
    pub material: Option<usize>,
    /// Where the vertices come from.
    pub geometry: Geometry,
    /// First instance.
    pub instance_offset: u32,
    /// Instances.
    pub instance_count: u32,
    /// Winding is turned round (mirrored instance).
    pub mirrored: bool,
    /// Faces that are not drawn.
    pub cull: Cull,
    /// Where in the attachments; `None`: all over them.
    pub view: Option<DrawView>,
}

/// A part of the attachments with a picture of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawView {
    /// First column and row, columns, rows.
    pub area: [u32; 4],
    /// To clip space, columns; pushed to the vertex stage.
    pub to_clip: [[f32; 4]; 4],
}

impl Draw {
    /// One triangle that covers the image, from a vertex shader without inputs.
    pub fn full_screen(pipeline: usize) -> Self {
        Self::procedural(pipeline, 3, 1, Cull::None)
    }

    /// Triangles whose corners the vertex shader makes from `gl_VertexIndex` and `gl_InstanceIndex` alone.
    pub fn procedural(pipeline: usize, vertex_count: u32, instance_count: u32, cull: Cull) -> Self {
        Self {
            pipeline,
            material: None,
            geometry: Geometry::Procedural { vertex_count },
            instance_offset: 0,
            instance_count,
            mirrored: false,
            cull,
            view: None,
        }
    }
}

/// Where a draw's vertices come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Geometry {
    /// A mesh in the scope's vertex and index buffers.
    Mesh(MeshRange),
    /// No buffer: the shader makes them.
    Procedural {
        /// Three a triangle, each instance.
        vertex_count: u32,
    },
}

/// Faces that are not drawn; the front is wound counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cull {
    /// Both sides are drawn.
    None,
    /// Faces turned away from the eye.
    #[default]
    Back,
    /// Faces turned to the eye: what is left of a closed volume is there with the eye inside, too.
    Front,
}

/// One attribute of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stream {
    /// First byte in the vertex buffer.
    pub offset: u64,
    /// Bytes from vertex to vertex; 0 where one element stands for all.
    pub stride: u64,
}

/// Where a mesh lies in the shared buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshRange {
    /// Each attribute stream by location.
    pub streams: [Stream; 6],
    /// First index.
    pub index_offset: u32,
    /// Indices.
    pub index_count: u32,
}

#[cfg(test)]
mod tests {
    use super::super::{Graph, Lifetime, Work};
    use super::*;

    static NOTHING: Program =
        Program { name: "nothing", stages: &[], slots: &[], local_size: [1; 3], inputs: &[], push_bytes: 0 };

    /// Access and freshness of the colour and the depth attachment of a scope with one pipeline.
    fn declared(
        color_clear: Option<[f32; 4]>,
        blend: Blend,
        depth_clear: Option<f32>,
        write: bool,
    ) -> Vec<(Access, bool)> {
        let (color, depth) = (vk::Format::R32G32B32A32_SFLOAT, vk::Format::D32_SFLOAT);
        let mut graph = Graph::new();
        let mut image = |format| graph.image("image", format, [4, 4], Lifetime::Transient);
        let (colors, depths) = (image(color), image(depth));
        let state = DepthState { write, ..DepthState::read(depth, vk::CompareOp::GREATER) };
        let pipeline = GraphicsPipeline {
            program: &NOTHING,
            constants: Vec::new(),
            colors: vec![color],
            blend,
            depth: Some(state),
            depth_clamp: false,
            samples: 1,
            sample_mask: u32::MAX,
        };
        let render = Render {
            colors: vec![ColorAttachment { image: colors, clear: color_clear }],
            depth: Some(DepthAttachment { image: depths, clear: depth_clear }),
            extent: [4, 4],
            bindings: Vec::new(),
            material_bindings: Vec::new(),
            pipelines: vec![pipeline],
            draws: vec![Draw::procedural(0, 36, 1000, Cull::Front)],
            vertices: None,
            indices: None,
        };
        graph.add("render", Work::Render(render));
        graph.nodes[0].accesses.iter().map(|d| (d.access, d.fresh)).collect()
    }

    #[test]
    fn attachments_are_declared_as_load_and_pipelines_use_them() {
        use Access::{ColorAttachmentReadWrite, ColorAttachmentWrite, DepthAttachmentRead, DepthAttachmentWrite};
        let (black, far) = (Some([0.0; 4]), Some(0.0));
        let replaced = declared(black, Blend::Replace, far, true);
        assert_eq!(replaced, [(ColorAttachmentWrite, true), (DepthAttachmentWrite, true)]);
        let blended = declared(black, Blend::Add, None, false);
        assert_eq!(blended, [(ColorAttachmentReadWrite, true), (DepthAttachmentRead, false)]);
        let loaded = declared(None, Blend::Replace, None, true);
        assert_eq!(loaded, [(ColorAttachmentReadWrite, false), (DepthAttachmentWrite, false)]);
    }
}
