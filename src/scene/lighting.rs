//! Lights made ready for shading: one falloff, one window, a finite range each (DESIGN.md, section 5).
//!
//! The irradiance factor of a light at distance `d` is `window(d) / max(c + l d + q d^2, MIN_FALLOFF)`, with
//! `window(d) = max(1 - (d / range)^4, 0)` (KHR_lights_punctual, "range property"), so it is exactly 0 from the range on.
//! The physical law is c = l = 0, q = 1.

use glam::{DVec3, Vec3};

use super::{Light, LightKind, Scene};
use crate::error::{Error, Result};

/// Smallest denominator of the falloff: a surface that touches a light stays finite.
pub const MIN_FALLOFF: f64 = 1e-8;

/// 5/256, the least step of a display that is still seen, as the classic tutorials choose it.
pub const DEFAULT_CUTOFF: f64 = 5.0 / 256.0;

/// Illuminance of the default light, which shines where the scene has no light.
pub const DEFAULT_LIGHT_LUX: f32 = 3.0;

/// Distance law of point and spot lights: `1 / (constant + linear d + quadratic d^2)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attenuation {
    /// 1
    pub constant: f64,
    /// 1/m
    pub linear: f64,
    /// 1/m^2
    pub quadratic: f64,
}

impl Attenuation {
    /// Inverse square.
    pub const PHYSICAL: Self = Self { constant: 0.0, linear: 0.0, quadratic: 1.0 };

    /// Distance at which `intensity` has fallen to `cutoff`: 0 where it is below it from the start, infinite where it
    /// never falls. The root of the quadratic is taken in the form that does not cancel.
    pub fn solve_range(&self, intensity: f64, cutoff: f64) -> f64 {
        if cutoff <= 0.0 {
            return if intensity > 0.0 { f64::INFINITY } else { 0.0 };
        }
        // q d^2 + l d = intensity / cutoff - c
        let target = intensity / cutoff - self.constant;
        if target.is_nan() || target <= 0.0 {
            return 0.0;
        }
        if target == f64::INFINITY {
            return f64::INFINITY;
        }
        // hypot: squares of the terms may pass f64 although the root does not.
        let half = 0.5 * self.linear;
        let denominator = half + half.hypot(self.quadratic.sqrt() * target.sqrt());
        if denominator > 0.0 { target / denominator } else { f64::INFINITY }
    }

    /// `1 / max(c + l d + q d^2, MIN_FALLOFF)`.
    pub fn falloff(&self, d: f64) -> f64 {
        1.0 / (self.constant + d * (self.linear + d * self.quadratic)).max(MIN_FALLOFF)
    }
}

/// How a light without a range of its own gets one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RangeRule {
    /// Solved from this cut-off (same unit as intensity over distance squared).
    Cutoff(f64),
    /// Every light gets this range in metres, its own or not.
    Fixed(f64),
    /// Range and window are lifted for every light.
    Infinite,
}

/// What the command line says about light.
#[derive(Debug, Clone, PartialEq)]
pub struct LightRules {
    /// Radiance from everywhere, linear RGB.
    pub ambient: Vec3,
    /// Distance law of point and spot lights.
    pub attenuation: Attenuation,
    /// Where ranges come from.
    pub range: RangeRule,
    /// Emission lights other surfaces: a scene that emits needs no default light.
    pub emission_lights: bool,
    /// Lights that are off stay in the list, and so do the numbers of those behind them.
    pub keep_absent: bool,
}

/// Metres that an absent light reaches where it is kept.
const ABSENT_RANGE: f64 = 1e-3;

impl Default for LightRules {
    fn default() -> Self {
        Self {
            ambient: Vec3::ZERO,
            attenuation: Attenuation::PHYSICAL,
            range: RangeRule::Cutoff(DEFAULT_CUTOFF),
            emission_lights: false,
            keep_absent: false,
        }
    }
}

/// A light as shading sees it, in f64 and world space; the plan rounds it to view space and f32 for the device.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedLight {
    /// Shape.
    pub kind: LightKind,
    /// Metres.
    pub position: DVec3,
    /// Unit; the way the light shines.
    pub direction: DVec3,
    /// colour x intensity: candela, or lux for a directional light.
    pub intensity: DVec3,
    /// Metres, infinite without a window. Directional: infinite.
    pub range: f64,
    /// Its way to a surface is looked at: the scene asks for it, until the plan has decided which lights have shadows.
    pub shadow: bool,
}

impl ResolvedLight {
    /// Spot factor for the cosine `cd` between the light's axis and the way to the surface: `saturate((cd - cos outer) / max(0.001,
    /// cos inner - cos outer))^2` (KHR_lights_punctual, "Inner and Outer Cone Angles"); 1 for other lights.
    pub fn cone(&self, cd: f64) -> f64 {
        match self.kind {
            LightKind::Spot { inner, outer } => {
                let (cos_inner, cos_outer) = ((inner as f64).cos(), (outer as f64).cos());
                let t = ((cd - cos_outer) / (cos_inner - cos_outer).max(0.001)).clamp(0.0, 1.0);
                t * t
            }
            _ => 1.0,
        }
    }
}

/// Lights of a scene after the rules; absent lights (range 0) are counted, and dropped where the rules do not keep them.
#[derive(Debug, Clone, PartialEq)]
pub struct Lighting {
    /// In light-id order.
    pub lights: Vec<ResolvedLight>,
    /// Linear RGB radiance from everywhere.
    pub ambient: Vec3,
    /// Distance law.
    pub attenuation: Attenuation,
    /// Lights that never rise above the cut-off.
    pub absent: usize,
    /// Lights of infinite range other than directional ones.
    pub unbounded: usize,
    /// True when the default light was put in, because the scene has no light.
    pub default_light: bool,
}

impl Lighting {
    /// Applies `rules` to the scene's lights.
    ///
    /// # Errors
    /// A rule that is negative or not a number; [`Scene::validate`] has seen to the lights themselves.
    pub fn new(scene: &Scene, rules: &LightRules) -> Result<Self> {
        check_rules(rules)?;
        // Emission lights nothing but itself while no bounced light is drawn.
        let emits = rules.emission_lights && scene.materials.iter().any(|material| material.emissive != [0.0; 3]);
        let default_light = scene.lights.is_empty() && rules.ambient == Vec3::ZERO && !emits;
        let mut own = Vec::new();
        if default_light {
            own.push(Light {
                name: "default light".into(),
                kind: LightKind::Directional,
                color: [1.0; 3],
                intensity: DEFAULT_LIGHT_LUX,
                position: DVec3::ZERO,
                direction: DVec3::new(-0.4, -1.0, -0.6).normalize(),
                range: None,
                shadow: false,
            });
        }
        let mut lighting = Self {
            lights: Vec::with_capacity(scene.lights.len() + own.len()),
            ambient: rules.ambient,
            attenuation: rules.attenuation,
            absent: 0,
            unbounded: 0,
            default_light,
        };
        for light in scene.lights.iter().chain(&own) {
            let intensity = DVec3::from_array(light.color.map(|c| c as f64)) * light.intensity as f64;
            let directional = light.kind == LightKind::Directional;
            let range = match (directional, rules.range, light.range) {
                (true, ..) | (_, RangeRule::Infinite, _) => f64::INFINITY,
                (_, RangeRule::Fixed(range), _) => range,
                (_, RangeRule::Cutoff(_), Some(range)) => range as f64,
                (_, RangeRule::Cutoff(cutoff), None) => rules.attenuation.solve_range(intensity.max_element(), cutoff),
            };
            let absent = range <= 0.0 || intensity.max_element() <= 0.0;
            lighting.absent += usize::from(absent);
            if absent && !rules.keep_absent {
                continue;
            }
            let (range, intensity) =
                if absent { (if directional { range } else { ABSENT_RANGE }, DVec3::ZERO) } else { (range, intensity) };
            lighting.unbounded += usize::from(!directional && range.is_infinite());
            lighting.lights.push(ResolvedLight {
                kind: light.kind,
                position: light.position,
                direction: light.direction,
                intensity,
                range,
                shadow: light.shadow,
            });
        }
        Ok(lighting)
    }
}

impl Lighting {
    /// Lights in the order of ids: directional ones first, so that techniques which add them with the ambient term keep the order.
    pub fn in_table_order(&self) -> impl Iterator<Item = &ResolvedLight> {
        let of = |directional: bool| move |l: &&ResolvedLight| (l.kind == LightKind::Directional) == directional;
        self.lights.iter().filter(of(true)).chain(self.lights.iter().filter(of(false)))
    }
}

fn check_rules(rules: &LightRules) -> Result<()> {
    let good = |x: f64| x.is_finite() && x >= 0.0;
    if !rules.ambient.is_finite() || rules.ambient.min_element() < 0.0 {
        return Err(Error::usage(format!("--ambient {} is not a non-negative colour", rules.ambient)));
    }
    let a = rules.attenuation;
    if ![a.constant, a.linear, a.quadratic].into_iter().all(good) || a.constant + a.linear + a.quadratic <= 0.0 {
        return Err(Error::usage(format!(
            "--attenuation {},{},{} must be non-negative and not all 0",
            a.constant, a.linear, a.quadratic
        )));
    }
    match rules.range {
        RangeRule::Cutoff(x) if !good(x) => {
            Err(Error::usage(format!("--light-cutoff {x} is not a non-negative number")))
        }
        RangeRule::Fixed(x) if !(x.is_finite() && x > 0.0) => {
            Err(Error::usage(format!("--light-range {x} is not a positive distance in metres")))
        }
        _ => Ok(()),
    }
}
