//! G-buffer: what lights need to know of the nearest lit surface, a texel a pixel (Saito and Takahashi, "Comprehensible rendering of 3-D
//! shapes", SIGGRAPH 1990; its use for many lights as in Akenine-Möller et al., Real-Time Rendering, 4th ed., section 20.1).
//!
//! Reads: frame, instances, materials, material textures, vertices, indices; depth of the pre-pass, where there is one (tested for
//! equality, not written). Writes: the layers, cleared to 0, and depth without a pre-pass. Unlit surfaces are left to `unlit`: where
//! one is nearest the layers keep 0 (after a pre-pass) or what lies behind it, which `unlit` covers.
//! Limits: the fat layout takes five colour attachments, the plan refuses it where there are four. CPU twin: `reference/surface.rs`,
//! and `reference/octahedral.rs` for normals.
//!
//! | layout | image | format | holds |
//! |---|---|---|---|
//! | compact | `gbuffer_base_color` | A2B10G10R10_UNORM | square root of the base colour; 1 where a surface is |
//! | | `gbuffer_normals` | R16G16, A2B10G10R10 or R8G8, UINT; R16G16B16A16 where materials are told apart | octahedral codes; number of the material |
//! | | `gbuffer_material` | R8G8B8A8_UNORM | roughness in 16 bits, metalness, occlusion |
//! | | `gbuffer_emission` | R16G16B16A16_SFLOAT | emission, where something emits |
//! | fat | five | R32G32B32A32_SFLOAT | position and roughness; normal and occlusion; base colour and metalness; specular colour and 1 plus the number of the material where a surface is; ambient light and emission |
//!
//! Codes are UINT at every width, so that they are exact and one shader writes all three.

use ash::vk;

use super::forward::depth_state;
use super::resources::{SceneHandles, chosen};
use super::{DEPTH_FORMAT, Frame, RADIANCE_FORMAT, depth_prepass, nearest_sampler, read_back};
use crate::graph::access::{ComputeSampled, GraphicsStorageRead, GraphicsUniform, VertexStorageRead, VertexUniform};
use crate::graph::{
    Access, Binding, Blend, ColorAttachment, DepthAttachment, Graph, GraphicsPipeline, ImageHandle, Render, Work,
};
use crate::plan::materials::Variant;
use crate::plan::{Gbuffer, GbufferLayout, Plan};
use crate::shaders::shade::{gbuffer, gbuffer_emissive, gbuffer_fat};
use crate::shared;

/// What readers of the G-buffer bind. What the layout lacks is another image of the same kind, which their shaders do not read.
#[derive(Debug, Clone, Copy)]
pub struct Layers {
    /// D32F, reversed; always the scene's.
    pub depth: ImageHandle,
    /// As the shaders' `gbuffer_depth`.
    pub sampled_depth: ImageHandle,
    /// Compact.
    pub base_color: ImageHandle,
    /// Compact.
    pub normals: ImageHandle,
    /// Compact.
    pub material: ImageHandle,
    /// Compact, where something emits.
    pub emission: ImageHandle,
    /// Fat.
    pub position_roughness: ImageHandle,
    /// Fat.
    pub normal_occlusion: ImageHandle,
    /// Fat.
    pub base_metallic: ImageHandle,
    /// Fat.
    pub specular_flag: ImageHandle,
    /// Fat.
    pub ambient_emission: ImageHandle,
    /// Compact, of several samples a pixel: depth, base colour, normals, material and emission.
    pub samples: Option<[ImageHandle; 5]>,
    /// Pixels whose samples differ.
    pub edges: Option<ImageHandle>,
}

impl Layers {
    fn new(graph: &Graph, depth: ImageHandle, planned: &Gbuffer, images: &[ImageHandle], scene: &SceneHandles) -> Self {
        if graph.image_info(depth).samples > 1 {
            return Self::of_samples(depth, images, scene);
        }
        let any = images[0];
        let mut layers = Self {
            depth,
            sampled_depth: any,
            base_color: any,
            normals: scene.no_normals.unwrap_or(any),
            material: any,
            emission: any,
            position_roughness: any,
            normal_occlusion: any,
            base_metallic: any,
            specular_flag: any,
            ambient_emission: any,
            samples: None,
            edges: None,
        };
        match planned.layout {
            GbufferLayout::Compact => {
                layers.sampled_depth = depth;
                layers.normals = images[1];
                layers.material = images[2];
                layers.emission = images.get(3).copied().unwrap_or(any);
            }
            GbufferLayout::Fat => {
                layers.normal_occlusion = images[1];
                layers.base_metallic = images[2];
                layers.specular_flag = images[3];
                layers.ambient_emission = images[4];
            }
        }
        layers
    }

    fn of_samples(depth: ImageHandle, images: &[ImageHandle], scene: &SceneHandles) -> Self {
        let any = scene.textures.last().copied().unwrap_or(depth);
        Self {
            depth,
            sampled_depth: any,
            base_color: any,
            normals: scene.no_normals.unwrap_or(any),
            material: any,
            emission: any,
            position_roughness: any,
            normal_occlusion: any,
            base_metallic: any,
            specular_flag: any,
            ambient_emission: any,
            samples: Some([depth, images[0], images[1], images[2], images.get(3).copied().unwrap_or(images[0])]),
            edges: None,
        }
    }

    /// Image `index` of those of several samples, as compute shaders bind it.
    pub fn of_sample(&self, index: usize) -> Option<ComputeSampled> {
        self.samples.map(|images| ComputeSampled(images[index], nearest_sampler()))
    }

    /// The pixels whose samples differ, or an image that is not read.
    pub fn edges_or(&self, scene: &SceneHandles) -> ImageHandle {
        self.edges.or(scene.no_normals).unwrap_or(self.sampled_depth)
    }

    /// The images that the layout has, in attachment order.
    fn images(&self, planned: &Gbuffer) -> Vec<ImageHandle> {
        match planned.layout {
            GbufferLayout::Compact => {
                let mut images = vec![self.base_color, self.normals, self.material];
                images.extend(planned.emission.then_some(self.emission));
                images
            }
            GbufferLayout::Fat => vec![
                self.position_roughness,
                self.normal_occlusion,
                self.base_metallic,
                self.specular_flag,
                self.ambient_emission,
            ],
        }
    }

    /// Bindings of a fragment shader that reads depth, with the one layout that serves sampling and a depth test alike.
    pub fn with_depth(&self, mut bindings: Vec<Binding>) -> Vec<Binding> {
        if self.sampled_depth == self.depth {
            for binding in bindings.iter_mut().filter(|b| b.name == "gbuffer_depth") {
                binding.access = Access::FragmentDepthSampled;
            }
        }
        bindings
    }
}

/// Values of the constants that every reader shares.
pub struct GbufferConstants {
    /// GBUFFER.
    pub layout: u32,
    /// NORMAL_BITS.
    pub normal_bits: u32,
    /// EMISSION.
    pub emission: bool,
    /// STORED_MATERIAL.
    pub material: bool,
}

/// The readers' constants.
pub fn gbuffer_constants(planned: &Gbuffer) -> GbufferConstants {
    let layout = match planned.layout {
        GbufferLayout::Compact => shared::GBUFFER_COMPACT,
        GbufferLayout::Fat => shared::GBUFFER_FAT,
    };
    GbufferConstants {
        layout,
        normal_bits: planned.normal_bits,
        emission: planned.emission,
        material: planned.material,
    }
}

/// Names and formats in attachment order.
fn attachments(planned: &Gbuffer) -> Vec<(&'static str, vk::Format)> {
    if planned.layout == GbufferLayout::Fat {
        return vec![
            ("gbuffer_position_roughness", RADIANCE_FORMAT),
            ("gbuffer_normal_occlusion", RADIANCE_FORMAT),
            ("gbuffer_base_metallic", RADIANCE_FORMAT),
            ("gbuffer_specular_flag", RADIANCE_FORMAT),
            ("gbuffer_ambient_emission", RADIANCE_FORMAT),
        ];
    }
    let normals = match planned.normal_bits {
        _ if planned.material => vk::Format::R16G16B16A16_UINT,
        8 => vk::Format::R8G8_UINT,
        10 => vk::Format::A2B10G10R10_UINT_PACK32,
        _ => vk::Format::R16G16_UINT,
    };
    let mut list = vec![
        ("gbuffer_base_color", vk::Format::A2B10G10R10_UNORM_PACK32),
        ("gbuffer_normals", normals),
        ("gbuffer_material", vk::Format::R8G8B8A8_UNORM),
    ];
    if planned.emission {
        list.push(("gbuffer_emission", vk::Format::R16G16B16A16_SFLOAT));
    }
    list
}

/// Adds the pass; `prepass` is the depth that is there already.
pub fn add(
    graph: &mut Graph,
    plan: &Plan,
    planned: &Gbuffer,
    scene: &SceneHandles,
    prepass: Option<ImageHandle>,
) -> Layers {
    let extent = [plan.view.width, plan.view.height];
    let depth = prepass.unwrap_or_else(|| graph.image_of_samples("depth", DEPTH_FORMAT, extent, plan.samples));
    let images: Vec<_> =
        attachments(planned).iter().map(|&(name, f)| graph.image_of_samples(name, f, extent, plan.samples)).collect();
    let (distinct, draws) = chosen(plan, |v| !v.unlit);
    let render = Render {
        colors: images.iter().map(|&image| ColorAttachment { image, clear: Some([0.0; 4]) }).collect(),
        depth: Some(DepthAttachment { image: depth, clear: prepass.is_none().then_some(0.0) }),
        extent,
        bindings: bindings(planned, scene),
        material_bindings: scene.material_bindings.clone(),
        pipelines: distinct.iter().map(|&v| pipeline(plan, planned, v, prepass.is_some())).collect(),
        draws,
        vertices: Some(scene.vertices),
        indices: Some(scene.indices),
    };
    graph.add("gbuffer", Work::Render(render));
    Layers::new(graph, depth, planned, &images, scene)
}

/// The frame that makes the G-buffer and leaves its images as they are stored, by the names above. `None` where the technique has none.
pub fn gbuffer_frame(plan: &Plan) -> Option<Frame> {
    let plan = &Plan { samples: 1, ..plan.clone() };
    let planned = &plan.deferred.as_ref()?.gbuffer;
    let mut graph = Graph::new();
    let scene = SceneHandles::declare(&mut graph, plan);
    let depth = plan.prepass.then(|| depth_prepass::add(&mut graph, plan, &scene));
    let layers = add(&mut graph, plan, planned, &scene, depth);
    graph.end_frame();
    let names = attachments(planned).into_iter().map(|attachment| attachment.0);
    let images: Vec<_> = names.zip(layers.images(planned)).collect();
    let results = read_back::add_pictures(&mut graph, &images);
    Some(Frame { graph, scene, results })
}

fn bindings(planned: &Gbuffer, scene: &SceneHandles) -> Vec<Binding> {
    if planned.layout == GbufferLayout::Fat {
        let set = gbuffer_fat::Bindings {
            frame: GraphicsUniform(scene.frame),
            instances: VertexStorageRead(scene.instances),
            materials: GraphicsStorageRead(scene.materials),
        };
        return set.list();
    }
    let set = gbuffer::Bindings {
        frame: VertexUniform(scene.frame),
        instances: VertexStorageRead(scene.instances),
        materials: GraphicsStorageRead(scene.materials),
    };
    set.list()
}

fn pipeline(plan: &Plan, planned: &Gbuffer, variant: Variant, after_prepass: bool) -> GraphicsPipeline {
    // The same constants as those of the two other programs but for NORMAL_BITS, which the fat one lacks.
    let spec = gbuffer::Spec {
        TEXTURES: variant.textures,
        ALPHA_MASK: variant.masked,
        UV_SETS: variant.uv_sets,
        UV_TRANSFORMS: variant.uv_transforms,
        VERTEX_COLORS: variant.vertex_colors,
        UNLIT: false,
        MIRRORED_LENS: plan.view.lens.mirrors(),
        PERSPECTIVE: plan.view.lens.is_perspective(),
        SAMPLES: plan.samples,
        NORMAL_BITS: planned.normal_bits,
    };
    let program = match planned {
        Gbuffer { layout: GbufferLayout::Fat, .. } => &gbuffer_fat::PROGRAM,
        Gbuffer { emission: true, .. } => &gbuffer_emissive::PROGRAM,
        _ => &gbuffer::PROGRAM,
    };
    GraphicsPipeline {
        program,
        constants: spec.values(),
        colors: attachments(planned).iter().map(|a| a.1).collect(),
        blend: Blend::Replace,
        depth: Some(depth_state(after_prepass)),
        depth_clamp: false,
        samples: plan.samples,
        sample_mask: u32::MAX,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{checker, hazard, log};
    use crate::plan::{Limits, Request, Technique};
    use crate::scene::builtin;

    fn planned(request: Request) -> Plan {
        let scene = builtin::load("cornell").expect("a built-in scene");
        let limits = Limits { max_color_attachments: 5, ..Limits::MINIMUM };
        Plan::new(&scene, &Request { width: 16, height: 9, ..request }, &limits).expect("a plan")
    }

    fn names(frame: &Frame) -> Vec<&str> {
        frame.results.iter().map(|result| result.0).collect()
    }

    #[test]
    fn what_is_stored_comes_back_in_as_many_bytes() {
        let compact = Request { technique: Technique::TiledDeferred, ..Request::default() };
        let fat = Request { gbuffer: GbufferLayout::Fat, prepass: false, ..compact.clone() };
        let coarse = Request { normal_bits: 8, technique: Technique::Deferred, ..compact.clone() };
        for request in [compact, fat, coarse] {
            let plan = planned(request);
            let frame = gbuffer_frame(&plan).expect("a G-buffer");
            let barriers = hazard::derive(&frame.graph);
            let found = checker::check(&frame.graph, &log::declared(&frame.graph, &barriers, 3));
            assert!(found.is_empty(), "{found:#?}");
            let bytes: u64 = frame.results.iter().map(|result| frame.graph.buffer_info(result.1).bytes).sum();
            let gbuffer = plan.deferred.as_ref().expect("a G-buffer").gbuffer;
            assert_eq!(bytes, gbuffer.texel_bytes() * plan.pixels(), "{:?}", names(&frame));
        }
        let forward = Request { technique: Technique::Forward, ..Request::default() };
        assert!(gbuffer_frame(&planned(forward)).is_none());
    }
}
