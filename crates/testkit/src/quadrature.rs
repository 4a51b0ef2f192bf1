//! Quadrature to a given accuracy in f64, for tests such as "∫pdf = 1" and "albedo by quadrature".
//!
//! The method is adaptive Gauss–Kronrod (7, 15) quadrature with a global list of regions, which splits the region of
//! the largest error first [Piessens et al. 1983, QUADPACK]. Regions of the plane use the tensor product and are split
//! along the axis of the larger error, so that splits concentrate at narrow peaks and edges. `tolerance` is relative to
//! ∫|f|, regardless of the magnitude of f. The error is the difference of the two rules, which is an upper estimate for
//! smooth functions.

use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// Kronrod nodes from the outside in, with the Kronrod and Gauss weights (0 where a node is not a Gauss node).
const NODES: [(f64, f64, f64); 8] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_225, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.741_531_185_599_394_4, 0.140_653_259_715_525_92, 0.279_705_391_489_276_66),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (0.0, 0.209_482_141_084_727_83, 0.417_959_183_673_469_4),
];

/// Returns all 15 nodes on (−1, 1) with Kronrod and Gauss weights.
fn nodes() -> impl Iterator<Item = (f64, f64, f64)> + Clone {
    let (outer, centre) = NODES.split_at(7);
    outer.iter().map(|&(x, k, g)| (-x, k, g)).chain(NODES.iter().copied().take(7)).chain([centre[0]])
}

/// An integral with its error estimate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integral {
    /// The Kronrod estimate.
    pub value: f64,
    /// Sum of |Kronrod − Gauss| over the regions, an upper estimate of the error.
    pub error: f64,
    /// ∫|f|, to which the tolerance is relative.
    pub absolute: f64,
    /// Number of regions.
    pub regions: usize,
}

/// A region of one or two dimensions with its estimates.
#[derive(Clone, Copy)]
struct Region {
    low: [f64; 2],
    high: [f64; 2],
    value: f64,
    absolute: f64,
    /// Error per axis.
    error: [f64; 2],
}

impl Region {
    fn line(f: &mut impl FnMut(f64) -> f64, a: f64, b: f64) -> Self {
        let (centre, half) = (0.5 * (a + b), 0.5 * (b - a));
        let mut region = Self { low: [a, 0.0], high: [b, 0.0], value: 0.0, absolute: 0.0, error: [0.0; 2] };
        let mut gauss = 0.0;
        for (x, k, g) in nodes() {
            let y = f(centre + half * x) * half;
            region.value += k * y;
            region.absolute += k * y.abs();
            gauss += g * y;
        }
        region.error[0] = (region.value - gauss).abs();
        region
    }

    fn plane(f: &mut impl FnMut(f64, f64) -> f64, low: [f64; 2], high: [f64; 2]) -> Self {
        let centre = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        let half = [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])];
        let mut region = Self { low, high, value: 0.0, absolute: 0.0, error: [0.0; 2] };
        let mut gauss = [0.0; 2];
        for (x, kx, gx) in nodes() {
            for (y, ky, gy) in nodes() {
                let z = f(centre[0] + half[0] * x, centre[1] + half[1] * y) * half[0] * half[1];
                region.value += kx * ky * z;
                region.absolute += kx * ky * z.abs();
                gauss[0] += gx * ky * z;
                gauss[1] += kx * gy * z;
            }
        }
        region.error = gauss.map(|g| (region.value - g).abs());
        region
    }

    fn worst(&self) -> f64 {
        self.error[0].max(self.error[1])
    }

    /// Returns the two halves along the axis of the larger error, or None if the region is too small to be split in
    /// f64.
    fn halves(&self) -> Option<[([f64; 2], [f64; 2]); 2]> {
        let axis = usize::from(self.error[1] > self.error[0]);
        let middle = 0.5 * (self.low[axis] + self.high[axis]);
        if !(self.low[axis] < middle && middle < self.high[axis]) {
            return None;
        }
        let (mut left, mut right) = (self.high, self.low);
        left[axis] = middle;
        right[axis] = middle;
        Some([(self.low, left), (right, self.high)])
    }
}

impl PartialEq for Region {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Region {}
impl PartialOrd for Region {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Region {
    fn cmp(&self, other: &Self) -> Ordering {
        self.worst().total_cmp(&other.worst())
    }
}

/// Splits the region of the largest error until the total error is below `relative`·∫|f| or `absolute`, or there are
/// `most` regions.
fn refine(
    start: Vec<Region>,
    mut make: impl FnMut([f64; 2], [f64; 2]) -> Region,
    relative: f64,
    absolute: f64,
    most: usize,
) -> Integral {
    let total = |list: &mut dyn Iterator<Item = &Region>| {
        list.fold(Integral::default(), |sum, r| Integral {
            value: sum.value + r.value,
            error: sum.error + r.worst(),
            absolute: sum.absolute + r.absolute,
            regions: sum.regions + 1,
        })
    };
    let mut done: Vec<Region> = Vec::new();
    let mut open: BinaryHeap<Region> = start.into();
    let mut sum = total(&mut open.iter());
    while sum.error > absolute.max(relative * sum.absolute) && sum.regions < most {
        let Some(worst) = open.pop() else { break };
        let Some(halves) = worst.halves() else {
            done.push(worst);
            continue;
        };
        for (low, high) in halves {
            let half = make(low, high);
            sum.error += half.worst();
            sum.absolute += half.absolute;
            open.push(half);
        }
        sum.error -= worst.worst();
        sum.absolute -= worst.absolute;
        sum.regions += 1;
    }
    // Sums all regions again, because the running sums contain the rounding errors of the subtractions.
    total(&mut done.iter().chain(open.iter()))
}

/// Returns ∫_a^b f dx with its error, using at most `most` regions of 15 evaluations.
pub fn adaptive_line(mut f: impl FnMut(f64) -> f64, a: f64, b: f64, tolerance: f64, most: usize) -> Integral {
    // Thirteen regions, so that positions such as ½ and ¼ are not at region borders by coincidence.
    let at = |i: u32| a + (b - a) * f64::from(i) / 13.0;
    let start = (0..13).map(|i| Region::line(&mut f, at(i), at(i + 1))).collect();
    refine(start, |low, high| Region::line(&mut f, low[0], high[0]), tolerance, 0.0, most)
}

/// Returns ∫∫ f dx dy over the rectangle between two corners with its error. It stops at `most` regions of 225
/// evaluations, or when the error is below `tolerance`·∫|f| or below `absolute`.
pub fn adaptive_plane(
    f: impl FnMut(f64, f64) -> f64,
    low: [f64; 2],
    high: [f64; 2],
    tolerance: f64,
    absolute: f64,
    most: usize,
) -> Integral {
    split_plane(f, [low, high], [1, 1], [tolerance, absolute], most)
}

/// Like [`adaptive_plane`], but starts with `start` regions along each axis, which are not included in `most`.
pub(crate) fn split_plane(
    mut f: impl FnMut(f64, f64) -> f64,
    [low, high]: [[f64; 2]; 2],
    start: [u32; 2],
    [tolerance, absolute]: [f64; 2],
    most: usize,
) -> Integral {
    let at =
        |axis: usize, i: u32| low[axis] + (high[axis] - low[axis]) * f64::from(i) / f64::from(start[axis]);
    let corners = (0..start[0]).flat_map(|i| (0..start[1]).map(move |j| (i, j)));
    let regions: Vec<Region> = corners
        .map(|(i, j)| Region::plane(&mut f, [at(0, i), at(1, j)], [at(0, i + 1), at(1, j + 1)]))
        .collect();
    let most = most + regions.len();
    refine(regions, |low, high| Region::plane(&mut f, low, high), tolerance, absolute, most)
}

/// Returns ∫_a^b f dx. `tolerance` is relative to ∫|f|.
///
/// # Panics
/// Panics when the tolerance is not reached after 20 000 regions, or when f is not finite.
pub fn line(f: impl FnMut(f64) -> f64, a: f64, b: f64, tolerance: f64) -> f64 {
    reached(adaptive_line(f, a, b, tolerance, 20_000), tolerance)
}

/// Returns ∫∫ f dx dy over [low.0, high.0] × [low.1, high.1], with a `tolerance` as in [`line()`].
///
/// # Panics
/// Panics as [`line()`] does.
pub fn rectangle(f: impl FnMut(f64, f64) -> f64, low: [f64; 2], high: [f64; 2], tolerance: f64) -> f64 {
    reached(split_first(f, low, high, tolerance), tolerance)
}

/// Returns ∫ f dω over the hemisphere about +z, where f is a function of a unit direction. Peaks narrower than about
/// 1/50 radian may be missed unless they are at +z; use [`sphere_about`] with the direction of such a peak.
///
/// # Panics
/// Panics as [`line()`] does.
pub fn hemisphere(mut f: impl FnMut(DVec3) -> f64, tolerance: f64) -> f64 {
    let polar = |s: f64, phi: f64| f(polar_direction(s * s)(phi)) * 2.0 * s;
    reached(split_first(polar, [0.0, 0.0], [1.0, TAU], tolerance), tolerance)
}

/// Returns ∫ f dω over the sphere, with the limits of [`hemisphere`].
///
/// # Panics
/// Panics as [`line()`] does.
pub fn sphere(f: impl FnMut(DVec3) -> f64, tolerance: f64) -> f64 {
    sphere_about(DVec3::Z, f, tolerance)
}

/// Returns ∫ f dω over the sphere with polar coordinates about `axis` (unit), for a narrow peak in that direction. f is
/// a function of the world direction. The polar coordinate is s with s² = 1 − cosθ, so that a peak of width w takes
/// about log₂ 1/w splits.
///
/// # Panics
/// Panics as [`line()`] does.
pub fn sphere_about(axis: DVec3, mut f: impl FnMut(DVec3) -> f64, tolerance: f64) -> f64 {
    let (x, y) = axis.any_orthonormal_pair();
    let polar = |s: f64, phi: f64| {
        let d = polar_direction(s * s)(phi);
        f(x * d.x + y * d.y + axis * d.z) * 2.0 * s
    };
    reached(split_first(polar, [0.0, 0.0], [2f64.sqrt(), TAU], tolerance), tolerance)
}

/// Returns the direction with 1 − cosθ = v as a function of φ. sinθ = √(v(2 − v)) keeps the precision of tiny angles.
fn polar_direction(v: f64) -> impl Fn(f64) -> DVec3 {
    let sin = (v * (2.0 - v)).max(0.0).sqrt();
    move |phi| DVec3::new(sin * phi.cos(), sin * phi.sin(), 1.0 - v)
}

fn split_first(f: impl FnMut(f64, f64) -> f64, low: [f64; 2], high: [f64; 2], tolerance: f64) -> Integral {
    split_plane(f, [low, high], [5, 7], [tolerance, 0.0], 20_000)
}

fn reached(integral: Integral, tolerance: f64) -> f64 {
    assert!(
        integral.error <= tolerance * integral.absolute,
        "quadrature did not reach {tolerance:e}: {integral:?}"
    );
    integral.value
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_rules_have_their_degrees() {
        for degree in 0..=23u32 {
            let exact = if degree % 2 == 0 { 2.0 / f64::from(degree + 1) } else { 0.0 };
            let (mut kronrod, mut gauss) = (0.0, 0.0);
            for (x, k, g) in nodes() {
                kronrod += k * x.powi(degree as i32);
                gauss += g * x.powi(degree as i32);
            }
            assert!((kronrod - exact).abs() < 2e-15, "Kronrod, degree {degree}: {kronrod}");
            assert!(degree > 13 || (gauss - exact).abs() < 2e-15, "Gauss, degree {degree}: {gauss}");
        }
    }

    #[test]
    fn lines_smooth_edged_peaked_and_tiny() {
        let near = |a: f64, b: f64, tolerance: f64| assert!((a / b - 1.0).abs() <= tolerance, "{a} {b}");
        near(line(f64::exp, 0.0, 1.0, 1e-12), 1f64.exp() - 1.0, 1e-12);
        near(line(|x| if x < 1.0 / 3.0 { 1.0 } else { 0.0 }, 0.0, 1.0, 1e-9), 1.0 / 3.0, 1e-9);
        near(line(|x| 1e-4 / (x * x + 1e-8), -1.0, 1.0, 1e-10), 2.0 * 1e4f64.atan(), 1e-10);
        near(line(|x| 1e-30 * x, 0.0, 1.0, 1e-12), 0.5e-30, 1e-12);
        near(line(|x| x.sqrt().recip(), 0.0, 1.0, 1e-8), 2.0, 1e-7);
    }

    #[test]
    fn an_unreachable_tolerance_is_said() {
        let f = || line(|x| if (x * 1e9).sin() > 0.0 { 1.0 } else { 0.0 }, 0.0, 1.0, 1e-14);
        assert!(std::panic::catch_unwind(f).is_err());
    }

    #[test]
    fn planes_and_spheres() {
        let near = |a: f64, b: f64, tolerance: f64| assert!((a / b - 1.0).abs() <= tolerance, "{a} {b}");
        let e = 1f64.exp() - 1.0;
        near(rectangle(|x, y| (x + y).exp(), [0.0; 2], [1.0; 2], 1e-12), e * e, 1e-12);
        near(hemisphere(|w| w.z, 1e-10), PI, 1e-10);
        near(sphere(|_| 1.0, 1e-12), 4.0 * PI, 1e-12);
        near(sphere(|w| w.x * w.x, 1e-10), 4.0 * PI / 3.0, 1e-10);
        // A cone about an oblique axis, whose indicator function has an edge.
        let axis = DVec3::new(0.6, 0.0, 0.8);
        near(sphere(|w| f64::from(w.dot(axis) > 0.9), 1e-3), TAU * 0.1, 1e-3);
        // GGX-like lobe of width 1e-4 about the axis: ∫ D cosθ dω = 1.
        let a2 = 1e-8f64;
        let lobe = |w: DVec3| {
            let t = (w - axis).length_squared();
            let (sin2, cos) = (t * (1.0 - 0.25 * t), 1.0 - 0.5 * t);
            if cos <= 0.0 { 0.0 } else { a2 / PI / (a2 * cos * cos + sin2).powi(2) * cos }
        };
        near(sphere_about(axis, lobe, 1e-9), 1.0, 1e-8);
    }
}
