//! What is drawn: meshes, materials, lights and cameras, from a glTF file or from code.
//!
//! Units are glTF's: metres, right-handed, +Y up, a camera looks along its own -Z; lux for directional lights, candela for
//! point and spot lights. Node transforms are kept in f64, vertices in f32 in their mesh's own space.

use glam::{DMat4, DVec3};

use crate::error::Result;
use shading::OwnModel;

/// Everything that can be drawn, free of Vulkan. A [`validate`](Scene::validate)d scene has no dangling index and no NaN.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// File name or `builtin:...` as the user wrote it.
    pub name: String,
    /// Triangle lists, one a glTF primitive.
    pub meshes: Vec<Mesh>,
    /// Referred to by [`Mesh::material`]; never empty where a mesh exists.
    pub materials: Vec<Material>,
    /// Decoded pictures, referred to by [`Texture::image`].
    pub images: Vec<Image>,
    /// Where each mesh stands.
    pub instances: Vec<Instance>,
    /// Punctual lights in light-id order.
    pub lights: Vec<Light>,
    /// Cameras of the file, in node order.
    pub cameras: Vec<Camera>,
    /// Sentences for the user: what was dropped, replaced or is not supported, each once with its count.
    pub warnings: Vec<String>,
}

/// One triangle list. Optional attributes are empty when absent; the others have one element a vertex.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// For messages and object names.
    pub name: String,
    /// Metres, in mesh space.
    pub positions: Vec<[f32; 3]>,
    /// Unit length; always there (loaders make flat normals when a file has none).
    pub normals: Vec<[f32; 3]>,
    /// xyz unit tangent, w the sign of the bitangent: `b = w * cross(n, t)`. Empty unless the material has a normal map.
    pub tangents: Vec<[f32; 4]>,
    /// Texture coordinates, sets 0 and 1; (0, 0) is the upper left corner.
    pub uvs: [Vec<[f32; 2]>; 2],
    /// Linear RGBA factors, multiplied with the base colour.
    pub colors: Vec<[f32; 4]>,
    /// Three a triangle, counter-clockwise seen from the front.
    pub indices: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

/// A mesh placed in the world. A negative determinant turns the winding round.
#[derive(Debug, Clone)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Affine, invertible.
    pub object_to_world: DMat4,
}

/// Surface description: glTF's metallic-roughness model (glTF 2.0, section 3.9).
#[derive(Debug, Clone)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Linear RGBA.
    pub base_color: [f32; 4],
    /// sRGB-encoded RGBA texture, multiplied with `base_color`.
    pub base_color_texture: Option<Texture>,
    /// 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f32,
    /// Linear; green is roughness, blue is metalness, each multiplied with its factor.
    pub metallic_roughness_texture: Option<Texture>,
    /// Linear, tangent space, +Y up.
    pub normal_texture: Option<Texture>,
    /// Scales x and y of the normal texture.
    pub normal_scale: f32,
    /// Linear; red is ambient occlusion.
    pub occlusion_texture: Option<Texture>,
    /// `1 + strength * (sample - 1)` multiplies ambient light.
    pub occlusion_strength: f32,
    /// Linear RGB radiance in nits, `emissiveFactor * emissiveStrength`.
    pub emissive: [f32; 3],
    /// sRGB-encoded, multiplied with `emissive`.
    pub emissive_texture: Option<Texture>,
    /// What alpha means.
    pub alpha: AlphaMode,
    /// Both faces are drawn; the normal is turned to the viewer.
    pub double_sided: bool,
    /// `KHR_materials_unlit`: the base colour is the picture.
    pub unlit: bool,
    /// `extras.lampyris.model`; `None`: the picture's.
    pub model: Option<OwnModel>,
    /// `extras.lampyris.heightTexture`: what lies below the surface is seen at an angle (parallax mapping).
    pub height: Option<Height>,
}

/// How deep a surface seems to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Height {
    /// Linear: 1 is the surface, 0 the deepest point.
    pub texture: Texture,
    /// Its channel, 0 to 3 for red, green, blue and alpha.
    pub channel: usize,
    /// Depth of 0, in widths of the texture: 0 to 1.
    pub scale: f32,
}

impl Height {
    /// The depth where a file says none.
    pub const SCALE: f32 = 0.05;
}

/// glTF's `alphaMode`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// A fragment with alpha below the cut-off does not exist.
    Mask(f32),
    /// Mixed with what lies behind: its share is alpha.
    Blend,
}

/// Use of an image by a material: image, sampler, UV set and `KHR_texture_transform`.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Index into [`Scene::images`].
    pub image: usize,
    /// Wrapping and filtering.
    pub sampler: Sampler,
    /// 0 or 1.
    pub uv_set: usize,
    /// Rows of the affine map: `u' = row0 . (u, v, 1)`, `v' = row1 . (u, v, 1)`.
    pub uv_transform: [[f32; 3]; 2],
}

/// Maps each coordinate to itself.
pub const IDENTITY_UV: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// glTF's sampler. `mipmapped == false` samples level 0 only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Horizontal wrapping.
    pub wrap_u: Wrap,
    /// Vertical wrapping.
    pub wrap_v: Wrap,
    /// Linear when the level is 0 or less.
    pub mag_linear: bool,
    /// Linear within a level when minified.
    pub min_linear: bool,
    /// Levels other than 0 are used.
    pub mipmapped: bool,
    /// Linear between levels; else the nearest level.
    pub mip_linear: bool,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            mag_linear: true,
            min_linear: true,
            mipmapped: true,
            mip_linear: true,
        }
    }
}

/// glTF's wrapping modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// 10497
    Repeat,
    /// 33648
    MirroredRepeat,
    /// 33071
    ClampToEdge,
}

/// A decoded picture, rows from the top, 8-bit RGBA. Whether it is sRGB-encoded is decided by its use.
#[derive(Debug, Clone, Default)]
pub struct Image {
    /// File name or index, for messages.
    pub name: String,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// `width * height * 4` bytes.
    pub rgba8: Vec<u8>,
}

/// A punctual light (`KHR_lights_punctual`).
#[derive(Debug, Clone)]
pub struct Light {
    /// For messages.
    pub name: String,
    /// Directional, point or spot.
    pub kind: LightKind,
    /// Linear RGB, multiplied with `intensity`.
    pub color: [f32; 3],
    /// Lux for directional, candela for the others.
    pub intensity: f32,
    /// World space, metres.
    pub position: DVec3,
    /// World space, unit length: the way the light shines.
    pub direction: DVec3,
    /// Metres. `None`: solved from the cut-off by the plan.
    pub range: Option<f32>,
    /// `extras.lampyris.shadow`: what stands in its way keeps it from what lies behind.
    pub shadow: bool,
}

/// Shape of a light. Angles are from the axis, in radians, `inner <= outer`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightKind {
    /// Parallel rays.
    Directional,
    /// All directions alike.
    Point,
    /// A cone, full inside `inner`, nothing outside `outer`.
    Spot {
        /// Full intensity up to here.
        inner: f32,
        /// Zero from here on.
        outer: f32,
    },
}

/// A camera in the world.
#[derive(Debug, Clone)]
pub struct Camera {
    /// glTF node or camera name.
    pub name: String,
    /// Rigid: rotation and translation, scale removed. The camera looks along its own -Z.
    pub camera_to_world: DMat4,
    /// Lens.
    pub projection: Projection,
}

/// glTF's two projections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Vertical field of view in radians; `aspect` is width over height, `None` takes the picture's.
    Perspective {
        /// Radians, in (0, pi).
        yfov: f64,
        /// `None`: the picture's own.
        aspect: Option<f64>,
        /// Metres, positive.
        znear: f64,
        /// Clips when given; the projection itself has no far plane.
        zfar: Option<f64>,
    },
    /// Half width and half height in metres.
    Orthographic {
        /// Half width; negative mirrors.
        xmag: f64,
        /// Half height.
        ymag: f64,
        /// May be 0 or negative.
        znear: f64,
        /// Greater than `znear`.
        zfar: f64,
    },
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            model: None,
            height: None,
        }
    }
}

/// Axis-aligned box in world space, metres; empty when `min > max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
}

impl Bounds {
    /// Contains nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Grows to contain `point`.
    pub fn include(&mut self, point: DVec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// True where no point was included.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Middle of the box.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }
}

impl Scene {
    /// Box around every triangle's vertices, in world space.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for instance in &self.instances {
            for position in &self.meshes[instance.mesh].positions {
                let local = DVec3::new(position[0] as f64, position[1] as f64, position[2] as f64);
                bounds.include(instance.object_to_world.transform_point3(local));
            }
        }
        bounds
    }

    /// Triangles over all instances.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|instance| self.meshes[instance.mesh].indices.len() / 3).sum()
    }

    /// Checks every index and every number; the error names what and where. Loaders and builders call it last.
    pub fn validate(&self) -> Result<()> {
        validate::scene(self)
    }

    /// 64-bit FNV-1a hash of everything that can change the picture, as 16 hexadecimal digits.
    pub fn fingerprint(&self) -> String {
        fingerprint::scene(self)
    }

    /// The same of what light meets alone: lights and cameras may differ.
    pub fn surface_fingerprint(&self) -> String {
        fingerprint::surfaces(self)
    }
}

pub mod builtin;
pub mod gltf;
pub mod lighting;
pub mod mips;
pub mod mutate;
pub mod overrides;
pub mod scatter;
pub mod shading;
pub mod view;
pub mod write;

mod fingerprint;
mod validate;
