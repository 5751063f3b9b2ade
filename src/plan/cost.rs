//! `auto`: a cost model of every technique, and the choice of the cheapest that the limits allow.
//!
//! With P pixels, N lights seen, A the pixels of all their rectangles, T tests of a light against a tile and L pairs of listed light and
//! pixel, in the profile's terms and without what all share:
//!
//! - forward: `N P test`
//! - tiled: `lists + P bounds + T cull + L pair`
//! - clustered: `lists + clusters + P cluster + T cull + L/2 pair`
//! - deferred ones: `P gbuffer`, and their own price of a pair; volumes: `N volume + A volume_pixel + R volume_pair`,
//!   with R the pairs that reach
//!
//! L is not known before depths are. A light's rectangle is known; of its pixels those count whose surface lies at the light's depth, and
//! for want of depths they are taken to lie anywhere in the scene's depth range alike. Tiles list three times what reaches
//! (docs/ACCURACY.md, waste), clusters half of that.

use glam::DVec3;

use super::profile::Profile;
use super::projection;
use super::request::{DeferredLights, Technique};
use super::{Limits, Request};
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::View;
use crate::scene::{LightKind, Scene};

/// Listed over reaching pairs of tiles with depth bounds.
const TILE_WASTE: f64 = 3.0;
/// Clusters list this share of what tiles do.
const CLUSTER_SHARE: f64 = 0.5;
/// Mean chord of a sphere over its radius, and the share of a rectangle that its disc covers.
const MEAN_CHORD: f64 = 4.0 / 3.0;
const DISC: f64 = std::f64::consts::FRAC_PI_4;

/// A technique whose picture is not forward's bit for bit has to be cheaper by this factor.
const INEXACT_FACTOR: f64 = 1.1;

fn draws_exactly(technique: Technique) -> bool {
    matches!(technique, Technique::Forward | Technique::TiledForward | Technique::ClusteredForward)
}

/// What a picture's lights come to before anything is drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Load {
    /// Pixels.
    pub pixels: f64,
    /// Lights that every pixel adds: directional ones.
    pub everywhere: f64,
    /// Other lights that can be seen.
    pub seen: f64,
    /// Every light, seen or not.
    pub lights: f64,
    /// Pixels of all rectangles.
    pub covered: f64,
    /// Tests of a light against a tile.
    pub tests: f64,
    /// Pairs of light and pixel that reach, as estimated.
    pub pairs: f64,
    /// A thread of tiled-deferred may shade four pixels.
    pub shares: bool,
}

impl Load {
    /// Of the lights as `view` sees them.
    pub fn new(scene: &Scene, lighting: &Lighting, view: &View, tile: u32) -> Self {
        let pixels = f64::from(view.width) * f64::from(view.height);
        let mut load = Self { pixels, lights: lighting.lights.len() as f64, shares: true, ..Self::default() };
        let depth = depth_range(scene, view);
        for light in &lighting.lights {
            load.add(light, view, f64::from(tile), depth);
        }
        load
    }

    /// What a listed light costs a pixel of tiled-deferred.
    fn tile_pair(&self, profile: &Profile) -> f64 {
        if self.shares { profile.deferred_pair.min(profile.shared_pair) } else { profile.deferred_pair }
    }

    fn add(&mut self, light: &ResolvedLight, view: &View, tile: f64, [near, far]: [f64; 2]) {
        if light.kind == LightKind::Directional {
            self.everywhere += 1.0;
            return;
        }
        let center = view.world_to_view.transform_point3(light.position);
        let Some(rect) = projection::tangent_rectangle(center, light.range, view) else { return };
        let area = f64::from(rect.x[1] - rect.x[0]) * f64::from(rect.y[1] - rect.y[0]);
        // Culling tests whole bins.
        let bin = tile * f64::from(crate::shared::BIN_TILES);
        let bins = |side: [f32; 2]| f64::from(side[1] - side[0]) / bin + 1.0;
        let at_depth = (light.range * MEAN_CHORD / (far - near).max(1e-9)).min(1.0);
        self.seen += 1.0;
        self.covered += area * DISC;
        self.tests += bins(rect.x) * bins(rect.y) * f64::from(crate::shared::BIN_TILES.pow(2));
        self.pairs += area * DISC * at_depth;
    }
}

/// Nearest and farthest that the scene reaches in front of the eye, metres.
fn depth_range(scene: &Scene, view: &View) -> [f64; 2] {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return [0.0, 1.0];
    }
    let corner = |i: usize| {
        let pick = |bit: usize, axis: usize| if i & bit == 0 { bounds.min[axis] } else { bounds.max[axis] };
        -view.world_to_view.transform_point3(DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2))).z
    };
    let depths = (0..8).map(corner);
    let (near, far) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    [near.max(view.znear), far.max(view.znear)]
}

/// Estimated milliseconds of a technique, beyond what every technique takes.
pub fn estimate(profile: &Profile, load: &Load, technique: Technique) -> f64 {
    let p = profile;
    let listed = load.pairs * TILE_WASTE;
    let lists = p.lists_ms * 1e6 + load.pixels * p.bounds.min(p.group_bounds) + load.tests * p.cull;
    let clusters = p.clusters_ms * 1e6 + load.pixels * p.cluster;
    let everywhere = load.everywhere * load.pixels;
    let forward = |pairs: f64| (pairs + everywhere) * p.pair;
    let deferred = |pairs: f64, pair: f64| pairs * pair + everywhere * p.deferred_pair + load.pixels * p.gbuffer;
    let nanoseconds = match technique {
        Technique::Forward => (load.lights - load.everywhere) * load.pixels * p.test + forward(load.pairs),
        Technique::TiledForward => lists + forward(listed),
        Technique::TiledDeferred => lists + deferred(listed, load.tile_pair(p)),
        Technique::ClusteredForward => lists + clusters + forward(listed * CLUSTER_SHARE),
        Technique::ClusteredDeferred => lists + clusters + deferred(listed * CLUSTER_SHARE, p.deferred_pair),
        Technique::Deferred => {
            load.seen * p.volume
                + load.covered * p.volume_pixel
                + load.pairs * p.volume_pair
                + deferred(0.0, p.deferred_pair)
        }
        Technique::Auto | Technique::Reference => f64::INFINITY,
    };
    nanoseconds * 1e-6
}

/// Why `taken`: its estimate beside those of the others, and whose numbers they are.
pub fn why(profile: &Profile, ranked: &[(Technique, f64)], taken: Technique) -> String {
    let all: Vec<_> = ranked.iter().map(|(t, ms)| format!("{} {ms:.1}", t.name())).collect();
    let taken = taken.name();
    if ranked.len() == 1 {
        return format!("auto took {taken}: an option asks for it");
    }
    format!("auto took {taken}: estimated ms for lights are {} ({})", all.join(", "), profile.source)
}

/// Techniques that `auto` may take for a request, best first, with their estimates in milliseconds.
pub fn ranked(profile: &Profile, load: &Load, request: &Request, limits: &Limits) -> Vec<(Technique, f64)> {
    let load = &Load { shares: load.shares && request.may_share_lights(), ..*load };
    // Options that one technique alone takes ask for it.
    let only = match request {
        Request { cluster_normals: true, .. } => Some(Technique::ClusteredDeferred),
        Request { pixels_a_thread: Some(_), .. } => Some(Technique::TiledDeferred),
        _ => None,
    };
    if let Some(only) = only {
        return vec![(only, estimate(profile, load, only))];
    }
    let mut techniques = vec![Technique::Forward, Technique::TiledForward, Technique::ClusteredForward];
    // Without a pre-pass the deferred ones have no depth bounds.
    if request.prepass {
        techniques.extend([Technique::TiledDeferred, Technique::ClusteredDeferred]);
        if limits.float_blend && request.deferred_lights == DeferredLights::Volumes {
            techniques.push(Technique::Deferred);
        }
    }
    let mut ranked: Vec<_> = techniques.into_iter().map(|t| (t, estimate(profile, load, t))).collect();
    // A compact G-buffer rounds surfaces: it has to be worth it.
    let rank = |t: &(Technique, f64)| if draws_exactly(t.0) { t.1 } else { t.1 * INEXACT_FACTOR };
    ranked.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    ranked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::lighting::{LightRules, RangeRule};
    use crate::scene::{builtin, scatter};

    fn first(lights: usize, range: f64) -> Technique {
        let mut scene = builtin::load("atrium").expect("a built-in scene");
        scene.lights = scatter::point_lights(&scene.bounds(), lights, 1);
        let rules = LightRules { range: RangeRule::Fixed(range), ..LightRules::default() };
        let lighting = Lighting::new(&scene, &rules).expect("rules");
        let view = View::new(&scene.cameras[0], 1280, 720).expect("a view");
        let load = Load::new(&scene, &lighting, &view, 16);
        let limits = Limits { float_blend: true, ..Limits::MINIMUM };
        ranked(&Profile::lavapipe(), &load, &Request::default(), &limits)[0].0
    }

    #[test]
    fn few_lights_need_no_lists_and_many_do() {
        assert_eq!(first(1, 1.0), Technique::Forward);
        assert_eq!(first(1024, 1.0), Technique::TiledForward);
        assert!(matches!(first(65_536, 1.0), Technique::TiledDeferred | Technique::ClusteredDeferred));
    }

    #[test]
    fn more_of_anything_never_costs_less() {
        let profile = Profile::lavapipe();
        let less = Load {
            pixels: 1e5,
            everywhere: 1.0,
            seen: 10.0,
            lights: 12.0,
            covered: 1e5,
            tests: 1e3,
            pairs: 1e5,
            shares: true,
        };
        let more = Load { pairs: 2e5, tests: 2e3, covered: 3e5, seen: 20.0, lights: 30.0, ..less };
        for technique in [Technique::Forward, Technique::TiledForward, Technique::ClusteredForward, Technique::Deferred]
        {
            assert!(estimate(&profile, &more, technique) > estimate(&profile, &less, technique), "{technique:?}");
        }
    }
}
