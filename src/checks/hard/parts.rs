//! Sums over lights that several passes continue (plan/light_parts.rs): the bits of one pass, whatever surfaces and lights there are.

use glam::{DMat4, DVec3};

use super::fixtures::{looking, point, request, scene, sphere, wall};
use crate::checks::Row;
use crate::checks::lists::{differing, radiance_of};
use crate::error::Result;
use crate::plan::{Limits, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::shading::Shading;
use crate::scene::{AlphaMode, Bounds, Instance, Light, LightKind, Material, Scene, scatter};

/// Of which three are directional.
const LIGHTS: usize = 90;

/// A lit wall, in front of it a sphere full of holes and an unlit square, under lights of every kind.
fn fixture() -> Scene {
    let mut scene = scene(wall(4.0), lights(), looking([0.25, 0.5, 5.0], [0.0; 3], 45.0));
    let lit = scene.materials[0].clone();
    scene.materials.push(Material { alpha: AlphaMode::Mask(0.5), double_sided: true, ..lit.clone() });
    scene.materials.push(Material { unlit: true, ..lit });
    let mut holes = sphere(0.8);
    holes.colors.iter_mut().enumerate().for_each(|(index, color)| color[3] = (index % 3) as f32 * 0.5);
    holes.material = 1;
    let mut unlit = wall(0.6);
    unlit.material = 2;
    scene.meshes.extend([holes, unlit]);
    for (mesh, at) in [(1, DVec3::new(-1.0, 0.0, 0.9)), (2, DVec3::new(1.2, 0.3, 1.5))] {
        scene.instances.push(Instance { mesh, object_to_world: DMat4::from_translation(at) });
    }
    scene
}

fn lights() -> Vec<Light> {
    let mut bounds = Bounds::EMPTY;
    bounds.include(DVec3::new(-3.0, -3.0, 0.2));
    bounds.include(DVec3::new(3.0, 3.0, 3.0));
    let mut lights = scatter::point_lights(&bounds, LIGHTS, 1);
    for (index, light) in lights.iter_mut().enumerate() {
        light.direction = (DVec3::new(0.3, -0.2, 0.0) - light.position).normalize();
        light.kind = match index {
            20 | 40 | 60 => LightKind::Directional,
            _ if index % 3 == 0 => LightKind::Spot { inner: 0.2, outer: 0.9 },
            _ => LightKind::Point,
        };
    }
    lights
}

/// As the wall of `radiance_range`, but most of its lights come in a later pass than the first that pass f32.
fn overflowing() -> Scene {
    let near = point(DVec3::new(0.0, 0.0, 0.5), 3e38);
    let lights = [lights(), vec![near; 40], lights()].concat();
    let mut scene = scene(wall(4.0), lights, looking([0.25, 0.5, 3.0], [0.0; 3], 45.0));
    scene.materials[0].base_color = [0.0, 0.5, 1.0, 1.0];
    scene
}

/// A picture in one pass and in as many as a driver needs that leaves its loops after `most` iterations.
fn row(renderer: &Renderer, name: &str, scene: &Scene, request: &Request, (most, passes): (u32, u32)) -> Result<Row> {
    let whole = Plan::new(scene, request, &renderer.limits())?;
    let parted = Plan::new(scene, request, &Limits { max_loop_iterations: most, ..renderer.limits() })?;
    let count = parted.light_parts.count;
    let off = differing(&radiance_of(renderer, scene, &whole)?, &radiance_of(renderer, scene, &parted)?);
    Ok(Row {
        name: format!("{name} in {passes} parts = in one"),
        passed: off == 0 && whole.light_parts.count == 1 && count == passes,
        detail: format!("{off} differing pixels, {count} passes"),
    })
}

/// Every forward technique in parts, with and without a pre-pass, and sums that pass f32.
pub fn light_parts(renderer: &Renderer) -> Result<Vec<Row>> {
    let of = |technique, range| {
        let rules = LightRules { range, ..LightRules::default() };
        Request { technique, rules, ..request(Shading::Gltf) }
    };
    // A group of 32 lights takes 68 iterations of the loop that seeks. Lights of a long range are in every list; the directional ones
    // among them come before it.
    let seeking = of(Technique::Forward, RangeRule::Fixed(3.0));
    let plain = of(Technique::Forward, RangeRule::Infinite);
    let tiled = of(Technique::TiledForward, RangeRule::Fixed(50.0));
    let clustered = of(Technique::ClusteredForward, RangeRule::Fixed(50.0));
    let hidden = Request { prepass: false, ..seeking.clone() };
    let cases = [
        ("forward", seeking, (70, 3)),
        ("forward without ranges", plain.clone(), (30, 3)),
        ("forward without a pre-pass", hidden, (70, 3)),
        ("tiled-forward", tiled, (35, 3)),
        ("clustered-forward", clustered, (87, 2)),
    ];
    let scene = fixture();
    let mut rows = Vec::new();
    for (name, request, loops) in cases {
        rows.push(row(renderer, name, &scene, &request, loops)?);
    }
    let request = Request { shading: Shading::Lambert, ..plain };
    rows.push(row(renderer, "radiance past f32", &overflowing(), &request, (55, 4))?);
    Ok(rows)
}
