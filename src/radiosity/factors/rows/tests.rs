use glam::DVec3;

use super::*;
use crate::radiosity::exchange::patches;
use crate::radiosity::sight::NO_TRIANGLE;
use crate::reference::render::Reference;
use crate::scene::builtin;
use crate::scene::view::View;

fn empty() -> PendingRow {
    PendingRow { pairs: Vec::new(), segments: Vec::new(), shares: Vec::new(), counted: [0; 4] }
}

/// Fewer rays than points: on average each point has the share that its own exchange is of all.
#[test]
fn rays_that_are_left_out_are_made_up_for() {
    let weights = [4.0, 1.0, 0.0, 2.0, 0.5, 2.5];
    let all: f64 = weights.iter().sum();
    let room: Vec<Weighted> = (0..weights.len())
        .filter(|k| weights[*k] > 0.0)
        .map(|k| (Segment { from: DVec3::X * k as f64, to: DVec3::ZERO, triangles: [NO_TRIANGLE; 2] }, weights[k]))
        .collect();
    let mut random = Random::new(11);
    for wanted in [1, 2, 3, 64] {
        let (mut found, rounds) = ([0.0; 6], 4000);
        for _ in 0..rounds {
            let mut row = empty();
            row.keep_some(&room, wanted, &mut random);
            assert!((row.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(row.segments.len() <= (wanted as usize).min(room.len()));
            row.segments.iter().zip(&row.shares).for_each(|(s, share)| found[s.from.x as usize] += share);
        }
        for (found, weight) in found.iter().zip(weights) {
            // Standard error of a share near 0.4 that is 0 or 1: 0.008.
            let off = found / f64::from(rounds) - weight / all;
            assert!(off.abs() < 0.03, "{wanted} rays: {off} for {weight}");
        }
    }
}

/// Every stratum of the other patch has its turn, however many there are.
#[test]
fn every_stratum_has_its_turn() {
    for count in 1..=MOST_RAYS {
        for offset in [0, count / 2, count - 1] {
            let mut met: Vec<u32> = (0..count).map(|k| other_stratum(k, offset, count)).collect();
            met.sort_unstable();
            assert_eq!(met, (0..count).collect::<Vec<_>>(), "{count} strata");
        }
    }
}

/// Pairs that carry much light have many rays, others one.
#[test]
fn rays_go_where_the_light_is() {
    let scene = builtin::load("cornell").expect("a built-in scene");
    let occluders = Reference::new(&scene, &View::of_world()).expect("a reference");
    let rays_of = |count| {
        let settings = crate::radiosity::bake::Settings::of_count(count);
        let patches = patches(&scene, &occluders, &settings).expect("patches");
        let count = patches.list.len();
        let raw = RawRows::new(&patches, &occluders, 1, 0..count, &|| {}).expect("rows");
        let pairs: u64 = raw.counted[..3].iter().sum();
        (raw.counted[3] as f64 / count as f64, raw.counted[3] as f64 / pairs as f64)
    };
    let ((few, of_few), (many, of_many)) = (rays_of(100), rays_of(400));
    println!("rays a patch {few:.0} and {many:.0}, a pair {of_few:.1} and {of_many:.1}");
    // Four times as many patches: what one has of them hangs on its light more than on how many others there are.
    assert!(many < 2.0 * few, "{few} and {many} rays a patch");
    assert!(of_many < 0.6 * of_few, "{of_few} and {of_many} rays a pair");
}

/// Some pairs of many triangles exchange what all of them do, on average.
#[test]
fn some_pairs_exchange_as_much_as_all() {
    // A quarter of a bowl above a floor, in 800 triangles.
    let bowl = |u: f64, v: f64| {
        let (across, up) = (u * std::f64::consts::FRAC_PI_2, v * std::f64::consts::FRAC_PI_2);
        DVec3::new(up.cos() * across.cos(), up.cos() * across.sin(), 0.3 + up.sin())
    };
    let grid = |place: &dyn Fn(f64, f64) -> DVec3, n: usize| -> Vec<[DVec3; 3]> {
        let at = |i: usize, j: usize| place(i as f64 / n as f64, j as f64 / n as f64);
        let cell = |(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, c, b], [a, d, c]]
        };
        (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).flat_map(cell).collect()
    };
    let patch = |triangles: Vec<[DVec3; 3]>| {
        let area = triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
        Patch {
            sources: vec![NO_TRIANGLE; triangles.len()],
            triangles,
            area,
            center: DVec3::Z,
            normal: DVec3::NEG_Z,
            radius: 1.0,
            flat: false,
            reflectance: DVec3::ONE,
            emission: DVec3::ZERO,
        }
    };
    let bowl = patch(grid(&bowl, 20));
    let floor = patch(grid(&|u, v| DVec3::new(v, u, 0.0), 2));
    let exact: f64 = {
        let facets =
            |patch: &Patch| -> Vec<_> { patch.triangles.iter().map(crate::radiosity::pair::Facet::new).collect() };
        let others = facets(&floor);
        facets(&bowl).iter().flat_map(|t| others.iter().map(|u| crate::radiosity::pair::exchange(t, u))).sum()
    };
    let (bowl, floor, mut random) = (Places::new(&bowl), Places::new(&floor), Random::new(3));
    let found: Vec<f64> = (0..200).map(|_| bowl.exchange(&floor, &mut random)).collect();
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let off = found.iter().map(|found| (found / exact - 1.0).powi(2)).sum::<f64>() / found.len() as f64;
    println!("{mean} m2 for {exact}, each off by {:.4}", off.sqrt());
    assert!(exact > 0.05 && (mean / exact - 1.0).abs() < 0.01 && off.sqrt() < 0.1, "{mean} m2 for {exact}");
}
