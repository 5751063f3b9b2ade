//! C1 and C4: the slice of a depth on the device, on the CPU and in metres.

use super::{parts, request, scene};
use crate::checks::Row;
use crate::error::{Error, Result};
use crate::graph::access::{ComputeStorageWrite, ComputeUniform};
use crate::graph::{ComputePipeline, Graph, Groups, Lifetime, Work};
use crate::math::cull;
use crate::passes::{Frame, SceneHandles, read_back};
use crate::plan::{Plan, Request, Technique};
use crate::reference::cluster_keys;
use crate::renderer::Renderer;
use crate::scene::{Projection, Scene};
use crate::shaders::cluster::slice_probe;
use crate::shared::{FAR_LIMIT, PROBE_DEPTHS};

/// Reversed depth between the boundaries of linear slices.
fn step(plan: &Plan) -> Result<f32> {
    let scale = parts(plan)?.1.grid.slice_scale;
    Ok(if scale > 0.0 { 1.0 / scale } else { 0.0 })
}

/// The slices that the device finds for the depths of `cluster_keys::probe_depth`.
fn probed(renderer: &Renderer, scene: &Scene, plan: &Plan, count: u32) -> Result<Vec<u32>> {
    let mut graph = Graph::new();
    let handles = SceneHandles::declare(&mut graph, plan);
    let (tiles, clusters) =
        handles.tiles.zip(handles.clusters).ok_or_else(|| Error::new("this technique has no clusters"))?;
    let slices = graph.word_buffer("slices", u64::from(count) * 4, Lifetime::Transient);
    let set = slice_probe::Bindings {
        grid: ComputeUniform(tiles.grid),
        clusters: ComputeUniform(clusters.grid),
        slices: ComputeStorageWrite(slices),
    };
    let spec = slice_probe::Spec { SLICE_STEP: step(plan)? };
    let pipeline = ComputePipeline { program: &slice_probe::PROGRAM, constants: spec.values() };
    let groups = [count.div_ceil(slice_probe::PROGRAM.local_size[0]), 1, 1];
    graph.add(
        "slice_probe",
        Work::Dispatch { pipeline, bindings: set.list(), push: Vec::new(), groups: Groups::Fixed(groups) },
    );
    graph.end_frame();
    let results = read_back::add_all(&mut graph, &[], &[("slices", slices)]);
    let mut prepared = renderer.prepare_frame(scene, plan, Frame { graph, scene: handles, results })?;
    prepared.draw(1)?;
    let (picture, _) = prepared.finish()?;
    Ok(picture.layer("slices").unwrap_or(&[]).iter().map(|x| x.to_bits()).collect())
}

/// Rows of one lens.
fn rows_of(renderer: &Renderer, name: &str, scene: &Scene, plan: &Plan) -> Result<[Row; 4]> {
    let (tiles, clusters) = parts(plan)?;
    let (grid, cut, step) = (&tiles.grid, &clusters.grid, step(plan)?);
    let count = (cut.slices + 1) * PROBE_DEPTHS;
    let depths: Vec<f32> = (0..count).map(|i| cluster_keys::probe_depth(grid, cut, step, i)).collect();
    let slices: Vec<u32> = depths.iter().map(|&depth| cluster_keys::slice(grid, cut, depth)).collect();
    let found = probed(renderer, scene, plan, count)?;
    let elsewhere = slices.iter().enumerate().filter(|(i, slice)| found.get(*i) != Some(*slice)).count();
    let outside = found.iter().filter(|&&slice| slice >= cut.slices).count();
    let mut ordered: Vec<(f32, u32)> = depths.iter().copied().zip(slices.iter().copied()).collect();
    ordered.sort_by(|a, b| b.0.total_cmp(&a.0));
    let descending = ordered.windows(2).filter(|pair| pair[1].1 < pair[0].1).count();
    let sticks_out = |&(depth, slice): &(f32, u32)| {
        let [near, far, ..] = clusters.slices[slice as usize];
        let [low, high] = cull::distance_range(grid, depth);
        // Where nothing is known of how far a sample is, its slice still says how near it is not.
        high > far || (low < near && high < FAR_LIMIT)
    };
    let seen = ordered.iter().filter(|(depth, _)| cluster_keys::shows_surface(*depth) && *depth <= 1.0);
    let sticking_out = seen.filter(|&pair| sticks_out(pair)).count();
    Ok([
        Row::none(format!("C1 slices = twin, {name}, {count} depths"), elsewhere, "slices that differ"),
        Row::none(format!("C1 slices never descend, {name}"), descending, "depths"),
        Row::none(format!("C1 slices contain their samples, {name}"), sticking_out, "depths"),
        Row::none(format!("C4 depths of any size and sign, {name}"), outside, "slices that there are not"),
    ])
}

/// Depths within 256 ulp of every boundary, and of every size and sign.
pub fn cluster_slices(renderer: &Renderer) -> Result<Vec<Row>> {
    let perspective = |znear, zfar| Projection::Perspective { yfov: 0.69, aspect: None, znear, zfar };
    let orthographic = |znear, zfar| Projection::Orthographic { xmag: 5.0, ymag: 3.0, znear, zfar };
    let lenses = [
        ("no far plane", perspective(0.05, None)),
        ("far plane", perspective(0.05, Some(14.0))),
        ("near is far", perspective(10.0, Some(11.0))),
        ("orthographic", orthographic(0.0, 20.0)),
        ("orthographic, near -4", orthographic(-4.0, 20.0)),
    ];
    let mut rows = Vec::new();
    for (name, projection) in lenses {
        let mut scene = scene("cornell", 8)?;
        scene.cameras.truncate(1);
        for camera in &mut scene.cameras {
            camera.projection = projection;
        }
        for tile in [8, 64] {
            let asked = Request { tile, ..request(Technique::ClusteredForward) };
            let plan = Plan::new(&scene, &asked, &renderer.limits())?;
            rows.extend(rows_of(renderer, &format!("{name}, tile {tile}"), &scene, &plan)?);
        }
    }
    Ok(rows)
}
