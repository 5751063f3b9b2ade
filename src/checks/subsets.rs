//! Every subset of effects as a scene that calls for them and for nothing else: what the plan decides, without a device, and a covering
//! array of them on the device. What is forbidden is as if it had not been called for, and what is forced with neutral input changes nothing.

use std::collections::BTreeSet;

use glam::{DMat4, DVec3};

use super::Row;
use super::hard::fixtures::{looking, point, scene, spot, wall};
use super::lists::differing;
use super::oracle::shader;
use crate::error::{Error, Result};
use crate::graph::log::Event;
use crate::graph::{Graph, Work};
use crate::passes;
use crate::plan::overrides::{EffectName, apply};
use crate::plan::{Limits, Plan, Request, Technique};
use crate::reference::render::Reference;
use crate::renderer::Renderer;
use crate::scene::shading::{Model, OwnModel};
use crate::scene::{
    AlphaMode, Height, IDENTITY_UV, Image, Instance, LightKind, Material, Mesh, Sampler, Scene, Texture,
};
use crate::shared::{KIND_DIRECTIONAL, KIND_POINT, KIND_SPOT};

/// What a scene may call for, a bit each.
pub(super) const CALLS: [&str; 9] = [
    "transparency",
    "alpha_mask",
    "normal_maps",
    "parallax",
    "spot",
    "directional",
    "msaa",
    "material_models",
    "shadows",
];

fn called(bits: u32, name: &str) -> bool {
    CALLS.iter().position(|call| *call == name).is_some_and(|at| bits & 1 << at != 0)
}

/// A wall and a panel in front of it, with a material and a light for each bit.
pub(super) fn scene_of(bits: u32) -> Scene {
    let mut back = Mesh { uvs: [vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], Vec::new()], ..wall(4.0) };
    let mapped = called(bits, "normal_maps") || called(bits, "parallax");
    if mapped {
        back.tangents = vec![[1.0, 0.0, 0.0, 1.0]; 4];
    }
    let camera = looking([0.4, 0.3, 5.0], [0.0, 0.0, 0.0], 60.0);
    let mut scene = scene(back, Vec::new(), camera);
    let sampler = Sampler::default();
    let texture = |image: usize| Texture { image, sampler, uv_set: 0, uv_transform: IDENTITY_UV };
    let image = |name: &str, of: fn(u32, u32) -> [u8; 4]| {
        let rgba8 = (0..8).flat_map(|y| (0..8).flat_map(move |x| of(x, y))).collect();
        Image { name: name.into(), width: 8, height: 8, rgba8 }
    };
    scene.images = vec![
        image("bent", |x, y| [96 + 8 * x as u8, 96 + 8 * y as u8, 240, 255]),
        image("deep", |x, y| [(128.0 + 100.0 * (f64::from(x * y) * 0.4).sin()) as u8; 4]),
    ];
    let material = &mut scene.materials[0];
    material.normal_texture = called(bits, "normal_maps").then(|| texture(0));
    material.height = called(bits, "parallax").then(|| Height { texture: texture(1), channel: 0, scale: 0.05 });
    let mut add = |x: f64, material: Material| {
        scene.materials.push(material);
        scene.meshes.push(Mesh { material: scene.materials.len() - 1, ..wall(0.7) });
        let object_to_world = DMat4::from_translation(DVec3::new(x, 0.2 * x, 1.5 + 0.1 * x));
        scene.instances.push(Instance { mesh: scene.meshes.len() - 1, object_to_world });
    };
    let plain = Material { metallic: 0.0, roughness: 0.6, ..Material::default() };
    if called(bits, "transparency") {
        let base_color = [0.4, 0.7, 0.9, 0.4];
        add(-0.6, Material { base_color, alpha: AlphaMode::Blend, double_sided: true, ..plain.clone() });
    }
    if called(bits, "alpha_mask") {
        add(0.5, Material { alpha: AlphaMode::Mask(0.5), ..plain.clone() });
    }
    if called(bits, "material_models") {
        let own = OwnModel { model: Model::CarPaint, color: [0.1, 0.2, 0.9], exponent: 2.0 };
        add(1.2, Material { model: Some(own), ..plain });
    }
    if called(bits, "spot") {
        scene.lights.push(spot(DVec3::new(1.0, 1.0, 3.0), DVec3::NEG_Z, 0.2, 0.6));
    }
    if called(bits, "directional") {
        let direction = DVec3::new(-0.3, -0.4, -1.0).normalize();
        scene.lights.push(crate::scene::Light { kind: LightKind::Directional, direction, ..point(DVec3::ZERO, 1.5) });
    }
    if scene.lights.is_empty() {
        scene.lights.push(point(DVec3::new(-0.5, 0.6, 2.5), 8.0));
    }
    scene.lights[0].shadow = called(bits, "shadows");
    scene
}

/// One that calls for everything.
#[cfg(test)]
pub(crate) fn scene_of_every_effect() -> Scene {
    scene_of((1 << CALLS.len()) - 1)
}

pub(super) fn request_of(bits: u32, technique: Technique) -> Request {
    let msaa = if called(bits, "msaa") { 4 } else { 1 };
    Request { width: 64, height: 48, technique, msaa, shadow_size: 128, ..crate::checks::forward() }
}

/// Names of passes, pipelines with their constants, and images and buffers with their sizes: all that a frame consists of.
fn trace(graph: &Graph) -> Vec<String> {
    let mut lines = Vec::new();
    for node in &graph.nodes {
        lines.push(format!("{}: {:?}", node.name, node.accesses));
        match &node.work {
            Work::Dispatch { pipeline, groups, push, .. } => {
                lines.push(format!("{} {:?} {groups:?} {push:?}", pipeline.program.name, pipeline.constants));
            }
            Work::Render(render) => {
                lines.extend(render.pipelines.iter().map(|p| format!("{p:?}")));
                lines.push(format!("{:?}", render.draws));
            }
            _ => {}
        }
    }
    lines.extend(graph.images.iter().map(|image| format!("{image:?}")));
    lines.extend(graph.buffers.iter().map(|buffer| format!("{buffer:?}")));
    lines
}

/// What the plan of a subset gets wrong, in words.
fn wrong(bits: u32, technique: Technique, limits: &Limits) -> Result<Vec<String>> {
    let scene = scene_of(bits);
    let plan = Plan::new(&scene, &request_of(bits, technique), limits)?;
    let mut wrong = Vec::new();
    let mut expect = |what: &str, found: bool, wanted: bool| {
        if found != wanted {
            wrong.push(format!("{bits:09b} {}: {what} is {found}", technique.name()));
        }
    };
    for name in CALLS.iter().filter(|name| !["spot", "directional"].contains(name)) {
        let runs = plan.effects.iter().any(|effect| effect.name == *name && effect.runs);
        expect(name, runs, called(bits, name));
    }
    let [spots, suns] = ["spot", "directional"].map(|name| called(bits, name));
    let kinds = if spots { KIND_SPOT } else { 0 } | if suns { KIND_DIRECTIONAL } else { 0 };
    let kinds = if kinds == 0 { KIND_POINT } else { kinds };
    expect("only the kinds of lights that there are", plan.lights.kinds == kinds, true);
    let listed = !matches!(technique, Technique::Forward | Technique::Deferred) && (spots || !suns);
    expect("grid of tiles", plan.tiles.is_some(), listed);
    expect("cones", plan.tiles.as_ref().is_some_and(|tiles| !tiles.cones.is_empty()), spots && listed);
    expect("buffers of lists", passes::frame(&plan).graph.buffers.iter().any(|b| b.name.contains("tile_")), listed);
    let graph = passes::frame(&plan).graph;
    let names: BTreeSet<&str> = graph.nodes.iter().map(|node| node.name.as_str()).collect();
    let any = |prefix: &str| names.iter().any(|name| name.starts_with(prefix));
    expect("transparent passes", any("transparent"), called(bits, "transparency"));
    expect("msaa passes", any("msaa") || any("sample_edges"), called(bits, "msaa"));
    expect("images of samples", graph.images.iter().any(|image| image.samples > 1), called(bits, "msaa"));
    let constants = |name: &str, id: u32, value: u32| {
        let of = |render: &crate::graph::Render| {
            let shaded = render.pipelines.iter().filter(|p| p.program.name.starts_with(name));
            shaded.flat_map(|p| p.constants.clone()).any(|(at, bits)| at == id && bits & value != 0)
        };
        graph.nodes.iter().any(|node| matches!(&node.work, Work::Render(render) if of(render)))
    };
    // TEXTURES and ALPHA_MASK of glsl/inc/surface.glsl.
    expect("shadow passes", any("shadow_map"), called(bits, "shadows"));
    let named = |name: &str| name.starts_with("shadow");
    expect("images of shadows", graph.images.iter().any(|image| named(&image.name)), called(bits, "shadows"));
    expect("buffers of shadows", graph.buffers.iter().any(|buffer| named(&buffer.name)), called(bits, "shadows"));
    expect("shadow variants", shadow_kinds(&graph) != 0, called(bits, "shadows"));
    let shadowed = if spots {
        KIND_SPOT
    } else if suns {
        KIND_DIRECTIONAL
    } else {
        KIND_POINT
    };
    expect("only the kind of light that asks", [0, shadowed].contains(&shadow_kinds(&graph)), true);
    expect("normal map variants", constants("shade/", 10, crate::shared::TEXTURE_NORMAL), called(bits, "normal_maps"));
    expect("height map variants", constants("shade/", 10, crate::shared::TEXTURE_HEIGHT), called(bits, "parallax"));
    expect("mask variants", constants("shade/", 11, 1), called(bits, "alpha_mask"));
    Ok(wrong)
}

/// SHADOW_KINDS of glsl/inc/shadow.glsl over all pipelines.
fn shadow_kinds(graph: &Graph) -> u32 {
    let of = |constants: &[(u32, u32)]| constants.iter().filter(|(at, _)| *at == 36).fold(0, |kinds, c| kinds | c.1);
    let of_node = |work: &Work| match work {
        Work::Dispatch { pipeline, .. } if pipeline.program.name.starts_with("shade/") => of(&pipeline.constants),
        Work::Render(render) => {
            let shaded = render.pipelines.iter().filter(|p| p.program.name.starts_with("shade/"));
            shaded.fold(0, |kinds, p| kinds | of(&p.constants))
        }
        _ => 0,
    };
    graph.nodes.iter().fold(0, |kinds, node| kinds | of_node(&node.work))
}

/// Subsets in which each pair of calls is there in all four ways: rows of an orthogonal array of strength 2 (12 runs, 11 columns; R. L. Plackett,
/// J. P. Burman, "The design of optimum multifactorial experiments", Biometrika 33, 1946), of which nine columns are taken.
pub(super) fn covering() -> Vec<u32> {
    const FIRST: [u32; 11] = [1, 1, 0, 1, 1, 1, 0, 0, 0, 1, 0];
    let row = |shift: usize| (0..CALLS.len()).fold(0, |bits, at| bits | FIRST[(at + 11 - shift) % 11] << at);
    (0..11).map(row).chain([0]).collect()
}

/// The covering array on this device: what is called for is drawn without a message, and is what the plan lists; forbidding an effect that is
/// called for leaves what a scene without it does, and forbidding one that is not leaves no trace.
pub fn subsets(renderer: &Renderer) -> Result<Vec<Row>> {
    let limits = Limits { max_color_attachments: 4, ..renderer.limits() };
    let techniques =
        [Technique::Forward, Technique::TiledForward, Technique::TiledDeferred, Technique::ClusteredForward];
    let mut rows = Vec::new();
    for (index, bits) in covering().into_iter().enumerate() {
        let technique = techniques[index % techniques.len()];
        let (scene, request) = (scene_of(bits), request_of(bits, technique));
        let plan = Plan::new(&scene, &request, &limits)?;
        let mut prepared = renderer.prepare(&scene, &plan)?;
        prepared.draw(1)?;
        let (picture, violations) = prepared.finish()?;
        let lit = picture.rgba("radiance").unwrap_or(&[]).iter().filter(|pixel| pixel[0] > 0.0).count();
        let problems = wrong(bits, technique, &limits)?;
        rows.push(Row {
            name: format!("subset {bits:09b} in {}", technique.name()),
            passed: problems.is_empty() && violations.is_empty() && lit > 100,
            detail: format!("{} decisions wrong, {} barriers, {lit} pixels lit", problems.len(), violations.len()),
        });
    }
    rows.extend(overrides(renderer, &limits)?);
    Ok(rows)
}

/// What is overridden, and whether it leaves the picture as it is where nothing calls for it: several samples change edges, and shadows are compared
/// with rays.
fn forced_and_forbidden() -> [(EffectName, bool); 8] {
    [
        (EffectName::Transparency, true),
        (EffectName::AlphaMask, true),
        (EffectName::NormalMaps, true),
        (EffectName::Parallax, true),
        (EffectName::MaterialModels, true),
        (EffectName::Prepass, true),
        (EffectName::Msaa, false),
        (EffectName::Shadows, false),
    ]
}

/// What a frame leaves: radiance, recorded commands, and what it consists of.
type Drawn = (Vec<u32>, Vec<Event>, Vec<String>);

fn drawn(renderer: &Renderer, scene: &Scene, plan: &Plan) -> Result<Drawn> {
    let mut prepared = renderer.prepare(scene, plan)?;
    prepared.draw(1)?;
    let (log, parts) = (prepared.log().to_vec(), trace(prepared.graph().0));
    let (picture, violations) = prepared.finish()?;
    match violations.first() {
        Some(violation) => Err(Error::new(format!("the checker found {violation}"))),
        None => Ok((picture.layer("radiance").unwrap_or(&[]).iter().map(|x| x.to_bits()).collect(), log, parts)),
    }
}

fn overrides(renderer: &Renderer, limits: &Limits) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for technique in [Technique::Forward, Technique::TiledForward, Technique::ClusteredForward] {
        let (plain, request) = (scene_of(0), request_of(0, technique));
        let (whole, log, parts) = drawn(renderer, &plain, &Plan::new(&plain, &request, limits)?)?;
        let overridden = |force: &[EffectName], forbid: &[EffectName]| -> Result<Drawn> {
            let (mut scene, mut request) = (plain.clone(), request.clone());
            apply(&mut scene, &mut request, force, forbid)?;
            drawn(renderer, &scene, &Plan::new(&scene, &request, limits)?)
        };
        for (effect, neutral) in forced_and_forbidden() {
            if neutral {
                let (forced, ..) = overridden(&[effect], &[])?;
                let name = format!("{} forced in {}", effect.name(), technique.name());
                rows.push(Row::none(name, differing(&whole, &forced), "differing pixels"));
            }
            if effect == EffectName::Prepass {
                continue;
            }
            let (forbidden, commands, consists) = overridden(&[], &[effect])?;
            let name = format!("{} forbidden in {} where nothing calls for it", effect.name(), technique.name());
            let traces = [forbidden != whole, commands != log, consists != parts];
            let count = traces.into_iter().filter(|differs| *differs).count();
            rows.push(Row::none(name, count, "differences of picture, recorded commands, pipelines and memory"));
        }
        // A panel before the wall, which has edges and stands in the light's way.
        let (panel, plain) = (scene_of(1 << 1), request_of(0, technique));
        for effect in [EffectName::Msaa, EffectName::Shadows] {
            rows.extend(against_rays(renderer, &panel, &plain, effect, limits)?);
        }
    }
    Ok(rows)
}

/// A forced effect that changes the picture: how many pixels it changes, and the share of those of the forced picture that differ by more than a
/// fiftieth from rays, a ray a sample.
fn against_rays(
    renderer: &Renderer,
    scene: &Scene,
    plain: &Request,
    effect: EffectName,
    limits: &Limits,
) -> Result<[Row; 2]> {
    let (mut scene, mut request) = (scene.clone(), plain.clone());
    let (without, ..) = drawn(renderer, &scene, &Plan::new(&scene, plain, limits)?)?;
    apply(&mut scene, &mut request, &[effect], &[])?;
    let plan = Plan::new(&scene, &request, limits)?;
    let (forced, ..) = drawn(renderer, &scene, &plan)?;
    let traced = Reference::new(&scene, &plan.view)?.of_samples(plan.samples).render(&shader(&plan), &|_| {});
    let differs = |(pixel, wanted): &(&[u32], &[f64; 4])| {
        (0..3).any(|c| (f64::from(f32::from_bits(pixel[c])) - wanted[c]).abs() > 0.02 * wanted[c].max(1e-3))
    };
    let wrong = forced.chunks_exact(4).zip(&traced.rgba).filter(differs).count();
    let changed = differing(&without, &forced);
    let what = format!("{} forced in {}", effect.name(), plan.technique.name());
    Ok([
        Row {
            name: format!("{what} changes the picture"),
            passed: changed > 30 && changed != usize::MAX,
            detail: format!("{changed} pixels"),
        },
        Row::at_most(format!("{what} against rays"), wrong as f64 / traced.rgba.len() as f64, 0.04),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        Limits { samples: [1 | 4; 2], float_blend: true, fragment_stores: true, ..Limits::MINIMUM }
    }

    #[test]
    fn every_subset_gets_exactly_what_it_calls_for() {
        for technique in [
            Technique::Forward,
            Technique::TiledForward,
            Technique::ClusteredForward,
            Technique::Deferred,
            Technique::TiledDeferred,
            Technique::ClusteredDeferred,
        ] {
            for bits in 0..1 << CALLS.len() {
                let found = wrong(bits, technique, &limits()).expect("a plan");
                assert!(found.is_empty(), "{found:#?}");
            }
        }
    }

    #[test]
    fn the_array_has_each_pair_of_calls_in_every_way() {
        let rows = covering();
        for (a, b) in (0..CALLS.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let ways: BTreeSet<[u32; 2]> = rows.iter().map(|bits| [bits >> a & 1, bits >> b & 1]).collect();
            assert_eq!(ways.len(), 4, "{} and {}", CALLS[a], CALLS[b]);
        }
        assert_eq!(rows.len(), 12);
    }

    /// What a subset without a call is planned as, and what the subset with it is once that is forbidden.
    #[test]
    fn forbidden_is_as_if_it_had_not_been_called_for() {
        for technique in [Technique::TiledForward, Technique::ClusteredDeferred] {
            for (at, effect) in [
                (1, EffectName::AlphaMask),
                (2, EffectName::NormalMaps),
                (3, EffectName::Parallax),
                (6, EffectName::Msaa),
                (7, EffectName::MaterialModels),
                (8, EffectName::Shadows),
            ] {
                for bits in [0u32, 0b1_1111_1111, 0b1_0101_0101] {
                    let (with, without) = (bits | 1 << at, bits & !(1 << at));
                    let (mut scene, mut request) = (scene_of(with), request_of(with, technique));
                    apply(&mut scene, &mut request, &[], &[effect]).expect("an override");
                    let forbidden = Plan::new(&scene, &request, &limits()).expect("a plan");
                    let runs = |name: &str| forbidden.effects.iter().any(|e| e.name == name && e.runs);
                    assert!(!runs(effect.name()), "{}", effect.name());
                    if [EffectName::Msaa, EffectName::Shadows].contains(&effect) {
                        let plain = scene_of(without);
                        let plan = Plan::new(&plain, &request_of(without, technique), &limits()).expect("a plan");
                        let [found, wanted] = [&forbidden, &plan].map(|plan| trace(&passes::frame(plan).graph));
                        assert_eq!(found, wanted, "{}", effect.name());
                    }
                }
            }
        }
    }
}
