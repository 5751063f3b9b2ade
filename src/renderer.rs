//! The way through the library on a device: open it, prepare a planned scene, draw frames, read times and pictures back.

use std::sync::Arc;
use std::time::Instant;

use bytemuck::{bytes_of, cast_slice};

use crate::error::{Error, Result};
use crate::gpu::pipeline_cache::PipelineCache;
use crate::gpu::realize::Realized;
use crate::gpu::{Device, Options};
use crate::graph::checker::{self, Layouts, Violation};
use crate::graph::hazard::{self, Barrier};
use crate::graph::log::Event;
use crate::measure::picture::Picture;
use crate::measure::times::FrameTimes;
use crate::passes::{self, Frame};
use crate::plan::{Limits, Plan};
use crate::record::Recorder;
use crate::record::upload::Uploader;
use crate::scene::{Scene, mips};
use crate::shared;
use crate::submit::Queue;

/// Events after which a log is judged and dropped.
const LONG_LOG: usize = 4096;

/// An open device with its pipeline cache.
pub struct Renderer {
    cache: PipelineCache,
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
        Ok(Self { cache, device })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// True where compiled pipelines of an earlier run were found.
    pub fn cache_is_warm(&self) -> bool {
        self.cache.warm
    }

    /// The device's limits as plain numbers for [`Plan::new`].
    pub fn limits(&self) -> Limits {
        let (facts, limits) = (&self.device.facts, &self.device.facts.limits);
        Limits {
            max_image_dimension: limits.max_image_dimension2_d,
            max_buffer_bytes: facts.max_buffer_bytes,
            max_storage_bytes: u64::from(limits.max_storage_buffer_range),
            max_uniform_bytes: u64::from(limits.max_uniform_buffer_range),
            max_texel_elements: u64::from(limits.max_texel_buffer_elements),
            max_color_attachments: limits.max_color_attachments,
            max_stage_storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
        }
    }

    /// Messages of the validation layer so far; taken, so that each is seen once.
    pub fn take_messages(&self) -> Vec<String> {
        self.device.instance.messages().take()
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
        let barriers = hazard::derive(&frame.graph);
        let realized = Realized::create(&self.device, &frame.graph, &self.cache)?;
        let mut queue = Queue::create(&self.device, frame.graph.nodes.len() as u32 + 1)?;
        let start = Instant::now();
        upload(&self.device, &mut queue, &realized, &frame, scene, plan)?;
        let upload_ms = start.elapsed().as_secs_f64() * 1e3;
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
            layouts: Layouts::default(),
            violations: Vec::new(),
        })
    }
}

fn upload(
    device: &Arc<Device>,
    queue: &mut Queue,
    realized: &Realized,
    frame: &Frame,
    scene: &Scene,
    plan: &Plan,
) -> Result<()> {
    let mut uploader = Uploader::new(device);
    let handles = &frame.scene;
    let constants = shared::Frame {
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
    };
    uploader.buffer(queue, realized.buffer(handles.frame), bytes_of(&constants))?;
    uploader.buffer(queue, realized.buffer(handles.instances), cast_slice(&plan.geometry.instances))?;
    uploader.buffer(queue, realized.buffer(handles.materials), cast_slice(&plan.materials.data))?;
    uploader.buffer(queue, realized.buffer(handles.lights), cast_slice(&plan.lights.texels))?;
    uploader.buffer(queue, realized.buffer(handles.vertices), &plan.geometry.vertex_data(scene))?;
    uploader.buffer(queue, realized.buffer(handles.indices), cast_slice(&plan.geometry.index_data(scene)))?;
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

/// A scene on the device, ready to be drawn any number of times.
pub struct Prepared {
    queue: Queue,
    realized: Realized,
    frame: Frame,
    barriers: Vec<Barrier>,
    device: Arc<Device>,
    size: [u32; 2],
    log: Vec<Event>,
    /// Layouts where the log begins, and what was found before it.
    layouts: Layouts,
    violations: Vec<Violation>,
    /// Milliseconds of making pipelines.
    pub pipelines_ms: f64,
    /// Milliseconds of uploads.
    pub upload_ms: f64,
}

impl Prepared {
    /// The frame's graph and its derived barriers.
    pub fn graph(&self) -> (&crate::graph::Graph, &[Barrier]) {
        (&self.frame.graph, &self.barriers)
    }

    /// Leaves out the barrier that `node` has for `resource`, from now on: for studying what a missing one does.
    pub fn forget_barrier(&mut self, node: &str, resource: &str) {
        let graph = &self.frame.graph;
        self.barriers.retain(|b| graph.nodes[b.before].name != node || graph.name_of(b.resource) != resource);
    }

    /// Draws `count` frames with two in flight and times them.
    ///
    /// # Errors
    /// A lost device.
    pub fn draw(&mut self, count: usize) -> Result<FrameTimes> {
        let Self { queue, realized, frame, barriers, device, log, layouts, violations, .. } = self;
        let nodes = frame.graph.frame_len();
        let (walls, timings) = queue.frames(count, |commands, timer| {
            let mut recorder = Recorder { device, commands, timer, log: std::mem::take(log) };
            recorder.nodes(&frame.graph, barriers, realized, 0..nodes);
            *log = recorder.log;
            nodes as u32 + 1
        })?;
        log.push(Event::HostWait);
        if log.len() > LONG_LOG {
            violations.extend(checker::check_from(&frame.graph, log, layouts));
            log.clear();
        }
        let names = frame.graph.nodes[..nodes].iter().map(|n| n.name.clone()).collect();
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
    /// it comes what [`check`](Self::check) finds.
    ///
    /// # Errors
    /// As there.
    pub fn finish(mut self) -> Result<(Picture, Vec<Violation>)> {
        self.copy_back()?;
        let found = self.check();
        self.realized.images.clear();
        Ok((self.collect()?, found))
    }

    fn copy_back(&mut self) -> Result<()> {
        let Self { queue, realized, frame, barriers, device, log, .. } = self;
        let graph = &frame.graph;
        let value = queue.submit(|commands, _| {
            let mut recorder = Recorder { device, commands, timer: None, log: std::mem::take(log) };
            recorder.nodes(graph, barriers, realized, graph.frame_len()..graph.nodes.len());
            *log = recorder.log;
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
            let values = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            picture.add_layer(name, values.collect());
        }
        Ok(picture)
    }

    /// Judges everything recorded so far by the checker; empty is the proof.
    pub fn check(&self) -> Vec<Violation> {
        let mut found = self.violations.clone();
        found.extend(checker::check_from(&self.frame.graph, &self.log, &mut self.layouts.clone()));
        found
    }

    /// What was recorded and is kept: everything, until a long log has been judged.
    pub fn log(&self) -> &[Event] {
        &self.log
    }
}
