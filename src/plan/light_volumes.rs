//! Light volumes: where each light is added over the G-buffer. A light that is seen has the mesh around its sphere or, where a mesh is not
//! safe, a rectangle of the screen; one that is not seen has neither. Of a mesh the back faces are drawn, and a pixel is shaded where
//! the back face is not nearer than what is stored. No stencil and no depth clamp.
//!
//! Why a mesh adds its light to every pixel that the light reaches, and to each once:
//!
//! 1. Let P be the position that is shaded, within the light's range. P lies in the padded sphere (tiles.rs), that in the mesh, and the mesh
//!    is convex and closed: the ray from the eye leaves it once behind P, through a back face. So it is with the eye outside, in a face or
//!    inside; front faces, of which an eye inside sees none, are not needed. Where the whole mesh lies before P the depth test fails.
//! 2. The near plane clips back faces before it. All that is seen there lies behind the plane, so behind the face: outside of the mesh.
//! 3. Rounding of centre, radius, corner and transform, and the lerp that clips, move a vertex by less than 2^-20 of `size`, the
//!    largest coordinate. A mesh is used where that is at most 1/8 of a pixel at `nearest`, the nearest distance that is left of it. Snapping to
//!    the rasteriser's grid (subPixelPrecisionBits is at least 4) adds 1/32: a vertex is off by e < 0.16 pixels.
//! 4. That moves the rim by e, and may turn round faces that are less than 2 e high on the screen, so that pixels there are covered twice or
//!    not at all. A face of inradius R is at least 0.48 R high and reaches 0.39 R from its middle: a ray through such a face passes the centre at R -
//!    1.6 e or more. R is half a pixel larger than the padded sphere, at the mesh's farthest distance; 2.6 e is less, so all of this
//!    happens where the light is exactly 0.
//! 5. Depth itself: stored depth is off by DEPTH_SLACK (tiles.rs, 2^-20), the face's interpolation by 2^-21 of depths up to 1, its
//!    transform by 2^-22 while the far plane is at least twice as far as the near plane. The vertex shader takes 2^-19 from it. Orthographic:
//!    2^-23 of (far + size) / (far - near), which has to be at most 64, and the shader takes 2^-16.
//! 6. What would then be behind the far plane would be clipped. A depth clamp would keep it but give up the near plane, and with it the bound
//!    of 5. A light that reaches so far has a rectangle.
//!
//! Lights of infinite range have the rectangle of the whole picture, in their place in the order. A rectangle is not tested against
//! depth.

use glam::DVec3;

use super::{Limits, projection, tiles};
use crate::error::{Error, Result};
use crate::math::icosphere::CIRCUMRADIUS;
use crate::scene::LightKind;
use crate::scene::lighting::{Lighting, ResolvedLight};
use crate::scene::view::{Lens, View};
use crate::shared::{ICOSPHERE_CORNERS, LightVolume, VOLUME_DEPTH_SLACK, VOLUME_LINEAR_SLACK};

/// `size` over a pixel's size at `nearest`, at most: 2^20 / 8.
const MOST_PIXELS: f64 = 131_072.0;

/// (far + size) / (far - near) of an orthographic lens, at most.
const MOST_DEPTHS: f64 = 64.0;

/// Volumes that are drawn by one call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Rectangles instead of meshes.
    pub rectangles: bool,
    /// First volume.
    pub first: u32,
    /// Volumes.
    pub count: u32,
}

/// What is drawn to add lights, in the order of ids.
#[derive(Debug, Clone, Default)]
pub struct LightVolumes {
    /// For the device.
    pub volumes: Vec<LightVolume>,
    /// Neighbours of one kind.
    pub runs: Vec<Run>,
    /// Lights that are not seen.
    pub unseen: u32,
}

impl LightVolumes {
    /// Decides for every light but directional ones. No geometry is farther than `extent` metres from the eye.
    ///
    /// # Errors
    /// More lights than a storage buffer binds.
    pub fn new(lighting: &Lighting, view: &View, extent: f64, limits: &Limits) -> Result<Self> {
        let mut found = Self::default();
        for (id, light) in lighting.in_table_order().enumerate() {
            if light.kind != LightKind::Directional {
                found.push(id as u32, light, view, extent);
            }
        }
        let (bytes, most) = (size_of_val(found.volumes.as_slice()) as u64, limits.max_storage_bytes);
        if bytes > most {
            let count = found.volumes.len();
            return Err(Error::new(format!(
                "{count} light volumes need {bytes} bytes, this device binds at most {most} at once"
            )));
        }
        Ok(found)
    }

    fn push(&mut self, light: u32, resolved: &ResolvedLight, view: &View, extent: f64) {
        let center = view.world_to_view.transform_point3(resolved.position);
        let radius = tiles::padded_radius(center, resolved.range, extent);
        let seen = projection::distance_range(center, radius, view)
            .and_then(|_| projection::tangent_rectangle(center, radius, view));
        let Some(rectangle) = seen else {
            self.unseen += 1;
            return;
        };
        let inscribed = inscribed_radius(center, radius, view);
        let place = match inscribed {
            Some(inscribed) => center.as_vec3().extend((inscribed as f32).next_up()).to_array(),
            None => {
                let (width, height) = (view.width, view.height);
                let [x0, x1, y0, y1] = projection::rectangle_tiles(&rectangle, 1, width, height);
                let clip = |pixel: u32, size: u32| (2.0 * f64::from(pixel) / f64::from(size) - 1.0) as f32;
                [clip(x0, width), clip(y0, height), clip(x1 + 1, width), clip(y1 + 1, height)]
            }
        };
        let rectangles = inscribed.is_none();
        match self.runs.last_mut().filter(|run| run.rectangles == rectangles) {
            Some(run) => run.count += 1,
            None => self.runs.push(Run { rectangles, first: self.volumes.len() as u32, count: 1 }),
        }
        self.volumes.push(LightVolume { place, light });
    }

    /// Bytes of the buffers that are made for them.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.volumes.as_slice()) as u64 + u64::from(ICOSPHERE_CORNERS) * 16
    }

    pub(super) fn why(&self) -> String {
        let of =
            |rectangles: bool| self.runs.iter().filter(|r| r.rectangles == rectangles).map(|r| r.count).sum::<u32>();
        format!(
            "{} meshes and {} rectangles in {} draws, {} lights are not seen",
            of(false),
            of(true),
            self.runs.len(),
            self.unseen
        )
    }
}

/// Radius of the sphere in the mesh of a light whose light ends within `radius` of `center` (view space); `None` where a mesh is not safe.
fn inscribed_radius(center: DVec3, radius: f64, view: &View) -> Option<f64> {
    let pixel = view.image_point(1.0, 1.0) - view.image_point(0.0, 0.0);
    let (half_pixel, finest) = (0.5 * pixel.length(), pixel.abs().min_element());
    let clip = view.view_to_clip();
    // Depth is offset / distance - scale, or offset - scale * distance.
    let (scale, offset) = (clip.z_axis.z, clip.w_axis.z);
    let ahead = -center.z;
    let (inscribed, safe) = match view.lens {
        Lens::Perspective(_) => {
            // The farthest point is at `ahead` and a circumradius, where half a pixel is half_pixel times that.
            let growth = half_pixel * CIRCUMRADIUS;
            let inscribed = (radius + half_pixel * ahead.max(0.0)) / (1.0 - growth);
            let reach = inscribed * CIRCUMRADIUS;
            let nearest = (ahead - reach).max(view.znear);
            let size = center.length() + reach;
            let last_depth = offset / (ahead + reach) - scale;
            let deep = scale <= 1.0 && last_depth >= 2.0 * f64::from(VOLUME_DEPTH_SLACK);
            (inscribed, growth < 0.5 && deep && size <= MOST_PIXELS * finest * nearest)
        }
        Lens::Orthographic(_) => {
            let inscribed = radius + half_pixel;
            let reach = inscribed * CIRCUMRADIUS;
            let size = center.length() + reach;
            let last_depth = offset - scale * (ahead + reach);
            let deep = (offset / scale).abs() + size <= MOST_DEPTHS / scale
                && last_depth >= 2.0 * f64::from(VOLUME_LINEAR_SLACK);
            (inscribed, deep && size <= MOST_PIXELS * finest)
        }
    };
    (safe && inscribed.is_finite()).then_some(inscribed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::icosphere;
    use crate::math::random::Random;
    use crate::scene::lighting::{LightRules, RangeRule};
    use crate::scene::{Camera, Light, Projection, Scene};

    fn camera(projection: Projection) -> Camera {
        Camera { projection, ..Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 1.0) }
    }

    fn perspective(zfar: Option<f64>) -> View {
        let projection = Projection::Perspective { yfov: 1.0, aspect: None, znear: 0.05, zfar };
        View::new(&camera(projection), 320, 180).expect("a view")
    }

    fn orthographic() -> View {
        let projection = Projection::Orthographic { xmag: -8.0, ymag: 4.5, znear: -1.0, zfar: 60.0 };
        View::new(&camera(projection), 320, 180).expect("a view")
    }

    fn light(position: DVec3, range: Option<f32>) -> Light {
        Light {
            name: "light".into(),
            kind: LightKind::Point,
            color: [1.0; 3],
            intensity: 1.0,
            position,
            direction: DVec3::NEG_Z,
            range,
            shadow: false,
        }
    }

    fn volumes(lights: Vec<Light>, view: &View, rules: &LightRules) -> LightVolumes {
        let scene = Scene { lights, ..Scene::default() };
        let lighting = Lighting::new(&scene, rules).expect("rules");
        LightVolumes::new(&lighting, view, 100.0, &Limits::MINIMUM).expect("volumes")
    }

    #[test]
    fn runs_keep_the_order_and_skip_what_is_not_seen() {
        let lights = vec![
            light(DVec3::new(0.0, 0.0, -5.0), Some(1.0)),
            light(DVec3::new(0.0, 0.0, 5.0), Some(1.0)),
            light(DVec3::new(1.0, 0.0, -5.0), Some(1.0)),
            light(DVec3::new(0.0, 0.0, -5.0), Some(5000.0)),
            light(DVec3::new(0.0, 0.0, -0.1), Some(0.5)),
        ];
        let found = volumes(lights, &perspective(None), &LightRules::default());
        let ids: Vec<_> = found.volumes.iter().map(|v| v.light).collect();
        assert_eq!((ids.as_slice(), found.unseen), ([0, 2, 3, 4].as_slice(), 1));
        let run = |rectangles, first, count| Run { rectangles, first, count };
        assert_eq!(found.runs, [run(false, 0, 2), run(true, 2, 1), run(false, 3, 1)]);
        assert_eq!(found.volumes[2].place, [-1.0, -1.0, 1.0, 1.0]);
    }

    #[test]
    fn lights_that_reach_the_far_plane_or_have_no_range_get_rectangles() {
        let at = |z| light(DVec3::new(0.0, 0.0, z), Some(1.0));
        let found = volumes(vec![at(-10.0), at(-19.5), at(-22.0)], &perspective(Some(20.0)), &LightRules::default());
        assert_eq!((found.runs.len(), found.runs[1].rectangles, found.unseen), (2, true, 1));
        let rules = LightRules { range: RangeRule::Infinite, ..LightRules::default() };
        let found = volumes(vec![at(-10.0)], &perspective(None), &rules);
        assert_eq!(found.volumes[0].place, [-1.0, -1.0, 1.0, 1.0]);
        assert!(found.runs[0].rectangles);
    }

    /// Along the way from the eye through a point of the sphere: where it leaves the mesh.
    fn leaves_at(origin: DVec3, direction: DVec3, volume: &LightVolume) -> Option<f64> {
        let [x, y, z, scale] = volume.place.map(f64::from);
        let center = DVec3::new(x, y, z);
        let corner = |c: [f32; 4]| center + DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2])) * scale;
        let mut left = Vec::new();
        for triangle in icosphere::corners().chunks_exact(3) {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(corner);
            let normal = (b - a).cross(c - a);
            let t = (a - origin).dot(normal) / direction.dot(normal);
            let at = origin + direction * t;
            let inside = [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| (q - p).cross(at - p).dot(normal) >= 0.0);
            if direction.dot(normal) > 0.0 && inside {
                left.push(t);
            }
        }
        left.into_iter().reduce(f64::max)
    }

    #[test]
    fn meshes_reach_half_a_pixel_past_every_lit_point() {
        let mut random = Random::new(11);
        for view in [perspective(None), perspective(Some(80.0)), orthographic()] {
            let mut meshes = 0;
            for _ in 0..60 {
                let position = DVec3::new(random.range(-6.0, 6.0), random.range(-4.0, 4.0), random.range(-40.0, 0.5));
                let range = random.range(0.05, 3.0);
                let found = volumes(vec![light(position, Some(range as f32))], &view, &LightRules::default());
                let Some(volume) = found.volumes.first().filter(|_| !found.runs[0].rectangles) else { continue };
                meshes += 1;
                for _ in 0..20 {
                    let way = DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0));
                    let point = position + way.normalize_or_zero() * range;
                    if -point.z < view.znear {
                        continue;
                    }
                    // Half a pixel to any side of the point's own ray.
                    let pixel = view.image_point(1.0, 1.0) - view.image_point(0.0, 0.0);
                    let off = DVec3::new(pixel.x * random.range(-0.35, 0.35), pixel.y * random.range(-0.35, 0.35), 0.0);
                    let (origin, direction) = if view.lens.is_perspective() {
                        (DVec3::ZERO, point / -point.z + off)
                    } else {
                        (DVec3::new(point.x, point.y, 0.0) + off, DVec3::NEG_Z)
                    };
                    let left = leaves_at(origin, direction, volume);
                    assert!(left.is_some_and(|t| t >= -point.z), "{position} {range}: {left:?}, point at {}", -point.z);
                }
            }
            assert!(meshes > 20, "{meshes} meshes");
        }
    }
}
