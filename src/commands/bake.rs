//! `bake`: patches, form factors, codec, and a folder of files.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use serde_json::{Value, json};

use super::measured::progress;
use super::{report, setup};
use crate::cli::{self, CodecArg, PatchesFromArg};
use crate::error::{Error, Result};
use crate::gpu::{Options, pipeline_cache};
use crate::radiosity::bake::{Bake, CodecName, PatchRule, Settings};
use crate::radiosity::factors::{MOST_PATCHES, RawRows};
use crate::radiosity::order::Order;
use crate::radiosity::patches::PatchSource;
use crate::radiosity::sight::Sight;
use crate::radiosity::{Exchange, Patches, exchange, files};
use crate::reference::render::Reference;
use crate::scene::Scene;
use crate::scene::view::View;

mod figures;
mod looks;

use looks::{Looks, judged, looked};

/// Milliseconds by stage, in their order.
type Stages = Vec<(&'static str, f64)>;

/// Runs the command.
///
/// # Errors
/// One sentence; rows that are done are kept for the next call.
pub fn run(args: &cli::Bake) -> Result<ExitCode> {
    let options = Options { validate: args.validate, driver: args.driver.clone() };
    let looks = Looks::new(args.bake_on, options)?;
    files::check_place(&args.output)?;
    let scene = setup::load_scene(&args.scene)?;
    let settings = settings(args)?;
    let mut stages = Stages::new();
    let which = match (args.shard, args.merge) {
        (Some((i, n)), _) => Rows::Shard { index: i as usize - 1, of: n as usize },
        (None, true) => Rows::Given,
        (None, false) => Rows::All,
    };
    let made = make(&scene, settings, (&args.output, &looks), (&which, args.report.as_deref()), &mut stages)?;
    let Some(baked) = made.baked else {
        let parts = parts_of(&args.output);
        report::print(&format!(
            "{}looks     {}\nrows      of shard {} are in {}; bake --merge makes the bake of all of them\n",
            made.patches,
            made.looks,
            args.shard.map_or(String::new(), |(i, n)| format!("{i}/{n}")),
            parts.display()
        ))?;
        return Ok(ExitCode::SUCCESS);
    };
    let start = Instant::now();
    let bytes = files::store(&baked, &args.output)?;
    let _ = fs::remove_dir_all(parts_of(&args.output));
    stages.push(("files", start.elapsed().as_secs_f64() * 1e3));
    if !report::json_on_stdout(args.json.as_deref()) {
        report::print(&said(&baked, &stages, bytes, (&args.output, &made.looks)))?;
    }
    if let Some(path) = &args.json {
        report::write_json(path, &machine_form(&baked, &stages, bytes, &made.looks))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn codec_name(codec: CodecArg) -> CodecName {
    match codec {
        CodecArg::Classical => CodecName::Classical,
        CodecArg::DenseF16 => CodecName::DenseF16,
        CodecArg::Thesis => CodecName::Thesis,
        CodecArg::ThesisFilled => CodecName::ThesisFilled,
        CodecArg::Bc1 => CodecName::Bc1,
        CodecArg::Bc4Chroma => CodecName::Bc4Chroma,
        CodecArg::ZeroBlock => CodecName::ZeroBlock,
    }
}

fn settings(args: &cli::Bake) -> Result<Settings> {
    let codec = codec_name(args.codec);
    let refuse = |option: &str, why: &str| Err(Error::usage(format!("{option}: --codec {} {why}", codec.name())));
    if args.bounces.is_some() && !codec.is_summed() {
        return refuse("--bounces", "gathers each bounce as it renders; --gi-gathers of render says how often");
    }
    if args.order.is_some() && !codec.is_summed() {
        return refuse("--order", "keeps the order of patches");
    }
    if args.extract.is_some() && codec != CodecName::ZeroBlock {
        return refuse("--extract", "has a share of its own");
    }
    let defaults = Settings::of_codec(codec);
    let patches = match (args.patch_size, args.patches) {
        (Some(metres), _) => PatchRule::Size(metres),
        (None, Some(count)) => PatchRule::Count(count as usize),
        (None, None) => defaults.patches,
    };
    let bounces = match args.bounces {
        Some(cli::Bounces::Some(count)) => Some(count),
        Some(cli::Bounces::All) => None,
        None => defaults.bounces,
    };
    let order = match args.order {
        Some(cli::OrderArg::None) => Order::None,
        Some(cli::OrderArg::Rows) => Order::Rows,
        Some(cli::OrderArg::RowsColumns) => Order::RowsColumns,
        Some(cli::OrderArg::Landmarks) => Order::Landmarks,
        None => defaults.order,
    };
    let extract = args.extract.map_or(defaults.extract, |percent| percent / 100.0);
    let patches_from = match args.patches_from {
        PatchesFromArg::Triangles => PatchSource::Triangles,
        PatchesFromArg::Voxels => PatchSource::Voxels,
    };
    Ok(Settings { patches, patches_from, codec, extract, bounces, order, seed: args.seed })
}

/// Which rows are computed here.
enum Rows {
    /// All that are not there yet.
    All,
    /// Every `of`-th run, from `index` on.
    Shard { index: usize, of: usize },
    /// None: they have to be there.
    Given,
}

/// Where rows are kept until all are there.
fn parts_of(folder: &Path) -> PathBuf {
    files::beside(folder, ".rows")
}

/// What of a bake its rows depend on.
fn key(scene: &Scene, settings: &Settings, patches: &Patches) -> String {
    let from = match settings.patches_from {
        PatchSource::Triangles => "",
        PatchSource::Voxels => "-voxels",
    };
    let (count, size) = (patches.list.len(), patches.size.to_bits());
    format!("{}-{count}-{size}-{}{from}", scene.surface_fingerprint(), settings.seed)
}

/// What baking leaves.
struct Made {
    /// None where only a shard's rows were wanted.
    baked: Option<Bake>,
    /// For people: the patches, a line.
    patches: String,
    /// Who looked.
    looks: String,
}

/// Makes a bake, or a shard's rows.
fn make(
    scene: &Scene,
    settings: Settings,
    (folder, looks): (&Path, &Looks),
    (which, report): (&Rows, Option<&Path>),
    stages: &mut Stages,
) -> Result<Made> {
    let mut timed = |name: &'static str, start: Instant| stages.push((name, start.elapsed().as_secs_f64() * 1e3));
    let start = Instant::now();
    let occluders = Reference::new(scene, &View::of_world())?;
    let patches = exchange::patches(scene, &occluders, &settings)?;
    let count = patches.list.len();
    if count == 0 {
        return Err(Error::new(format!("{}: no surface reflects light between patches", scene.name)));
    }
    if count > MOST_PATCHES {
        let size = patches.size;
        return Err(Error::new(format!(
            "{}: {count} patches of {size:.3} m, at most {MOST_PATCHES} have a matrix here",
            scene.name
        )));
    }
    timed("patches", start);
    let start = Instant::now();
    let key = key(scene, &settings, &patches);
    let parts = parts_of(folder);
    fs::create_dir_all(&parts).map_err(|e| Error::new(format!("{}: could not be made: {e}", parts.display())))?;
    let said = said_of_patches(&patches);
    let own = |index: usize| !matches!(which, Rows::Shard { index: own, of } if index % of != *own);
    let runs = exchange::runs(count);
    let missing = |(index, run): (usize, &Range<usize>)| own(index) && !files::rows_path(&parts, run).exists();
    let looks_anew = !matches!(which, Rows::Given) && runs.iter().enumerate().any(missing);
    let renderer = if looks_anew { looks.renderer(count)? } else { None };
    let (device, mut who) = looks.device(renderer.as_ref(), &occluders, (&patches, settings.seed))?;
    if !looks_anew {
        who = "rows were there".into();
    }
    let sight: &dyn Sight = device.as_ref().map_or(&occluders, |device| device);
    let check = || device.as_ref().zip(renderer.as_ref()).map_or(Ok(()), |(device, renderer)| judged(device, renderer));
    let bar = progress(count as u64, "form factors, rows");
    let mut rows = Vec::new();
    for (index, run) in runs.into_iter().enumerate() {
        if !own(index) {
            bar.inc(run.len() as u64);
            continue;
        }
        rows.push(rows_of(&patches, (sight, &check), settings.seed, (&parts, &key), run, which, &|| bar.inc(1))?);
    }
    bar.finish_and_clear();
    timed("form factors", start);
    who += &device.as_ref().map_or(String::new(), looked);
    if matches!(which, Rows::Shard { .. }) {
        return Ok(Made { baked: None, patches: said, looks: who });
    }
    let start = Instant::now();
    let exchange = Exchange::new(scene, &occluders, settings.seed, patches, rows)?;
    timed("transfer", start);
    if let Some(folder) = report {
        let start = Instant::now();
        figures::write(&exchange, &scene.name, folder)?;
        timed("report", start);
    }
    let start = Instant::now();
    let baked = Bake::new(exchange, settings)?;
    timed("codec", start);
    Ok(Made { baked: Some(baked), patches: said, looks: who })
}

/// A run of rows from its file, or computed and stored there.
fn rows_of(
    patches: &Patches,
    (sight, check): (&dyn Sight, &dyn Fn() -> Result<()>),
    seed: u64,
    (parts, key): (&Path, &str),
    run: Range<usize>,
    which: &Rows,
    done: &(dyn Fn() + Sync),
) -> Result<RawRows> {
    if let Some(found) = files::load_rows(parts, key, &run, patches.list.len())? {
        run.for_each(|_| done());
        return Ok(found);
    }
    if matches!(which, Rows::Given) {
        let path = files::rows_path(parts, &run);
        return Err(Error::new(format!("{}: rows {} to {} are not there", path.display(), run.start, run.end - 1)));
    }
    let found = RawRows::new(patches, sight, seed, run, done)?;
    // Nothing is kept that was not looked at rightly.
    check()?;
    files::store_rows(parts, key, &found)?;
    Ok(found)
}

/// The bake of a scene from the cache, made there where it is not.
///
/// # Errors
/// As baking; no cache folder.
pub fn cached(scene: &Scene, driver: Option<&str>) -> Result<Bake> {
    let settings = Settings::default();
    let cache = pipeline_cache::folder()
        .ok_or_else(|| Error::new("neither XDG_CACHE_HOME nor HOME is set: a bake has no place; --gi radiosity:DIR"))?;
    let PatchRule::Count(count) = settings.patches else { return Err(Error::new("the default has a size")) };
    let (version, codec) = (files::VERSION, settings.codec.name());
    let name = format!("bake-v{version}-{}-{count}-{codec}", scene.surface_fingerprint());
    let folder = cache.join(name);
    if let Ok(found) = files::load(&folder, &scene.surface_fingerprint()) {
        return Ok(found);
    }
    fs::create_dir_all(&cache).map_err(|e| Error::new(format!("{}: could not be made: {e}", cache.display())))?;
    let made = make(scene, settings, (&folder, &Looks::auto(driver)), (&Rows::All, None), &mut Stages::new())?;
    let baked = made.baked.ok_or_else(|| Error::new("a bake without shards is whole"))?;
    files::store(&baked, &folder)?;
    let _ = fs::remove_dir_all(parts_of(&folder));
    Ok(baked)
}

fn said_of_patches(patches: &Patches) -> String {
    let [area_off, albedo_off] = patches.simplified();
    format!(
        "patches   {} of about {:.3} m from {} triangles; {} dropped, {:.3} m2 inside of something; area {:+.2} %, reflectance off by {albedo_off:.4}\n",
        patches.list.len(),
        patches.size,
        patches.triangles,
        patches.dropped,
        patches.buried,
        100.0 * area_off,
    )
}

fn said(baked: &Bake, stages: &Stages, bytes: u64, (folder, looks): (&Path, &str)) -> String {
    let report = &baked.factors;
    let times: Vec<String> = stages.iter().map(|(name, ms)| format!("{name} {:.2}", ms * 1e-3)).collect();
    let [least, mean, most] = report.row_sums;
    format!(
        "{}factors   {} near pairs by their triangles, {} by points, {} by one; {} rays; rows summed to {least:.3}, {mean:.3}, {most:.3} of what rays find\n\
         looks     {looks}\n\
         codec     {}: {:.3} bytes an element, {} in all; relative L2 of bounced light {:.2e}, at most {:.2e}\n\
         spectrum  {:.4} to {:.4}{}\n\
         seconds   {}\n\
         folder    {} ({})\n",
        said_of_patches(&baked.patches),
        report.pairs[0],
        report.pairs[1],
        report.pairs[2],
        report.rays,
        baked.settings.codec.name(),
        baked.bytes_an_element(),
        report::bytes(baked.operator.bytes()),
        baked.codec_error[0],
        baked.codec_error[1],
        baked.spectrum.smallest,
        baked.spectrum.largest,
        if baked.norm_scale < 1.0 { format!(", scaled by {:.5}", baked.norm_scale) } else { String::new() },
        times.join(", "),
        folder.display(),
        report::bytes(bytes),
    )
}

fn machine_form(baked: &Bake, stages: &Stages, bytes: u64, looks: &str) -> Value {
    let seconds: serde_json::Map<String, Value> =
        stages.iter().map(|(name, ms)| (name.replace(' ', "_"), json!(ms * 1e-3))).collect();
    json!({
        "schema": report::SCHEMA,
        "scene": baked.fingerprint,
        "settings": baked.settings,
        "patches": baked.patches.list.len(),
        "patch_size_m": baked.patches.size,
        "triangles": baked.patches.triangles,
        "dropped": baked.patches.dropped,
        "buried_m2": baked.patches.buried,
        "area_error": baked.patches.simplified()[0],
        "albedo_error": baked.patches.simplified()[1],
        "factors": baked.factors,
        "looks": looks,
        "bytes_an_element": baked.bytes_an_element(),
        "matrix_bytes": baked.operator.bytes(),
        "codec_error": { "mean": baked.codec_error[0], "worst": baked.codec_error[1] },
        "spectrum": baked.spectrum,
        "norm_scale": baked.norm_scale,
        "seconds": seconds,
        "bytes": bytes,
    })
}
