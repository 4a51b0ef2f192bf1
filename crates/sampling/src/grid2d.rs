//! Piecewise constant densities on a grid over the unit square. Sampling uses marginal and conditional tables in f64,
//! so that stratified points stay stratified and cells of weight 0 are never sampled.

use crate::Discrete;
use glam::Vec2;
use std::cmp::Ordering;

/// A piecewise constant density on `width`×`height` cells, with row 0 at y = 0.
#[derive(Clone, Debug)]
pub struct Grid2d {
    rows: Discrete,
    /// One conditional table per row; None for rows of weight 0.
    columns: Vec<Option<Discrete>>,
    width: usize,
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

impl Grid2d {
    /// Creates the density from `width`·`height` weights in row-major order. It is None when the sum is zero, a weight
    /// is negative or not finite, or the number of weights is wrong.
    pub fn new(width: usize, height: usize, weights: &[f64]) -> Option<Self> {
        if width == 0
            || weights.len() != width.checked_mul(height)?
            || weights.iter().any(|w| !w.is_finite() || *w < 0.0)
        {
            return None;
        }
        let sums: Vec<f64> = weights.chunks(width).map(|row| row.iter().sum()).collect();
        let columns = weights.chunks(width).map(Discrete::new).collect();
        Some(Self { rows: Discrete::new(&sums)?, columns, width })
    }

    /// Samples a point by `u` in [0,1)²: y from the marginal distribution, x from the conditional distribution of the
    /// row.
    pub fn sample(&self, u: Vec2) -> GridSample {
        let y = self.rows.sample(u.y);
        let row = y.index;
        // A row of positive probability always has a table.
        let (column, h) = self.columns[row].as_ref().map_or((0, 0.5), |c| {
            let x = c.sample(u.x);
            (x.index, x.u)
        });
        GridSample {
            point: Vec2::new(inside(column, h, self.width), inside(row, y.u, self.rows.len())),
            cell: (column as u32, row as u32),
            within: Vec2::new(h, y.u),
            pdf: self.cell_pdf(column as u32, row as u32),
        }
    }

    /// Returns the density at `point`, which is clamped to the unit square.
    pub fn pdf(&self, point: Vec2) -> f32 {
        self.cell_pdf(cell(point.x, self.width) as u32, cell(point.y, self.rows.len()) as u32)
    }

    /// Returns the density within a cell.
    pub fn cell_pdf(&self, column: u32, row: u32) -> f32 {
        let Some(Some(columns)) = self.columns.get(row as usize) else { return 0.0 };
        let p = self.rows.probability(row as usize) * columns.probability(column as usize);
        (p * self.width as f64 * self.rows.len() as f64) as f32
    }
}

/// Returns the cell of `x`, clamped to 0..n.
fn cell(x: f32, n: usize) -> usize {
    ((f64::from(x).clamp(0.0, 1.0) * n as f64) as usize).min(n - 1)
}

/// Returns (index + place)/n as f32, moved by an ulp where rounding would leave the cell, because the adjacent cell may
/// have weight 0.
fn inside(index: usize, place: f32, n: usize) -> f32 {
    let x = ((index as f64 + f64::from(place)) / n as f64) as f32;
    match cell(x, n).cmp(&index) {
        Ordering::Less => x.next_up(),
        Ordering::Equal if x < 1.0 => x,
        _ => x.next_down(),
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
