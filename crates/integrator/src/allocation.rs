//! Which pixels get how many samples?
//!
//! The error of a picture is smallest, at the same cost, when a pixel's samples follow σ/√c: its deviation over the
//! root of what a sample costs (the minimum of Σ σ²/n at a fixed Σ c·n). Both are guessed once, from the first
//! [`PILOT`] samples.
//!
//! No number that comes from a pixel's samples may decide how often those samples are weighted. A pixel whose own first
//! samples decided how many more it gets would be too dark: one that happened to miss the light would stop, one that
//! happened to find it would go on. And a share is a ratio to the mean over the picture, to which the pixel's own
//! samples contribute by way of its neighbours: where they were bright, the mean is large, the pixel gets few further
//! samples, and the bright ones weigh more, which makes it too bright. So a pixel's share follows from the samples of
//! the pixels around it, relative to a mean over the picture from which the pixel's own samples are left out as well.
//! Samples of different pixels are independent; the number of a pixel's samples is therefore independent of their
//! values, and the plain mean of all of them, the first ones included, is unbiased. For the same reason shares are
//! decided once: later samples of a neighbour are as many as this pixel's first ones asked for.
//!
//! The price is that shares add up to the number of pixels only nearly: a pixel that alone makes most of the changes
//! around it is measured by what the picture would be without it.

use dapple_camera::Film;
use dapple_math::PixelRect;
use dapple_sampling::Key;

/// Samples of every pixel before the shares are decided.
pub const PILOT: u32 = 16;

/// Pixels to each side whose samples decide about the one between them.
const REACH: u32 = 2;

/// Part of the further samples that all pixels get alike: what the first ones have not seen is still looked for.
const EVEN: f64 = 0.25;

/// The share of every pixel in the samples that follow the first ones; 1 on average, but for pixels that stand out alone.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleAllocation {
    rect: PixelRect,
    shares: Vec<f64>,
}

impl SampleAllocation {
    /// Samples that a pixel has when it is `spp` on average: all the same up to [`PILOT`], then by share, rounded up or
    /// down by chance so that no share is lost. Never falls as `spp` grows.
    pub fn count(&self, x: u32, y: u32, spp: u32) -> u32 {
        if spp <= PILOT || !self.rect.contains(x, y) {
            return spp;
        }
        let i = (y - self.rect.y0) as usize * self.rect.width() as usize + (x - self.rect.x0) as usize;
        let chance = (Key::pixel(0x5b4e_ad00, x, y).bits() >> 11) as f64 / (1u64 << 53) as f64;
        let more = f64::from(spp - PILOT) * self.shares[i] + chance;
        PILOT.saturating_add(more as u32)
    }

    /// From the pictures of half the pilot's samples and of all of them, and the rays that each pixel took: how much a
    /// pixel changed when its samples doubled says how much it would gain, whatever the points.
    pub(crate) fn decide(half: &Film, whole: &Film, rays: &[u64]) -> Self {
        let rect = whole.rect();
        let change = |(x, y)| (whole.mean_at(x, y) - half.mean_at(x, y)).length_squared();
        let cost = |rays: &u64| f64::from(PILOT) + *rays as f64;
        let first: Vec<First> =
            pixels(rect).zip(rays).map(|(p, r)| First { change: change(p), cost: cost(r) }).collect();
        let wishes = Wishes::new(rect, &first);
        let shares = pixels(rect).map(|p| wishes.share(p)).collect();
        Self { rect, shares }
    }
}

/// What the first samples of a pixel say: its squared change, and what its samples cost.
#[derive(Clone, Copy, Debug, Default)]
struct First {
    change: f64,
    cost: f64,
}

/// How many samples every pixel should have by what the pixels around it say, but for a factor.
struct Wishes<'a> {
    rect: PixelRect,
    first: &'a [First],
    /// Of every pixel; `None` if there is none around it.
    wanted: Vec<Option<f64>>,
    /// Sums and numbers of the wishes left and right of every column within its row, the column itself left out.
    left: Vec<(f64, f64)>,
    right: Vec<(f64, f64)>,
    /// Sums and numbers of the wishes above and below every row.
    above: Vec<(f64, f64)>,
    below: Vec<(f64, f64)>,
}

impl<'a> Wishes<'a> {
    fn new(rect: PixelRect, first: &'a [First]) -> Self {
        let none = Vec::new();
        let mut all =
            Self { rect, first, wanted: none, left: vec![], right: vec![], above: vec![], below: vec![] };
        all.wanted = pixels(rect).map(|p| all.wish(p, None)).collect();
        let mut rows = Vec::new();
        for row in all.wanted.chunks(rect.width().max(1) as usize) {
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

    /// Pixels around (x, y) and itself.
    fn near(&self, (x, y): (u32, u32)) -> PixelRect {
        let (x0, y0) = (x.saturating_sub(REACH), y.saturating_sub(REACH));
        let (x1, y1) = (x.saturating_add(REACH + 1), y.saturating_add(REACH + 1));
        PixelRect { x0, y0, x1, y1 }.intersection(&self.rect)
    }

    /// The root of the mean squared change over the mean cost of the pixels around `pixel`, `pixel` itself and `without`
    /// left out; `None` if there are none.
    fn wish(&self, pixel: (u32, u32), without: Option<(u32, u32)>) -> Option<f64> {
        let around = pixels(self.near(pixel)).filter(|p| *p != pixel && Some(*p) != without);
        let add = |s: First, f: &First| First { change: s.change + f.change, cost: s.cost + f.cost };
        let sum = around.clone().map(|p| &self.first[self.index(p)]).fold(First::default(), add);
        let n = around.count() as f64;
        // The mean cost is one sample's at least, as in a picture that takes no rays.
        (n > 0.0).then(|| (sum.change / sum.cost.max(n)).sqrt())
    }

    /// The share of `pixel`: its wish over the mean of all wishes as they are without its samples. They are added up from
    /// parts none of which knows of the pixel, so that not even rounding tells of it.
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
        sum = pixels(near).fold(sum, |sum, p| plus(sum, counted(&self.wish(p, Some(pixel)))));
        let (mean, own) = (sum.0 / sum.1.max(1.0), self.wanted[self.index(pixel)].unwrap_or_default());
        if mean > 0.0 && mean.is_finite() { EVEN + (1.0 - EVEN) * own / mean } else { 1.0 }
    }
}

/// A wish as a sum of one; none counts nothing.
fn counted(wish: &Option<f64>) -> (f64, f64) {
    wish.map_or((0.0, 0.0), |wish| (wish, 1.0))
}

fn plus(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 + b.0, a.1 + b.1)
}

/// The sums of all before each.
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

    /// Left half black, right half of deviation 1; one wild pixel at (5, 6).
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

    /// Shares of a picture without a wild pixel add up to one each, and with one to what the others make of it.
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

    /// A wild pixel calls samples to its neighbours, not to itself.
    #[test]
    fn no_pixel_decides_about_itself() {
        let allocation = allocation();
        assert!(allocation.count(6, 6, 1016) > 2000 && allocation.count(5, 8, 1016) > 2000);
        assert!(allocation.count(8, 6, 1016) <= 267);
    }

    /// Whatever a pixel's own samples and rays are, its share is the same to the last bit; those of others are not.
    #[test]
    fn own_samples_do_not_change_the_own_share() {
        let rect = PixelRect { x0: 1, y0: 2, x1: 14, y1: 11 };
        let noise = |x: u32, y: u32| (Key::pixel(9, x, y).bits() >> 40) as f64 / (1u64 << 24) as f64;
        let first = |x, y| First { change: noise(x, y).powi(8), cost: 16.0 + 99.0 * noise(y, x) };
        let all: Vec<First> = pixels(rect).map(|(x, y)| first(x, y)).collect();
        let whole = Wishes::new(rect, &all);
        for pixel in pixels(rect) {
            for value in [0.0, 1e-9, 1e9] {
                let mut other = all.clone();
                other[whole.index(pixel)] = First { change: value, cost: 16.0 + value };
                let other = Wishes::new(rect, &other);
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
