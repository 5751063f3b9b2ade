//! `bench profile`: what this device takes for the steps that techniques are made of, stored for `--technique auto` (plan/cost.rs).
//!
//! Each number is the slope of a pass's time over what makes it grow, between two loads that differ in that alone.

use std::process::ExitCode;

use serde_json::json;

use super::{ceiling, effects};
use crate::cli::Bench;
use crate::commands::{measured, report, setup};
use crate::error::{Error, Result};
use crate::gpu::Options;
use crate::lists;
use crate::measure::html::Table;
use crate::measure::times::FrameTimes;
use crate::plan::cost::Load;
use crate::plan::profile::Profile;
use crate::plan::{Plan, Request, Technique};
use crate::profile_file;
use crate::renderer::Renderer;
use crate::scene::Scene;
use crate::scene::lighting::LightRules;

/// Pixels: large enough that passes take milliseconds on a CPU.
const SIZE: (u32, u32) = (640, 360);

/// Frames a case, after one that warms up, and those of a quick run.
const FRAMES: [usize; 2] = [7, 3];

/// Metres: nothing but the light's own place, and many pixels.
const RANGES: [f64; 2] = [0.02, 3.0];

/// Metres: volumes that reach few of the pixels that they cover.
const BETWEEN: f64 = 0.7;

/// Lights of most cases.
const LIGHTS: u32 = 1024;

/// One technique at two ranges.
struct Case {
    times: FrameTimes,
    plan: Plan,
    load: Load,
    /// Pairs of listed light and pixel.
    listed: f64,
}

impl Case {
    /// Median milliseconds of the passes whose name begins so.
    fn ms(&self, prefixes: &[&str]) -> f64 {
        let chosen = self.times.nodes().into_iter().filter(|(name, _)| prefixes.iter().any(|p| name.starts_with(p)));
        chosen.filter_map(|(_, ms)| ms).sum()
    }
}

struct Bencher<'a> {
    renderer: &'a Renderer,
    request: Request,
    frames: usize,
}

impl Bencher<'_> {
    fn case(&self, scene: &Scene, technique: Technique, pixels_a_thread: u32, range: f64) -> Result<Case> {
        let rules = LightRules { range: setup::range(range), ..LightRules::default() };
        let pixels_a_thread = (technique == Technique::TiledDeferred).then_some(pixels_a_thread);
        let lists = !matches!(technique, Technique::Forward | Technique::Deferred);
        let group_a_tile = self.request.group_a_tile.filter(|_| lists);
        let request = Request { technique, rules, pixels_a_thread, group_a_tile, ..self.request.clone() };
        let plan = Plan::new(scene, &request, &self.renderer.limits())?;
        let mut prepared = self.renderer.prepare(scene, &plan)?;
        prepared.draw(1)?;
        let times = prepared.draw(self.frames)?;
        drop(prepared);
        let listed = if plan.has_lists() {
            let made = lists::make(self.renderer, scene, &plan)?;
            let shown = made.depth.iter().zip(made.cells.list_lengths()).filter(|(depth, _)| **depth > 0.0);
            shown.map(|(_, length)| f64::from(length)).filter(|length| length.is_finite()).sum()
        } else {
            0.0
        };
        let load = Load::new(scene, &plan.lighting, &plan.view, request.tile);
        Ok(Case { times, plan, load, listed })
    }
}

/// The slope of milliseconds over counts, in nanoseconds; never below 0, which noise could make it.
fn slope(ms: [f64; 2], counts: [f64; 2]) -> f64 {
    let steps = counts[1] - counts[0];
    if steps > 0.0 { ((ms[1] - ms[0]) * 1e6 / steps).max(0.0) } else { 0.0 }
}

/// Prices of two things from two bills, `[how many, how many, sum]`; none is negative, which noise could make it.
fn two_prices([a, b, first]: [f64; 3], [c, d, second]: [f64; 3]) -> [f64; 2] {
    let alone = |count: f64| if count > 0.0 { (second / count).max(0.0) } else { 0.0 };
    let determinant = a * d - b * c;
    let [x, y] = [(first * d - second * b) / determinant, (a * second - c * first) / determinant];
    match (x >= 0.0, y >= 0.0) {
        (true, true) if x.is_finite() && y.is_finite() => [x, y],
        (true, _) => [alone(c), 0.0],
        _ => [0.0, alone(d)],
    }
}

fn measure(renderer: &Renderer, args: &Bench) -> Result<Profile> {
    let (width, height) = args.size.unwrap_or(SIZE);
    let shading = setup::shading(args.shading);
    let request = Request { width, height, shading, group_a_tile: Some(false), ..Request::default() };
    let bencher =
        Bencher { renderer, request, frames: args.frames.map_or(FRAMES[usize::from(args.quick)], |n| n as usize) };
    let mut scene = setup::load_scene(args.scene.as_deref().unwrap_or("builtin:atrium"))?;
    let bar = measured::progress(13, "profile");
    let mut lit = |count: u32, (technique, pixels): (Technique, u32), range: f64| -> Result<Case> {
        setup::scatter_lights(&mut scene, Some(count), args.light_seed)?;
        let case = bencher.case(&scene, technique, pixels, range);
        bar.inc(1);
        case
    };
    let pixels = f64::from(width) * f64::from(height);
    let forward = [lit(8, (Technique::Forward, 1), RANGES[0])?, lit(72, (Technique::Forward, 1), RANGES[0])?];
    let test = slope(forward.each_ref().map(|c| c.ms(&["forward"])), [8.0 * pixels, 72.0 * pixels]);
    let mut both = |technique| -> Result<[Case; 2]> {
        Ok([lit(LIGHTS, technique, RANGES[0])?, lit(LIGHTS, technique, RANGES[1])?])
    };
    let tiled = both((Technique::TiledForward, 1))?;
    let deferred = both((Technique::TiledDeferred, 1))?;
    let shared = both((Technique::TiledDeferred, 4))?;
    let volumes = both((Technique::Deferred, 1))?;
    let smaller = lit(LIGHTS, (Technique::Deferred, 1), BETWEEN)?;
    let mut both = |technique| -> Result<[Case; 2]> {
        Ok([lit(LIGHTS, technique, RANGES[0])?, lit(LIGHTS, technique, RANGES[1])?])
    };
    let clustered = both((Technique::ClusteredForward, 1))?;
    bar.finish_and_clear();
    let groups = Request { group_a_tile: Some(true), ..bencher.request.clone() };
    let grouped = Bencher { request: groups, ..bencher }.case(&scene, Technique::TiledForward, 1, RANGES[0])?;
    if tiled[1].times.nodes().iter().any(|node| node.1.is_none()) {
        return Err(Error::new("this device has no timestamps: passes cannot be timed one by one"));
    }
    let listed = |cases: &[Case; 2]| cases.each_ref().map(|c| c.listed);
    let pair = slope(tiled.each_ref().map(|c| c.ms(&["tiled_forward"])), listed(&tiled));
    let of_pair = |cases: &[Case; 2]| slope(cases.each_ref().map(|c| c.ms(&["tiled_deferred"])), listed(cases));
    let [deferred_pair, shared_pair] = [&deferred, &shared].map(of_pair);
    // What is left of each way's shading where almost nothing is listed.
    let inline = tiled[0].ms(&["tiled_forward"]) - tiled[0].listed * pair * 1e-6;
    let stored = deferred[0].ms(&["gbuffer", "tiled_deferred"]) - deferred[0].listed * deferred_pair * 1e-6;
    let culls = tiled.each_ref().map(|c| c.ms(&["tile_count", "tile_fill"]));
    let tests = |case: &Case| case.plan.tiles.as_ref().map_or(0.0, |t| t.bin_pairs as f64) * 64.0;
    let volume = volumes[0].ms(&["light_volumes"]) * 1e6 / volumes[0].load.seen.max(1.0);
    let beyond =
        |case: &Case| [case.load.covered, case.load.pairs, case.ms(&["light_volumes"]) * 1e6 - volume * case.load.seen];
    let [volume_pixel, volume_pair] = two_prices(beyond(&smaller), beyond(&volumes[1]));
    let cluster_all = clustered[0].ms(&["cluster_", "block_", "entry_", "group_"]);
    let cluster_pixels = clustered[0].ms(&["cluster_keys", "cluster_index"]);
    setup::scatter_lights(&mut scene, Some(64), args.light_seed)?;
    let rules = LightRules { range: setup::range(4.0), ..LightRules::default() };
    // Forward has no depths to reduce.
    let alone = Request { group_a_tile: None, ..bencher.request.clone() };
    let tiled_request = Request { technique: Technique::TiledForward, rules, ..alone.clone() };
    let forced = effects::forced_costs(renderer, &scene, &tiled_request, bencher.frames)?;
    let [texel_fetch, uniform_fetch, storage_fetch] = ceiling::fetch_costs(renderer, &alone, bencher.frames)?;
    Ok(Profile {
        source: "measured on this device".into(),
        texel_fetch,
        uniform_fetch,
        storage_fetch,
        test,
        pair,
        deferred_pair,
        shared_pair,
        gbuffer: ((stored - inline) * 1e6 / pixels).max(0.0),
        bounds: tiled[0].ms(&["depth_reduce"]) * 1e6 / pixels,
        group_bounds: grouped.ms(&["depth_reduce"]) * 1e6 / pixels,
        cull: slope(culls, tiled.each_ref().map(tests)),
        cluster: cluster_pixels * 1e6 / pixels,
        volume,
        volume_pixel,
        volume_pair,
        lists_ms: tiled[0].ms(&["tile_bin", "bin_", "tile_scan"]),
        clusters_ms: (cluster_all - cluster_pixels).max(0.0),
        forced: Some(forced),
    })
}

/// Measures, stores and prints the profile.
///
/// # Errors
/// A device without timestamps, a lost one, or no place for the file.
pub(super) fn run(args: &Bench) -> Result<ExitCode> {
    let renderer = Renderer::new(&Options { validate: false, driver: args.driver.first().cloned() })?;
    let facts = &renderer.device().facts;
    let profile = measure(&renderer, args)?;
    let path = profile_file::store(facts, &profile)?;
    if !report::json_on_stdout(args.json.as_deref()) {
        let mut text = format!("device    {}\n\n", facts.line());
        text += &table(&profile, &renderer.limits().profile.unwrap_or_default()).text();
        text += &format!("\nstored as {}\n", path.display());
        report::print(&text)?;
    }
    if let Some(json) = &args.json {
        let value = json!({
            "schema": report::SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "experiment": "profile",
            "device": report::device_json(facts),
            "profile": profile,
        });
        report::write_json(json, &value)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Effects that are forced, for people and by name.
const FORCED: [(&str, &str); 8] = [
    ("pre-pass, forced", "prepass"),
    ("transparency, forced", "transparency"),
    ("alpha masks, forced", "alpha_mask"),
    ("normal maps, forced", "normal_maps"),
    ("parallax, forced", "parallax"),
    ("material models, forced", "material_models"),
    ("four samples, forced", "msaa"),
    ("a light's shadow, forced", "shadows"),
];

fn table(new: &Profile, old: &Profile) -> Table {
    let row = |name: &str, unit: &str, new: f64, old: f64| {
        vec![name.to_string(), unit.to_string(), format!("{new:.2}"), format!("{old:.2}")]
    };
    let forced = FORCED.into_iter().map(|(name, effect)| {
        let of = |profile: &Profile| profile.forced.and_then(|forced| forced.of(effect)).unwrap_or(f64::NAN);
        row(name, "ns a pixel", of(new), of(old))
    });
    let mut table = Table {
        caption: "what steps take, for --technique auto".into(),
        header: ["step", "unit", "measured", "before"].map(String::from).to_vec(),
        rows: vec![
            row("a light by texel", "ns a pixel", new.texel_fetch, old.texel_fetch),
            row("by uniform buffer", "ns a pixel", new.uniform_fetch, old.uniform_fetch),
            row("by storage buffer", "ns a pixel", new.storage_fetch, old.storage_fetch),
            row("forward looks at a light", "ns a pixel", new.test, old.test),
            row("a listed light is shaded", "ns a pair", new.pair, old.pair),
            row("the same from a G-buffer", "ns a pair", new.deferred_pair, old.deferred_pair),
            row("and four pixels a thread", "ns a pair", new.shared_pair, old.shared_pair),
            row("G-buffer", "ns a pixel", new.gbuffer, old.gbuffer),
            row("depth bounds", "ns a pixel", new.bounds, old.bounds),
            row("by groups of threads", "ns a pixel", new.group_bounds, old.group_bounds),
            row("a light against a tile", "ns", new.cull, old.cull),
            row("a pixel's cluster", "ns a pixel", new.cluster, old.cluster),
            row("a light volume", "ns", new.volume, old.volume),
            row("a pixel of a volume", "ns", new.volume_pixel, old.volume_pixel),
            row("and one that its light reaches", "ns", new.volume_pair, old.volume_pair),
            row("lists by themselves", "ms", new.lists_ms, old.lists_ms),
            row("clusters by themselves", "ms", new.clusters_ms, old.clusters_ms),
        ],
    };
    table.rows.extend(forced);
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_bills_have_two_prices_and_none_is_negative() {
        let bill = |a: f64, b: f64| [a, b, 3.0 * a + 5.0 * b];
        assert_eq!(two_prices(bill(1.0, 2.0), bill(4.0, 1.0)), [3.0, 5.0]);
        assert_eq!(two_prices([1.0, 1.0, 10.0], [2.0, 1.0, 8.0]), [0.0, 8.0]);
        assert_eq!(two_prices([1.0, 1.0, 1.0], [1.0, 2.0, 0.5]), [0.5, 0.0]);
        assert_eq!(two_prices([0.0; 3], [0.0; 3]), [0.0, 0.0]);
    }
}
