//! Scenes made by code: the same on every machine, no files needed. `builtin:NAME[:key=value,...]`.

mod atrium;
mod build;
mod cornell;
mod corridor;
mod furnace;
mod glass;
mod terrain;

use super::Scene;
use crate::error::{Error, Result};

/// Name, and what it shows with its parameters, their defaults and ranges.
pub const NAMES: &[(&str, &str)] = &[
    ("cornell", "box of 5.5 m with a red and a green wall, two blocks and a lit ceiling panel"),
    ("atrium", "two-storey court with arcades and curtains, 256 coloured point lights; detail=1 (1, 2, 3 or 4)"),
    ("corridor", "a lit and a dark room, thin walls; door=0.9 (opening in m, 0 to 1.2; under 0.001 no door)"),
    ("terrain", "200 m of hills with houses and trees under a sun; albedo=0.5 (0 to 1), detail=1 (1, 2 or 3)"),
    ("glass", "hall with panes of coloured glass behind each other; layers=8 (0 to 64)"),
    ("furnace", "closed emitting room whose radiance is 1 everywhere; albedo=0.5 (0 to 1; at 1 nothing emits)"),
];

/// A number that the user may give.
struct Parameter {
    key: &'static str,
    default: f64,
    low: f64,
    high: f64,
    whole: bool,
}

/// A scene and how it is made; `build` gets one value a parameter, in their order.
struct Entry {
    name: &'static str,
    parameters: &'static [Parameter],
    build: fn(&[f64]) -> Scene,
}

const ENTRIES: &[Entry] = &[
    Entry { name: "cornell", parameters: &[], build: |_| cornell::build() },
    Entry { name: "atrium", parameters: &[whole("detail", 4.0)], build: |values| atrium::build(values[0] as usize) },
    Entry { name: "corridor", parameters: &[real("door", 0.9, 1.2)], build: |values| corridor::build(values[0]) },
    Entry {
        name: "terrain",
        parameters: &[real("albedo", 0.5, 1.0), whole("detail", 3.0)],
        build: |values| terrain::build(values[0], values[1] as usize),
    },
    Entry {
        name: "glass",
        parameters: &[Parameter { key: "layers", default: 8.0, low: 0.0, high: 64.0, whole: true }],
        build: |values| glass::build(values[0] as usize),
    },
    Entry { name: "furnace", parameters: &[real("albedo", 0.5, 1.0)], build: |values| furnace::build(values[0]) },
];

/// From 0 to `high`.
const fn real(key: &'static str, default: f64, high: f64) -> Parameter {
    Parameter { key, default, low: 0.0, high, whole: false }
}

/// A whole number from 1, the default, to `high`.
const fn whole(key: &'static str, high: f64) -> Parameter {
    Parameter { key, default: 1.0, low: 1.0, high, whole: true }
}

/// Makes the scene that `spec`, `NAME[:key=value,...]`, describes; its name is `builtin:` and `spec`.
///
/// # Errors
/// Usage: a name or key that is not known, a key given twice, a value out of range. The message names what is known.
pub fn load(spec: &str) -> Result<Scene> {
    let (name, settings) = match spec.split_once(':') {
        Some((name, settings)) => (name, Some(settings)),
        None => (spec, None),
    };
    let entry = ENTRIES.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let known: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
        Error::usage(format!("there is no built-in scene \"{name}\"; there are {}", known.join(", ")))
    })?;
    let values = values(entry, settings).map_err(|error| error.within(format!("builtin:{name}")))?;
    let mut scene = (entry.build)(&values);
    scene.name = format!("builtin:{spec}");
    scene.validate()?;
    Ok(scene)
}

/// The defaults, replaced where `settings` says so.
fn values(entry: &Entry, settings: Option<&str>) -> Result<Vec<f64>> {
    let mut values: Vec<f64> = entry.parameters.iter().map(|parameter| parameter.default).collect();
    let mut given = vec![false; values.len()];
    for setting in settings.into_iter().flat_map(|settings| settings.split(',')) {
        let (key, text) = setting
            .split_once('=')
            .ok_or_else(|| Error::usage(format!("\"{setting}\" is not of the form key=value")))?;
        let Some(index) = entry.parameters.iter().position(|parameter| parameter.key == key) else {
            return Err(Error::usage(format!("there is no parameter \"{key}\"; {}", known_parameters(entry))));
        };
        if std::mem::replace(&mut given[index], true) {
            return Err(Error::usage(format!("\"{key}\" is given twice")));
        }
        values[index] = value(&entry.parameters[index], text)?;
    }
    Ok(values)
}

fn value(parameter: &Parameter, text: &str) -> Result<f64> {
    let Parameter { key, low, high, whole, .. } = parameter;
    match text.parse::<f64>() {
        Ok(value) if (*low..=*high).contains(&value) && (!whole || value.fract() == 0.0) => Ok(value),
        _ => {
            let kind = if *whole { "a whole number" } else { "a number" };
            Err(Error::usage(format!("\"{key}={text}\": {key} is {kind} from {low} to {high}")))
        }
    }
}

fn known_parameters(entry: &Entry) -> String {
    let keys: Vec<&str> = entry.parameters.iter().map(|parameter| parameter.key).collect();
    if keys.is_empty() { "the scene takes none".into() } else { format!("known: {}", keys.join(", ")) }
}

#[cfg(test)]
mod tests;
