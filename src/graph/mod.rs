//! The frame as plain data: resources, and nodes that say what they touch and what they do. Nothing here knows a device.
//!
//! Passes add nodes; [`hazard`] derives the barriers between them, [`describe`] prints them, `record.rs` turns both into
//! commands, and [`checker`] proves from the log of those commands that every access was ordered.

use ash::vk;

pub mod access;
pub mod checker;
mod declare;
pub mod describe;
pub mod hazard;
pub mod log;
pub mod program;
mod prune;
mod render;
mod shape;

pub use access::Access;
use program::Program;
pub use render::{
    Blend, ColorAttachment, Cull, DepthAttachment, DepthBias, DepthState, Draw, DrawView, Geometry, GraphicsPipeline,
    MeshRange, Render, Stream,
};

/// A buffer of one graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BufferHandle(pub(crate) u32);

/// An image of one graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageHandle(pub(crate) u32);

/// Either kind of resource.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Resource {
    /// A buffer.
    Buffer(BufferHandle),
    /// An image.
    Image(ImageHandle),
}

/// Who owns the memory and what is in it before the first node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lifetime {
    /// Made for this graph; its contents need not survive, its last access carries over into the next frame.
    Transient,
    /// A buffer, made and filled with zeros before, that keeps what the graph writes from frame to frame.
    Kept,
    /// Made and filled before, only read here; images are in `SHADER_READ_ONLY_OPTIMAL`.
    Static,
    /// Written by the graph, mapped for the host.
    ReadBack,
}

/// Description of a buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BufferInfo {
    /// The words that listings and debug names use.
    pub name: String,
    /// Size.
    pub bytes: u64,
    /// Format of a texel where the buffer is bound as a texel buffer, what the shader's sampler type has to match; where a picture is
    /// read back, that of its image.
    pub texel_format: vk::Format,
    /// See [`Lifetime`].
    pub lifetime: Lifetime,
}

/// Description of an image: 2-D, one layer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageInfo {
    /// The words that listings and debug names use.
    pub name: String,
    /// Format.
    pub format: vk::Format,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// Mip levels.
    pub levels: u32,
    /// Samples a texel.
    pub samples: u32,
    /// See [`Lifetime`].
    pub lifetime: Lifetime,
}

/// Sampler as plain data; made once a distinct value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SamplerState {
    /// Filter at level 0 and below.
    pub mag: vk::Filter,
    /// Filter above level 0.
    pub min: vk::Filter,
    /// Between levels.
    pub mip: vk::SamplerMipmapMode,
    /// Horizontal and vertical wrapping.
    pub wrap: [vk::SamplerAddressMode; 2],
    /// False: level 0 only, still with both filters.
    pub mipmapped: bool,
}

/// A shader binding with its declared access.
#[derive(Debug, Clone, Copy)]
pub struct Binding {
    /// Name in the shader.
    pub name: &'static str,
    /// Descriptor set.
    pub set: u32,
    /// Binding in the set.
    pub binding: u32,
    /// What is bound.
    pub resource: Resource,
    /// What the shader does with it.
    pub access: Access,
    /// For sampled images.
    pub sampler: Option<SamplerState>,
    /// The old contents are not wanted.
    pub fresh: bool,
}

/// What becomes of the old contents of a storage image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contents {
    /// They stay where they are not written.
    Kept,
    /// They are not wanted: the image may come from `UNDEFINED`.
    Discarded,
}

/// A declared access of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Declared {
    /// Binding, attachment or argument, as listings print it.
    pub name: String,
    /// What is touched.
    pub resource: Resource,
    /// How.
    pub access: Access,
    /// The old contents are not wanted: an image may come from `UNDEFINED`.
    pub fresh: bool,
}

/// One step of the frame: label, timer, accesses, work.
#[derive(Debug)]
pub struct Node {
    /// `subject_verb`; also the debug label and the timer.
    pub name: String,
    /// Everything it touches, in binding order.
    pub accesses: Vec<Declared>,
    /// What is recorded.
    pub work: Work,
}

/// A compute pipeline as plain data.
#[derive(Debug, Clone, PartialEq)]
pub struct ComputePipeline {
    /// Shader.
    pub program: &'static Program,
    /// Specialization constants, (id, bits).
    pub constants: Vec<(u32, u32)>,
}

impl PartialEq for Program {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// How many workgroups a dispatch has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Groups {
    /// So many along x, y and z.
    Fixed([u32; 3]),
    /// As many as the first three words of a buffer say when the node runs. Nobody checks them against the device's limits:
    /// whoever writes them keeps each to 65,535.
    Indirect(BufferHandle),
}

/// What a node does.
#[derive(Debug)]
pub enum Work {
    /// Compute over a grid of workgroups.
    Dispatch {
        /// Program and constants.
        pipeline: ComputePipeline,
        /// All sets.
        bindings: Vec<Binding>,
        /// Bytes of the push constants.
        push: Vec<u8>,
        /// Workgroups.
        groups: Groups,
    },
    /// Rasterisation into attachments.
    Render(Render),
    /// The whole of one buffer into another.
    CopyBuffer {
        /// Source.
        from: BufferHandle,
        /// Destination, at least as large.
        to: BufferHandle,
    },
    /// Level 0 of an image, tightly packed.
    CopyImageToBuffer {
        /// Source.
        from: ImageHandle,
        /// Destination.
        to: BufferHandle,
    },
    /// Every word of a buffer.
    Fill {
        /// Destination.
        buffer: BufferHandle,
        /// Value of each 32-bit word.
        word: u32,
    },
    /// Nothing is recorded but the barriers: the host will read.
    Host,
}

/// Resources and nodes of one frame.
#[derive(Debug, Default)]
pub struct Graph {
    /// By [`BufferHandle`].
    pub buffers: Vec<BufferInfo>,
    /// By [`ImageHandle`].
    pub images: Vec<ImageInfo>,
    /// In execution order.
    pub nodes: Vec<Node>,
    /// Nodes before this index run once, before the first frame: what they leave does not change from frame to frame.
    pub once_nodes: usize,
    /// Nodes from there to this index make the frame that is timed and repeated; later ones read its results back once.
    pub frame_nodes: Option<usize>,
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Self {
        Self::default()
    }

    /// Declares a buffer; as a `samplerBuffer` its texels are four 32-bit floats.
    pub fn buffer(&mut self, name: &str, bytes: u64, lifetime: Lifetime) -> BufferHandle {
        self.add_buffer(BufferInfo {
            name: name.into(),
            bytes,
            texel_format: vk::Format::R32G32B32A32_SFLOAT,
            lifetime,
        })
    }

    /// Declares an array of u32; as a `usamplerBuffer` its texels are one word of 4 bytes each.
    pub fn word_buffer(&mut self, name: &str, bytes: u64, lifetime: Lifetime) -> BufferHandle {
        self.add_buffer(BufferInfo { name: name.into(), bytes, texel_format: vk::Format::R32_UINT, lifetime })
    }

    /// Declares a buffer of any kind.
    pub fn add_buffer(&mut self, info: BufferInfo) -> BufferHandle {
        self.buffers.push(info);
        BufferHandle(self.buffers.len() as u32 - 1)
    }

    /// Declares an image of one level and one sample.
    pub fn image(&mut self, name: &str, format: vk::Format, size: [u32; 2], lifetime: Lifetime) -> ImageHandle {
        let [width, height] = size;
        self.add_image(ImageInfo { name: name.into(), format, width, height, levels: 1, samples: 1, lifetime })
    }

    /// Declares a transient image of so many samples a texel.
    pub fn image_of_samples(&mut self, name: &str, format: vk::Format, size: [u32; 2], samples: u32) -> ImageHandle {
        let ([width, height], lifetime) = (size, Lifetime::Transient);
        self.add_image(ImageInfo { name: name.into(), format, width, height, levels: 1, samples, lifetime })
    }

    /// Declares an image of any kind.
    pub fn add_image(&mut self, info: ImageInfo) -> ImageHandle {
        self.images.push(info);
        ImageHandle(self.images.len() as u32 - 1)
    }

    /// Adds a node whose accesses are those of its work.
    pub fn add(&mut self, name: &str, work: Work) {
        let accesses = declare::accesses_of(&work);
        self.nodes.push(Node { name: name.into(), accesses, work });
    }

    /// Adds the node that hands read-back buffers to the host.
    pub fn host_read(&mut self, buffers: &[BufferHandle]) {
        let accesses = buffers.iter().map(|&b| declare::access("host", Resource::Buffer(b), Access::HostRead, false));
        let accesses = accesses.collect();
        self.nodes.push(Node { name: "host_read".into(), accesses, work: Work::Host });
    }

    /// Ends the part that runs once, before the first frame.
    pub fn end_once(&mut self) {
        self.once_nodes = self.nodes.len();
    }

    /// Ends the part that is timed and repeated. What was written once before it is handed over, at the end of that part, to all that reads it
    /// in the frame, so that the first frame finds what every other one does.
    pub fn end_frame(&mut self) {
        let frame_nodes = self.nodes.len();
        let handed_over = declare::handed_over(self);
        self.frame_nodes = Some(frame_nodes + handed_over.len());
        for (step, accesses) in handed_over.into_iter().enumerate() {
            let node = Node { name: format!("hand_over_{step}"), accesses, work: Work::Host };
            self.nodes.insert(self.once_nodes, node);
            self.once_nodes += 1;
        }
    }

    /// What the barriers cannot be derived for: a transient image that is used before anything defines its contents, and a node
    /// that touches one resource in two ways of which one writes or which want two layouts.
    pub fn problems(&self) -> Vec<String> {
        declare::problems(self)
    }

    /// Index behind the last node of the timed part.
    pub fn frame_len(&self) -> usize {
        self.frame_nodes.unwrap_or(self.nodes.len())
    }

    /// Nodes of the timed part.
    pub fn frame_range(&self) -> std::ops::Range<usize> {
        self.once_nodes..self.frame_len()
    }

    /// Description of a buffer.
    pub fn buffer_info(&self, handle: BufferHandle) -> &BufferInfo {
        &self.buffers[handle.0 as usize]
    }

    /// Description of an image.
    pub fn image_info(&self, handle: ImageHandle) -> &ImageInfo {
        &self.images[handle.0 as usize]
    }

    /// Name of either kind.
    pub fn name_of(&self, resource: Resource) -> &str {
        match resource {
            Resource::Buffer(b) => &self.buffer_info(b).name,
            Resource::Image(i) => &self.image_info(i).name,
        }
    }
}
