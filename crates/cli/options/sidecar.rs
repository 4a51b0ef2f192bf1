//! Record of the options that the settings file beside a scene (the sidecar) set.

use std::path::PathBuf;

/// Options that a sidecar set and no later layer of settings replaced.
#[derive(Clone, Debug, Default)]
pub struct OfScene {
    pub file: PathBuf,
    pub command: String,
    pub keys: Vec<String>,
}

impl OfScene {
    /// Whether the value of this option comes from the sidecar.
    pub fn set(&self, key: &str) -> bool {
        self.keys.iter().any(|set| set == key)
    }
}
