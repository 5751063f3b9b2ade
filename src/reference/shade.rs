//! Local shading in f64: the definition that the shaders follow, term by term.
//!
//! A light adds `E * max(n . l, 0) * f`, with `E` its intensity times falloff, window and cone (`scene::lighting`)
//! and `f` by the shading model:
//! - Lambert: base / pi.
//! - Phong, with Blinn's half vector h: base + F0 * max(n . h, 0)^s, where F0 is 0.04 blended to the base colour by
//!   metalness and s = clamp(2 / roughness^4 - 2, 1, 1024).
//! - glTF 2.0, appendix B: (1 - F) * base * (1 - metallic) / pi + F * D * V with Schlick's F, the D of Trowbridge and
//!   Reitz and Smith's separable V.
//! - Car paint: glTF, with the base colour mixed from a second one by |n . v|^e.
//! - Rim: glTF, and a second colour times (1 - |n . v|)^e.
//!
//! A material that names a model has that one, whatever the picture has.
//!
//! Lights are added in light-id order, then `ambient * occlusion * base` and the emission. A surface without lighting
//! is its base colour and nothing else.

use std::f64::consts::PI;

use glam::DVec3;

use super::surface::{MIN_ROUGHNESS, Surface};
use crate::scene::LightKind;
use crate::scene::lighting::{Attenuation, Lighting, ResolvedLight};
use crate::scene::shading::{Model, OwnModel, Shading};
use crate::scene::view::View;

/// Least squared distance to a light, in square metres.
const MIN_DISTANCE_SQUARED: f64 = crate::shared::MIN_DISTANCE2 as f64;

/// Reflectance of a dielectric seen head on.
const DIELECTRIC_F0: f64 = 0.04;

/// Lights in view space and the shading model.
#[derive(Debug, Clone)]
pub struct Shader<'a> {
    lights: &'a [ResolvedLight],
    /// Beside `lights`, so that the test that most lights fail reads little memory.
    reach: Vec<Reach>,
    /// Beside `lights`: where each shines to, view space.
    axes: Vec<DVec3>,
    ambient: DVec3,
    attenuation: Attenuation,
    shading: Shading,
    perspective: bool,
}

/// What one light sends to a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sent {
    /// Lux by channel.
    pub irradiance: DVec3,
    /// From the surface to the light, or to where it shines from.
    pub way: DVec3,
    /// The light is at the end of the way, else infinitely far.
    pub ends: bool,
}

#[derive(Debug, Clone, Copy)]
struct Reach {
    /// View space.
    position: DVec3,
    /// Infinite for a directional light.
    range_squared: f64,
}

impl<'a> Shader<'a> {
    /// Brings the lights to view space.
    pub fn new(lighting: &'a Lighting, view: &View, shading: Shading) -> Self {
        let reach = |light: &ResolvedLight| Reach {
            position: view.world_to_view.transform_point3(light.position),
            range_squared: light.range * light.range,
        };
        Self {
            lights: &lighting.lights,
            reach: lighting.lights.iter().map(reach).collect(),
            axes: lighting.lights.iter().map(|light| view.world_to_view.transform_vector3(light.direction)).collect(),
            ambient: lighting.ambient.as_dvec3(),
            attenuation: lighting.attenuation,
            shading,
            perspective: view.lens.is_perspective(),
        }
    }

    /// Linear RGB radiance towards the camera, nits, with nothing in the way of any light.
    pub fn radiance(&self, surface: &Surface) -> DVec3 {
        self.radiance_past(surface, &|_, _| false)
    }

    /// The same where something may stand in the way of lights that have shadows: `blocked` is asked with the way from the surface to a light that
    /// would add something, and whether the light is at the way's end, else infinitely far.
    pub fn radiance_past(&self, surface: &Surface, blocked: &dyn Fn(DVec3, bool) -> bool) -> DVec3 {
        if surface.unlit {
            return surface.base_color;
        }
        let to_viewer = if self.perspective { (-surface.position).normalize_or_zero() } else { DVec3::Z };
        let response = Response::new(surface, to_viewer, self.shading);
        let mut radiance = DVec3::ZERO;
        for (id, reach) in self.reach.iter().enumerate() {
            let to_light = reach.position - surface.position;
            let distance_squared = to_light.length_squared().max(MIN_DISTANCE_SQUARED);
            if distance_squared >= reach.range_squared {
                continue;
            }
            let (l, strength) = self.strength(id, to_light, distance_squared);
            let nl = surface.normal.dot(l);
            let light = &self.lights[id];
            let placed = light.kind != LightKind::Directional;
            let lit = nl > 0.0 && strength > 0.0;
            if lit && !(light.shadow && blocked(if placed { to_light } else { l }, placed)) {
                radiance += self.lights[id].intensity * strength * nl * response.to(l, nl);
            }
        }
        radiance + self.ambient * surface.occlusion * surface.base_color + surface.emissive
    }

    /// What each light sends to a place without anything in its way, of lights that send something: for surfaces that know no direction.
    pub fn sent(&self, position: DVec3, normal: DVec3) -> Vec<Sent> {
        let mut all = Vec::new();
        for (id, reach) in self.reach.iter().enumerate() {
            let to_light = reach.position - position;
            let distance_squared = to_light.length_squared().max(MIN_DISTANCE_SQUARED);
            if distance_squared >= reach.range_squared {
                continue;
            }
            let (l, strength) = self.strength(id, to_light, distance_squared);
            let nl = normal.dot(l);
            if nl > 0.0 && strength > 0.0 {
                let ends = self.lights[id].kind != LightKind::Directional;
                let irradiance = self.lights[id].intensity * strength * nl;
                all.push(Sent { irradiance, way: if ends { to_light } else { l }, ends });
            }
        }
        all
    }

    /// The direction to the light, and what its intensity is multiplied with: falloff, window and cone.
    fn strength(&self, id: usize, to_light: DVec3, distance_squared: f64) -> (DVec3, f64) {
        let light = &self.lights[id];
        if light.kind == LightKind::Directional {
            return (-self.axes[id], 1.0);
        }
        let distance = distance_squared.sqrt();
        let l = to_light / distance;
        let ratio = distance_squared / self.reach[id].range_squared;
        let window = (1.0 - ratio * ratio).max(0.0);
        (l, self.attenuation.falloff(distance) * window * light.cone((-l).dot(self.axes[id])))
    }
}

/// A surface seen from one direction: what does not depend on the light.
struct Response {
    model: Model,
    normal: DVec3,
    to_viewer: DVec3,
    base: DVec3,
    metallic: f64,
    f0: DVec3,
    roughness: f64,
    rim: DVec3,
}

impl Response {
    fn new(surface: &Surface, to_viewer: DVec3, shading: Shading) -> Self {
        let own = surface.model.unwrap_or(OwnModel::of(shading.into()));
        let color = DVec3::from_array(own.color.map(f64::from));
        let facing = surface.normal.dot(to_viewer).abs().min(1.0);
        let base = match own.model {
            Model::CarPaint => color.lerp(surface.base_color, facing.powf(f64::from(own.exponent))),
            _ => surface.base_color,
        };
        let rim = match own.model {
            Model::Rim => color * (1.0 - facing).powf(f64::from(own.exponent)),
            _ => DVec3::ZERO,
        };
        Self {
            model: own.model,
            normal: surface.normal,
            to_viewer,
            base,
            metallic: surface.metallic,
            f0: DVec3::splat(DIELECTRIC_F0).lerp(base, surface.metallic),
            roughness: surface.roughness.clamp(MIN_ROUGHNESS, 1.0),
            rim,
        }
    }

    /// Reflected radiance for an irradiance of 1 from direction `l`, where `nl` is `n . l`, positive.
    fn to(&self, l: DVec3, nl: f64) -> DVec3 {
        let half = (l + self.to_viewer).normalize_or_zero();
        match self.model {
            Model::Lambert => self.base / PI,
            Model::Phong => {
                let exponent = (2.0 / self.roughness.powi(4) - 2.0).clamp(1.0, 1024.0);
                self.base + self.f0 * self.normal.dot(half).max(0.0).powf(exponent)
            }
            Model::Gltf | Model::CarPaint => self.gltf(half, nl),
            Model::Rim => self.gltf(half, nl) + self.rim,
        }
    }

    /// glTF 2.0, appendix B.3.
    fn gltf(&self, half: DVec3, nl: f64) -> DVec3 {
        let alpha = self.roughness * self.roughness;
        let a2 = alpha * alpha;
        let (nh, nv) = (self.normal.dot(half), self.normal.dot(self.to_viewer));
        let vh = self.to_viewer.dot(half).max(0.0);
        let fresnel = self.f0 + (1.0 - self.f0) * (1.0 - vh).powi(5);
        let lobe = nh * nh * (a2 - 1.0) + 1.0;
        let distribution = if nh > 0.0 { a2 / (PI * lobe * lobe) } else { 0.0 };
        let smith = |cosine: f64| (a2 + (1.0 - a2) * cosine * cosine).sqrt();
        let visibility = 1.0 / ((nl + smith(nl)) * (nv.abs() + smith(nv)));
        let diffuse = self.base * (1.0 - self.metallic) / PI;
        (1.0 - fresnel) * diffuse + fresnel * (distribution * visibility)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, Vec3};

    use super::*;
    use crate::scene::{Camera, Projection};

    fn view(camera_to_world: DMat4) -> View {
        let projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0, znear: 0.0, zfar: 100.0 };
        View::new(&Camera { name: "test".into(), camera_to_world, projection }, 8, 8).expect("a good camera")
    }

    fn light(kind: LightKind, position: DVec3, range: f64) -> ResolvedLight {
        ResolvedLight {
            kind,
            position,
            direction: DVec3::NEG_Z,
            intensity: DVec3::new(1.0, 2.0, 4.0),
            range,
            shadow: false,
        }
    }

    fn lighting(lights: Vec<ResolvedLight>) -> Lighting {
        Lighting {
            lights,
            ambient: Vec3::ZERO,
            attenuation: Attenuation::PHYSICAL,
            absent: 0,
            unbounded: 0,
            default_light: false,
        }
    }

    /// Faces the viewer.
    fn surface(metallic: f64, roughness: f64) -> Surface {
        Surface {
            position: DVec3::new(0.0, 0.0, -5.0),
            normal: DVec3::Z,
            base_color: DVec3::splat(0.5),
            alpha: 1.0,
            metallic,
            roughness,
            occlusion: 1.0,
            emissive: DVec3::ZERO,
            unlit: false,
            model: None,
        }
    }

    /// Radiance under a directional light of (1, 2, 4) lux whose direction is `angle` from the normal.
    fn under(angle: f64, surface: &Surface, shading: Shading) -> DVec3 {
        let mut sun = light(LightKind::Directional, DVec3::ZERO, f64::INFINITY);
        sun.direction = -DVec3::new(angle.sin(), 0.0, angle.cos());
        Shader::new(&lighting(vec![sun]), &view(DMat4::IDENTITY), shading).radiance(surface)
    }

    fn near(found: DVec3, expected: DVec3) {
        assert!((found - expected).length() <= 1e-12 * expected.length(), "{found} against {expected}");
    }

    const LUX: DVec3 = DVec3::new(1.0, 2.0, 4.0);

    #[test]
    fn models_equal_hand_computed_values() {
        near(under(0.0, &surface(0.0, 1.0), Shading::Lambert), LUX * 0.5 / PI);
        near(under(PI / 3.0, &surface(0.0, 1.0), Shading::Lambert), LUX * 0.25 / PI);
        // Exponent clamp(2 - 2, 1, 1024) = 1 at n = h; exponent 30 at 30 degrees between n and h.
        near(under(0.0, &surface(0.0, 1.0), Shading::Phong), LUX * 0.54);
        near(under(PI / 3.0, &surface(0.0, 0.5), Shading::Phong), LUX * 0.5 * (0.5 + 0.04 * 0.75f64.powi(15)));
        near(under(PI / 3.0, &surface(1.0, 0.1), Shading::Phong), LUX * 0.5 * (0.5 + 0.5 * 0.75f64.powi(512)));
        // F = F0, D = 1 / pi, V = 1 / 4 head on at roughness 1.
        near(under(0.0, &surface(0.0, 1.0), Shading::Gltf), LUX * (0.96 * 0.5 + 0.01) / PI);
        near(under(0.0, &surface(1.0, 1.0), Shading::Gltf), LUX * 0.125 / PI);
        // Computed term by term in Python at 60 degrees, metallic 0.25, roughness 0.5.
        near(under(PI / 3.0, &surface(0.25, 0.5), Shading::Gltf), LUX * GLTF_60);
    }

    const GLTF_60: f64 = 0.05880336582262311;

    #[test]
    fn materials_own_models_equal_hand_computed_values() {
        let own = |model, exponent| Some(OwnModel { model, color: [0.25, 0.5, 1.0], exponent });
        let with = |model, exponent| Surface { model: own(model, exponent), ..surface(0.0, 1.0) };
        near(under(0.0, &with(Model::Lambert, 1.0), Shading::Gltf), LUX * 0.5 / PI);
        near(under(0.0, &with(Model::Phong, 1.0), Shading::Lambert), LUX * 0.54);
        // Head on paint has its first colour and a rim is dark.
        let plain = under(0.0, &surface(0.0, 1.0), Shading::Gltf);
        near(under(0.0, &with(Model::CarPaint, 2.0), Shading::Lambert), plain);
        near(under(0.0, &with(Model::Rim, 2.0), Shading::Lambert), plain);
        // Tilted by 60 degrees and lit along the normal: |n . v| is 0.5.
        let tilt = DVec3::new((PI / 3.0).sin(), 0.0, 0.5);
        let lit = |at: Surface| under(PI / 3.0, &Surface { normal: tilt, ..at }, Shading::Lambert);
        let shared = |base: DVec3| lit(Surface { base_color: base, ..with(Model::Gltf, 1.0) });
        let second = DVec3::new(0.25, 0.5, 1.0);
        near(lit(with(Model::CarPaint, 2.0)), shared(second * 0.75 + DVec3::splat(0.5) * 0.25));
        near(lit(with(Model::Rim, 2.0)), shared(DVec3::splat(0.5)) + LUX * second * 0.25);
    }

    #[test]
    fn nothing_comes_from_behind() {
        for shading in [Shading::Lambert, Shading::Phong, Shading::Gltf] {
            assert_eq!(under(2.0, &surface(0.5, 0.5), shading), DVec3::ZERO);
        }
    }

    /// A Lambertian sphere of radius r round the origin, a point light at distance D on the axis: at the angle a from
    /// the axis, E = I (D cos a - r) / (D^2 + r^2 - 2 D r cos a)^(3/2).
    #[test]
    fn irradiance_on_a_sphere_is_the_closed_form() {
        let (radius, distance): (f64, f64) = (0.5, 2.0);
        let camera_to_world = DMat4::from_translation(DVec3::new(3.0, -2.0, 9.0)) * DMat4::from_rotation_x(0.3);
        let view = view(camera_to_world);
        let lighting = lighting(vec![light(LightKind::Point, DVec3::Y * distance, f64::INFINITY)]);
        let shader = Shader::new(&lighting, &view, Shading::Lambert);
        for angle in [0.0, 0.2, 0.7, 1.1, 1.3, 1.32, 2.0] {
            let normal = DVec3::new(f64::sin(angle), f64::cos(angle), 0.0);
            let at = Surface {
                position: view.world_to_view.transform_point3(normal * radius),
                normal: view.world_to_view.transform_vector3(normal),
                ..surface(0.0, 1.0)
            };
            let height = (distance * normal.y - radius).max(0.0);
            let apart = distance * distance + radius * radius - 2.0 * distance * radius * normal.y;
            let expected = LUX * height / apart.powf(1.5) * 0.5 / PI;
            assert!((shader.radiance(&at) - expected).length() < 1e-12, "{angle}");
        }
    }

    #[test]
    fn range_and_cone_end_exactly() {
        let lit = |light: ResolvedLight| {
            Shader::new(&lighting(vec![light]), &view(DMat4::IDENTITY), Shading::Lambert).radiance(&surface(0.0, 1.0)).x
        };
        let above = DVec3::new(0.0, 0.0, -3.0);
        assert!((lit(light(LightKind::Point, above, 4.0)) - 0.25 * (1.0 - 0.0625) * 0.5 / PI).abs() < 1e-15);
        assert_eq!(lit(light(LightKind::Point, above, 2.0)), 0.0);
        assert!(lit(light(LightKind::Point, above, 2.0 + 1e-12)) > 0.0);
        let spot = |offset: f64| {
            lit(light(LightKind::Spot { inner: 0.25, outer: 0.5 }, above + DVec3::X * offset, f64::INFINITY))
        };
        assert!((spot(0.0) - 0.25 * 0.5 / PI).abs() < 1e-15);
        // The axis is -z and the surface 2 m below: the cone ends at an offset of 2 tan(0.5).
        let edge = 2.0 * 0.5f64.tan();
        assert!(spot(edge * 0.999) > 0.0);
        assert_eq!(spot(edge * 1.001), 0.0);
    }

    #[test]
    fn a_light_on_the_surface_stays_finite() {
        let at = surface(0.0, 0.5);
        for offset in [DVec3::ZERO, DVec3::Z * 1e-9, DVec3::Z * 1e-5] {
            let lighting = lighting(vec![light(LightKind::Point, at.position + offset, 1.0)]);
            for shading in [Shading::Lambert, Shading::Phong, Shading::Gltf] {
                let radiance = Shader::new(&lighting, &view(DMat4::IDENTITY), shading).radiance(&at);
                assert!(radiance.is_finite() && (offset == DVec3::ZERO) == (radiance == DVec3::ZERO), "{radiance}");
            }
        }
    }

    #[test]
    fn ambient_emission_and_unlit() {
        let mut lighting = lighting(Vec::new());
        lighting.ambient = Vec3::new(1.0, 0.5, 0.25);
        let mut at = Surface { occlusion: 0.5, emissive: DVec3::new(0.0, 1.0, 2.0), ..surface(1.0, 0.5) };
        let shader = Shader::new(&lighting, &view(DMat4::IDENTITY), Shading::default());
        assert_eq!(shader.radiance(&at), DVec3::new(0.25, 1.125, 2.0625));
        at.unlit = true;
        assert_eq!(shader.radiance(&at), at.base_color);
    }
}
