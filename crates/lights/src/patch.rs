//! Points within a texel by the brightness that interpolation between texels gives it.
//!
//! Interpolated between the centres of texels, a texel's square is made of four bilinear quarters. Its density is sampled
//! exactly: first the height by the marginal density, then the place along that line; both are linear on each half.

/// Values, not negative, of a texel and the eight around it, in rows from the top.
pub(crate) struct Patch(pub [[f64; 3]; 3]);

/// A function on \[0, 1\], linear between its values at 0, ½ and 1.
#[derive(Clone, Copy)]
struct Line([f64; 3]);

impl Line {
    /// Between the centres of three texels, over the middle one.
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

    /// The place that `u` in \[0, 1) takes if these values are a density; even where they are all zero.
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
    /// By height: the mean along each line.
    fn marginal(&self) -> Line {
        Line::over(self.0.map(|row| Line::over(row).mean()))
    }

    /// Along the line at a height.
    fn line(&self, y: f64) -> Line {
        let [top, middle, bottom] = self.0;
        Line::over([0, 1, 2].map(|i| Line::over([top[i], middle[i], bottom[i]]).at(y)))
    }

    /// The point that `u` in \[0, 1)² takes, x to the right and y down in \[0, 1\].
    pub fn sample(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let y = self.marginal().sample(y);
        (self.line(y).sample(x), y)
    }

    /// Density at a point, in parts of an even one.
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
