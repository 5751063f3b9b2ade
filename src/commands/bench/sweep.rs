//! Cells over one quantity: their tables, figures and rows of the machine form.

use serde_json::{Map, Value, json};

use super::cell::{Cell, STAGES, digits};
use super::run::{Case, Loaded, Runner};
use crate::error::Result;
use crate::measure::html::Table;
use crate::measure::plot::{Axis, Bars, Figure, Plot, Point, Scale, Series};

/// What is shown of a cell.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    Milliseconds,
    FramesPerSecond,
}

impl Shown {
    fn label(self) -> &'static str {
        match self {
            Self::Milliseconds => "frame (ms)",
            Self::FramesPerSecond => "frames a second",
        }
    }

    /// Median with the ends of its spread.
    fn of(self, cell: &Cell) -> Option<[f64; 3]> {
        let spread = cell.spread()?;
        Some(match self {
            Self::Milliseconds => [spread.median, spread.min, spread.max],
            Self::FramesPerSecond => [1e3 / spread.median, 1e3 / spread.max, 1e3 / spread.min],
        })
    }
}

/// A group that was measured.
pub(super) struct Place {
    /// For tables.
    pub(super) name: String,
    /// Of the quantity.
    pub(super) x: f64,
    /// An object: what its rows say beside the cell.
    pub(super) facts: Value,
    /// As many in each place, in the same order.
    pub(super) cells: Vec<Cell>,
}

/// An experiment's groups.
pub(super) struct Sweep {
    /// What differs from group to group.
    pub(super) quantity: &'static str,
    pub(super) places: Vec<Place>,
}

impl Sweep {
    pub(super) fn new(quantity: &'static str) -> Self {
        Self { quantity, places: Vec::new() }
    }

    /// The same cases over numbers of lights.
    ///
    /// # Errors
    /// A lost device.
    pub(super) fn over_lights(
        runner: &Runner,
        what: &'static str,
        loaded: &mut Loaded,
        cases: &[Case],
        (counts, range): (&[u32], f64),
    ) -> Result<Self> {
        let mut session = runner.session(what, counts.len() * cases.len());
        let mut sweep = Self::new("lights");
        for &count in counts {
            runner.light(loaded, count)?;
            let cells = session.group(&loaded.scene, cases, Some(f64::from(count)))?;
            let facts = json!({ "lights": count, "light_range": range });
            sweep.places.push(Place { name: count.to_string(), x: f64::from(count), facts, cells });
        }
        Ok(sweep)
    }

    /// Names of the cells of each place.
    pub(super) fn names(&self, runner: &Runner) -> Vec<String> {
        let first = self.places.first();
        first.into_iter().flat_map(|place| &place.cells).map(|cell| runner.name_of(cell)).collect()
    }

    /// Medians: a row a case, a column a place.
    pub(super) fn table(&self, runner: &Runner, shown: Shown, notes: &mut Vec<String>) -> Table {
        let corner = std::iter::once(self.quantity.to_string());
        let header = corner.chain(self.places.iter().map(|place| place.name.clone())).collect();
        let names = self.names(runner);
        let row = |(index, name): (usize, &String)| {
            let cells = self.places.iter().map(|place| text(&place.cells[index], shown, notes));
            std::iter::once(name.clone()).chain(cells).collect()
        };
        Table { caption: caption(shown), header, rows: names.iter().enumerate().map(row).collect() }
    }

    /// Medians: a row a place, a column a case.
    pub(super) fn turned(&self, runner: &Runner, shown: Shown, notes: &mut Vec<String>) -> Table {
        let header = std::iter::once(self.quantity.to_string()).chain(self.names(runner)).collect();
        let row = |place: &Place| {
            let cells = place.cells.iter().map(|cell| text(cell, shown, notes));
            std::iter::once(place.name.clone()).chain(cells).collect()
        };
        Table { caption: caption(shown), header, rows: self.places.iter().map(row).collect() }
    }

    /// Everything that was measured, a row a cell.
    pub(super) fn details(&self, runner: &Runner) -> Table {
        let fixed = [self.quantity, "case", "median (ms)", "min", "max", "frames", "frames/s"];
        let last = ["plan (ms)", "prepare (ms)", "first frame (ms)", "why not"];
        let header = fixed.iter().chain(&STAGES).chain(&last).map(|name| name.to_string()).collect();
        let row = |(place, cell): (&Place, &Cell)| {
            let mut row = vec![place.name.clone(), runner.name_of(cell)];
            let optional = |value: Option<f64>| value.map_or("-".into(), digits);
            let spread = cell.spread();
            row.extend([spread.map(|s| s.median), spread.map(|s| s.min), spread.map(|s| s.max)].map(optional));
            row.push(cell.times().map_or("-".into(), |times| times.wall_ms.len().to_string()));
            row.push(optional(spread.map(|s| 1e3 / s.median)));
            row.extend((0..STAGES.len()).map(|stage| optional(cell.stages().map(|ms| ms[stage]))));
            row.extend([cell.plan_ms, cell.prepare_ms, cell.first_ms].map(digits));
            row.push(cell.why().unwrap_or_default());
            row
        };
        Table { caption: "Everything that was measured".into(), header, rows: self.cells().map(row).collect() }
    }

    /// A line a case.
    pub(super) fn plot(&self, runner: &Runner, title: &str, x: Axis, y: (Shown, Scale)) -> Figure {
        let series = |(index, name): (usize, String)| Series {
            name,
            points: self.places.iter().map(|place| point(place.x, &place.cells[index], y.0)).collect(),
            line: true,
            marked: Vec::new(),
        };
        Figure::Plot(Plot {
            title: title.into(),
            caption: "Medians; bars from the smallest to the largest.".into(),
            x,
            y: Axis { label: y.0.label().into(), scale: y.1 },
            series: self.names(runner).into_iter().enumerate().map(series).collect(),
        })
    }

    /// A group of bars a place, a bar a case.
    pub(super) fn bars(&self, runner: &Runner, title: &str, (shown, scale): (Shown, Scale)) -> Figure {
        let of = |index: usize| self.places.iter().map(|place| shown.of(&place.cells[index]).map(|v| v[0])).collect();
        let names = self.names(runner).into_iter().enumerate();
        Figure::Bars(Bars {
            title: title.into(),
            caption: "Medians.".into(),
            y: Axis { label: shown.label().into(), scale },
            groups: self.places.iter().map(|place| place.name.clone()).collect(),
            series: names.map(|(index, name)| (name, of(index))).collect(),
            stacked: false,
        })
    }

    /// Every cell with its place.
    pub(super) fn cells(&self) -> impl Iterator<Item = (&Place, &Cell)> {
        self.places.iter().flat_map(|place| place.cells.iter().map(move |cell| (place, cell)))
    }

    /// Rows of the machine form.
    pub(super) fn rows(&self, runner: &Runner) -> Vec<Value> {
        self.cells().map(|(place, cell)| joined(&place.facts, &cell.json(runner))).collect()
    }

    /// Why nothing at all was drawn, where that is so.
    pub(super) fn refusal(&self) -> Option<String> {
        let drawn = self.cells().any(|(_, cell)| cell.known_ms().is_some());
        let why = || self.cells().find_map(|(_, cell)| cell.why());
        (!drawn).then(|| why().unwrap_or_else(|| "there is nothing to measure".into()))
    }
}

/// A logarithmic axis.
pub(super) fn log_axis(label: &str) -> Axis {
    Axis { label: label.into(), scale: Scale::Log }
}

/// The fields of both objects.
pub(super) fn joined(first: &Value, second: &Value) -> Value {
    let mut fields = Map::new();
    for map in [first, second].into_iter().filter_map(Value::as_object) {
        fields.extend(map.clone());
    }
    Value::Object(fields)
}

fn caption(shown: Shown) -> String {
    format!("{}, medians", shown.label())
}

fn text(cell: &Cell, shown: Shown, notes: &mut Vec<String>) -> String {
    match shown.of(cell) {
        Some([median, ..]) => digits(median),
        None => cell.missing(notes),
    }
}

/// NaN, which figures leave out and say so, where nothing was measured.
fn point(x: f64, cell: &Cell, shown: Shown) -> Point {
    let [y, low, high] = shown.of(cell).unwrap_or([f64::NAN; 3]);
    Point { x, y, low, high }
}

#[cfg(test)]
mod tests {
    use super::super::cell::Verdict;
    use super::*;
    use crate::measure::times::FrameTimes;

    fn cell(verdict: Verdict) -> Cell {
        Cell { verdict, ..Cell::new(0, "forward") }
    }

    fn measured(walls: &[f64]) -> Cell {
        cell(Verdict::Measured(FrameTimes::new(Vec::new(), walls.to_vec(), Vec::new())))
    }

    fn sweep(cells: Vec<Cell>) -> Sweep {
        let place = |(index, cell): (usize, Cell)| Place {
            name: format!("{index}"),
            x: index as f64,
            facts: json!({ "lights": index }),
            cells: vec![cell],
        };
        Sweep { quantity: "lights", places: cells.into_iter().enumerate().map(place).collect() }
    }

    #[test]
    fn frames_a_second_turn_the_spread_round() {
        let timed = measured(&[10.0, 20.0, 40.0]);
        assert_eq!(Shown::Milliseconds.of(&timed), Some([20.0, 10.0, 40.0]));
        assert_eq!(Shown::FramesPerSecond.of(&timed), Some([50.0, 25.0, 100.0]));
        assert_eq!(text(&timed, Shown::FramesPerSecond, &mut Vec::new()), "50.0");
        assert!(point(1.0, &cell(Verdict::Predicted(2e4)), Shown::Milliseconds).y.is_nan());
    }

    #[test]
    fn only_an_experiment_without_any_frame_is_refused() {
        let refused = |why: &str| cell(Verdict::Refused(why.into()));
        assert_eq!(sweep(vec![refused("a"), refused("b")]).refusal(), Some("a".into()));
        assert_eq!(sweep(vec![refused("a"), measured(&[1.0])]).refusal(), None);
        assert_eq!(sweep(vec![refused("a"), cell(Verdict::TooSlow(2e4))]).refusal(), None);
        assert!(sweep(Vec::new()).refusal().is_some());
    }

    #[test]
    fn fields_are_joined_in_order() {
        let both = joined(&json!({ "a": 1 }), &json!({ "b": [2] }));
        assert_eq!(both.to_string(), "{\"a\":1,\"b\":[2]}");
    }
}
