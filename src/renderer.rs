//! The way through the library on a device: open it, prepare a planned scene, draw frames, read times and pictures back.

pub mod sight;
mod upload;

use std::sync::Arc;
use std::time::Instant;

use ash::vk;
use exr::prelude::f16;

use crate::error::{Error, Result};
use crate::gpu::instance::Messages;
use crate::gpu::pipeline_cache::PipelineCache;
use crate::gpu::realize::{Realized, check_all_groups};
use crate::gpu::{Device, Options};
use crate::graph::checker::{self, Progress, Violation};
use crate::graph::hazard::{self, Barrier};
use crate::graph::log::Event;
use crate::graph::program::Program;
use crate::graph::{Graph, Work};
use crate::measure::picture::Picture;
use crate::measure::times::FrameTimes;
use crate::passes::{self, Frame};
use crate::plan::profile::Profile;
use crate::plan::{Limits, Plan};
use crate::profile_file;
use crate::record::Recorder;
use crate::record::upload::Uploader;
use crate::scene::Scene;
use crate::submit::Queue;

/// Frames of one call that are logged: the first has nothing before it, the third finds what every later one finds.
const LOGGED_FRAMES: usize = 3;

/// An open device with its pipeline cache.
pub struct Renderer {
    cache: PipelineCache,
    profile: Profile,
    device: Arc<Device>,
}

impl Renderer {
    /// Opens the device that `options` chooses.
    ///
    /// # Errors
    /// No loader, no driver, a driver below the baseline, or validation without its layer: one sentence each.
    pub fn new(options: &Options) -> Result<Self> {
        let device = Arc::new(Device::create(options)?);
        let cache = PipelineCache::create(&device)?;
        let profile = profile_file::load(&device.facts);
        Ok(Self { cache, profile, device })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The device's limits as plain numbers for [`Plan::new`].
    pub fn limits(&self) -> Limits {
        let (facts, limits) = (&self.device.facts, &self.device.facts.limits);
        Limits {
            max_image_dimension: limits
                .max_image_dimension2_d
                .min(limits.max_framebuffer_width)
                .min(limits.max_framebuffer_height)
                .min(limits.max_viewport_dimensions[0])
                .min(limits.max_viewport_dimensions[1]),
            max_index: limits.max_draw_indexed_index_value,
            max_loop_iterations: facts.loop_iterations.unwrap_or(u32::MAX),
            max_buffer_bytes: facts.max_buffer_bytes,
            max_storage_bytes: u64::from(limits.max_storage_buffer_range),
            max_uniform_bytes: u64::from(limits.max_uniform_buffer_range),
            max_texel_elements: u64::from(limits.max_texel_buffer_elements),
            profile: Some(self.profile.clone()),
            sub_pixel_bits: limits.sub_pixel_precision_bits,
            max_color_attachments: limits.max_color_attachments,
            max_stage_storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
            subgroup_size: facts.subgroup_size,
            float_blend: facts.float_blend,
            fragment_stores: facts.fragment_stores,
            block_compression: facts.block_compression,
            samples: facts.samples,
        }
    }

    /// Messages of the validation layer so far; taken, so that each is seen once.
    pub fn take_messages(&self) -> Vec<String> {
        self.messages().take()
    }

    /// Where messages go; it outlives the renderer, so that what is said while it is dropped can be read too.
    pub fn messages(&self) -> Arc<Messages> {
        self.device.instance.messages()
    }

    /// Makes every Vulkan object of the plan's frame and uploads the scene.
    ///
    /// # Errors
    /// Out of memory, or a pipeline that the driver refuses.
    pub fn prepare(&self, scene: &Scene, plan: &Plan) -> Result<Prepared> {
        self.prepare_frame(scene, plan, passes::frame(plan))
    }

    /// As [`prepare`](Self::prepare) for any frame made of the plan.
    pub fn prepare_frame(&self, scene: &Scene, plan: &Plan, frame: Frame) -> Result<Prepared> {
        if let Some(problem) = frame.graph.problems().first() {
            return Err(Error::new(format!("this frame cannot be synchronized: {problem}")));
        }
        check_programs(&frame.graph, &self.limits())?;
        let barriers = hazard::derive(&frame.graph);
        let realized = Realized::create(&self.device, &frame.graph, &self.cache)?;
        let mut queue = Queue::create(&self.device, frame.graph.nodes.len() as u32 + 1)?;
        let start = Instant::now();
        upload::scene(&self.device, &mut queue, &realized, &frame, scene, plan)?;
        let upload_ms = start.elapsed().as_secs_f64() * 1e3;
        let uploader = match plan.lights_move {
            true => Some(Uploader::with_room(&self.device, upload::largest_of_lights(&frame))?),
            false => None,
        };
        Ok(Prepared {
            pipelines_ms: realized.pipeline_ms,
            upload_ms,
            size: [plan.view.width, plan.view.height],
            barriers,
            frame,
            queue,
            realized,
            device: self.device.clone(),
            log: Vec::new(),
            progress: Progress::default(),
            violations: Vec::new(),
            drawn: false,
            once_done: false,
            uploader,
            finished: false,
            once_ms: 0.0,
            once_nodes_ms: Vec::new(),
        })
    }
}

/// Attachments and storage buffers of every pipeline against what the device binds.
fn check_programs(graph: &Graph, limits: &Limits) -> Result<()> {
    let too_many = |program: &str, count: usize, what: &str, most: u32| {
        Err(Error::new(format!("{program} needs {count} {what}, this device takes at most {most}")))
    };
    for (node, (program, colors)) in graph.nodes.iter().flat_map(|n| programs(&n.work).into_iter().map(move |p| (n, p)))
    {
        // What a variant leaves out is not bound.
        let bound = |name: &str| node.accesses.iter().any(|declared| declared.name == name);
        if colors > limits.max_color_attachments as usize {
            return too_many(program.name, colors, "colour attachments", limits.max_color_attachments);
        }
        for stage in program.stages {
            let slots = program.slots.iter().filter(|s| s.stages.contains(stage.stage) && s.kind.is_storage_buffer());
            let (count, most) = (slots.filter(|s| bound(s.name)).count(), limits.max_stage_storage_buffers);
            if count > most as usize {
                return too_many(program.name, count, "storage buffers in one stage", most);
            }
        }
    }
    Ok(())
}

/// Programs of a node with their number of colour attachments.
fn programs(work: &Work) -> Vec<(&'static Program, usize)> {
    match work {
        Work::Dispatch { pipeline, .. } => vec![(pipeline.program, 0)],
        Work::Render(render) => render.pipelines.iter().map(|p| (p.program, p.colors.len())).collect(),
        _ => Vec::new(),
    }
}

/// A scene on the device, ready to be drawn any number of times.
pub struct Prepared {
    queue: Queue,
    realized: Realized,
    frame: Frame,
    barriers: Vec<Barrier>,
    device: Arc<Device>,
    size: [u32; 2],
    log: Vec<Event>,
    /// What was checked before the log begins, and what was found there.
    progress: Progress,
    violations: Vec<Violation>,
    drawn: bool,
    /// What is drawn once has been, since lights moved last.
    once_done: bool,
    /// Where lights move.
    uploader: Option<Uploader>,
    finished: bool,
    /// Milliseconds of making pipelines.
    pub pipelines_ms: f64,
    /// Milliseconds of uploads.
    pub upload_ms: f64,
    /// Milliseconds of what is drawn once, before the first frame: of the device, without timestamps of the host.
    pub once_ms: f64,
    /// The same by node, where there are timestamps.
    pub once_nodes_ms: Vec<(String, f64)>,
}

impl Prepared {
    /// The frame's graph and its derived barriers.
    pub fn graph(&self) -> (&Graph, &[Barrier]) {
        (&self.frame.graph, &self.barriers)
    }

    /// Leaves out the barrier that `node` has for `resource`, from now on: for studying what a missing one does.
    pub fn forget_barrier(&mut self, node: &str, resource: &str) {
        let graph = &self.frame.graph;
        self.barriers.retain(|b| graph.nodes[b.before].name != node || graph.name_of(b.resource) != resource);
    }

    /// Lights as a plan of the same picture has them ([`Plan::relit`]): their data is uploaded, and what is drawn once while nothing moves is drawn
    /// again before the next frame. Nothing is read back, allocated or compiled; frames in flight have ended.
    ///
    /// # Errors
    /// A plan that needs more than was prepared, such as longer light lists, or other passes, by name; then nothing has changed.
    pub fn relight(&mut self, plan: &Plan) -> Result<()> {
        self.relight_frame(plan, passes::frame(plan))
    }

    /// As [`relight`](Self::relight) for any frame made of the plan.
    pub fn relight_frame(&mut self, plan: &Plan, mut frame: Frame) -> Result<()> {
        let Some(uploader) = &mut self.uploader else {
            return Err(Error::new("lights of this picture do not move: it was not planned so"));
        };
        let refused = |why: String| Error::new(format!("the picture has to be prepared anew for these lights: {why}"));
        frame.graph.take_sizes_of(&self.frame.graph).map_err(refused)?;
        check_all_groups(&self.device, &frame.graph)?;
        upload::lights(uploader, &mut self.queue, &self.realized, &frame, plan)?;
        self.frame = frame;
        self.once_done = false;
        Ok(())
    }

    /// Draws `count` frames with two in flight and times them.
    ///
    /// # Errors
    /// A lost device.
    pub fn draw(&mut self, count: usize) -> Result<FrameTimes> {
        if self.finished {
            return Err(Error::new("the frame's images have been freed: nothing can be drawn any more"));
        }
        let Self {
            queue,
            realized,
            frame,
            barriers,
            device,
            log,
            progress,
            violations,
            drawn,
            once_done,
            once_ms,
            once_nodes_ms,
            ..
        } = self;
        violations.extend(checker::check_from(&frame.graph, log, progress));
        log.clear();
        let once = frame.graph.once_nodes;
        if !*once_done && count > 0 && once > 0 {
            let start = Instant::now();
            let value = queue.submit(|commands, timer| {
                let mut recorder = Recorder { device, commands, timer, log: Some(std::mem::take(log)) };
                recorder.nodes(&frame.graph, barriers, realized, 0..once);
                *log = recorder.log.unwrap_or_default();
                once as u32 + 1
            })?;
            queue.wait(value)?;
            let wall = start.elapsed().as_secs_f64() * 1e3;
            let timed = queue.timings(value)?.node_ms;
            *once_ms = if timed.is_empty() { wall } else { timed.iter().sum() };
            let names = frame.graph.nodes[0..once].iter().map(|node| node.name.clone());
            *once_nodes_ms = names.zip(timed).collect();
            *once_done = true;
            log.push(Event::HostWait);
        }
        let nodes = frame.graph.frame_range();
        let mut recorded = 0;
        let (walls, timings) = queue.frames(count, |commands, timer| {
            let kept = (recorded < LOGGED_FRAMES).then(|| std::mem::take(log));
            recorded += 1;
            let mut recorder = Recorder { device, commands, timer, log: kept };
            recorder.nodes(&frame.graph, barriers, realized, nodes.clone());
            if let Some(kept) = recorder.log {
                *log = kept;
            }
            nodes.len() as u32 + 1
        })?;
        log.push(Event::HostWait);
        *drawn |= count > 0;
        let names = frame.graph.nodes[nodes].iter().map(|n| n.name.clone()).collect();
        Ok(FrameTimes::new(names, walls, timings.into_iter().map(|t| t.node_ms).collect()))
    }

    /// Copies the last frame's results to the host.
    ///
    /// # Errors
    /// A lost device, or results that are not mapped.
    pub fn read_back(&mut self) -> Result<Picture> {
        self.copy_back()?;
        self.collect()
    }

    /// As [`read_back`](Self::read_back) for the last time: images are freed before the picture is made, which lowers the peak; with
    /// it comes what [`check`](Self::check) finds. Nothing can be drawn afterwards.
    ///
    /// # Errors
    /// As there.
    pub fn finish(&mut self) -> Result<(Picture, Vec<Violation>)> {
        self.copy_back()?;
        let found = self.check();
        self.finished = true;
        self.realized.images.clear();
        Ok((self.collect()?, found))
    }

    fn copy_back(&mut self) -> Result<()> {
        if !self.drawn || self.finished {
            return Err(Error::new("nothing has been drawn that could be read back"));
        }
        let Self { queue, realized, frame, barriers, device, log, .. } = self;
        let graph = &frame.graph;
        let value = queue.submit(|commands, _| {
            let mut recorder = Recorder { device, commands, timer: None, log: Some(std::mem::take(log)) };
            recorder.nodes(graph, barriers, realized, graph.frame_len()..graph.nodes.len());
            *log = recorder.log.unwrap_or_default();
            0
        })?;
        queue.wait(value)?;
        log.push(Event::HostWait);
        Ok(())
    }

    fn collect(&self) -> Result<Picture> {
        let mut picture = Picture::new(self.size[0], self.size[1]);
        for &(name, buffer) in &self.frame.results {
            let bytes = self.realized.buffer(buffer).mapped();
            let bytes = bytes.ok_or_else(|| Error::new(format!("the read-back of {name} is not mapped")))?;
            let halves = self.frame.graph.buffer_info(buffer).texel_format == vk::Format::R16G16B16A16_SFLOAT;
            let values = if halves {
                bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect()
            } else {
                bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
            };
            picture.add_layer(name, values);
        }
        Ok(picture)
    }

    /// Judges everything recorded so far by the checker; empty is the proof.
    pub fn check(&self) -> Vec<Violation> {
        let mut found = self.violations.clone();
        found.extend(checker::check_from(&self.frame.graph, &self.log, &mut self.progress.clone()));
        found
    }

    /// What was recorded since the last call of [`draw`](Self::draw) began; what was before has been judged.
    pub fn log(&self) -> &[Event] {
        &self.log
    }
}
