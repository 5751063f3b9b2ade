//! One binary, by kind: no GPU, pictures, hard cases, command line, controls.

#![allow(missing_docs)]

mod support;

mod accuracy;
mod bad_input;
mod bakes;
mod barriers;
mod command_line;
mod controls;
mod documents;
mod effects;
mod fuzz;
mod graph_properties;
mod hard_cases;
mod hard_values;
mod layering;
mod list_bytes;
mod pictures;
