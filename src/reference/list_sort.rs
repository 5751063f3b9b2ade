//! CPU twin of `glsl/bvh/list_sort.comp` and `list_merge.comp`: the same runs, the same merges.

use crate::shared::{LIST_INSERTION, LIST_SORT_RUN};

/// Sorts each list ascending: list l is `lists[offsets[l * stride]..offsets[(l + 1) * stride]]`. Gives the iterations of the thread that
/// takes most.
pub fn run(offsets: &[u32], stride: usize, lists: &mut [u32]) -> u64 {
    let begins: Vec<usize> = offsets.iter().step_by(stride.max(1)).map(|&offset| offset as usize).collect();
    let mut most = 0;
    for range in begins.windows(2) {
        let list = &mut lists[range[0]..range[1]];
        for run in list.chunks_mut(LIST_SORT_RUN as usize) {
            let iterations = if run.len() <= LIST_INSERTION as usize { insertion_sort(run) } else { heap_sort(run) };
            most = most.max(iterations);
        }
        let mut width = LIST_SORT_RUN as usize;
        while width < list.len() {
            let merged: Vec<u32> = list.chunks(2 * width).flat_map(|pair| merge(pair, width)).collect();
            most = most.max(list.len().min(2 * width) as u64);
            list.copy_from_slice(&merged);
            width *= 2;
        }
    }
    most
}

fn insertion_sort(run: &mut [u32]) -> u64 {
    let mut iterations = 2 * run.len() as u64;
    for i in 0..run.len() {
        let (item, mut at) = (run[i], i);
        while at > 0 && run[at - 1] > item {
            run[at] = run[at - 1];
            at -= 1;
            iterations += 1;
        }
        run[at] = item;
    }
    iterations
}

/// Lets the item at `at` sink until no child is larger.
fn sink(heap: &mut [u32], mut at: usize) -> u64 {
    let (item, mut iterations) = (heap[at], 0);
    while 2 * at + 1 < heap.len() {
        iterations += 1;
        let mut child = 2 * at + 1;
        if child + 1 < heap.len() && heap[child + 1] > heap[child] {
            child += 1;
        }
        if heap[child] <= item {
            break;
        }
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = item;
    iterations
}

fn heap_sort(run: &mut [u32]) -> u64 {
    let mut iterations = 0;
    for at in (0..run.len() / 2).rev() {
        iterations += 1 + sink(run, at);
    }
    for last in (1..run.len()).rev() {
        run.swap(0, last);
        iterations += 1 + sink(&mut run[..last], 0);
    }
    iterations
}

/// The two sorted runs of a pair as one.
fn merge(pair: &[u32], width: usize) -> Vec<u32> {
    let middle = width.min(pair.len());
    let (mut left, mut right) = (0, middle);
    let take = |_| {
        let from_left = right >= pair.len() || (left < middle && pair[left] <= pair[right]);
        let next = if from_left { &mut left } else { &mut right };
        *next += 1;
        pair[*next - 1]
    };
    (0..pair.len()).map(take).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    #[test]
    fn equals_the_sort_of_the_standard_library() {
        let mut random = Random::new(21);
        let lengths = [0, 1, 2, 31, 32, 33, 64, 2047, 2048, 2049, 4096, 4097, 8192, 8193, 20_000, 3, 0];
        let mut offsets = vec![0u32];
        let mut lists = Vec::new();
        for length in lengths {
            lists.extend((0..length).map(|_| (random.next_u64() >> 50) as u32));
            // Stride 2: a list of two stretches.
            offsets.push(lists.len() as u32 - length / 3);
            offsets.push(lists.len() as u32);
        }
        let mut wanted = lists.clone();
        for range in offsets.iter().step_by(2).collect::<Vec<_>>().windows(2) {
            wanted[*range[0] as usize..*range[1] as usize].sort_unstable();
        }
        run(&offsets, 2, &mut lists);
        assert_eq!(lists, wanted);
    }

    #[test]
    fn no_order_takes_more_iterations_than_the_plan_counts() {
        let mut random = Random::new(22);
        let length = LIST_SORT_RUN;
        let orders: [&mut dyn FnMut(u32) -> u32; 5] =
            [&mut |i| i, &mut |i| length - i, &mut |_| 7, &mut |i| i ^ 1, &mut |_| random.next_u64() as u32];
        for order in orders {
            let mut list: Vec<u32> = (0..length).map(order).collect();
            let iterations = run(&[0, length], 1, &mut list);
            assert!(list.is_sorted() && iterations <= u64::from(length) * (11 + 3), "{iterations}");
        }
        let mut backwards: Vec<u32> = (0..LIST_INSERTION).rev().collect();
        assert!(run(&[0, LIST_INSERTION], 1, &mut backwards) < 1000);
    }
}
