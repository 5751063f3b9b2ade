//! The steps of Chebyshev's iteration as the device makes them, bit for bit: the twin of `patch_gather`.

use super::bake::Operator;

/// Irradiance of each patch after all `steps` (share of the residual, weight of the change), from what patches send at `first` (exitance). `areas` and
/// `reflectance` as the device has them; `lanes` threads add each row.
pub fn gathered(
    operator: &Operator,
    areas: &[f32],
    reflectance: &[[f32; 3]],
    first: &[[f32; 3]],
    steps: &[[f32; 2]],
    lanes: usize,
) -> Vec<[f32; 3]> {
    gathered_each(operator, [areas, reflectance.as_flattened()], first, steps, lanes, &mut |_| {})
}

/// The same, and `each` is told of the irradiance after every step. `patches` are areas, and reflectance channel by channel.
pub fn gathered_each(
    operator: &Operator,
    [areas, reflectance]: [&[f32]; 2],
    first: &[[f32; 3]],
    steps: &[[f32; 2]],
    lanes: usize,
    each: &mut dyn FnMut(&[[f32; 3]]),
) -> Vec<[f32; 3]> {
    if let Operator::Summed(summed) = operator {
        let irradiance = summed.product(first, lanes);
        each(&irradiance);
        return irradiance;
    }
    let count = areas.len();
    let (mut irradiance, mut previous) = (vec![[0f32; 3]; count], vec![[0f32; 3]; count]);
    let mut sent: Vec<[f32; 3]> = (0..count).map(|i| first[i].map(|x| x * areas[i])).collect();
    for [share, weight] in steps {
        let sums = operator.product(&sent, lanes);
        let next: Vec<[f32; 3]> = (0..count)
            .map(|i| {
                std::array::from_fn(|c| {
                    let (now, before) = (irradiance[i][c], previous[i][c]);
                    let correction = share * (sums[i][c] - now);
                    weight * ((now - before) + correction) + before
                })
            })
            .collect();
        sent = (0..count)
            .map(|i| std::array::from_fn(|c| (first[i][c] + reflectance[3 * i + c] * next[i][c]) * areas[i]))
            .collect();
        previous = irradiance;
        irradiance = next;
        each(&irradiance);
    }
    irradiance
}
