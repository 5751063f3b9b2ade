//! `devices`: drivers found, and what happens where a feature is missing.

use std::process::ExitCode;

use serde_json::json;

use super::report;
use crate::cli::Devices;
use crate::error::Result;
use crate::gpu::{Instance, Options, features};

/// Runs the command.
///
/// # Errors
/// No loader or no driver.
pub fn run(args: &Devices) -> Result<ExitCode> {
    let instance = Instance::create(&Options::default())?;
    let all = features::enumerate(&instance)?;
    let (mut out, mut listed) = (String::new(), Vec::new());
    for facts in &all {
        let (major, minor, patch) = facts.api;
        out += &format!("{}, Vulkan {major}.{minor}.{patch}, {}\n", facts.line(), facts.kind);
        if facts.missing.is_empty() {
            out += "  baseline: met\n";
        } else {
            out += &format!("  baseline: NOT met, it lacks {}\n", facts.missing.join(", "));
        }
        let limits = &facts.limits;
        out += &format!(
            "  limits: images of {}, storage bindings of {}, {} texels, subgroups of {}\n",
            limits.max_image_dimension2_d,
            report::bytes(u64::from(limits.max_storage_buffer_range)),
            limits.max_texel_buffer_elements,
            facts.subgroup_size
        );
        for optional in &facts.optional {
            let state = if optional.there { "there".to_string() } else { format!("missing: {}", optional.without) };
            out += &format!("  {:<26} {state}\n", optional.name);
        }
        let mut value = report::device_json(facts);
        value["missing"] = json!(facts.missing);
        value["features"] =
            facts.optional.iter().map(|o| json!({ "name": o.name, "there": o.there, "without": o.without })).collect();
        listed.push(value);
    }
    if !report::json_on_stdout(args.json.as_deref()) {
        report::print(&out)?;
    }
    if let Some(path) = &args.json {
        report::write_json(
            path,
            &json!({ "schema": report::SCHEMA, "version": env!("CARGO_PKG_VERSION"), "devices": listed }),
        )?;
    }
    Ok(ExitCode::SUCCESS)
}
