//! Many coloured point lights at random places of a scene, for `--lights N --light-seed S`.

use glam::DVec3;

use super::lighting::DEFAULT_CUTOFF;
use super::{Bounds, Light, LightKind};
use crate::math::random::Random;

/// Part of the box left free at each side, so that no light sits in an outer wall.
const MARGIN: f64 = 0.02;

/// Lights that reach an average point of the box: a ball of radius r holds 4.19 r^3, and r^3 = volume * 8 / count.
const CUBES_PER_LIGHT: f64 = 8.0;

/// `count` point lights, uniform in `bounds`. Places and colours depend on `bounds` and `seed` alone: the first lights of a
/// longer list are those of a shorter one. The intensity shrinks with the count so that about as many lights reach each
/// point whatever the count is; `range` is left to the cut-off. An empty box counts as 1 m around the origin.
pub fn point_lights(bounds: &Bounds, count: usize, seed: u64) -> Vec<Light> {
    let bounds = if bounds.is_empty() { Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE } } else { *bounds };
    let intensity = intensity(&bounds, count);
    let extent = bounds.max - bounds.min;
    let (low, high) = (bounds.min + extent * MARGIN, bounds.max - extent * MARGIN);
    let mut random = Random::new(seed);
    (0..count)
        .map(|index| {
            let x = random.range(low.x, high.x);
            let y = random.range(low.y, high.y);
            let z = random.range(low.z, high.z);
            let hue = random.range(0.0, 6.0);
            let saturation = random.range(0.6, 1.0);
            Light {
                name: format!("light {index}"),
                kind: LightKind::Point,
                color: color(hue, saturation),
                intensity,
                position: DVec3::new(x, y, z),
                direction: DVec3::NEG_Z,
                range: None,
                shadow: false,
            }
        })
        .collect()
}

/// Candela at which the range solved from the default cut-off is the one meant for `count` lights.
fn intensity(bounds: &Bounds, count: usize) -> f32 {
    let extent = bounds.max - bounds.min;
    // A box of one point still gets lights that shine.
    let diagonal = extent.length().max(1e-3);
    // A flat box has no volume; lights near a plane still reach into the space around it.
    let extent = extent.max(DVec3::splat(diagonal * 0.05));
    let volume = extent.x * extent.y * extent.z;
    let range = (volume * CUBES_PER_LIGHT / count.max(1) as f64).cbrt().min(diagonal / 4.0);
    (range * range * DEFAULT_CUTOFF) as f32
}

/// Linear RGB of a hue in [0, 6] (0 red, 2 green, 4 blue): largest component 1, smallest `1 - saturation`.
fn color(hue: f64, saturation: f64) -> [f32; 3] {
    [0.0, 4.0, 2.0].map(|shift| {
        let distance = (hue + shift).rem_euclid(6.0) - 3.0;
        let pure = (distance.abs() - 1.0).clamp(0.0, 1.0);
        (1.0 - saturation * (1.0 - pure)) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::lighting::Attenuation;

    const BOX: Bounds = Bounds { min: DVec3::new(-10.0, 0.0, -5.0), max: DVec3::new(10.0, 8.0, 5.0) };

    #[test]
    fn hues_are_the_primaries_and_keep_their_largest_component() {
        assert_eq!(color(0.0, 1.0), [1.0, 0.0, 0.0]);
        assert_eq!(color(2.0, 1.0), [0.0, 1.0, 0.0]);
        assert_eq!(color(4.0, 1.0), [0.0, 0.0, 1.0]);
        for step in 0..60 {
            let c = color(step as f64 * 0.1, 0.7);
            assert!((c.into_iter().fold(0.0, f32::max) - 1.0).abs() < 1e-6, "{c:?}");
            assert!((c.into_iter().fold(1.0, f32::min) - 0.3).abs() < 1e-6, "{c:?}");
        }
    }

    #[test]
    fn lights_stay_inside_and_only_intensity_depends_on_the_count() {
        let (few, many) = (point_lights(&BOX, 50, 9), point_lights(&BOX, 400, 9));
        assert_eq!((few.len(), many.len()), (50, 400));
        for (a, b) in few.iter().zip(&many) {
            assert_eq!((a.position, a.color, &a.name), (b.position, b.color, &b.name));
            assert!(a.position.cmpgt(BOX.min).all() && a.position.cmplt(BOX.max).all());
            assert!(a.intensity > b.intensity);
        }
        assert_ne!(few[0].position, point_lights(&BOX, 50, 10)[0].position);
    }

    #[test]
    fn solved_range_follows_the_cube_root_of_the_count_and_stops_at_a_quarter_of_the_diagonal() {
        let range = |count| {
            let light = &point_lights(&BOX, count, 1)[0];
            Attenuation::PHYSICAL.solve_range(light.intensity as f64, DEFAULT_CUTOFF)
        };
        let expected = (1600.0f64 * 8.0 / 1000.0).cbrt();
        assert!((range(1000) / expected - 1.0).abs() < 1e-6, "{}", range(1000));
        assert!((range(8000) * 2.0 / expected - 1.0).abs() < 1e-6);
        let quarter = (BOX.max - BOX.min).length() / 4.0;
        assert!((range(1) / quarter - 1.0).abs() < 1e-6, "{}", range(1));
    }

    #[test]
    fn odd_boxes_give_finite_lights_that_shine() {
        let point = Bounds { min: DVec3::ONE, max: DVec3::ONE };
        let flat = Bounds { min: DVec3::new(-5.0, 1.0, -5.0), max: DVec3::new(5.0, 1.0, 5.0) };
        for bounds in [Bounds::EMPTY, point, flat] {
            for light in point_lights(&bounds, 20, 0) {
                assert!(light.position.is_finite() && light.intensity > 0.0 && light.intensity.is_finite());
            }
        }
        assert!(point_lights(&BOX, 0, 0).is_empty());
    }
}
