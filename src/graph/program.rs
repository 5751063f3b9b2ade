//! A shader program as plain data; `build.rs` generates one static of it for each stem under `glsl/`.

use ash::vk;

/// All stages of one stem and what they bind.
#[derive(Debug)]
pub struct Program {
    /// `folder/stem`, also the debug name.
    pub name: &'static str,
    /// Vertex before fragment.
    pub stages: &'static [Stage],
    /// Every binding over all stages, by set and binding.
    pub slots: &'static [Slot],
    /// Threads a workgroup; 1,1,1 for graphics.
    pub local_size: [u32; 3],
    /// Locations of vertex attributes.
    pub inputs: &'static [u32],
    /// Size of the push constant struct, 0 without one.
    pub push_bytes: u32,
}

/// One compiled stage.
#[derive(Debug)]
pub struct Stage {
    /// Exactly one bit.
    pub stage: vk::ShaderStageFlags,
    /// SPIR-V words as little-endian bytes.
    pub spirv: &'static [u8],
}

/// One binding as reflected from the SPIR-V.
#[derive(Debug)]
pub struct Slot {
    /// Instance name in the shader.
    pub name: &'static str,
    /// Descriptor set.
    pub set: u32,
    /// Binding in the set.
    pub binding: u32,
    /// Descriptor type and what the shader may do with it.
    pub kind: SlotKind,
    /// Stages that declare it.
    pub stages: vk::ShaderStageFlags,
}

/// What a shader does through a binding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SlotKind {
    /// Uniform buffer.
    Uniform,
    /// `readonly buffer`.
    StorageRead,
    /// `writeonly buffer`.
    StorageWrite,
    /// `buffer`.
    StorageReadWrite,
    /// `samplerBuffer`.
    UniformTexel,
    /// Image with sampler.
    Sampled,
    /// `readonly image`.
    ImageRead,
    /// `writeonly image`.
    ImageWrite,
    /// `image`.
    ImageReadWrite,
}

impl SlotKind {
    /// True for every kind of storage buffer.
    pub fn is_storage_buffer(self) -> bool {
        self.descriptor_type() == vk::DescriptorType::STORAGE_BUFFER
    }

    /// The descriptor type a layout needs.
    pub fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
            Self::StorageRead | Self::StorageWrite | Self::StorageReadWrite => vk::DescriptorType::STORAGE_BUFFER,
            Self::UniformTexel => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
            Self::Sampled => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::ImageRead | Self::ImageWrite | Self::ImageReadWrite => vk::DescriptorType::STORAGE_IMAGE,
        }
    }

    /// Access flags of every operation that the shader can do through it.
    pub fn access_flags(self) -> vk::AccessFlags2 {
        const READ: vk::AccessFlags2 = vk::AccessFlags2::SHADER_STORAGE_READ;
        const WRITE: vk::AccessFlags2 = vk::AccessFlags2::SHADER_STORAGE_WRITE;
        match self {
            Self::Uniform => vk::AccessFlags2::UNIFORM_READ,
            Self::StorageRead | Self::ImageRead => READ,
            Self::StorageWrite | Self::ImageWrite => WRITE,
            Self::StorageReadWrite | Self::ImageReadWrite => vk::AccessFlags2::from_raw(READ.as_raw() | WRITE.as_raw()),
            Self::UniformTexel | Self::Sampled => vk::AccessFlags2::SHADER_SAMPLED_READ,
        }
    }
}
