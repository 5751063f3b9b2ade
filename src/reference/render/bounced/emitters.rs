//! Triangles that emit, drawn by how much.

use std::collections::HashMap;

use glam::DVec3;

use super::super::Reference;
use crate::math::random::Random;
use crate::scene::AlphaMode;

/// Triangles that emit.
pub(super) struct Emitters {
    /// Sums of weights up to and including each, and its triangle.
    sums: Vec<(f64, u32)>,
    /// Probability by area, per square metre, by triangle.
    densities: HashMap<u32, f64>,
}

impl Emitters {
    /// All of a scene, by area times the largest component of the factor: a texture may emit less.
    pub fn new(reference: &Reference) -> Self {
        let mut sums = Vec::new();
        let mut densities = HashMap::new();
        let mut sum = 0.0;
        for (triangle, owner) in reference.owners.iter().enumerate() {
            let instance = &reference.scene.instances[owner.instance as usize];
            let material = &reference.scene.materials[reference.scene.meshes[instance.mesh].material];
            let factor = material.emissive.into_iter().fold(0.0f32, f32::max);
            if factor <= 0.0 || material.alpha == AlphaMode::Blend || material.unlit {
                continue;
            }
            let triangle = triangle as u32;
            let [a, b, c] = reference.bvh.corners(triangle);
            let area = (*b - *a).cross(*c - *a).length() * 0.5;
            // What has no area is not in the hierarchy either.
            if area > 0.0 && area.is_finite() {
                sum += area * f64::from(factor);
                sums.push((sum, triangle));
                densities.insert(triangle, f64::from(factor));
            }
        }
        densities.values_mut().for_each(|density| *density /= sum);
        Self { sums, densities }
    }

    /// A triangle and barycentric weights of a place on it; `None` where nothing emits.
    pub fn draw(&self, random: &mut Random) -> Option<(u32, DVec3)> {
        let whole = self.sums.last()?.0;
        let wanted = random.unit_f64() * whole;
        let at = self.sums.partition_point(|(sum, _)| *sum <= wanted).min(self.sums.len() - 1);
        // A square folded onto the triangle.
        let (root, across) = (random.unit_f64().sqrt(), random.unit_f64());
        Some((self.sums[at].1, DVec3::new(1.0 - root, root * (1.0 - across), root * across)))
    }

    /// Probability by area with which places of the triangle are drawn, per square metre.
    pub fn density(&self, triangle: u32) -> f64 {
        self.densities.get(&triangle).copied().unwrap_or(0.0)
    }
}
