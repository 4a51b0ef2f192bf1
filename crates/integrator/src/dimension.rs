//! The named random decisions of a path.
//!
//! This table is fixed like a file format: replay and the merging of sample ranges rest on it. New decisions get new
//! numbers (below 256: a key packs depth·256 + number); numbers are never reused. A decision left out shifts no other
//! number, because each is keyed by name.
//!
//! | number | decision | dims | depth |
//! |---|---|---|---|
//! | 0, 1, 2 | pixel, lens, time | 2, 2, 1 | 0 |
//! | 3, 4 | lobe, direction | 1, 2 | vertex |
//! | 5, 6 | light choice, light point | 1, 2 | vertex |
//! | 7 | roulette | 1 | vertex |
//! | 8, 9 | alpha met by the path ray, by the shadow ray | hash | vertex |
//! | 10 | environment seen by a diffuse lobe that is not followed | 2 | vertex |

/// Version of the table; part of what two renders must share to be merged.
pub const LAYOUT: u32 = 1;

/// One named decision at one depth (0 = the camera and the first hit).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Dimension {
    /// Place within the pixel's filter (2-D, depth 0).
    Pixel = 0,
    /// Place on the lens (2-D, depth 0).
    Lens = 1,
    /// Instant within the shutter (1-D, depth 0).
    Time = 2,
    /// Which lobe scatters (1-D).
    Lobe = 3,
    /// Where that lobe sends the path (2-D).
    Direction = 4,
    /// Which light is aimed at (1-D).
    Light = 5,
    /// Where on it (2-D).
    LightPoint = 6,
    /// Whether the path goes on (1-D).
    Roulette = 7,
    /// Alpha of what the path ray meets (hash).
    Alpha = 8,
    /// Alpha of what the shadow ray meets (hash).
    ShadowAlpha = 9,
    /// Where a diffuse lobe that is not followed looks for the environment (2-D).
    Sky = 10,
}

impl From<Dimension> for u32 {
    fn from(dimension: Dimension) -> Self {
        dimension as Self
    }
}
