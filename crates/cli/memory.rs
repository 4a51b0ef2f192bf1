//! How much memory may a command take? What `--memory-limit` says, else what the machine or its container has free.

use crate::machine;
use dapple_integrator::imaging::MemoryLimit;

/// The limit for what is read: `asked` is the user's own word.
pub fn limit(asked: Option<u64>) -> MemoryLimit {
    match asked {
        Some(bytes) => MemoryLimit::asked(bytes),
        None => MemoryLimit::free(machine::free_memory_bytes().unwrap_or(UNKNOWN)),
    }
}

/// The limit for what is taken beside what the process holds already.
pub fn left(asked: Option<u64>) -> MemoryLimit {
    match asked {
        Some(bytes) => MemoryLimit::asked(bytes).less(machine::resident_memory_bytes()),
        None => limit(None),
    }
}

/// Taken to be free where the system does not say: 16 GiB.
const UNKNOWN: u64 = 1 << 34;
