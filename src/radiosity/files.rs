//! A bake as a folder that others can read: `manifest.json` and NumPy arrays (format version 1.0, little-endian). Equal bakes are equal bytes: there are
//! no times and no names of machines in them. A folder is written beside its place and renamed.

mod ktx2;
mod npy;
mod operator;
mod rows;

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::bake::{Bake, POINTS, Settings};
use super::factors::Report;
use super::patches::{Patch, Patches};
use super::spectrum::Spectrum;
use super::transfer::Transfer;
use crate::error::{Error, Result};

pub use rows::{load_rows, rows_path, store_rows};

/// Raised when a file changes its meaning, or what is baked of the same scene and settings changes.
pub const VERSION: u32 = 5;
/// The file that says what the others are.
pub const MANIFEST: &str = "manifest.json";

/// The manifest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Manifest {
    format: String,
    version: u32,
    scene: String,
    settings: Settings,
    patches: usize,
    patch_size_m: f64,
    triangles: usize,
    dropped: usize,
    buried_m2: f64,
    /// Of the surfaces that patches stand for.
    surface_m2: f64,
    surface_reflectance: [f64; 3],
    /// That patches may lie off them.
    off_surface_m: f64,
    points_a_patch: u32,
    spectrum: Spectrum,
    factors: Report,
    bytes_an_element: f64,
    /// Relative L2 of one gather: mean and largest over light set-ups.
    codec_error: [f64; 2],
    norm_scale: f64,
    transfer: GridForm,
    /// Name, number of bytes, FNV-1a of 64 bits.
    files: Vec<(String, u64, String)>,
    /// What 16-bit floats are multiplied by.
    #[serde(skip_serializing_if = "Option::is_none")]
    residual_scale: Option<f32>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct GridForm {
    origin_m: [f64; 3],
    cell_m: f64,
    size: [u32; 3],
    reach_cells: f64,
}

/// Numbers a patch of `patches.npy`: centre, normal, area, radius, reflectance, emission.
const PATCH_NUMBERS: usize = 14;

fn hash(bytes: &[u8]) -> String {
    let fnv = |h: u64, b: &u8| (h ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01b3);
    format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, fnv))
}

/// Every array with its name.
fn arrays(bake: &Bake) -> Vec<(&'static str, Vec<u8>)> {
    let count = bake.patches.list.len();
    let patch = |p: &Patch| -> Vec<f64> {
        let mut numbers = [p.center, p.normal].iter().flat_map(|v| v.to_array()).collect::<Vec<_>>();
        numbers.extend([p.area, p.radius]);
        numbers.extend([p.reflectance, p.emission].iter().flat_map(|v| v.to_array()));
        numbers
    };
    let patches: Vec<f64> = bake.patches.list.iter().flat_map(patch).collect();
    let points: Vec<f64> = bake.points.iter().flatten().flat_map(|v| v.to_array()).collect();
    let mut arrays = vec![
        ("patches.npy", npy::write(&[count, PATCH_NUMBERS], &patches)),
        ("points.npy", npy::write(&[count, POINTS as usize, 6], &points)),
        ("transfer.npy", npy::write(&[bake.transfer.words.len()], &bake.transfer.words)),
    ];
    arrays.extend(operator::arrays(&bake.operator));
    arrays
}

/// Says before the work what [`store`] would find after it.
///
/// # Errors
/// Something in the folder's place that is no bake.
pub fn check_place(folder: &Path) -> Result<()> {
    let is_empty = |p: &Path| fs::read_dir(p).is_ok_and(|mut entries| entries.next().is_none());
    if folder.exists() && !folder.join(MANIFEST).is_file() && !is_empty(folder) {
        return Err(Error::new(format!("{}: is there, and is no bake that could be replaced", folder.display())));
    }
    Ok(())
}

/// A name beside a folder's.
pub fn beside(folder: &Path, ending: &str) -> PathBuf {
    let mut name = folder.file_name().unwrap_or_default().to_os_string();
    name.push(ending);
    folder.with_file_name(name)
}

/// Writes a bake beside `folder` and puts it in its place; what was baked there before is gone then. Bytes of all files.
///
/// # Errors
/// See [`check_place`]; a full disk, no permission.
pub fn store(bake: &Bake, folder: &Path) -> Result<u64> {
    check_place(folder)?;
    let part = beside(folder, &format!(".{}.part", std::process::id()));
    let failed = |path: &Path, e: std::io::Error| Error::new(format!("{}: could not be written: {e}", path.display()));
    let written = write_all(bake, &part, &failed);
    if written.is_err() {
        let _ = fs::remove_dir_all(&part);
        return written;
    }
    let old = beside(folder, &format!(".{}.old", std::process::id()));
    let had = folder.exists();
    if had {
        fs::rename(folder, &old).map_err(|e| failed(folder, e))?;
    }
    fs::rename(&part, folder).map_err(|e| failed(folder, e))?;
    if had {
        fs::remove_dir_all(&old).map_err(|e| failed(&old, e))?;
    }
    written
}

fn write_all(bake: &Bake, part: &Path, failed: &dyn Fn(&Path, std::io::Error) -> Error) -> Result<u64> {
    fs::create_dir_all(part).map_err(|e| failed(part, e))?;
    let arrays = arrays(bake);
    let mut total = 0;
    for (name, bytes) in &arrays {
        let path = part.join(name);
        fs::write(&path, bytes).map_err(|e| failed(&path, e))?;
        total += bytes.len() as u64;
    }
    let manifest = Manifest {
        format: "lampyris bake".into(),
        version: VERSION,
        scene: bake.fingerprint.clone(),
        settings: bake.settings,
        patches: bake.patches.list.len(),
        patch_size_m: bake.patches.size,
        triangles: bake.patches.triangles,
        dropped: bake.patches.dropped,
        buried_m2: bake.patches.buried,
        surface_m2: bake.patches.surface.0,
        surface_reflectance: bake.patches.surface.1.to_array(),
        off_surface_m: bake.patches.off_surface,
        points_a_patch: POINTS,
        spectrum: bake.spectrum,
        factors: bake.factors,
        bytes_an_element: bake.bytes_an_element(),
        codec_error: bake.codec_error,
        norm_scale: bake.norm_scale,
        transfer: GridForm {
            origin_m: bake.transfer.origin.to_array(),
            cell_m: bake.transfer.cell,
            size: bake.transfer.size,
            reach_cells: bake.transfer.reach,
        },
        files: arrays.iter().map(|(name, bytes)| ((*name).into(), bytes.len() as u64, hash(bytes))).collect(),
        residual_scale: operator::scale(&bake.operator),
    };
    let mut text = serde_json::to_string_pretty(&manifest).map_err(|e| Error::new(format!("the manifest: {e}")))?;
    text.push('\n');
    let path = part.join(MANIFEST);
    fs::write(&path, &text).map_err(|e| failed(&path, e))?;
    Ok(total + text.len() as u64)
}

/// Reads a bake of the scene whose surfaces have this fingerprint.
///
/// # Errors
/// A file that is missing, damaged, or of another version; a bake of another scene. The file and the field are named.
pub fn load(folder: &Path, fingerprint: &str) -> Result<Bake> {
    let path = folder.join(MANIFEST);
    let refuse = |why: String| Error::new(format!("{}: {why}", path.display()));
    let text = fs::read(&path).map_err(|e| refuse(format!("could not be read: {e}")))?;
    let manifest: Manifest =
        serde_json::from_slice(&text).map_err(|e| refuse(format!("is no manifest of a bake: {e}")))?;
    if manifest.format != "lampyris bake" || manifest.version != VERSION {
        return Err(refuse(format!(
            "format \"{}\", version {}: this build reads \"lampyris bake\", version {VERSION}",
            manifest.format, manifest.version
        )));
    }
    if manifest.scene != fingerprint {
        return Err(refuse(format!("scene {} was baked, this one is {fingerprint}", manifest.scene)));
    }
    if manifest.points_a_patch != POINTS {
        return Err(refuse(format!("points_a_patch {} is not {POINTS}", manifest.points_a_patch)));
    }
    let read = |name: &str| -> Result<Vec<u8>> {
        let path = folder.join(name);
        let wrong = |why: String| Error::new(format!("{}: {why}", path.display()));
        let bytes = fs::read(&path).map_err(|e| wrong(format!("could not be read: {e}")))?;
        let said = manifest.files.iter().find(|file| file.0 == name);
        let Some((_, length, sum)) = said else { return Err(wrong("the manifest does not name it".into())) };
        if bytes.len() as u64 != *length {
            return Err(wrong(format!("has {} bytes, the manifest says {length}", bytes.len())));
        }
        if hash(&bytes) != *sum {
            return Err(wrong(format!("has the checksum {}, the manifest says {sum}", hash(&bytes))));
        }
        Ok(bytes)
    };
    let count = manifest.patches;
    let within = |name: &str, e: String| Error::new(format!("{}: {e}", folder.join(name).display()));
    let doubles = |name: &str, shape: &[usize]| -> Result<Vec<f64>> {
        npy::read(&read(name)?, Some(shape)).map_err(|e| within(name, e))
    };
    let list = doubles("patches.npy", &[count, PATCH_NUMBERS])?
        .chunks_exact(PATCH_NUMBERS)
        .map(|n| Patch {
            sources: Vec::new(),
            flat: false,
            triangles: Vec::new(),
            center: DVec3::new(n[0], n[1], n[2]),
            normal: DVec3::new(n[3], n[4], n[5]),
            area: n[6],
            radius: n[7],
            reflectance: DVec3::new(n[8], n[9], n[10]),
            emission: DVec3::new(n[11], n[12], n[13]),
        })
        .collect();
    let points = doubles("points.npy", &[count, POINTS as usize, 6])?
        .chunks_exact(6)
        .map(|p| [DVec3::new(p[0], p[1], p[2]), DVec3::new(p[3], p[4], p[5])])
        .collect();
    let arrays = operator::Arrays { folder, read: &read };
    let operator = operator::load(&arrays, manifest.settings.codec, count, manifest.residual_scale.unwrap_or(1.0))?;
    let grid = manifest.transfer;
    let transfer = Transfer {
        origin: DVec3::from_array(grid.origin_m),
        cell: grid.cell_m,
        size: grid.size,
        words: npy::read(&read("transfer.npy")?, None).map_err(|e| within("transfer.npy", e))?,
        reach: grid.reach_cells,
    };
    transfer.check(count).map_err(|e| within("transfer.npy", e))?;
    Ok(Bake {
        fingerprint: manifest.scene,
        settings: manifest.settings,
        patches: Patches {
            list,
            size: manifest.patch_size_m,
            triangles: manifest.triangles,
            dropped: manifest.dropped,
            buried: manifest.buried_m2,
            surface: (manifest.surface_m2, DVec3::from_array(manifest.surface_reflectance)),
            off_surface: manifest.off_surface_m,
        },
        points,
        operator,
        transfer,
        spectrum: manifest.spectrum,
        factors: manifest.factors,
        codec_error: manifest.codec_error,
        norm_scale: manifest.norm_scale,
    })
}

#[cfg(test)]
mod tests;
