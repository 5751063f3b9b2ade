use super::super::exchange;
use super::super::factors::RawRows;
use super::*;
use crate::reference::render::Reference;
use crate::scene::builtin;
use crate::scene::view::View;

pub(crate) fn baked(name: &str, settings: Settings) -> Bake {
    Bake::of_scene(&builtin::load(name).expect("a built-in scene"), settings).expect("a bake")
}

/// The same matrix whichever runs its rows are computed in.
#[test]
fn runs_of_rows_come_to_the_same_bake() {
    let settings = Settings { patches: PatchRule::Count(60), ..Settings::default() };
    let scene = builtin::load("cornell").expect("a built-in scene");
    let occluders = Reference::new(&scene, &View::of_world()).expect("a reference");
    let patches = exchange::patches(&scene, &occluders, &settings).expect("patches");
    let rows = exchange::runs(patches.list.len())
        .into_iter()
        .map(|rows| RawRows::new(&patches, &occluders, settings.seed, rows, &|| {}))
        .collect::<Result<Vec<_>>>()
        .expect("rows");
    let exchange = Exchange::new(&scene, &occluders, settings.seed, patches, rows).expect("an exchange");
    assert!(Bake::new(exchange, settings).expect("a bake") == baked("cornell", settings));
}

/// Every codec of summed bounces comes as close as its kind does, and the ones that were fitted better are better.
#[test]
fn codecs_of_summed_bounces_are_as_good_as_they_say() {
    let exchange = Exchange::of_scene(&builtin::load("cornell").expect("a scene"), &Settings::of_count(250));
    let exchange = exchange.expect("an exchange");
    let errors: Vec<f64> = CodecName::ALL
        .into_iter()
        .filter(|codec| codec.is_summed())
        .map(|codec| {
            let settings = Settings { patches: PatchRule::Count(250), ..Settings::of_codec(codec) };
            let bake = Bake::new(exchange.clone(), settings).expect("a bake");
            println!("{}: {:?}, {:.3} B/el", codec.name(), bake.codec_error, bake.bytes_an_element());
            bake.codec_error[0]
        })
        .collect();
    let [half, thesis, filled, bc1, bc4] = errors[..] else { panic!("{errors:?}") };
    assert!(half < 5e-4 && bc1 < 0.04 && bc4 < 0.04, "{errors:?}");
    assert!(filled < thesis && thesis < 0.3 && bc1 < filled, "{errors:?}");
}

#[test]
fn runs_hold_every_row_once() {
    for count in [0, 1, 2, 63, 1000] {
        let rows: Vec<usize> = exchange::runs(count).into_iter().flatten().collect();
        assert_eq!(rows, (0..count).collect::<Vec<_>>());
    }
}

/// R4, R5: rows of the stored matrix sum to 1 within the codec's error in a closed room, and reflection never adds energy.
#[test]
fn the_stored_matrix_keeps_a_white_furnace() {
    let settings = Settings { patches: PatchRule::Count(300), ..Settings::default() };
    let found = baked("furnace:albedo=0.9", settings);
    assert!(found.spectrum.largest < 1.0 && found.spectrum.smallest <= 0.0, "{:?}", found.spectrum);
    assert!((found.spectrum.largest - 0.9).abs() < 0.01, "{:?}", found.spectrum);
    println!("codec error {:?}, {} B/el", found.codec_error, found.bytes_an_element());
    assert!(found.codec_error[0] < 0.01, "{:?}", found.codec_error);
    assert!(found.bytes_an_element() < 0.8, "{}", found.bytes_an_element());
    let sent: Vec<[f32; 3]> = found.patches.list.iter().map(|patch| [patch.area as f32; 3]).collect();
    for (i, sum) in found.operator.product(&sent, 32).iter().enumerate() {
        assert!((sum[0] - 1.0).abs() < 0.015, "row {i}: {}", sum[0]);
    }
}

/// R13: a scene a thousand times smaller or larger, or far from the origin, has the same shares of light; R15: one that is turned has the same within
/// the patches' own error.
#[test]
fn r13_r15_size_place_and_turn_do_not_matter() {
    let scene = builtin::load("cornell").expect("a built-in scene");
    let settings = Settings { patches: PatchRule::Count(150), ..Settings::default() };
    let sums = |matrix: glam::DMat4| -> (usize, f64, f64) {
        let mut moved = scene.clone();
        moved.instances.iter_mut().for_each(|instance| instance.object_to_world = matrix * instance.object_to_world);
        let found = Exchange::of_scene(&moved, &settings).expect("an exchange");
        let patches = &found.patches.list;
        let sent: Vec<[f32; 3]> =
            patches.iter().map(|patch| (patch.reflectance * patch.area).as_vec3().to_array()).collect();
        let gathered = found.exact.product(&sent, 8);
        let area: f64 = patches.iter().map(|patch| patch.area).sum();
        let mean = gathered.iter().zip(patches).map(|(e, patch)| f64::from(e[1]) * patch.area).sum::<f64>() / area;
        (patches.len(), mean, found.spectrum.largest)
    };
    let (count, mean, largest) = sums(glam::DMat4::IDENTITY);
    for scale in [1e-3, 1e3] {
        let (other, found, bound) = sums(glam::DMat4::from_scale(DVec3::splat(scale)));
        assert!(other.abs_diff(count) <= count / 20, "{scale}: {other} patches instead of {count}");
        assert!((found / mean - 1.0).abs() < 0.01 && (bound - largest).abs() < 0.01, "{scale}: {found} {mean}");
    }
    let (_, found, bound) = sums(glam::DMat4::from_translation(DVec3::new(1e4, -1e4, 1e4)));
    assert!((found / mean - 1.0).abs() < 0.01 && (bound - largest).abs() < 0.01, "moved: {found} {mean}");
    for (axis, degrees) in [(DVec3::Y, 15.0), (DVec3::Y, 45.0), (DVec3::ONE.normalize(), 60.0)] {
        let (_, found, bound) = sums(glam::DMat4::from_axis_angle(axis, f64::to_radians(degrees)));
        assert!((found / mean - 1.0).abs() < 0.02 && (bound - largest).abs() < 0.02, "{degrees}: {found} {mean}");
    }
}

/// R12: one patch, two, a few: every codec encodes them, and nothing is not a number.
#[test]
fn r12_few_patches_are_no_special_case() {
    for count in [1, 3, 6] {
        let exchange = Exchange::of_scene(&builtin::load("furnace").expect("a scene"), &Settings::of_count(count));
        let exchange = exchange.expect("an exchange");
        for codec in CodecName::ALL {
            let bake = Bake::new(exchange.clone(), Settings::of_codec(codec)).expect("a bake");
            let n = bake.patches.list.len();
            let light = bake.operator.product(&vec![[1.0; 3]; n], 4);
            assert_eq!(light.len(), n, "{}", codec.name());
            assert!(light.iter().flatten().all(|e| e.is_finite() && *e >= 0.0), "{}: {light:?}", codec.name());
        }
    }
}

/// R6: as albedo comes near to 1 light stays finite and the stored matrix keeps it ending; at 1 in a closed room it never does, which is said.
#[test]
fn r6_albedo_may_come_near_to_one() {
    for albedo in [0.99, 0.999] {
        let bake = baked(&format!("furnace:albedo={albedo}"), Settings::of_count(120));
        assert!(bake.spectrum.largest < 1.0 && bake.norm_scale <= 1.0, "{albedo}: {:?}", bake.spectrum);
        let first: Vec<[f32; 3]> = bake.patches.list.iter().map(|p| (p.emission * 3.0).as_vec3().to_array()).collect();
        let found = after_bounces(&|sent| bake.operator.product(sent, 32), &bake.patches, &first);
        let whole = found.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
        assert!(whole && found.iter().all(|e| e[1] > 0.0), "{albedo}");
    }
    let mut scene = builtin::load("furnace:albedo=0.5").expect("a built-in scene");
    for material in &mut scene.materials {
        (material.base_color, material.metallic, material.emissive) = ([1.0; 4], 0.0, [1.0; 3]);
    }
    let refused = Bake::of_scene(&scene, Settings::of_count(120)).expect_err("light that never ends").to_string();
    assert!(refused.contains("never ends"), "{refused}");
}
