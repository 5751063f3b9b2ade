//! A sun that turns and a lamp that is switched, in a picture that is prepared once; and a dark scene, whose light asks for next to nothing.

use std::sync::Arc;
use std::time::Instant;

use glam::{DQuat, DVec3};
use serde_json::{Value, json};

use crate::commands::bench::cell::digits;
use crate::commands::bench::run::Runner;
use crate::error::Result;
use crate::measure::html::Table;
use crate::measure::times::Spread;
use crate::plan::{Gathering, Gi, Plan, Request, ShadowUpdate, Technique};
use crate::radiosity::{Bake, Settings};
use crate::renderer::Renderer;
use crate::scene::{Light, LightKind, Scene, builtin};

/// Frames of each row.
const FRAMES: u32 = 12;
/// Degrees that the sun turns in a frame.
const TURN: f64 = 2.0;
/// Patches of the dark scene, and of a quick run.
const DARK_PATCHES: [usize; 2] = [1000, 100];

/// A sun that shines into the scene from above, and a lamp in its middle.
pub(super) fn lights(scene: &Scene) -> Vec<Light> {
    let bounds = scene.bounds();
    let size = (bounds.max - bounds.min).length();
    let middle = bounds.center();
    let lamp = Light {
        name: "lamp".into(),
        kind: LightKind::Point,
        color: [1.0, 0.8, 0.5],
        // About as bright as the sun a quarter of the scene away.
        intensity: (0.02 * size * size) as f32,
        position: DVec3::new(middle.x, bounds.min.y + 0.35 * (bounds.max.y - bounds.min.y), middle.z),
        direction: DVec3::NEG_Y,
        range: Some(2.0 * size as f32),
        shadow: true,
    };
    let direction = DVec3::new(0.35, -1.0, 0.25).normalize();
    let sun = Light {
        name: "sun".into(),
        kind: LightKind::Directional,
        intensity: 3.0,
        range: None,
        direction,
        ..lamp.clone()
    };
    vec![sun, lamp]
}

/// What changes from frame to frame.
#[derive(Clone, Copy)]
struct Moves {
    name: &'static str,
    sun: bool,
    lamp: bool,
    feedback: bool,
}

/// Medians of the frames of a row, milliseconds.
struct Timed {
    name: String,
    device: String,
    plan: f64,
    upload: f64,
    shadows: f64,
    direct: f64,
    gathers: f64,
    frame: f64,
    made: u64,
}

/// Both tables' rows.
pub(super) struct Moving {
    rows: Vec<Timed>,
    dark: String,
}

fn request(bake: &Arc<Bake>, base: &Request, gathering: Gathering) -> Request {
    Request {
        technique: Technique::Forward,
        shadow_update: ShadowUpdate::Once,
        lights_move: true,
        shadow_size: 512,
        width: 320,
        height: 180,
        gi: Gi::Radiosity(gathering),
        bake: Some(Arc::clone(bake)),
        ..base.clone()
    }
}

impl Moving {
    /// Draws all rows on every device.
    ///
    /// # Errors
    /// A lost device, or a plan that is refused.
    pub fn new(runner: &Runner, scene: &Scene, base: &Request, bake: &Arc<Bake>) -> Result<Self> {
        let mut scene = scene.clone();
        scene.lights = lights(&scene);
        let all = [
            Moves { name: "nothing moves", sun: false, lamp: false, feedback: false },
            Moves { name: "the sun turns", sun: true, lamp: false, feedback: false },
            Moves { name: "the lamp is switched", sun: false, lamp: true, feedback: false },
            Moves { name: "both", sun: true, lamp: true, feedback: false },
            Moves { name: "both, one gather and feedback", sun: true, lamp: true, feedback: true },
        ];
        let mut rows = Vec::new();
        for renderer in &runner.renderers {
            for moves in all {
                rows.push(timed(renderer, &scene, base, bake, moves)?);
            }
        }
        let mut moving = Self { rows, dark: String::new() };
        if let Some(renderer) = runner.renderers.first() {
            let patches = runner.either(DARK_PATCHES[0], DARK_PATCHES[1]).min(bake.patches.list.len());
            moving.dark = moving.dark_scene(renderer, base, (patches, bake.patches.list.len()))?;
        }
        Ok(moving)
    }

    /// `terrain:albedo=0.05` under its sun, against the first device's scene with both lights moving.
    fn dark_scene(&self, renderer: &Renderer, base: &Request, (patches, of_scene): (usize, usize)) -> Result<String> {
        let mut scene = builtin::load("terrain:albedo=0.05")?;
        scene.lights.truncate(1);
        let bake = Arc::new(Bake::of_scene(&scene, Settings::of_count(patches))?);
        let moves = Moves { name: "dark", sun: true, lamp: false, feedback: false };
        let dark = timed(renderer, &scene, base, &bake, moves)?;
        let plan = Plan::new(&scene, &request(&bake, base, Gathering::default()), &renderer.limits())?;
        let of = |row: &Timed| row.direct + row.gathers;
        let bright = self.rows.iter().find(|row| row.name == "both").map_or(f64::NAN, of);
        Ok(format!(
            "builtin:terrain:albedo=0.05 under one sun that turns, {} patches: {} ms for direct light of patches and gathers, {:.1} % of the {} ms above \
             for {of_scene} patches (both lights move). Its plan: {}.",
            bake.patches.list.len(),
            digits(of(&dark)),
            100.0 * of(&dark) / bright,
            digits(bright),
            plan.bounced_why
        ))
    }

    /// For people.
    pub fn table(&self) -> Table {
        let several = self.rows.iter().any(|row| row.device != self.rows[0].device);
        let row = |row: &Timed| {
            let name = if several { format!("{}, {}", row.name, row.device) } else { row.name.clone() };
            let mut cells = vec![name];
            let times = [row.plan, row.upload, row.shadows, row.direct, row.gathers, row.frame];
            cells.extend(times.map(|ms| match ms {
                0.0 => "0".into(),
                ms if ms.is_nan() => "-".into(),
                ms => digits(ms),
            }));
            cells.push(row.made.to_string());
            cells
        };
        Table {
            caption: format!(
                "A sun that turns by {TURN} degrees a frame and a lamp that is switched in each, 320x180, medians of {FRAMES} frames"
            ),
            header: [
                "what moves",
                "plan (ms)",
                "upload (ms)",
                "shadow maps (ms)",
                "direct light of patches (ms)",
                "gathers (ms)",
                "the rest of the frame (ms)",
                "allocations and pipelines",
            ]
            .map(String::from)
            .to_vec(),
            rows: self.rows.iter().map(row).collect(),
        }
    }

    /// The dark scene, in a sentence.
    pub fn sentence(&self) -> &str {
        &self.dark
    }

    /// For machines.
    pub fn rows(&self) -> Vec<Value> {
        let row = |row: &Timed| {
            json!({
                "gathering": format!("moving: {}", row.name),
                "case": format!("moving: {}", row.name),
                "device": row.device,
                "technique": "forward",
                "outcome": "measured",
                "plan_ms": row.plan,
                "upload_ms": row.upload,
                "shadow_ms": row.shadows,
                "direct_ms": row.direct,
                "gather_ms": row.gathers,
                "ms": { "median": row.frame },
                "objects_made": row.made,
            })
        };
        self.rows.iter().map(row).collect()
    }
}

fn timed(renderer: &Renderer, scene: &Scene, base: &Request, bake: &Arc<Bake>, moves: Moves) -> Result<Timed> {
    let mut scene = scene.clone();
    let gathering = Gathering { feedback: moves.feedback, ..Gathering::default() };
    let request = request(bake, base, gathering);
    let limits = renderer.limits();
    let mut plan = Plan::new(&scene, &request, &limits)?;
    let mut prepared = renderer.prepare(&scene, &plan)?;
    prepared.draw(2)?;
    let made = renderer.device().objects_made();
    let lamp = scene.lights.last().map_or(0.0, |light| light.intensity);
    let mut found: [Vec<f64>; 6] = Default::default();
    for frame in 1..=FRAMES {
        let start = Instant::now();
        let (mut planned, mut uploaded) = (0.0, 0.0);
        let relit = moves.sun || moves.lamp;
        if relit {
            if moves.sun
                && let Some(sun) = scene.lights.first_mut()
            {
                sun.direction = DQuat::from_rotation_y(TURN.to_radians()) * sun.direction;
            }
            if moves.lamp
                && let Some(light) = scene.lights.last_mut()
            {
                light.intensity = if frame % 2 == 0 { lamp } else { 0.0 };
            }
            plan = plan.relit(&scene, &request, &limits)?;
            planned = start.elapsed().as_secs_f64() * 1e3;
            let start = Instant::now();
            prepared.relight(&plan)?;
            uploaded = start.elapsed().as_secs_f64() * 1e3;
        }
        let times = prepared.draw(1)?;
        let of_frame = times.names.iter().zip(times.node_ms.first().into_iter().flatten());
        let once = if relit { prepared.once_nodes_ms.as_slice() } else { &[] };
        let nodes: Vec<(&str, f64)> = of_frame
            .map(|(name, ms)| (name.as_str(), *ms))
            .chain(once.iter().map(|(name, ms)| (name.as_str(), *ms)))
            .collect();
        // Without timestamps nothing is known of nodes.
        let known = times.node_ms.first().is_some_and(|row| !row.is_empty());
        let sum = |which: &dyn Fn(&str) -> bool| {
            let own = nodes.iter().filter(|(name, _)| which(name)).map(|(_, ms)| ms).sum::<f64>();
            if known { own } else { f64::NAN }
        };
        let gathers = |name: &str| name.starts_with("patch_gather") || name.starts_with("patch_product");
        let own = |name: &str| gathers(name) || name == "patch_light" || name == "shadow_map";
        let values = [
            planned,
            uploaded,
            sum(&|name| name == "shadow_map"),
            sum(&|name| name == "patch_light"),
            sum(&gathers),
            if known { sum(&|name| !own(name)) } else { times.wall_ms.first().copied().unwrap_or(f64::NAN) },
        ];
        found.iter_mut().zip(values).for_each(|(list, value)| list.push(value));
    }
    let [plan, upload, shadows, direct, gathers, frame] = found.map(|values| Spread::of(&values).median);
    Ok(Timed {
        name: moves.name.into(),
        device: renderer.device().facts.name.clone(),
        plan,
        upload,
        shadows,
        direct,
        gathers,
        frame,
        made: renderer.device().objects_made() - made,
    })
}
