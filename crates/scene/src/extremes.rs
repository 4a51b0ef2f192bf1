//! Bounds of a texture over regions of its plane: minimum and maximum of blocks of texels, in levels of doubling size.
use crate::TextureUse;
use dapple_imaging::Texture;
use dapple_imaging::texture::{Interpolation, Wrap};
use glam::{DVec2, Vec4};
use std::ops::RangeInclusive;

/// A scalar function of the texels, with its minimum and maximum over blocks.
#[derive(Debug)]
pub(crate) struct Extremes<'a> {
    texture: &'a Texture,
    /// The scalar of a texel.
    value: Value,
    /// Levels with blocks of 2, 4, 8… texels per side, up to a single block.
    levels: Vec<Level>,
}

/// Weights of the channels; the scalar is the weighted sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Value(pub Vec4);

impl Value {
    pub fn of(self, texel: Vec4) -> f32 {
        self.0.dot(texel)
    }
}

#[derive(Debug)]
struct Level {
    width: usize,
    blocks: Vec<(f32, f32)>,
}

const NONE: (f32, f32) = (f32::INFINITY, f32::NEG_INFINITY);

fn joined(a: (f32, f32), b: (f32, f32)) -> (f32, f32) {
    (a.0.min(b.0), a.1.max(b.1))
}

impl<'a> Extremes<'a> {
    pub fn new(texture: &'a Texture, value: Value) -> Self {
        let mut extremes = Self { texture, value, levels: Vec::new() };
        let (mut width, mut height) = texture.size();
        while width.max(height) > 1 {
            let (w, h) = (width.div_ceil(2), height.div_ceil(2));
            let level = extremes.levels.len();
            let block = |i: usize| {
                let (x, y) = (2 * (i % w), 2 * (i / w));
                let columns = x..=(x + 1).min(width - 1);
                (y..=(y + 1).min(height - 1))
                    .flat_map(|y| columns.clone().map(move |x| (x, y)))
                    .fold(NONE, |all, (x, y)| joined(all, extremes.at(level, x, y)))
            };
            let blocks = (0..w * h).map(block).collect();
            extremes.levels.push(Level { width: w, blocks });
            (width, height) = (w, h);
        }
        extremes
    }

    fn at(&self, level: usize, x: usize, y: usize) -> (f32, f32) {
        if level == 0 {
            let value = self.value.of(self.texture.texel(x, y));
            return (value, value);
        }
        let Level { width, blocks } = &self.levels[level - 1];
        blocks[y * width + x]
    }

    /// Bounds of the lookups in the box `low`…`high` (in texels, not wrapped), including rounding. The box may be
    /// enlarged.
    pub fn within(&self, low: DVec2, high: DVec2) -> (f32, f32) {
        let (sampler, (w, h)) = (self.texture.sampler(), self.texture.size());
        let linear = sampler.interpolation == Interpolation::Linear;
        let columns = indices(sampler.wrap_s, linear, low.x, high.x, w);
        let rows = indices(sampler.wrap_t, linear, low.y, high.y, h);
        let mut all = NONE;
        for rows in rows.iter().flatten() {
            for columns in columns.iter().flatten() {
                all = joined(all, self.block(columns, rows));
            }
        }
        all
    }

    /// Bounds of a range of texels, from the level at which it is a few blocks wide.
    fn block(&self, columns: &RangeInclusive<usize>, rows: &RangeInclusive<usize>) -> (f32, f32) {
        let widest = (columns.end() - columns.start()).max(rows.end() - rows.start());
        let level = (usize::BITS - (widest / 3).leading_zeros()).min(self.levels.len() as u32);
        let mut all = NONE;
        for y in rows.start() >> level..=rows.end() >> level {
            for x in columns.start() >> level..=columns.end() >> level {
                all = joined(all, self.at(level as usize, x, y));
            }
        }
        all
    }
}

/// Indices of the texels, of `n`, that lookups between two coordinates (in texels) access: up to two ranges.
fn indices(wrap: Wrap, linear: bool, low: f64, high: f64, n: usize) -> [Option<RangeInclusive<usize>>; 2] {
    let whole = [Some(0..=n - 1), None];
    // Bound of the f32 rounding error of a coordinate.
    let rounding = (low.abs().max(high.abs()) + n as f64) * (4.0 * f64::from(f32::EPSILON));
    let (low, high) = (low - rounding, high + rounding);
    // Also true for NaN.
    if !(high - low < n as f64 && rounding < n as f64) {
        return whole;
    }
    let (first, last) = match linear {
        true => ((low - 0.5).floor(), (high - 0.5).floor() + 1.0),
        false => (low.floor(), high.floor()),
    };
    let (first, last, size) = (first as i64, last as i64, n as i64);
    match wrap {
        Wrap::Clamp => {
            let held = |i: i64| i.clamp(0, size - 1) as usize;
            [Some(held(first)..=held(last)), None]
        }
        Wrap::Repeat => {
            let (start, length) = (first.rem_euclid(size), last - first);
            match start + length {
                _ if length >= size => whole,
                end if end < size => [Some(start as usize..=end as usize), None],
                end => [Some(start as usize..=n - 1), Some(0..=(end - size) as usize)],
            }
        }
        Wrap::Mirror => {
            let fold = |i: i64| {
                let i = i.rem_euclid(2 * size);
                (if i < size { i } else { 2 * size - 1 - i }) as usize
            };
            let (a, b) = (fold(first), fold(last));
            // If the range contains a fold, it ends there.
            let turns = first.div_euclid(size) != last.div_euclid(size);
            let at_end = first.div_euclid(size).rem_euclid(2) == 0;
            match turns {
                false => [Some(a.min(b)..=a.max(b)), None],
                true if last - first >= size => whole,
                true if at_end => [Some(a.min(b)..=n - 1), None],
                true => [Some(0..=a.max(b)), None],
            }
        }
    }
}

/// Texture coordinates of a triangle's corners in texels, transformed as `of` requires; `uvs` are those of its uv set.
pub(crate) fn in_texels(of: &TextureUse, texture: &Texture, uvs: [glam::Vec2; 3]) -> [DVec2; 3] {
    let (w, h) = texture.size();
    uvs.map(|uv| of.apply(uv).as_dvec2() * DVec2::new(w as f64, h as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_imaging::{Sampler, read::Rgba8, texture::Encoding};
    use glam::Vec2;

    /// All lookups are within the bounds, and bounds of constant regions are tight, for every wrap mode and filter,
    /// inside and far outside the texture.
    #[test]
    fn lookups_stay_within() {
        let (width, height) = (13, 6);
        let texels: Vec<[u8; 4]> = (0..width * height).map(|i| [(i * 37 % 251) as u8; 4]).collect();
        let value = Value(Vec4::X);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for interpolation in [Interpolation::Nearest, Interpolation::Linear] {
                let sampler = Sampler { wrap_s: wrap, wrap_t: wrap, interpolation };
                let image = Rgba8 { width, height, texels: texels.clone() };
                let texture = Texture::new(image, Encoding::Linear, sampler);
                let extremes = Extremes::new(&texture, value);
                let size = DVec2::new(width as f64, height as f64);
                let mut tight = 0;
                for k in 0..4000 {
                    let fraction = |a: f64| (f64::from(k) * a).fract();
                    let low = DVec2::new(fraction(0.618), fraction(0.7548)) * 8.0 - 4.0;
                    let step = DVec2::new(fraction(0.5698), fraction(0.4142));
                    let step = step * if k % 2 == 0 { 0.02 } else { 0.8 };
                    let (least, most) = extremes.within(low * size, (low + step) * size);
                    tight += u32::from(least == most);
                    for i in 0..25 {
                        let at = low + step * DVec2::new(f64::from(i % 5), f64::from(i / 5)) / 4.0;
                        let seen = value.of(texture.lookup(Vec2::new(at.x as f32, at.y as f32)));
                        let rounding = 1e-6;
                        let inside = seen >= least - rounding && seen <= most + rounding;
                        assert!(inside, "{wrap:?} {interpolation:?} {at}: {seen} not in {least}..{most}");
                    }
                }
                assert!(tight > 100 || interpolation == Interpolation::Linear, "{tight}");
            }
        }
    }

    #[test]
    fn what_is_no_place_is_everywhere() {
        for (low, high) in [(f64::NAN, 1.0), (0.0, f64::INFINITY), (1e30, 1e30)] {
            assert_eq!(indices(Wrap::Repeat, false, low, high, 8), [Some(0..=7), None]);
        }
    }
}
