//! Importance sampling of image blocks (or single pixels) that represent the whole image.
//!
//! Blocks are drawn with a probability that follows the variance within their pixels. This variance is too large for
//! evenly distributed points, but it locates the errors. Dividing by the probability makes the sum over the image
//! unbiased in any case.

use dapple_integrator::math::PixelRect;
use dapple_integrator::sampling::Key;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Share of the probability that is uniform over the image, so that every block can be drawn regardless of the samples
/// taken so far.
const EVEN: f64 = 0.5;

/// A block and its weight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Block {
    pub rect: PixelRect,
    pub weight: f64,
    /// Number of times the block was drawn.
    pub times: u32,
}

/// All blocks of `side`² pixels in `rect`, row by row.
fn all(rect: PixelRect, side: u32) -> Vec<PixelRect> {
    let row = |y0: u32| {
        let block =
            move |x0: u32| PixelRect { x0, y0, x1: (x0 + side).min(rect.x1), y1: (y0 + side).min(rect.y1) };
        (rect.x0..rect.x1).step_by(side as usize).map(block)
    };
    (rect.y0..rect.y1).step_by(side as usize).flat_map(row).collect()
}

/// As [`drawn`], but returns every block once if there are no more blocks than draws.
pub(crate) fn chosen(rect: PixelRect, side: u32, within: &[f64], seed: u64, draws: usize) -> Vec<Block> {
    let all = all(rect, side);
    match draws >= all.len() {
        true => all.into_iter().map(|rect| Block { rect, weight: 1.0, times: 1 }).collect(),
        false => drawn(rect, side, within, seed, draws),
    }
}

/// Draws blocks of `rect`, whose pixels have the variances `within`, in `draws` draws at equal steps along their
/// cumulative probabilities. The weight of a block is proportional to the number of times it was drawn.
pub(crate) fn drawn(rect: PixelRect, side: u32, within: &[f64], seed: u64, draws: usize) -> Vec<Block> {
    let all = all(rect, side);
    let probability = probabilities(rect, &all, within);
    let u = (Key::pixel(seed, 0, 0xb10c).bits() >> 11) as f64 / (1u64 << 53) as f64;
    let mut times: BTreeMap<usize, u32> = BTreeMap::new();
    let (mut at, mut below) = (0, probability.first().copied().unwrap_or_default());
    for j in 0..draws {
        let wanted = (j as f64 + u) / draws as f64;
        while below < wanted && at + 1 < all.len() {
            at += 1;
            below += probability[at];
        }
        *times.entry(at).or_default() += 1;
    }
    let weight = |i: usize, times: u32| f64::from(times) / (draws as f64 * probability[i]);
    let one = |(i, times): (usize, u32)| Block { rect: all[i], weight: weight(i, times), times };
    times.into_iter().map(one).collect()
}

/// The probability of each block; they add up to 1.
fn probabilities(rect: PixelRect, all: &[PixelRect], within: &[f64]) -> Vec<f64> {
    let at = |x: u32, y: u32| within[((y - rect.y0) * rect.width() + (x - rect.x0)) as usize];
    let sum = |r: &PixelRect| (r.y0..r.y1).flat_map(|y| (r.x0..r.x1).map(move |x| at(x, y))).sum::<f64>();
    let sums: Vec<f64> = all.iter().map(sum).collect();
    let (total, even): (f64, f64) = (sums.iter().sum(), 1.0 / all.len() as f64);
    let known = total > 0.0 && total.is_finite();
    let share = |sum: &f64| if known { sum / total } else { even };
    sums.iter().map(|sum| EVEN * even + (1.0 - EVEN) * share(sum)).collect()
}

/// Applies `work` to every block on the given number of threads. The results are in the order of the blocks, because
/// sums must not depend on the order of completion.
pub(crate) fn each<B: Sync, T: Send>(
    blocks: &[B],
    threads: Option<usize>,
    work: impl Fn(&B) -> T + Sync,
) -> Vec<T> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let turn = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(block) = blocks.get(i) else { return };
            let result = work(block);
            if let Ok(mut found) = found.lock() {
                found.insert(i, result);
            }
        }
    };
    std::thread::scope(|scope| {
        let threads = threads.unwrap_or(1).clamp(1, blocks.len().max(1));
        (1..threads).for_each(|_| drop(scope.spawn(turn)));
        turn();
    });
    found.into_inner().unwrap_or_default().into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECT: PixelRect = PixelRect { x0: 3, y0: 5, x1: 515, y1: 517 };

    #[test]
    fn blocks_are_spread_evenly_where_nothing_is_known() {
        for within in [vec![0.0; RECT.area()], vec![f64::INFINITY; RECT.area()]] {
            for (side, weight) in [(8, 32.0), (1, 2048.0)] {
                let blocks = chosen(RECT, side, &within, 7, 128);
                assert_eq!(blocks.len(), 128);
                let area = (side * side) as usize;
                let inside = |r: PixelRect| r.x1 <= RECT.x1 && r.y1 <= RECT.y1 && r.area() == area;
                assert!(blocks.iter().all(|b| inside(b.rect) && (b.weight - weight).abs() < 1e-9));
            }
        }
        let small = PixelRect { x0: 0, y0: 0, x1: 10, y1: 3 };
        let all = chosen(small, 8, &[1.0; 30], 0, 24);
        assert_eq!(all.iter().map(|b| b.rect.area()).sum::<usize>(), 30);
    }

    /// The weighted sum of any quantity over the blocks is unbiased, and nearly exact if the variances are proportional
    /// to the quantity.
    #[test]
    fn weights_make_up_for_the_choice() {
        let value = |i: usize| if i.is_multiple_of(511) { 50.0 } else { 1.0 + (i % 7) as f64 };
        let within: Vec<f64> = (0..RECT.area()).map(value).collect();
        let truth: f64 = within.iter().sum();
        for side in [8, 1] {
            let sum = |seed: u64| -> f64 {
                let at = |x: u32, y: u32| within[((y - 5) * 512 + (x - 3)) as usize];
                let blocks = drawn(RECT, side, &within, seed, 128);
                let one = |b: &Block| {
                    let r = b.rect;
                    let pixels = (r.y0..r.y1).flat_map(|y| (r.x0..r.x1).map(move |x| (x, y)));
                    b.weight * pixels.map(|(x, y)| at(x, y)).sum::<f64>()
                };
                blocks.iter().map(one).sum()
            };
            let sums: Vec<f64> = (0..200).map(|seed| sum(seed) / truth).collect();
            let mean = crate::statistics::mean(&sums, 0.9999).unwrap();
            assert!(mean.contains(1.0) && mean.high - mean.low < 0.03, "{side}: {mean:?}");
        }
    }

    #[test]
    fn who_is_drawn_often_counts_often() {
        let mut within = vec![1.0; 64];
        within[9] = 64.0;
        let drawn = drawn(PixelRect { x0: 0, y0: 0, x1: 8, y1: 8 }, 1, &within, 1, 256);
        assert_eq!(drawn.iter().map(|b| b.times).sum::<u32>(), 256);
        let bright = drawn.iter().find(|b| (b.rect.x0, b.rect.y0) == (1, 1)).unwrap();
        // Half of the draws follow 64/127, half are uniform; a pixel drawn so often has a weight near 1.
        assert!((66..=67).contains(&bright.times) && (bright.weight - 1.0).abs() < 0.02, "{bright:?}");
    }
}
