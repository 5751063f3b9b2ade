//! Clusters that tell directions of normals: the same picture, lists equal to the twin's, no light missed in front of a surface, and fewer
//! lights listed than without.

use glam::DVec3;

use super::{differing, judged, make, make_of, parts, radiance, request, rows_of, scene, unlike_twin};
use crate::checks::Row;
use crate::error::Result;
use crate::plan::{AssignChoice, ClusterBounds, Limits, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::scene::lighting::{LightRules, RangeRule};
use crate::scene::{LightKind, Projection};

/// Light evaluations without directions over those with them, at least. Measured on lavapipe: 1.5 on the atrium.
const GAIN: f64 = 1.2;

/// Scenes, and the range of their lights in metres.
const SCENES: [(&str, f64); 2] = [("atrium", 2.0), ("terrain", 15.0)];

fn base(tile: u32, normal_bits: u32) -> Request {
    Request { tile, normal_bits, ..request(Technique::ClusteredDeferred) }
}

/// Every tile size and number of bits, both bounds, both sources of candidates.
fn cases() -> Vec<(String, Request)> {
    let sizes = [(8, 16), (16, 8), (16, 16), (32, 10), (64, 16)]
        .map(|(tile, bits)| (format!("tile {tile}, normals of {bits} bits"), base(tile, bits)));
    let implicit = Request { cluster_bounds: Some(ClusterBounds::Implicit), ..base(16, 16) };
    let tree = Request { assign: AssignChoice::Tree, ..base(16, 16) };
    let others = [("implicit".to_string(), implicit), ("by tree".to_string(), tree)];
    sizes.into_iter().chain(others).collect()
}

/// Lenses, spot lights, lights without an end, and 16 directions, on one scene.
fn hard_cases(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut spots = scene("atrium", 200)?;
    for (index, light) in spots.lights.iter_mut().enumerate() {
        light.range = Some(3.0);
        if index % 2 == 0 {
            light.kind = LightKind::Spot { inner: 0.2, outer: 0.9 };
            light.direction = DVec3::new(0.3, -1.0, 0.2).normalize();
        }
    }
    let lens = |projection: Projection| {
        let mut scene = spots.clone();
        scene.cameras.truncate(1);
        scene.cameras.iter_mut().for_each(|camera| camera.projection = projection);
        scene
    };
    let flat = |xmag: f64| Projection::Orthographic { xmag, ymag: 4.0, znear: -1.0, zfar: 30.0 };
    let mut endless = spots.clone();
    endless.lights.iter_mut().for_each(|light| light.range = None);
    let told = Request { cluster_normals: true, ..base(32, 16) };
    let infinite = LightRules { range: RangeRule::Infinite, ..LightRules::default() };
    let cases = [
        ("spot lights", &spots, told.clone()),
        ("orthographic", &lens(flat(6.0)), told.clone()),
        ("mirrored", &lens(flat(-6.0)), told.clone()),
        ("no range", &endless, Request { rules: infinite, ..told.clone() }),
        ("merged, by tree", &spots, Request { assign: AssignChoice::Tree, ..told.clone() }),
    ];
    for (name, scene, told) in cases {
        let plain = Request { cluster_normals: false, ..told.clone() };
        let count = differing(&radiance(renderer, scene, &plain)?, &radiance(renderer, scene, &told)?);
        rows.push(Row::none(format!("by normal = without, {name}"), count, "differing pixels"));
        rows.extend(rows_of(renderer, &format!("by normal, {name}"), scene, &told)?);
    }
    let told = base(16, 16);
    let told = Request { cluster_normals: true, ..told };
    let many = Plan::new(&spots, &told, &renderer.limits())?;
    let most = many.clusters.as_ref().map_or(0, |clusters| clusters.pairs * 4 - 1);
    let limits = Limits { max_storage_bytes: most, ..renderer.limits() };
    let made = make_of(renderer, &spots, Plan::new(&spots, &told, &limits)?)?;
    let directions = parts(&made.plan)?.1.count_directions();
    let counts = judged(&made, &made.index, &made.lists);
    let wrong = unlike_twin(&made)? + (counts.missed_pairs + counts.unordered + counts.foreign) as usize;
    let mut row = Row::none("by normal, 16 directions", wrong, "pairs missed, or buffers that differ");
    row.passed &= directions == 16 && counts.exact_pairs > 0;
    row.detail += &format!(", {directions} directions");
    rows.push(row);
    Ok(rows)
}

/// Rows of each case on two scenes, and of hard ones.
pub fn cluster_normals(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = hard_cases(renderer)?;
    for (name, range) in SCENES {
        let scene = scene(name, 600)?;
        let ranged = |request: Request| {
            let rules = LightRules { range: RangeRule::Fixed(range), ..LightRules::default() };
            Request { rules, ..request }
        };
        for (case, plain) in cases().into_iter().map(|(case, plain)| (case, ranged(plain))) {
            let name = format!("{name}, {case}");
            let told = Request { cluster_normals: true, ..plain.clone() };
            let count = differing(&radiance(renderer, &scene, &plain)?, &radiance(renderer, &scene, &told)?);
            rows.push(Row::none(format!("by normal = without, {name}"), count, "differing pixels"));
            rows.extend(rows_of(renderer, &format!("by normal, {name}"), &scene, &told)?);
        }
        let plain = ranged(base(16, 16));
        let told = Request { cluster_normals: true, ..plain.clone() };
        let evaluations = |request: &Request| -> Result<f64> {
            let made = make(renderer, &scene, request)?;
            Ok(judged(&made, &made.index, &made.lists).listed_pairs as f64)
        };
        let gain = evaluations(&plain)? / evaluations(&told)?;
        rows.push(Row {
            name: format!("light evaluations, by normal against without, {name}"),
            passed: gain >= GAIN,
            detail: format!("{gain:.3} times fewer, at least {GAIN}"),
        });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Clusters;
    use crate::reference::{cluster_keys, octahedral};

    /// Clusters that tell 64 directions, and where their lists do not fit 16.
    fn planned(normal_bits: u32) -> [Clusters; 2] {
        let scene = scene("atrium", 600).expect("a built-in scene");
        let request = Request { cluster_normals: true, ..base(16, normal_bits) };
        let of = |limits: &Limits| Plan::new(&scene, &request, limits).expect("a plan").clusters.expect("clusters");
        let many = of(&Limits::UNLIMITED);
        let few = of(&Limits { max_storage_bytes: many.pairs * 4 - 1, ..Limits::UNLIMITED });
        [many, few]
    }

    /// Every code of few bits, and of many those along the borders of cells.
    fn codes(bits: u32, shift: u32) -> Vec<u32> {
        (0..1 << bits).filter(|&code| bits == 8 || (code + 2) % (1 << shift) < 4).collect()
    }

    #[test]
    fn bounds_of_directions_hold_every_normal_and_little_more() {
        for bits in [8, 10, 16] {
            for (clusters, wanted) in planned(bits).into_iter().zip([64, 16]) {
                let (grid, table) = (&clusters.grid, &clusters.directions);
                assert_eq!((clusters.count_directions(), table.len()), (wanted, 2 * wanted as usize));
                let codes = codes(bits, grid.direction_shift);
                for (&y, &x) in codes.iter().flat_map(|y| codes.iter().map(move |x| (y, x))) {
                    let n = octahedral::decode([x, y], bits);
                    let at = 2 * cluster_keys::direction(grid, [x, y]) as usize;
                    for axis in 0..3 {
                        let (low, high) = (f64::from(table[at][axis]), f64::from(table[at + 1][axis]));
                        assert!(low < n[axis] && n[axis] < high, "{bits} bits, {x} {y}: {n} in {low} to {high}");
                    }
                }
                let wide = table.chunks(2).flat_map(|t| (0..3).map(|axis| t[1][axis] - t[0][axis])).fold(0.0, f32::max);
                assert!(wanted < 64 || wide < 0.85, "{wide}");
            }
        }
    }
}
