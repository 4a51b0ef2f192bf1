//! What the settings file beside a scene said of the options.

use std::path::PathBuf;

/// What a sidecar set and no later layer of settings did.
#[derive(Clone, Debug, Default)]
pub struct OfScene {
    pub file: PathBuf,
    pub command: String,
    pub keys: Vec<String>,
}

impl OfScene {
    /// Whether the value of this option is the sidecar's.
    pub fn set(&self, key: &str) -> bool {
        self.keys.iter().any(|set| set == key)
    }
}
