//! Everything that changes the estimate or when it stops.
use dapple_camera::{Filter, PixelRect};
use dapple_sampling::Pattern;
use std::time::Duration;
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    #[default]
    Path,
    Distribution,
}
#[derive(Clone, Debug)]
pub struct Settings {
    pub method: Method,
    pub size: (u32, u32),
    pub crop: Option<PixelRect>,
    /// None: no limit (then `time_limit` must be set).
    pub spp: Option<u32>,
    pub time_limit: Option<Duration>,
    pub pattern: Pattern,
    /// Scattering events: 0 = emitters seen directly, 1 = direct light.
    pub max_bounces: u32,
    pub roulette: bool,
    pub seed: u64,
    /// None: all the system grants.
    pub threads: Option<usize>,
    pub filter: Filter,
    pub aovs: Vec<crate::Aov>,
    pub cull_backfaces: bool,
}
