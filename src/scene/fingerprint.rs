//! A hash of everything that can change the picture: two scenes of one fingerprint are taken for the same scene.
//!
//! 64-bit FNV-1a (draft-eastlake-fnv, section 5) over, in this order and each list after its length: images, materials,
//! meshes, instances, lights, cameras; within each, the fields in the order of their declaration. Numbers go in as
//! their little-endian bits. Names and warnings are left out.

use super::{
    AlphaMode, Camera, Image, Instance, Light, LightKind, Material, Mesh, Projection, Sampler, Scene, Texture, Wrap,
};

const OFFSET_BASIS: u64 = 0xCBF2_9CE4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01B3;

struct Fnv(u64);

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(PRIME);
        }
    }

    fn count(&mut self, count: usize) {
        self.bytes(&(count as u64).to_le_bytes());
    }

    fn flag(&mut self, flag: bool) {
        self.bytes(&[flag.into()]);
    }

    fn floats(&mut self, floats: &[f32]) {
        for float in floats {
            self.bytes(&float.to_le_bytes());
        }
    }

    fn doubles(&mut self, doubles: &[f64]) {
        for double in doubles {
            self.bytes(&double.to_le_bytes());
        }
    }

    fn elements<const N: usize>(&mut self, elements: &[[f32; N]]) {
        self.count(elements.len());
        self.floats(elements.as_flattened());
    }

    fn option(&mut self, value: Option<f64>) {
        self.flag(value.is_some());
        self.doubles(&[value.unwrap_or(0.0)]);
    }
}

/// Of what light meets: images, materials, meshes and instances. 16 hexadecimal digits.
pub(super) fn surfaces(scene: &Scene) -> String {
    let mut hash = Fnv(OFFSET_BASIS);
    list(&mut hash, &scene.images, image);
    list(&mut hash, &scene.materials, material);
    list(&mut hash, &scene.meshes, mesh);
    list(&mut hash, &scene.instances, instance);
    format!("{:016x}", hash.0)
}

/// 16 hexadecimal digits.
pub(super) fn scene(scene: &Scene) -> String {
    let mut hash = Fnv(OFFSET_BASIS);
    list(&mut hash, &scene.images, image);
    list(&mut hash, &scene.materials, material);
    list(&mut hash, &scene.meshes, mesh);
    list(&mut hash, &scene.instances, instance);
    list(&mut hash, &scene.lights, light);
    list(&mut hash, &scene.cameras, camera);
    format!("{:016x}", hash.0)
}

fn list<T>(hash: &mut Fnv, items: &[T], item: fn(&mut Fnv, &T)) {
    hash.count(items.len());
    for value in items {
        item(hash, value);
    }
}

fn image(hash: &mut Fnv, image: &Image) {
    hash.bytes(&image.width.to_le_bytes());
    hash.bytes(&image.height.to_le_bytes());
    hash.bytes(&image.rgba8);
}

fn material(hash: &mut Fnv, material: &Material) {
    hash.floats(&material.base_color);
    texture(hash, &material.base_color_texture);
    hash.floats(&[material.metallic, material.roughness]);
    texture(hash, &material.metallic_roughness_texture);
    texture(hash, &material.normal_texture);
    hash.floats(&[material.normal_scale]);
    texture(hash, &material.occlusion_texture);
    hash.floats(&[material.occlusion_strength]);
    hash.floats(&material.emissive);
    texture(hash, &material.emissive_texture);
    let (mode, cutoff) = match material.alpha {
        AlphaMode::Opaque => (0, 0.0),
        AlphaMode::Mask(cutoff) => (1, cutoff),
        AlphaMode::Blend => (2, 0.0),
    };
    hash.bytes(&[mode]);
    hash.floats(&[cutoff]);
    hash.flag(material.double_sided);
    hash.flag(material.unlit);
    // Absent ones leave no trace, so that files without them keep their number.
    if let Some(own) = &material.model {
        hash.bytes(own.model.name().as_bytes());
        hash.floats(&own.color);
        hash.floats(&[own.exponent]);
    }
    if let Some(height) = &material.height {
        texture(hash, &Some(height.texture.clone()));
        hash.count(height.channel);
        hash.floats(&[height.scale]);
    }
}

fn texture(hash: &mut Fnv, texture: &Option<Texture>) {
    hash.flag(texture.is_some());
    let Some(texture) = texture else {
        return;
    };
    hash.count(texture.image);
    let Sampler { wrap_u, wrap_v, mag_linear, min_linear, mipmapped, mip_linear } = texture.sampler;
    for wrap in [wrap_u, wrap_v] {
        hash.bytes(&[match wrap {
            Wrap::Repeat => 0,
            Wrap::MirroredRepeat => 1,
            Wrap::ClampToEdge => 2,
        }]);
    }
    for flag in [mag_linear, min_linear, mipmapped, mip_linear] {
        hash.flag(flag);
    }
    hash.count(texture.uv_set);
    hash.floats(texture.uv_transform.as_flattened());
}

fn mesh(hash: &mut Fnv, mesh: &Mesh) {
    hash.elements(&mesh.positions);
    hash.elements(&mesh.normals);
    hash.elements(&mesh.tangents);
    hash.elements(&mesh.uvs[0]);
    hash.elements(&mesh.uvs[1]);
    hash.elements(&mesh.colors);
    hash.count(mesh.indices.len());
    for index in &mesh.indices {
        hash.bytes(&index.to_le_bytes());
    }
    hash.count(mesh.material);
}

fn instance(hash: &mut Fnv, instance: &Instance) {
    hash.count(instance.mesh);
    hash.doubles(&instance.object_to_world.to_cols_array());
}

fn light(hash: &mut Fnv, light: &Light) {
    let (kind, cone) = match light.kind {
        LightKind::Directional => (0, [0.0; 2]),
        LightKind::Point => (1, [0.0; 2]),
        LightKind::Spot { inner, outer } => (2, [inner, outer]),
    };
    hash.bytes(&[kind]);
    hash.floats(&cone);
    hash.floats(&light.color);
    hash.floats(&[light.intensity]);
    hash.doubles(&light.position.to_array());
    hash.doubles(&light.direction.to_array());
    hash.option(light.range.map(f64::from));
    // Nothing is added where none asks: scenes keep the fingerprints that they had before there were shadows.
    if light.shadow {
        hash.flag(true);
    }
}

fn camera(hash: &mut Fnv, camera: &Camera) {
    hash.doubles(&camera.camera_to_world.to_cols_array());
    match camera.projection {
        Projection::Perspective { yfov, aspect, znear, zfar } => {
            hash.flag(false);
            hash.doubles(&[yfov, znear]);
            hash.option(aspect);
            hash.option(zfar);
        }
        Projection::Orthographic { xmag, ymag, znear, zfar } => {
            hash.flag(true);
            hash.doubles(&[xmag, ymag, znear, zfar]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat4, DVec3};

    #[test]
    fn fnv_of_its_own_draft() {
        for (text, expected) in [("", OFFSET_BASIS), ("a", 0xAF63_DC4C_8601_EC8C), ("foobar", 0x8594_4171_F739_67E8)] {
            let mut hash = Fnv(OFFSET_BASIS);
            hash.bytes(text.as_bytes());
            assert_eq!(hash.0, expected, "{text}");
        }
    }

    #[test]
    fn one_bit_changes_it_and_a_name_does_not() {
        let scene = Scene {
            meshes: vec![Mesh { positions: vec![[0.0; 3]; 3], ..Mesh::default() }],
            materials: vec![Material::default()],
            instances: vec![Instance { mesh: 0, object_to_world: DMat4::IDENTITY }],
            cameras: vec![Camera::looking(DVec3::ONE, DVec3::ZERO, 1.0)],
            ..Scene::default()
        };
        let before = scene.fingerprint();
        assert_eq!(before.len(), 16);
        let mut renamed = scene.clone();
        renamed.name = "x".into();
        renamed.meshes[0].name = "y".into();
        renamed.warnings.push("z".into());
        assert_eq!(renamed.fingerprint(), before);
        type Change = fn(&mut Scene);
        let changes: [Change; 5] = [
            |s| s.meshes[0].positions[2][1] = -0.0,
            |s| s.materials[0].alpha = AlphaMode::Mask(0.0),
            |s| s.instances[0].object_to_world.w_axis.x = 1e-300,
            |s| s.cameras[0].projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0, znear: 0.0, zfar: 1.0 },
            |s| s.meshes.push(Mesh::default()),
        ];
        for (number, change) in changes.into_iter().enumerate() {
            let mut other = scene.clone();
            change(&mut other);
            assert_ne!(other.fingerprint(), before, "change {number}");
        }
    }
}
