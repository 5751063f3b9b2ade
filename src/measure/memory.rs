//! Memory of the process by stage: what the operating system counts as resident, where it says so (Linux).

use serde::Serialize;

/// Growth of the process over one stage of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Stage {
    /// What was done.
    pub name: &'static str,
    /// Bytes by which the resident set grew; negative where it shrank.
    pub bytes: i64,
}

/// Resident bytes stage by stage, and the most there ever were.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct ProcessMemory {
    /// Most resident bytes so far; 0 where the system does not say.
    pub peak_bytes: u64,
    /// Every stage in order; they add up to what is resident at the end.
    pub stages: Vec<Stage>,
    /// What no stage explains: peak less the largest running sum.
    pub unexplained_bytes: u64,
}

/// Field of `/proc/self/status` in bytes.
fn status(field: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    parse(&text, field)
}

fn parse(text: &str, field: &str) -> Option<u64> {
    let line = text.lines().find(|l| l.strip_prefix(field).is_some_and(|rest| rest.starts_with(':')))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib * 1024)
}

impl ProcessMemory {
    /// Ends a stage.
    pub fn stage(&mut self, name: &'static str) {
        let (Some(now), Some(peak)) = (status("VmRSS"), status("VmHWM")) else { return };
        let before: i64 = self.stages.iter().map(|s| s.bytes).sum();
        self.stages.push(Stage { name, bytes: now as i64 - before });
        self.peak_bytes = peak;
        let mut sum = 0;
        let largest = self.stages.iter().map(|s| {
            sum += s.bytes;
            sum
        });
        self.unexplained_bytes = peak.saturating_sub(largest.max().unwrap_or(0).max(0) as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_read_by_their_whole_name() {
        let text = "VmPeak:\t  9 kB\nVmHWM:\t  12 kB\nVmRSS:\t   8 kB\n";
        assert_eq!(parse(text, "VmRSS"), Some(8192));
        assert_eq!(parse(text, "VmHWM"), Some(12288));
        assert_eq!(parse(text, "Vm"), None);
    }

    #[test]
    fn stages_add_up() {
        let mut memory = ProcessMemory::default();
        memory.stage("before");
        let block = vec![1u8; 64 << 20];
        memory.stage("block");
        assert!(block.iter().all(|b| *b == 1));
        if memory.peak_bytes > 0 {
            assert!(memory.stages[1].bytes > 60 << 20, "{memory:?}");
        }
    }
}
