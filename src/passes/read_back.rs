//! Read-back: copies finished images into mapped buffers and hands them to the host. Runs once, after the timed frames.
//!
//! Reads: any image. Writes: one tightly packed buffer an image, in whole words. Limits: the plan checks the largest buffer beforehand.
//! CPU twin: none, it moves bytes.

use ash::vk::Format;

use crate::graph::{BufferHandle, Graph, ImageHandle, Lifetime, Work};

/// Bytes of a texel of the formats that are read back.
fn texel_bytes(format: Format) -> u64 {
    match format {
        Format::R8G8_UINT => 2,
        Format::D32_SFLOAT | Format::R32_SFLOAT | Format::R32_UINT => 4,
        Format::R8G8B8A8_UNORM | Format::R16G16_UINT => 4,
        Format::A2B10G10R10_UNORM_PACK32 | Format::A2B10G10R10_UINT_PACK32 => 4,
        Format::R16G16B16A16_SFLOAT | Format::R16G16B16A16_UINT => 8,
        // The largest that there is: a buffer is never too small.
        _ => 16,
    }
}

/// Adds a copy for each layer and the node that hands all of them over; the buffers by layer name.
pub fn add(graph: &mut Graph, layers: &[(&'static str, ImageHandle)]) -> Vec<(&'static str, BufferHandle)> {
    add_all(graph, layers, &[])
}

/// As [`add`], for pictures: 16-bit floats come back as 32-bit ones. Of the other formats words come back as they are.
pub fn add_pictures(graph: &mut Graph, layers: &[(&'static str, ImageHandle)]) -> Vec<(&'static str, BufferHandle)> {
    let results = add(graph, layers);
    for (&(_, image), &(_, buffer)) in layers.iter().zip(&results) {
        graph.buffers[buffer.0 as usize].texel_format = graph.image_info(image).format;
    }
    results
}

/// As [`add`], for buffers too: words come back as the bits of floats.
pub fn add_all(
    graph: &mut Graph,
    layers: &[(&'static str, ImageHandle)],
    buffers: &[(&'static str, BufferHandle)],
) -> Vec<(&'static str, BufferHandle)> {
    let mut results = Vec::with_capacity(layers.len());
    for &(name, image) in layers {
        let info = graph.image_info(image);
        let texels = u64::from(info.width) * u64::from(info.height);
        let bytes = (texels * texel_bytes(info.format)).next_multiple_of(4);
        let buffer = graph.buffer(&format!("{name} (host)"), bytes, Lifetime::ReadBack);
        graph.add(&format!("read_{name}"), Work::CopyImageToBuffer { from: image, to: buffer });
        results.push((name, buffer));
    }
    for &(name, from) in buffers {
        let to = graph.buffer(&format!("{name} (host)"), graph.buffer_info(from).bytes, Lifetime::ReadBack);
        graph.add(&format!("read_{name}"), Work::CopyBuffer { from, to });
        results.push((name, to));
    }
    let buffers: Vec<_> = results.iter().map(|r| r.1).collect();
    graph.host_read(&buffers);
    results
}
