//! Scenes in which one light's way is known.

use glam::{DMat4, DVec3};

use crate::checks::hard::fixtures::{looking, point, scene, wall};
use crate::scene::{
    AlphaMode, IDENTITY_UV, Image, Instance, Light, LightKind, Material, Mesh, Sampler, Scene, Texture, builtin,
};

/// A lamp that reaches far.
pub fn lamp(position: DVec3) -> Light {
    Light { range: Some(40.0), ..point(position, 30.0) }
}

/// The furnace with a light in it.
pub fn room_with(light: Light) -> Scene {
    let mut scene = builtin::load("furnace").expect("a built-in scene");
    scene.lights = vec![light];
    scene
}

/// A wall of 4 m under lights of each kind, so many degrees from head on.
pub fn grazed_wall(degrees: f64) -> Vec<(&'static str, Scene)> {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    // Neither along nor across the wall's edges.
    let to_light = DVec3::new(sine * 0.8, sine * 0.6, cosine);
    let camera = || looking([0.3, -0.4, 4.5], [0.0, 0.0, 0.0], 50.0);
    let place = to_light * 6.0;
    let sun = Light { kind: LightKind::Directional, direction: -to_light, ..point(DVec3::ZERO, 2.0) };
    let spot = Light { kind: LightKind::Spot { inner: 0.5, outer: 0.8 }, direction: -to_light, ..lamp(place) };
    [("directional", sun), ("point", lamp(place)), ("spot", spot)]
        .map(|(name, light)| (name, scene(wall(2.0), vec![light], camera())))
        .into()
}

/// Six squares about the origin, of half a metre to a side, seen from outside.
fn block(half: f32) -> Mesh {
    let mut mesh = Mesh { name: "block".into(), material: 1, ..Mesh::default() };
    for axis in 0..3usize {
        for sign in [-1.0f32, 1.0] {
            let first = mesh.positions.len() as u32;
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for [a, b] in [[-1.0f32, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
                let mut position = [0.0; 3];
                (position[axis], position[u], position[v]) = (sign * half, a * half * sign, b * half);
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                mesh.positions.push(position);
                mesh.normals.push(normal);
            }
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
        }
    }
    mesh
}

/// A wall with blocks before it.
fn wall_and_blocks(places: &[[f64; 3]], half: f32, light: Light) -> Scene {
    let mut built = scene(wall(3.0), vec![light], looking([1.5, 2.0, 6.0], [0.0, 0.0, 0.5], 50.0));
    built.materials.push(Material { metallic: 0.0, roughness: 0.6, double_sided: true, ..Material::default() });
    built.meshes.push(block(half));
    for place in places {
        let object_to_world = DMat4::from_translation(DVec3::from_array(*place));
        built.instances.push(Instance { mesh: 1, object_to_world });
    }
    built
}

/// A spot light on three blocks in front of a wall; half angle in radians.
pub fn spot_over_blocks(outer: f64) -> Scene {
    let place = DVec3::new(0.7, 0.9, 4.0);
    let direction = (DVec3::new(-0.2, 0.0, 0.6) - place).normalize();
    let light =
        Light { kind: LightKind::Spot { inner: (outer * 0.9) as f32, outer: outer as f32 }, direction, ..lamp(place) };
    wall_and_blocks(&[[-0.8, 0.2, 0.9], [0.7, -0.6, 0.6], [0.1, 0.9, 1.3]], 0.3, light)
}

/// A lamp in the middle of a block, or so many metres behind it as the wall sees it.
pub fn boxed_lamp(behind: f64) -> Scene {
    wall_and_blocks(&[[0.0, 0.0, 1.5]], 0.5, lamp(DVec3::new(0.0, 0.0, 1.5 + behind)))
}

/// A lamp in the plane of the wall, in the middle of a pixel's surface, beside blocks.
pub fn light_on_wall() -> Scene {
    wall_and_blocks(&[[0.9, 0.4, 0.4], [-0.8, -0.5, 0.5]], 0.3, lamp(DVec3::ZERO))
}

/// A lamp that reaches a thousand kilometres, 3 cm before a small plate which keeps its light from the middle of a wall.
pub fn shaded_lamp() -> Scene {
    let place = DVec3::new(0.0, 0.0, 1.5);
    let light = Light { range: Some(1e6), ..point(place, 30.0) };
    let mut built = wall_and_blocks(&[], 0.3, light);
    built.meshes.push(Mesh { material: 1, ..wall(0.03) });
    let object_to_world = DMat4::from_translation(place - DVec3::Z * 0.03);
    built.instances.push(Instance { mesh: built.meshes.len() - 1, object_to_world });
    built
}

/// Before a wall a panel whose mask has holes, which light goes through, and a pane that is mixed with what lies behind, which stands in no light's way.
pub fn mask_and_pane() -> Scene {
    let mut built =
        scene(wall(3.0), vec![lamp(DVec3::new(0.4, 0.7, 4.0))], looking([1.5, 2.0, 6.0], [0.0, 0.0, 0.5], 50.0));
    // Holes of 8 texels; coarse levels of its mip chain have neither holes nor cloth.
    let alpha = |texel: u32| if (texel % 32 / 8 + texel / 256).is_multiple_of(2) { 255 } else { 0 };
    let rgba8 = (0..1024).flat_map(|texel| [255, 255, 255, alpha(texel)]).collect();
    built.images = vec![Image { name: "holes".into(), width: 32, height: 32, rgba8 }];
    let sampler = Sampler { mag_linear: false, min_linear: false, mip_linear: false, ..Sampler::default() };
    let holes = Texture { image: 0, sampler, uv_set: 0, uv_transform: IDENTITY_UV };
    let plain = Material { metallic: 0.0, roughness: 0.6, ..Material::default() };
    built.materials.push(Material {
        base_color_texture: Some(holes),
        alpha: AlphaMode::Mask(0.5),
        double_sided: true,
        ..plain.clone()
    });
    built.materials.push(Material {
        base_color: [0.3, 0.5, 0.9, 0.3],
        alpha: AlphaMode::Blend,
        double_sided: true,
        ..plain
    });
    let square = |material: usize| Mesh {
        material,
        uvs: [vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], Vec::new()],
        ..wall(0.7)
    };
    for (material, place) in [(1, DVec3::new(-0.7, 0.1, 1.2)), (2, DVec3::new(0.9, -0.2, 1.0))] {
        built.meshes.push(square(material));
        let object_to_world = DMat4::from_translation(place);
        built.instances.push(Instance { mesh: built.meshes.len() - 1, object_to_world });
    }
    built
}
