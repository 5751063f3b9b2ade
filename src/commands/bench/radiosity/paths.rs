//! Paths from some of the patches: what patches alone are off by, and what as many paths would cost.

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::commands::bench::run::Runner;
use crate::commands::measured;
use crate::error::Result;
use crate::measure::html::Table;
use crate::plan::{Gi, Limits, Plan, Request};
use crate::radiosity::bake::POINTS;
use crate::radiosity::judge::after_bounces;
use crate::radiosity::{Exchange, Patches, solve};
use crate::reference::render::{Paths, Reference};
use crate::reference::shade::Shader;
use crate::scene::Scene;
use crate::scene::view::View;
use crate::shared::GATHER_LANES;

/// Patches that paths start from, and paths from each of their points; of a quick run.
const PATCHES: [usize; 2] = [400, 60];
const PATHS: [u32; 2] = [1024, 16];
/// Paths a patch that are timed.
const FEW: [u32; 3] = [1, 16, 256];

/// Patches that lie evenly in the area of all of them.
fn by_area(patches: &Patches, wanted: usize) -> Vec<usize> {
    let mut sums = Vec::with_capacity(patches.list.len());
    let mut whole = 0.0;
    for patch in &patches.list {
        whole += patch.area;
        sums.push(whole);
    }
    let place = |k: usize| (2 * k + 1) as f64 / (2 * wanted) as f64 * whole;
    (0..wanted).map(|k| sums.partition_point(|sum| *sum < place(k)).min(sums.len() - 1)).collect()
}

/// Irradiance that paths find.
pub(super) struct Traced {
    /// Indices of patches.
    chosen: Vec<usize>,
    irradiance: Vec<DVec3>,
    /// Root mean square of the tracer's own error over the mean.
    standard_error: f64,
    /// What patches are off by after all bounces of the exact matrix: root mean square over the mean, and bias.
    pub discretization: f64,
    bias: f64,
    paths: u32,
    /// Direct irradiance of all patches.
    direct: Vec<DVec3>,
    /// Paths a patch, milliseconds on all cores for all patches of the scene, and error.
    few: Vec<(u32, f64, f64)>,
}

impl Traced {
    /// Traces.
    ///
    /// # Errors
    /// A scene that cannot be planned.
    pub fn new(runner: &Runner, scene: &Scene, request: &Request, exchange: &Exchange) -> Result<Self> {
        let patches = &exchange.patches;
        let asked = Request { gi: Gi::Off, ..request.clone() };
        let plan = Plan::new(scene, &asked, &Limits::MINIMUM)?;
        let view = View::of_world();
        let reference = Reference::new(scene, &view)?;
        let shader = Shader::new(&plan.lighting, &view, plan.shading);
        let count = patches.list.len();
        let wanted = runner.either(PATCHES[0], PATCHES[1]).min(count);
        let chosen = by_area(patches, wanted);
        let places = |index: usize| &exchange.points[index * POINTS as usize..(index + 1) * POINTS as usize];
        let bar = measured::progress(chosen.len() as u64, "paths from patches");
        let paths = runner.either(PATHS[0], PATHS[1]);
        let trace = |index: usize, count: u32, seed: u64, places: &[[DVec3; 2]]| {
            let paths = Paths { count, seed: seed ^ (index as u64).wrapping_mul(0xD6E8_FEB8_6659_FD93) };
            reference.bounced_irradiance(&shader, places, paths)
        };
        let halves: Vec<[DVec3; 2]> = chosen
            .par_iter()
            .map(|&index| {
                let both = [1, 2].map(|seed| trace(index, paths.div_ceil(2), seed, places(index)));
                bar.inc(1);
                both
            })
            .collect();
        bar.finish_and_clear();
        let irradiance: Vec<DVec3> = halves.iter().map(|[a, b]| (*a + *b) * 0.5).collect();
        let direct = solve::direct_at(patches, &exchange.points, &reference, &shader);
        let mut traced = Self {
            chosen,
            irradiance,
            standard_error: 0.0,
            discretization: 0.0,
            bias: 0.0,
            paths: paths.div_ceil(2) * 2 * POINTS,
            direct,
            few: Vec::new(),
        };
        let difference: Vec<DVec3> = halves.iter().map(|[a, b]| (*a - *b) * 0.5).collect();
        traced.standard_error = traced.over_mean(&difference)[0];
        let product = |sent: &[[f32; 3]]| exchange.exact.product(sent, GATHER_LANES as usize);
        let solved = after_bounces(&product, patches, &traced.exitance(patches));
        [traced.discretization, traced.bias] = traced.over_mean(&traced.differences(&solved));
        // Without any bounced light.
        let none: Vec<DVec3> = traced.irradiance.iter().map(|e| -*e).collect();
        traced.few.push((0, 0.0, traced.over_mean(&none)[0]));
        for few in FEW {
            let start = Instant::now();
            let found: Vec<DVec3> = traced
                .chosen
                .par_iter()
                .map(|&index| {
                    let each = few.min(POINTS) as usize;
                    trace(index, few.div_ceil(POINTS), 3, &places(index)[..each])
                })
                .collect();
            let ms = start.elapsed().as_secs_f64() * 1e3 * count as f64 / traced.chosen.len() as f64;
            let off: Vec<DVec3> = found.iter().zip(&traced.irradiance).map(|(a, b)| *a - *b).collect();
            traced.few.push((few, ms, traced.over_mean(&off)[0]));
        }
        Ok(traced)
    }

    /// What patches send at first.
    pub fn exitance(&self, patches: &Patches) -> Vec<[f32; 3]> {
        let of = |(patch, direct): (&crate::radiosity::Patch, &DVec3)| {
            (patch.emission * std::f64::consts::PI + patch.reflectance * *direct).as_vec3().to_array()
        };
        patches.list.iter().zip(&self.direct).map(of).collect()
    }

    fn differences(&self, found: &[[f64; 3]]) -> Vec<DVec3> {
        self.chosen
            .iter()
            .zip(&self.irradiance)
            .map(|(index, right)| DVec3::from_array(found[*index]) - *right)
            .collect()
    }

    /// Root mean square of differences over the mean that paths find, and their mean over it, of green light: by area, for patches are chosen by it.
    fn over_mean(&self, off: &[DVec3]) -> [f64; 2] {
        let count = self.chosen.len().max(1);
        let mean = |of: &dyn Fn(usize) -> f64| (0..self.chosen.len()).map(of).sum::<f64>() / count as f64;
        let all = mean(&|k| self.irradiance[k].y);
        if all > 0.0 { [mean(&|k| off[k].y * off[k].y).sqrt() / all, mean(&|k| off[k].y) / all] } else { [0.0; 2] }
    }

    /// Root mean square against paths, over their mean.
    pub fn rms(&self, found: &[[f64; 3]]) -> f64 {
        self.over_mean(&self.differences(found))[0]
    }

    /// For people.
    pub fn sentence(&self, exchange: &Exchange, seconds: f64) -> String {
        let report = exchange.factors;
        format!(
            "Patches, form factors and transfer took {seconds:.1} s: {} near pairs by their triangles, {} by points, {} by one, {} rays. Against {} paths from each of {} patches \
             (standard error {:.2} % of their mean) patches with all bounces of the exact matrix are off by {:.2} % rms, {:+.2} % in the mean: no \
             codec is better than that.",
            report.pairs[0],
            report.pairs[1],
            report.pairs[2],
            report.rays,
            self.paths,
            self.chosen.len(),
            100.0 * self.standard_error,
            100.0 * self.discretization,
            100.0 * self.bias,
        )
    }

    /// Paths in the place of patches.
    pub fn table(&self) -> Table {
        let row = |(paths, ms, rms): &(u32, f64, f64)| {
            vec![paths.to_string(), format!("{ms:.0}"), format!("{:.2} %", 100.0 * rms)]
        };
        Table {
            caption: "Paths on the CPU, from every patch".into(),
            header: ["paths a patch", "ms, all cores", "rms"].map(String::from).to_vec(),
            rows: self.few.iter().map(row).collect(),
        }
    }

    /// The same for machines.
    pub fn rows(&self) -> Vec<Value> {
        let row = |(paths, ms, rms): &(u32, f64, f64)| {
            json!({
                "gathering": format!("paths, {paths} a patch"),
                "case": format!("paths, {paths} a patch"),
                "technique": "reference",
                "outcome": "measured",
                "ms": { "median": ms },
                "rms_against_paths": rms,
            })
        };
        // No path takes no time.
        self.few.iter().filter(|(paths, ..)| *paths > 0).map(row).collect()
    }
}
