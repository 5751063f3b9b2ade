//! Golden listings: a change of synchronization is a change of text in the same commit. `LAMPYRIS_BLESS=1` rewrites them.

use std::fs;
use std::path::PathBuf;

use lampyris::graph::{checker, describe, hazard, log};
use lampyris::passes::{self, Frame};
use lampyris::plan::{
    AssignChoice, DebugView, DeferredLights, Gathering, GbufferLayout, Gi, Limits, Plan, Request, ShadowUpdate,
    Technique, TransparentBounds,
};
use lampyris::radiosity::bake::{Bake, PatchRule, Settings};
use lampyris::scene::{Scene, builtin, scatter};

fn golden(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/barriers").join(format!("{name}.txt"))
}

fn cornell() -> Scene {
    builtin::load("cornell").expect("a built-in scene")
}

fn frame(scene: &Scene, request: &Request, limits: &Limits) -> Frame {
    passes::frame(&Plan::new(scene, request, limits).expect("a plan"))
}

fn compare(name: &str, request: &Request) {
    compare_with(name, &cornell(), request, &Limits::MINIMUM);
}

fn compare_with(name: &str, scene: &Scene, request: &Request, limits: &Limits) {
    let frame = frame(scene, request, limits);
    let barriers = hazard::derive(&frame.graph);
    let found = checker::check(&frame.graph, &log::declared(&frame.graph, &barriers, 3));
    assert!(found.is_empty(), "{name}: {found:#?}");
    for index in 0..barriers.len() {
        let mut fewer = barriers.clone();
        let removed = fewer.remove(index);
        let found = checker::check(&frame.graph, &log::declared(&frame.graph, &fewer, 3));
        assert!(!found.is_empty(), "{name}: not needed: {}", describe::sentence(&frame.graph, &removed));
    }
    let listing = describe::listing(&frame.graph, &barriers);
    let path = golden(name);
    if std::env::var_os("LAMPYRIS_BLESS").is_some() {
        fs::write(&path, &listing).expect("tests/barriers is writable");
    }
    let stored = fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(stored, listing, "{} differs", path.display());
}

#[test]
fn forward() {
    compare("forward", &Request { technique: Technique::Forward, ..Request::default() });
}

#[test]
fn forward_without_prepass() {
    compare("forward_no_prepass", &Request { technique: Technique::Forward, prepass: false, ..Request::default() });
}

#[test]
fn forward_in_parts() {
    let mut scene = cornell();
    scene.lights = scatter::point_lights(&scene.bounds(), 96, 1);
    // As many iterations as a group of 32 lights takes.
    let limits = Limits { max_loop_iterations: 68, ..Limits::MINIMUM };
    let request = Request { technique: Technique::Forward, ..Request::default() };
    compare_with("forward_in_parts", &scene, &request, &limits);
}

#[test]
fn tiled_forward() {
    compare("tiled_forward", &Request { technique: Technique::TiledForward, ..Request::default() });
}

#[test]
fn tiled_forward_without_prepass() {
    let request = Request { technique: Technique::TiledForward, prepass: false, ..Request::default() };
    compare("tiled_forward_no_prepass", &request);
}

/// What is drawn over the picture, too: an unlit surface and the lights.
#[test]
fn tiled_deferred_over_a_fat_gbuffer() {
    let mut scene = cornell();
    scene.materials[0].unlit = true;
    let limits = Limits { max_color_attachments: 5, ..Limits::MINIMUM };
    let request = Request {
        technique: Technique::TiledDeferred,
        gbuffer: GbufferLayout::Fat,
        show_lights: true,
        ..Request::default()
    };
    compare_with("tiled_deferred_fat", &scene, &request, &limits);
}

#[test]
fn deferred_volumes() {
    let limits = Limits { float_blend: true, ..Limits::MINIMUM };
    let request = Request { technique: Technique::Deferred, ..Request::default() };
    compare_with("deferred_volumes", &cornell(), &request, &limits);
}

#[test]
fn deferred_fullscreen() {
    let deferred_lights = DeferredLights::Fullscreen;
    let request = Request { technique: Technique::Deferred, deferred_lights, ..Request::default() };
    compare("deferred_fullscreen", &request);
}

#[test]
fn tiled_deferred() {
    compare("tiled_deferred", &Request { technique: Technique::TiledDeferred, ..Request::default() });
}

#[test]
fn clustered_deferred() {
    compare("clustered_deferred", &Request { technique: Technique::ClusteredDeferred, ..Request::default() });
}

#[test]
fn clustered_deferred_by_tree() {
    let technique = Technique::ClusteredDeferred;
    compare("clustered_deferred_tree", &Request { technique, assign: AssignChoice::Tree, ..Request::default() });
}

#[test]
fn clustered_deferred_by_normal() {
    let technique = Technique::ClusteredDeferred;
    compare("clustered_deferred_normals", &Request { technique, cluster_normals: true, ..Request::default() });
}

#[test]
fn clustered_forward() {
    compare("clustered_forward", &Request { technique: Technique::ClusteredForward, ..Request::default() });
}

#[test]
fn clustered_forward_of_merged_blocks() {
    let request = Request { technique: Technique::ClusteredForward, tile: 32, ..Request::default() };
    compare("clustered_forward_merged", &request);
}

#[test]
fn clustered_forward_without_prepass() {
    let request = Request { technique: Technique::ClusteredForward, prepass: false, ..Request::default() };
    compare("clustered_forward_no_prepass", &request);
}

/// Panes of glass, mixed in 32-bit floats, by fragment shaders that write buffers.
fn compare_glass(name: &str, request: Request, limits: Limits) {
    let glass = builtin::load("glass:layers=2").expect("a built-in scene");
    compare_with(name, &glass, &request, &Limits { float_blend: true, fragment_stores: true, ..limits });
}

#[test]
fn transparency_in_tiled_forward() {
    let own = Request { technique: Technique::TiledForward, ..Request::default() };
    let merged = Request { transparent_bounds: Some(TransparentBounds::Merged), ..own.clone() };
    compare_glass("tiled_forward_transparent", own, Limits::MINIMUM);
    compare_glass("tiled_forward_transparent_merged", merged, Limits::MINIMUM);
}

#[test]
fn transparency_in_clusters() {
    let technique = Technique::ClusteredDeferred;
    let request = Request { width: 320, height: 180, technique, ..Request::default() };
    compare_glass("clustered_deferred_transparent", request, Limits::MINIMUM);
}

#[test]
fn transparency_over_light_volumes() {
    let request = Request { technique: Technique::Deferred, ..Request::default() };
    compare_glass("deferred_transparent", request, Limits::MINIMUM);
}

#[test]
fn transparency_without_float_blending() {
    let glass = builtin::load("glass:layers=2").expect("a built-in scene");
    let request = Request { technique: Technique::Forward, ..Request::default() };
    compare_with("forward_transparent_layer", &glass, &request, &Limits::MINIMUM);
}

/// Four samples a pixel in every kind of attachment.
fn four_samples() -> Limits {
    Limits { max_image_dimension: 8192, samples: [1 | 4; 2], ..Limits::MINIMUM }
}

#[test]
fn several_samples_in_forward_techniques() {
    let tiled = Request { technique: Technique::TiledForward, msaa: 4, ..Request::default() };
    let clustered = Request { technique: Technique::ClusteredForward, ..tiled.clone() };
    compare_with("tiled_forward_msaa", &cornell(), &tiled, &four_samples());
    compare_with("clustered_forward_msaa", &cornell(), &clustered, &four_samples());
}

#[test]
fn several_samples_in_deferred_techniques() {
    let alone = Request { technique: Technique::Deferred, msaa: 4, ..Request::default() };
    compare_with("deferred_msaa", &cornell(), &alone, &four_samples());
    // Lights are drawn over it.
    let over = Request { technique: Technique::TiledDeferred, show_lights: true, ..alone };
    compare_with("tiled_deferred_msaa", &cornell(), &over, &four_samples());
}

/// The lamp of the box has a cube of maps, which are drawn once or in every frame.
#[test]
fn shadows_in_forward_and_deferred_techniques() {
    let once = Request { technique: Technique::Forward, shadows: Some(1), ..Request::default() };
    let each = Request { shadow_update: ShadowUpdate::Frame, ..once.clone() };
    let deferred = Request { technique: Technique::TiledDeferred, ..once.clone() };
    compare("forward_shadows", &once);
    compare("forward_shadows_each_frame", &each);
    compare("tiled_deferred_shadows", &deferred);
    // Opaque surfaces are lit by compute, blended ones by fragments.
    let both = Request { technique: Technique::ClusteredDeferred, width: 320, height: 180, ..once };
    compare_glass("clustered_deferred_shadows_transparent", both, Limits::MINIMUM);
}

#[test]
fn surface() {
    compare("surface", &Request { debug_view: Some(DebugView::Albedo), ..Request::default() });
}

/// What is gathered once while nothing moves, and in every frame.
#[test]
fn radiosity() {
    let settings = Settings { patches: PatchRule::Count(60), ..Settings::default() };
    let bake = std::sync::Arc::new(Bake::of_scene(&cornell(), settings).expect("a bake"));
    let request = Request {
        technique: Technique::TiledForward,
        gi: Gi::Radiosity(Gathering { gathers: Some(2), ..Gathering::default() }),
        bake: Some(bake),
        shadow_size: 128,
        ..Request::default()
    };
    compare("radiosity", &request);
    compare("radiosity_every_frame", &Request { shadow_update: ShadowUpdate::Frame, ..request.clone() });
    // Light goes on from frame to frame, shadow maps are drawn once.
    let gi = Gi::Radiosity(Gathering { feedback: true, ..Gathering::default() });
    compare("radiosity_feedback", &Request { gi, ..request });
}
