//! Techniques agree on everything that a scene may have: lights of every kind, ambient light, emission, maps, masks, surfaces that no light
//! changes, each shading model, and light data that is read in any way.

use glam::{DVec3, Vec3};

use super::lists::{differing, radiance, radiance_of};
use super::{Row, textured};
use crate::error::Result;
use crate::plan::{AssignChoice, DeferredLights, Fetch, FetchChoice, GbufferLayout, Limits, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::lighting::LightRules;
use crate::scene::shading::Shading;
use crate::scene::{Light, LightKind, Scene, builtin, scatter};

/// Not a multiple of any tile size.
const SIZE: (u32, u32) = (100, 75);

const SHADINGS: [Shading; 3] = [Shading::Lambert, Shading::Phong, Shading::Gltf];

fn request(shading: Shading) -> Request {
    let rules = LightRules { ambient: Vec3::new(0.2, 0.3, 0.1), ..LightRules::default() };
    Request { width: SIZE.0, height: SIZE.1, shading, rules, ..crate::checks::forward() }
}

/// Point and spot lights, and one from far away.
fn lit(mut scene: Scene, lights: usize) -> Scene {
    scene.lights = scatter::point_lights(&scene.bounds(), lights, 5);
    for (index, light) in scene.lights.iter_mut().enumerate() {
        light.range = Some(1.5);
        if index % 3 == 0 {
            light.kind = LightKind::Spot { inner: 0.3, outer: 0.8 };
            light.direction = DVec3::new(0.1, -1.0, -0.4).normalize();
        }
    }
    if let Some(first) = scene.lights.first().cloned() {
        let direction = DVec3::new(0.2, -1.0, -0.6).normalize();
        let sun = Light { kind: LightKind::Directional, intensity: 0.3, range: None, direction, ..first };
        scene.lights.insert(1, sun);
    }
    scene
}

fn of(base: &Request, technique: Technique, gbuffer: GbufferLayout) -> (String, Request) {
    let layout = if gbuffer == GbufferLayout::Fat { ", fat G-buffer" } else { "" };
    (format!("{}{layout}", technique.name()), Request { technique, gbuffer, ..base.clone() })
}

/// Techniques whose picture is forward's, and those that agree with tiled-deferred.
fn forms(base: &Request, fat_fits: bool) -> [Vec<(String, Request)>; 2] {
    let compact = |technique| of(base, technique, GbufferLayout::Compact);
    let mut exact = vec![compact(Technique::TiledForward), compact(Technique::ClusteredForward)];
    if fat_fits {
        let fat = [Technique::Deferred, Technique::TiledDeferred, Technique::ClusteredDeferred];
        exact.extend(fat.map(|technique| of(base, technique, GbufferLayout::Fat)));
    }
    let mut rounded: Vec<_> = DeferredLights::ALL
        .into_iter()
        .map(|deferred_lights| {
            let (name, request) = compact(Technique::Deferred);
            (format!("{name} {}", deferred_lights.name()), Request { deferred_lights, ..request })
        })
        .collect();
    rounded.push(compact(Technique::ClusteredDeferred));
    [exact, rounded]
}

/// Every technique on every shading model.
pub fn agreement(renderer: &Renderer) -> Result<Vec<Row>> {
    let fat_fits = renderer.limits().max_color_attachments >= 5;
    let mut scenes: Vec<(&str, Scene)> = textured::mixed().into_iter().map(|(name, s)| (name, lit(s, 24))).collect();
    scenes.push(("cornell", lit(builtin::load("cornell")?, 40)));
    let mut rows = Vec::new();
    for (name, scene) in &scenes {
        let dark = Scene { lights: Vec::new(), ..scene.clone() };
        for shading in SHADINGS {
            let base = request(shading);
            let lit = differing(&radiance(renderer, scene, &base)?, &radiance(renderer, &dark, &base)?);
            let detail = format!("{lit} pixels differ from those without");
            rows.push(Row { name: format!("lights are seen, {name}, {}", shading.name()), passed: lit > 1000, detail });
            let [exact, rounded] = forms(&base, fat_fits);
            let tiled = Request { technique: Technique::TiledDeferred, ..base.clone() };
            let pairs = [(&base, "forward", exact), (&tiled, "tiled-deferred", rounded)];
            for (judge, judge_name, forms) in pairs {
                let wanted = radiance(renderer, scene, judge)?;
                for (form, request) in forms {
                    let count = differing(&wanted, &radiance(renderer, scene, &request)?);
                    let row = format!("{form} = {judge_name}, {name}, {}", shading.name());
                    rows.push(Row::none(row, count, "differing pixels"));
                }
            }
        }
    }
    Ok(rows)
}

/// C12: whatever light data and lists are read from, the picture is the same. Devices that grant less are played by limits.
pub fn fetches(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = lit(builtin::load("cornell")?, 200);
    let device = renderer.limits();
    // Too few texels for lists and lights, and a uniform block that holds the lights or does not.
    let uniform = Limits { max_texel_elements: 64, ..device.clone() };
    let storage = Limits { max_uniform_bytes: 1024, ..uniform.clone() };
    let mut rows = Vec::new();
    for technique in [
        Technique::Forward,
        Technique::TiledForward,
        Technique::ClusteredForward,
        Technique::Deferred,
        Technique::TiledDeferred,
        Technique::ClusteredDeferred,
    ] {
        for assign in [AssignChoice::Tiles, AssignChoice::Tree] {
            if assign == AssignChoice::Tree && !technique.clusters() {
                continue;
            }
            let assign = if technique.clusters() { assign } else { AssignChoice::Auto };
            let request = Request { technique, assign, ..request(Shading::Gltf) };
            let texel = Plan::new(&scene, &Request { fetch: FetchChoice::Texel, ..request.clone() }, &device)?;
            let wanted = radiance_of(renderer, &scene, &texel)?;
            for (limits, fetch) in [(&uniform, Fetch::Uniform), (&storage, Fetch::Storage)] {
                let plan = Plan::new(&scene, &request, limits)?;
                let lists = plan.tiles.as_ref().is_none_or(|t| !t.words_by_texel)
                    && plan.clusters.as_ref().is_none_or(|c| !c.words_by_texel);
                let planned = plan.lights.fetch == fetch && lists;
                let count = differing(&wanted, &radiance_of(renderer, &scene, &plan)?);
                let by = fetch.name();
                let name = format!("C12 {} ({}), lights by {by}, lists by storage", technique.name(), assign.name());
                let mut row = Row::none(name, count, "differing pixels");
                row.passed &= planned;
                row.detail += if planned { "" } else { ", another fetch was planned" };
                rows.push(row);
            }
        }
    }
    Ok(rows)
}
