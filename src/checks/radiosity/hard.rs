//! Hard cases of bounced light that take a device: one red wall through every codec, and a sun of 100,000 lux.

use std::sync::Arc;

use glam::DVec3;

use super::{Row, lamp, patch_light, request, rgb};
use crate::error::Result;
use crate::plan::{Plan, Technique};
use crate::radiosity::bake::{Bake, CodecName, Settings};
use crate::radiosity::judge::{after_bounces, wide};
use crate::radiosity::{Exchange, codec};
use crate::renderer::Renderer;
use crate::scene::{Light, LightKind, builtin};

/// Relative L2 that a codec may be off by from the exact matrix's light of one wall: what three bounces leave out, and logarithms in 8 bits.
const OF_THESIS: f64 = 0.35;
const OF_OTHERS: f64 = 0.06;

/// R10: light of one red wall is red and nothing else, and falls where the exact matrix has it: rows, columns and what is kept apart lie the same way
/// round in every codec.
fn red_wall(renderer: &Renderer, rows: &mut Vec<Row>) -> Result<()> {
    let mut scene = builtin::load("cornell")?;
    for material in &mut scene.materials {
        let [red, green, _, _] = material.base_color;
        // Of the red wall alone.
        material.emissive = if red > 2.0 * green { [3.0, 0.0, 0.0] } else { [0.0; 3] };
    }
    scene.lights.clear();
    let exchange = Exchange::of_scene(&scene, &Settings::of_count(150))?;
    let patches = &exchange.patches;
    let first: Vec<[f32; 3]> =
        patches.list.iter().map(|p| (p.emission * std::f64::consts::PI).as_vec3().to_array()).collect();
    let right = after_bounces(&|sent| exchange.exact.product(sent, 32), patches, &first);
    let areas = exchange.areas();
    for codec_name in CodecName::ALL {
        let bake = Arc::new(Bake::new(exchange.clone(), Settings::of_codec(codec_name))?);
        let plan = Plan::new(&scene, &request(&bake, Technique::Forward), &renderer.limits())?;
        let light: Vec<[f32; 3]> = patch_light(renderer, &scene, &plan)?.iter().map(|p| rgb(p[0])).collect();
        let other = light.iter().filter(|e| e[1] != 0.0 || e[2] != 0.0).count();
        let off = codec::relative_l2(&wide(&light), &right, &areas);
        let thesis = matches!(codec_name, CodecName::Thesis | CodecName::ThesisFilled);
        let name = codec_name.name();
        rows.push(Row::none(format!("R10 one red wall, {name}"), other, "patches are not red"));
        let bound = if thesis { OF_THESIS } else { OF_OTHERS };
        rows.push(Row::at_most(format!("R10 one red wall, {name}: against the exact matrix"), off, bound));
    }
    Ok(())
}

/// R11: light is linear up to a sun of 100,000 lux.
fn bright_sun(renderer: &Renderer, rows: &mut Vec<Row>) -> Result<()> {
    let mut scene = builtin::load("cornell")?;
    scene.materials.iter_mut().for_each(|material| material.emissive = [0.0; 3]);
    let direction = DVec3::new(0.3, -0.5, -1.0).normalize();
    scene.lights =
        vec![Light { kind: LightKind::Directional, direction, range: None, color: [1.0; 3], ..lamp(DVec3::ZERO) }];
    let exchange = Exchange::of_scene(&scene, &Settings::of_count(150))?;
    for codec_name in [CodecName::ZeroBlock, CodecName::Thesis, CodecName::Bc4Chroma, CodecName::DenseF16] {
        let bake = Arc::new(Bake::new(exchange.clone(), Settings::of_codec(codec_name))?);
        let mut under = |lux: f32| -> Result<Vec<[f32; 3]>> {
            scene.lights[0].intensity = lux;
            let plan = Plan::new(&scene, &request(&bake, Technique::Forward), &renderer.limits())?;
            Ok(patch_light(renderer, &scene, &plan)?.iter().map(|p| rgb(p[0])).collect())
        };
        let (dim, bright) = (under(1.0)?, under(1e5)?);
        let most = bright.iter().flatten().fold(0f32, |most, x| most.max(*x));
        let off = dim.iter().flatten().zip(bright.iter().flatten()).map(|(a, b)| (a - b * 1e-5).abs() / (most * 1e-5));
        let name = codec_name.name();
        rows.push(Row::at_most(format!("R11 a sun of 1e5 lux, {name}"), f64::from(off.fold(0.0, f32::max)), 1e-5));
        let broken = bright.iter().flatten().filter(|x| !x.is_finite() || **x < 0.0).count();
        rows.push(Row::none(
            format!("R11 a sun of 1e5 lux, {name}: numbers"),
            broken + usize::from(most < 10.0),
            "are none",
        ));
    }
    Ok(())
}

/// Both.
pub fn radiosity_hard(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    red_wall(renderer, &mut rows)?;
    bright_sun(renderer, &mut rows)?;
    Ok(rows)
}
