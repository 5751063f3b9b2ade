//! Sorting many lists of u32, each ascending: rounds, scratch space and limits.

use super::Limits;
use crate::error::{Error, Result};
use crate::shared::LIST_SORT_RUN;

/// Lists that lie behind each other in one buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ListSort {
    /// Lists.
    pub list_count: u32,
    /// Offsets from the beginning of one list to that of the next: list l goes from `offsets[l * stride]` to
    /// `offsets[(l + 1) * stride]`.
    pub stride: u32,
    /// Entries of all lists, at most.
    pub entry_count: u64,
    /// Entries of the longest list, at most; what is longer stays unsorted.
    pub longest: u32,
}

/// A round merges four neighbouring runs into one, by pairs: into the scratch space and back.
const ROUND_SHIFT: u32 = 2;

/// Iterations of one thread that sorts a run of n = 2^11 entries on a heap: n / 2 items sink while it is built, n steps together; then n
/// items sink through 10 levels at most.
const RUN_ITERATIONS: u64 = LIST_SORT_RUN as u64 * (11 + 3);

impl ListSort {
    /// Whether a device can sort them.
    ///
    /// # Errors
    /// A list longer than its loops go round, or more entries than it binds.
    pub fn check(&self, limits: &Limits) -> Result<()> {
        let longest = u64::from(self.longest);
        let iterations = if longest <= u64::from(LIST_SORT_RUN) { 0 } else { longest }.max(RUN_ITERATIONS);
        if iterations >= u64::from(limits.max_loop_iterations) {
            return Err(Error::new(format!(
                "sorting a list of {longest} lights takes {iterations} iterations; this driver leaves its loops after {}",
                limits.max_loop_iterations
            )));
        }
        let (bytes, most) = (self.entry_count * 4, limits.max_storage_bytes.min(limits.max_buffer_bytes));
        if bytes > most {
            return Err(Error::new(format!(
                "light lists that are sorted need {bytes} bytes, this device binds at most {most} at once"
            )));
        }
        Ok(())
    }

    /// Rounds of merging after runs are sorted; none where every list is a run.
    pub fn rounds(&self) -> u32 {
        (0..).find(|&round| Self::width(round) >= u64::from(self.longest)).unwrap_or(0)
    }

    /// Entries of the runs that a round begins with.
    pub fn width(round: u32) -> u64 {
        u64::from(LIST_SORT_RUN) << (ROUND_SHIFT * round)
    }

    /// Bytes of the scratch space.
    pub fn bytes(&self) -> u64 {
        if self.rounds() == 0 { 0 } else { self.entry_count.max(1) * 4 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sort(longest: u32) -> ListSort {
        ListSort { list_count: 10, stride: 1, entry_count: 100_000, longest }
    }

    #[test]
    fn rounds_are_those_that_the_longest_list_needs() {
        let cases = [(0, 0), (1, 0), (2048, 0), (2049, 1), (8192, 1), (8193, 2), (32_768, 2), (u32::MAX, 11)];
        for (longest, rounds) in cases {
            assert_eq!(sort(longest).rounds(), rounds, "{longest}");
            assert_eq!(sort(longest).bytes(), if rounds == 0 { 0 } else { 400_000 });
        }
    }

    #[test]
    fn what_loops_do_not_reach_is_refused() {
        let limits = Limits { max_loop_iterations: 65_535, ..Limits::MINIMUM };
        assert!(sort(65_534).check(&limits).is_ok());
        let refused = sort(65_535).check(&limits).expect_err("too long").to_string();
        assert_eq!(
            refused,
            "sorting a list of 65535 lights takes 65535 iterations; this driver leaves its loops after 65535"
        );
        let bytes = ListSort { entry_count: 1 << 40, ..sort(5) };
        assert!(bytes.check(&limits).is_err());
    }
}
