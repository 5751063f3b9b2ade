//! What a node may do with a resource: stage, kind and image layout in one word, and a type a word, so that a binding whose
//! shader reads cannot be declared as written.

use ash::vk;
use ash::vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};

use super::{Binding, BufferHandle, Contents, ImageHandle, Resource, SamplerState};

macro_rules! accesses {
    ($($(#[$doc:meta])* $name:ident: $stage:expr, $access:expr, $layout:expr;)*) => {
        /// Stage and kind of an access.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Access { $($(#[$doc])* $name,)* }

        impl Access {
            /// Every access there is, for the table of docs/SYNC.md and its test.
            pub const ALL: &'static [Access] = &[$(Access::$name,)*];

            /// Pipeline stages in which it happens.
            pub fn stages(self) -> S { match self { $(Access::$name => $stage,)* } }

            /// Access flags of the operations.
            pub fn flags(self) -> A { match self { $(Access::$name => $access,)* } }

            /// Layout an image has to be in; `UNDEFINED` for accesses that only buffers have.
            pub fn layout(self) -> L { match self { $(Access::$name => $layout,)* } }
        }
    };
}

const DEPTH_TESTS: S = S::from_raw(S::EARLY_FRAGMENT_TESTS.as_raw() | S::LATE_FRAGMENT_TESTS.as_raw());
const GRAPHICS: S = S::from_raw(S::VERTEX_SHADER.as_raw() | S::FRAGMENT_SHADER.as_raw());
const FILL: S = S::from_raw(S::COPY.as_raw() | S::CLEAR.as_raw());
const READ_WRITE: A = A::from_raw(A::SHADER_STORAGE_READ.as_raw() | A::SHADER_STORAGE_WRITE.as_raw());
const DEPTH_READ_WRITE: A =
    A::from_raw(A::DEPTH_STENCIL_ATTACHMENT_READ.as_raw() | A::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw());
const COLOR_READ_WRITE: A = A::from_raw(A::COLOR_ATTACHMENT_READ.as_raw() | A::COLOR_ATTACHMENT_WRITE.as_raw());

accesses! {
    /// Uniform buffer in a compute shader.
    ComputeUniform: S::COMPUTE_SHADER, A::UNIFORM_READ, L::UNDEFINED;
    /// Storage buffer read in a compute shader.
    ComputeStorageRead: S::COMPUTE_SHADER, A::SHADER_STORAGE_READ, L::UNDEFINED;
    /// Storage buffer written in a compute shader.
    ComputeStorageWrite: S::COMPUTE_SHADER, A::SHADER_STORAGE_WRITE, L::UNDEFINED;
    /// Storage buffer read and written in a compute shader.
    ComputeStorageReadWrite: S::COMPUTE_SHADER, READ_WRITE, L::UNDEFINED;
    /// Uniform texel buffer in a compute shader.
    ComputeTexel: S::COMPUTE_SHADER, A::SHADER_SAMPLED_READ, L::UNDEFINED;
    /// Image sampled in a compute shader.
    ComputeSampled: S::COMPUTE_SHADER, A::SHADER_SAMPLED_READ, L::SHADER_READ_ONLY_OPTIMAL;
    /// Storage image read in a compute shader.
    ComputeImageRead: S::COMPUTE_SHADER, A::SHADER_STORAGE_READ, L::GENERAL;
    /// Storage image written in a compute shader.
    ComputeImageWrite: S::COMPUTE_SHADER, A::SHADER_STORAGE_WRITE, L::GENERAL;
    /// Storage image read and written in a compute shader.
    ComputeImageReadWrite: S::COMPUTE_SHADER, READ_WRITE, L::GENERAL;
    /// Uniform buffer in a vertex shader.
    VertexUniform: S::VERTEX_SHADER, A::UNIFORM_READ, L::UNDEFINED;
    /// Storage buffer read in a vertex shader.
    VertexStorageRead: S::VERTEX_SHADER, A::SHADER_STORAGE_READ, L::UNDEFINED;
    /// Uniform buffer in a fragment shader.
    FragmentUniform: S::FRAGMENT_SHADER, A::UNIFORM_READ, L::UNDEFINED;
    /// Storage buffer read in a fragment shader.
    FragmentStorageRead: S::FRAGMENT_SHADER, A::SHADER_STORAGE_READ, L::UNDEFINED;
    /// Storage buffer written in a fragment shader.
    FragmentStorageWrite: S::FRAGMENT_SHADER, A::SHADER_STORAGE_WRITE, L::UNDEFINED;
    /// Uniform texel buffer in a fragment shader.
    FragmentTexel: S::FRAGMENT_SHADER, A::SHADER_SAMPLED_READ, L::UNDEFINED;
    /// Image sampled in a fragment shader.
    FragmentSampled: S::FRAGMENT_SHADER, A::SHADER_SAMPLED_READ, L::SHADER_READ_ONLY_OPTIMAL;
    /// Depth sampled in a fragment shader, in the layout that serves a depth test as well.
    FragmentDepthSampled: S::FRAGMENT_SHADER, A::SHADER_SAMPLED_READ, L::DEPTH_READ_ONLY_OPTIMAL;
    /// Uniform buffer in vertex and fragment shader.
    GraphicsUniform: GRAPHICS, A::UNIFORM_READ, L::UNDEFINED;
    /// Storage buffer read in vertex and fragment shader.
    GraphicsStorageRead: GRAPHICS, A::SHADER_STORAGE_READ, L::UNDEFINED;
    /// Vertex buffer.
    VertexAttribute: S::VERTEX_ATTRIBUTE_INPUT, A::VERTEX_ATTRIBUTE_READ, L::UNDEFINED;
    /// Index buffer.
    Index: S::INDEX_INPUT, A::INDEX_READ, L::UNDEFINED;
    /// Arguments of an indirect draw or dispatch.
    IndirectRead: S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ, L::UNDEFINED;
    /// Colour attachment that is cleared or overwritten.
    ColorAttachmentWrite: S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_WRITE, L::COLOR_ATTACHMENT_OPTIMAL;
    /// Colour attachment that is loaded or blended.
    ColorAttachmentReadWrite: S::COLOR_ATTACHMENT_OUTPUT, COLOR_READ_WRITE, L::COLOR_ATTACHMENT_OPTIMAL;
    /// Depth attachment that is tested and written.
    DepthAttachmentWrite: DEPTH_TESTS, DEPTH_READ_WRITE, L::DEPTH_ATTACHMENT_OPTIMAL;
    /// Depth attachment that is only tested.
    DepthAttachmentRead: DEPTH_TESTS, A::DEPTH_STENCIL_ATTACHMENT_READ, L::DEPTH_READ_ONLY_OPTIMAL;
    /// Source of a copy.
    TransferRead: S::COPY, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL;
    /// Destination of a copy.
    TransferWrite: S::COPY, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL;
    /// Destination of a fill or clear command; the layer of Debian 12 (1.3.239) files fills under COPY.
    ClearWrite: FILL, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL;
    /// Mapped memory read by the host after a wait.
    HostRead: S::HOST, A::HOST_READ, L::UNDEFINED;
}

/// Flags that write.
pub const WRITES: A = A::from_raw(
    A::SHADER_STORAGE_WRITE.as_raw()
        | A::COLOR_ATTACHMENT_WRITE.as_raw()
        | A::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw()
        | A::TRANSFER_WRITE.as_raw()
        | A::HOST_WRITE.as_raw(),
);

impl Access {
    /// True where the old contents can change.
    pub fn writes(self) -> bool {
        self.flags().intersects(WRITES)
    }

    /// The flags that read.
    pub fn read_flags(self) -> A {
        self.flags() & !WRITES
    }

    /// The flags that write.
    pub fn write_flags(self) -> A {
        self.flags() & WRITES
    }

    /// The enum's word, as listings print it.
    pub fn name(self) -> String {
        format!("{self:?}")
    }
}

macro_rules! buffer_bindings {
    ($($name:ident)*) => { $(
        #[doc = concat!("A buffer bound with [`Access::", stringify!($name), "`].")]
        #[derive(Debug, Clone, Copy)]
        pub struct $name(pub BufferHandle);
        impl $name {
            /// The binding's declaration.
            pub fn bound(self, name: &'static str, set: u32, binding: u32) -> Binding {
                let resource = Resource::Buffer(self.0);
                Binding { name, set, binding, resource, access: Access::$name, sampler: None, fresh: false }
            }
        }
    )* };
}

macro_rules! image_bindings {
    ($($name:ident)*) => { $(
        #[doc = concat!("An image bound with [`Access::", stringify!($name), "`].")]
        #[derive(Debug, Clone, Copy)]
        pub struct $name(pub ImageHandle, pub Contents);
        impl $name {
            /// The binding's declaration.
            pub fn bound(self, name: &'static str, set: u32, binding: u32) -> Binding {
                let resource = Resource::Image(self.0);
                let fresh = self.1 == Contents::Discarded;
                Binding { name, set, binding, resource, access: Access::$name, sampler: None, fresh }
            }
        }
    )* };
}

macro_rules! sampled_bindings {
    ($($name:ident)*) => { $(
        #[doc = concat!("An image and its sampler bound with [`Access::", stringify!($name), "`].")]
        #[derive(Debug, Clone, Copy)]
        pub struct $name(pub ImageHandle, pub SamplerState);
        impl $name {
            /// The binding's declaration.
            pub fn bound(self, name: &'static str, set: u32, binding: u32) -> Binding {
                let resource = Resource::Image(self.0);
                Binding { name, set, binding, resource, access: Access::$name, sampler: Some(self.1), fresh: false }
            }
        }
    )* };
}

buffer_bindings!(ComputeUniform ComputeStorageRead ComputeStorageWrite ComputeStorageReadWrite ComputeTexel VertexUniform
    VertexStorageRead FragmentUniform FragmentStorageRead FragmentStorageWrite FragmentTexel GraphicsUniform GraphicsStorageRead);
image_bindings!(ComputeImageRead ComputeImageWrite ComputeImageReadWrite);
sampled_bindings!(ComputeSampled FragmentSampled);

/// Stages of a shader program's slot as pipeline stages.
pub fn pipeline_stages(stages: vk::ShaderStageFlags) -> S {
    let mut result = S::NONE;
    for (shader, pipeline) in [
        (vk::ShaderStageFlags::VERTEX, S::VERTEX_SHADER),
        (vk::ShaderStageFlags::FRAGMENT, S::FRAGMENT_SHADER),
        (vk::ShaderStageFlags::COMPUTE, S::COMPUTE_SHADER),
    ] {
        if stages.contains(shader) {
            result |= pipeline;
        }
    }
    result
}
