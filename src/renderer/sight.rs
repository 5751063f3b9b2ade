//! A device that looks for the CPU: walks a scene's triangles for batches of segments, and leaves to the CPU what 32 bits cannot tell. Both come to the
//! same answers, segment for segment.

use std::sync::Mutex;

use bytemuck::cast_slice;
use glam::DVec3;
use rayon::prelude::*;

use super::Renderer;
use crate::error::{Error, Result};
use crate::gpu::realize::Realized;
use crate::graph::checker::{self, Progress, Violation};
use crate::graph::hazard::{self, Barrier};
use crate::graph::log::Event;
use crate::graph::{Graph, Groups, Work};
use crate::passes::sight::{SightFrame, frame};
use crate::radiosity::sight::{Segment, Sight};
use crate::record::Recorder;
use crate::record::upload::Uploader;
use crate::reference::render::Reference;
use crate::shared::{SIGHT_MET, SIGHT_MISSED, SightPush};
use crate::submit::Queue;

/// Segments of a batch: 8 MiB.
const BATCH: usize = 1 << 18;
/// Pairs of patches of a batch of rows: a few batches of segments.
const BATCH_PAIRS: usize = 1 << 17;
/// What a box is made wider by, in units of what a difference of positions is off by.
const WIDER: f64 = 4.0;
/// Of the largest coordinate: what a difference of two positions is off by, at most. Each is rounded by 2^-24, and so is their difference; the square
/// root of 3 for three coordinates.
const OFF: f64 = 1e-6;

/// Looks on a device.
pub struct DeviceSight<'a> {
    reference: &'a Reference<'a>,
    /// What positions are taken from before they are rounded.
    origin: DVec3,
    device: Mutex<OnDevice<'a>>,
}

struct OnDevice<'a> {
    renderer: &'a Renderer,
    frame: SightFrame,
    barriers: Vec<Barrier>,
    realized: Realized,
    queue: Queue,
    uploader: Uploader,
    push: SightPush,
    /// Segments looked at, and those that the CPU decided.
    looked: [u64; 2],
    violations: Vec<Violation>,
    progress: Progress,
}

impl Renderer {
    /// Uploads the triangles of a scene that stop light; `reference` sees it from the world's axes, and segments begin and end at most `beyond` metres
    /// outside of the box of all triangles.
    ///
    /// # Errors
    /// Out of memory, or more triangles than this device binds at once.
    pub fn sight<'a>(&'a self, reference: &'a Reference<'a>, beyond: f64) -> Result<DeviceSight<'a>> {
        let hierarchy = reference.hierarchy();
        let walk = hierarchy.threaded();
        let corners = || walk.iter().flat_map(|node| node.triangles).flat_map(|&id| *hierarchy.corners(id));
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let origin = if low.is_finite() { (low + high) * 0.5 } else { DVec3::ZERO };
        let size = corners().map(|p| (p - origin).abs().max_element()).fold(0.0, f64::max) + beyond;
        let world = corners().map(|p| p.abs().max_element()).fold(0.0, f64::max) + beyond;
        let off = OFF * size;
        let (mut nodes, mut triangles): (Vec<[u32; 4]>, Vec<[u32; 4]>) = (Vec::new(), Vec::new());
        for node in &walk {
            let first = triangles.len() as u32 / 3;
            for &id in node.triangles {
                // Glass lets light through.
                let Some(masked) = reference.stops_light(id).map_or(Some(true), |stops| stops.then_some(false)) else {
                    continue;
                };
                let corners = hierarchy.corners(id).map(|p| p - origin);
                triangles.extend([texel(corners[0], id), texel(corners[1], u32::from(masked)), texel(corners[2], 0)]);
            }
            let count = triangles.len() as u32 / 3 - first;
            let wider = DVec3::splat(WIDER * off);
            nodes.push(texel(node.min - origin - wider, node.next as u32));
            nodes.push(texel(node.max - origin + wider, first << 3 | count));
        }
        let push = SightPush {
            count: 0,
            nodes: walk.len() as u32,
            off: (off as f32).max(f32::MIN_POSITIVE),
            reach: (world * 3f64.sqrt()) as f32,
        };
        let most = triangles.len().max(nodes.len()) as u64 * 16;
        if most > self.limits().max_storage_bytes {
            return Err(Error::new(format!(
                "{} triangles take {most} bytes, this device binds {}",
                triangles.len() / 3,
                self.limits().max_storage_bytes
            )));
        }
        let frame = frame(push, triangles.len() as u64 / 3, BATCH as u32);
        let barriers = hazard::derive(&frame.graph);
        let realized = Realized::create(&self.device, &frame.graph, &self.cache)?;
        let mut queue = Queue::create(&self.device, 0)?;
        let mut uploader = Uploader::new(&self.device);
        uploader.buffer(&mut queue, realized.buffer(frame.nodes), cast_slice(&nodes))?;
        uploader.buffer(&mut queue, realized.buffer(frame.triangles), cast_slice(&triangles))?;
        let device = OnDevice {
            renderer: self,
            frame,
            barriers,
            realized,
            queue,
            uploader,
            push,
            looked: [0; 2],
            violations: Vec::new(),
            progress: Progress::default(),
        };
        Ok(DeviceSight { reference, origin, device: Mutex::new(device) })
    }
}

impl DeviceSight<'_> {
    /// Segments looked at so far, and those of them that the CPU decided.
    pub fn looked(&self) -> [u64; 2] {
        self.device.lock().map(|device| device.looked).unwrap_or_default()
    }

    /// Begins to count again.
    pub fn forget_looked(&self) {
        if let Ok(mut device) = self.device.lock() {
            device.looked = [0; 2];
        }
    }

    /// What the checker found in all that was recorded; empty is the proof.
    pub fn check(&self) -> Vec<Violation> {
        self.device.lock().map(|device| device.violations.clone()).unwrap_or_default()
    }

    fn words(&self, segment: &Segment) -> [[u32; 4]; 2] {
        let [a, b] = segment.triangles;
        [texel(segment.from - self.origin, a), texel(segment.to - segment.from, b)]
    }
}

impl OnDevice<'_> {
    /// A word a segment.
    fn run(&mut self, segments: &[[[u32; 4]; 2]]) -> Result<Vec<u32>> {
        let Self { renderer, frame, barriers, realized, queue, uploader, push, violations, progress, .. } = self;
        uploader.buffer(queue, realized.buffer(frame.segments), cast_slice(segments))?;
        push.count = segments.len() as u32;
        tell(&mut frame.graph, *push);
        let mut log = Vec::new();
        let nodes = 0..frame.graph.nodes.len();
        let value = queue.submit(|commands, _| {
            let mut recorder =
                Recorder { device: &renderer.device, commands, timer: None, log: Some(std::mem::take(&mut log)) };
            recorder.nodes(&frame.graph, barriers, realized, nodes);
            log = recorder.log.unwrap_or_default();
            0
        })?;
        queue.wait(value)?;
        log.push(Event::HostWait);
        violations.extend(checker::check_from(&frame.graph, &log, progress));
        let bytes = realized.buffer(frame.found).mapped().ok_or_else(|| Error::new("what was seen is not mapped"))?;
        let words = bytes.chunks_exact(4).take(segments.len());
        Ok(words.map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}

/// A place and a word beside it.
fn texel(place: DVec3, word: u32) -> [u32; 4] {
    let [x, y, z] = place.as_vec3().to_array().map(f32::to_bits);
    [x, y, z, word]
}

/// How many segments there are, to the one pass.
fn tell(graph: &mut Graph, of: SightPush) {
    for node in &mut graph.nodes {
        if let Work::Dispatch { push, groups, .. } = &mut node.work {
            *push = bytemuck::bytes_of(&of).to_vec();
            *groups = Groups::Fixed([of.count.div_ceil(64).max(1), 1, 1]);
        }
    }
}

impl Sight for DeviceSight<'_> {
    fn open(&self, segments: &[&[Segment]]) -> Result<Vec<Vec<bool>>> {
        let mut device = self.device.lock().map_err(|_| Error::new("the device that looks is unusable"))?;
        let all: Vec<&Segment> = segments.iter().flat_map(|run| run.iter()).collect();
        let mut seen = Vec::with_capacity(all.len());
        for batch in all.chunks(BATCH) {
            let words: Vec<[[u32; 4]; 2]> = batch.par_iter().map(|segment| self.words(segment)).collect();
            seen.extend(device.run(&words)?);
        }
        let unsure = seen.iter().filter(|word| **word != SIGHT_MET && **word != SIGHT_MISSED).count();
        device.looked[0] += seen.len() as u64;
        device.looked[1] += unsure as u64;
        drop(device);
        let decided = |(segment, word): (&&Segment, &u32)| match *word {
            SIGHT_MISSED => true,
            SIGHT_MET => false,
            _ => !self.reference.is_blocked_past(segment.from, segment.to, segment.triangles),
        };
        let open: Vec<bool> = all.par_iter().zip(&seen).map(decided).collect();
        let mut rest = open.as_slice();
        let mut runs = Vec::with_capacity(segments.len());
        for run in segments {
            let (own, others) = rest.split_at(run.len());
            runs.push(own.to_vec());
            rest = others;
        }
        Ok(runs)
    }

    fn batch_pairs(&self) -> usize {
        BATCH_PAIRS
    }
}
