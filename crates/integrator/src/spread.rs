//! Which pixels get how many samples?
//!
//! The error of a picture is smallest, at the same cost, when a pixel's samples follow σ/√c: its deviation over the
//! root of what a sample costs (the minimum of Σ σ²/n at a fixed Σ c·n). Both are guessed once, from the first
//! [`PILOT`] samples.
//!
//! A pixel whose own first samples decided how many more it gets would be biased: one that happened to miss the light
//! would stop, one that happened to find it would go on. Here a pixel's share follows from the samples of the pixels
//! around it, never from its own. Samples of different pixels are independent, so all of a pixel's samples, the first
//! ones included, are a fair set, whatever its share. For the same reason shares are decided once: later samples of a
//! neighbour are as many as this pixel's first ones asked for.

use dapple_camera::{Film, PixelRect};
use dapple_sampling::Key;

/// Samples of every pixel before the shares are decided.
pub const PILOT: u32 = 16;

/// Pixels to each side whose samples decide about the one between them.
const REACH: u32 = 2;

/// Part of the further samples that all pixels get alike: what the first ones have not seen is still looked for.
const EVEN: f64 = 0.25;

/// The share of every pixel in the samples that follow the first ones; 1 on average.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    rect: PixelRect,
    shares: Vec<f64>,
}

impl Spread {
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
        let changes: Vec<f64> =
            pixels(rect).map(|(x, y)| (whole.mean_at(x, y) - half.mean_at(x, y)).length_squared()).collect();
        let costs: Vec<f64> = rays.iter().map(|r| f64::from(PILOT) + *r as f64).collect();
        let (changes, costs) = (around(rect, &changes), around(rect, &costs));
        let wanted = changes.iter().zip(&costs).map(|(e, c)| (e / c.max(1.0)).sqrt());
        let wanted: Vec<f64> = wanted.collect();
        let mean = wanted.iter().sum::<f64>() / wanted.len().max(1) as f64;
        let share =
            |w: &f64| if mean > 0.0 && mean.is_finite() { EVEN + (1.0 - EVEN) * w / mean } else { 1.0 };
        Self { rect, shares: wanted.iter().map(share).collect() }
    }
}

fn pixels(rect: PixelRect) -> impl Iterator<Item = (u32, u32)> {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}

/// Of every pixel, the mean over those around it, itself left out; a picture of one pixel has none.
fn around(rect: PixelRect, values: &[f64]) -> Vec<f64> {
    let one = |(x, y): (u32, u32)| {
        let near = PixelRect {
            x0: x.saturating_sub(REACH),
            y0: y.saturating_sub(REACH),
            x1: x + REACH + 1,
            y1: y + REACH + 1,
        };
        let (mut sum, mut n) = (0.0, 0.0);
        for (u, v) in pixels(near.intersection(&rect)).filter(|p| *p != (x, y)) {
            sum += values[((v - rect.y0) * rect.width() + (u - rect.x0)) as usize];
            n += 1.0;
        }
        if n > 0.0 { sum / n } else { 1.0 }
    };
    pixels(rect).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const RECT: PixelRect = PixelRect { x0: 2, y0: 3, x1: 34, y1: 23 };

    /// Left half black, right half of deviation 1; one wild pixel at (5, 6).
    fn spread() -> Spread {
        let (mut half, mut whole) = (Film::new(RECT), Film::new(RECT));
        for (x, y) in pixels(RECT) {
            let sign = if (x + y).is_multiple_of(2) { 1.0 } else { -1.0 };
            let value = if (x, y) == (5, 6) { 1e3 } else { sign * f32::from(u8::from(x >= 18)) };
            half.add(x, y, Vec3::ZERO, 1.0);
            whole.add(x, y, Vec3::splat(value), 1.0);
        }
        Spread::decide(&half, &whole, &vec![48; RECT.area()])
    }

    #[test]
    fn samples_go_where_the_changes_are_and_none_is_lost() {
        let spread = spread();
        let shares: f64 = spread.shares.iter().sum();
        assert!((shares / RECT.area() as f64 - 1.0).abs() < 1e-12);
        assert!(pixels(RECT).all(|(x, y)| (0..=PILOT).all(|n| spread.count(x, y, n) == n)));
        let total = |spp| pixels(RECT).map(|(x, y)| f64::from(spread.count(x, y, spp))).sum::<f64>();
        for spp in [17, 20, 64, 1000] {
            let off = total(spp) / (RECT.area() as f64 * f64::from(spp)) - 1.0;
            assert!(off.abs() < 0.01, "{spp}: {off}");
        }
        assert!(spread.count(8, 20, 1016) == 266 || spread.count(8, 20, 1016) == 267);
        assert!(spread.count(30, 10, 116) > spread.count(8, 20, 116));
        assert!((16..2000).all(|n| spread.count(30, 10, n) <= spread.count(30, 10, n + 1)));
    }

    /// A wild pixel calls samples to its neighbours, not to itself.
    #[test]
    fn no_pixel_decides_about_itself() {
        let spread = spread();
        assert!(spread.count(5, 6, 1016) <= 267);
        assert!(spread.count(6, 6, 1016) > 2000 && spread.count(5, 8, 1016) > 2000);
        assert!(spread.count(8, 6, 1016) <= 267);
    }

    #[test]
    fn where_nothing_changes_all_get_the_same() {
        let film = Film::new(RECT);
        let spread = Spread::decide(&film, &film, &vec![16; RECT.area()]);
        assert!(pixels(RECT).all(|(x, y)| spread.count(x, y, 500) == 500));
        let one = PixelRect { x0: 0, y0: 0, x1: 1, y1: 1 };
        assert_eq!(Spread::decide(&Film::new(one), &Film::new(one), &[16]).count(0, 0, 99), 99);
    }
}
