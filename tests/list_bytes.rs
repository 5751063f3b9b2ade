//! C10: lists from given bounds and from given depths are the same bytes on every driver and at every subgroup size. tests/lists.txt has
//! their digests;
//! `LAMPYRIS_BLESS=1` rewrites it.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use lampyris::checks;
use serde_json::Value;

use crate::support::gpu;

/// Beginning of the names of both checks.
const CHECK: &str = "given_";

fn golden() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/lists.txt")
}

/// A row's name and digest.
fn line(name: &str, detail: &str) -> String {
    let digest = detail.split("digest ").nth(1).unwrap_or_else(|| panic!("{name} has no digest: {detail}"));
    format!("{name}: {digest}\n")
}

#[test]
fn c10_lists_of_given_bounds_are_those_of_every_driver() {
    let Some(gpu) = gpu() else { return };
    let given = checks::ALL.iter().filter(|check| check.0.starts_with(CHECK));
    let rows: Vec<_> = given.flat_map(|check| check.1(&gpu).expect("the check runs")).collect();
    let failed: Vec<_> = rows.iter().filter(|row| !row.passed).collect();
    assert!(!rows.is_empty() && failed.is_empty(), "{failed:#?}");
    let found: String = rows.iter().map(|row| line(&row.name, &row.detail)).collect();
    if std::env::var_os("LAMPYRIS_BLESS").is_some() {
        fs::write(golden(), &found).expect("tests is writable");
    }
    let stored = fs::read_to_string(golden()).unwrap_or_default();
    assert_eq!(stored, found, "{} differs", golden().display());
}

/// What `check` says of the lists where lavapipe's vectors have so many bits.
fn checked(bits: u32) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_lampyris"))
        .args(["check", "--only", CHECK, "--json", "-"])
        .env("LP_NATIVE_VECTOR_WIDTH", bits.to_string())
        // What Mesa has kept may have been compiled for another width.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{bits} bits: {e}: {said}"))
}

#[test]
fn c10_lists_are_the_same_bytes_at_every_subgroup_size() {
    // Held, so that nothing else is drawn meanwhile.
    let Some(gpu) = gpu() else { return };
    let name = &gpu.device().facts.name;
    if !name.contains("llvmpipe") {
        println!("SKIPPED: {name} has one subgroup size");
        return;
    }
    let stored = fs::read_to_string(golden()).expect("tests/lists.txt");
    for bits in [128, 256, 512] {
        let value = checked(bits);
        assert!(value["device"]["name"].as_str().is_some_and(|name| name.contains("llvmpipe")), "{value}");
        assert_eq!(value["device"]["subgroup_size"], bits / 32, "{bits} bits");
        assert_eq!(value["failed"], 0, "{bits} bits: {value}");
        let text = |row: &Value, key: &str| row[key].as_str().unwrap_or_default().to_string();
        let rows = value["rows"].as_array().expect("rows");
        let found: String = rows.iter().map(|row| line(&text(row, "name"), &text(row, "detail"))).collect();
        assert_eq!(stored, found, "{bits} bits");
    }
}
