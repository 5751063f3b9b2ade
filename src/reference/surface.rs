//! What a ray finds on a triangle: position, normal and material values in view space and f64.
//!
//! Rules that the shaders share:
//! - The normal is interpolated, then multiplied by [`Placement::normal_to_view`]. Where the squared length is under
//!   1e-12 after that, the geometric normal takes its place.
//! - The tangent is made orthogonal to that normal; where nothing remains (1e-12 of its squared length), or the mesh
//!   has no tangents, the normal map is ignored. The bitangent is `w * cross(n, t)`, times -1 in a mirrored instance,
//!   because a mirror turns a cross product round.
//! - Parallax mapping (T. Welsh, "Parallax Mapping with Offset Limiting", 2004) shifts the coordinates of the height map's set by the
//!   part of the view direction along the surface times a depth, which [`crate::shared::PARALLAX_STEPS`] steps find; not where
//!   there is no tangent frame, or where the interpolated normal points away from the viewer.
//! - On a back face the mapped normal is reversed whole (glTF 2.0, section 3.9.6): tangent, bitangent and map are those of
//!   the front face.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::texture::{Encoding, Footprint, Textures};
use crate::scene::shading::OwnModel;
use crate::scene::{Material, Mesh, Texture};
use crate::shared::{PARALLAX_STEP, PARALLAX_STEPS};

/// Least perceptual roughness: below it a highlight is narrower than a pixel ever shows.
pub const MIN_ROUGHNESS: f64 = crate::shared::MIN_ROUGHNESS as f64;

/// Squared length, relative to what it is a part of, under which a direction counts as absent.
const ABSENT: f64 = 1e-12;

/// All that shading needs to know about a point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surface {
    /// View space, metres.
    pub position: DVec3,
    /// View space, unit length, after the normal map.
    pub normal: DVec3,
    /// Linear RGB.
    pub base_color: DVec3,
    /// Alpha of the base colour; coverage is 1 all the same.
    pub alpha: f64,
    /// 0 to 1.
    pub metallic: f64,
    /// [`MIN_ROUGHNESS`] to 1.
    pub roughness: f64,
    /// Multiplies ambient light.
    pub occlusion: f64,
    /// Linear RGB radiance, nits.
    pub emissive: DVec3,
    /// The base colour is the picture.
    pub unlit: bool,
    /// The material's own shading model.
    pub model: Option<OwnModel>,
}

/// An instance's transforms into view space.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// `world_to_view * object_to_world`, multiplied in f64.
    pub object_to_view: DMat4,
    /// The cofactor matrix times the sign of the determinant, which has the direction of the inverse transpose;
    /// divided by the length of its longest column, so that a small or large instance does not make normals vanish.
    pub normal_to_view: DMat3,
    /// The determinant is negative: the front is wound clockwise.
    pub mirrored: bool,
}

impl Placement {
    /// From the instance's and the camera's transform.
    pub fn new(object_to_world: &DMat4, world_to_view: &DMat4) -> Self {
        let object_to_view = *world_to_view * *object_to_world;
        let m = DMat3::from_mat4(object_to_view);
        let mirrored = DMat3::from_mat4(*object_to_world).determinant() < 0.0;
        let columns = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
        let longest = columns.iter().fold(0.0f64, |longest, column| longest.max(column.length()));
        let scale = if longest > 0.0 { 1.0 / longest } else { 0.0 };
        let [x, y, z] = columns.map(|column| column * if mirrored { -scale } else { scale });
        Self { object_to_view, normal_to_view: DMat3::from_cols(x, y, z), mirrored }
    }
}

/// Barycentric weights at a pixel's centre, and their fine differences to the neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// At the centre.
    pub at: DVec3,
    /// Along the row.
    pub dx: DVec3,
    /// Down the column.
    pub dy: DVec3,
}

/// Which side of a triangle is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Geometric normal of the front, view space, unit length.
    pub front: DVec3,
    /// The ray comes from behind.
    pub back: bool,
}

impl Face {
    /// The front is where the corners run counter-clockwise, or clockwise in a mirrored instance.
    pub fn new(corners: &[DVec3; 3], mirrored: bool, direction: DVec3) -> Self {
        let wound = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let front = if mirrored { -wound } else { wound };
        Self { front, back: front.dot(direction) > 0.0 }
    }
}

/// A point on a triangle, before its material is evaluated.
#[derive(Clone, Copy)]
pub struct Fragment<'a> {
    /// The triangle's mesh.
    pub mesh: &'a Mesh,
    /// The mesh's material.
    pub material: &'a Material,
    /// Where the mesh stands.
    pub placement: &'a Placement,
    /// Of the scene.
    pub textures: &'a Textures,
    /// Indices of the corners.
    pub vertices: [usize; 3],
    /// Where on the triangle.
    pub weights: Weights,
    /// Which side is seen.
    pub face: Face,
    /// Unit direction to the viewer, view space.
    pub to_viewer: DVec3,
}

impl Fragment<'_> {
    /// Base colour and alpha: factor times texture times vertex colour.
    pub fn base(&self) -> DVec4 {
        self.base_at(self.parallax_shift())
    }

    /// The same where no eye looks at the height map.
    pub fn unshifted_base(&self) -> DVec4 {
        self.base_at(DVec2::ZERO)
    }

    fn base_at(&self, shift: DVec2) -> DVec4 {
        let factor = DVec4::from_array(self.material.base_color.map(f64::from));
        let color = if self.mesh.colors.is_empty() { DVec4::ONE } else { self.blend(&self.mesh.colors).into() };
        factor * self.texel(self.material.base_color_texture.as_ref(), Encoding::Srgb, shift) * color
    }

    /// Evaluates the material.
    pub fn surface(&self, position: DVec3) -> Surface {
        let material = self.material;
        let shift = self.parallax_shift();
        let base = self.base_at(shift);
        let rough_metal = self.texel(material.metallic_roughness_texture.as_ref(), Encoding::Linear, shift);
        let occlusion = self.texel(material.occlusion_texture.as_ref(), Encoding::Linear, shift).x;
        let emissive = self.texel(material.emissive_texture.as_ref(), Encoding::Srgb, shift).truncate();
        Surface {
            position,
            normal: self.normal(shift),
            base_color: base.truncate(),
            alpha: base.w,
            metallic: (f64::from(material.metallic) * rough_metal.z).clamp(0.0, 1.0),
            roughness: (f64::from(material.roughness) * rough_metal.y).clamp(MIN_ROUGHNESS, 1.0),
            occlusion: 1.0 + f64::from(material.occlusion_strength) * (occlusion - 1.0),
            emissive: DVec3::from_array(material.emissive.map(f64::from)) * emissive,
            unlit: material.unlit,
            model: material.model,
        }
    }

    /// Interpolated, of the front.
    fn front_normal(&self) -> DVec3 {
        let interpolated = self.placement.normal_to_view * DVec3::from_array(self.blend(&self.mesh.normals));
        if interpolated.length_squared() < ABSENT { self.face.front } else { interpolated.normalize() }
    }

    fn normal(&self, shift: DVec2) -> DVec3 {
        let front = self.front_normal();
        let mapped = self.mapped_normal(front, shift).unwrap_or(front);
        // glTF 2.0, section 3.9.6 (double sided): a back face reverses its normal before lighting.
        if self.face.back { -mapped } else { mapped }
    }

    /// Tangent and bitangent; `None` where the mesh has none or nothing is left beside the normal.
    fn frame(&self, front: DVec3) -> Option<[DVec3; 2]> {
        if self.mesh.tangents.is_empty() {
            return None;
        }
        let [x, y, z, w] = self.blend(&self.mesh.tangents);
        let along = self.placement.object_to_view.transform_vector3(DVec3::new(x, y, z));
        let tangent = along - front * front.dot(along);
        if tangent.length_squared() <= ABSENT * along.length_squared() {
            return None;
        }
        let tangent = tangent.normalize();
        let sign = if self.placement.mirrored { -w } else { w };
        Some([tangent, front.cross(tangent) * sign])
    }

    /// The normal map's normal, or `None` where there is no map or no tangent frame.
    fn mapped_normal(&self, front: DVec3, shift: DVec2) -> Option<DVec3> {
        let texture = self.material.normal_texture.as_ref()?;
        let [tangent, bitangent] = self.frame(front)?;
        let scale = f64::from(self.material.normal_scale);
        let texel = self.texel(Some(texture), Encoding::Linear, shift).truncate();
        let map = (texel * 2.0 - 1.0) * DVec3::new(scale, scale, 1.0);
        (tangent * map.x + bitangent * map.y + front * map.z).try_normalize()
    }

    /// What parallax mapping adds to the coordinates of the height map's set.
    fn parallax_shift(&self) -> DVec2 {
        let Some(height) = &self.material.height else { return DVec2::ZERO };
        let front = self.front_normal();
        let seen = if self.face.back { -front } else { front };
        let Some([tangent, bitangent]) = self.frame(front).filter(|_| self.to_viewer.dot(seen) > 0.0) else {
            return DVec2::ZERO;
        };
        // v points down the picture, the bitangent up.
        let across = DVec2::new(-self.to_viewer.dot(tangent), self.to_viewer.dot(bitangent));
        let mut depth = 0.0;
        for _ in 0..PARALLAX_STEPS {
            let texel = self.texel(Some(&height.texture), Encoding::Linear, across * depth);
            let target = (1.0 - texel[height.channel]) * f64::from(height.scale);
            depth += (target - depth) * f64::from(PARALLAX_STEP);
        }
        across * depth
    }

    fn texel(&self, texture: Option<&Texture>, encoding: Encoding, shift: DVec2) -> DVec4 {
        let Some(texture) = texture else {
            return DVec4::ONE;
        };
        let corners = match self.mesh.uvs.get(texture.uv_set) {
            Some(uvs) if !uvs.is_empty() => self.vertices.map(|v| DVec2::from_array(uvs[v].map(f64::from))),
            _ => [DVec2::ZERO; 3],
        };
        let shifted = self.material.height.as_ref().is_some_and(|height| height.texture.uv_set == texture.uv_set);
        let blend = |w: DVec3| corners[0] * w.x + corners[1] * w.y + corners[2] * w.z;
        let Weights { at, dx, dy } = self.weights;
        let uv = blend(at) + if shifted { shift } else { DVec2::ZERO };
        self.textures.sample(texture, encoding, &Footprint { uv, dx: blend(dx), dy: blend(dy) })
    }

    fn blend<const N: usize>(&self, values: &[[f32; N]]) -> [f64; N] {
        let [a, b, c] = self.vertices.map(|v| values[v].map(f64::from));
        let w = self.weights.at;
        std::array::from_fn(|i| a[i] * w.x + b[i] * w.y + c[i] * w.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{IDENTITY_UV, Image, Sampler, Scene};

    /// A triangle in the plane z = 0, seen from +z, with a normal map of one texel.
    fn scene(normal_texel: [u8; 3]) -> Scene {
        let [r, g, b] = normal_texel;
        let image = Image { name: "normal".into(), width: 1, height: 1, rgba8: vec![r, g, b, 255] };
        let texture = Texture { image: 0, sampler: Sampler::default(), uv_set: 0, uv_transform: IDENTITY_UV };
        let mesh = Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            tangents: vec![[1.0, 0.0, 0.0, -1.0]; 3],
            indices: vec![0, 1, 2],
            ..Mesh::default()
        };
        let material = Material { normal_texture: Some(texture), ..Material::default() };
        Scene { meshes: vec![mesh], materials: vec![material], images: vec![image], ..Scene::default() }
    }

    fn normal(scene: &Scene, placement: &Placement, face: Face) -> DVec3 {
        let textures = Textures::new(scene).expect("a good image");
        let at = DVec3::new(0.25, 0.25, 0.5);
        let fragment = Fragment {
            mesh: &scene.meshes[0],
            material: &scene.materials[0],
            placement,
            textures: &textures,
            vertices: [0, 1, 2],
            weights: Weights { at, dx: DVec3::ZERO, dy: DVec3::ZERO },
            face,
            to_viewer: DVec3::Z,
        };
        fragment.surface(DVec3::ZERO).normal
    }

    fn placed(object_to_world: DMat4) -> Placement {
        Placement::new(&object_to_world, &DMat4::from_rotation_y(0.4))
    }

    const SEEN: Face = Face { front: DVec3::Z, back: false };

    #[test]
    fn normals_follow_the_inverse_transpose_at_every_scale() {
        let m = DMat4::from_rotation_x(0.7) * DMat4::from_scale(DVec3::new(2.0, 0.5, -3.0));
        for scale in [1e-5, 1.0, 1e5] {
            let placement = placed(m * DMat4::from_scale(DVec3::splat(scale)));
            assert!(placement.mirrored);
            let inverse_transpose = DMat3::from_mat4(placement.object_to_view).inverse().transpose();
            for normal in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.3, -0.8, 0.5)] {
                let found = (placement.normal_to_view * normal).normalize();
                assert!((found - (inverse_transpose * normal).normalize()).length() < 1e-12, "{normal}");
            }
        }
    }

    #[test]
    fn the_tangent_frame_is_the_transformed_frame() {
        // Object space: t = +x, b = -cross(n, t) = -y, n = +z. The texels point along t, along b, along n.
        let axes = [([255, 128, 128], DVec3::X), ([128, 255, 128], DVec3::NEG_Y), ([128, 128, 255], DVec3::Z)];
        let turn = DMat4::from_rotation_x(0.7);
        for m in [turn, turn * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)), -2.0 * turn] {
            let object_to_world = DMat4::from_mat3(DMat3::from_mat4(m));
            let placement = placed(object_to_world);
            for (texel, axis) in axes {
                let expected = placement.object_to_view.transform_vector3(axis).normalize();
                let found = normal(&scene(texel), &placement, SEEN);
                // A byte of 128 means 1/255, not 0.
                assert!((found - expected).length() < 0.01, "{texel:?}: {found} against {expected}");
            }
        }
    }

    #[test]
    fn a_back_face_reverses_the_mapped_normal() {
        let placement = Placement::new(&DMat4::IDENTITY, &DMat4::IDENTITY);
        let scene = scene([200, 60, 220]);
        let front = normal(&scene, &placement, SEEN);
        let back = normal(&scene, &placement, Face { back: true, ..SEEN });
        assert!(front.x > 0.1 && front.y > 0.1 && front.z > 0.1);
        assert!((back + front).length() < 1e-15);
    }

    #[test]
    fn missing_frames_fall_back() {
        let placement = Placement::new(&DMat4::IDENTITY, &DMat4::IDENTITY);
        let mapped = scene([255, 128, 128]);
        assert!(normal(&mapped, &placement, SEEN).x > 0.9);
        let mut parallel = mapped.clone();
        parallel.meshes[0].tangents = vec![[0.0, 0.0, 1.0, 1.0]; 3];
        let mut zero = mapped.clone();
        zero.meshes[0].tangents = vec![[0.0, 0.0, 0.0, 1.0]; 3];
        let mut none = mapped.clone();
        none.meshes[0].tangents.clear();
        for scene in [parallel, zero, none] {
            assert_eq!(normal(&scene, &placement, SEEN), DVec3::Z);
        }
        let mut no_normal = mapped;
        no_normal.materials[0].normal_texture = None;
        no_normal.meshes[0].normals = vec![[0.0; 3]; 3];
        let face = Face { front: DVec3::new(0.6, 0.0, 0.8), back: true };
        assert_eq!(normal(&no_normal, &placement, face), -face.front);
    }

    #[test]
    fn a_mirror_turns_the_winding() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(Face::new(&corners, false, DVec3::NEG_Z), SEEN);
        assert_eq!(Face::new(&corners, true, DVec3::NEG_Z), Face { front: DVec3::NEG_Z, back: true });
        assert_eq!(Face::new(&corners, false, DVec3::Z), Face { back: true, ..SEEN });
    }

    #[test]
    fn factors_and_texels_multiply() {
        let mut scene = scene([0, 51, 102]);
        let texture = scene.materials[0].normal_texture.take();
        let material = &mut scene.materials[0];
        material.metallic_roughness_texture = texture.clone();
        material.occlusion_texture = texture;
        (material.metallic, material.roughness, material.occlusion_strength) = (0.5, 0.5, 0.25);
        (material.base_color, material.emissive) = ([0.5, 0.25, 1.0, 0.75], [3.0, 2.0, 1.0]);
        scene.meshes[0].colors = vec![[0.5, 1.0, 1.0, 1.0], [0.5, 1.0, 1.0, 1.0], [1.0, 1.0, 0.0, 1.0]];
        let textures = Textures::new(&scene).expect("a good image");
        let placement = placed(DMat4::IDENTITY);
        let at = DVec3::new(0.25, 0.25, 0.5);
        let fragment = Fragment {
            mesh: &scene.meshes[0],
            material: &scene.materials[0],
            placement: &placement,
            textures: &textures,
            vertices: [0, 1, 2],
            weights: Weights { at, dx: DVec3::ZERO, dy: DVec3::ZERO },
            face: SEEN,
            to_viewer: DVec3::Z,
        };
        let surface = fragment.surface(DVec3::NEG_Z);
        assert_eq!((surface.base_color, surface.alpha), (DVec3::new(0.375, 0.25, 0.5), 0.75));
        assert!((surface.metallic - 0.2).abs() < 1e-15 && (surface.roughness - 0.1).abs() < 1e-15);
        assert!((surface.occlusion - 0.75).abs() < 1e-15);
        assert_eq!(surface.emissive, DVec3::new(3.0, 2.0, 1.0));
    }
}
