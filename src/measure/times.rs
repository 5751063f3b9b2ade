//! Times of frames and passes: medians, and whether the device's timestamps add up to what the host saw.

use serde::Serialize;

/// Median, smallest and largest of some milliseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Middle value (mean of the two middle ones for even counts).
    pub median: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

impl Spread {
    /// Of any values; zeros for none.
    pub fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        match n {
            0 => Self::default(),
            _ => Self { median: (sorted[(n - 1) / 2] + sorted[n / 2]) * 0.5, min: sorted[0], max: sorted[n - 1] },
        }
    }
}

/// Times of some frames.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameTimes {
    /// Node names in order.
    pub names: Vec<String>,
    /// Wall-clock milliseconds between the ends of consecutive frames.
    pub wall_ms: Vec<f64>,
    /// Device milliseconds by frame and node; empty rows without timestamps.
    pub node_ms: Vec<Vec<f64>>,
}

/// Share of the host's frame time that timestamps may leave unexplained before a report says so.
const UNEXPLAINED: f64 = 0.25;

impl FrameTimes {
    /// Pairs times with node names.
    pub fn new(names: Vec<String>, wall_ms: Vec<f64>, node_ms: Vec<Vec<f64>>) -> Self {
        Self { names, wall_ms, node_ms }
    }

    /// Spread of whole frames.
    pub fn frame(&self) -> Spread {
        Spread::of(&self.wall_ms)
    }

    /// Median of each node, `None` without timestamps.
    pub fn nodes(&self) -> Vec<(String, Option<f64>)> {
        let median = |index: usize| {
            let values: Vec<f64> = self.node_ms.iter().filter_map(|row| row.get(index).copied()).collect();
            (!values.is_empty()).then(|| Spread::of(&values).median)
        };
        self.names.iter().enumerate().map(|(i, name)| (name.clone(), median(i))).collect()
    }

    /// A sentence where the device's timestamps do not add up to the host's time, or are missing.
    pub fn complaint(&self) -> Option<String> {
        if self.names.is_empty() {
            return None;
        }
        let nodes: Option<f64> = self.nodes().into_iter().map(|(_, ms)| ms).sum();
        let frame = self.frame().median;
        match nodes {
            None => Some("this device has no timestamps: passes are not timed, frames are timed by the host".into()),
            Some(sum) if frame > 1.0 && (sum - frame).abs() > UNEXPLAINED * frame => {
                Some(format!("timestamps add up to {sum:.2} ms of a {frame:.2} ms frame: trust the frame"))
            }
            Some(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_even_and_odd_counts() {
        assert_eq!(Spread::of(&[3.0, 1.0, 2.0]), Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(Spread::of(&[4.0, 1.0]).median, 2.5);
        assert_eq!(Spread::of(&[]), Spread::default());
    }

    #[test]
    fn timestamps_that_do_not_add_up_are_said() {
        let times = |node| FrameTimes::new(vec!["a".into()], vec![10.0], vec![vec![node]]);
        assert_eq!(times(9.5).complaint(), None);
        assert!(times(2.0).complaint().is_some_and(|c| c.contains("2.00 ms of a 10.00 ms")));
        assert_eq!(FrameTimes::new(Vec::new(), vec![9.0], vec![Vec::new()]).complaint(), None, "traced on the CPU");
        let none = FrameTimes::new(vec!["a".into()], vec![10.0], vec![vec![]]);
        assert!(none.complaint().is_some_and(|c| c.contains("no timestamps")));
    }
}
