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

/// The most memory this process ever held, in bytes; 0 where the system does not say (it is read from Linux).
pub fn peak_memory_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|l| l.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}
