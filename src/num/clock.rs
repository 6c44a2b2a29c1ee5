//! CPU time and memory of this process, where the system says them (Linux);
//! wall time instead where it does not.

use std::time::Instant;

/// Clock ticks a second in `/proc/self/stat`: 100 on every Linux (USER_HZ).
const TICKS: f64 = 100.0;

/// CPU seconds (user and system, all threads) used so far; `None` where unknown.
/// Resolution 10 ms.
pub fn cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is a name in brackets that may hold blanks.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |index: usize| fields.get(index)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS)
}

/// CPU seconds since `cpu` was read, or wall seconds since `wall` where CPU time is unknown.
pub fn since(cpu: Option<f64>, wall: Instant) -> f64 {
    match (cpu, cpu_seconds()) {
        (Some(before), Some(now)) => now - before,
        _ => wall.elapsed().as_secs_f64(),
    }
}

/// Largest resident memory of this process so far, bytes; `None` where unknown.
pub fn peak_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

/// Resident memory of this process now, bytes; `None` where unknown.
pub fn resident_bytes() -> Option<u64> {
    status_bytes("VmRSS:")
}

fn status_bytes(name: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_does_not_run_backwards() {
        let wall = Instant::now();
        let before = cpu_seconds();
        assert!(since(before, wall) >= 0.0);
        assert!(peak_bytes().is_none_or(|bytes| bytes > 100_000));
    }
}
