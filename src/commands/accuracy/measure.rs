//! Measuring a knob: its settings are prepared together and drawn in turns, then each picture and each list is judged.

use indicatif::ProgressBar;

use super::cell::{Cell, mark_fronts};
use super::judge::{Judge, radiance};
use super::knobs::{Knob, planned};
use crate::commands::measured;
use crate::error::Result;
use crate::lists::{self, Counters};
use crate::measure::times::FrameTimes;
use crate::plan::{Plan, Request};
use crate::renderer::{Prepared, Renderer};
use crate::scene::Scene;

/// What every knob is measured with.
pub(super) struct Runner<'a> {
    pub(super) renderer: &'a Renderer,
    pub(super) scene: &'a Scene,
    pub(super) judge: &'a Judge,
    /// Most frames of each setting.
    pub(super) rounds: u32,
    /// Of drawing, after which a setting gets no further frame.
    pub(super) seconds: f64,
}

/// A setting while it may still be drawn.
struct Drawn {
    /// Of the knob's cells.
    index: usize,
    plan: Plan,
    prepared: Prepared,
    times: FrameTimes,
}

impl Runner<'_> {
    /// Measures and judges every setting.
    ///
    /// # Errors
    /// A lost device.
    pub(super) fn measure(&self, knob: &Knob) -> Result<Vec<Cell>> {
        // Preparing, drawing and judging.
        let steps = knob.settings.len() as u64 * (u64::from(self.rounds) + 2);
        let bar = measured::progress(steps, knob.name);
        let cells = self.measure_with(knob, &bar);
        bar.finish_and_clear();
        cells
    }

    fn measure_with(&self, knob: &Knob, bar: &ProgressBar) -> Result<Vec<Cell>> {
        let mut cells = Vec::new();
        let mut drawn = Vec::new();
        for (index, (setting, request)) in knob.settings.iter().enumerate() {
            let mut cell = Cell { setting: setting.clone(), ..Cell::default() };
            match self.prepare(request, &mut cell) {
                Ok((plan, prepared)) => drawn.push(Drawn { index, plan, prepared, times: FrameTimes::default() }),
                Err(error) => cell.refusal = Some(error.to_string()),
            }
            cells.push(cell);
            bar.inc(1);
        }
        for setting in &mut drawn {
            // Warms up.
            setting.prepared.draw(1)?;
        }
        for _ in 0..self.rounds {
            for setting in &mut drawn {
                setting.draw(self.seconds)?;
                bar.inc(1);
            }
        }
        for setting in drawn {
            self.conclude(knob, setting, &mut cells)?;
            bar.inc(1);
        }
        mark_fronts(&mut cells);
        Ok(cells)
    }

    /// Plans and makes a setting's frame, and counts its bytes.
    fn prepare(&self, request: &Request, cell: &mut Cell) -> Result<(Plan, Prepared)> {
        let plan = Plan::new(self.scene, request, &self.renderer.limits())?;
        cell.technique = Some(plan.technique.name());
        if let Some(clusters) = &plan.clusters {
            cell.setting = planned(&cell.setting, clusters);
        }
        let before = device_bytes(self.renderer);
        let prepared = self.renderer.prepare(self.scene, &plan)?;
        cell.memory_bytes = device_bytes(self.renderer).saturating_sub(before);
        Ok((plan, prepared))
    }

    /// Compares a setting's picture, frees its frame, and counts its lists.
    fn conclude(&self, knob: &Knob, drawn: Drawn, cells: &mut [Cell]) -> Result<()> {
        let Drawn { index, plan, mut prepared, times } = drawn;
        let cell = &mut cells[index];
        cell.times = times;
        let picture = prepared.read_back()?;
        drop(prepared);
        let pixels = radiance(&picture)?;
        cell.error = Some(self.judge.error(pixels, knob.against));
        cell.from_forward = self.judge.beside_forward(pixels);
        // Lists are read back with one sample a pixel.
        if plan.has_lists() && plan.samples == 1 {
            let made = lists::make(self.renderer, self.scene, &plan)?;
            cell.counters = Some(Counters::new(&made.cells, &made.judge(&plan), lists::directional(&plan)));
        }
        Ok(())
    }
}

impl Drawn {
    /// Draws one more frame, unless those before took so many seconds together.
    fn draw(&mut self, seconds: f64) -> Result<()> {
        if self.times.wall_ms.iter().sum::<f64>() >= seconds * 1e3 {
            return Ok(());
        }
        let one = self.prepared.draw(1)?;
        self.times.names = one.names;
        self.times.wall_ms.extend(one.wall_ms);
        self.times.node_ms.extend(one.node_ms);
        Ok(())
    }
}

/// Bytes of every resource that is there now; what only the read-back needs is none of the technique's.
fn device_bytes(renderer: &Renderer) -> u64 {
    let accounts = renderer.device().accounts.lock().map(|accounts| accounts.live.clone()).unwrap_or_default();
    accounts.iter().filter(|(name, _)| !name.ends_with(" (host)")).map(|(_, bytes)| bytes).sum()
}
