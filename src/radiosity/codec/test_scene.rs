//! What tests encode: form factors of the inside of a box with a block in it, random numbers, and how far a product is off.

use super::{Coded, bounces};

/// Numbers that look random (G. Marsaglia, "Xorshift RNGs", 2003, the 64-bit generator with shifts 13, 7 and 17).
pub struct Xorshift(u64);

impl Xorshift {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn between(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|k| b[k] - a[k])
}

/// A patch of the scene.
struct Patch {
    center: Vector,
    normal: Vector,
    area: f64,
    reflectance: [f32; 3],
}

/// Form factors and what they act on.
pub struct Scene {
    pub n: usize,
    pub factors: Vec<f32>,
    pub reflectance: Vec<[f32; 3]>,
    /// Exitance of the patches by direct light: six set-ups.
    pub lights: Vec<Vec<[f32; 3]>>,
}

const LOW: Vector = [0.35, 0.3, 0.0];
const HIGH: Vector = [0.65, 0.55, 0.45];

/// A segment meets the block in the box.
fn blocked(a: Vector, b: Vector) -> bool {
    let (mut from, mut to) = (1e-6, 1.0 - 1e-6);
    for k in 0..3 {
        let step = b[k] - a[k];
        let [near, far] = [LOW[k] + 1e-6, HIGH[k] - 1e-6].map(|plane| (plane - a[k]) / step);
        if step.abs() < 1e-12 {
            if a[k] <= LOW[k] + 1e-6 || a[k] >= HIGH[k] - 1e-6 {
                return false;
            }
        } else {
            (from, to) = (f64::max(from, near.min(far)), f64::min(to, near.max(far)));
        }
    }
    from < to
}

/// Patches of one side of an axis-aligned box, `across` along each edge; `inward` is the sign of the normal on the low side.
fn side(
    low: Vector,
    high: Vector,
    [axis, upper]: [usize; 2],
    inward: f64,
    across: usize,
    color: [f32; 3],
    to: &mut Vec<Patch>,
) {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    for row in 0..across {
        for column in 0..across {
            let mut center = [0.0; 3];
            center[axis] = if upper == 1 { high[axis] } else { low[axis] };
            center[u] = low[u] + (high[u] - low[u]) * (row as f64 + 0.5) / across as f64;
            center[v] = low[v] + (high[v] - low[v]) * (column as f64 + 0.5) / across as f64;
            let mut normal = [0.0; 3];
            normal[axis] = if upper == 1 { -inward } else { inward };
            let area = (high[u] - low[u]) * (high[v] - low[v]) / (across * across) as f64;
            to.push(Patch { center, normal, area, reflectance: color });
        }
    }
}

/// The scene with 6 x `walls`^2 patches inside of a unit box and 5 x `block`^2 on a block in it.
pub fn scene(walls: usize, block: usize) -> Scene {
    let white = [0.75, 0.73, 0.7];
    let mut patches = Vec::new();
    for axis in 0..3 {
        for upper in 0..2 {
            let color = match (axis, upper) {
                (0, 0) => [0.63, 0.06, 0.05],
                (0, 1) => [0.12, 0.48, 0.1],
                _ => white,
            };
            side([0.0; 3], [1.0; 3], [axis, upper], 1.0, walls, color, &mut patches);
        }
    }
    for (axis, upper) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 1)] {
        side(LOW, HIGH, [axis, upper], -1.0, block, [0.35, 0.4, 0.7], &mut patches);
    }
    let n = patches.len();
    let mut exchange = vec![0.0f64; n * n];
    for i in 0..n {
        for j in 0..i {
            let way = between(patches[i].center, patches[j].center);
            let cosines = dot(way, patches[i].normal).max(0.0) * (-dot(way, patches[j].normal)).max(0.0);
            if cosines > 0.0 && !blocked(patches[i].center, patches[j].center) {
                // Softened by the area, so that patches that touch have no pole.
                let squared = dot(way, way) + 0.25 * (patches[i].area * patches[j].area).sqrt();
                let value = cosines / dot(way, way) * dot(way, way) / (std::f64::consts::PI * squared * squared);
                exchange[i * n + j] = value * patches[i].area * patches[j].area;
                exchange[j * n + i] = exchange[i * n + j];
            }
        }
    }
    let mut scales = vec![1.0f64; n];
    for _ in 0..30 {
        let sums: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| exchange[i * n + j] * scales[j]).sum::<f64>() * scales[i] / patches[i].area)
            .collect();
        scales.iter_mut().zip(sums).filter(|(_, sum)| *sum > 0.0).for_each(|(scale, sum)| *scale /= sum.sqrt());
    }
    let factor = |at: usize| (exchange[at] * scales[at / n] * scales[at % n] / patches[at / n].area) as f32;
    let lamps =
        [[0.5, 0.5, 0.95], [0.1, 0.1, 0.9], [0.9, 0.2, 0.2], [0.2, 0.85, 0.5], [0.8, 0.8, 0.8], [0.15, 0.5, 0.15]];
    let lights = lamps.iter().enumerate().map(|(k, lamp)| {
        let direct = |patch: &Patch| {
            let way = between(patch.center, *lamp);
            let cosine = dot(way, patch.normal).max(0.0);
            let open = cosine > 0.0 && !blocked(patch.center, *lamp);
            let share = if open { cosine / dot(way, way).powf(1.5) } else { 0.0 } as f32;
            [0, 1, 2].map(|c| patch.reflectance[c] * share * if c == k % 3 { 1.0 } else { 0.8 })
        };
        patches.iter().map(direct).collect()
    });
    let lights = lights.collect();
    let factors = (0..n * n).map(factor).collect();
    Scene { n, factors, reflectance: patches.iter().map(|patch| patch.reflectance).collect(), lights }
}

impl Scene {
    pub fn polynomial(&self, k: u32) -> [Vec<f32>; 3] {
        bounces::polynomial(&self.factors, self.n, &self.reflectance, k).unwrap()
    }

    pub fn resolvent(&self) -> [Vec<f32>; 3] {
        bounces::resolvent(&self.factors, self.n, &self.reflectance).unwrap()
    }
}

/// The product in f64.
pub fn exact(n: usize, operator: &[Vec<f32>; 3], x: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let sum = |i: usize, c: usize| (0..n).map(|j| f64::from(operator[c][i * n + j]) * f64::from(x[j][c])).sum();
    (0..n).map(|i| [0, 1, 2].map(|c| sum(i, c))).collect()
}

/// Relative L2 distance.
pub fn relative(product: &[[f64; 3]], wanted: &[[f64; 3]]) -> f64 {
    let squared = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let off = squared(&mut product.iter().flatten().zip(wanted.iter().flatten()).map(|(a, b)| a - b));
    (off / squared(&mut wanted.iter().flatten().copied())).sqrt()
}

/// Mean relative L2 error of products over light set-ups, against the operator in f64.
pub fn error(coded: &dyn Coded, operator: &[Vec<f32>; 3], lights: &[Vec<[f32; 3]>]) -> f64 {
    let of = |x: &Vec<[f32; 3]>| {
        let product: Vec<[f64; 3]> = coded.product(x, 1).into_iter().map(|y| y.map(f64::from)).collect();
        relative(&product, &exact(coded.side(), operator, x))
    };
    lights.iter().map(of).sum::<f64>() / lights.len() as f64
}

/// Every element by itself and by its row are the same, and a product is the sum that the module's head describes.
pub fn check_decoding(coded: &dyn Coded) {
    let n = coded.side();
    let mut random = Xorshift::new(n as u64);
    let x: Vec<[f32; 3]> = (0..n).map(|_| [0; 3].map(|_| random.unit() as f32)).collect();
    let product = coded.product(&x, 1);
    assert_eq!(product.len(), n);
    for i in 0..n {
        let row = coded.decode_row(i);
        assert_eq!(row.len(), n);
        let mut sum = [0.0f64; 3];
        for (j, element) in row.iter().enumerate() {
            assert_eq!(coded.decode_element(i, j), *element, "{i} {j}");
            (0..3).for_each(|c| sum[c] += f64::from(element[c]) * f64::from(x[j][c]));
        }
        for c in 0..3 {
            assert!((f64::from(product[i][c]) - sum[c]).abs() <= 1e-5 * sum[c].abs() + 1e-30, "{i} {c}: {product:?}");
        }
    }
    assert!(coded.decode_row(n).is_empty());
    assert_eq!(coded.decode_element(n, 0), [0.0; 3]);
    assert_eq!(coded.product(&[], 1), vec![[0.0; 3]; n]);
    let mut longer = x.clone();
    longer.push([1.0; 3]);
    assert_eq!(coded.product(&longer, 1), product);
}

/// Three channels alike but for a factor.
pub fn scaled(values: &[f32], factors: [f32; 3]) -> [Vec<f32>; 3] {
    factors.map(|factor| values.iter().map(|x| x * factor).collect())
}
