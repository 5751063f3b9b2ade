//! Samples of a pixel.

/// Where the samples of a pixel lie, in 16ths of its width and height from its upper left corner: the standard locations (Vulkan 1.3,
/// "Multisampling").
pub fn locations(samples: u32) -> &'static [[u32; 2]] {
    match samples {
        2 => &[[12, 12], [4, 4]],
        4 => &[[6, 2], [14, 6], [2, 10], [10, 14]],
        8 => &[[9, 5], [7, 11], [13, 9], [5, 3], [3, 13], [1, 7], [11, 15], [15, 1]],
        _ => &[[8, 8]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations_are_distinct_and_their_mean_is_the_middle() {
        for count in [1, 2, 4, 8] {
            let places = locations(count);
            assert_eq!(places.len(), count as usize);
            let sum = |axis: usize| places.iter().map(|place| place[axis]).sum::<u32>();
            assert_eq!([sum(0), sum(1)], [8 * count; 2]);
            assert!(places.iter().enumerate().all(|(i, place)| !places[..i].contains(place)));
        }
    }
}
