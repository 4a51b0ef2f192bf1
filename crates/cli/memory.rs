//! Memory limit of a command: that of `--memory-limit`, else the free memory of the machine or its container.

use crate::machine;
use dapple_integrator::imaging::MemoryLimit;

/// Returns the limit for data that is read; `asked` is the value of `--memory-limit`.
pub fn limit(asked: Option<u64>) -> MemoryLimit {
    match asked {
        Some(bytes) => MemoryLimit::asked(bytes),
        None => MemoryLimit::free(machine::free_memory_bytes().unwrap_or(UNKNOWN)),
    }
}

/// Returns the limit for memory in addition to what the process already uses.
pub fn left(asked: Option<u64>) -> MemoryLimit {
    match asked {
        Some(bytes) => MemoryLimit::asked(bytes).less(machine::resident_memory_bytes()),
        None => limit(None),
    }
}

/// Assumed free memory where the system does not report it: 16 GiB.
const UNKNOWN: u64 = 1 << 34;
