//! What a knob leaves: a table, two figures, rows.

use super::cell::Cell;
use super::knobs::{Against, Knob};
use crate::commands::measured;
use crate::measure::html::{Section, Table};
use crate::measure::plot::{Axis, Figure, Plot, Point, Scale, Series};
use crate::measure::times::Spread;

/// Bytes of a MiB.
const MIB: f64 = 1_048_576.0;

const HEADER: [&str; 16] = [
    "setting",
    "frame (ms)",
    "min",
    "max",
    "passes (ms)",
    "min",
    "max",
    "mean error",
    "max error",
    "from forward",
    "missed pairs",
    "waste, samples",
    "waste, cells",
    "MiB",
    "time front",
    "bytes front",
];

/// A knob that was measured.
pub(super) struct Outcome {
    pub(super) knob: Knob,
    pub(super) cells: Vec<Cell>,
    pub(super) section: Section,
    /// Why some settings have no numbers, by the numbers in the table.
    pub(super) notes: Vec<String>,
}

impl Outcome {
    /// The table and the figures of its cells; `how` they were measured.
    pub(super) fn new(knob: Knob, cells: Vec<Cell>, how: &str) -> Self {
        let mut notes = Vec::new();
        let table = Table {
            caption: "Medians; errors from the reference are relative".into(),
            header: HEADER.map(String::from).to_vec(),
            rows: cells.iter().map(|cell| row(&knob, cell, &mut notes)).collect(),
        };
        let section = Section {
            title: format!("{}: {}", knob.name, knob.title),
            paragraphs: vec![paragraph(&knob, &cells), how.to_string()],
            tables: vec![table],
            figures: vec![time_figure(&knob, &cells), bytes_figure(&knob, &cells)],
            pictures: Vec::new(),
        };
        Self { knob, cells, section, notes }
    }

    /// Its part of the page.
    pub(super) fn page_section(&self) -> Section {
        let mut section = self.section.clone();
        section.paragraphs.extend(measured::numbered(&self.notes));
        section
    }

    /// Why nothing at all was drawn, where that is so.
    pub(super) fn refusal(&self) -> Option<&str> {
        let first = self.cells.first().and_then(|cell| cell.refusal.as_deref())?;
        self.cells.iter().all(|cell| cell.refusal.is_some()).then_some(first)
    }
}

fn row(knob: &Knob, cell: &Cell, notes: &mut Vec<String>) -> Vec<String> {
    if let Some(why) = &cell.refusal {
        return vec![cell.setting.clone(), measured::refused(why, notes)];
    }
    let milliseconds = |spread: Option<Spread>| {
        spread.map_or([0; 3].map(|_| "-".to_string()), |s| [s.median, s.min, s.max].map(|ms| format!("{ms:.2}")))
    };
    let relative = |error: Option<f64>| match error {
        None => "-".to_string(),
        Some(0.0) => "0".into(),
        Some(error) => format!("{error:.2e}"),
    };
    let counters = cell.counters.as_ref();
    let counted = |number: Option<f64>| number.map_or("-".to_string(), |waste| format!("{waste:.2}"));
    let star = |on_front: bool| String::from(if on_front { "*" } else { "" });
    let mut row = vec![cell.setting.clone()];
    row.extend(milliseconds(cell.frame()));
    row.extend(milliseconds(cell.passes(knob)));
    row.push(relative(cell.error.map(|error| error.mean_relative)));
    row.push(relative(cell.error.map(|error| error.max_relative)));
    row.push(relative(cell.from_forward.map(|difference| difference.max_relative)));
    row.push(counters.map_or("-".into(), |counters| counters.missed_pairs.to_string()));
    row.push(counted(counters.map(|counters| counters.waste_samples)));
    row.push(counted(counters.map(|counters| counters.waste_cells)));
    row.push(format!("{:.2}", cell.memory_bytes as f64 / MIB));
    row.extend([cell.on_time_front, cell.on_bytes_front].map(star));
    row
}

/// What the columns are, as far as it differs from knob to knob.
fn paragraph(knob: &Knob, cells: &[Cell]) -> String {
    // Settings leave passes out, none has others instead.
    let most = cells.iter().max_by_key(|cell| cell.times.names.len());
    let passes = most.into_iter().flat_map(|cell| &cell.times.names).filter(|name| knob.touches(name));
    let names: Vec<&str> = passes.map(String::as_str).collect();
    let passes = if names.is_empty() { String::new() } else { format!(" Passes: {}.", names.join(", ")) };
    let reference = match knob.against {
        Against::Unbounded => {
            "The reference's lights have no range: what a cut-off cuts off is part of the error, and ranges change the picture \
             itself, so it differs from forward with the ranges of the command line."
        }
        Against::Samples => "The reference has eight rays a pixel; errors are over every pixel, edges included.",
        Against::Shadows => {
            "The reference's rays look for what stands in the way of the four lights that matter most; maps are drawn in every \
             frame. Forward, which the others are compared with, has no shadows."
        }
        Against::Bounces => {
            "The reference has shadow rays for all lights, and paths for what bounces; means of squares of 10 x 10 pixels are compared, since paths \
             are noisy. Light is gathered and maps are drawn in every frame. Forward, which the others are compared with, has neither."
        }
        Against::Own => "The reference has the same lights, with the same ranges.",
    };
    format!("{reference}{passes} *: no other setting is at most as far off and quicker, or smaller.")
}

fn time_figure(knob: &Knob, cells: &[Cell]) -> Figure {
    let series = |cell: &Cell| {
        let spread = cell.frame()?;
        Some(series(cell, [spread.median, spread.min, spread.max], cell.on_time_front))
    };
    Figure::Plot(Plot {
        title: format!("{}: error and time", knob.name),
        caption: "Medians; bars from the smallest to the largest. Ringed: no other setting is both quicker and closer."
            .into(),
        x: error_axis(),
        y: Axis { label: "frame (ms)".into(), scale: Scale::Linear },
        series: cells.iter().filter_map(series).collect(),
    })
}

fn bytes_figure(knob: &Knob, cells: &[Cell]) -> Figure {
    let drawn = cells.iter().filter(|cell| cell.refusal.is_none());
    let series = |cell: &Cell| series(cell, [cell.memory_bytes as f64 / MIB; 3], cell.on_bytes_front);
    Figure::Plot(Plot {
        title: format!("{}: error and device memory", knob.name),
        caption: "Ringed: no other setting is both smaller and closer.".into(),
        x: error_axis(),
        y: Axis { label: "device memory (MiB)".into(), scale: Scale::Linear },
        series: drawn.map(series).collect(),
    })
}

fn error_axis() -> Axis {
    Axis { label: "mean relative error".into(), scale: Scale::Log }
}

/// A setting is a series of its own, so that the legend names it.
fn series(cell: &Cell, [y, low, high]: [f64; 3], marked: bool) -> Series {
    let x = cell.error.map_or(f64::NAN, |error| error.mean_relative);
    Series { name: cell.setting.clone(), points: vec![Point { x, y, low, high }], line: false, marked: vec![marked] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::KnobName;
    use crate::commands::accuracy::knobs;
    use crate::lists::Counters;
    use crate::measure::metrics;
    use crate::measure::times::FrameTimes;
    use crate::plan::Request;

    fn outcome() -> Outcome {
        let names = vec!["depth_prepass".to_string(), "tiled_forward".into()];
        let measured = Cell {
            setting: "8".into(),
            times: FrameTimes::new(names, vec![5.0], vec![vec![1.0, 3.0]]),
            memory_bytes: 3 << 20,
            error: Some(metrics::compare(&[[1.0; 4]], &[[1.5; 4]])),
            from_forward: Some(metrics::compare(&[[1.0; 4]], &[[1.0; 4]])),
            counters: Some(Counters { missed_pairs: 7, waste_samples: 2.0, waste_cells: 1.25, ..Counters::default() }),
            on_time_front: true,
            ..Cell::default()
        };
        let refused = Cell { setting: "64".into(), refusal: Some("too large".into()), ..Cell::default() };
        Outcome::new(knobs::knob(KnobName::Tile, &Request::default(), &[]), vec![measured, refused], "how")
    }

    #[test]
    fn a_row_has_a_cell_a_column() {
        let found = outcome();
        let rows = &found.section.tables[0].rows;
        let expected = [
            "8", "5.00", "5.00", "5.00", "3.00", "3.00", "3.00", "5.00e-1", "5.00e-1", "0", "7", "2.00", "1.25",
            "3.00", "*", "",
        ];
        assert_eq!(rows[0], expected);
        assert_eq!(rows[1], ["64", "refused [1]"]);
        assert_eq!(found.notes, ["too large"]);
        assert_eq!(found.refusal(), None);
    }

    #[test]
    fn figures_have_a_series_a_setting_that_was_drawn() {
        for figure in &outcome().section.figures {
            let Figure::Plot(plot) = figure else { panic!("a plot") };
            assert_eq!(plot.series.len(), 1);
            assert_eq!(plot.series[0].points[0].x, 0.5);
            assert!(figure.svg((600, 400)).is_ok());
        }
    }

    #[test]
    fn only_a_knob_without_any_picture_is_refused() {
        let mut found = outcome();
        found.cells.remove(0);
        assert_eq!(found.refusal(), Some("too large"));
    }
}
