//! Row C8: the light hierarchy on the device against its twin to the bit, and what walks find in it against every light in f64.

use super::Row;
use crate::error::{Error, Result};
use crate::graph::Graph;
use crate::passes::{self, Frame, SceneHandles};
use crate::plan::light_tree::LightTree;
use crate::plan::{DebugView, Plan, Request, Technique};
use crate::reference::light_tree::{self as twin, Tree};
use crate::renderer::Renderer;
use crate::scene::{Scene, builtin, scatter};
use crate::shared::{CULL_TEXELS, TREE_CELLS, TreeQuery};

/// Boxes that are asked for.
const QUERIES: u32 = 600;

/// Lights of a scene and how they are made.
struct Case {
    name: &'static str,
    lights: usize,
    /// Lights of a range far beyond the scene among them.
    wide: usize,
    one_place: bool,
    /// Nodes are read from storage whatever the device could do.
    storage: bool,
}

/// What holds for 5,000 lights, and no more than that.
const PLAIN: Case = Case { name: "5,000 lights", lights: 5000, wide: 0, one_place: false, storage: false };

/// C8, and more lights than 65,536 texels or one root hold.
const CASES: [Case; 7] = [
    Case { name: "no light", lights: 0, ..PLAIN },
    Case { name: "1 light", lights: 1, ..PLAIN },
    Case { name: "33 lights", lights: 33, ..PLAIN },
    Case { name: "5,000 lights at one place", one_place: true, ..PLAIN },
    Case { name: "5,000 lights, 40 of them wide", wide: 40, ..PLAIN },
    Case { name: "5,000 lights from storage", wide: 3, storage: true, ..PLAIN },
    Case { name: "40,000 lights", lights: 40_000, ..PLAIN },
];

impl Case {
    fn scene(&self) -> Result<Scene> {
        let mut scene = builtin::load("atrium")?;
        scene.lights = scatter::point_lights(&scene.bounds(), self.lights, 3);
        let places: Vec<_> = scene.lights.iter().map(|l| l.position).collect();
        for (index, light) in scene.lights.iter_mut().enumerate() {
            light.position = if self.one_place { places[0] } else { places[index] };
            light.range = if index < self.wide { Some(1e4) } else { self.range() };
        }
        Ok(scene)
    }

    /// Metres; scattered lights keep what the cut-off gives them.
    fn range(&self) -> Option<f32> {
        (self.lights >= PLAIN.lights).then_some(0.5)
    }
}

/// What a device made.
struct Made {
    lights: Vec<[f32; 4]>,
    tree: LightTree,
    queries: TreeQuery,
    texels: Vec<u32>,
    found: Vec<u32>,
    violations: usize,
}

fn make(renderer: &Renderer, case: &Case) -> Result<Made> {
    let (scene, limits) = (case.scene()?, renderer.limits());
    let request = Request { width: 150, height: 85, technique: Technique::TiledForward, ..crate::checks::forward() };
    // Without a light there are tiles only where they are shown.
    let request = Request { debug_view: Some(DebugView::TileLights), ..request };
    let plan = Plan::new(&scene, &request, &limits)?;
    let mut graph = Graph::new();
    let handles = SceneHandles::declare(&mut graph, &plan);
    let (Some(tiles), Some(tile_handles)) = (&plan.tiles, &handles.tiles) else {
        return Err(Error::new("this technique culls no lights"));
    };
    let mut tree = LightTree::new(&tiles.lights, &limits)?;
    tree.by_texel &= !case.storage;
    let queries = queries(&tree, &tiles.lights);
    let texels = passes::light_tree::add(&mut graph, tiles, &tree, tile_handles);
    let found = passes::light_tree::add_query(&mut graph, &tree, texels, &queries);
    graph.end_frame();
    let results = passes::read_back::add_all(&mut graph, &[], &[("light_tree", texels), ("found", found)]);
    let mut prepared = renderer.prepare_frame(&scene, &plan, Frame { graph, scene: handles, results })?;
    prepared.draw(2)?;
    let (picture, violations) = prepared.finish()?;
    // Layers are words whose bits went through f32 untouched: they were only copied.
    let words = |layer: &str| -> Vec<u32> { picture.layer(layer).unwrap_or(&[]).iter().map(|x| x.to_bits()).collect() };
    let (texels, found) = (words("light_tree"), words("found"));
    Ok(Made { lights: tiles.lights.clone(), tree, queries, texels, found, violations: violations.len() })
}

/// Boxes over all centres and the spheres of lights that are not wide.
fn queries(tree: &LightTree, lights: &[[f32; 4]]) -> TreeQuery {
    let shape = &tree.shape;
    let radii = lights.chunks_exact(CULL_TEXELS as usize).map(|light| light[1][2]);
    let radius = radii.filter(|r| *r <= shape.radius_limit && r.is_finite()).fold(0.0, f32::max);
    let extent = TREE_CELLS as f32 / shape.scale;
    let step = (if tree.shape.scale == 1.0 { 0.0 } else { extent } + 2.0 * radius) / TREE_CELLS as f32;
    TreeQuery { low: shape.low.map(|x| x - radius), step, query_count: QUERIES }
}

/// The sphere reaches into the box, in f64. Lights that no tile sees reach nothing.
fn reaches(light: &[[f32; 4]], (low, high): ([f32; 3], [f32; 3])) -> bool {
    let ([x, y, z, _], radius, [x0, x1, y0, y1]) = (light[0], light[1][2], light[2]);
    let apart = [x, y, z].into_iter().zip(low.into_iter().zip(high)).map(|(center, (low, high))| {
        let [center, low, high] = [center, low, high].map(f64::from);
        (low - center).max(center - high).max(0.0)
    });
    x0 <= x1 && y0 <= y1 && apart.map(|d| d * d).sum::<f64>() <= f64::from(radius) * f64::from(radius)
}

/// Lights that walks through `tree` should find and do not, over all boxes, and lights found twice.
fn missed(tree: &Tree<'_>, walks: u32, queries: &TreeQuery, lights: &[[f32; 4]]) -> usize {
    let mut wrong = 0;
    let mut times = vec![0u8; lights.len() / CULL_TEXELS as usize];
    for query in 0..queries.query_count {
        let (low, high) = twin::query_box(queries, query);
        times.fill(0);
        for light in (0..walks).flat_map(|root| tree.walk(root, low, high).0) {
            times[light as usize] = times[light as usize].saturating_add(1);
        }
        let each = times.iter().zip(lights.chunks_exact(CULL_TEXELS as usize));
        wrong += each.filter(|(times, light)| **times > 1 || (**times == 0 && reaches(light, (low, high)))).count();
    }
    wrong
}

/// Words that differ; all of them where the lengths do.
fn differing(found: &[u32], wanted: &[u32]) -> usize {
    if found.len() != wanted.len() {
        return found.len().max(wanted.len());
    }
    found.iter().zip(wanted).filter(|(a, b)| a != b).count()
}

/// Row C8: each hierarchy, and the walks through it.
///
/// # Errors
/// No memory, or a lost device.
pub fn light_tree(renderer: &Renderer) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut violations = 0;
    for case in &CASES {
        let made = make(renderer, case)?;
        violations += made.violations;
        let wanted = twin::build(&made.tree.shape, &made.lights);
        let bits: Vec<u32> = wanted.iter().flatten().map(|x| x.to_bits()).collect();
        let wrong = differing(&made.texels, &bits);
        rows.push(Row::none(format!("C8 light tree = twin, {}", case.name), wrong, "words that differ"));
        let tree = Tree::new(&wanted).ok_or_else(|| Error::new("the twin made no header"))?;
        let walks = made.tree.walk_count();
        let mut answers = Vec::new();
        for query in 0..QUERIES {
            let (low, high) = twin::query_box(&made.queries, query);
            for root in 0..walks {
                let (lights, visited) = tree.walk(root, low, high);
                answers.extend(twin::probe(&lights, visited));
            }
        }
        let wrong = differing(&made.found, &answers);
        rows.push(Row::none(format!("C8 walks = twin, {}", case.name), wrong, "words that differ"));
        let wrong = missed(&tree, walks, &made.queries, &made.lights);
        rows.push(Row::none(format!("C8 walks miss nothing, {}", case.name), wrong, "lights missed or met twice"));
    }
    rows.push(Row::none("barriers of the light tree proved", violations, "violations"));
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::plan::Limits;
    use crate::shared::{TREE_EMPTY, TREE_ENTRY_TEXELS, TREE_HEADER_TEXELS};

    /// Lights in a box of 40 m: some wide, some that no tile sees, radii down to 0.
    fn random(count: u32, seed: u64) -> Vec<[f32; 4]> {
        let mut random = Random::new(seed);
        let light = |index: u32| {
            let place = [-20.0, -20.0, -45.0].map(|low| random.range(low, low + 40.0) as f32);
            let radius = if index % 1000 == 7 { 50.0 } else { random.range(-0.2, 1.0).max(0.0) as f32 };
            let tiles = if index % 29 == 3 { [1.0, 0.0, 1.0, 0.0] } else { [0.0, 9.0, 0.0, 9.0] };
            [[place[0], place[1], place[2], radius * radius], [0.1, 99.0, radius, 0.0], tiles]
        };
        (0..count).flat_map(light).collect()
    }

    fn at_one_place(count: u32) -> Vec<[f32; 4]> {
        (0..count).flat_map(|_| [[1.0, 2.0, -3.0, 4.0], [1.0, 5.0, 2.0, 0.0], [0.0; 4]]).collect()
    }

    fn judge(lights: &[[f32; 4]], queries_asked: u32) {
        let count = (lights.len() / CULL_TEXELS as usize) as u32;
        let plan = LightTree::new(lights, &Limits::UNLIMITED).expect("nothing limits it");
        let texels = twin::build(&plan.shape, lights);
        assert_eq!(texels.len() as u64, plan.texel_count());
        let tree = Tree::new(&texels).expect("a header");
        let outside = plan.shape.everywhere_count;
        let leaves = tree.level(plan.shape.height);
        let mut order: Vec<u32> = (0..outside).map(|e| tree.entry(e).light as u32).collect();
        assert!(order.is_sorted(), "wide lights keep the order of ids");
        order.extend(leaves.iter().map(|leaf| leaf.light as u32));
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..count), "every light is in one leaf");
        for depth in 0..plan.shape.height {
            let (level, below) = (tree.level(depth), tree.level(depth + 1));
            assert_eq!(level.iter().map(|n| f64::from(n.light_count)).sum::<f64>(), f64::from(count - outside));
            for (node, children) in level.iter().zip(below.chunks(8)) {
                let holds = |c: &twin::Entry| (0..3).all(|a| node.low[a] <= c.low[a] && c.high[a] <= node.high[a]);
                assert!(children.iter().all(holds));
            }
        }
        let asked = TreeQuery { query_count: queries_asked, ..queries(&plan, lights) };
        assert_eq!(missed(&tree, plan.walk_count(), &asked, lights), 0);
        let everything = |root| tree.walk(root, [-TREE_EMPTY / 2.0; 3], [TREE_EMPTY / 2.0; 3]);
        let walks: Vec<_> = (0..plan.walk_count()).map(everything).collect();
        assert!(walks.iter().all(|(_, visited)| u64::from(*visited) <= plan.longest_walk()));
        let unseen = lights.chunks_exact(CULL_TEXELS as usize).filter(|light| light[2][0] > light[2][1]).count();
        assert_eq!(walks.iter().map(|(found, _)| found.len()).sum::<usize>(), count as usize - unseen);
    }

    #[test]
    fn c8_every_light_is_in_one_leaf_and_is_found() {
        for count in [0, 1, 7, 8, 9, 33, 64, 65, 512, 4097] {
            judge(&random(count, 40 + u64::from(count)), 120);
        }
        judge(&at_one_place(5000), 60);
        judge(&random(100_000, 99), 36);
    }

    #[test]
    fn a_box_that_loses_its_light_is_found() {
        let lights = random(300, 5);
        let plan = LightTree::new(&lights, &Limits::UNLIMITED).expect("nothing limits it");
        let mut texels = twin::build(&plan.shape, &lights);
        let asked = queries(&plan, &lights);
        let misses = |texels: &[[f32; 4]]| missed(&Tree::new(texels).expect("a header"), 1, &asked, &lights);
        assert_eq!(misses(&texels), 0);
        // The high corner of the root, pulled in by half the box.
        let root = TREE_HEADER_TEXELS + TREE_ENTRY_TEXELS * plan.shape.everywhere_count;
        texels[root as usize + 1][0] -= 20.0;
        assert!(misses(&texels) > 0);
    }
}
