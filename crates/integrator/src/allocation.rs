//! Sample allocation: distributes the samples of an adaptive render over the pixels.
//!
//! At a given cost, the error of an image is smallest when the sample counts are proportional to σ/√c, the standard
//! deviation of a pixel over the square root of the cost of a sample (the minimum of Σ σ²/n at a fixed Σ c·n). Both are
//! estimated once, from the first [`PILOT`] samples.
//!
//! To avoid bias, no value computed from a pixel's samples may determine how these samples are weighted. If a pixel's
//! own first samples determined its sample count, the pixel would be too dark: a pixel that happened to miss the light
//! would stop, one that happened to find it would continue. A share is also a ratio to the mean over the image, to
//! which the pixel's own samples contribute through its neighbours: where they are bright, the mean is large, the pixel
//! gets few further samples, and the bright samples weigh more, which makes the pixel too bright. The share of a pixel
//! is therefore computed from the samples of the surrounding pixels, relative to a mean over the image from which the
//! pixel's own samples are excluded as well. Samples of different pixels are independent; the sample count of a pixel
//! is therefore independent of its sample values, and the plain mean of all its samples, the first ones included, is
//! unbiased. For the same reason shares are computed once: the number of later samples of a neighbour depends on this
//! pixel's first samples.
//!
//! As a consequence, the shares add up to the number of pixels only approximately: a pixel that alone causes most of
//! the changes around it is normalised by the mean of the image without it.

use dapple_camera::Film;
use dapple_math::PixelRect;
use dapple_sampling::Key;

/// Samples per pixel before the shares are computed.
pub const PILOT: u32 = 16;

/// Radius, in pixels, of the neighbourhood that determines the share of a pixel.
const REACH: u32 = 2;

/// Fraction of the further samples that is distributed evenly, so that features missed by the pilot samples can still
/// be found.
const EVEN: f64 = 0.25;

/// The share of every pixel in the samples after the pilot; 1 on average, except for isolated outliers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SampleAllocation {
    rect: PixelRect,
    shares: Vec<f64>,
}

impl SampleAllocation {
    /// Sample count of a pixel at an average of `spp`: the same for all pixels up to [`PILOT`], then proportional to
    /// the share, rounded up or down at random so that the expectation is exact. Never decreases as `spp` grows.
    pub fn count(&self, x: u32, y: u32, spp: u32) -> u32 {
        if spp <= PILOT || !self.rect.contains(x, y) {
            return spp;
        }
        let i = (y - self.rect.y0) as usize * self.rect.width() as usize + (x - self.rect.x0) as usize;
        let chance = (Key::pixel(0x5b4e_ad00, x, y).bits() >> 11) as f64 / (1u64 << 53) as f64;
        let more = f64::from(spp - PILOT) * self.shares[i] + chance;
        PILOT.saturating_add(more as u32)
    }

    /// A digest of all shares, which tells allocations apart.
    pub fn digest(&self) -> u64 {
        let PixelRect { x0, y0, x1, y1 } = self.rect;
        let start = Key::pixel(u64::from(x1) << 32 | u64::from(y1), x0, y0);
        let mix = |digest: u64, share: &f64| Key::pixel(digest ^ share.to_bits(), 0, 0).bits();
        self.shares.iter().fold(start.bits(), mix)
    }

    /// Whether there is a share for each pixel; an allocation that was read from a file may lack some.
    pub(crate) fn is_whole(&self) -> bool {
        self.shares.len() == self.rect.area()
    }

    /// Computes the shares from the films after half of the pilot samples and after all of them, and from the rays
    /// traced per pixel. The change of a pixel when its sample count doubles estimates what it gains from more samples,
    /// for any sampling pattern.
    pub(crate) fn decide(half: &Film, whole: &Film, rays: &[u64]) -> Self {
        let rect = whole.rect();
        let change = |(x, y)| (whole.mean_at(x, y) - half.mean_at(x, y)).length_squared();
        let cost = |rays: &u64| f64::from(PILOT) + *rays as f64;
        let first: Vec<First> =
            pixels(rect).zip(rays).map(|(p, r)| First { change: change(p), cost: cost(r) }).collect();
        let densities = Densities::new(rect, &first);
        let shares = pixels(rect).map(|p| densities.share(p)).collect();
        Self { rect, shares }
    }
}

/// Result of the pilot samples of a pixel: the squared change, and the cost.
#[derive(Clone, Copy, Debug, Default)]
struct First {
    change: f64,
    cost: f64,
}

/// Desired sample density of every pixel, estimated from its neighbours, up to a common factor.
struct Densities<'a> {
    rect: PixelRect,
    first: &'a [First],
    /// Density for every pixel; `None` for a pixel without neighbours.
    densities: Vec<Option<f64>>,
    /// Sums and counts of the densities left and right of every column within its row, excluding the column.
    left: Vec<(f64, f64)>,
    right: Vec<(f64, f64)>,
    /// Sums and counts of the densities above and below every row.
    above: Vec<(f64, f64)>,
    below: Vec<(f64, f64)>,
}

impl<'a> Densities<'a> {
    fn new(rect: PixelRect, first: &'a [First]) -> Self {
        let none = Vec::new();
        let mut all =
            Self { rect, first, densities: none, left: vec![], right: vec![], above: vec![], below: vec![] };
        all.densities = pixels(rect).map(|p| all.density(p, None)).collect();
        let mut rows = Vec::new();
        for row in all.densities.chunks(rect.width().max(1) as usize) {
            all.left.extend(before(row.iter().map(counted)));
            let mut right = before(row.iter().rev().map(counted));
            right.reverse();
            all.right.extend(right);
            rows.push(row.iter().map(counted).fold((0.0, 0.0), plus));
        }
        all.above = before(rows.iter().copied());
        all.below = before(rows.iter().rev().copied());
        all.below.reverse();
        all
    }

    fn index(&self, (x, y): (u32, u32)) -> usize {
        (y - self.rect.y0) as usize * self.rect.width() as usize + (x - self.rect.x0) as usize
    }

    /// The neighbourhood of (x, y), including the pixel itself.
    fn near(&self, (x, y): (u32, u32)) -> PixelRect {
        let (x0, y0) = (x.saturating_sub(REACH), y.saturating_sub(REACH));
        let (x1, y1) = (x.saturating_add(REACH + 1), y.saturating_add(REACH + 1));
        PixelRect { x0, y0, x1, y1 }.intersection(&self.rect)
    }

    /// The square root of the mean squared change over the mean cost of the neighbours of `pixel`, excluding `pixel`
    /// itself and `without`; `None` if there are none.
    fn density(&self, pixel: (u32, u32), without: Option<(u32, u32)>) -> Option<f64> {
        let around = pixels(self.near(pixel)).filter(|p| *p != pixel && Some(*p) != without);
        let add = |s: First, f: &First| First { change: s.change + f.change, cost: s.cost + f.cost };
        let sum = around.clone().map(|p| &self.first[self.index(p)]).fold(First::default(), add);
        let n = around.count() as f64;
        // The mean cost is at least that of one sample, as in an image that traces no rays.
        (n > 0.0).then(|| (sum.change / sum.cost.max(n)).sqrt())
    }

    /// The share of `pixel`: its density over the mean of all densities computed without its samples. The mean is
    /// summed from parts that are independent of the pixel, so that not even rounding depends on it.
    fn share(&self, pixel: (u32, u32)) -> f64 {
        let near = self.near(pixel);
        let mut sum = plus(
            self.above[(near.y0 - self.rect.y0) as usize],
            self.below[(near.y1 - 1 - self.rect.y0) as usize],
        );
        for y in near.y0..near.y1 {
            sum = plus(sum, self.left[self.index((near.x0, y))]);
            sum = plus(sum, self.right[self.index((near.x1 - 1, y))]);
        }
        sum = pixels(near).fold(sum, |sum, p| plus(sum, counted(&self.density(p, Some(pixel)))));
        let (mean, own) = (sum.0 / sum.1.max(1.0), self.densities[self.index(pixel)].unwrap_or_default());
        if mean > 0.0 && mean.is_finite() { EVEN + (1.0 - EVEN) * own / mean } else { 1.0 }
    }
}

/// A density with its count of 1, or zeros for `None`.
fn counted(density: &Option<f64>) -> (f64, f64) {
    density.map_or((0.0, 0.0), |density| (density, 1.0))
}

fn plus(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 + b.0, a.1 + b.1)
}

/// Exclusive prefix sums.
fn before(values: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    values
        .scan((0.0, 0.0), |sum, value| {
            let before = *sum;
            *sum = plus(before, value);
            Some(before)
        })
        .collect()
}

fn pixels(rect: PixelRect) -> impl Iterator<Item = (u32, u32)> + Clone {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const RECT: PixelRect = PixelRect { x0: 2, y0: 3, x1: 34, y1: 23 };

    /// The left half is black, the right half has standard deviation 1, and the pixel (5, 6) is an outlier.
    fn allocation() -> SampleAllocation {
        let (mut half, mut whole) = (Film::new(RECT), Film::new(RECT));
        for (x, y) in pixels(RECT) {
            let sign = if (x + y).is_multiple_of(2) { 1.0 } else { -1.0 };
            let value = if (x, y) == (5, 6) { 1e3 } else { sign * f32::from(u8::from(x >= 18)) };
            half.add(x, y, Vec3::ZERO, 1.0);
            whole.add(x, y, Vec3::splat(value), 1.0);
        }
        SampleAllocation::decide(&half, &whole, &vec![48; RECT.area()])
    }

    /// The shares have a mean of 1 without the outlier, and almost so with it.
    #[test]
    fn samples_go_where_the_changes_are_and_none_is_lost() {
        let allocation = allocation();
        let shares: f64 = allocation.shares.iter().sum();
        assert!((shares / RECT.area() as f64 - 1.0).abs() < 0.01, "{shares}");
        assert!(pixels(RECT).all(|(x, y)| (0..=PILOT).all(|n| allocation.count(x, y, n) == n)));
        let total = |spp| pixels(RECT).map(|(x, y)| f64::from(allocation.count(x, y, spp))).sum::<f64>();
        for spp in [17, 20, 64, 1000] {
            let off = total(spp) / (RECT.area() as f64 * f64::from(spp)) - 1.0;
            assert!(off.abs() < 0.01, "{spp}: {off}");
        }
        assert!(allocation.count(8, 20, 1016) == 266 || allocation.count(8, 20, 1016) == 267);
        assert!(allocation.count(30, 10, 116) > allocation.count(8, 20, 116));
        assert!((16..2000).all(|n| allocation.count(30, 10, n) <= allocation.count(30, 10, n + 1)));
    }

    /// An outlier adds samples to its neighbours, not to itself.
    #[test]
    fn no_pixel_decides_about_itself() {
        let allocation = allocation();
        assert!(allocation.count(6, 6, 1016) > 2000 && allocation.count(5, 8, 1016) > 2000);
        assert!(allocation.count(8, 6, 1016) <= 267);
    }

    /// The share of a pixel does not depend on its own samples and rays, bit for bit; the shares of other pixels do.
    #[test]
    fn own_samples_do_not_change_the_own_share() {
        let rect = PixelRect { x0: 1, y0: 2, x1: 14, y1: 11 };
        let noise = |x: u32, y: u32| (Key::pixel(9, x, y).bits() >> 40) as f64 / (1u64 << 24) as f64;
        let first = |x, y| First { change: noise(x, y).powi(8), cost: 16.0 + 99.0 * noise(y, x) };
        let all: Vec<First> = pixels(rect).map(|(x, y)| first(x, y)).collect();
        let whole = Densities::new(rect, &all);
        for pixel in pixels(rect) {
            for value in [0.0, 1e-9, 1e9] {
                let mut other = all.clone();
                other[whole.index(pixel)] = First { change: value, cost: 16.0 + value };
                let other = Densities::new(rect, &other);
                assert_eq!(whole.share(pixel).to_bits(), other.share(pixel).to_bits(), "{pixel:?} {value}");
                let beside = if pixel.0 > 1 { (pixel.0 - 1, pixel.1) } else { (pixel.0 + 1, pixel.1) };
                assert!(whole.share(beside) != other.share(beside));
            }
        }
    }

    #[test]
    fn where_nothing_changes_all_get_the_same() {
        let film = Film::new(RECT);
        let allocation = SampleAllocation::decide(&film, &film, &vec![16; RECT.area()]);
        assert!(pixels(RECT).all(|(x, y)| allocation.count(x, y, 500) == 500));
        for (x1, y1) in [(1, 1), (2, 1), (1, 2), (3, 1)] {
            let few = PixelRect { x0: 0, y0: 0, x1, y1 };
            let allocation =
                SampleAllocation::decide(&Film::new(few), &Film::new(few), &vec![16; few.area()]);
            assert!(pixels(few).all(|(x, y)| allocation.count(x, y, 99) == 99));
        }
    }
}
