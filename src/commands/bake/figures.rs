//! `bake --report`: what the thesis shows of its matrix (A. Shcherbakov, 2017), from this scene: histograms before and after logarithm and scaling (its
//! figures 1, 3 and 4), what is lost by what is taken out (2), the matrix before and after ordering and compressed (5, 7, 8, 9), differences (10, 11),
//! and the table of errors by passes of ordering.

use std::path::Path;

use crate::commands::measured;
use crate::error::{Error, Result};
use crate::measure::file;
use crate::measure::html::{self, Section, Table};
use crate::measure::plot::{Axis, Figure, Plot, Point, Scale, Series};
use crate::radiosity::Exchange;
use crate::radiosity::bake::{CodecName, sum_bounces};
use crate::radiosity::codec::block;
use crate::radiosity::codec::logarithm::Logarithm;
use crate::radiosity::codec::thesis::{self, Holes, SHARE, Thesis};
use crate::radiosity::order::{Order, Orders};

/// Bounces of the thesis.
const BOUNCES: u32 = 3;
/// Most columns and rows of a picture; larger matrices are averaged.
const PICTURE: usize = 1024;
/// Intervals of a histogram.
const BINS: usize = 128;
/// Nats below the largest that its first histogram shows.
const DECADES: f64 = 12.0;
/// A code more or less is so bright in pictures of differences.
const DIFFERENCE: u32 = 8;

/// Errors of codes, over what was not taken out.
struct Errors {
    mean: f64,
    largest: u32,
    sum: u64,
}

/// A way to order the matrix, with what comes of it.
struct Ordered {
    name: &'static str,
    /// 8-bit logarithms, three channels.
    image: Vec<u8>,
    /// What blocks decode to.
    decoded: Vec<u8>,
    errors: Errors,
}

/// Writes all of it into a folder.
///
/// # Errors
/// Bounces that cannot be summed; a full disk, no permission.
pub(super) fn write(exchange: &Exchange, scene: &str, folder: &Path) -> Result<()> {
    measured::make_folder(folder)?;
    let n = exchange.exact.count;
    let (sums, _) = sum_bounces(&exchange.exact, &exchange.patches, CodecName::Thesis, Some(BOUNCES))?;
    let image = thesis::image(n, &sums).map_err(Error::new)?;
    let passes = [("no", Order::None), ("one", Order::Rows), ("two", Order::RowsColumns)];
    let ordered: Vec<Ordered> =
        passes.into_iter().map(|(name, order)| of_order(n, &sums, &image, name, order)).collect::<Result<_>>()?;
    let largest = sums.iter().flatten().copied().fold(0f32, f32::max);
    let figures =
        vec![values_histogram(&sums, largest), lost_by_share(&sums), kept_histogram(&sums), codes_histogram(&image)];
    let mut pictures = Vec::new();
    for (index, of) in ordered.iter().enumerate() {
        let what = format!("8-bit logarithms of the matrix, {} pass(es) of ordering", of.name);
        pictures.push((format!("matrix-{index}"), what, of.image.clone()));
    }
    if let (Some(first), Some(last)) = (ordered.first(), ordered.last()) {
        pictures.push((
            "matrix-compressed".into(),
            "After two passes, as BC1 blocks decode".into(),
            last.decoded.clone(),
        ));
        for (name, of) in [("difference-0", first), ("difference-2", last)] {
            let what = format!("Blocks against what they encode, {} pass(es), times {DIFFERENCE}", of.name);
            let differences = of.image.iter().zip(&of.decoded).map(|(a, b)| off(*a, *b)).collect();
            pictures.push((name.into(), what, differences));
        }
    }
    let mut shown = Vec::new();
    for (name, caption, bytes) in pictures {
        let (side, rgba) = shrunk(n, &bytes);
        file::write_png(&folder.join(format!("{name}.png")), [side; 2], &rgba, &[])?;
        shown.push((caption, file::png([side; 2], &rgba)?));
    }
    let origin = [("version".into(), env!("CARGO_PKG_VERSION").into()), ("scene".into(), scene.to_string())];
    measured::write_figures(folder, "matrix-values", &figures, &origin)?;
    let section = Section {
        title: format!("{n} patches of {scene}, {BOUNCES} bounces"),
        paragraphs: vec![format!(
            "Elements are light that leaves a column's patch and is sent on by a row's after {BOUNCES} bounces or fewer; {:.0} % of them, the largest, \
             are taken out.",
            100.0 * SHARE
        )],
        tables: vec![table(&ordered)],
        figures,
        pictures: shown,
    };
    let page = html::page("Lampyris: a form-factor matrix and its compression", &origin, &[section])?;
    file::write(&folder.join("index.html"), page.as_bytes())
}

fn of_order(n: usize, sums: &[Vec<f32>; 3], image: &[u8], name: &'static str, order: Order) -> Result<Ordered> {
    let orders = Orders::new(order, image, n, 3).map_err(Error::new)?;
    let mut channels = Vec::new();
    for sum in sums {
        channels.push(orders.apply(sum).map_err(Error::new)?);
    }
    let channels: [Vec<f32>; 3] = channels.try_into().map_err(|_| Error::new("a matrix has three channels"))?;
    let image = thesis::image(n, &channels).map_err(Error::new)?;
    let encoded = Thesis::encode(n, &channels, Holes::Zero).map_err(Error::new)?;
    let side = block::side(n);
    let mut decoded = vec![0u8; 3 * n * n];
    for (number, of) in encoded.blocks.iter().enumerate() {
        for (t, codes) in block::bc1_texels(*of).into_iter().enumerate() {
            let (row, column) = (4 * (number / side) + t / 4, 4 * (number % side) + t % 4);
            if row < n && column < n {
                decoded[3 * (row * n + column)..3 * (row * n + column) + 3].copy_from_slice(&codes);
            }
        }
    }
    let mut errors = Errors { mean: 0.0, largest: 0, sum: 0 };
    for (a, b) in image.iter().zip(&decoded) {
        let off = u32::from(a.abs_diff(*b));
        errors.largest = errors.largest.max(off);
        errors.sum += u64::from(off);
    }
    errors.mean = errors.sum as f64 / image.len().max(1) as f64;
    Ok(Ordered { name, image, decoded, errors })
}

fn off(a: u8, b: u8) -> u8 {
    (u32::from(a.abs_diff(b)) * DIFFERENCE).min(255) as u8
}

fn table(ordered: &[Ordered]) -> Table {
    let first = ordered.first().map_or(0, |of| of.errors.sum);
    let row = |of: &Ordered| {
        let ratio = first as f64 / of.errors.sum.max(1) as f64;
        vec![
            of.name.to_string(),
            format!("{:.3}", of.errors.mean),
            of.errors.largest.to_string(),
            of.errors.sum.to_string(),
            format!("{ratio:.2}"),
        ]
    };
    Table {
        caption: "Errors of 8-bit codes by passes of ordering".into(),
        header: ["passes", "mean", "largest", "sum", "no ordering over this"].map(String::from).to_vec(),
        rows: ordered.iter().map(row).collect(),
    }
}

fn points(of: impl Iterator<Item = (f64, f64)>) -> Vec<Point> {
    of.map(|(x, y)| Point { x, y, low: y, high: y }).collect()
}

fn line(title: &str, caption: &str, [x, y]: [Axis; 2], series: Vec<(String, Vec<Point>)>) -> Figure {
    let series = series.into_iter().map(|(name, points)| Series { name, points, line: true, marked: Vec::new() });
    Figure::Plot(Plot { title: title.into(), caption: caption.into(), x, y, series: series.collect() })
}

fn linear(label: &str) -> Axis {
    Axis { label: label.into(), scale: Scale::Linear }
}

fn counted(label: &str) -> Axis {
    Axis { label: label.into(), scale: Scale::Log }
}

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// Numbers in intervals of `low` to `high`; those that are empty are left out, since the axis is logarithmic.
fn histogram(values: impl Iterator<Item = f64>, low: f64, high: f64) -> Vec<Point> {
    let mut bins = [0u64; BINS];
    let width = (high - low) / BINS as f64;
    for value in values.filter(|value| (low..=high).contains(value)) {
        bins[(((value - low) / width) as usize).min(BINS - 1)] += 1;
    }
    let middle = |k: usize| low + (k as f64 + 0.5) * width;
    points(bins.iter().enumerate().filter(|(_, count)| **count > 0).map(|(k, count)| (middle(k), *count as f64)))
}

fn values_histogram(sums: &[Vec<f32>; 3], largest: f32) -> Figure {
    let of = |c: usize| {
        let values = sums[c].iter().map(|x| f64::from(*x / largest.max(f32::MIN_POSITIVE)));
        (CHANNELS[c].to_string(), histogram(values, 0.0, 1.0))
    };
    let axes = [linear("element over the largest"), counted("elements")];
    line("Elements as they are", "Almost all are next to nothing.", axes, (0..3).map(of).collect())
}

/// What the largest elements hold of all.
fn lost_by_share(sums: &[Vec<f32>; 3]) -> Figure {
    let of = |c: usize| {
        let mut values = sums[c].clone();
        values.sort_unstable_by(|a, b| b.total_cmp(a));
        let all: f64 = values.iter().map(|x| f64::from(*x)).sum();
        let (mut held, mut at) = (0.0, 0);
        let curve = (0..=BINS).map(|k| {
            let end = values.len() * k / (10 * BINS);
            held += values[at..end].iter().map(|x| f64::from(*x)).sum::<f64>();
            at = end;
            (100.0 * k as f64 / (10 * BINS) as f64, 100.0 * held / all.max(f64::MIN_POSITIVE))
        });
        let curve: Vec<(f64, f64)> = curve.collect();
        (CHANNELS[c].to_string(), points(curve.into_iter()))
    };
    let axes = [linear("elements taken out, the largest first (%)"), linear("of all light (%)")];
    line(
        "What the largest elements hold",
        "Blocks lose less the more of it is kept apart.",
        axes,
        (0..3).map(of).collect(),
    )
}

fn kept_histogram(sums: &[Vec<f32>; 3]) -> Figure {
    let of = |c: usize| {
        let mut values = sums[c].clone();
        values.sort_unstable_by(|a, b| b.total_cmp(a));
        let kept = &values[(values.len() as f64 * SHARE) as usize..];
        let top = f64::from(kept.first().copied().unwrap_or(0.0)).max(f64::MIN_POSITIVE);
        (CHANNELS[c].to_string(), histogram(kept.iter().map(|x| f64::from(*x) / top), 0.0, 1.0))
    };
    let axes = [linear("element over the largest that is left"), counted("elements")];
    line("Elements that are left, divided by their largest", "", axes, (0..3).map(of).collect())
}

fn codes_histogram(image: &[u8]) -> Figure {
    let step = Logarithm::thesis(1.0).step;
    let of = |c: usize| {
        let codes = image.iter().skip(c).step_by(3).map(|code| f64::from(*code));
        (CHANNELS[c].to_string(), histogram(codes, 0.0, 256.0))
    };
    let axes = [linear(&format!("8-bit code; {:.1} of them are {DECADES} nats", DECADES / step)), counted("elements")];
    line("After the logarithm", "Code 0 is what was taken out or is exactly 0.", axes, (0..3).map(of).collect())
}

/// At most [`PICTURE`] columns and rows: the mean of what falls on each.
fn shrunk(n: usize, bytes: &[u8]) -> (u32, Vec<u8>) {
    let side = n.clamp(1, PICTURE);
    let mut rgba = Vec::with_capacity(4 * side * side);
    for y in 0..side {
        for x in 0..side {
            let range = |k: usize| k * n / side..((k + 1) * n / side).max(k * n / side + 1).min(n);
            let mut sums = [0u64; 3];
            let mut count = 0u64;
            for row in range(y) {
                for column in range(x) {
                    let at = 3 * (row * n + column);
                    (0..3).for_each(|c| sums[c] += u64::from(bytes[at + c]));
                    count += 1;
                }
            }
            rgba.extend(sums.map(|sum| (sum / count.max(1)) as u8));
            rgba.push(255);
        }
    }
    (side as u32, rgba)
}
