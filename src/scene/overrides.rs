//! Effects forced on a scene that does not call for them, with input that changes nothing, or taken from one that does. The result is a
//! scene like any other: what is forbidden leaves no trace behind it.

use glam::{DMat4, DQuat, DVec3, Vec3};

use super::shading::{Model, OwnModel};
use super::{AlphaMode, Height, IDENTITY_UV, Image, Instance, Material, Mesh, Sampler, Scene, Texture};

/// Effects that materials call for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaterialEffect {
    /// Blended surfaces.
    Transparency,
    /// Holes by alpha.
    AlphaMask,
    /// Bent normals.
    NormalMaps,
    /// Depth below the surface.
    Parallax,
    /// Shading models of materials.
    MaterialModels,
}

impl Scene {
    /// Takes the effect away from every material; how many had it.
    pub fn forbid(&mut self, effect: MaterialEffect) -> usize {
        let mut count = 0;
        for material in &mut self.materials {
            let had = match effect {
                MaterialEffect::Transparency => take_alpha(&mut material.alpha, |mode| mode == AlphaMode::Blend),
                MaterialEffect::AlphaMask => take_alpha(&mut material.alpha, |mode| matches!(mode, AlphaMode::Mask(_))),
                MaterialEffect::NormalMaps => material.normal_texture.take().is_some(),
                MaterialEffect::Parallax => material.height.take().is_some(),
                MaterialEffect::MaterialModels => material.model.take().is_some(),
            };
            count += usize::from(had);
        }
        count
    }

    /// Gives every material that lacks it the effect with neutral input: a mask that nothing falls through, a normal map of scale 0, a height
    /// map of no depth, `default` as its own model. Of blended surfaces one is added that covers nothing: a pane of alpha 0 across the scene.
    /// How many materials got it, or came with it.
    pub fn force(&mut self, effect: MaterialEffect, default: Model) -> usize {
        let before = self.materials.clone();
        match effect {
            MaterialEffect::Transparency => {
                self.add_clear_pane();
                return 1;
            }
            MaterialEffect::AlphaMask => {
                let opaque = self.materials.iter_mut().filter(|material| material.alpha == AlphaMode::Opaque);
                opaque.for_each(|material| material.alpha = AlphaMode::Mask(0.0));
            }
            MaterialEffect::NormalMaps => {
                let texture = self.flat_texture([128, 128, 255, 255]);
                self.give_frames();
                for material in self.materials.iter_mut().filter(|material| material.normal_texture.is_none()) {
                    (material.normal_texture, material.normal_scale) = (Some(texture.clone()), 0.0);
                }
            }
            MaterialEffect::Parallax => {
                let texture = self.flat_texture([255; 4]);
                self.give_frames();
                for material in self.materials.iter_mut().filter(|material| material.height.is_none()) {
                    material.height = Some(Height { texture: texture.clone(), channel: 0, scale: 0.0 });
                }
            }
            MaterialEffect::MaterialModels => {
                let without = self.materials.iter_mut().filter(|material| material.model.is_none());
                without.for_each(|material| material.model = Some(OwnModel::of(default)));
            }
        }
        let changed = |(a, b): (&super::Material, &super::Material)| {
            a.alpha != b.alpha || a.normal_texture != b.normal_texture || a.height != b.height || a.model != b.model
        };
        before.iter().zip(&self.materials).filter(|&pair| changed(pair)).count()
    }

    fn add_clear_pane(&mut self) {
        let bounds = self.bounds();
        let (center, half) = if bounds.is_empty() {
            (DVec3::ZERO, DVec3::ONE)
        } else {
            (bounds.center(), (bounds.max - bounds.min) * 0.5)
        };
        self.materials.push(Material {
            name: "clear".into(),
            base_color: [1.0, 1.0, 1.0, 0.0],
            metallic: 0.0,
            alpha: AlphaMode::Blend,
            double_sided: true,
            ..Material::default()
        });
        self.meshes.push(Mesh {
            name: "clear pane".into(),
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            material: self.materials.len() - 1,
            ..Mesh::default()
        });
        let size = DVec3::new(half.x.max(1e-3), half.y.max(1e-3), 1.0);
        let object_to_world = DMat4::from_scale_rotation_translation(size, DQuat::IDENTITY, center);
        self.instances.push(Instance { mesh: self.meshes.len() - 1, object_to_world });
    }

    fn flat_texture(&mut self, texel: [u8; 4]) -> Texture {
        self.images.push(Image { name: "neutral".into(), width: 1, height: 1, rgba8: texel.to_vec() });
        let sampler = Sampler { mipmapped: false, mip_linear: false, ..Sampler::default() };
        Texture { image: self.images.len() - 1, sampler, uv_set: 0, uv_transform: IDENTITY_UV }
    }

    /// Coordinates and tangents for meshes without: any do where nothing hangs on them.
    fn give_frames(&mut self) {
        for mesh in &mut self.meshes {
            let count = mesh.positions.len();
            if mesh.uvs[0].is_empty() {
                mesh.uvs[0] = vec![[0.0; 2]; count];
            }
            if mesh.tangents.is_empty() {
                mesh.tangents = tangents(mesh);
            }
        }
    }
}

fn take_alpha(mode: &mut AlphaMode, is: impl Fn(AlphaMode) -> bool) -> bool {
    let had = is(*mode);
    if had {
        *mode = AlphaMode::Opaque;
    }
    had
}

fn tangents(mesh: &Mesh) -> Vec<[f32; 4]> {
    let across = |normal: &[f32; 3]| Vec3::from_array(*normal).any_orthonormal_vector().extend(1.0).to_array();
    mesh.normals.iter().map(across).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    const ALL: [MaterialEffect; 5] = [
        MaterialEffect::Transparency,
        MaterialEffect::AlphaMask,
        MaterialEffect::NormalMaps,
        MaterialEffect::Parallax,
        MaterialEffect::MaterialModels,
    ];

    #[test]
    fn what_is_forced_and_then_forbidden_is_gone() {
        for effect in ALL {
            let mut scene = builtin::load("cornell").expect("a built-in scene");
            assert_eq!(scene.forbid(effect), 0);
            let forced = scene.force(effect, Model::Gltf);
            assert!(forced > 0, "{effect:?}");
            scene.validate().expect("a good scene");
            assert_eq!(scene.forbid(effect), forced);
        }
        let mut glass = builtin::load("glass:layers=2").expect("a built-in scene");
        assert_eq!(glass.forbid(MaterialEffect::Transparency), 3);
        assert!(glass.materials.iter().all(|material| material.alpha == AlphaMode::Opaque));
    }
}
