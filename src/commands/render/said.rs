//! What `render` says: to people, in machine form, and in the picture's own file.

use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::cli::Render;
use crate::commands::{plan, report};
use crate::lists::Counters;
use crate::plan::{DebugView, Gi, Plan, Technique};
use crate::scene::Scene;

/// What a picture file says of itself, by keyword.
pub(super) fn provenance(
    typed: &[String],
    outcome: &Outcome,
    fingerprint: &str,
    args: &Render,
) -> Vec<(String, String)> {
    let entry = |key: &str, value: String| (format!("lampyris {key}"), value);
    vec![
        entry("version", env!("CARGO_PKG_VERSION").into()),
        entry("arguments", serde_json::to_string(typed).unwrap_or_default()),
        entry("device", outcome.driver_line.clone()),
        entry("scene", format!("{} {fingerprint}", args.scene)),
        entry("light seed", args.shared.light_seed.to_string()),
    ]
}

/// What `render` prints.
pub(super) fn text(
    args: &Render,
    scene: &Scene,
    plan: &Plan,
    outcome: &Outcome,
    (ev, automatic): (f64, bool),
) -> String {
    let mut out = format!("device    {}\n", outcome.driver_line);
    out += &plan::summary(scene, plan);
    let frame = outcome.times.frame();
    if plan.technique == Technique::Reference {
        out += &format!("traced    {:.2} s\n", frame.median / 1e3);
        if let (Some(bounced), Gi::Path { paths, seed }) = (&outcome.bounced, plan.gi) {
            let error = bounced
                .standard_error
                .map_or("unknown of one path".into(), |e| format!("{:.2} % of its mean", 100.0 * e));
            let seconds = bounced.ms / 1e3;
            out += &format!(
                "bounced   {seconds:.2} s, {paths} paths a pixel, seed {seed}; standard error of a pixel {error}\n"
            );
        }
    } else {
        out += &format!(
            "frame     {:.2} ms median of {} ({:.2} to {:.2})\n",
            frame.median, args.frames, frame.min, frame.max
        );
        for (name, ms) in outcome.times.nodes() {
            out += &match ms {
                Some(ms) => format!("  {name:<18} {ms:>9.3} ms\n"),
                None => format!("  {name:<18}   (no timestamps)\n"),
            };
        }
        let once = match outcome.once_ms {
            0.0 => String::new(),
            ms => format!(", shadow maps {ms:.1} ms"),
        };
        out += &format!(
            "start     first frame after {:.0} ms, of which pipelines {:.0} ms, upload {:.0} ms{once}\n",
            outcome.first_frame_ms, outcome.pipelines_ms, outcome.upload_ms
        );
        out += &format!("memory    {} on the device at most\n", report::bytes(outcome.memory_bytes));
        out += &process_line(outcome);
    }
    if let Some(complaint) = outcome.times.complaint() {
        out += &format!("note      {complaint}\n");
    }
    if let Some(note) = clamped_note(outcome) {
        out += &format!("note      {note}\n");
    }
    if let Some(counters) = &outcome.counters {
        out += &counter_lines(counters);
    }
    if plan.debug_view.is_none_or(DebugView::over_lit) {
        let how = if automatic { "automatic" } else { "as asked" };
        out += &format!("exposure  {ev:+.2} EV, {how}; tone curve {}\n", super::tonemap(args.tonemap).name());
    }
    if let Some(messages) = &outcome.validation {
        out += &format!("validation  {} messages\n", messages.len());
        for message in messages {
            out += &format!("  {message}\n");
        }
    }
    out + &format!("picture   {}\n", args.output.display())
}

/// L9 of the hard cases: radiance past f32 is clamped once, and said.
fn clamped_note(outcome: &Outcome) -> Option<String> {
    let values = outcome.picture.layer("radiance")?;
    let clamped = values.chunks_exact(4).filter(|p| p[..3].iter().any(|c| *c >= f32::MAX)).count();
    (clamped > 0)
        .then(|| format!("the radiance of {clamped} pixels passes 32-bit floats and is clamped to their largest"))
}

/// What `--json` writes.
pub(super) fn machine_form(
    (args, typed): (&Render, &[String]),
    scene: &Scene,
    plan: &Plan,
    outcome: &Outcome,
    (ev, fingerprint): (f64, &str),
) -> Value {
    let frame = outcome.times.frame();
    let passes: Vec<_> =
        outcome.times.nodes().into_iter().map(|(name, gpu_ms)| json!({ "name": name, "gpu_ms": gpu_ms })).collect();
    let memory: serde_json::Map<String, Value> =
        outcome.memory.iter().map(|(name, bytes)| (name.clone(), json!(bytes))).collect();
    json!({
        "schema": report::SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "arguments": typed,
        "light_seed": args.shared.light_seed,
        "device": outcome.device,
        "scene": plan::scene_json(&args.scene, scene, fingerprint),
        "plan": plan::plan_json(plan),
        "passes": passes,
        "frame_ms": { "median": frame.median, "min": frame.min, "max": frame.max, "frames": outcome.times.wall_ms.len() },
        "startup_ms": { "pipelines": outcome.pipelines_ms, "upload": outcome.upload_ms, "shadow_maps": outcome.once_ms, "first_frame": outcome.first_frame_ms },
        "memory_bytes": outcome.memory_bytes,
        "memory": memory,
        "process_memory": outcome.process,
        "counters": counters_json(plan, outcome),
        "gi": gi_json(plan, outcome),
        "exposure_ev": ev,
        "notes": plan.notes.iter().chain(&scene.warnings).cloned().chain(clamped_note(outcome)).collect::<Vec<_>>(),
        "output": args.output.display().to_string(),
        "validation": {
            "enabled": outcome.validation.is_some(),
            "messages": outcome.validation.as_ref().map_or(0, Vec::len),
        },
    })
}

/// How bounced light was made.
fn gi_json(plan: &Plan, outcome: &Outcome) -> Value {
    let (paths, seed) = match plan.gi {
        Gi::Off => (None, None),
        Gi::Path { paths, seed } => (Some(paths), Some(seed)),
        Gi::Radiosity(_) => (None, None),
    };
    json!({
        "mode": plan.gi.name(),
        "spp": paths,
        "seed": seed,
        "patches": plan.bounced.as_ref().map(|bounced| bounced.patches.len()),
        "gathers": plan.bounced.as_ref().map(|bounced| bounced.steps.len()),
        "codec": plan.bounced.as_ref().map(|bounced| bounced.bake.settings.codec.name()),
        "standard_error": outcome.bounced.as_ref().and_then(|bounced| bounced.standard_error),
        "ms": outcome.bounced.as_ref().map(|bounced| bounced.ms),
    })
}

/// Without `--counters` what the plan knows: a technique without lists evaluates at most every light at every pixel.
fn counters_json(plan: &Plan, outcome: &Outcome) -> Value {
    if let Some(counters) = &outcome.counters {
        return json!(counters);
    }
    let known = !plan.has_lists();
    let most = u64::from(plan.lights.count) * plan.pixels();
    json!({
        "light_pairs": null,
        "exact_pairs": null,
        "missed_pairs": null,
        "waste_cells": null,
        "waste_samples": null,
        "light_evaluations": known.then_some(most),
        "lists_overflowed": known.then_some(0),
        "longest_list": null,
    })
}

fn counter_lines(counters: &Counters) -> String {
    format!(
        "lists     {} pairs of cell and light, longest list {}, {} overflowed; {} light evaluations\n\
         oracle    {} pairs of sample and light, {} missed; waste {:.3} by samples, {:.3} by cells\n",
        counters.light_pairs,
        counters.longest_list,
        counters.lists_overflowed,
        counters.light_evaluations,
        counters.exact_pairs,
        counters.missed_pairs,
        counters.waste_samples,
        counters.waste_cells
    )
}

/// The process's memory by stage.
fn process_line(outcome: &Outcome) -> String {
    let process = &outcome.process;
    if process.peak_bytes == 0 {
        return String::new();
    }
    let mib = |bytes: i64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    let stages: Vec<_> = process.stages.iter().map(|s| format!("{} {}", s.name, mib(s.bytes))).collect();
    format!("process   {} at most: {} MiB\n", report::bytes(process.peak_bytes), stages.join(", "))
}
