//! What the machine grants and what it gave.

/// Worker threads to use: what was asked for, else what the batch scheduler allotted, else what the system grants.
pub fn threads(asked: Option<u32>) -> usize {
    let allotted = || std::env::var("SLURM_CPUS_PER_TASK").ok()?.trim().parse::<usize>().ok();
    let granted = || std::thread::available_parallelism().map_or(1, usize::from);
    asked
        .map(|n| n as usize)
        .or_else(|| allotted().filter(|n| (1..=1024).contains(n)))
        .unwrap_or_else(granted)
}

/// Memory that can still be had, in bytes; `None` where the system does not say (it is read from Linux).
pub fn available_memory_bytes() -> Option<u64> {
    kilobytes("/proc/meminfo", "MemAvailable:")
}

/// The most memory this process ever held, in bytes; 0 where the system does not say (it is read from Linux).
pub fn peak_memory_bytes() -> u64 {
    kilobytes("/proc/self/status", "VmHWM:").unwrap_or(0)
}

/// The value of a line such as `VmHWM:  1234 kB`, in bytes.
fn kilobytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(value.trim().trim_end_matches("kB").trim().parse::<u64>().ok()? * 1024)
}
