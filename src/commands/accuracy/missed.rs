//! The picture that explains why rectangles come from tangents: what the textbook's rectangles lose beside the eye, in green.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::judge::radiance;
use crate::error::Result;
use crate::lists;
use crate::measure::exposure::{self, Tonemap};
use crate::measure::{file, views};
use crate::plan::{CameraChoice, CullTest, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{builtin, scatter};

const LIGHTS: usize = 256;
const SEED: u64 = 1;

/// Metres.
const RANGE: f64 = 2.0;

const SIZE: [u32; 2] = [480, 270];

/// One of the lights lies 2.16 m below this eye and 0.8 mm ahead of it.
fn request(cull: CullTest) -> Request {
    let rules = LightRules { range: RangeRule::Fixed(RANGE), ..LightRules::default() };
    let camera = CameraChoice::LookAt(DVec3::new(1.0, 1.45, -1.463), DVec3::new(1.0, 1.45, -2.0), FRAC_PI_2);
    let [width, height] = SIZE;
    Request { width, height, technique: Technique::TiledForward, cull, rules, camera, ..Request::default() }
}

/// A picture for each of the two tests, with what it shows.
///
/// # Errors
/// A lost device.
pub(super) fn pictures(renderer: &Renderer) -> Result<Vec<(String, Vec<u8>)>> {
    let mut scene = builtin::load("furnace")?;
    scene.lights = scatter::point_lights(&scene.bounds(), LIGHTS, SEED);
    let mut pictures = Vec::new();
    for cull in [CullTest::BoundsTextbook, CullTest::Bounds] {
        let plan = Plan::new(&scene, &request(cull), &renderer.limits())?;
        let mut prepared = renderer.prepare(&scene, &plan)?;
        prepared.draw(1)?;
        let picture = prepared.read_back()?;
        drop(prepared);
        let counts = lists::make(renderer, &scene, &plan)?.judge(&plan);
        let missed: Vec<f32> = counts.missed_of_sample.iter().map(|&missed| missed as f32).collect();
        let lit = radiance(&picture)?;
        let bytes = exposure::display(lit, exposure::automatic_ev(lit), Tonemap::Neutral);
        let (rows, height) = views::missed(&bytes, &missed).with_legend(SIZE[0])?;
        let pixels = missed.iter().filter(|missed| **missed > 0.0).count();
        let caption = format!(
            "--cull {}: {pixels} of {} pixels miss a light. builtin:furnace, {LIGHTS} lights of {RANGE} m, one of them beside the eye.",
            cull.name(),
            missed.len()
        );
        pictures.push((caption, file::png([SIZE[0], height], &rows)?));
    }
    Ok(pictures)
}
