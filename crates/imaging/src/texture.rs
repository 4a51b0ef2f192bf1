//! What colour does a texture have at (u, v)?
//!
//! glTF convention: (0, 0) is the top-left corner of the first texel, u to the right, v down; texel i of n covers
//! [i/n, (i+1)/n) and its value sits at its centre (i + ½)/n (SCIENCE B11: the other convention, i/(n−1), moves a
//! sun by 3.65 % of its energy at 64×32). sRGB is decoded before filtering; alpha is always linear. Only the finest
//! level is looked up: prefiltering would be a bias, and averaging many rays per pixel does its work.
//!
//! Lookups are total: any uv, NaN and ±∞ included, gives a colour of the texture.

use crate::color::{srgb_table, unit_table};
use crate::read::Rgba8;
use glam::{Vec2, Vec4};

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

/// What the RGB bytes mean; alpha is linear in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// sRGB code values (base colour, emission).
    Srgb,
    /// Numbers in [0, 1] (normals, roughness, occlusion).
    Linear,
}

/// An RGBA texture of 8 bits per channel, as it came from the file (4 bytes per texel).
#[derive(Clone, Debug)]
pub struct Texture {
    width: usize,
    height: usize,
    texels: Vec<[u8; 4]>,
    decode: &'static [f32; 256],
    unit: &'static [f32; 256],
    sampler: Sampler,
}

impl Texture {
    /// `Encoding::Srgb` decodes RGB (never alpha) on lookup, before filtering. An image without texels, or with
    /// another number of them than its size says, becomes one white texel, the neutral factor of every glTF
    /// texture slot.
    pub fn new(image: Rgba8, encoding: Encoding, sampler: Sampler) -> Self {
        let sound = !image.texels.is_empty()
            && image.width.checked_mul(image.height) == Some(image.texels.len())
            && image.width.max(image.height) <= i32::MAX as usize;
        let Rgba8 { width, height, texels } =
            if sound { image } else { Rgba8 { width: 1, height: 1, texels: vec![[255; 4]] } };
        let decode = match encoding {
            Encoding::Srgb => srgb_table(),
            Encoding::Linear => unit_table(),
        };
        Self { width, height, texels, decode, unit: unit_table(), sampler }
    }

    /// Width and height in texels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// How it is looked up.
    pub fn sampler(&self) -> Sampler {
        self.sampler
    }

    /// Linear RGB and alpha at `uv`, each in [0, 1]. uv in glTF convention: (0,0) is the top-left corner of the
    /// first texel.
    #[inline]
    pub fn lookup(&self, uv: Vec2) -> Vec4 {
        let Sampler { wrap_s, wrap_t, interpolation } = self.sampler;
        match interpolation {
            Interpolation::Nearest => {
                self.texel(nearest(wrap_s, uv.x, self.width), nearest(wrap_t, uv.y, self.height))
            }
            Interpolation::Linear => {
                let (x0, x1, s) = span(wrap_s, uv.x, self.width);
                let (y0, y1, t) = span(wrap_t, uv.y, self.height);
                let top = mix(self.texel(x0, y0), self.texel(x1, y0), s);
                let bottom = mix(self.texel(x0, y1), self.texel(x1, y1), s);
                mix(top, bottom, t)
            }
        }
    }

    /// The decoded texel in column `x` and row `y`; both must be within [`size`](Self::size).
    #[inline]
    fn texel(&self, x: usize, y: usize) -> Vec4 {
        let [r, g, b, a] = self.texels[y * self.width + x];
        let d = self.decode;
        Vec4::new(d[r as usize], d[g as usize], d[b as usize], self.unit[a as usize])
    }

    /// The colour of every lookup, if all texels are the same.
    pub fn constant(&self) -> Option<Vec4> {
        let first = self.texels[0];
        self.texels.iter().all(|texel| *texel == first).then(|| self.texel(0, 0))
    }

    /// Mean of all decoded texels, summed in f64: the integral of the texture over its unit square, whatever the
    /// interpolation under `Repeat` and `Mirror`.
    pub fn mean(&self) -> Vec4 {
        let mut count = [[0u64; 256]; 4];
        for texel in &self.texels {
            for (count, &byte) in count.iter_mut().zip(texel) {
                count[byte as usize] += 1;
            }
        }
        let mean = |count: &[u64; 256], table: &[f32; 256]| {
            let sum: f64 = count.iter().zip(table).map(|(&n, &v)| n as f64 * v as f64).sum();
            (sum / self.texels.len() as f64) as f32
        };
        let [r, g, b, a] = &count;
        Vec4::new(mean(r, self.decode), mean(g, self.decode), mean(b, self.decode), mean(a, self.unit))
    }

    /// Bytes held by the texels.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.texels.as_slice())
    }
}

/// a + (b − a) t: exact when a = b, and the same on every machine (no reduction, no fused multiply).
#[inline]
fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
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
fn nearest(wrap: Wrap, c: f32, n: usize) -> usize {
    ((wrapped(wrap, c) * n as f32) as i32 as usize).min(n - 1)
}

/// The two texels whose centres enclose a coordinate, and how far it is from the first to the second, in [0, 1).
#[inline]
fn span(wrap: Wrap, c: f32, n: usize) -> (usize, usize, f32) {
    // With ½ added instead of taken off the number stays positive, so that truncation is floor; `cell` is the
    // index of the upper neighbour, between 0 and n.
    let x = wrapped(wrap, c) * n as f32 + 0.5;
    let cell = x as i32;
    let t = x - cell as f32;
    let cell = (cell as usize).min(n);
    let (before, after) = if wrap == Wrap::Repeat { (n - 1, 0) } else { (0, n - 1) };
    (if cell == 0 { before } else { cell - 1 }, if cell == n { after } else { cell }, t)
}
