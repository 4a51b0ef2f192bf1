//! χ² tests of a `sample` function against its `pdf`: Pearson's χ² over cells whose expected counts are integrals of
//! the density by quadrature.
//!
//! The same run also tests that ∫ pdf = 1 − P(None) and that no sample falls where the density is zero. `None` is one
//! more cell. Cells are made from a pilot run (see `partition`), so that narrow lobes need no tuning. Cells with an
//! expected count below 5 are pooled; a pool that stays below 5 is tested by the Poisson tail instead. The two p-values
//! are combined by Šidák; `tests` is the number of such tests that share the family level.
//!
//! ```
//! use dapple_testkit::chi_square::ChiSquare;
//! use std::f32::consts::{FRAC_1_PI, TAU};
//!
//! // Samples the hemisphere with cosine weight by the inverse of the distribution function.
//! let sample = |u: glam::Vec2, _uc: f32| {
//!     let (r, phi) = (u.x.sqrt(), TAU * u.y);
//!     Some(glam::Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u.x).sqrt()))
//! };
//! let result = ChiSquare::default().sphere(sample, |w| w.z.max(0.0) * FRAC_1_PI);
//! assert!(result.passed(), "{result}");
//! assert!((result.integral - 1.0).abs() < 1e-3);
//! ```

use crate::partition::{Cell, Partition, Place};
use crate::quadrature::split_plane;
use crate::rng::Rng;
use crate::z_test::sidak;
use glam::{DVec3, Vec2, Vec3};
use statrs::function::gamma::{gamma_lr, gamma_ur};
use std::f64::consts::{PI, TAU};
use std::fmt;

/// Fraction of the samples that may fall, by rounding, where the density is zero.
const ROUNDING: f64 = 2e-6;

/// The parameters of a χ² test.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquare {
    /// Number of samples, without the pilot run.
    pub samples: u32,
    /// Approximate number of cells.
    pub cells: usize,
    /// Probability of a false alarm in the whole family.
    pub level: f64,
    /// Number of tests in the family.
    pub tests: usize,
    /// Seed of the generator.
    pub seed: u64,
    /// Maximum number of quadrature regions (225 evaluations of the density each) per cell.
    pub regions: usize,
}

impl Default for ChiSquare {
    fn default() -> Self {
        Self { samples: 200_000, cells: 300, level: 1e-4, tests: 1, seed: 1, regions: 100 }
    }
}

/// The result of a χ² test.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Probability of a deviation at least this large if samples and density agree.
    pub p: f64,
    /// The test fails if p is below this level.
    pub level: f64,
    /// Pearson's statistic.
    pub statistic: f64,
    /// Degrees of freedom: the number of cells after pooling, minus one.
    pub freedom: usize,
    /// ∫ pdf over the whole domain.
    pub integral: f64,
    /// Fraction of the samples that were None.
    pub missed: f64,
    /// The cells that deviate most: description, observed count, expected count.
    pub worst: Vec<(String, f64, f64)>,
    /// A reason to fail in addition to p.
    pub fault: Option<String>,
}

impl Outcome {
    /// Returns whether p is at or above its level and there is no fault.
    pub fn passed(&self) -> bool {
        self.p >= self.level && self.fault.is_none()
    }
}

/// Formats the result as one paragraph for a failed assertion.
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: p = {:.2e} (level {:.2e}), chi² = {:.1} with {} degrees of freedom, ∫pdf = {:.6}, None {:.3} %",
            if self.passed() { "pass" } else { "FAIL" },
            self.p,
            self.level,
            self.statistic,
            self.freedom,
            self.integral,
            100.0 * self.missed
        )?;
        if let Some(fault) = &self.fault {
            writeln!(f, "  {fault}")?;
        }
        for (cell, observed, expected) in &self.worst {
            writeln!(f, "  {cell}: observed {observed}, expected {expected:.1}")?;
        }
        Ok(())
    }
}

impl ChiSquare {
    /// Returns the parameters of one of a family of `tests` tests at the default level.
    pub fn family(tests: usize) -> Self {
        Self { tests, ..Self::default() }
    }

    /// Tests unit directions anywhere on the sphere against a density per solid angle.
    pub fn sphere(
        &self,
        mut sample: impl FnMut(Vec2, f32) -> Option<Vec3>,
        mut pdf: impl FnMut(Vec3) -> f32,
    ) -> Outcome {
        // Two charts for the upper and lower half: (1 − |cosθ|, φ), whose area is the solid angle and which keep the
        // precision of small angles.
        let half = [[0.0, 0.0], [1.0, TAU]];
        self.run(
            &[half, half],
            |u, uc| sample(u, uc).map(|w| sphere_place(w.as_dvec3())),
            |(chart, p)| f64::from(pdf(sphere_point(chart, p).as_vec3())),
            |cell| {
                let degrees = |v: f64| (1.0 - v).acos().to_degrees();
                let (a, b) = (degrees(cell.low[0]), degrees(cell.high[0]));
                let (a, b) = if cell.chart == 0 { (a, b) } else { (180.0 - b, 180.0 - a) };
                let phi = [cell.low[1], cell.high[1]].map(f64::to_degrees);
                format!("θ {a:.4}°…{b:.4}°, φ {:.3}°…{:.3}°", phi[0], phi[1])
            },
        )
    }

    /// Tests points of the plane against a density per area, within the rectangle from `low` to `high`. Points outside
    /// of it are a fault.
    pub fn plane(
        &self,
        low: Vec2,
        high: Vec2,
        mut sample: impl FnMut(Vec2, f32) -> Option<Vec2>,
        mut pdf: impl FnMut(Vec2) -> f32,
    ) -> Outcome {
        let corners = [low, high].map(|p| p.as_dvec2().to_array());
        let mut outside = 0u32;
        let mut outcome = self.run(
            &[corners],
            |u, uc| {
                let p = sample(u, uc)?;
                outside += u32::from(!(p.cmpge(low).all() && p.cmple(high).all()));
                Some((0, p.as_dvec2().to_array()))
            },
            |(_, p)| f64::from(pdf(Vec2::new(p[0] as f32, p[1] as f32))),
            |cell| format!("{:.6?} … {:.6?}", cell.low, cell.high),
        );
        if outside > 0 {
            outcome.fault = Some(format!("{outside} points outside the rectangle"));
        }
        outcome
    }

    /// Tests points of an interval against a density per length.
    pub fn line(
        &self,
        low: f32,
        high: f32,
        mut sample: impl FnMut(f32) -> f32,
        mut pdf: impl FnMut(f32) -> f32,
    ) -> Outcome {
        // A strip of width 1 whose second coordinate is known to be uniform.
        self.plane(
            Vec2::new(low, 0.0),
            Vec2::new(high, 1.0),
            |u, uc| Some(Vec2::new(sample(u.x), uc)),
            |p| pdf(p.x),
        )
    }

    /// Tests indices, where index i has probability `pmf[i]`.
    pub fn indices(&self, pmf: &[f64], mut sample: impl FnMut(f32) -> usize) -> Outcome {
        let mut rng = Rng::new(self.seed);
        let mut observed = vec![0.0; pmf.len()];
        let mut outside = 0u32;
        for _ in 0..self.samples {
            match observed.get_mut(sample(rng.f32())) {
                Some(count) => *count += 1.0,
                None => outside += 1,
            }
        }
        let bins = pmf.iter().zip(&observed).enumerate();
        let bins = bins.map(|(i, (p, o))| (format!("index {i}"), *o, p * f64::from(self.samples))).collect();
        let fault = (outside > 0).then(|| format!("{outside} indices out of range"));
        self.judge(bins, pmf.iter().sum(), 0.0, fault)
    }

    fn run(
        &self,
        charts: &[[[f64; 2]; 2]],
        mut sample: impl FnMut(Vec2, f32) -> Option<Place>,
        mut pdf: impl FnMut(Place) -> f64,
        describe: impl Fn(&Cell) -> String,
    ) -> Outcome {
        let mut rng = Rng::new(self.seed);
        let mut fault = None;
        let mut draw = |rng: &mut Rng, fault: &mut Option<String>| {
            let place = sample(rng.vec2(), rng.f32())?;
            if !place.1.iter().all(|x| x.is_finite()) {
                *fault = Some("a sample is not finite".into());
            }
            Some(place)
        };
        let pilot: Vec<Place> =
            (0..self.cells * 64).filter_map(|_| draw(&mut rng, &mut fault)).filter(finite).collect();
        let partition = Partition::new(charts, &pilot, self.cells);
        let mut observed = vec![0.0; partition.cells.len()];
        let mut missed = 0.0;
        for _ in 0..self.samples {
            match draw(&mut rng, &mut fault) {
                Some(place) => observed[partition.locate(place)] += 1.0,
                None => missed += 1.0,
            }
        }
        let n = f64::from(self.samples);
        // A hundredth of a standard deviation of the count of an average cell.
        let tolerance = 0.1 / (n * self.cells as f64).sqrt() / 10.0;
        let mut integral = 0.0;
        let mut bins = Vec::new();
        let mut looks = 8 + self.cells / 8;
        for (cell, observed) in partition.cells.iter().zip(observed) {
            let mut mass = |start| {
                let density = |a: f64, b: f64| {
                    let density = pdf((cell.chart, [a, b]));
                    if !(density >= 0.0 && density.is_finite()) {
                        fault = Some(format!("the density is {density} in {}", describe(cell)));
                        return 0.0;
                    }
                    density
                };
                split_plane(density, [cell.low, cell.high], start, [1e-6, tolerance], self.regions).value
            };
            let mut expected = mass([1, 1]) * n;
            // A cell with a large deviation is integrated again at a higher resolution, because the density may change
            // abruptly near its edge. If many cells deviate, quadrature is not the cause, so that their number is
            // limited.
            if (observed - expected).powi(2) > 6.0 * expected && looks > 0 {
                looks -= 1;
                expected = mass([12, 12]) * n;
            }
            integral += expected / n;
            bins.push((describe(cell), observed, expected));
        }
        // The margin allows for the quadrature tolerance over all cells and for densities in f32.
        if integral > 1.0 + 1e-3 {
            fault = fault.or(Some(format!("the density integrates to {integral:.6}, more than 1")));
        }
        bins.push(("None".into(), missed, (1.0 - integral).max(0.0) * n));
        self.judge(bins, integral, missed / n, fault)
    }

    /// Pools bins and computes the result. A bin has a description, an observed count and an expected count.
    fn judge(
        &self,
        bins: Vec<(String, f64, f64)>,
        integral: f64,
        missed: f64,
        fault: Option<String>,
    ) -> Outcome {
        let n = f64::from(self.samples);
        let (mut full, thin): (Vec<_>, Vec<_>) = bins.into_iter().partition(|bin| bin.2 >= 5.0);
        let pool = thin.iter().fold((0.0, 0.0), |sum, bin| (sum.0 + bin.1, sum.1 + bin.2));
        let mut tail = 1.0;
        if pool.1 >= 5.0 {
            full.push((format!("{} thin cells", thin.len()), pool.0, pool.1));
        } else if pool.0 > 0.0 {
            // P(Poisson ≥ k) = P(k, λ), the regularised lower gamma function.
            tail = gamma_lr(pool.0, pool.1 + ROUNDING * n);
        }
        let part = |bin: &(String, f64, f64)| (bin.1 - bin.2).powi(2) / bin.2;
        let statistic: f64 = full.iter().map(part).sum();
        let freedom = full.len().saturating_sub(1);
        let body = if freedom == 0 { 1.0 } else { gamma_ur(0.5 * freedom as f64, 0.5 * statistic) };
        let least = body.min(tail);
        // 1 − (1 − p)² without cancellation.
        let p = least * (2.0 - least);
        let mut worst = full;
        if tail < 1.0 {
            worst.extend(thin.into_iter().filter(|bin| bin.1 > 0.0));
        }
        worst.sort_by(|a, b| (part(b)).total_cmp(&part(a)));
        worst.truncate(5);
        Outcome {
            p,
            level: sidak(self.level, self.tests),
            statistic,
            freedom,
            integral,
            missed,
            worst,
            fault,
        }
    }
}

fn finite(place: &Place) -> bool {
    place.1.iter().all(|x| x.is_finite())
}

/// Returns the place of a direction. Chart 0 is the upper half, and 1 − |cosθ| = (x² + y²)/(1 + |z|).
fn sphere_place(w: DVec3) -> Place {
    let w = w / w.length();
    let v = (w.x * w.x + w.y * w.y) / (1.0 + w.z.abs());
    let phi = w.y.atan2(w.x);
    (usize::from(w.z < 0.0), [v, if phi < 0.0 { phi + 2.0 * PI } else { phi }])
}

fn sphere_point(chart: usize, [v, phi]: [f64; 2]) -> DVec3 {
    let sin = (v * (2.0 - v)).max(0.0).sqrt();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), if chart == 0 { 1.0 - v } else { v - 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_1_PI;

    fn cosine(u: Vec2, _uc: f32) -> Option<Vec3> {
        let (r, phi) = (u.x.sqrt(), std::f32::consts::TAU * u.y);
        Some(Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u.x).sqrt()))
    }

    fn cosine_pdf(w: Vec3) -> f32 {
        w.z.max(0.0) * FRAC_1_PI
    }

    /// Half vectors of GGX at normal incidence, rotated to the axis `axis`.
    fn ggx(alpha: f64, axis: DVec3) -> (impl Fn(Vec2, f32) -> Option<Vec3>, impl Fn(Vec3) -> f32) {
        let (x, y) = axis.any_orthonormal_pair();
        let a2 = alpha * alpha;
        let sample = move |u: Vec2, _| {
            let (u, phi) = (f64::from(u.x), TAU * f64::from(u.y));
            let tan2 = a2 * u / (1.0 - u);
            let cos = (1.0 + tan2).sqrt().recip();
            let sin = tan2.sqrt() * cos;
            Some((x * (sin * phi.cos()) + y * (sin * phi.sin()) + axis * cos).as_vec3())
        };
        let pdf = move |w: Vec3| {
            let w = w.as_dvec3().normalize();
            let (cos, sin2) = (w.dot(axis), w.cross(axis).length_squared());
            if cos <= 0.0 { 0.0 } else { (a2 / PI / (a2 * cos * cos + sin2).powi(2) * cos) as f32 }
        };
        (sample, pdf)
    }

    #[test]
    fn places_are_found_again() {
        let mut rng = Rng::new(9);
        for _ in 0..1000 {
            let w = rng.direction();
            let (chart, p) = sphere_place(w);
            assert!(sphere_point(chart, p).distance(w) < 1e-12);
        }
        let tiny = DVec3::new(1e-9, 0.0, 1.0);
        assert!((sphere_place(tiny).1[0] / 0.5e-18 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn right_pairs_pass() {
        let result = ChiSquare::default().sphere(cosine, cosine_pdf);
        assert!(result.passed() && (result.integral - 1.0).abs() < 1e-4, "{result}");
        for (alpha, axis) in
            [(1.0, DVec3::Z), (1e-3, DVec3::Z), (1e-3, DVec3::new(0.6, 0.0, 0.8)), (0.1, DVec3::X)]
        {
            let (sample, pdf) = ggx(alpha, axis);
            let result = ChiSquare::default().sphere(sample, pdf);
            assert!(result.passed() && (result.integral - 1.0).abs() < 1e-3, "alpha {alpha}: {result}");
        }
    }

    #[test]
    fn missing_samples_are_a_cell() {
        // Half of the samples are rejected, and the density takes that into account.
        let half = |u: Vec2, uc: f32| if uc < 0.5 { cosine(u, uc) } else { None };
        let result = ChiSquare::default().sphere(half, |w| 0.5 * cosine_pdf(w));
        assert!(result.passed() && (result.missed - 0.5).abs() < 0.01, "{result}");
        assert!(!ChiSquare::default().sphere(half, cosine_pdf).passed());
        assert!(!ChiSquare::default().sphere(cosine, |w| 0.99 * cosine_pdf(w)).passed());
    }

    #[test]
    fn wrong_pairs_fail() {
        let test = ChiSquare::default();
        let fails = |result: Outcome| assert!(!result.passed(), "{result}");
        fails(test.sphere(cosine, |w| if w.z > 0.0 { 0.5 * FRAC_1_PI } else { 0.0 }));
        fails(test.sphere(cosine, |w| 2.0 * cosine_pdf(w)));
        fails(test.sphere(cosine, |w| if w.x > 0.99 { 0.0 } else { cosine_pdf(w) }));
        fails(test.sphere(cosine, |w| cosine_pdf(w) * (1.0 + 0.05 * w.x)));
        fails(test.sphere(cosine, |_| f32::NAN));
        // The density is correct where the samples are, and too large where they never are.
        fails(test.sphere(cosine, |w| cosine_pdf(w) + if w.z < -0.98 { 0.1 } else { 0.0 }));
        // One sample in a thousand falls where the density is zero.
        fails(test.sphere(|u, uc| if uc < 1e-3 { Some(Vec3::NEG_Z) } else { cosine(u, uc) }, cosine_pdf));
        let (sample, _) = ggx(1e-3, DVec3::Z);
        let (_, pdf) = ggx(1.05e-3, DVec3::Z);
        fails(test.sphere(sample, pdf));
    }

    #[test]
    fn lines_planes_and_indices() {
        let test = ChiSquare::default();
        let tent = |u: f32| if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() };
        let result = test.line(-1.0, 1.0, tent, |x| 1.0 - x.abs());
        assert!(result.passed(), "{result}");
        assert!(!test.line(-1.0, 1.0, |u| 2.0 * u - 1.0, |x| 1.0 - x.abs()).passed());
        let square = test.plane(Vec2::ZERO, Vec2::ONE, |u, _| Some(u), |_| 1.0);
        assert!(square.passed(), "{square}");
        assert!(!test.plane(Vec2::ZERO, Vec2::splat(0.9), |u, _| Some(u), |_| 1.0).passed());
        let pmf = [0.5, 0.0, 0.25, 0.25];
        let right = |u: f32| [0, 0, 2, 3][(u * 4.0) as usize];
        assert!(test.indices(&pmf, right).passed());
        assert!(!test.indices(&pmf, |u| if u < 1e-3 { 1 } else { right(u) }).passed());
        assert!(!test.indices(&pmf, |u| (u * 5.0) as usize).passed());
    }

    /// Correct pairs must fail at the rate given by the level.
    #[test]
    fn p_is_uniform_for_a_right_pair() {
        let p = |seed| {
            let test = ChiSquare { samples: 20_000, cells: 40, seed, ..ChiSquare::default() };
            test.plane(Vec2::ZERO, Vec2::ONE, |u, _| Some(u), |_| 1.0).p
        };
        let p: Vec<f64> = (0..400).map(p).collect();
        // p is the Šidák combination of a uniform body and tail = 1: p = b(2 − b), b = 1 − √(1 − p).
        let low = p.iter().filter(|p| 1.0 - (1.0 - **p).sqrt() < 0.1).count();
        // Binomial(400, 0.1): 40 ± 4·6.
        assert!((16..=64).contains(&low), "{low}");
    }
}
