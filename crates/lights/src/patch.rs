//! Sampling of a point within a texel in proportion to the bilinearly interpolated luminance.
//!
//! Interpolation between texel centres divides the square of a texel into four bilinear quarters. The density is
//! sampled exactly: first the height by the marginal density, then the position along that line; both are linear on
//! each half.

use dapple_math::lanes::{Real, Vec2x};

/// Non-negative values of a texel and its eight neighbours, in rows from the top, none of them much above 1; per lane.
#[derive(Clone, Copy)]
pub(crate) struct Patch<R>(pub [[R; 3]; 3]);

/// A function on \[0, 1\], linear between its values at 0, ½ and 1.
#[derive(Clone, Copy)]
struct Line<R>([R; 3]);

impl<R: Real> Line<R> {
    /// Interpolates between the centres of three texels, over the middle one.
    #[inline(always)]
    fn over([a, b, c]: [R; 3]) -> Self {
        let half = R::splat(0.5);
        Self([half * (a + b), b, half * (b + c)])
    }

    #[inline(always)]
    fn at(&self, x: R) -> R {
        let ([a, b, c], twice) = (self.0, x + x);
        let first = x.lt(R::splat(0.5));
        let (from, to) = (R::select(first, a, b), R::select(first, b, c));
        from + (to - from) * (twice - R::select(first, R::splat(0.0), R::splat(1.0)))
    }

    #[inline(always)]
    fn mean(&self) -> R {
        let [a, b, c] = self.0;
        R::splat(0.25) * (a + b + b + c)
    }

    /// Maps `u` in \[0, 1) to a position with these values as the density; uniform if they are all zero.
    #[inline(always)]
    fn sample(&self, u: R) -> R {
        let ([a, b, c], zero, half) = (self.0, R::splat(0.0), R::splat(0.5));
        let total = a + b + b + c;
        let at = u * total;
        let first = at.lt(a + b);
        let (from, to) = (R::select(first, a, b), R::select(first, b, c));
        let area = R::select(first, at, at - (a + b));
        // from·t + (to − from)·t²/2 = area/2 for t in [0, 1], in the form that does not cancel.
        let root = (from * from + (to - from) * area).max(zero).sqrt();
        let t = R::select(area.gt(zero), area / (from + root), zero).min(R::splat(1.0));
        R::select(total.gt(zero), R::select(first, zero, half) + half * t, u)
    }
}

impl<R: Real> Patch<R> {
    /// Marginal density over the height: the mean along each line.
    #[inline(always)]
    fn marginal(&self) -> Line<R> {
        let [top, middle, bottom] = self.0;
        Line::over([Line::over(top).mean(), Line::over(middle).mean(), Line::over(bottom).mean()])
    }

    /// Values along the line at height `y`.
    #[inline(always)]
    fn line(&self, y: R) -> Line<R> {
        let [top, middle, bottom] = self.0;
        Line::over([
            Line::over([top[0], middle[0], bottom[0]]).at(y),
            Line::over([top[1], middle[1], bottom[1]]).at(y),
            Line::over([top[2], middle[2], bottom[2]]).at(y),
        ])
    }

    /// Maps `u` in \[0, 1)² to a point, x to the right and y down in \[0, 1\].
    #[inline(always)]
    pub fn sample(&self, u: Vec2x<R>) -> Vec2x<R> {
        let y = self.marginal().sample(u.y);
        Vec2x::new(self.line(y).sample(u.x), y)
    }

    /// Density at a point relative to the uniform density.
    #[inline(always)]
    pub fn density(&self, at: Vec2x<R>) -> R {
        let mean = self.marginal().mean();
        R::select(mean.gt(R::splat(0.0)), self.line(at.y).at(at.x) / mean, R::splat(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_equal_area_get_equal_shares_of_the_density() {
        let n = 400;
        let cases: [[[f32; 3]; 3]; 4] = [
            [[0.0, 0.0, 0.0], [0.0, 7.0, 0.0], [0.0, 0.0, 0.0]],
            [[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [1.0, 0.0, 9.0]],
            [[1.0, 2.0, 3.0], [4.0, 1e6, 6.0], [7.0, 8.0, 0.0]],
            [[0.0; 3]; 3],
        ];
        for values in cases {
            let patch = Patch::<f32>(values);
            let (mut counts, mut integrals) = ([[0.0; 4]; 4], [[0.0; 4]; 4]);
            let share = 1.0 / f64::from(n * n);
            for i in 0..n * n {
                let at = |i: i32| (i as f32 + 0.5) / n as f32;
                let p = Vec2x::new(at(i % n), at(i / n));
                let cell = |p: Vec2x<f32>| ((p.x * 4.0).min(3.0) as usize, (p.y * 4.0).min(3.0) as usize);
                let q = patch.sample(p);
                assert!((0.0..=1.0).contains(&q.x) && (0.0..=1.0).contains(&q.y));
                counts[cell(q).0][cell(q).1] += share;
                integrals[cell(p).0][cell(p).1] += f64::from(patch.density(p)) * share;
            }
            for (count, integral) in counts.as_flattened().iter().zip(integrals.as_flattened()) {
                assert!(
                    (count - integral).abs() < 4.0 / f64::from(n),
                    "{values:?}: {counts:?} {integrals:?}"
                );
            }
            assert!((integrals.as_flattened().iter().sum::<f64>() - 1.0).abs() < 1e-4);
        }
    }
}
