//! `ceiling`: a full-screen loop over N lights for each light fetch, the most that shading can reach on a driver.

use glam::DVec3;
use serde_json::json;

use super::cell::{Cell, digits};
use super::output::Outcome;
use super::run::{Case, Runner};
use super::sweep::{Place, Sweep};
use crate::commands::setup;
use crate::error::{Error, Result};
use crate::measure::html::{Section, Table};
use crate::measure::plot::{Axis, Bars, Figure, Scale};
use crate::measure::times::Spread;
use crate::passes::ceiling;
use crate::plan::{FetchChoice, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{Bounds, Camera, Scene, scatter};

const COUNTS: &[u32] = &[16, 64];

/// More lights say nothing new of a loop over all, and no known driver leaves a loop earlier.
const MOST_LIGHTS: u32 = 65_535;

const FETCHES: [(&str, FetchChoice); 3] =
    [("storage", FetchChoice::Storage), ("uniform", FetchChoice::Uniform), ("texel", FetchChoice::Texel)];

/// Runs the experiment.
///
/// # Errors
/// Only numbers of lights past the most, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut counts = runner.counts(COUNTS, COUNTS);
    counts.retain(|&count| count <= MOST_LIGHTS);
    if counts.is_empty() {
        return Err(Error::usage(format!("--lights: the ceiling is measured for at most {MOST_LIGHTS}")));
    }
    let size = runner.size((1280, 720), (1280, 720));
    let of = |(name, fetch): (&str, FetchChoice)| -> Case {
        (name.into(), Request { technique: Technique::Forward, fetch, ..Request::default() })
    };
    let cases = runner.sized(FETCHES.map(of).to_vec(), size, f64::INFINITY);
    let mut session = runner.session("ceiling", counts.len() * cases.len());
    session.frame = ceiling::frame;
    let mut sweep = Sweep::new("lights");
    for count in counts {
        let cells = session.group(&wall(count), &cases, Some(f64::from(count)))?;
        let facts = json!({ "lights": count });
        sweep.places.push(Place { name: count.to_string(), x: f64::from(count), facts, cells });
    }
    drop(session);
    let pixels = f64::from(size.0) * f64::from(size.1);
    let mut notes = Vec::new();
    let section = section(runner, &sweep, size, &mut notes);
    let row = |(place, cell): (&Place, &Cell)| {
        let ms = pass(cell)?;
        Some(json!({
            "device": runner.renderers[cell.device].device().facts.name,
            "lights": place.facts["lights"],
            "fetch": cell.case,
            "ms": ms,
            "million_light_pixels_per_second": pixels * place.x / ms.median / 1e3,
        }))
    };
    Ok(Outcome {
        name: "ceiling",
        section,
        details: Vec::new(),
        notes,
        size,
        scenes: Vec::new(),
        rows: sweep.cells().filter_map(row).collect(),
        refusal: sweep.refusal(),
    })
}

/// Nanoseconds a light and pixel by texel, uniform and storage buffer, of a small loop.
///
/// # Errors
/// A lost device, or lights that a fetch cannot hold.
pub(super) fn fetch_costs(renderer: &Renderer, base: &Request, frames: usize) -> Result<[f64; 3]> {
    let lights = COUNTS[0];
    let pairs = f64::from(base.width) * f64::from(base.height) * f64::from(lights);
    let rules = LightRules { range: RangeRule::Infinite, ..LightRules::default() };
    let mut costs = [0.0; 3];
    for (cost, fetch) in costs.iter_mut().zip([FetchChoice::Texel, FetchChoice::Uniform, FetchChoice::Storage]) {
        let request = Request { technique: Technique::Forward, fetch, rules: rules.clone(), ..base.clone() };
        let scene = wall(lights);
        let plan = Plan::new(&scene, &request, &renderer.limits())?;
        let mut prepared = renderer.prepare_frame(&scene, &plan, ceiling::frame(&plan))?;
        prepared.draw(1)?;
        *cost = prepared.draw(frames)?.frame().median * 1e6 / pairs;
    }
    Ok(costs)
}

fn section(runner: &Runner, sweep: &Sweep, size: (u32, u32), notes: &mut Vec<String>) -> Section {
    let pixels = f64::from(size.0) * f64::from(size.1);
    let rate = |place: &Place, cell: &Cell| pass(cell).map(|ms| pixels * place.x / ms.median / 1e3);
    let row = |(place, cell): (&Place, &Cell)| {
        let numbers = match pass(cell) {
            Some(ms) => [ms.median, ms.min, ms.max].map(digits).to_vec(),
            None => vec![cell.missing(notes), "-".into(), "-".into()],
        };
        let rate = rate(place, cell).map_or("-".into(), |rate| format!("{rate:.0}"));
        [vec![place.name.clone(), runner.name_of(cell)], numbers, vec![rate]].concat()
    };
    let header = ["lights", "fetch", "median (ms)", "min", "max", "million light-pixels/s"];
    let table = Table {
        caption: "The pass that shades".into(),
        header: header.map(String::from).to_vec(),
        rows: sweep.cells().map(row).collect(),
    };
    let of_case = |index: usize| sweep.places.iter().map(|place| rate(place, &place.cells[index])).collect();
    let names = sweep.names(runner).into_iter().enumerate();
    let shading = setup::shading(runner.args.shading).name();
    let bars = Bars {
        title: format!("ceiling: full-screen loop over all lights, {shading} shading"),
        caption: "By how light data is read, and by the number of lights; medians.".into(),
        y: Axis { label: "million light-pixels a second".into(), scale: Scale::Linear },
        groups: sweep.places.iter().map(|place| format!("{} lights", place.name)).collect(),
        series: names.map(|(index, name)| (name, of_case(index))).collect(),
        stacked: false,
    };
    Section {
        title: format!("ceiling: a full-screen loop over N lights at {}x{}", size.0, size.1),
        paragraphs: vec![runner.how("lights without a range", runner.rounds())],
        tables: vec![table],
        figures: vec![Figure::Bars(bars)],
        pictures: Vec::new(),
    }
}

/// Milliseconds of the pass; of the frame without timestamps.
fn pass(cell: &Cell) -> Option<Spread> {
    let times = cell.times()?;
    let passes: Vec<f64> = times.node_ms.iter().filter_map(|row| row.first().copied()).collect();
    Some(Spread::of(if passes.is_empty() { &times.wall_ms } else { &passes }))
}

/// Lights between the camera and the wall of ceiling.frag, all of them reaching every pixel.
fn wall(lights: u32) -> Scene {
    let mut bounds = Bounds::EMPTY;
    bounds.include(DVec3::new(-5.0, -5.0, -9.0));
    bounds.include(DVec3::new(5.0, 5.0, -6.0));
    Scene {
        name: "ceiling".into(),
        lights: scatter::point_lights(&bounds, lights as usize, 1),
        cameras: vec![Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 1.0)],
        ..Scene::default()
    }
}
