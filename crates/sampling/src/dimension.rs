//! The named random decisions of a path. The numbers are fixed like a file format: replay and merging rest on them.
/// One named decision at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Dimension {
    Pixel = 0,
    Lens = 1,
    Time = 2,
    Lobe = 3,
    Direction = 4,
    LightChoice = 5,
    LightPoint = 6,
    Roulette = 7,
    Alpha = 8,
    ShadowAlpha = 9,
}
