//! Sample edges: pixels of a G-buffer whose samples show different surfaces, so that only these are lit sample by sample (A. Lauritzen, "Deferred
//! Rendering for Current and Future Rendering Pipelines", SIGGRAPH 2010).
//!
//! Reads: frame, G-buffer of several samples. Writes: an R32_UINT image, 1 where samples differ. Groups of 8x8, a thread a pixel. Limits: the
//! compact layout. CPU twin: rays through the samples (`check --only msaa_edges`).

use ash::vk;

use super::gbuffer::{Layers, gbuffer_constants};
use super::{Frame, RADIANCE_FORMAT, SceneHandles, depth_prepass, dispatch, gbuffer, nearest_sampler, read_back};
use crate::graph::access::{ComputeImageWrite, ComputeSampled, ComputeStorageRead, ComputeUniform};
use crate::graph::{Contents, Graph, ImageHandle, Lifetime};
use crate::plan::{Gbuffer, Plan};
use crate::shaders::shade::sample_edges;

/// What passes that light a G-buffer in compute write: the picture, or the samples of each pixel side by side.
pub fn target(graph: &mut Graph, plan: &Plan) -> ImageHandle {
    let (width, height) = (plan.view.width, plan.view.height);
    let (name, wide) = if plan.spreads_samples() { ("radiance_texels", plan.samples) } else { ("radiance", 1) };
    graph.image(name, RADIANCE_FORMAT, [width * wide, height], Lifetime::Transient)
}

/// Adds the pass; the image of edges. Nothing where there is one sample a pixel.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    planned: &Gbuffer,
    scene: &SceneHandles,
    layers: &Layers,
) -> Option<ImageHandle> {
    layers.samples?;
    let size = [plan.view.width, plan.view.height];
    let edges = graph.image("sample_edges", vk::Format::R32_UINT, size, Lifetime::Transient);
    let sampled = |image| ComputeSampled(image, nearest_sampler());
    let set = sample_edges::Bindings {
        frame: ComputeUniform(scene.frame),
        materials: ComputeStorageRead(scene.materials),
        sample_edges: ComputeImageWrite(edges, Contents::Discarded),
        gbuffer_depth: sampled(layers.sampled_depth),
        gbuffer_base_color: sampled(layers.base_color),
        gbuffer_normals: sampled(layers.normals),
        gbuffer_material: sampled(layers.material),
        gbuffer_emission: sampled(layers.emission),
        gbuffer_position_roughness: sampled(layers.position_roughness),
        gbuffer_normal_occlusion: sampled(layers.normal_occlusion),
        gbuffer_base_metallic: sampled(layers.base_metallic),
        gbuffer_specular_flag: sampled(layers.specular_flag),
        gbuffer_ambient_emission: sampled(layers.ambient_emission),
        depth_samples: layers.of_sample(0),
        base_color_samples: layers.of_sample(1),
        normals_samples: layers.of_sample(2),
        material_samples: layers.of_sample(3),
        emission_samples: layers.of_sample(4),
    };
    let constants = gbuffer_constants(planned);
    let spec = sample_edges::Spec {
        GBUFFER: constants.layout,
        NORMAL_BITS: constants.normal_bits,
        EMISSION: constants.emission,
        STORED_MATERIAL: false,
        SAMPLES: plan.samples,
    };
    let groups = [size[0].div_ceil(8), size[1].div_ceil(8), 1];
    graph.add("sample_edges", dispatch(&sample_edges::PROGRAM, spec.values(), set.list(), groups));
    Some(edges)
}

/// The frame that finds edges and leaves them. `None` where the plan has no G-buffer of several samples.
pub fn edges_frame(plan: &Plan) -> Option<Frame> {
    let planned = &plan.deferred.as_ref()?.gbuffer;
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let depth = plan.prepass.then(|| depth_prepass::add(&mut graph, plan, &scene));
    let layers = gbuffer::add(&mut graph, plan, planned, &scene, depth);
    let edges = add(&mut graph, plan, planned, &scene, &layers)?;
    graph.end_frame();
    let results = read_back::add_all(&mut graph, &[("sample_edges", edges)], &[]);
    Some(Frame { graph, scene, results })
}
