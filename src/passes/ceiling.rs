//! Ceiling: a full-screen loop over all lights on a made-up surface. No geometry, no depth: what is left is the time of shading,
//! against which techniques are measured (`bench ceiling`).
//!
//! Reads: frame, lights. Writes: radiance (RGBA32F). Limits: as `forward`. CPU twin: `reference/shade.rs`.

use super::forward::light_constants;
use super::{Frame, RADIANCE_FORMAT, SceneHandles, read_back};
use crate::graph::access::{FragmentStorageRead, FragmentTexel, FragmentUniform};
use crate::graph::{Graph, GraphicsPipeline, Lifetime, Render, Work};
use crate::plan::Plan;
use crate::shaders::shade::ceiling;

/// The frame that does nothing else.
pub fn frame(plan: &Plan) -> Frame {
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let extent = [plan.view.width, plan.view.height];
    let radiance = graph.image("radiance", RADIANCE_FORMAT, extent, Lifetime::Transient);
    let set = ceiling::Bindings {
        frame: FragmentUniform(scene.frame),
        lights_storage: FragmentStorageRead(scene.lights),
        lights_uniform: FragmentUniform(scene.lights),
        lights_texel: FragmentTexel(scene.lights),
        shadow_atlas: None,
        shadow_maps: None,
        bounced_places: None,
        bounced_words: None,
        bounced_words_storage: None,
        bounced_light: None,
    };
    let constants = light_constants(plan);
    let spec = ceiling::Spec {
        LIGHT_FETCH: constants.fetch,
        LIGHT_KINDS: constants.kinds,
        LIGHT_TEXELS: constants.texels,
        LIGHT_UNIFORM_TEXELS: constants.uniform_texels,
        LIGHT_SEEK: constants.seek,
        INVERSE_SQUARE: constants.inverse_square,
        SHADOW_KINDS: 0,
        SHADOW_FILTER: 0,
        BOUNCED: false,
        BOUNCED_STORAGE: false,
        SHADING: constants.shading,
    };
    let pipeline = GraphicsPipeline::full_screen(&ceiling::PROGRAM, spec.values(), RADIANCE_FORMAT);
    let render = Render::full_screen(radiance, extent, set.list(), vec![pipeline]);
    graph.add("ceiling", Work::Render(render));
    graph.end_frame();
    let results = read_back::add(&mut graph, &[("radiance", radiance)]);
    Frame { graph, scene, results }
}
