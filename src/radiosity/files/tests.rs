use std::sync::OnceLock;

use super::*;
use crate::radiosity::bake::tests::baked;
use crate::radiosity::bake::{CodecName, PatchRule};

fn small() -> &'static Bake {
    static BAKE: OnceLock<Bake> = OnceLock::new();
    BAKE.get_or_init(|| baked("furnace", Settings { patches: PatchRule::Count(60), ..Settings::default() }))
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lampyris-files-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    folder
}

#[test]
fn a_bake_comes_back_as_it_was() {
    for codec in CodecName::ALL {
        let settings = Settings { patches: PatchRule::Count(60), ..Settings::of_codec(codec) };
        let mut bake = baked("furnace", settings);
        let folder = folder(codec.name());
        store(&bake, &folder).expect("stored");
        let found = load(&folder, &bake.fingerprint).expect("loaded");
        for patch in &mut bake.patches.list {
            patch.triangles.clear();
            patch.sources.clear();
            patch.flat = false;
        }
        assert_eq!(found, bake);
        // A second one replaces the first.
        store(&bake, &folder).expect("stored again");
        assert_eq!(load(&folder, &bake.fingerprint).expect("loaded"), bake);
        fs::remove_dir_all(&folder).expect("removed");
    }
}

/// R19.
#[test]
fn what_is_damaged_foreign_or_of_another_scene_is_refused_by_name() {
    let bake = small();
    let folder = folder("refused");
    store(bake, &folder).expect("stored");
    let other = load(&folder, "0123456789abcdef").expect_err("another scene").to_string();
    assert!(other.contains(&bake.fingerprint) && other.contains("0123456789abcdef"), "{other}");
    for name in ["patches.npy", "blocks.npy", "transfer.npy", "residuals.npy"] {
        let path = folder.join(name);
        let whole = fs::read(&path).expect("there");
        let mut damaged = whole.clone();
        let last = damaged.len() - 1;
        damaged[last] ^= 1;
        for bytes in [&damaged[..], &whole[..last], &[]] {
            fs::write(&path, bytes).expect("written");
            let error = load(&folder, &bake.fingerprint).expect_err("refused").to_string();
            assert!(error.contains(name), "{error}");
        }
        fs::remove_file(&path).expect("removed");
        assert!(load(&folder, &bake.fingerprint).expect_err("missing").to_string().contains(name));
        fs::write(&path, &whole).expect("written");
    }
    load(&folder, &bake.fingerprint).expect("whole again");
    fs::write(folder.join(MANIFEST), "{}").expect("written");
    let error = load(&folder, &bake.fingerprint).expect_err("no manifest").to_string();
    assert!(error.contains(MANIFEST), "{error}");
    fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_folder_of_something_else_is_not_replaced() {
    let folder = folder("foreign");
    fs::create_dir_all(&folder).expect("made");
    fs::write(folder.join("thesis.txt"), "years of work").expect("written");
    assert!(store(small(), &folder).is_err());
    assert!(folder.join("thesis.txt").is_file());
    fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn rows_come_back_or_are_refused() {
    let folder = folder("rows");
    fs::create_dir_all(&folder).expect("made");
    let raw = RawRowsFixture::rows();
    store_rows(&folder, "key", &raw).expect("stored");
    assert_eq!(load_rows(&folder, "key", &(1..3), 5).expect("loaded"), Some(raw));
    assert_eq!(load_rows(&folder, "key", &(3..4), 5).expect("none"), None);
    assert!(load_rows(&folder, "other", &(1..3), 5).is_err());
    let path = rows_path(&folder, &(1..3));
    let mut bytes = fs::read(&path).expect("there");
    let old = [b"lampyris rows 1".as_slice(), &bytes["lampyris rows 1".len()..]].concat();
    fs::write(&path, old).expect("written");
    let error = load_rows(&folder, "key", &(1..3), 5).expect_err("of another version").to_string();
    assert!(error.contains("version 1"), "{error}");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&path, bytes).expect("written");
    assert!(load_rows(&folder, "key", &(1..3), 5).is_err());
    fs::remove_dir_all(&folder).expect("removed");
}

struct RawRowsFixture;

impl RawRowsFixture {
    fn rows() -> crate::radiosity::factors::RawRows {
        let exchanges = vec![vec![0.5, 0.25, 1e-9], vec![3.0, 0.0]];
        crate::radiosity::factors::RawRows { first: 1, exchanges, counted: [1, 2, 3, 4] }
    }
}
