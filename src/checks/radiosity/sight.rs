//! What a device sees between points of surfaces against what the CPU sees.

use glam::{DMat4, DVec3};

use super::Row;
use crate::checks::shadows::mask_and_pane;
use crate::error::Result;
use crate::math::random::Random;
use crate::radiosity::sight::{Segment, Sight};
use crate::reference::render::Reference;
use crate::renderer::Renderer;
use crate::scene::view::View;
use crate::scene::{Scene, builtin};

const SEGMENTS: u32 = 20_000;
/// Between a segment and the planes of its ends, where bakes look along it.
const LEAST_COSINE: f64 = 1e-4;
/// Share of segments that 32 bits may leave to the CPU.
const UNSURE: f64 = 0.05;
const MASKED: f64 = 0.2;

/// Between random points of the scene's surface, from surface to surface as bakes look.
fn segments(reference: &Reference, count: u32) -> Vec<Segment> {
    let mut random = Random::new(7);
    let hierarchy = reference.hierarchy();
    let ids: Vec<u32> = hierarchy.threaded().iter().flat_map(|node| node.triangles.iter().copied()).collect();
    let mut sums = Vec::with_capacity(ids.len());
    let mut area = 0.0;
    for id in &ids {
        let [a, b, c] = *hierarchy.corners(*id);
        area += (b - a).cross(c - a).length();
        sums.push(area);
    }
    let mut place = || {
        let chosen = random.unit_f64() * area;
        let id = ids[sums.partition_point(|sum| *sum < chosen).min(ids.len() - 1)];
        let [a, b, c] = *hierarchy.corners(id);
        let (root, across) = (random.unit_f64().sqrt(), random.unit_f64());
        (a * (1.0 - root) + b * (root * (1.0 - across)) + c * (root * across), id)
    };
    let segment = |_| {
        let ((from, own), (to, other)) = (place(), place());
        Segment { from, to, triangles: [own, other] }
    };
    (0..count).map(segment).filter(|s| s.from != s.to).collect()
}

/// It leaves the planes of both its ends.
fn leaves(reference: &Reference, segment: &Segment) -> bool {
    segment.triangles.iter().all(|id| {
        let [a, b, c] = *reference.hierarchy().corners(*id);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        (segment.to - segment.from).normalize_or_zero().dot(normal).abs() > LEAST_COSINE
    })
}

/// Both say the same of every segment: in rooms, among ornaments, behind masks and glass, and far from the origin.
pub fn radiosity_sight(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut far = builtin::load("corridor")?;
    let away = DMat4::from_translation(DVec3::new(1e4, -1e4, 1e4));
    far.instances.iter_mut().for_each(|instance| instance.object_to_world = away * instance.object_to_world);
    let mut masked = mask_and_pane();
    // The mask stands between the pane and the wall.
    if let Some(pane) = masked.instances.last_mut() {
        pane.object_to_world = DMat4::from_translation(DVec3::new(-0.6, 0.1, 2.0));
    }
    let scenes: [(&str, Scene); 5] = [
        ("cornell", builtin::load("cornell")?),
        ("corridor", builtin::load("corridor")?),
        ("corridor, 10 km away (R13)", far),
        ("atrium", builtin::load("atrium")?),
        ("a mask before a pane", masked),
    ];
    let mut rows = Vec::new();
    for (name, scene) in &scenes {
        let reference = Reference::new(scene, &View::of_world())?;
        let device = renderer.sight(&reference, 0.0)?;
        let all = segments(&reference, SEGMENTS);
        let runs: Vec<&[Segment]> = all.chunks(999).collect();
        let (seen, right) = (device.open(&runs)?.concat(), reference.open(&runs)?.concat());
        let wrong = seen.iter().zip(&right).filter(|(a, b)| a != b).count() + usize::from(seen.len() != all.len());
        let open = right.iter().filter(|open| **open).count();
        // What lies in a plane exchanges nothing, and is not looked at in a bake.
        let leaving: Vec<Segment> = all.iter().copied().filter(|s| leaves(&reference, s)).collect();
        device.forget_looked();
        device.open(&[&leaving])?;
        let [_, unsure] = device.looked();
        let share = unsure as f64 / leaving.len().max(1) as f64;
        let faults = device.check().len();
        rows.push(Row::none(format!("sight of a device = of the CPU, {name}"), wrong, "segments differ"));
        rows.push(Row::none(
            format!("sight, {name}: both answers"),
            usize::from(open < 100 || open + 100 > all.len()),
            "faults",
        ));
        // Where a mask may be in the way the CPU looks.
        let bound = if name.contains("mask") { MASKED } else { UNSURE };
        rows.push(Row::at_most(format!("sight, {name}: share left to the CPU"), share, bound));
        rows.push(Row::none(format!("sight, {name}: every access ordered"), faults, "not ordered"));
    }
    Ok(rows)
}
