//! Estimates the mean height of a cosine-weighted hemisphere, 2/3, over padded Sobol points, one lane and many at a time,
//! and the mean of a table by its samples.
//! `cargo run --release --example point_lanes -p dapple-sampling`

use dapple_math::lanes::{Isa, Kernel, Real, Vec2x, Word, dispatch};
use dapple_sampling::lanes::pattern::{self, Index};
use dapple_sampling::lanes::{Keyx, warp};
use dapple_sampling::{Grid2d, Pattern};
use std::time::Instant;

/// Sums the heights of `n` directions, and the columns of as many samples of a table.
struct Means<'a> {
    pattern: Pattern,
    n: u32,
    grid: &'a Grid2d,
}

impl Kernel for Means<'_> {
    type Output = [f64; 2];
    #[inline(always)]
    fn run<R: Real>(self) -> [f64; 2] {
        let (mut height, mut column) = (0.0, 0.0);
        let zero = R::Word::splat(0);
        let key = Keyx::pixel(7, zero, zero);
        for s in (0..self.n).step_by(R::LANES) {
            let s = Index::new(R::Word::splat(s).wrapping_add(R::Word::lane_index()));
            let u = pattern::padded_2d(self.pattern, s, [self.n, 1], key.at(zero, 4u32));
            let x = pattern::padded_1d(self.pattern, s, self.n, key.at(zero, 5u32));
            let point = self.grid.sample_lanes(Vec2x::new(x, u.y)).point;
            let (mut heights, mut columns) = ([0.0; 16], [0.0; 16]);
            warp::hemisphere_cosine(u).z.store(&mut heights);
            point.x.store(&mut columns);
            for i in 0..R::LANES {
                height += f64::from(heights[i]);
                column += f64::from(columns[i]);
            }
        }
        [height / f64::from(self.n), column / f64::from(self.n)]
    }
}

fn main() {
    let weights: Vec<f64> = (0..64 * 32).map(|i| f64::from(i % 64)).collect();
    let Some(grid) = Grid2d::new(64, 32, &weights) else { return };
    for pattern in [Pattern::Sobol, Pattern::Stratified, Pattern::Random] {
        for isa in Isa::available() {
            let start = Instant::now();
            let n = 1 << 20;
            let [height, column] = dispatch(isa, Means { pattern, n, grid: &grid });
            let ns = start.elapsed().as_secs_f64() * 1e9 / f64::from(n);
            println!("{pattern:10} {:9} {height:.7} {column:.7} {ns:6.1} ns per sample", isa.name());
        }
    }
}
