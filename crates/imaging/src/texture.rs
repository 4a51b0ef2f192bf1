//! RGBA textures and their lookup.
//!
//! The texture coordinates follow the glTF convention: (0, 0) is the top-left corner of the first texel, u increases to
//! the right and v downward; texel i of n covers [i/n, (i+1)/n) and its value is at its centre (i + ½)/n
//! (docs/science.md, "Skies": the other convention, i/(n−1), changes the energy of a sun of one texel by 3.65 % at
//! 64×32). sRGB is decoded before filtering; alpha is always linear. Only the finest level is used: prefiltering would
//! cause bias, and averaging many rays per pixel has the same effect.
//!
//! Lookups are total: any uv, including NaN and ±∞, gives a colour of the texture.

mod encoding;
mod sampler;
mod wide;

pub use encoding::{Channels, Encoding};
pub use sampler::{Interpolation, Sampler, Wrap};

use crate::color::{ones_table, srgb_table, unit_table};
use crate::read::{Rgba8, Texels};
use glam::{Vec2, Vec4};
use sampler::{nearest, span};
use wide::Wide;

/// An RGBA texture of 8 or 16 bits per channel, with all channels of the file or only some of them.
#[derive(Clone, Debug)]
pub struct Texture {
    width: usize,
    height: usize,
    /// `stride` bytes per texel, plus padding so that four bytes can be read at any texel.
    bytes: Vec<u8>,
    stride: usize,
    /// The position of each channel within its texel.
    places: [u8; 4],
    /// The decoding table of each channel.
    tables: [&'static [f32; 256]; 4],
    sampler: Sampler,
    /// Whether all texels of the image are equal.
    is_constant: bool,
    /// Texels of 16 bits per channel; replaces `bytes` if present.
    wide: Option<Box<Wide>>,
}

impl Texture {
    /// Creates a texture. `Encoding::Srgb` decodes RGB (never alpha) on lookup, before filtering. An image without
    /// texels, or whose number of texels does not match its size, becomes a single white texel, which is the neutral
    /// factor of every glTF texture slot.
    pub fn new(image: impl Into<Texels>, encoding: Encoding, sampler: Sampler) -> Self {
        match image.into() {
            Texels::Eight(image) => Self::eight(image, encoding, sampler),
            Texels::Sixteen(image) if is_sound(image.width, image.height, image.texels.len()) => Self {
                width: image.width,
                height: image.height,
                is_constant: image.texels.iter().all(|texel| *texel == image.texels[0]),
                wide: Some(Box::new(Wide::new(image.texels, encoding))),
                bytes: Vec::new(),
                ..Self::eight(WHITE, encoding, sampler)
            },
            Texels::Sixteen(_) => Self::eight(WHITE, encoding, sampler),
        }
    }

    fn eight(image: Rgba8, encoding: Encoding, sampler: Sampler) -> Self {
        let sound = is_sound(image.width, image.height, image.texels.len());
        let Rgba8 { width, height, texels } =
            if sound { image } else { Rgba8 { width: 1, height: 1, texels: vec![[255; 4]] } };
        let color = match encoding {
            Encoding::Srgb => srgb_table(),
            Encoding::Linear => unit_table(),
        };
        let is_constant = texels.iter().all(|texel| *texel == texels[0]);
        Self {
            width,
            height,
            bytes: texels.into_flattened(),
            stride: 4,
            places: [0, 1, 2, 3],
            tables: [color, color, color, unit_table()],
            sampler,
            is_constant,
            wide: None,
        }
    }

    /// Removes the channels that are not `wanted`; lookups return 1 for them. Of the other channels, those that are 1
    /// everywhere are not stored, and equal channels are stored once.
    #[must_use]
    pub fn keep(self, wanted: Channels) -> Self {
        if let Some(wide) = self.wide {
            return Self { wide: Some(Box::new(wide.keep(wanted.0))), ..self };
        }
        let mut stored: Vec<usize> = Vec::new();
        let (mut places, mut tables) = ([0; 4], self.tables);
        for c in 0..4 {
            if !wanted.0[c] || self.texels().all(|texel| self.tables[c][self.byte(texel, c)] == 1.0) {
                tables[c] = ones_table();
                continue;
            }
            let same = |s: &usize| self.texels().all(|texel| self.byte(texel, *s) == self.byte(texel, c));
            let place = stored.iter().position(same).unwrap_or_else(|| {
                stored.push(c);
                stored.len() - 1
            });
            places[c] = place as u8;
        }
        if stored.len() == self.stride {
            return Self { places: self.places, tables, ..self };
        }
        let mut bytes = Vec::with_capacity(self.width * self.height * stored.len() + 4 - stored.len());
        let taken: Vec<usize> = stored.iter().map(|&c| usize::from(self.places[c])).collect();
        bytes.extend(self.texels().flat_map(|texel| taken.iter().map(|&place| texel[place])));
        bytes.resize(bytes.capacity(), 0);
        Self { bytes, stride: stored.len(), places, tables, ..self }
    }

    /// The number of stored channels.
    pub fn channels(&self) -> usize {
        self.wide.as_ref().map_or(self.stride, |wide| wide.channels())
    }

    /// For each texel, a slice of at least four bytes, of which only the first `stride` belong to it.
    fn texels(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.width * self.height).map(|i| &self.bytes[i * self.stride..])
    }

    fn byte(&self, texel: &[u8], channel: usize) -> usize {
        usize::from(texel[usize::from(self.places[channel])])
    }

    /// Width and height in texels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The wrap modes and interpolation.
    pub fn sampler(&self) -> Sampler {
        self.sampler
    }

    /// Linear RGB and alpha at `uv`, each in [0, 1]. uv is in the glTF convention: (0,0) is the top-left corner of the
    /// first texel.
    #[inline]
    pub fn lookup(&self, uv: Vec2) -> Vec4 {
        match &self.wide {
            None => self.lookup_of(uv, |x, y| self.narrow_texel(x, y)),
            Some(wide) => self.lookup_wide(wide, uv),
        }
    }

    #[inline(never)]
    fn lookup_wide(&self, wide: &Wide, uv: Vec2) -> Vec4 {
        self.lookup_of(uv, |x, y| wide.texel(y * self.width + x))
    }

    #[inline(always)]
    fn lookup_of(&self, uv: Vec2, texel: impl Fn(usize, usize) -> Vec4) -> Vec4 {
        let Sampler { wrap_s, wrap_t, interpolation } = self.sampler;
        match interpolation {
            Interpolation::Nearest => {
                texel(nearest(wrap_s, uv.x, self.width), nearest(wrap_t, uv.y, self.height))
            }
            Interpolation::Linear => {
                let (x0, x1, s) = span(wrap_s, uv.x, self.width);
                let (y0, y1, t) = span(wrap_t, uv.y, self.height);
                let top = mix(texel(x0, y0), texel(x1, y0), s);
                let bottom = mix(texel(x0, y1), texel(x1, y1), s);
                mix(top, bottom, t)
            }
        }
    }

    /// The decoded texel in column `x` and row `y`; both must be within [`size`](Self::size).
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> Vec4 {
        match &self.wide {
            None => self.narrow_texel(x, y),
            Some(wide) => wide.texel(y * self.width + x),
        }
    }

    /// A decoded texel of 8 bits per channel.
    #[inline(always)]
    fn narrow_texel(&self, x: usize, y: usize) -> Vec4 {
        let at = (y * self.width + x) * self.stride;
        let bytes = &self.bytes[at..at + 4];
        // Positions are below 4; the mask eliminates the bounds check.
        let value = |c: usize| self.tables[c][usize::from(bytes[usize::from(self.places[c] & 3)])];
        Vec4::new(value(0), value(1), value(2), value(3))
    }

    /// The colour of every lookup, if all texels of the image are equal.
    pub fn constant(&self) -> Option<Vec4> {
        self.is_constant.then(|| self.texel(0, 0))
    }

    /// Mean of all decoded texels, summed in f64. With `Repeat` and `Mirror`, this is the integral of the texture over
    /// its unit square for either interpolation.
    pub fn mean(&self) -> Vec4 {
        if let Some(wide) = &self.wide {
            return wide.mean(self.width * self.height);
        }
        let mut count = [[0u64; 256]; 4];
        for texel in self.texels() {
            for (c, count) in count.iter_mut().enumerate() {
                count[self.byte(texel, c)] += 1;
            }
        }
        let mean = |c: usize| {
            let sum: f64 = count[c].iter().zip(self.tables[c]).map(|(&n, &v)| n as f64 * v as f64).sum();
            (sum / (self.width * self.height) as f64) as f32
        };
        Vec4::new(mean(0), mean(1), mean(2), mean(3))
    }

    /// Memory of the texels in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.bytes.as_slice()) + self.wide.as_ref().map_or(0, |wide| wide.memory_bytes())
    }
}

/// Replaces an image without texels.
const WHITE: Rgba8 = Rgba8 { width: 0, height: 0, texels: Vec::new() };

/// Whether an image of this size has this number of texels.
fn is_sound(width: usize, height: usize, texels: usize) -> bool {
    texels > 0 && width.checked_mul(height) == Some(texels) && width.max(height) <= i32::MAX as usize
}

/// a + (b − a) t: exact when a = b, and identical on every machine (no reduction, no fused multiply).
#[inline]
fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}
