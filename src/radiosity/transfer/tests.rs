use super::*;
use crate::math::random::Random;
use crate::radiosity::patches::PatchSource;
use crate::radiosity::places::points_on;
use crate::scene::view::View;
use crate::scene::{Scene, builtin};

fn with_grid(scene: &Scene, count: usize) -> (Patches, Transfer) {
    let occluders = Reference::new(scene, &View::of_world()).expect("a reference");
    let patches = Patches::of_count(scene, &occluders, count, PatchSource::Triangles).expect("patches");
    let transfer = Transfer::new(&patches, &occluders);
    (patches, transfer)
}

/// R16: weights sum to 1 on every surface, so that a constant field stays constant.
#[test]
fn weights_sum_to_one_everywhere() {
    for name in ["cornell", "corridor", "furnace"] {
        let scene = builtin::load(name).expect("a built-in scene");
        let (patches, transfer) = with_grid(&scene, 300);
        let mut random = Random::new(3);
        for patch in &patches.list {
            for [at, _] in points_on(patch, 8, &mut random) {
                let weights = transfer.weights(&patches.list, at, patch.normal);
                let sum: f64 = weights.iter().map(|w| w.1).sum();
                assert!((sum - 1.0).abs() < 1e-9, "{name}: {sum} of {} patches", weights.len());
            }
        }
    }
}

/// R14, R16: nothing comes through the corridor's walls.
#[test]
fn no_weight_crosses_a_wall() {
    let scene = builtin::load("corridor:door=0").expect("a built-in scene");
    let occluders = Reference::new(&scene, &View::of_world()).expect("a reference");
    let (patches, transfer) = with_grid(&scene, 400);
    let mut random = Random::new(5);
    let (mut crossing, mut all) = (0.0, 0.0);
    for patch in &patches.list {
        for [at, _] in points_on(patch, 8, &mut random) {
            for (index, weight) in transfer.weights(&patches.list, at, patch.normal) {
                let other = &patches.list[index as usize];
                let lift = LIFT * patches.size;
                let nearest = places_of(other, index)
                    .map(|p| p.at)
                    .min_by(|a, b| a.distance_squared(at).total_cmp(&b.distance_squared(at)));
                let to = nearest.unwrap_or(other.center) + other.normal * lift;
                all += weight;
                if std::ptr::eq(other, patch) {
                    continue;
                }
                if occluders.is_blocked(at + patch.normal * lift, to) {
                    crossing += weight;
                }
            }
        }
    }
    assert!(crossing < 1e-3 * all, "{crossing} of {all}");
}

/// R16 for patches that lie off the surfaces they stand for: every place of a surface still has some, and their weights sum to 1.
#[test]
fn sides_of_cubes_reach_every_surface() {
    for name in ["cornell", "corridor"] {
        let scene = builtin::load(name).expect("a built-in scene");
        let occluders = Reference::new(&scene, &View::of_world()).expect("a reference");
        let cubes = Patches::of_count(&scene, &occluders, 400, PatchSource::Voxels).expect("patches");
        let transfer = Transfer::new(&cubes, &occluders);
        let mut random = Random::new(3);
        for patch in &with_grid(&scene, 300).0.list {
            for [at, _] in points_on(patch, 8, &mut random) {
                let weights = transfer.weights(&cubes.list, at, patch.normal);
                let sum: f64 = weights.iter().map(|w| w.1).sum();
                assert!((sum - 1.0).abs() < 1e-9, "{name}: {sum} of {} patches", weights.len());
            }
        }
    }
}
