//! Points, warps, weights and tables over lanes: the same bits with every instruction set, and those of the scalar
//! functions.

use dapple_math::lanes::{Isa, Kernel, Real, Vec2x, Vec3x, Word, dispatch};
use dapple_sampling::lanes::pattern::{self, Index};
use dapple_sampling::lanes::{Keyx, mis, warp};
use dapple_sampling::pattern::nearest_square;
use dapple_sampling::{Discrete, Grid2d, Key, Pattern, padded_1d, padded_2d, point_1d, point_2d};
use dapple_testkit::Rng;

const PATTERNS: [Pattern; 4] = [Pattern::Grid, Pattern::Random, Pattern::Stratified, Pattern::Sobol];

/// Bits of all results of a kernel, a column per result.
type Columns = Vec<Vec<u32>>;

/// Runs a kernel with every instruction set, compares the bits, and returns them. NaN have no specified bits.
fn same<K: Kernel<Output = Columns> + Copy>(kernel: K) -> Columns {
    let portable = dispatch(Isa::Portable, kernel);
    for isa in Isa::available() {
        for (c, (a, b)) in portable.iter().zip(dispatch(isa, kernel)).enumerate() {
            assert_eq!(a.len(), b.len());
            for (i, (&a, &b)) in a.iter().zip(&b).enumerate() {
                let is_nan = f32::from_bits(a).is_nan() && f32::from_bits(b).is_nan();
                assert!(a == b || is_nan, "column {c}, number {i}: {a:#x} portable, {b:#x} {}", isa.name());
            }
        }
    }
    portable
}

/// Appends the lanes of up to `count` numbers to a column.
#[inline(always)]
fn write<W: Word>(columns: &mut Columns, column: usize, count: usize, x: W) {
    let mut lanes = [0; 16];
    x.store(&mut lanes);
    if columns.len() <= column {
        columns.resize(column + 1, Vec::new());
    }
    columns[column].extend(&lanes[..count.min(W::Real::LANES)]);
}

#[inline(always)]
fn write_all<R: Real, const N: usize>(columns: &mut Columns, count: usize, x: [R; N]) {
    for (i, x) in x.into_iter().enumerate() {
        write(columns, i, count, x.to_bits());
    }
}

/// Sample numbers, pixels, depths.
#[derive(Clone, Copy)]
struct Points<'a> {
    pattern: Pattern,
    n: u32,
    s: &'a [u32],
    x: &'a [u32],
    depth: &'a [u32],
}

impl Kernel for Points<'_> {
    type Output = Columns;
    #[inline(always)]
    fn run<R: Real>(self) -> Columns {
        let mut out = Columns::new();
        for i in (0..self.s.len()).step_by(R::LANES) {
            let [s, x, depth] = [self.s, self.x, self.depth].map(|from| R::Word::load(&from[i..]));
            let key = Keyx::pixel(77, x, s ^ x).branch(x).at(depth, 4u32);
            let (n, size, s) = (self.n, nearest_square(self.n), Index::new(s));
            let (p, q) = (
                pattern::point_2d(self.pattern, s, size, key),
                pattern::padded_2d(self.pattern, s, size, key),
            );
            let (a, b) =
                (pattern::point_1d(self.pattern, s, n, key), pattern::padded_1d(self.pattern, s, n, key));
            write_all(&mut out, self.s.len() - i, [p.x, p.y, q.x, q.y, a, b, key.unit()]);
        }
        out
    }
}

#[test]
fn points_are_the_same_in_every_lane() {
    let mut rng = Rng::new(1);
    for n in [1u32, 2, 7, 13, 16, 48, 64, 1000, 99_991, 1 << 24, (1 << 25) + 3, (1 << 30) + 1, u32::MAX] {
        let special = [0, 1, n - 1, n, n.wrapping_add(1), n / 2, u32::MAX, 1 << 31];
        let below = |rng: &mut Rng| rng.below(n.min(1 << 31));
        let s: Vec<u32> = special
            .into_iter()
            .chain((0..300).map(|i| if i % 4 == 0 { rng.bits() as u32 } else { below(&mut rng) }))
            .collect();
        let [x, depth] = [7, 9].map(|shift| s.iter().map(|s| s.rotate_left(shift) ^ 5).collect::<Vec<u32>>());
        for pattern in PATTERNS {
            let columns = same(Points { pattern, n, s: &s, x: &x, depth: &depth });
            for (i, &s) in s.iter().enumerate() {
                let key = Key::pixel(77, x[i], s ^ x[i]).branch(x[i]).at(depth[i], 4u32);
                let (p, q) = (point_2d(pattern, s, n, key), padded_2d(pattern, s, n, key));
                let (a, b) = (point_1d(pattern, s, n, key), padded_1d(pattern, s, n, key));
                for (column, x) in columns.iter().zip([p.x, p.y, q.x, q.y, a, b, key.unit()]) {
                    assert_eq!(column[i], x.to_bits(), "{pattern} {s} of {n}");
                }
            }
        }
    }
}

/// Pairs of numbers for warps and weights.
#[derive(Clone, Copy)]
struct Warps<'a> {
    x: &'a [f32],
    y: &'a [f32],
}

impl Kernel for Warps<'_> {
    type Output = Columns;
    #[inline(always)]
    fn run<R: Real>(self) -> Columns {
        let mut out = Columns::new();
        for i in (0..self.x.len()).step_by(R::LANES) {
            let (x, y) = (R::load(&self.x[i..]), R::load(&self.y[i..]));
            let u = Vec2x::new(x, y);
            let [disk, triangle] = [warp::disk(u), warp::triangle(u)];
            let [five, square] = [warp::polygon(u, 5, 0.3), warp::square(u)];
            let [up, narrow] = [warp::hemisphere_cosine(u), warp::cone(u, y)];
            let Vec3x { x: a, y: b, z: c } = warp::sphere(u);
            let columns = [
                [disk.x, disk.y, triangle.x, triangle.y],
                [five.x, five.y, square.x, square.y],
                [up.x, up.y, up.z, warp::hemisphere_cosine_pdf(x)],
                [narrow.x, narrow.y, narrow.z, warp::cone_pdf(y)],
                [a, b, c, warp::tent(x, y)],
                [warp::tent_pdf(x, y), mis::power(x, y), mis::balance(x, y), mis::power(y, x)],
            ];
            for (k, x) in columns.into_iter().flatten().enumerate() {
                write(&mut out, k, self.x.len() - i, x.to_bits());
            }
        }
        out
    }
}

/// Numbers of the unit interval, of all magnitudes, and special ones.
fn numbers(rng: &mut Rng, n: usize) -> Vec<f32> {
    let special =
        [0.0, -0.0, 0.5, 1.0, 1.0 - f32::EPSILON / 2.0, 2.0, -1.0, f32::INFINITY, f32::NAN, f32::MAX, 1e-40];
    let random = (0..n).map(|i| if i % 3 == 0 { f32::from_bits(rng.bits() as u32) } else { rng.f32() });
    special.into_iter().chain(random.collect::<Vec<_>>()).collect()
}

#[test]
fn warps_and_weights_are_the_same_in_every_lane() {
    let mut rng = Rng::new(2);
    let x = numbers(&mut rng, 5000);
    let mut y = numbers(&mut rng, 5000);
    y.rotate_left(3);
    same(Warps { x: &x, y: &y });
}

#[derive(Clone, Copy)]
struct Tables<'a> {
    discrete: &'a Discrete,
    grid: &'a Grid2d,
    x: &'a [f32],
    y: &'a [f32],
}

impl Kernel for Tables<'_> {
    type Output = Columns;
    #[inline(always)]
    fn run<R: Real>(self) -> Columns {
        let mut out = Columns::new();
        for i in (0..self.x.len()).step_by(R::LANES) {
            let (x, y) = (R::load(&self.x[i..]), R::load(&self.y[i..]));
            let (c, g) = (self.discrete.sample_lanes(x), self.grid.sample_lanes(Vec2x::new(x, y)));
            let pdfs = [self.discrete.pmf_lanes::<R>(c.index), self.grid.pdf_lanes(Vec2x::new(x, y))];
            let numbers = [c.u, c.pmf, pdfs[0], g.point.x, g.point.y, g.within.x, g.within.y, g.pdf, pdfs[1]];
            write_all(&mut out, self.x.len() - i, numbers);
            for (k, index) in [c.index, g.cell[0], g.cell[1]].into_iter().enumerate() {
                write(&mut out, 9 + k, self.x.len() - i, index);
            }
        }
        out
    }
}

/// The index is that of an exact search of the cumulative weights, for tables of even and very uneven weights.
#[test]
fn tables_are_the_same_in_every_lane_and_exact() {
    let mut rng = Rng::new(3);
    let x = numbers(&mut rng, 5000);
    let mut y = numbers(&mut rng, 5000);
    y.rotate_left(5);
    for n in [1usize, 2, 5, 64, 1000, 30_000] {
        let even = |i: usize| 1.0 + (i * 37 % 101) as f64;
        let weight = |i: usize| match i % 7 {
            0 => 0.0,
            1 => 1e-9,
            _ => even(i) * 10f64.powi((i % 5) as i32 * 3),
        };
        for weights in [(0..n).map(even).collect::<Vec<_>>(), (1..=n).map(weight).collect()] {
            let (discrete, grid) = (Discrete::new(&weights).unwrap(), Grid2d::new(n, 1, &weights).unwrap());
            let columns = same(Tables { discrete: &discrete, grid: &grid, x: &x, y: &y });
            let sum: f64 = weights.iter().sum();
            let mut running = 0.0;
            let edges: Vec<f64> = weights
                .iter()
                .map(|w| {
                    running += w;
                    running / sum
                })
                .collect();
            let last = weights.iter().rposition(|w| *w > 0.0).unwrap();
            for (i, &u) in x.iter().enumerate() {
                let u = if u > 0.0 { u.min(1.0 - f32::EPSILON / 2.0) } else { 0.0 };
                let exact = edges.partition_point(|&edge| edge <= f64::from(u)).min(last);
                assert_eq!(columns[9][i] as usize, exact, "{u} of {n}");
                assert_eq!(discrete.sample(x[i]).index, exact);
                assert_eq!(f32::from_bits(columns[1][i]), discrete.pmf(exact));
            }
        }
    }
}
