//! The queue: command buffers of two frames in flight, one timeline semaphore, GPU timers read when a frame has ended.
#![allow(unsafe_code)]

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::{Device, failed};

/// Frames that may be on the device at once.
pub const FRAMES_IN_FLIGHT: usize = 2;

/// Longest wait for a submission before the device counts as lost.
const TIMEOUT: Duration = Duration::from_secs(600);

struct Slot {
    commands: vk::CommandBuffer,
    timer: Option<vk::QueryPool>,
    /// Timestamps written by the last submission.
    written: u32,
    /// Value that the timeline reaches when the slot is free.
    value: u64,
}

/// Timestamps of one ended submission.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timings {
    /// Milliseconds between consecutive timestamps; empty without a timer.
    pub node_ms: Vec<f64>,
}

/// Submits in order and waits by value.
pub struct Queue {
    device: Arc<Device>,
    pool: vk::CommandPool,
    timeline: vk::Semaphore,
    slots: Vec<Slot>,
    submitted: u64,
    timer_queries: u32,
}

impl Queue {
    /// A queue whose timers hold `timer_queries` timestamps a submission (0: none).
    pub fn create(device: &Arc<Device>, timer_queries: u32) -> Result<Self> {
        let timers = device.facts.timestamp_bits > 0 && timer_queries > 0;
        // Filled in as it is made, so that whatever exists is destroyed when a later step fails; null handles are ignored.
        let mut queue = Self {
            device: device.clone(),
            pool: vk::CommandPool::null(),
            timeline: vk::Semaphore::null(),
            slots: Vec::new(),
            submitted: 0,
            timer_queries: if timers { timer_queries } else { 0 },
        };
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(device.queue_family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: plain creation.
        let pool = unsafe { device.raw.create_command_pool(&info, None) };
        queue.pool = pool.map_err(failed("creating a command pool"))?;
        let mut kind = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: plain creation.
        let timeline = unsafe { device.raw.create_semaphore(&info, None) };
        queue.timeline = timeline.map_err(failed("creating the timeline semaphore"))?;
        device.name(queue.timeline, "timeline");
        for _ in 0..FRAMES_IN_FLIGHT {
            queue.add_slot()?;
        }
        Ok(queue)
    }

    fn add_slot(&mut self) -> Result<()> {
        let raw = &self.device.raw;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        // SAFETY: the pool is alive.
        let commands =
            unsafe { raw.allocate_command_buffers(&info) }.map_err(failed("allocating a command buffer"))?[0];
        let timer = if self.timer_queries > 0 {
            let info =
                vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(self.timer_queries);
            // SAFETY: plain creation.
            Some(unsafe { raw.create_query_pool(&info, None) }.map_err(failed("creating a query pool"))?)
        } else {
            None
        };
        self.slots.push(Slot { commands, timer, written: 0, value: 0 });
        Ok(())
    }

    /// Records into the next slot and submits it; returns the timeline value of its end. Waits first while all slots are
    /// in flight. `record` gets the command buffer and the timer and says how many timestamps it writes.
    pub fn submit(&mut self, record: impl FnOnce(vk::CommandBuffer, Option<vk::QueryPool>) -> u32) -> Result<u64> {
        let index = (self.submitted as usize) % FRAMES_IN_FLIGHT;
        let free_at = self.slots[index].value;
        self.wait(free_at)?;
        let slot = &mut self.slots[index];
        let raw = &self.device.raw;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the slot's last submission has ended.
        unsafe { raw.begin_command_buffer(slot.commands, &begin) }.map_err(failed("recording"))?;
        slot.written = record(slot.commands, slot.timer);
        // SAFETY: begun above.
        unsafe { raw.end_command_buffer(slot.commands) }.map_err(failed("recording"))?;
        let value = self.submitted + 1;
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let signals = [vk::SemaphoreSubmitInfo::default()
            .semaphore(self.timeline)
            .value(value)
            // Everything has ended: a frame's resources are free for the host and the next frame in this slot.
            .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
        let info = [vk::SubmitInfo2::default().command_buffer_infos(&commands).signal_semaphore_infos(&signals)];
        // SAFETY: everything recorded is alive until the timeline reaches the value.
        unsafe { raw.queue_submit2(self.device.queue, &info, vk::Fence::null()) }.map_err(failed("submitting"))?;
        (self.submitted, slot.value) = (value, value);
        Ok(value)
    }

    /// Waits until the timeline has reached `value`.
    pub fn wait(&self, value: u64) -> Result<()> {
        let (semaphores, values) = ([self.timeline], [value]);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        // SAFETY: the semaphore is alive; every value waited for has been submitted.
        unsafe { self.device.raw.wait_semaphores(&info, TIMEOUT.as_nanos() as u64) }.map_err(|e| match e {
            vk::Result::TIMEOUT => Error::new(format!("the device did not finish within {} s", TIMEOUT.as_secs())),
            other => failed("waiting for the device")(other),
        })
    }

    /// Records, submits and waits.
    pub fn once(&mut self, record: impl FnOnce(vk::CommandBuffer)) -> Result<()> {
        let value = self.submit(|commands, _| {
            record(commands);
            0
        })?;
        self.wait(value)
    }

    /// Times of the submission that ended at `value`, while its slot has not been used again.
    pub fn timings(&self, value: u64) -> Result<Timings> {
        let Some(slot) = self.slots.iter().find(|s| s.value == value) else { return Ok(Timings::default()) };
        let Some(pool) = slot.timer.filter(|_| slot.written > 1) else { return Ok(Timings::default()) };
        let mut ticks = vec![0u64; slot.written as usize];
        // SAFETY: `written` queries were written by a submission that has ended.
        unsafe { self.device.raw.get_query_pool_results(pool, 0, &mut ticks, vk::QueryResultFlags::TYPE_64) }
            .map_err(failed("reading timestamps"))?;
        let bits = self.device.facts.timestamp_bits;
        let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
        let tick_ms = f64::from(self.device.facts.limits.timestamp_period) * 1e-6;
        // Nodes that do not wait for one another may end out of order: a difference past half the counter is a small negative one.
        let elapsed = |w: &[u64]| Some(w[1].wrapping_sub(w[0]) & mask).filter(|d| *d <= mask / 2).unwrap_or(0);
        let node_ms = ticks.windows(2).map(|w| elapsed(w) as f64 * tick_ms).collect();
        Ok(Timings { node_ms })
    }

    /// Runs `count` frames with two in flight; the wall-clock milliseconds between consecutive ends, and every frame's timers.
    pub fn frames(
        &mut self,
        count: usize,
        mut record: impl FnMut(vk::CommandBuffer, Option<vk::QueryPool>) -> u32,
    ) -> Result<(Vec<f64>, Vec<Timings>)> {
        let (mut walls, mut timings) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut last_end = Instant::now();
        let mut pending: Option<u64> = None;
        for frame in 0..=count {
            let next = if frame < count { Some(self.submit(&mut record)?) } else { None };
            if let Some(value) = pending {
                self.wait(value)?;
                let end = Instant::now();
                walls.push(end.duration_since(last_end).as_secs_f64() * 1e3);
                last_end = end;
                timings.push(self.timings(value)?);
            }
            pending = next;
        }
        Ok((walls, timings))
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        // SAFETY: the device is idle before its objects go.
        unsafe {
            let _ = self.device.raw.device_wait_idle();
            for slot in &self.slots {
                if let Some(timer) = slot.timer {
                    self.device.raw.destroy_query_pool(timer, None);
                }
            }
            self.device.raw.destroy_semaphore(self.timeline, None);
            self.device.raw.destroy_command_pool(self.pool, None);
        }
    }
}
