//! What an experiment leaves: text, rows, figures, and one page of all.

use std::path::Path;

use serde_json::{Value, json};

use super::run::Runner;
use super::sweep::{Shown, Sweep};
use crate::commands::measured::{self, numbered};
use crate::commands::{report, setup};
use crate::error::Result;
use crate::measure::file;
use crate::measure::html::{self, Section, Table};
use crate::measure::plot::Figure;

/// What an experiment gives.
pub(super) struct Outcome {
    pub(super) name: &'static str,
    /// What people see; its last paragraph says how it was measured.
    pub(super) section: Section,
    /// Tables that only the page has room for.
    pub(super) details: Vec<Table>,
    /// Why some cells have no number, by the numbers in tables.
    pub(super) notes: Vec<String>,
    /// Of the picture, the largest where there are several.
    pub(super) size: (u32, u32),
    /// Name as typed, and fingerprint.
    pub(super) scenes: Vec<Value>,
    /// Rows of the machine form.
    pub(super) rows: Vec<Value>,
    /// Why nothing at all was drawn, where that is so.
    pub(super) refusal: Option<String>,
}

/// What an experiment says of itself.
pub(super) struct About {
    pub(super) name: &'static str,
    pub(super) title: String,
    /// Its lights and their range, for people.
    pub(super) lights: String,
    pub(super) size: (u32, u32),
    pub(super) scenes: Vec<Value>,
}

impl Outcome {
    /// Of groups that were measured: the table of their medians, and figures.
    pub(super) fn of_sweep(runner: &Runner, sweep: &Sweep, about: About, figures: Vec<Figure>) -> Self {
        let mut notes = Vec::new();
        let table = sweep.table(runner, Shown::Milliseconds, &mut notes);
        Self {
            name: about.name,
            section: Section {
                title: about.title,
                paragraphs: vec![runner.how(&about.lights, runner.rounds())],
                tables: vec![table],
                figures,
                pictures: Vec::new(),
            },
            details: vec![sweep.details(runner)],
            notes,
            size: about.size,
            scenes: about.scenes,
            rows: sweep.rows(runner),
            refusal: sweep.refusal(),
        }
    }

    /// For a terminal.
    pub(super) fn text(&self) -> String {
        measured::text(&self.section, &self.notes)
    }

    /// Machine form.
    pub(super) fn json(&self, runner: &Runner) -> Value {
        let devices: Vec<Value> = runner.renderers.iter().map(|r| report::device_json(&r.device().facts)).collect();
        json!({
            "schema": report::SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "arguments": measured::typed_arguments(),
            "experiment": self.name,
            "device": devices.first(),
            "devices": devices,
            "host_cores": measured::host_cores(),
            "scenes": self.scenes,
            "light_seed": runner.args.light_seed,
            "width": self.size.0,
            "height": self.size.1,
            "shading": setup::shading(runner.args.shading).name(),
            "rows": self.rows,
        })
    }

    /// Writes the figures into a folder.
    ///
    /// # Errors
    /// See [`measured::write_figures`].
    pub(super) fn write_figures(&self, folder: &Path, origin: &[(String, String)]) -> Result<()> {
        measured::write_figures(folder, self.name, &self.section.figures, origin)
    }

    /// Its part of the page.
    fn page_section(&self) -> Section {
        let mut section = self.section.clone();
        section.paragraphs.extend(numbered(&self.notes));
        section.tables.extend(self.details.iter().cloned());
        section
    }
}

/// Writes the page of all experiments.
///
/// # Errors
/// See [`file::write`].
pub(super) fn write_page(folder: &Path, outcomes: &[Outcome], origin: &[(String, String)]) -> Result<()> {
    let mut known: Vec<(String, String)> = origin.to_vec();
    for scene in outcomes.iter().flat_map(|outcome| &outcome.scenes) {
        let text = |key: &str| scene[key].as_str().unwrap_or_default().to_string();
        let entry = ("scene".to_string(), format!("{} {}", text("name"), text("fingerprint")));
        if !known.contains(&entry) {
            known.push(entry);
        }
    }
    let sections: Vec<Section> = outcomes.iter().map(Outcome::page_section).collect();
    let page = html::page("Lampyris: many lights, measured", &known, &sections)?;
    file::write(&folder.join("index.html"), page.as_bytes())
}

/// Where figures come from, by keyword.
pub(super) fn origin(runner: &Runner) -> Vec<(String, String)> {
    let mut origin = vec![
        ("version".to_string(), env!("CARGO_PKG_VERSION").to_string()),
        ("arguments".into(), measured::typed_arguments().join(" ")),
        ("light seed".into(), runner.args.light_seed.to_string()),
        ("host cores".into(), measured::host_cores().to_string()),
    ];
    let device = |index: usize| match runner.renderers.len() {
        1 => "device".to_string(),
        _ => format!("device {}", index + 1),
    };
    let lines = runner.renderers.iter().map(|renderer| renderer.device().facts.line());
    origin.extend(lines.enumerate().map(|(index, line)| (device(index), line)));
    origin
}
