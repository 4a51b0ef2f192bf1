//! How a texture is looked up: which texels a coordinate falls between.

/// What lies outside [0, 1), per axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture again, every other time mirrored.
    Mirror,
    /// The nearest edge texel.
    Clamp,
}

/// How values between texel centres are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The texel that covers the point.
    Nearest,
    /// Bilinear between the four nearest centres.
    #[default]
    Linear,
}

/// How a texture is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// Outside [0, 1) along u.
    pub wrap_s: Wrap,
    /// Outside [0, 1) along v.
    pub wrap_t: Wrap,
    /// Between texel centres.
    pub interpolation: Interpolation,
}

/// c − ⌊c⌋, in [0, 1]: 1 only by rounding, for c just below a whole number. Beyond 2²³ a float is a whole number,
/// and NaN and ±∞ count as one too. No call to `floor`, which is a library call on plain x86-64.
#[inline]
fn fract(c: f32) -> f32 {
    if c.abs() < 8_388_608.0 {
        let f = c - (c as i32) as f32;
        if f < 0.0 { f + 1.0 } else { f }
    } else {
        0.0
    }
}

/// Takes a coordinate to [0, 1].
#[inline]
fn wrapped(wrap: Wrap, c: f32) -> f32 {
    match wrap {
        Wrap::Repeat => fract(c),
        Wrap::Mirror => {
            let twice = 2.0 * fract(0.5 * c);
            if twice > 1.0 { 2.0 - twice } else { twice }
        }
        // `max` before `min`: a NaN becomes 0.
        #[allow(clippy::manual_clamp)]
        Wrap::Clamp => c.max(0.0).min(1.0),
    }
}

/// The texel that covers a coordinate, of `n`.
#[inline]
pub(super) fn nearest(wrap: Wrap, c: f32, n: usize) -> usize {
    ((wrapped(wrap, c) * n as f32) as i32 as usize).min(n - 1)
}

/// The two texels whose centres enclose a coordinate, and how far it is from the first to the second, in [0, 1).
#[inline]
pub(super) fn span(wrap: Wrap, c: f32, n: usize) -> (usize, usize, f32) {
    // With ½ added instead of taken off the number stays positive, so that truncation is floor; `cell` is the
    // index of the upper neighbour, between 0 and n.
    let x = wrapped(wrap, c) * n as f32 + 0.5;
    let cell = x as i32;
    let t = x - cell as f32;
    let cell = (cell as usize).min(n);
    let (before, after) = if wrap == Wrap::Repeat { (n - 1, 0) } else { (0, n - 1) };
    (if cell == 0 { before } else { cell - 1 }, if cell == n { after } else { cell }, t)
}
