//! Blocks of a picture that stand for all of it.
//!
//! Blocks are chosen with a probability that follows the variance within their pixels: that is too large for points that
//! are spread evenly, but it knows where the errors are. Dividing by the probability makes the sum over the picture
//! unbiased whatever it knows.

use dapple_integrator::camera::PixelRect;
use dapple_integrator::sampling::Key;
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Side of a block in pixels.
const SIDE: u32 = 8;
/// Share of the choice that is even over the picture, so that no block is left to what the samples happened to see.
const EVEN: f64 = 0.25;

/// A block, and what it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    pub rect: PixelRect,
    pub weight: f64,
    /// How often it was drawn.
    pub times: u32,
}

/// How many blocks there are in `rect`.
pub(crate) fn count(rect: PixelRect) -> usize {
    rect.width().div_ceil(SIDE) as usize * rect.height().div_ceil(SIDE) as usize
}

/// Blocks of `rect`, whose pixels have the variances `within`, in `draws` draws at equal steps along their summed
/// probabilities. A block that is met more than once counts accordingly. All blocks, once each, if there are no more than
/// that.
pub(crate) fn chosen(rect: PixelRect, within: &[f64], seed: u64, draws: usize) -> Vec<Block> {
    let columns = rect.width().div_ceil(SIDE) as usize;
    let count = count(rect);
    let block = |i: usize| {
        let (x0, y0) = (rect.x0 + (i % columns) as u32 * SIDE, rect.y0 + (i / columns) as u32 * SIDE);
        PixelRect { x0, y0, x1: (x0 + SIDE).min(rect.x1), y1: (y0 + SIDE).min(rect.y1) }
    };
    if draws >= count {
        return (0..count).map(|i| Block { rect: block(i), weight: 1.0, times: 1 }).collect();
    }
    let mut sums = vec![0.0; count];
    for (i, v) in within.iter().enumerate() {
        let (x, y) = (i % rect.width() as usize, i / rect.width() as usize);
        sums[y / SIDE as usize * columns + x / SIDE as usize] += v;
    }
    let total: f64 = sums.iter().sum();
    let known = total > 0.0 && total.is_finite();
    let share = |sum: f64| if known { sum / total } else { 1.0 / count as f64 };
    let probability: Vec<f64> = sums.iter().map(|s| EVEN / count as f64 + (1.0 - EVEN) * share(*s)).collect();
    let u = (Key::pixel(seed, 0, 0xb10c).bits() >> 11) as f64 / (1u64 << 53) as f64;
    let mut times: BTreeMap<usize, u32> = BTreeMap::new();
    let (mut at, mut below) = (0, probability[0]);
    for j in 0..draws {
        let wanted = (j as f64 + u) / draws as f64;
        while below < wanted && at + 1 < count {
            at += 1;
            below += probability[at];
        }
        *times.entry(at).or_default() += 1;
    }
    let weight = |i: usize, times: u32| f64::from(times) / (draws as f64 * probability[i]);
    let one = |(i, times): (usize, u32)| Block { rect: block(i), weight: weight(i, times), times };
    times.into_iter().map(one).collect()
}

/// How much the choice of `blocks` matters to the sum of `values`, one of each block and weighted: the square of that
/// sum's relative standard deviation. Draws are at equal steps over the picture, so neighbours are compared
/// [Wolter 1984, estimator v2]; those of one block are alike. Nothing was chosen where all blocks are drawn.
pub(crate) fn spread(blocks: &[Block], values: &[f64]) -> f64 {
    let draws: f64 = blocks.iter().map(|b| f64::from(b.times)).sum();
    let one: Vec<f64> = blocks.iter().zip(values).map(|(b, v)| v / f64::from(b.times)).collect();
    let steps: f64 = one.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
    let sum: f64 = values.iter().sum();
    if sum > 0.0 && draws > 1.0 { draws / (2.0 * (draws - 1.0)) * steps / (sum * sum) } else { 0.0 }
}

/// `work` on every block, as many at a time as there are threads; the results in the order of the blocks, for sums must
/// not depend on who was first.
pub(crate) fn each<T: Send>(
    blocks: &[Block],
    threads: Option<usize>,
    work: impl Fn(&Block) -> T + Sync,
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
            let blocks = chosen(RECT, &within, 7, 128);
            assert_eq!(blocks.len(), 128);
            assert!(
                blocks.iter().all(|b| b.rect.x1 <= RECT.x1 && b.rect.y1 <= RECT.y1 && b.rect.area() == 64)
            );
            assert!(blocks.iter().all(|b| (b.weight - 32.0).abs() < 1e-9));
        }
        let small = PixelRect { x0: 0, y0: 0, x1: 10, y1: 3 };
        let all = chosen(small, &[1.0; 30], 0, 24);
        assert_eq!(all.iter().map(|b| b.rect.area()).sum::<usize>(), 30);
    }

    /// The weighted sum of anything over the blocks is unbiased, and where the variances say what is summed it is exact
    /// but for the even share.
    #[test]
    fn weights_make_up_for_the_choice() {
        let value = |i: usize| if i.is_multiple_of(511) { 50.0 } else { 1.0 + (i % 7) as f64 };
        let within: Vec<f64> = (0..RECT.area()).map(value).collect();
        let truth: f64 = within.iter().sum();
        let sum = |seed: u64| -> f64 {
            let at = |x: u32, y: u32| within[((y - 5) * 512 + (x - 3)) as usize];
            let blocks = chosen(RECT, &within, seed, 128);
            let one = |b: &Block| {
                let r = b.rect;
                let pixels = (r.y0..r.y1).flat_map(|y| (r.x0..r.x1).map(move |x| (x, y)));
                b.weight * pixels.map(|(x, y)| at(x, y)).sum::<f64>()
            };
            blocks.iter().map(one).sum()
        };
        let sums: Vec<f64> = (0..200).map(|seed| sum(seed) / truth).collect();
        let mean = crate::statistics::mean(&sums, 0.9999).unwrap();
        assert!(mean.contains(1.0) && mean.high - mean.low < 0.02, "{mean:?}");
    }

    /// The spread that one choice tells is on average that over choices.
    #[test]
    fn a_choice_knows_how_much_it_matters() {
        let within = vec![1.0; RECT.area()];
        let value = |seed: u64, r: PixelRect| 1.0 + (Key::pixel(seed, r.x0, r.y0).bits() >> 61) as f64;
        let one = |seed: u64| {
            let blocks = chosen(RECT, &within, seed, 100);
            let values: Vec<f64> = blocks.iter().map(|b| b.weight * value(seed, b.rect)).collect();
            let truth = 4.5 * 4096.0;
            ((values.iter().sum::<f64>() / truth - 1.0).powi(2), spread(&blocks, &values))
        };
        let (found, told): (f64, f64) =
            (0..400).map(one).fold((0.0, 0.0), |sum, x| (sum.0 + x.0, sum.1 + x.1));
        // A variance from 400 is known to 7 %; four times that.
        assert!((found / told - 1.0).abs() < 0.28 && told > 0.4, "{found} and {told}");
    }
}
