use super::*;
use crate::scene::builtin;
use crate::scene::view::View;

pub(crate) fn baked(name: &str, settings: Settings) -> Bake {
    let scene = builtin::load(name).expect("a built-in scene");
    let occluders = Reference::new(&scene, &View::of_world()).expect("a reference");
    let patches = patches(&scene, &occluders, settings.patches).expect("patches");
    let rows = runs(patches.list.len())
        .into_iter()
        .map(|rows| RawRows::new(&patches, &occluders, settings.seed, rows, &|| {}))
        .collect();
    Bake::new(&scene, &occluders, settings, patches, rows).expect("a bake")
}

#[test]
fn runs_hold_every_row_once() {
    for count in [0, 1, 2, 63, 1000] {
        let rows: Vec<usize> = runs(count).into_iter().flatten().collect();
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
