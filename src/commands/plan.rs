//! `plan`: what would run and why, without drawing; and the summary that `render` prints.

mod grids;

use std::process::ExitCode;

use serde_json::{Value, json};

use super::{report, setup};
use crate::cli::{LimitsChoice, PlanArgs};
use crate::error::Result;
use crate::gpu::Options;
use crate::graph::{Access, Graph, describe, hazard};
use crate::passes;
use crate::plan::{Plan, Technique, estimate};
use crate::renderer::Renderer;
use crate::scene::Scene;

/// Runs the command.
///
/// # Errors
/// As `render`, up to the plan.
pub fn run(args: &PlanArgs) -> Result<ExitCode> {
    let (scene, request) = setup::scene_and_request(&args.scene, &args.shared)?;
    let needs_device = args.shared.limits == LimitsChoice::Device && request.technique != Technique::Reference;
    let options = Options { validate: false, driver: args.shared.driver.clone() };
    let renderer = if needs_device { Some(Renderer::new(&options)?) } else { None };
    let limits = setup::limits(&args.shared, renderer.as_ref());
    let mut plan = Plan::new(&scene, &request, &limits)?;
    let profile = limits.profile.unwrap_or_default();
    estimate(&mut plan, &scene, request.tile, &profile);
    let traced = plan.technique == Technique::Reference;
    let graph = if traced { Graph::new() } else { passes::frame(&plan).graph };
    let barriers = hazard::derive(&graph);
    if !report::json_on_stdout(args.json.as_deref()) {
        let mut out = String::new();
        if traced && (args.dot || args.barriers) {
            out += "the reference traces rays on the CPU: it has no passes and no barriers\n";
        } else if args.dot {
            out += &describe::dot(&graph, &barriers);
        } else if args.barriers {
            out += &describe::listing(&graph, &barriers);
        } else {
            out += &summary(&scene, &plan);
            if plan.effects.iter().any(|effect| effect.ms.is_some()) {
                out += &format!("milliseconds are estimates for a frame: {}\n", profile.source);
            }
            out += &grids::lines(&plan);
            out += &format!(
                "memory    {} attachments, {} scene data\n",
                report::bytes(plan.attachment_bytes()),
                report::bytes(plan.static_bytes())
            );
        }
        report::print(&out)?;
    }
    if let Some(path) = &args.json {
        let listed: Vec<_> = barriers.iter().map(|b| barrier_json(&graph, b)).collect();
        let value = json!({
            "schema": report::SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "device": renderer.as_ref().map(|r| report::device_json(&r.device().facts)),
            "scene": scene_json(&args.scene, &scene, &scene.fingerprint()),
            "plan": plan_json(&plan),
            "passes": graph.nodes.iter().map(|n| json!({ "name": n.name })).collect::<Vec<_>>(),
            "barriers": listed,
            "notes": plan.notes.iter().chain(&scene.warnings).collect::<Vec<_>>(),
        });
        report::write_json(path, &value)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn barrier_json(graph: &Graph, b: &hazard::Barrier) -> Value {
    let producers: Vec<_> = b
        .producers
        .iter()
        .map(|p| json!({ "node": p.node, "access": p.access.name(), "previous_frame": p.previous_frame }))
        .collect();
    json!({
        "resource": graph.name_of(b.resource),
        "hazard": b.hazard.name(),
        "producers": producers,
        "consumer": { "node": graph.nodes[b.before].name, "access": Access::name(b.consumer) },
        "src_stages": describe::stages(b.src_stages),
        "src_access": describe::accesses(b.src_access),
        "dst_stages": describe::stages(b.dst_stages),
        "dst_access": describe::accesses(b.dst_access),
        "old_layout": format!("{:?}", b.layouts.0),
        "new_layout": format!("{:?}", b.layouts.1),
        "sentence": describe::sentence(graph, b),
    })
}

/// Scene, technique, effects and notes for people.
pub fn summary(scene: &Scene, plan: &Plan) -> String {
    let mut out = format!(
        "scene     {}: {} in {}, {}, {}, {}\n",
        scene.name,
        report::count(scene.triangle_count(), "triangle"),
        report::count(scene.instances.len(), "instance"),
        report::count(scene.materials.len(), "material"),
        report::count(plan.materials.textures.len(), "texture"),
        report::count(scene.lights.len(), "light")
    );
    out += &format!("picture   {}x{} through camera \"{}\"\n", plan.view.width, plan.view.height, plan.view.name);
    out += &format!("plan      {}, {} shading\n", plan.technique.name(), plan.shading.name());
    out += &format!("why       {}\n", plan.technique_why);
    for (title, runs) in [("runs", true), ("skipped", false)] {
        for effect in plan.effects.iter().filter(|e| e.runs == runs) {
            let bytes = (effect.bytes > 0).then(|| report::bytes(effect.bytes));
            let ms = effect.ms.filter(|ms| ms.abs() >= 0.005).map(|ms| format!("about {ms:.2} ms"));
            let cost: Vec<String> = bytes.into_iter().chain(ms).collect();
            let cost = match (cost.is_empty(), runs) {
                (true, _) => String::new(),
                (false, true) => format!(" [{}]", cost.join(", ")),
                (false, false) => format!(" [{} saved]", cost.join(", ")),
            };
            out += &format!("  {title:<8} {:<13} {}{cost}\n", effect.name, effect.why);
        }
    }
    for note in plan.notes.iter().chain(&scene.warnings) {
        out += &format!("note      {note}\n");
    }
    out
}

/// The scene in machine form.
pub fn scene_json(spec: &str, scene: &Scene, fingerprint: &str) -> Value {
    json!({
        "name": spec,
        "fingerprint": fingerprint,
        "triangles": scene.triangle_count(),
        "instances": scene.instances.len(),
        "meshes": scene.meshes.len(),
        "materials": scene.materials.len(),
        "images": scene.images.len(),
        "lights": scene.lights.len(),
    })
}

/// The plan in machine form.
pub fn plan_json(plan: &Plan) -> Value {
    json!({
        "technique": plan.technique.name(),
        "why": plan.technique_why,
        "shading": plan.shading.name(),
        "samples": plan.samples,
        "width": plan.view.width,
        "height": plan.view.height,
        "camera": plan.view.name,
        "lights": plan.lights.count,
        "light_fetch": plan.lights.fetch.name(),
        "attachment_bytes": plan.attachment_bytes(),
        "static_bytes": plan.static_bytes(),
        "tiles": plan.tiles.as_ref().map(grids::tiles_json),
        "clusters": plan.clusters.as_ref().map(grids::clusters_json),
        "gbuffer": plan.deferred.as_ref().map(|deferred| grids::gbuffer_json(plan, &deferred.gbuffer)),
        "effects": plan.effects,
    })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::checks::scene_of_every_effect;
    use crate::cli::{Cli, Command};
    use crate::plan::{Limits, STATEMENTS};
    use crate::radiosity::bake::{Bake, PatchRule, Settings};
    use crate::radiosity::files;
    use crate::scene::write;

    /// Whether the effect runs in the plan of what was typed.
    fn runs(effect: &str, typed: &[&str]) -> bool {
        let Ok(Some(Command::Plan(args))) = Cli::try_parse_from(typed).map(|cli| cli.command) else {
            panic!("{typed:?}");
        };
        let (scene, request) = setup::scene_and_request(&args.scene, &args.shared).expect("a scene and a request");
        let limits = Limits { samples: [1 | 4; 2], float_blend: true, fragment_stores: true, ..Limits::MINIMUM };
        let plan = Plan::new(&scene, &request, &limits).expect("a plan");
        plan.effects.iter().any(|known| known.name == effect && known.runs)
    }

    #[test]
    fn what_is_said_to_turn_an_effect_off_does() {
        let folder = std::env::temp_dir().join(format!("lampyris-effects-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("all.glb");
        std::fs::write(&path, write::glb(&scene_of_every_effect()).expect("a file")).expect("written");
        let file = path.to_str().expect("a plain path");
        let bounced = format!("radiosity:{}", folder.join("bake").to_str().expect("a plain path"));
        let settings = Settings { patches: PatchRule::Count(20), ..Settings::default() };
        let baked = Bake::of_scene(&setup::load_scene("builtin:cornell").expect("a scene"), settings).expect("a bake");
        files::store(&baked, &folder.join("bake")).expect("a folder");
        let mut tried = 0;
        for statement in STATEMENTS {
            let options = statement.off.split('`').skip(1).step_by(2).filter(|option| option.starts_with("--"));
            for option in options {
                let technique = match (statement.name, option) {
                    ("light_volumes", _) => "deferred",
                    (_, "--assign tree") => "clustered-forward",
                    _ => "tiled-forward",
                };
                // Surfaces that see each other call for what an option asks for, too.
                let scene = if statement.name == "radiosity" { "builtin:cornell" } else { file };
                let mut typed = vec!["lampyris", "plan", scene, "--technique", technique];
                let with_samples = [&typed[..], &["--msaa", "4"]].concat();
                let with_patches = [&typed[..], &["--gi", &bounced]].concat();
                let base = match statement.name {
                    "msaa" => &with_samples,
                    "radiosity" => &with_patches,
                    _ => &typed,
                };
                assert!(runs(statement.name, base), "{} does not run", statement.name);
                if statement.name == "msaa" && option.starts_with("--forbid") {
                    typed.extend(["--msaa", "4"]);
                }
                typed.extend(option.split(' '));
                assert!(!runs(statement.name, &typed), "{option} does not turn {} off", statement.name);
                tried += 1;
            }
        }
        assert!(tried >= 14, "{tried} options");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
