//! Sampling of a point within a texel in proportion to the bilinearly interpolated luminance.
//!
//! Interpolation between texel centres divides the square of a texel into four bilinear quarters. The density is
//! sampled exactly: first the height by the marginal density, then the position along that line; both are linear on
//! each half.

/// Non-negative values of a texel and its eight neighbours, in rows from the top.
pub(crate) struct Patch(pub [[f64; 3]; 3]);

/// A function on \[0, 1\], linear between its values at 0, ½ and 1.
#[derive(Clone, Copy)]
struct Line([f64; 3]);

impl Line {
    /// Interpolates between the centres of three texels, over the middle one.
    fn over([a, b, c]: [f64; 3]) -> Self {
        Self([0.5 * (a + b), b, 0.5 * (b + c)])
    }

    fn at(&self, x: f64) -> f64 {
        let [a, b, c] = self.0;
        if x < 0.5 { a + (b - a) * (2.0 * x) } else { b + (c - b) * (2.0 * x - 1.0) }
    }

    fn mean(&self) -> f64 {
        let [a, b, c] = self.0;
        0.25 * (a + b + b + c)
    }

    /// Maps `u` in \[0, 1) to a position with these values as the density; uniform if they are all zero.
    fn sample(&self, u: f64) -> f64 {
        let [a, b, c] = self.0;
        let total = a + b + b + c;
        if total <= 0.0 {
            return u;
        }
        let at = u * total;
        let (from, to, start, area) = if at < a + b { (a, b, 0.0, at) } else { (b, c, 0.5, at - (a + b)) };
        // from·t + (to − from)·t²/2 = area/2 for t in [0, 1], in the form that does not cancel.
        let root = (from * from + (to - from) * area).max(0.0).sqrt();
        let t = if area > 0.0 { area / (from + root) } else { 0.0 };
        start + 0.5 * t.min(1.0)
    }
}

impl Patch {
    /// Marginal density over the height: the mean along each line.
    fn marginal(&self) -> Line {
        Line::over(self.0.map(|row| Line::over(row).mean()))
    }

    /// Values along the line at height `y`.
    fn line(&self, y: f64) -> Line {
        let [top, middle, bottom] = self.0;
        Line::over([0, 1, 2].map(|i| Line::over([top[i], middle[i], bottom[i]]).at(y)))
    }

    /// Maps `u` in \[0, 1)² to a point, x to the right and y down in \[0, 1\].
    pub fn sample(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let y = self.marginal().sample(y);
        (self.line(y).sample(x), y)
    }

    /// Density at a point relative to the uniform density.
    pub fn density(&self, (x, y): (f64, f64)) -> f64 {
        let mean = self.marginal().mean();
        if mean > 0.0 { self.line(y).at(x) / mean } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_equal_area_get_equal_shares_of_the_density() {
        let n = 400;
        for values in [
            [[0.0, 0.0, 0.0], [0.0, 7.0, 0.0], [0.0, 0.0, 0.0]],
            [[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [1.0, 0.0, 9.0]],
            [[1.0, 2.0, 3.0], [4.0, 1e6, 6.0], [7.0, 8.0, 0.0]],
            [[0.0; 3]; 3],
        ] {
            let patch = Patch(values);
            let (mut counts, mut integrals) = ([[0.0; 4]; 4], [[0.0; 4]; 4]);
            let share = 1.0 / f64::from(n * n);
            for i in 0..n * n {
                let p = ((f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n));
                let cell = |(x, y): (f64, f64)| ((x * 4.0).min(3.0) as usize, (y * 4.0).min(3.0) as usize);
                let q = patch.sample(p);
                assert!((0.0..=1.0).contains(&q.0) && (0.0..=1.0).contains(&q.1));
                counts[cell(q).0][cell(q).1] += share;
                integrals[cell(p).0][cell(p).1] += patch.density(p) * share;
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
