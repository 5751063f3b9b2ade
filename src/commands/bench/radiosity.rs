//! `radiosity`: bounced light by every codec, iteration and path to the matrix, from one set of form factors: what each takes in bytes and in time, and
//! how far it is from all bounces of the exact matrix and from paths.

mod cases;
mod moving;
mod paths;

use std::time::Instant;

use serde_json::{Value, json};

use self::cases::{Row, gi_ms};
use self::moving::Moving;
use self::paths::Traced;
use super::cell::{Cell, digits};
use super::output::{About, Outcome};
use super::run::{Case, Runner};
use super::sweep::{Place, Sweep, log_axis};
use crate::error::{Error, Result};
use crate::measure::html::Table;
use crate::measure::plot::{Axis, Figure, Plot, Point, Scale, Series};
use crate::passes;
use crate::plan::{Gi, Request, ShadowUpdate, Technique};
use crate::radiosity::Exchange;
use crate::radiosity::Settings;
use crate::radiosity::bake::CodecName;
use crate::scene::lighting::LightRules;
use crate::scene::shading::Shading;

const PATCHES: [u32; 2] = [4096, 300];
/// Lights of a scene that are taken as they are.
const OWN_LIGHTS: usize = 16;

/// Runs the experiment.
///
/// # Errors
/// A scene that cannot be loaded or baked, a lost device.
pub(super) fn run(runner: &Runner) -> Result<Outcome> {
    let mut loaded = runner.load(runner.either("builtin:atrium", "builtin:cornell"))?;
    // The scene's own, where all of them may have shadows; else a sun and a lamp.
    match runner.args.lights.iter().copied().max() {
        Some(count) => runner.light(&mut loaded, count)?,
        None if (1..=OWN_LIGHTS).contains(&loaded.scene.lights.len()) => {}
        None => loaded.scene.lights = moving::lights(&loaded.scene),
    }
    let lights = loaded.scene.lights.len();
    let wanted = runner.args.patches.unwrap_or_else(|| runner.either(PATCHES[0], PATCHES[1]));
    let start = Instant::now();
    let exchange = Exchange::of_scene(&loaded.scene, &Settings::of_count(wanted as usize))?;
    let factor_seconds = start.elapsed().as_secs_f64();
    if exchange.patches.list.is_empty() {
        return Err(Error::new(format!("{}: no surface reflects light between patches", loaded.spec)));
    }
    let base = Request {
        technique: Technique::Forward,
        shading: Shading::Lambert,
        shadow_update: ShadowUpdate::Frame,
        shadow_size: 256,
        rules: LightRules { emission_lights: true, ..LightRules::default() },
        width: 64,
        height: 36,
        ..Request::default()
    };
    let traced = Traced::new(runner, &loaded.scene, &base, &exchange)?;
    let rows = cases::rows(&exchange, &traced)?;
    let cases: Vec<Case> = rows
        .iter()
        .map(|row| {
            let (gi, bake) = (Gi::Radiosity(row.gathering), Some(row.bake.clone()));
            (row.name.clone(), Request { gi, bake, ..base.clone() })
        })
        .collect();
    let mut session = runner.session("radiosity", cases.len());
    session.frame = passes::patch_frame;
    let mut cells = session.group(&loaded.scene, &cases, None)?;
    drop(session);
    let blocks = rows.iter().find(|row| row.kind == CodecName::ZeroBlock.name()).map(|row| row.bake.clone());
    let moving = blocks.map(|bake| Moving::new(runner, &loaded.scene, &base, &bake)).transpose()?;
    let devices = runner.renderers.len();
    let mut sweep = Sweep::new("gathering");
    for (index, row) in rows.iter().enumerate() {
        let own: Vec<Cell> = cells.drain(..devices.min(cells.len())).collect();
        sweep.places.push(Place { name: row.name.clone(), x: index as f64, facts: row.facts(), cells: own });
    }
    let count = exchange.patches.list.len();
    let about = About {
        name: "radiosity",
        title: format!("radiosity: {}, {count} patches, {lights} lights", loaded.spec),
        lights: "lights of their own ranges, all with shadows".into(),
        size: (base.width, base.height),
        scenes: vec![loaded.facts.clone()],
    };
    let figures = figures(runner, &rows, &sweep, &traced);
    let mut outcome = Outcome::of_sweep(runner, &sweep, about, figures);
    outcome.section.tables = vec![table(runner, &rows, &sweep), traced.table()];
    outcome.section.tables.extend(moving.iter().map(Moving::table));
    outcome.section.paragraphs.extend(moving.iter().map(|moving| moving.sentence().into()));
    outcome.section.paragraphs.insert(0, traced.sentence(&exchange, factor_seconds));
    for (row, (_, cell)) in outcome.rows.iter_mut().zip(sweep.cells()) {
        if let Some(fields) = row.as_object_mut() {
            let [direct, gathers] = gi_ms(cell).unwrap_or([f64::NAN; 2]);
            fields.insert("gather_ms".into(), json!(gathers));
            fields.insert("direct_ms".into(), json!(direct));
        }
    }
    outcome.rows.extend(traced.rows());
    outcome.rows.extend(moving.iter().flat_map(Moving::rows));
    Ok(outcome)
}

/// A row a way to gather.
fn table(runner: &Runner, rows: &[Row], sweep: &Sweep) -> Table {
    let fixed = ["gathering", "bytes an element", "MiB", "codec (s)", "gathers"];
    let timed = ["a gather (ms)", "all (ms)"];
    let last = ["relL2 mean", "worst", "of it the codec", "energy", "rms against paths"];
    let mut header: Vec<String> = fixed.map(String::from).to_vec();
    for renderer in &runner.renderers {
        let device =
            if runner.renderers.len() > 1 { format!(", {}", renderer.device().facts.name) } else { String::new() };
        header.extend(timed.map(|name| format!("{name}{device}")));
    }
    header.extend(last.map(String::from));
    let row = |(row, place): (&Row, &Place)| {
        let mut cells = vec![
            row.name.clone(),
            format!("{:.3}", row.bake.bytes_an_element()),
            digits(row.bake.operator.bytes() as f64 / f64::from(1 << 20)),
            format!("{:.1}", row.seconds),
            row.steps.to_string(),
        ];
        for cell in &place.cells {
            let ms = gi_ms(cell);
            cells.push(ms.map_or("-".into(), |[_, gathers]| digits(gathers / f64::from(row.steps))));
            cells.push(ms.map_or("-".into(), |[_, gathers]| digits(gathers)));
        }
        let per_cent = |x: f64| format!("{:.3} %", 100.0 * x);
        cells.extend([row.found.mean, row.found.worst].map(per_cent));
        cells.push(row.codec_alone.map_or("-".into(), per_cent));
        cells.push(format!("{:.4}", row.found.energy));
        cells.push(per_cent(row.against_paths));
        cells
    };
    Table {
        caption: "Against all bounces of the exact matrix, and against paths".into(),
        header,
        rows: rows.iter().zip(&sweep.places).map(row).collect(),
    }
}

/// Error against bytes and against milliseconds; what patches alone are off by as a line.
fn figures(runner: &Runner, rows: &[Row], sweep: &Sweep, traced: &Traced) -> Vec<Figure> {
    let kinds: Vec<&str> = rows.iter().fold(Vec::new(), |mut kinds, row| {
        if !kinds.contains(&row.kind) {
            kinds.push(row.kind);
        }
        kinds
    });
    let plot = |title: &str, label: &str, x: &dyn Fn(usize) -> Option<f64>| {
        let all: Vec<f64> = (0..rows.len()).filter_map(x).collect();
        let ends = [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(0.0, f64::max)];
        let mut series: Vec<Series> = kinds
            .iter()
            .map(|kind| {
                let own = (0..rows.len()).filter(|index| rows[*index].kind == *kind);
                let points = own.filter_map(|index| {
                    let y = rows[index].found.mean.max(1e-7);
                    x(index).map(|x| Point { x, y, low: y, high: y })
                });
                Series { name: (*kind).into(), points: points.collect(), line: false, marked: Vec::new() }
            })
            .collect();
        let line =
            |x: f64| Point { x, y: traced.discretization, low: traced.discretization, high: traced.discretization };
        series.push(Series {
            name: "patches against paths, rms".into(),
            points: ends.map(line).to_vec(),
            line: true,
            marked: Vec::new(),
        });
        Figure::Plot(Plot {
            title: title.into(),
            caption: "Relative L2 error of bounced irradiance, mean over six light set-ups.".into(),
            x: log_axis(label),
            y: Axis { label: "relative L2 error".into(), scale: Scale::Log },
            series,
        })
    };
    let first_device = |index: usize| sweep.places[index].cells.first().and_then(gi_ms).map(|[_, ms]| ms.max(1e-4));
    let device = runner.renderers.first().map_or(String::new(), |r| r.device().facts.name.clone());
    vec![
        plot("radiosity: error by milliseconds", &format!("gathers of a frame on {device} (ms)"), &first_device),
        plot("radiosity: error by bytes", "bytes an element", &|index| Some(rows[index].bake.bytes_an_element())),
    ]
}

/// Fields of rows that only paths have are null here, and the other way round.
fn facts(kind: &str, name: &str) -> Value {
    json!({ "gathering": name, "codec": kind })
}
