//! Named random decisions of a path.
//!
//! This table is fixed like a file format: replay and the merging of sample ranges rely on it. New decisions get new
//! numbers (below 256); numbers are never reused. Omitting a decision does not change
//! the other random numbers, because each is keyed by name.
//!
//! | number | decision | dims | depth |
//! |---|---|---|---|
//! | 0, 1, 2 | pixel, lens, time | 2, 2, 1 | 0 |
//! | 3, 4 | lobe, direction | 1, 2 | vertex |
//! | 5, 6 | light choice, light point | 1, 2 | vertex |
//! | 7 | roulette | 1 | vertex |
//! | 8, 9 | alpha met by the path ray, by the shadow ray | hash | vertex |
//! | 10 | environment direction of a diffuse lobe that is not sampled for paths | 2 | vertex |

/// Version of the table; renders must share it to be merged.
pub const LAYOUT: u32 = 1;

/// One named decision at one depth (0 = the camera and the first hit).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Dimension {
    /// Position within the pixel filter (2-D, depth 0).
    Pixel = 0,
    /// Position on the lens (2-D, depth 0).
    Lens = 1,
    /// Time within the shutter interval (1-D, depth 0).
    Time = 2,
    /// Choice of the scattering lobe (1-D).
    Lobe = 3,
    /// Direction sampled from that lobe (2-D).
    Direction = 4,
    /// Choice of the light (1-D).
    Light = 5,
    /// Position on the light (2-D).
    LightPoint = 6,
    /// Whether the path survives Russian roulette (1-D).
    Roulette = 7,
    /// Alpha test of the path ray (hash).
    Alpha = 8,
    /// Alpha test of the shadow ray (hash).
    ShadowAlpha = 9,
    /// Environment direction of a diffuse lobe that is not sampled for paths (2-D).
    Sky = 10,
}

impl From<Dimension> for u32 {
    fn from(dimension: Dimension) -> Self {
        dimension as Self
    }
}
