//! L5: normals decoded on the device, every code of 8 and 10 bits and rows of those of 16, folds and corners among them.

use glam::DVec3;

use super::Row;
use crate::error::Result;
use crate::passes::octahedral_probe::{self, Codes};
use crate::plan::{Plan, Request};
use crate::reference::octahedral;
use crate::renderer::Renderer;
use crate::scene::builtin;

/// Distance between a normal that the device decodes and the one in f64: an ulp or two of each coordinate.
const BOUND: f64 = 4e-7;

/// Every code, and of 16 bits the first and the last row, and rows on either side of the middle one, 32,767, where y changes its sign.
const CODES: [Codes; 4] = [
    Codes { bits: 8, first_row: 0, row_step: 1 },
    Codes { bits: 10, first_row: 0, row_step: 1 },
    Codes { bits: 16, first_row: 0, row_step: 65_535 },
    Codes { bits: 16, first_row: 642, row_step: 1285 },
];

/// Decoded normals are finite, of unit length and those of f64.
pub fn octahedral(renderer: &Renderer) -> Result<Vec<Row>> {
    let scene = builtin::load("furnace")?;
    let plan = Plan::new(&scene, &Request { width: 8, height: 8, ..crate::checks::forward() }, &renderer.limits())?;
    let mut rows = Vec::new();
    for codes in CODES {
        let mut prepared = renderer.prepare_frame(&scene, &plan, octahedral_probe::frame(&plan, &codes))?;
        prepared.draw(1)?;
        let (picture, violations) = prepared.finish()?;
        let normals = picture.layer("normals").unwrap_or(&[]);
        let wanted = codes.rows() << codes.bits;
        let (mut farthest, mut length) = (0.0f64, 0.0f64);
        let mut found = 0;
        for (index, n) in (0u32..).zip(normals.chunks_exact(3)) {
            let n = DVec3::new(f64::from(n[0]), f64::from(n[1]), f64::from(n[2]));
            // What is not a number is as far as can be.
            let far = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
            farthest = farthest.max(far(n.distance(octahedral::decode(codes.code(index), codes.bits))));
            length = length.max(far((n.length() - 1.0).abs()));
            found += 1;
        }
        let bits = format!("{} bits, every {} rows,", codes.bits, codes.row_step);
        rows.push(Row::at_most(format!("L5 {found} normals of {bits} against f64"), farthest, BOUND));
        rows.push(Row::at_most(format!("L5 lengths of {found} normals of {bits} against 1"), length, BOUND));
        rows.push(Row::none(
            format!("L5 {wanted} normals of {bits} are decoded"),
            wanted.abs_diff(found) as usize + violations.len(),
            "missing, or violations",
        ));
    }
    Ok(rows)
}
