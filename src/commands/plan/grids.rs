//! Grids, light lists and the G-buffer of a plan: lines for people, and their machine form.

use serde_json::{Value, json};

use crate::commands::report;
use crate::plan::{Clusters, Deferred, DepthBounds, Gbuffer, GbufferLayout, Plan, Tiles};
use crate::shared::BIN_TILES;

/// Bytes of a light's id in a list.
const ID_BYTES: u64 = 4;

/// A line for each grid, each kind of list and the G-buffer; none for what the plan does not have.
pub(super) fn lines(plan: &Plan) -> String {
    let mut out = String::new();
    if let Some(tiles) = &plan.tiles {
        out += &grids(tiles);
    }
    if let Some(clusters) = &plan.clusters {
        out += &slices(clusters);
    }
    if let Some(tiles) = &plan.tiles {
        out += &lists(tiles, plan.clusters.as_ref());
    }
    if let Some(deferred) = &plan.deferred {
        let bytes = deferred.gbuffer.texel_bytes();
        out += &format!(
            "gbuffer   {}, {bytes} bytes a pixel: {}\n",
            deferred.gbuffer.layout.name(),
            report::bytes(bytes * plan.pixels())
        );
    }
    out
}

fn grids(tiles: &Tiles) -> String {
    let row = |columns: u32, rows: u32| format!("{columns:>4} x {rows:<4} = {:>7}", columns * rows);
    let (grid, tile) = (&tiles.grid, tiles.tile);
    let slots = if tiles.bounds == DepthBounds::Mask { format!(" of {} slots", tiles.slots) } else { String::new() };
    format!(
        "tiles     {}, each {tile} x {tile} pixels; cull {}, depth bounds {}{slots}\n\
         bins      {}, each {BIN_TILES} x {BIN_TILES} tiles\n",
        row(grid.columns, grid.rows),
        tiles.cull.name(),
        tiles.bounds.name(),
        row(grid.bin_columns, grid.bin_rows)
    )
}

fn slices(clusters: &Clusters) -> String {
    let least = if clusters.keyed { "at most" } else { "exactly" };
    format!(
        "slices    {}\nclusters  {least} {}, {} bounds\n",
        clusters.why,
        clusters.grid.capacity,
        clusters.bounds.name()
    )
}

fn lists(tiles: &Tiles, clusters: Option<&Clusters>) -> String {
    let row = |title: &str, name: &str, how: &str, pairs: u64, longest: Option<u32>| {
        let longest = longest.map(|most| format!(", the longest {most}")).unwrap_or_default();
        let bytes = report::bytes(pairs * ID_BYTES);
        format!("{title:<10}{name:<9} {how:<8}{pairs:>12} entries {bytes:>11}{longest}\n")
    };
    let mut out = row("lists", "bins", "exactly", tiles.bin_pairs, Some(tiles.longest_bin));
    out += &row("", "tiles", "at most", tiles.tile_pairs, Some(tiles.longest_tile));
    if let Some(clusters) = clusters {
        out += &row("", "clusters", "at most", clusters.pairs, None);
    }
    out
}

/// `plan.tiles` of the machine form.
pub(super) fn tiles_json(tiles: &Tiles) -> Value {
    json!({
        "tile": tiles.tile,
        "columns": tiles.grid.columns,
        "rows": tiles.grid.rows,
        "cull": tiles.cull.name(),
        "depth_bounds": tiles.bounds.name(),
        "depth_reduce": (tiles.bounds != DepthBounds::Off).then_some(if tiles.group_a_tile { "group" } else { "thread" }),
        "slots": (tiles.bounds == DepthBounds::Mask).then_some(tiles.slots),
        "bin_columns": tiles.grid.bin_columns,
        "bin_rows": tiles.grid.bin_rows,
        "bin_list_bytes": tiles.bin_pairs * ID_BYTES,
        "tile_list_bytes": tiles.tile_pairs * ID_BYTES,
        "longest_list": tiles.longest_tile,
        "bytes": tiles.bytes(),
    })
}

/// `plan.clusters` of the machine form.
pub(super) fn clusters_json(clusters: &Clusters) -> Value {
    json!({
        "slices": clusters.grid.slices,
        "clusters": clusters.grid.capacity,
        "keyed": clusters.keyed,
        "sorted": clusters.merged,
        "key_bits": clusters.keyed.then_some(clusters.key_bits),
        "bounds": clusters.bounds.name(),
        "list_bytes": clusters.pairs * ID_BYTES,
        "bytes": clusters.bytes(),
        "directions": clusters.by_normal().then_some(clusters.count_directions()),
        "why": clusters.why,
    })
}

/// `plan.gbuffer` of the machine form.
pub(super) fn gbuffer_json(plan: &Plan, gbuffer: &Gbuffer) -> Value {
    let compact = gbuffer.layout == GbufferLayout::Compact;
    json!({
        "layout": gbuffer.layout.name(),
        "normal_bits": compact.then_some(gbuffer.normal_bits),
        "emission": gbuffer.emission || !compact,
        "texel_bytes": gbuffer.texel_bytes(),
        "bytes": gbuffer.texel_bytes() * plan.pixels(),
        "pixels_a_thread": plan.deferred.as_ref().and_then(Deferred::pixels_a_thread),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Limits, Request, Technique};
    use crate::scene::builtin;

    fn planned(technique: Technique) -> Plan {
        let scene = builtin::load("atrium").expect("a built-in scene");
        let request = Request { width: 320, height: 180, technique, ..Request::default() };
        Plan::new(&scene, &request, &Limits::MINIMUM).expect("a plan")
    }

    /// What stands in the first column of each line.
    fn titles(text: &str) -> Vec<&str> {
        text.lines().map(|line| line[..10].trim_end()).collect()
    }

    #[test]
    fn there_is_a_line_for_what_the_plan_has() {
        assert_eq!(lines(&planned(Technique::Forward)), "");
        let deferred = planned(Technique::Deferred);
        let bytes = deferred.deferred.as_ref().expect("a G-buffer").gbuffer.texel_bytes();
        let size = report::bytes(320 * 180 * bytes);
        assert_eq!(lines(&deferred), format!("gbuffer   compact, {bytes} bytes a pixel: {size}\n"));
        let tiled = lines(&planned(Technique::TiledDeferred));
        assert_eq!(titles(&tiled), ["tiles", "bins", "lists", "", "gbuffer"]);
        let clustered = lines(&planned(Technique::ClusteredForward));
        assert_eq!(titles(&clustered), ["tiles", "bins", "slices", "clusters", "lists", "", ""]);
        let first = "tiles       20 x 12   =     240, each 16 x 16 pixels; cull frustum-aabb, depth bounds minmax\n";
        assert!(clustered.starts_with(first), "{clustered}");
    }

    #[test]
    fn bytes_of_lists_are_the_plans() {
        let plan = planned(Technique::ClusteredForward);
        let (tiles, clusters) = (plan.tiles.as_ref().expect("tiles"), plan.clusters.as_ref().expect("clusters"));
        let text = lines(&plan);
        for (pairs, key) in [
            (tiles.bin_pairs, &tiles_json(tiles)["bin_list_bytes"]),
            (tiles.tile_pairs, &tiles_json(tiles)["tile_list_bytes"]),
            (clusters.pairs, &clusters_json(clusters)["list_bytes"]),
        ] {
            assert!(pairs > 0 && *key == 4 * pairs, "{pairs}: {key}");
            assert!(text.contains(&format!("{pairs} entries ")), "{pairs}: {text}");
        }
    }
}
