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
    let patches = exchange::patches(&scene, &occluders, settings.patches).expect("patches");
    let rows = exchange::runs(patches.list.len())
        .into_iter()
        .map(|rows| RawRows::new(&patches, &occluders, settings.seed, rows, &|| {}))
        .collect();
    let exchange = Exchange::new(&scene, &occluders, settings.seed, patches, rows).expect("an exchange");
    assert!(Bake::new(exchange, settings).expect("a bake") == baked("cornell", settings));
}

/// Every codec of summed bounces comes as close as its kind does, and the ones that were fitted better are better.
#[test]
fn codecs_of_summed_bounces_are_as_good_as_they_say() {
    let exchange = Exchange::of_scene(&builtin::load("cornell").expect("a scene"), PatchRule::Count(250), 1);
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
