//! Shadow maps: depth as lights see it, each map in its part of one image, in one rendering scope (L. Williams, "Casting Curved Shadows on Curved
//! Surfaces", 1978).
//!
//! Reads: frame, instances, vertices, indices; materials and base colour maps where a material is masked.
//! Writes: `shadow_atlas`, depth reversed, cleared to 0: nothing stands in the way.
//! Both faces of a surface stand in the way of light; blended ones let it through. Depth is pushed away from the light by as much as a triangle's
//! depth changes over the texels that one position is compared with. Limits: what one image holds; the plan makes maps smaller. Oracle: the rays of
//! `reference/render.rs`.

use std::collections::BTreeMap;

use super::depth_prepass::{COMPARE, alpha_only};
use super::resources::{ShadowHandles, draw};
use super::{DEPTH_FORMAT, SceneHandles};
use crate::graph::access::{GraphicsStorageRead, VertexStorageRead, VertexUniform};
use crate::graph::{
    Blend, Cull, DepthAttachment, DepthBias, DepthState, Draw, DrawView, Graph, GraphicsPipeline, Lifetime, Render,
    Work,
};
use crate::plan::materials::Variant;
use crate::plan::{Plan, Shadows};
use crate::shaders::shadow::{shadow_map, shadow_map_masked};
use crate::shared;

/// Steps of the depth format that a map's depth is pushed away by, besides its slope: what rounding leaves of a triangle's plane.
const ROUNDING_STEPS: i32 = 8;

/// Adds the pass where a light has a shadow; what shading reads afterwards stands in `scene`.
pub fn add(graph: &mut Graph, plan: &Plan, scene: &mut SceneHandles) {
    let Some(shadows) = &plan.shadows else { return };
    let atlas = graph.image("shadow_atlas", DEPTH_FORMAT, shadows.atlas, Lifetime::Transient);
    let maps = graph.buffer("shadow_maps", shadows.texel_bytes(), Lifetime::Static);
    let (variants, draws) = draws(plan, shadows);
    let any_masked = variants.iter().any(|v| v.masked);
    let bindings = if any_masked {
        let set = shadow_map_masked::Bindings {
            frame: VertexUniform(scene.frame),
            instances: VertexStorageRead(scene.instances),
            materials: GraphicsStorageRead(scene.materials),
        };
        set.list()
    } else {
        let set =
            shadow_map::Bindings { frame: VertexUniform(scene.frame), instances: VertexStorageRead(scene.instances) };
        set.list()
    };
    let render = Render {
        colors: Vec::new(),
        depth: Some(DepthAttachment { image: atlas, clear: Some(0.0) }),
        extent: shadows.atlas,
        bindings,
        material_bindings: if any_masked { scene.material_bindings.clone() } else { Vec::new() },
        pipelines: variants.iter().map(|&variant| pipeline(shadows, variant)).collect(),
        draws,
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    };
    graph.add("shadow_map", Work::Render(render));
    scene.shadows = Some(ShadowHandles { atlas, maps });
}

/// Distinct pipelines, and the draws of all maps in their order.
fn draws(plan: &Plan, shadows: &Shadows) -> (Vec<Variant>, Vec<Draw>) {
    let mut pipelines = BTreeMap::new();
    let mut draws = Vec::new();
    if shadows.holds_places() {
        // Whatever comes to stand in the light has its pipeline.
        for planned in &plan.geometry.draws {
            let next = pipelines.len();
            pipelines.entry(of_caster(planned.variant)).or_insert(next);
        }
    }
    for map in &shadows.maps {
        let view = DrawView { area: map.area, to_clip: map.view_to_map.as_mat4().to_cols_array_2d() };
        for caster in &map.draws {
            let planned = &plan.geometry.draws[caster.draw];
            let next = pipelines.len();
            let pipeline = *pipelines.entry(of_caster(planned.variant)).or_insert(next);
            draws.push(Draw {
                instance_offset: caster.instance_offset,
                instance_count: caster.instance_count,
                cull: Cull::None,
                view: Some(view),
                ..draw(plan, planned, pipeline)
            });
        }
    }
    let mut variants: Vec<(Variant, usize)> = pipelines.into_iter().collect();
    variants.sort_by_key(|(_, index)| *index);
    (variants.into_iter().map(|(variant, _)| variant).collect(), draws)
}

fn of_caster(variant: Variant) -> Variant {
    if variant.masked { seen_by_light(variant) } else { Variant::default() }
}

/// What decides whether a masked fragment exists: parallax is for the eye.
fn seen_by_light(variant: Variant) -> Variant {
    let alpha = alpha_only(variant);
    Variant { textures: alpha.textures & shared::TEXTURE_BASE_COLOR, ..alpha }
}

fn pipeline(shadows: &Shadows, variant: Variant) -> GraphicsPipeline {
    // A position is compared with texels whose middles are up to (filter + 1) / 2 away in column and in row, over which the depth of its own plane
    // changes by filter + 1 slopes at most. Half of that is taken off the position (glsl/inc/shadow.glsl); the other half, and half a texel or a
    // whole one for other planes that meet it there, is taken off the map. Measured by `check --only shadow_error,shadow_acne`: with all of it in
    // the map walls of a few texels leak, with none in it corners shade themselves.
    let slope = (shadows.filter as i32 + 3) / 2;
    let bias = DepthBias { constant: -ROUNDING_STEPS, slope: -slope };
    let depth = Some(DepthState { bias, ..DepthState::write(DEPTH_FORMAT, COMPARE) });
    let (program, constants) = if variant.masked {
        let spec = shadow_map_masked::Spec {
            TEXTURES: variant.textures,
            ALPHA_MASK: true,
            UV_SETS: variant.uv_sets,
            UV_TRANSFORMS: variant.uv_transforms,
            VERTEX_COLORS: variant.vertex_colors,
            UNLIT: true,
            MIRRORED_LENS: false,
            PERSPECTIVE: true,
            SAMPLES: 1,
        };
        (&shadow_map_masked::PROGRAM, spec.values())
    } else {
        (&shadow_map::PROGRAM, Vec::new())
    };
    GraphicsPipeline {
        program,
        constants,
        colors: Vec::new(),
        blend: Blend::Replace,
        depth,
        depth_clamp: false,
        samples: 1,
        sample_mask: u32::MAX,
    }
}
