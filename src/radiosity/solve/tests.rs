use super::*;
use crate::math::random::Random;
use crate::radiosity::exchange::points_of;
use crate::radiosity::patches::PatchSource;
use crate::radiosity::places::points_on;
use crate::reference::render::{Paths, Reference};
use crate::scene::lighting::{LightRules, Lighting};
use crate::scene::shading::Shading;
use crate::scene::view::View;
use crate::scene::{Scene, builtin};

struct Solved {
    patches: Patches,
    factors: Factors,
    direct: Vec<DVec3>,
    indirect: Vec<DVec3>,
}

fn solved(scene: &Scene, count: usize, view: &View, lighting: &Lighting) -> Solved {
    let occluders = Reference::new(scene, view).expect("a reference");
    let patches = Patches::of_count(scene, &occluders, count, PatchSource::Triangles).expect("patches");
    let shader = Shader::new(lighting, view, Shading::Lambert);
    let factors = Factors::new(&patches, &occluders, 1, &|| {}).expect("factors");
    let points: Vec<[DVec3; 2]> = (0..patches.list.len()).flat_map(|index| points_of(&patches, index)).collect();
    let direct = direct_at(&patches, &points, &occluders, &shader);
    let indirect = indirect(&factors, &patches, &direct, None, 1e-7);
    Solved { patches, factors, direct, indirect }
}

fn lights(scene: &Scene) -> Lighting {
    Lighting::new(scene, &LightRules { emission_lights: true, ..LightRules::default() }).expect("rules")
}

/// R4, R5, R6.
#[test]
fn a_white_furnace_has_exitance_pi_on_every_patch() {
    for albedo in [0.5, 0.9, 0.99] {
        let scene = builtin::load(&format!("furnace:albedo={albedo}")).expect("a built-in scene");
        let found = solved(&scene, 150, &View::of_world(), &lights(&scene));
        let n = found.factors.count;
        for i in 0..n {
            let sum: f64 = found.factors.row(i).iter().map(|f| f64::from(*f)).sum();
            assert!((sum - 1.0).abs() < 1e-5, "row {i} sums to {sum}");
            for j in 0..i {
                let [a, b] =
                    [(i, j), (j, i)].map(|(i, j)| found.patches.list[i].area * f64::from(found.factors.row(i)[j]));
                assert!((a - b).abs() <= 1e-6 * a.max(b), "{i} {j}");
            }
        }
        for (patch, e) in found.patches.list.iter().zip(&found.indirect) {
            let radiance = patch.emission + patch.reflectance * *e / PI;
            assert!((radiance - 1.0).abs().max_element() < 1e-3, "albedo {albedo}: {radiance}");
        }
        let report = found.factors.report;
        assert!(report.largest_scale < 0.1, "{report:?}");
    }
}

/// Against paths from the same patches: bias of the mean, and root mean square of patches over the mean, of green light.
fn against_paths(scene: &Scene, count: usize, paths: u32) -> [f64; 2] {
    let (view, lighting) = (View::of_world(), lights(scene));
    let found = solved(scene, count, &view, &lighting);
    let reference = Reference::new(scene, &view).expect("a reference");
    let shader = Shader::new(&lighting, &view, Shading::Lambert);
    let traced: Vec<f64> = found
        .patches
        .list
        .par_iter()
        .enumerate()
        .map(|(index, patch)| {
            let mut random = Random::new(index as u64);
            let points = points_on(patch, paths, &mut random);
            reference.bounced_irradiance(&shader, &points, Paths { count: 1, seed: index as u64 }).y
        })
        .collect();
    let areas: Vec<f64> = found.patches.list.iter().map(|patch| patch.area).collect();
    let whole: f64 = areas.iter().sum();
    let mean = |values: &dyn Fn(usize) -> f64| (0..areas.len()).map(|i| values(i) * areas[i]).sum::<f64>() / whole;
    let judged = mean(&|i| traced[i]);
    let bias = mean(&|i| found.indirect[i].y - traced[i]) / judged;
    let rms = mean(&|i| (found.indirect[i].y - traced[i]).powi(2)).sqrt() / judged;
    println!(
        "{count} patches: bias {bias:.4}, rms {rms:.4}, mean {judged:.4}, direct {:.4}",
        mean(&|i| found.direct[i].y)
    );
    [bias, rms]
}

#[test]
fn patches_have_the_light_that_paths_find() {
    let scene = builtin::load("cornell").expect("a built-in scene");
    let [bias, rms] = against_paths(&scene, 400, 600);
    assert!(bias.abs() < 0.02 && rms < 0.06, "bias {bias}, rms {rms}");
}
