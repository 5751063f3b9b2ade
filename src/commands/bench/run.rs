//! Measuring: cases of one group are prepared together and drawn in turns, so that drift of the machine touches all alike.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use serde_json::Value;

use super::cell::{Cell, Verdict};
use super::keys::CameraPath;
use crate::cli::Bench;
use crate::commands::{measured, plan, setup};
use crate::error::{ErrorKind, Result};
use crate::gpu::Options;
use crate::passes::{self, Frame};
use crate::plan::{DeferredLights, Plan, Request, Technique};
use crate::renderer::{Prepared, Renderer};
use crate::scene::Scene;
use crate::scene::lighting::LightRules;

/// A frame that takes longer, in milliseconds, is not drawn again.
pub(super) const SLOW_MS: f64 = 10_000.0;

/// Seconds of drawing after which a cell gets no further round, and those of a quick run.
const CELL_SECONDS: [f64; 2] = [6.0, 1.0];

/// Rounds of a group where `--frames` does not say, and those of a quick run.
const ROUNDS: [u32; 2] = [9, 3];

/// A name and what is drawn.
pub(super) type Case = (String, Request);

/// What experiments compare: every technique there is.
pub(super) fn contenders() -> Vec<Case> {
    let of = |technique: Technique| (technique.name().to_string(), Request { technique, ..Request::default() });
    let deferred = |deferred_lights: DeferredLights| -> Case {
        let (name, request) = of(Technique::Deferred);
        (format!("{name}, {}", deferred_lights.name()), Request { deferred_lights, ..request })
    };
    vec![
        of(Technique::Forward),
        deferred(DeferredLights::Volumes),
        deferred(DeferredLights::Fullscreen),
        deferred(DeferredLights::FullscreenBranch),
        of(Technique::TiledDeferred),
        of(Technique::TiledForward),
        of(Technique::ClusteredDeferred),
        of(Technique::ClusteredForward),
    ]
}

/// What the plan chooses.
pub(super) fn auto() -> Case {
    (Technique::Auto.name().into(), Request { technique: Technique::Auto, ..Request::default() })
}

/// Those whose pixels do not loop over all lights: the others take as long wherever camera and lights are.
pub(super) fn culling_contenders() -> Vec<Case> {
    contenders().into_iter().filter(|(_, request)| !loops_over_all(request)).collect()
}

fn loops_over_all(request: &Request) -> bool {
    match request.technique {
        Technique::Deferred => request.deferred_lights != DeferredLights::Volumes,
        technique => technique == Technique::Forward,
    }
}

/// Time grows as lights and pixels do: each light is looped over, or its volume is drawn.
fn is_proportional(request: &Request) -> bool {
    request.technique == Technique::Deferred || loops_over_all(request)
}

/// A scene and what is said of it, before its lights are replaced.
pub(super) struct Loaded {
    pub(super) spec: String,
    pub(super) scene: Scene,
    /// Machine form.
    pub(super) facts: Value,
}

/// Command line and devices.
pub(super) struct Runner<'a> {
    pub(super) args: &'a Bench,
    pub(super) renderers: Vec<Renderer>,
    pub(super) path: CameraPath,
    /// Seconds that the experiment has; `None`: as many as its cells take.
    pub(super) seconds: Option<f64>,
}

impl<'a> Runner<'a> {
    /// Opens each device that was asked for, once.
    pub(super) fn new(args: &'a Bench, path: CameraPath) -> Result<Self> {
        let open = |driver: Option<String>| Renderer::new(&Options { validate: false, driver });
        let renderers: Vec<Renderer> = if args.driver.is_empty() {
            vec![open(None)?]
        } else {
            args.driver.iter().map(|name| open(Some(name.clone()))).collect::<Result<_>>()?
        };
        Ok(Self { args, renderers, path, seconds: None })
    }

    /// What a whole run takes, or a quick one.
    pub(super) fn either<T>(&self, whole: T, quick: T) -> T {
        if self.args.quick { quick } else { whole }
    }

    /// Picture size, given the experiment's own.
    pub(super) fn size(&self, whole: (u32, u32), quick: (u32, u32)) -> (u32, u32) {
        self.args.size.unwrap_or_else(|| self.either(whole, quick))
    }

    /// Numbers of lights, rising, given the experiment's own.
    pub(super) fn counts(&self, whole: &[u32], quick: &[u32]) -> Vec<u32> {
        let own = self.either(whole, quick);
        let mut counts = if self.args.lights.is_empty() { own.to_vec() } else { self.args.lights.clone() };
        counts.sort_unstable();
        counts.dedup();
        counts
    }

    /// One number of lights, given the experiment's own.
    pub(super) fn count(&self, own: u32) -> u32 {
        self.args.lights.iter().copied().max().unwrap_or(own)
    }

    /// Range of lights in metres, given the experiment's own.
    pub(super) fn range(&self, own: f64) -> f64 {
        self.args.light_range.unwrap_or(own)
    }

    /// The scene that was asked for, or the experiment's own.
    ///
    /// # Errors
    /// Whatever the loader finds.
    pub(super) fn load(&self, own: &str) -> Result<Loaded> {
        let spec = self.args.scene.clone().unwrap_or_else(|| own.into());
        let scene = setup::load_scene(&spec)?;
        let facts = plan::scene_json(&spec, &scene, &scene.fingerprint());
        Ok(Loaded { spec, scene, facts })
    }

    /// `count` scattered lights in place of the scene's.
    ///
    /// # Errors
    /// Too many.
    pub(super) fn light(&self, loaded: &mut Loaded, count: u32) -> Result<()> {
        setup::scatter_lights(&mut loaded.scene, Some(count), self.args.light_seed)
    }

    /// The same cases with this picture size, lights of this range, and the shading that was asked for.
    pub(super) fn sized(&self, cases: Vec<Case>, (width, height): (u32, u32), range: f64) -> Vec<Case> {
        let rules = LightRules { range: setup::range(range), ..LightRules::default() };
        let shading = setup::shading(self.args.shading);
        let sized = |request: Request| Request { width, height, shading, rules: rules.clone(), ..request };
        cases.into_iter().map(|(name, request)| (name, sized(request))).collect()
    }

    /// Name of a cell's case, with its driver as it was typed where there are several.
    pub(super) fn name_of(&self, cell: &Cell) -> String {
        match self.renderers.len() {
            1 => cell.case.clone(),
            _ => format!("{}, {}", cell.case, self.args.driver[cell.device]),
        }
    }

    /// How everything is measured, for people.
    pub(super) fn how(&self, lights: &str, rounds: u32) -> String {
        let shading = setup::shading(self.args.shading).name();
        format!(
            "{shading} shading, {lights}, seed {}; medians of up to {rounds} interleaved frames of each case, \
             fewer where they take over {} s.",
            self.args.light_seed,
            self.either(CELL_SECONDS[0], CELL_SECONDS[1])
        )
    }

    /// Most frames of each case.
    pub(super) fn rounds(&self) -> u32 {
        self.args.frames.unwrap_or_else(|| self.either(ROUNDS[0], ROUNDS[1]))
    }

    /// Begins an experiment of so many cases a device.
    pub(super) fn session(&self, what: &'static str, cases: usize) -> Session<'_> {
        let cells = cases * self.renderers.len();
        Session {
            runner: self,
            frame: passes::frame,
            rounds: self.rounds(),
            bar: measured::progress(cells as u64, what),
            end: self.seconds.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds)),
            cells_left: cells,
            seen: HashMap::new(),
        }
    }
}

/// Bytes of the device's memory that are in use.
fn device_bytes(renderer: &Renderer) -> u64 {
    renderer.device().accounts.lock().map(|accounts| accounts.total).unwrap_or_default()
}

/// One experiment while it runs.
pub(super) struct Session<'a> {
    runner: &'a Runner<'a>,
    /// What is drawn of a plan.
    pub(super) frame: fn(&Plan) -> Frame,
    /// Most rounds of a group.
    pub(super) rounds: u32,
    bar: ProgressBar,
    end: Option<Instant>,
    cells_left: usize,
    /// Work and milliseconds of each device's cases, as they were seen last.
    seen: HashMap<(usize, String), (f64, f64)>,
}

/// A cell, and what draws it while it may still be drawn.
struct Slot {
    cell: Cell,
    prepared: Option<Prepared>,
}

impl Session<'_> {
    /// Measures every case on every device. A case's time grows with `work`, and where [`is_proportional`] by the same factor;
    /// groups that cannot be compared have none.
    ///
    /// # Errors
    /// A lost device, or a command line that cannot be carried out.
    pub(super) fn group(&mut self, scene: &Scene, cases: &[Case], work: Option<f64>) -> Result<Vec<Cell>> {
        let cases: Vec<_> = cases.iter().map(|case| (scene, case)).collect();
        self.group_of_scenes(&cases, work)
    }

    /// The same of cases with scenes of their own.
    ///
    /// # Errors
    /// As [`Session::group`].
    pub(super) fn group_of_scenes(&mut self, cases: &[(&Scene, &Case)], work: Option<f64>) -> Result<Vec<Cell>> {
        let mut slots = Vec::new();
        for &(scene, case) in cases {
            for device in 0..self.runner.renderers.len() {
                slots.push(self.start(scene, case, device, work)?);
                self.bar.inc(1);
            }
        }
        let seconds = self.cell_seconds();
        for _ in 0..self.rounds {
            let mut drawn = false;
            for slot in &mut slots {
                drawn |= slot.draw(seconds)?;
            }
            if !drawn {
                break;
            }
        }
        self.cells_left = self.cells_left.saturating_sub(slots.len());
        let cells: Vec<Cell> = slots.into_iter().map(|slot| slot.cell).collect();
        for cell in &cells {
            if let (Some(work), Some(ms)) = (work, cell.known_ms()) {
                self.seen.insert((cell.device, cell.case.clone()), (work, ms));
            }
        }
        Ok(cells)
    }

    /// Seconds of drawing that each cell has.
    fn cell_seconds(&self) -> f64 {
        let most = self.runner.either(CELL_SECONDS[0], CELL_SECONDS[1]);
        let left = |end: Instant| end.saturating_duration_since(Instant::now()).as_secs_f64();
        self.end.map_or(most, |end| most.min(left(end) / self.cells_left.max(1) as f64))
    }

    /// What a smaller case says of this one, in milliseconds, where that is too slow.
    fn too_slow(&self, (name, request): &Case, device: usize, work: Option<f64>) -> Option<f64> {
        let (before, ms) = self.seen.get(&(device, name.clone()))?;
        let growth = work? / before;
        let predicted = if is_proportional(request) { ms * growth } else { *ms };
        (growth >= 1.0 && predicted > SLOW_MS).then_some(predicted)
    }

    /// Plans, prepares and warms up one case on one device.
    fn start(&self, scene: &Scene, case: &Case, device: usize, work: Option<f64>) -> Result<Slot> {
        let mut cell = Cell::new(device, &case.0);
        if let Some(ms) = self.too_slow(case, device, work) {
            cell.verdict = Verdict::Predicted(ms);
            return Ok(Slot { cell, prepared: None });
        }
        let mut prepared = match self.prepare(scene, &case.1, &mut cell) {
            Ok(prepared) => prepared,
            Err(error) if error.kind() == ErrorKind::Usage => return Err(error),
            Err(error) => {
                cell.verdict = Verdict::Refused(error.to_string());
                return Ok(Slot { cell, prepared: None });
            }
        };
        cell.first_ms = prepared.draw(1)?.frame().median;
        let slow = cell.first_ms > SLOW_MS;
        if slow {
            cell.verdict = Verdict::TooSlow(cell.first_ms);
        }
        Ok(Slot { cell, prepared: (!slow).then_some(prepared) })
    }

    fn prepare(&self, scene: &Scene, request: &Request, cell: &mut Cell) -> Result<Prepared> {
        let renderer = &self.runner.renderers[cell.device];
        let start = Instant::now();
        let plan = Plan::new(scene, request, &renderer.limits())?;
        cell.planned(&plan, start.elapsed());
        let (start, before) = (Instant::now(), device_bytes(renderer));
        let prepared = renderer.prepare_frame(scene, &plan, (self.frame)(&plan))?;
        cell.prepare_ms = start.elapsed().as_secs_f64() * 1e3;
        cell.device_bytes = device_bytes(renderer).saturating_sub(before);
        Ok(prepared)
    }
}

impl Drop for Session<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Slot {
    /// Draws one more frame where the cell has not had its seconds; whether it did.
    fn draw(&mut self, seconds: f64) -> Result<bool> {
        let (Some(prepared), Verdict::Measured(times)) = (&mut self.prepared, &mut self.cell.verdict) else {
            return Ok(false);
        };
        let spent: f64 = times.wall_ms.iter().sum();
        if !times.wall_ms.is_empty() && spent >= seconds * 1e3 {
            return Ok(false);
        }
        let one = prepared.draw(1)?;
        let ms = one.frame().median;
        times.names = one.names;
        times.wall_ms.extend(one.wall_ms);
        times.node_ms.extend(one.node_ms);
        if ms > SLOW_MS {
            self.cell.verdict = Verdict::TooSlow(ms);
        }
        Ok(true)
    }
}
