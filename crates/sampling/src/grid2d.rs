//! Piecewise constant densities on a grid over the unit square. Sampling inverts the marginal distribution of the rows
//! and the conditional distribution of the row, so that stratified points stay stratified and cells of weight 0 are never
//! sampled.

use crate::table::Table;
use dapple_math::lanes::{Real, Vec2x, Word};
use glam::Vec2;

/// A piecewise constant density on `width`×`height` cells, with row 0 at y = 0.
#[derive(Clone, Debug)]
pub struct Grid2d {
    rows: Table,
    /// The conditional distribution of every row.
    columns: Table,
    /// Edges of the columns and rows.
    edges: [Edges; 2],
}

/// A point of the unit square, the cell it lies in, and its density with respect to the unit square.
#[derive(Clone, Copy, Debug)]
pub struct GridSample {
    /// The point in [0,1)².
    pub point: Vec2,
    /// Column and row of the cell.
    pub cell: (u32, u32),
    /// Position within the cell, in [0,1)².
    pub within: Vec2,
    /// Probability density, with ∫ pdf = 1 over the unit square.
    pub pdf: f32,
}

/// Points as in [`GridSample`], one per lane.
#[derive(Clone, Copy, Debug)]
pub struct GridSamplex<R: Real> {
    /// The point in [0,1)².
    pub point: Vec2x<R>,
    /// Column and row of the cell.
    pub cell: [R::Word; 2],
    /// Position within the cell, in [0,1)².
    pub within: Vec2x<R>,
    /// Probability density, with ∫ pdf = 1 over the unit square.
    pub pdf: R,
}

impl Grid2d {
    /// Creates the density from `width`·`height` weights in row-major order. It is None when the sum is zero, a weight
    /// is negative or not finite, the number of weights is wrong, or there are about 2³⁰ cells or more.
    pub fn new(width: usize, height: usize, weights: &[f64]) -> Option<Self> {
        if width == 0
            || weights.len() != width.checked_mul(height)?
            || weights.iter().any(|w| !w.is_finite() || *w < 0.0)
        {
            return None;
        }
        let mut columns = Table::new(width, height)?;
        let sums: Vec<f64> = weights.chunks(width).map(|row| columns.push(row).unwrap_or(0.0)).collect();
        let mut rows = Table::new(height, 1)?;
        rows.push(&sums)?;
        Some(Self { rows, columns, edges: [Edges::new(width), Edges::new(height)] })
    }

    /// Samples a point by `u` in [0,1)²: y from the marginal distribution, x from the conditional distribution of the
    /// row.
    pub fn sample(&self, u: Vec2) -> GridSample {
        let GridSamplex { point, cell: [column, row], within, pdf } = self.sample_lanes::<f32>(u.into());
        GridSample { point: point.into(), cell: (column, row), within: within.into(), pdf }
    }

    /// Samples a point per lane, as [`Grid2d::sample`] does.
    #[inline(always)]
    pub fn sample_lanes<R: Real>(&self, u: Vec2x<R>) -> GridSamplex<R> {
        let row = self.rows.sample(R::Word::splat(0), u.y);
        let column = self.columns.sample(row.index, u.x);
        let [x, y] = &self.edges;
        GridSamplex {
            point: Vec2x::new(x.inside(column.index, column.u), y.inside(row.index, row.u)),
            cell: [column.index, row.index],
            within: Vec2x::new(column.u, row.u),
            pdf: self.density(row.pmf, column.pmf),
        }
    }

    /// Returns the density at `point`, which is clamped to the unit square.
    pub fn pdf(&self, point: Vec2) -> f32 {
        self.pdf_lanes::<f32>(point.into())
    }

    /// Returns the density at a point per lane, as [`Grid2d::pdf`] does.
    #[inline(always)]
    pub fn pdf_lanes<R: Real>(&self, point: Vec2x<R>) -> R {
        let [x, y] = &self.edges;
        self.cell_pdf_lanes(x.cell(point.x), y.cell(point.y))
    }

    /// Returns the density within a cell; 0 if there is no such cell.
    pub fn cell_pdf(&self, column: u32, row: u32) -> f32 {
        if column as usize >= self.columns.bins() || row as usize >= self.rows.bins() {
            return 0.0;
        }
        self.cell_pdf_lanes::<f32>(column, row)
    }

    /// Returns the density within a cell per lane, which has to be one of the grid.
    #[inline(always)]
    pub fn cell_pdf_lanes<R: Real>(&self, column: R::Word, row: R::Word) -> R {
        self.density(self.rows.pmf(R::Word::splat(0), row), self.columns.pmf(row, column))
    }

    #[inline(always)]
    fn density<R: Real>(&self, row: R, column: R) -> R {
        // In an order in which the product of two small probabilities does not underflow.
        let (width, height) = (self.columns.bins() as f32, self.rows.bins() as f32);
        (row * R::splat(height)) * (column * R::splat(width))
    }
}

/// Number i is the smallest f32 that is not below i/n, for i ≤ n.
#[derive(Clone, Debug)]
struct Edges(Vec<f32>);

impl Edges {
    fn new(n: usize) -> Self {
        // The product of an f32 and a count is exact in f64.
        let is_below = |x: f32, i: usize| f64::from(x) * (n as f64) < i as f64;
        let edge = |i| {
            let x = (i as f64 / n as f64) as f32;
            if is_below(x, i) {
                x.next_up()
            } else if i > 0 && !is_below(x.next_down(), i) {
                x.next_down()
            } else {
                x
            }
        };
        Self((0..=n).map(edge).collect())
    }

    /// Returns (index + place)/n, within the interval also after rounding, because the adjacent one may have weight 0.
    #[inline(always)]
    fn inside<R: Real>(&self, index: R::Word, place: R) -> R {
        let (low, high) = self.ends::<R>(index);
        let x = (index.int_to_real() + place) / R::splat(self.count() as f32);
        let before_high = R::from_bits(high.to_bits().wrapping_sub(R::Word::splat(1)));
        x.max(low).min(before_high)
    }

    /// Returns the interval of `x`, which is clamped to 0..n.
    #[inline(always)]
    fn cell<R: Real>(&self, x: R) -> R::Word {
        let (zero, one) = (R::Word::splat(0), R::Word::splat(1));
        let last = R::Word::splat(self.count() as u32 - 1);
        let x = x.max(R::splat(0.0)).min(R::splat(1.0));
        let near = (x * R::splat(self.count() as f32)).to_int();
        let near = R::Word::select(near.lt(last), near, last);
        // The product in f32 is off by one interval at most.
        let (low, high) = self.ends::<R>(near);
        let down = x.lt(low) & zero.lt(near);
        let up = high.le(x) & near.lt(last);
        let near = R::Word::select(down, near.wrapping_sub(one), near);
        R::Word::select(up, near.wrapping_add(one), near)
    }

    #[inline(always)]
    fn ends<R: Real>(&self, index: R::Word) -> (R, R) {
        (R::gather(&self.0, index), R::gather(&self.0, index.wrapping_add(R::Word::splat(1))))
    }

    #[inline(always)]
    fn count(&self) -> usize {
        self.0.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every second cell has weight 0, and the points cover the positions where rounding matters.
    #[test]
    fn points_stay_in_cells_with_weight() {
        for n in [3usize, 7, 100, 999, 4097] {
            let weights: Vec<f64> = (0..n).map(|i| f64::from(i % 2 == 0)).collect();
            let g = Grid2d::new(n, 1, &weights).unwrap();
            for i in 0..1 << 16 {
                for u in [i as f32 / 65_536.0, (i as f32 + 1.0).next_down() / 65_536.0] {
                    let s = g.sample(Vec2::new(u, 1.0 - f32::EPSILON / 2.0));
                    assert!(s.point.x < 1.0 && s.point.y < 1.0);
                    assert!(s.pdf > 0.0 && g.pdf(s.point) == s.pdf, "{n} {u} {s:?}");
                }
            }
        }
    }

    #[test]
    fn samples_have_their_density() {
        let g = Grid2d::new(3, 2, &[1.0, 0.0, 2.0, 0.0, 0.0, 5.0]).unwrap();
        let mut counts = [0u32; 6];
        let n = 400;
        for i in 0..n * n {
            let s = g.sample(Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32);
            counts[s.cell.1 as usize * 3 + s.cell.0 as usize] += 1;
            assert_eq!(s.pdf, g.pdf(s.point));
        }
        for (count, weight) in counts.iter().zip([1.0, 0.0, 2.0, 0.0, 0.0, 5.0]) {
            let expected = weight / 8.0 * f64::from(n * n);
            assert!((f64::from(*count) - expected).abs() <= 2.0 * f64::from(n), "{count} {expected}");
        }
        assert_eq!(counts[1], 0);
    }

    #[test]
    fn nothing_to_sample_is_none() {
        assert!(Grid2d::new(2, 2, &[0.0; 4]).is_none());
        assert!(Grid2d::new(2, 2, &[1.0; 3]).is_none());
        assert!(Grid2d::new(0, 0, &[]).is_none());
    }
}
