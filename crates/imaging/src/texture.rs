//! Texture lookup. Texel centres lie at (i + ½)/n; (0, 0) is the top-left corner of the first texel, as in glTF.

use crate::color::SRGB_BYTE;
use crate::read::Rgba8;
use glam::{Vec2, Vec4};

/// What lies outside [0,1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Starts over.
    #[default]
    Repeat,
    /// Turns back.
    Mirror,
    /// Stays at the edge.
    Clamp,
}

/// What lies between texel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The nearest texel.
    Nearest,
    /// Bilinear mixture of four.
    #[default]
    Linear,
}

/// How a texture is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// Across.
    pub wrap_s: Wrap,
    /// Down.
    pub wrap_t: Wrap,
    /// Between texels.
    pub interpolation: Interpolation,
}

/// What the bytes mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// RGB through the sRGB curve, alpha linear.
    Srgb,
    /// byte / 255.
    Linear,
}

/// Texels and how to look them up.
#[derive(Clone, Debug)]
pub struct Texture {
    image: Rgba8,
    encoding: Encoding,
    sampler: Sampler,
}

impl Texture {
    /// `Encoding::Srgb` decodes RGB (never alpha) before filtering. An image without texels is white.
    pub fn new(image: Rgba8, encoding: Encoding, sampler: Sampler) -> Self {
        let whole = image.width * image.height == image.texels.len() && !image.texels.is_empty();
        let image = if whole { image } else { Rgba8 { width: 1, height: 1, texels: vec![[255; 4]] } };
        Self { image, encoding, sampler }
    }

    /// Linear RGBA at uv; anything that is not a number is looked up at 0.
    pub fn lookup(&self, uv: Vec2) -> Vec4 {
        let (w, h) = (self.image.width, self.image.height);
        let (x, y) = (place(uv.x, w, self.sampler.wrap_s), place(uv.y, h, self.sampler.wrap_t));
        if self.sampler.interpolation == Interpolation::Nearest {
            let (i, j) = (
                wrapped(x.floor() as i64, w, self.sampler.wrap_s),
                wrapped(y.floor() as i64, h, self.sampler.wrap_t),
            );
            return self.texel(i, j);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let (i0, i1) = (wrapped(i, w, self.sampler.wrap_s), wrapped(i + 1, w, self.sampler.wrap_s));
        let (j0, j1) = (wrapped(j, h, self.sampler.wrap_t), wrapped(j + 1, h, self.sampler.wrap_t));
        let top = mix(self.texel(i0, j0), self.texel(i1, j0), fx);
        let bottom = mix(self.texel(i0, j1), self.texel(i1, j1), fx);
        mix(top, bottom, fy)
    }

    fn texel(&self, i: usize, j: usize) -> Vec4 {
        let [r, g, b, a] = self.image.texels[j * self.image.width + i];
        let alpha = f32::from(a) * (1.0 / 255.0);
        match self.encoding {
            Encoding::Srgb => {
                Vec4::new(SRGB_BYTE[r as usize], SRGB_BYTE[g as usize], SRGB_BYTE[b as usize], alpha)
            }
            Encoding::Linear => {
                Vec4::new(f32::from(r), f32::from(g), f32::from(b), f32::from(a)) * (1.0 / 255.0)
            }
        }
    }

    /// Mean over all texels, in f64.
    pub fn mean(&self) -> Vec4 {
        let texels = (0..self.image.height).flat_map(|j| (0..self.image.width).map(move |i| (i, j)));
        let sum: glam::DVec4 = texels.map(|(i, j)| self.texel(i, j).as_dvec4()).sum();
        (sum / self.image.texels.len() as f64).as_vec4()
    }

    /// Texels across and down.
    pub fn size(&self) -> (usize, usize) {
        (self.image.width, self.image.height)
    }

    /// Bytes of the texels.
    pub fn memory_bytes(&self) -> usize {
        self.image.texels.len() * 4
    }
}

fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}

/// Coordinate in texels, brought into one or two periods while it still has its digits.
fn place(u: f32, n: usize, wrap: Wrap) -> f32 {
    let u = if u.is_finite() { u } else { 0.0 };
    let u = match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Mirror => u - 2.0 * (u * 0.5).floor(),
        Wrap::Clamp => u.clamp(0.0, 1.0),
    };
    u * n as f32
}

fn wrapped(i: i64, n: usize, wrap: Wrap) -> usize {
    let n = n as i64;
    (match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let m = i.rem_euclid(2 * n);
            m.min(2 * n - 1 - m)
        }
        Wrap::Clamp => i.clamp(0, n - 1),
    }) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(sampler: Sampler) -> Texture {
        let texels = (0..4).map(|i| [i * 60, 0, 0, 255]).collect();
        Texture::new(Rgba8 { width: 4, height: 1, texels }, Encoding::Linear, sampler)
    }

    #[test]
    fn wraps_as_named() {
        for (wrap, at) in [(Wrap::Repeat, 60.0), (Wrap::Mirror, 120.0), (Wrap::Clamp, 180.0)] {
            let t = ramp(Sampler { wrap_s: wrap, wrap_t: wrap, interpolation: Interpolation::Nearest });
            assert!((t.lookup(Vec2::new(1.375, 0.5)).x * 255.0 - at).abs() < 1e-3, "{wrap:?}");
            for u in [f32::NAN, f32::INFINITY, -1e30, 1e30, -0.0] {
                assert!(t.lookup(Vec2::splat(u)).is_finite());
            }
        }
    }

    #[test]
    fn interpolates_between_centres() {
        let t = ramp(Sampler::default());
        assert!((t.lookup(Vec2::new(0.25, 0.5)).x * 255.0 - 30.0).abs() < 1e-3);
        assert!((t.lookup(Vec2::new(0.0, 0.5)).x * 255.0 - 90.0).abs() < 1e-3);
        assert!((t.mean().x * 255.0 - 90.0).abs() < 1e-3);
    }
}
