//! Shared structs, member by member, as the device reads them.

use super::Row;
use crate::error::Result;
use crate::passes::layout_probe;
use crate::plan::{Plan, Request};
use crate::renderer::Renderer;
use crate::scene::builtin;

/// Members that the device reads elsewhere than Rust writes them.
pub fn layout(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = builtin::load("furnace")?;
    let plan = Plan::new(&scene, &Request { width: 8, height: 8, ..crate::checks::forward() }, &renderer.limits())?;
    let mut prepared = renderer.prepare_frame(&scene, &plan, layout_probe::frame(&plan))?;
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    let members = picture.layer("members").unwrap_or(&[]);
    let right = members.iter().enumerate().filter(|(i, x)| x.to_bits() == (*i as f32).to_bits()).count();
    Ok(vec![
        Row::none("shared structs lie alike on both sides", layout_probe::WORDS - right, "words elsewhere"),
        Row::none("barriers of two dispatches proved", violations.len(), "violations"),
    ])
}
