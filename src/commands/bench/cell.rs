//! One case on one device: what came of it, in numbers and in words.

use std::time::Duration;

use serde_json::{Value, json};

use super::run::{Runner, SLOW_MS};
use crate::commands::measured;
use crate::measure::times::{FrameTimes, Spread};
use crate::plan::Plan;

/// Parts of a frame, in the order of [`stage_of`].
pub(super) const STAGES: [&str; 4] = ["geometry", "depth reduction", "light lists", "shading"];

/// What came of a case.
pub(super) enum Verdict {
    /// Frames were timed.
    Measured(FrameTimes),
    /// The plan, or the device, says why not.
    Refused(String),
    /// A frame took so many milliseconds.
    TooSlow(f64),
    /// A frame would take so many milliseconds.
    Predicted(f64),
}

/// One case on one device.
pub(super) struct Cell {
    /// Index of the device.
    pub(super) device: usize,
    pub(super) case: String,
    pub(super) verdict: Verdict,
    /// The technique that was planned.
    pub(super) technique: Option<&'static str>,
    /// Of light lists, at most.
    pub(super) list_bytes: u64,
    /// That making it ready took of the device's memory.
    pub(super) device_bytes: u64,
    pub(super) plan_ms: f64,
    /// Pipelines and uploads.
    pub(super) prepare_ms: f64,
    /// The frame that warms up.
    pub(super) first_ms: f64,
}

impl Cell {
    pub(super) fn new(device: usize, case: &str) -> Self {
        Self {
            device,
            case: case.into(),
            verdict: Verdict::Measured(FrameTimes::default()),
            technique: None,
            list_bytes: 0,
            device_bytes: 0,
            plan_ms: 0.0,
            prepare_ms: 0.0,
            first_ms: 0.0,
        }
    }

    /// Keeps what matters of the plan.
    pub(super) fn planned(&mut self, plan: &Plan, took: Duration) {
        let lists = plan.effects.iter().filter(|e| e.runs && matches!(e.name, "light_lists" | "clusters"));
        self.list_bytes = lists.map(|e| e.bytes).sum();
        self.technique = Some(plan.technique.name());
        self.plan_ms = took.as_secs_f64() * 1e3;
    }

    /// Times of its frames.
    pub(super) fn times(&self) -> Option<&FrameTimes> {
        match &self.verdict {
            Verdict::Measured(times) if !times.wall_ms.is_empty() => Some(times),
            _ => None,
        }
    }

    /// Milliseconds a frame.
    pub(super) fn spread(&self) -> Option<Spread> {
        self.times().map(FrameTimes::frame)
    }

    /// Median milliseconds of each of [`STAGES`]; `None` without timestamps.
    pub(super) fn stages(&self) -> Option<[f64; STAGES.len()]> {
        let times = self.times().filter(|times| times.node_ms.iter().all(|row| !row.is_empty()))?;
        let of_frame = |row: &[f64], stage: usize| -> f64 {
            times.names.iter().zip(row).filter(|(name, _)| stage_of(name) == stage).map(|(_, ms)| ms).sum()
        };
        Some(std::array::from_fn(|stage| {
            Spread::of(&times.node_ms.iter().map(|row| of_frame(row, stage)).collect::<Vec<_>>()).median
        }))
    }

    /// Milliseconds a frame, measured or not.
    pub(super) fn known_ms(&self) -> Option<f64> {
        match self.verdict {
            Verdict::TooSlow(ms) | Verdict::Predicted(ms) => Some(ms),
            _ => self.spread().map(|spread| spread.median),
        }
    }

    /// What stands in the place of a number that was not measured: a bound, or a refusal with the number of its sentence in `notes`.
    pub(super) fn missing(&self, notes: &mut Vec<String>) -> String {
        match &self.verdict {
            Verdict::Measured(_) => "-".into(),
            Verdict::TooSlow(_) => format!("> {} s", SLOW_MS / 1e3),
            Verdict::Predicted(_) => format!("> {} s (predicted)", SLOW_MS / 1e3),
            Verdict::Refused(sentence) => measured::refused(sentence, notes),
        }
    }

    /// Why there is no number.
    pub(super) fn why(&self) -> Option<String> {
        match &self.verdict {
            Verdict::Measured(_) => None,
            Verdict::Refused(sentence) => Some(sentence.clone()),
            Verdict::TooSlow(ms) => Some(format!("a frame took {:.1} s", ms / 1e3)),
            Verdict::Predicted(ms) => Some(format!("not drawn: by a smaller case a frame takes {:.1} s", ms / 1e3)),
        }
    }

    /// A row of the machine form.
    pub(super) fn json(&self, runner: &Runner) -> Value {
        let stages = self.stages();
        let stage = |index: usize| stages.map(|ms| ms[index]);
        let outcome = match self.verdict {
            Verdict::Measured(_) => "measured",
            Verdict::Refused(_) => "refused",
            Verdict::TooSlow(_) => "too slow",
            Verdict::Predicted(_) => "predicted",
        };
        json!({
            "device": runner.renderers[self.device].device().facts.name,
            "case": self.case,
            "technique": self.technique,
            "outcome": outcome,
            "why": self.why(),
            "ms": self.spread(),
            "frames": self.times().map_or(0, |times| times.wall_ms.len()),
            "frames_per_second": self.spread().map(|spread| 1e3 / spread.median),
            "stages_ms": {
                "geometry": stage(0), "depth_reduction": stage(1), "light_lists": stage(2), "shading": stage(3),
            },
            "plan_ms": self.plan_ms,
            "prepare_ms": self.prepare_ms,
            "first_frame_ms": self.first_ms,
            "list_bytes": self.list_bytes,
            "device_bytes": self.device_bytes,
        })
    }
}

/// Which of [`STAGES`] a pass belongs to. What is not named here shades.
fn stage_of(pass: &str) -> usize {
    const GEOMETRY: [&str; 2] = ["depth_prepass", "gbuffer"];
    const LISTS: [&str; 9] = ["tile_", "bin_", "block_", "entry_", "cluster_", "flag_", "light_", "list_", "fill_"];
    let pass = pass.strip_prefix("transparent_").unwrap_or(pass);
    match pass {
        "depth" => 0,
        pass if GEOMETRY.iter().any(|prefix| pass.starts_with(prefix)) => 0,
        "depth_reduce" => 1,
        "light_volumes" | "light_markers" => 3,
        pass if LISTS.iter().any(|prefix| pass.starts_with(prefix)) => 2,
        _ => 3,
    }
}

/// Two decimals below 10, one below 1000, else none.
pub(super) fn digits(value: f64) -> String {
    match value {
        value if value < 10.0 => format!("{value:.2}"),
        value if value < 1000.0 => format!("{value:.1}"),
        value => format!("{value:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(rows: &[[f64; 4]]) -> Cell {
        let names = ["depth_prepass", "bin_scan_sum_0", "tile_fill", "tiled_forward"].map(String::from).to_vec();
        let walls = rows.iter().map(|row| row.iter().sum()).collect();
        let times = FrameTimes::new(names, walls, rows.iter().map(|row| row.to_vec()).collect());
        Cell { verdict: Verdict::Measured(times), ..Cell::new(0, "tiled-forward") }
    }

    #[test]
    fn passes_are_summed_by_stage_within_a_frame() {
        let cell = measured(&[[1.0, 2.0, 3.0, 4.0], [1.0, 5.0, 0.0, 7.0], [2.0, 1.0, 2.0, 5.0]]);
        assert_eq!(cell.stages(), Some([1.0, 0.0, 5.0, 5.0]));
        assert_eq!(cell.spread().map(|s| s.median), Some(10.0));
        assert_eq!(Cell::new(0, "nothing drawn").stages(), None);
        let none = FrameTimes::new(vec!["forward".into()], vec![3.0], vec![Vec::new()]);
        assert_eq!(Cell { verdict: Verdict::Measured(none), ..Cell::new(0, "no timestamps") }.stages(), None);
    }

    #[test]
    fn equal_refusals_share_a_note() {
        let refused = |why: &str| Cell { verdict: Verdict::Refused(why.into()), ..Cell::new(0, "forward") };
        let mut notes = Vec::new();
        let texts: Vec<_> = ["a", "b", "a"].map(|why| refused(why).missing(&mut notes)).to_vec();
        assert_eq!(texts, ["refused [1]", "refused [2]", "refused [1]"]);
        assert_eq!(notes, ["a", "b"]);
        let slow = |verdict| Cell { verdict, ..Cell::new(0, "forward") }.missing(&mut notes);
        assert_eq!([Verdict::TooSlow(12e3), Verdict::Predicted(2e4)].map(slow), ["> 10 s", "> 10 s (predicted)"]);
    }

    #[test]
    fn every_pass_has_a_stage() {
        let of = |name| STAGES[stage_of(name)];
        assert_eq!(["gbuffer", "depth_prepass"].map(of), ["geometry"; 2]);
        assert_eq!(["tile_fill", "block_scan_sum_0", "cluster_cells", "light_nodes_1"].map(of), ["light lists"; 4]);
        assert_eq!(["tiled_forward", "clustered_forward", "deferred_base", "light_volumes"].map(of), ["shading"; 4]);
        assert_eq!(of("depth_reduce"), "depth reduction");
    }

    #[test]
    fn large_numbers_have_fewer_decimals() {
        assert_eq!([0.0123, 9.5, 12.34, 999.4, 12345.6].map(digits), ["0.01", "9.50", "12.3", "999.4", "12346"]);
    }
}
