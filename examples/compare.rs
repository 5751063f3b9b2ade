//! One picture made twice, drawn on the Vulkan device and traced on the CPU in f64, and how far the two are apart.
//!
//! ```sh
//! cargo run --release --example compare [FOLDER]
//! ```
//!
//! writes `device.png` and `reference.png` to FOLDER (the current one where none is given) and prints, with names and
//! figures in place of the capitals:
//!
//! ```text
//! scene      builtin:cornell, 248 triangles
//! device     NAME (DRIVER)
//!   depth_prepass           T ms
//!   forward                 T ms
//! reference  traced in T s
//! picture    mean relative error E, largest E, rmse E over 57600 pixels
//! surfaces   mean relative error E, largest E, rmse E over N pixels
//! ```
//!
//! `surfaces` leaves out pixels with an edge in their 3x3 neighbourhood: there a rasteriser, which snaps vertices to a
//! grid, and a ray may see different triangles. Without a device the second line says why there is none, and only
//! `reference.png` is made.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use lampyris::gpu::Options;
use lampyris::measure::exposure::{self, Tonemap};
use lampyris::measure::file;
use lampyris::measure::metrics::{self, Difference};
use lampyris::plan::{Limits, Plan, Request, Technique};
use lampyris::reference::render::Reference;
use lampyris::reference::shade::Shader;
use lampyris::renderer::Renderer;
use lampyris::scene::{Scene, builtin};
use lampyris::{Error, Result};

/// Pixels.
const SIZE: [u32; 2] = [320, 180];
/// The last of them is read back; the passes' medians are over all.
const FRAMES: usize = 3;

fn main() -> ExitCode {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("."), PathBuf::from);
    match run(&folder) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("compare: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(folder: &Path) -> Result<()> {
    let [device_png, reference_png] = ["device.png", "reference.png"].map(|name| folder.join(name));
    file::check_place(&device_png)?;
    file::check_place(&reference_png)?;
    let scene = builtin::load("cornell")?;
    let device = Renderer::new(&Options::default());
    let limits = device.as_ref().map_or(Limits::MINIMUM, Renderer::limits);
    let request = Request { width: SIZE[0], height: SIZE[1], technique: Technique::Forward, ..Request::default() };
    let plan = Plan::new(&scene, &request, &limits)?;
    println!("scene      {}, {} triangles", scene.name, scene.triangle_count());
    let drawn = match &device {
        Ok(renderer) => Some(draw(renderer, &scene, &plan)?),
        Err(why) => {
            println!("device     none, so there is nothing to compare: {why}");
            None
        }
    };

    let start = Instant::now();
    let shader = Shader::new(&plan.lighting, &plan.view, plan.shading);
    let traced = Reference::new(&scene, &plan.view)?.render(&shader, &|_rows_done| ());
    println!("reference  traced in {:.2} s", start.elapsed().as_secs_f64());

    let narrow: Vec<[f32; 4]> = traced.rgba.iter().map(|pixel| pixel.map(|channel| channel as f32)).collect();
    // One exposure for both: two automatic ones would hide a difference in brightness.
    let ev = exposure::automatic_ev(&narrow);
    let png = |place: &Path, pixels: &[[f32; 4]]| {
        file::write_png(place, SIZE, &exposure::display(pixels, ev, Tonemap::Neutral), &[])
    };
    png(&reference_png, &narrow)?;
    let Some(drawn) = drawn else { return Ok(()) };
    png(&device_png, &drawn)?;

    let drawn = metrics::widen(&drawn);
    let surfaces = metrics::interior_mask(&traced.surface_id, traced.width, traced.height);
    say("picture", &metrics::compare(&traced.rgba, &drawn));
    say("surfaces", &metrics::compare_masked(&traced.rgba, &drawn, &surfaces));
    Ok(())
}

/// Draws the frames, prints what each pass took and gives the radiance of the last.
fn draw(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Vec<[f32; 4]>> {
    let facts = &renderer.device().facts;
    println!("device     {} ({})", facts.name, facts.driver);
    let mut prepared = renderer.prepare(scene, plan)?;
    for (pass, milliseconds) in prepared.draw(FRAMES)?.nodes() {
        match milliseconds {
            Some(ms) => println!("  {pass:<18} {ms:>6.3} ms"),
            None => println!("  {pass:<18} on a device without timestamps"),
        }
    }
    let picture = prepared.read_back()?;
    let radiance = picture.rgba("radiance").map(|pixels| pixels.to_vec());
    radiance.ok_or_else(|| Error::new("the frame has no radiance"))
}

fn say(what: &str, d: &Difference) {
    println!(
        "{what:<10} mean relative error {:.2e}, largest {:.2e}, rmse {:.2e} over {} pixels",
        d.mean_relative, d.max_relative, d.rmse, d.pixels
    );
}
