//! Texture samplers: wrap modes, interpolation, and the texels used for a coordinate.

/// The continuation of the texture outside [0, 1), per axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture is repeated.
    #[default]
    Repeat,
    /// The texture is repeated, with every other copy mirrored.
    Mirror,
    /// The nearest edge texel is used.
    Clamp,
}

/// The interpolation of values between texel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The texel that covers the point.
    Nearest,
    /// Bilinear interpolation between the four nearest centres.
    #[default]
    Linear,
}

/// The parameters of a texture lookup.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// The wrap mode outside [0, 1) along u.
    pub wrap_s: Wrap,
    /// The wrap mode outside [0, 1) along v.
    pub wrap_t: Wrap,
    /// The interpolation between texel centres.
    pub interpolation: Interpolation,
}

/// c − ⌊c⌋, in [0, 1]: 1 only by rounding, for c just below an integer. From 2²³ on, every float is an integer; NaN and
/// ±∞ are treated as integers too. `floor` is not used because it is a library call on baseline x86-64.
#[inline]
fn fract(c: f32) -> f32 {
    if c.abs() < 8_388_608.0 {
        let f = c - (c as i32) as f32;
        if f < 0.0 { f + 1.0 } else { f }
    } else {
        0.0
    }
}

/// Maps a coordinate to [0, 1].
#[inline]
fn wrapped(wrap: Wrap, c: f32) -> f32 {
    match wrap {
        Wrap::Repeat => fract(c),
        Wrap::Mirror => {
            let twice = 2.0 * fract(0.5 * c);
            if twice > 1.0 { 2.0 - twice } else { twice }
        }
        // `max` before `min` maps NaN to 0.
        #[allow(clippy::manual_clamp)]
        Wrap::Clamp => c.max(0.0).min(1.0),
    }
}

/// The index of the texel that covers a coordinate, among `n`.
#[inline]
pub(super) fn nearest(wrap: Wrap, c: f32, n: usize) -> usize {
    ((wrapped(wrap, c) * n as f32) as i32 as usize).min(n - 1)
}

/// The two texels whose centres enclose a coordinate, and the relative position between them, in [0, 1).
#[inline]
pub(super) fn span(wrap: Wrap, c: f32, n: usize) -> (usize, usize, f32) {
    // Adding ½ instead of subtracting it keeps the number positive, so that truncation is equal to floor; `cell` is the
    // index of the upper neighbour, between 0 and n.
    let x = wrapped(wrap, c) * n as f32 + 0.5;
    let cell = x as i32;
    let t = x - cell as f32;
    let cell = (cell as usize).min(n);
    let (before, after) = if wrap == Wrap::Repeat { (n - 1, 0) } else { (0, n - 1) };
    (if cell == 0 { before } else { cell - 1 }, if cell == n { after } else { cell }, t)
}
