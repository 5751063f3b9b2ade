//! L4: surfaces whose normal or tangent is no direction, mirrored texture coordinates, back faces.

use glam::DVec3;

use super::fixtures::{flat, looking, plan, point, request, scene, wall};
use crate::checks::Row;
use crate::checks::oracle::{self, SHADING_BOUND, Shaded, against_rays, picture_bound};
use crate::error::Result;
use crate::renderer::Renderer;
use crate::scene::shading::Shading;
use crate::scene::{Camera, IDENTITY_UV, Image, Sampler, Scene, Texture};

/// A wall lit and seen from the side of `z` (1 front, -1 back), both sides drawn.
fn lit_wall(z: f64) -> Scene {
    let light = point(DVec3::new(0.5, 0.5, 4.0 * z), 10.0);
    let mut scene = scene(wall(4.0), vec![light], looking([0.5, 0.25, 3.0 * z], [0.0; 3], 45.0));
    scene.materials[0].double_sided = true;
    scene
}

/// The same with a normal map that leans to one side, and one tangent everywhere.
fn mapped(z: f64, tangent: [f32; 4]) -> Scene {
    let mut scene = lit_wall(z);
    scene.images.push(Image { name: "leaning".into(), width: 1, height: 1, rgba8: vec![200, 60, 220, 255] });
    scene.materials[0].normal_texture =
        Some(Texture { image: 0, sampler: Sampler::default(), uv_set: 0, uv_transform: IDENTITY_UV });
    scene.meshes[0].uvs[0] = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    scene.meshes[0].tangents = vec![tangent; 4];
    scene
}

fn without_normals(mut scene: Scene) -> Scene {
    scene.meshes[0].normals = vec![[0.0; 3]; 4];
    scene
}

fn seen_by(mut scene: Scene, camera: Camera) -> Scene {
    scene.cameras = vec![camera];
    scene
}

/// Nothing is NaN, and every fallback is the reference's.
pub fn surface_fallbacks(renderer: &Renderer) -> Result<Vec<Row>> {
    let along_u = [1.0, 0.0, 0.0, 1.0];
    let mirror = flat([0.5, 0.25, 3.0], [-1.6, 1.2], [0.0, 10.0]);
    let cases = [
        ("zero normal", without_normals(lit_wall(1.0))),
        ("zero normal, back", without_normals(lit_wall(-1.0))),
        ("zero normal, mirrored lens", seen_by(without_normals(lit_wall(1.0)), mirror)),
        ("zero normal, normal map", without_normals(mapped(1.0, along_u))),
        ("zero tangent", mapped(1.0, [0.0, 0.0, 0.0, 1.0])),
        ("tangent along the normal", mapped(1.0, [0.0, 0.0, 1.0, 1.0])),
        ("mirrored coordinates", mapped(1.0, [-1.0, 0.0, 0.0, -1.0])),
        ("back, normal map", mapped(-1.0, along_u)),
    ];
    let mut rows = Vec::new();
    let mut not_finite = 0;
    for (name, scene) in cases {
        let plan = plan(renderer, &scene, &request(Shading::Gltf))?;
        let shaded = Shaded::draw(renderer, &scene, &plan)?;
        not_finite += shaded.not_finite();
        let shading = shaded.error(&oracle::shader(&plan));
        let picture = against_rays(&shaded.radiance, &scene, &plan)?.0;
        rows.push(Row::at_most(format!("L4 {name}, shading"), shading, SHADING_BOUND));
        rows.push(Row::at_most(format!("L4 {name}, picture"), picture, picture_bound(renderer)));
    }
    rows.push(Row::none("L4 pixels are finite", not_finite, "pixels that are not"));
    Ok(rows)
}
