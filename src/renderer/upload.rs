//! What is filled before the first frame: constants, geometry, lights, lists' inputs and textures.

use std::sync::Arc;

use bytemuck::{bytes_of, cast_slice};

use crate::error::Result;
use crate::gpu::Device;
use crate::gpu::realize::Realized;
use crate::graph::Lifetime;
use crate::math::icosphere;
use crate::passes::{Frame, SceneHandles};
use crate::plan::gbuffer::depth_terms;
use crate::plan::{Deferred, Plan};
use crate::record::upload::Uploader;
use crate::scene::{LightKind, Scene, mips};
use crate::shared;
use crate::submit::Queue;

fn frame_constants(plan: &Plan) -> shared::Frame {
    let first_pixel = plan.view.image_point(0.0, 0.0);
    let pixel = plan.view.image_point(1.0, 1.0) - first_pixel;
    let [depth_offset, depth_scale] = depth_terms(&plan.view);
    let directional = plan.lighting.lights.iter().filter(|l| l.kind == LightKind::Directional).count();
    shared::Frame {
        view_to_clip: plan.view.view_to_clip().as_mat4().to_cols_array_2d(),
        ambient: plan.lighting.ambient.to_array(),
        light_count: plan.lights.count,
        attenuation: [
            plan.lighting.attenuation.constant as f32,
            plan.lighting.attenuation.linear as f32,
            plan.lighting.attenuation.quadratic as f32,
        ],
        perspective: if plan.view.lens.is_perspective() { 1.0 } else { 0.0 },
        light_seek_limit: plan.lights.seek_limit,
        light_remainder_step: plan.lights.remainder_step,
        image_scale: pixel.as_vec2().to_array(),
        image_offset: first_pixel.as_vec2().to_array(),
        depth_offset,
        depth_scale,
        directional_count: directional as u32,
    }
}

/// What light volumes are drawn from, and what stands in for codes of normals.
fn upload_shapes(
    uploader: &mut Uploader,
    queue: &mut Queue,
    realized: &Realized,
    handles: &SceneHandles,
) -> Result<()> {
    if let Some(corners) = handles.corners {
        uploader.buffer(queue, realized.buffer(corners), cast_slice(&icosphere::corners()))?;
    }
    if let Some(no_normals) = handles.no_normals {
        uploader.image(queue, realized.image(no_normals), &[(1, 1, &[0; 4])])?;
    }
    Ok(())
}

/// Everything that hangs on where lights are and how bright. Buffers may be larger than what is in them.
///
/// # Errors
/// Out of memory, or a lost device.
pub(super) fn lights(
    uploader: &mut Uploader,
    queue: &mut Queue,
    realized: &Realized,
    frame: &Frame,
    plan: &Plan,
) -> Result<()> {
    let handles = &frame.scene;
    uploader.buffer(queue, realized.buffer(handles.frame), bytes_of(&frame_constants(plan)))?;
    uploader.buffer(queue, realized.buffer(handles.lights), cast_slice(&plan.lights.texels))?;
    if let (Some(tiles), Some(tile_handles)) = (&plan.tiles, &handles.tiles) {
        uploader.buffer(queue, realized.buffer(tile_handles.grid), bytes_of(&tiles.grid))?;
        uploader.buffer(queue, realized.buffer(tile_handles.lights), cast_slice(&tiles.cull_data()))?;
    }
    if let (Some(clusters), Some(cluster_handles)) = (&plan.clusters, &handles.clusters) {
        uploader.buffer(queue, realized.buffer(cluster_handles.grid), bytes_of(&clusters.grid))?;
        uploader.buffer(queue, realized.buffer(cluster_handles.slices), cast_slice(&clusters.slice_texels()))?;
    }
    if let (Some(shadows), Some(shadow_handles)) = (&plan.shadows, &handles.shadows) {
        uploader.buffer(queue, realized.buffer(shadow_handles.maps), cast_slice(&shadows.texels()))?;
    }
    if let (Some(handle), Some(volumes)) = (handles.light_volumes, plan.deferred.as_ref().and_then(Deferred::volumes)) {
        uploader.buffer(queue, realized.buffer(handle), cast_slice(&volumes.volumes))?;
    }
    if let Some(markers) = handles.light_markers {
        uploader.buffer(queue, realized.buffer(markers), cast_slice(&plan.markers))?;
    }
    Ok(())
}

/// Bytes of the largest of these.
pub(super) fn largest_of_lights(frame: &Frame) -> u64 {
    let handles = &frame.scene;
    let of_tiles = handles.tiles.iter().flat_map(|tiles| [tiles.grid, tiles.lights]);
    let of_clusters = handles.clusters.iter().flat_map(|clusters| [clusters.grid, clusters.slices]);
    let maps = handles.shadows.iter().map(|shadows| shadows.maps);
    let shapes = handles.light_volumes.into_iter().chain(handles.light_markers);
    let all = [handles.frame, handles.lights].into_iter().chain(of_tiles).chain(of_clusters).chain(maps).chain(shapes);
    all.map(|buffer| frame.graph.buffer_info(buffer).bytes).max().unwrap_or(0)
}

/// Everything that the frame's passes read and none of them writes.
///
/// # Errors
/// Out of memory, or a lost device.
pub(super) fn scene(
    device: &Arc<Device>,
    queue: &mut Queue,
    realized: &Realized,
    frame: &Frame,
    scene: &Scene,
    plan: &Plan,
) -> Result<()> {
    let mut uploader = Uploader::new(device);
    let handles = &frame.scene;
    lights(&mut uploader, queue, realized, frame, plan)?;
    uploader.buffer(queue, realized.buffer(handles.instances), cast_slice(&plan.geometry.instances))?;
    uploader.buffer(queue, realized.buffer(handles.materials), cast_slice(&plan.materials.data))?;
    uploader.buffer(queue, realized.buffer(handles.vertices), &plan.geometry.vertex_data(scene))?;
    uploader.buffer(queue, realized.buffer(handles.indices), cast_slice(&plan.geometry.index_data(scene)))?;
    if let (Some(tiles), Some(tile_handles)) = (&plan.tiles, &handles.tiles) {
        uploader.buffer(queue, realized.buffer(tile_handles.edges), cast_slice(&tiles.edges))?;
        uploader.image(queue, realized.image(tile_handles.no_bounds), &[(1, 1, &[0; 16])])?;
    }
    if let Some(given) = &handles.given {
        let [width, height] = given.size;
        uploader.image(queue, realized.image(given.image), &[(width, height, given.bytes.as_slice())])?;
    }
    if let (Some(bounced), Some(of)) = (&plan.bounced, &handles.bounced) {
        uploader.buffer(queue, realized.buffer(of.places), cast_slice(&bounced.places))?;
        uploader.buffer(queue, realized.buffer(of.words), cast_slice(&bounced.bake.transfer.words))?;
        uploader.buffer(queue, realized.buffer(of.patches), cast_slice(&bounced.patches))?;
        uploader.buffer(queue, realized.buffer(of.points), cast_slice(&bounced.points))?;
        uploader.buffer(queue, realized.buffer(of.matrix), cast_slice(&bounced.matrix.words))?;
        if let (Some(image), Some(handle)) = (&bounced.matrix.image, of.matrix_image) {
            let levels = [(image.side, image.side, image.bytes.as_slice())];
            uploader.image(queue, realized.image(handle), &levels)?;
        }
    }
    for (info, buffer) in frame.graph.buffers.iter().zip(&realized.buffers) {
        if info.lifetime == Lifetime::Kept {
            uploader.buffer(queue, buffer, &vec![0; info.bytes as usize])?;
        }
    }
    upload_shapes(&mut uploader, queue, realized, handles)?;
    for (&(key, _, mipmapped), &handle) in plan.materials.textures.iter().zip(&handles.textures) {
        let image = &scene.images[key.image];
        if mipmapped {
            let chain = mips::chain(image, key.srgb);
            let levels: Vec<_> = chain.levels.iter().map(|l| (l.width, l.height, l.rgba8.as_slice())).collect();
            uploader.image(queue, realized.image(handle), &levels)?;
        } else {
            uploader.image(queue, realized.image(handle), &[(image.width, image.height, image.rgba8.as_slice())])?;
        }
    }
    if let Some(&white) = handles.textures.last() {
        uploader.image(queue, realized.image(white), &[(1, 1, &[255; 4])])?;
    }
    Ok(())
}
