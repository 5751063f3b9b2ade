//! One setting: what came of it, in numbers and in words.

use serde_json::{Value, json};

use super::knobs::Knob;
use crate::lists::Counters;
use crate::measure::metrics::Difference;
use crate::measure::times::{FrameTimes, Spread};

/// One setting of a knob.
#[derive(Default)]
pub(super) struct Cell {
    pub(super) setting: String,
    /// Why nothing was drawn, where that is so.
    pub(super) refusal: Option<String>,
    /// The technique that was planned.
    pub(super) technique: Option<&'static str>,
    pub(super) times: FrameTimes,
    /// Of the device, without the read-back.
    pub(super) memory_bytes: u64,
    /// From the reference.
    pub(super) error: Option<Difference>,
    pub(super) from_forward: Option<Difference>,
    /// `None` for a technique without lists.
    pub(super) counters: Option<Counters>,
    /// No other setting is both quicker and closer.
    pub(super) on_time_front: bool,
    /// No other setting is both smaller and closer.
    pub(super) on_bytes_front: bool,
}

impl Cell {
    /// Milliseconds of the frame.
    pub(super) fn frame(&self) -> Option<Spread> {
        (!self.times.wall_ms.is_empty()).then(|| self.times.frame())
    }

    /// Milliseconds of the passes that the knob touches, together; `None` without timestamps.
    pub(super) fn passes(&self, knob: &Knob) -> Option<Spread> {
        let rows = &self.times.node_ms;
        if rows.is_empty() || rows.iter().any(Vec::is_empty) {
            return None;
        }
        let touched: Vec<bool> = self.times.names.iter().map(|name| knob.touches(name)).collect();
        let of_frame =
            |row: &Vec<f64>| row.iter().zip(&touched).filter(|(_, touched)| **touched).map(|(ms, _)| ms).sum::<f64>();
        Some(Spread::of(&rows.iter().map(of_frame).collect::<Vec<f64>>()))
    }

    /// Mean relative error and median milliseconds of the frame.
    fn time_point(&self) -> Option<[f64; 2]> {
        Some([self.error?.mean_relative, self.frame()?.median])
    }

    /// Mean relative error and bytes.
    fn bytes_point(&self) -> Option<[f64; 2]> {
        Some([self.error?.mean_relative, self.memory_bytes as f64])
    }

    /// A row of the machine form.
    pub(super) fn json(&self, knob: &Knob) -> Value {
        let counters = self.counters.as_ref();
        let touched = self.times.names.iter().filter(|name| knob.touches(name));
        json!({
            "knob": knob.name,
            "setting": self.setting,
            "technique": self.technique,
            "outcome": if self.refusal.is_none() { "measured" } else { "refused" },
            "why": self.refusal,
            "frames": self.times.wall_ms.len(),
            "ms": self.frame(),
            "passes": touched.collect::<Vec<_>>(),
            "passes_ms": self.passes(knob),
            "reference": knob.against.name(),
            "error": self.error.map(|error| json!({ "mean": error.mean_relative, "max": error.max_relative })),
            "from_forward": self.from_forward.map(|difference| json!({
                "mean": difference.mean_relative,
                "max": difference.max_relative,
                "differing_pixels": difference.differing_pixels,
            })),
            "light_pairs": counters.map(|counters| counters.light_pairs),
            "missed_pairs": counters.map(|counters| counters.missed_pairs),
            "waste_samples": counters.map(|counters| counters.waste_samples),
            "waste_cells": counters.map(|counters| counters.waste_cells),
            "memory_bytes": self.refusal.is_none().then_some(self.memory_bytes),
            "on_time_front": self.on_time_front,
            "on_bytes_front": self.on_bytes_front,
        })
    }
}

/// Marks the settings that no other beats.
pub(super) fn mark_fronts(cells: &mut [Cell]) {
    let of = |point: fn(&Cell) -> Option<[f64; 2]>, cells: &[Cell]| front(&cells.iter().map(point).collect::<Vec<_>>());
    let (time, bytes) = (of(Cell::time_point, cells), of(Cell::bytes_point, cells));
    for (cell, (time, bytes)) in cells.iter_mut().zip(time.into_iter().zip(bytes)) {
        (cell.on_time_front, cell.on_bytes_front) = (time, bytes);
    }
}

/// Whether no other point is at most as large in both coordinates and smaller in one (V. Pareto, "Manuale di economia politica", 1906);
/// points that are missing or not finite are on no front and beat none.
fn front(points: &[Option<[f64; 2]>]) -> Vec<bool> {
    let finite = |point: &Option<[f64; 2]>| point.filter(|p| p.iter().all(|x| x.is_finite()));
    let points: Vec<_> = points.iter().map(finite).collect();
    let beats = |a: [f64; 2], b: [f64; 2]| a[0] <= b[0] && a[1] <= b[1] && a != b;
    let on_front = |point: &Option<[f64; 2]>| point.is_some_and(|p| !points.iter().flatten().any(|&q| beats(q, p)));
    points.iter().map(on_front).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::KnobName;
    use crate::commands::accuracy::knobs;
    use crate::measure::metrics;
    use crate::plan::Request;

    #[test]
    fn a_front_has_what_no_other_point_beats() {
        let points = [[1.0, 9.0], [2.0, 5.0], [2.0, 6.0], [3.0, 5.0], [4.0, 1.0], [4.0, 1.0]].map(Some);
        assert_eq!(front(&points), [true, true, false, false, true, true]);
    }

    #[test]
    fn what_was_not_measured_is_on_no_front() {
        let points = [None, Some([f64::NAN, 0.0]), Some([f64::INFINITY, 0.0]), Some([5.0, 5.0])];
        assert_eq!(front(&points), [false, false, false, true]);
        assert!(front(&[]).is_empty());
    }

    fn cell(median: f64, bytes: u64, error: f32) -> Cell {
        let names = ["depth_prepass", "depth_reduce", "tile_fill", "tiled_forward"].map(String::from).to_vec();
        let rows = vec![vec![1.0, 2.0, 3.0, 4.0], vec![1.0, 0.0, 1.0, 1.0], vec![2.0, 1.0, 2.0, 5.0]];
        let error = metrics::compare(&[[1.0; 4]], &[[f64::from(1.0 + error); 4]]);
        Cell {
            times: FrameTimes::new(names, vec![median; 3], rows),
            memory_bytes: bytes,
            error: Some(error),
            ..Cell::default()
        }
    }

    #[test]
    fn touched_passes_are_summed_within_a_frame() {
        let of = |name| knobs::knob(name, &Request::default(), &[]);
        let spread = cell(9.0, 1, 0.5).passes(&of(KnobName::Cull)).expect("timestamps");
        assert_eq!(spread, Spread { median: 7.0, min: 2.0, max: 7.0 });
        assert_eq!(cell(9.0, 1, 0.5).passes(&of(KnobName::Tile)).map(|spread| spread.max), Some(9.0));
        assert!(Cell::default().passes(&of(KnobName::Tile)).is_none());
        let mut without = cell(9.0, 1, 0.5);
        without.times.node_ms = vec![Vec::new(); 3];
        assert!(without.passes(&of(KnobName::Tile)).is_none());
    }

    #[test]
    fn fronts_of_time_and_of_bytes_are_apart() {
        let refused = Cell { refusal: Some("no".into()), ..Cell::default() };
        let mut cells = [cell(9.0, 1, 0.25), cell(5.0, 2, 0.25), cell(7.0, 3, 0.5), refused];
        mark_fronts(&mut cells);
        assert_eq!(cells.each_ref().map(|cell| cell.on_time_front), [false, true, false, false]);
        assert_eq!(cells.each_ref().map(|cell| cell.on_bytes_front), [true, false, false, false]);
        let row = cells[3].json(&knobs::knob(KnobName::Tile, &Request::default(), &[]));
        assert!(row["ms"].is_null() && row["memory_bytes"].is_null() && row["outcome"] == "refused");
    }
}
