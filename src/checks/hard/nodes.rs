//! T9: nodes that mirror, stretch and shear what they place, and cameras on such nodes.

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::fixtures::{looking, plan, point, request, scene, sphere};
use crate::checks::Row;
use crate::checks::oracle::{self, SHADING_BOUND, Shaded, against_rays, picture_bound};
use crate::error::Result;
use crate::plan::Plan;
use crate::reference::surface::Surface;
use crate::renderer::Renderer;
use crate::scene::shading::Shading;
use crate::scene::{Scene, gltf};

/// Metres from the camera to the middle of what it looks at.
const DISTANCE: f64 = 5.0;

/// A node that only a camera stands on; its scale mirrors and stretches.
const SCALED_CAMERA: &str = r#"{"asset":{"version":"2.0"},
    "nodes":[{"camera":0,"scale":[-2,3,0.5],"translation":[0,0,5]}],
    "cameras":[{"type":"perspective","perspective":{"yfov":0.48869219,"znear":0.05}}]}"#;

/// A sphere of `radius` brought to about 1 m by its node, single-sided.
fn placed(radius: f64, object_to_world: DMat4) -> Scene {
    // Close to the line of sight, so that nearly all that is seen is lit.
    let light = point(DVec3::new(0.25, 0.5, 9.0), 50.0);
    let mut scene = scene(sphere(radius), vec![light], looking([0.0, 0.0, DISTANCE], [0.0; 3], 28.0));
    scene.instances[0].object_to_world = object_to_world;
    scene
}

/// True where the middle of the picture shows the near side: a turned winding would show the far side's inside.
fn shows_near_side(plan: &Plan, surfaces: &[Option<Surface>], radius: f64, object_to_world: DMat4) -> bool {
    let (width, height) = (plan.view.width as usize, plan.view.height as usize);
    // The line of sight leaves the ellipsoid where the inverse transform has length `radius`.
    let half_depth = radius / (DMat3::from_mat4(object_to_world).inverse() * DVec3::Z).length();
    let middle = surfaces.get(height / 2 * width + width / 2).and_then(Option::as_ref);
    // Half a pixel beside the middle and the flat facets cost less than 0.1 m; the far side is 1 m away and more.
    middle.is_some_and(|s| (s.position.z + DISTANCE - half_depth).abs() < 0.1)
}

/// Spheres through every kind of node, and a camera on a scaled one.
pub fn node_transforms(renderer: &Renderer) -> Result<Vec<Row>> {
    let scale = |x: f64, y: f64, z: f64| DMat4::from_scale(DVec3::new(x, y, z));
    let turn = DMat4::from_rotation_x(0.7);
    let shear = DMat4::from_cols(DVec4::NEG_X, DVec4::new(0.4, 0.8, 0.0, 0.0), DVec4::Z, DVec4::W);
    let cases = [
        ("mirrored in x", 1.0, scale(-1.0, 1.0, 1.0)),
        ("mirrored in x and y", 1.0, scale(-1.0, -1.0, 1.0)),
        ("mirrored in all", 1.0, scale(-1.0, -1.0, -1.0)),
        ("stretched, mirrored, turned", 1.0, turn * scale(0.7, -1.0, 0.8)),
        ("sheared, mirrored", 1.0, shear),
        ("scaled by 1e-3", 1e3, scale(1e-3, 1e-3, 1e-3)),
        ("scaled by -1e3", 1e-3, scale(-1e3, -1e3, -1e3)),
    ];
    let request = request(Shading::Lambert);
    let mut rows = Vec::new();
    let mut inside_out = 0;
    for (name, radius, object_to_world) in cases {
        let scene = placed(radius, object_to_world);
        let plan = plan(renderer, &scene, &request)?;
        let shaded = Shaded::draw(renderer, &scene, &plan)?;
        let picture = against_rays(&shaded.radiance, &scene, &plan)?.0;
        inside_out += usize::from(!shows_near_side(&plan, &shaded.surfaces, radius, object_to_world));
        rows.push(Row::at_most(format!("T9 {name}, shading"), shaded.error(&oracle::shader(&plan)), SHADING_BOUND));
        rows.push(Row::at_most(format!("T9 {name}, picture"), picture, picture_bound(renderer)));
    }
    rows.push(Row::none("T9 single-sided spheres seen from outside", inside_out, "seen from inside"));
    let straight = placed(1.0, DMat4::IDENTITY);
    let straight_plan = plan(renderer, &straight, &request)?;
    let mut scaled = straight.clone();
    scaled.cameras = gltf::load_slice(SCALED_CAMERA.as_bytes(), None, "scaled-camera.gltf")?.cameras;
    let pixels = oracle::draw(renderer, &scaled, &plan(renderer, &scaled, &request)?)?;
    let picture = against_rays(&pixels, &straight, &straight_plan)?.0;
    rows.push(Row::at_most("T9 camera scaled by -2, 3, 0.5, picture", picture, picture_bound(renderer)));
    Ok(rows)
}
