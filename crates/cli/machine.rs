//! Resources of the machine: threads, memory and processor time.

mod control_groups;

use std::path::Path;

/// Returns the number of worker threads: the requested count, else the batch scheduler's allotment, else the system's.
pub fn threads(asked: Option<u32>) -> usize {
    let allotted = || std::env::var("SLURM_CPUS_PER_TASK").ok()?.trim().parse::<usize>().ok();
    let granted = || std::thread::available_parallelism().map_or(1, usize::from);
    asked
        .map(|n| n as usize)
        .or_else(|| allotted().filter(|n| (1..=1024).contains(n)))
        .unwrap_or_else(granted)
}

/// Returns the memory still available to this process, in bytes: the minimum over the machine, its control groups
/// (containers, batch jobs) and the limits of the process. `None` where the system does not report it (read from
/// Linux).
pub fn free_memory_bytes() -> Option<u64> {
    let machine = kilobytes("/proc/meminfo", "MemAvailable:");
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    machine
        .into_iter()
        .chain(control_groups::free(&groups, Path::new("/sys/fs/cgroup")))
        .chain(unlimited())
        .min()
}

/// Returns what the limits of address space and data (`ulimit -v`, `ulimit -d`) leave to this process.
fn unlimited() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let left = |name: &str, held: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
        Some(limit.saturating_sub(kilobytes("/proc/self/status", held)?))
    };
    let all = [left("Max address space", "VmSize:"), left("Max data size", "VmData:")];
    all.into_iter().flatten().min()
}

/// Returns the peak memory use of this process, in bytes; 0 where the system does not report it (read from Linux).
pub fn peak_memory_bytes() -> u64 {
    kilobytes("/proc/self/status", "VmHWM:").unwrap_or(0)
}

/// Returns the current memory use of this process, in bytes; 0 where the system does not report it (read from Linux).
pub fn resident_memory_bytes() -> u64 {
    kilobytes("/proc/self/status", "VmRSS:").unwrap_or(0)
}

/// Returns the total memory of the machine, in bytes; 0 where the system does not report it (read from Linux).
pub fn memory_bytes() -> u64 {
    kilobytes("/proc/meminfo", "MemTotal:").unwrap_or(0)
}

/// Returns the name of the processor; "unknown processor" where the system does not report it (read from Linux).
pub fn cpu() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| "unknown processor".into(), |(_, name)| name.trim().into())
}

/// Returns the processor seconds of all threads of this process; 0 where the system does not report them (other than
/// Unix).
#[cfg(all(unix, feature = "report"))]
pub fn cpu_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Returns the processor seconds of all threads of this process; 0 where the system does not report them (other than
/// Unix).
#[cfg(not(all(unix, feature = "report")))]
pub fn cpu_seconds() -> f64 {
    0.0
}

/// Returns the processor seconds of all finished child processes and their descendants, in steps of 1/100 s; 0 where
/// the system does not report them (read from Linux).
pub fn children_cpu_seconds() -> f64 {
    // After the name in parentheses: user and system time of children waited for are fields 16 and 17, in 1/100 s.
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(13).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Returns the value of a line such as `VmHWM:  1234 kB`, in bytes.
fn kilobytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(value.trim().trim_end_matches("kB").trim().parse::<u64>().ok()? * 1024)
}
