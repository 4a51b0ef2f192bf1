//! Closed forms of radiances, irradiances and coverages, in f64.

use std::f64::consts::{FRAC_1_PI, PI};

/// Maximum relative rounding error of [`linear_edge`].
const ROUNDING: f64 = 1e-9;

/// Radiance in a closed room whose walls emit `emission` and reflect `albedo`, after `bounces` scattering events:
/// L(1 − ρⁿ⁺¹)/(1 − ρ) (docs/science.md, "Closed room").
pub fn furnace(emission: f64, albedo: f64, bounces: u32) -> f64 {
    emission * (1.0 - albedo.powi(bounces as i32 + 1)) / (1.0 - albedo)
}

/// Irradiance over πL from a rectangle parallel to the receiver at unit distance, with one corner directly above it and
/// sides `x` and `y` of either sign [Howell 2010].
pub fn corner_rectangle(x: f64, y: f64) -> f64 {
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI)
}

/// Irradiance over πL from the rectangle between two corners in the plane at `height` above a receiver at the origin.
pub fn parallel_rectangle(low: [f64; 2], high: [f64; 2], height: f64) -> f64 {
    let corner = |x: f64, y: f64| corner_rectangle(x / height, y / height);
    corner(high[0], high[1]) - corner(low[0], high[1]) - corner(high[0], low[1]) + corner(low[0], low[1])
}

/// Irradiance over πL from a rectangle that stands on the receiver's plane at distance `c`, `a` high and `b` wide, with
/// one corner at the foot of the perpendicular from the receiver [Howell 2010].
pub fn perpendicular_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / b, c / b);
    let r = (x * x + y * y).sqrt();
    ((1.0 / y).atan() - y / r * (1.0 / r).atan()) / (2.0 * PI)
}

/// Irradiance over πL at the origin from a polygon above the receiver's plane z = 0, by Lambert's formula [Lambert
/// 1760].
pub fn polygon(corners: &[[f64; 3]]) -> f64 {
    let corner = |i: usize| glam::DVec3::from_array(corners[i % corners.len()]);
    let edge = |i: usize| {
        let (a, b) = (corner(i), corner(i + 1));
        let cross = a.cross(b);
        let sine = cross.length();
        if sine == 0.0 { 0.0 } else { libm::atan2(sine, a.dot(b)) * cross.z / sine }
    };
    ((0..corners.len()).map(edge).sum::<f64>() / (2.0 * PI)).abs()
}

/// Irradiance over πL from a disk of `radius` parallel to the receiver at `height`, offset by `d` to the side [Howell
/// 2010].
pub fn parallel_disk(radius: f64, height: f64, d: f64) -> f64 {
    let (r2, s2) = (radius * radius, height * height + d * d);
    0.5 * (1.0 - (s2 - r2) / ((s2 + r2).powi(2) - 4.0 * r2 * d * d).sqrt())
}

/// Irradiance over πL from a sphere whose centre is `q` ≥ 1 radii away at an angle of cosine `cos` to the receiver's
/// normal, clipped at the horizon (docs/science.md, "Sphere lights").
pub fn sphere(q: f64, cos: f64) -> f64 {
    if q * cos >= 1.0 || q * cos <= -1.0 {
        return cos.max(0.0) / (q * q);
    }
    let (x, sin) = (((q - 1.0) * (q + 1.0)).sqrt(), (1.0 - cos * cos).sqrt());
    let y = -x * cos / sin;
    let s = sin * (1.0 - y * y).max(0.0).sqrt();
    ((cos * libm::acos(y) - x * s) / (q * q) + libm::atan2(s, x)) * FRAC_1_PI
}

/// Form factor between opposite faces a × b at distance c, x = a/c, y = b/c (docs/science.md, "Form factors").
pub fn opposite_faces(x: f64, y: f64) -> f64 {
    let (p, q) = (1.0 + x * x, 1.0 + y * y);
    let angles = x * q.sqrt() * (x / q.sqrt()).atan() + y * p.sqrt() * (y / p.sqrt()).atan()
        - x * x.atan()
        - y * y.atan();
    2.0 / (PI * x * y) * (0.5 * (p * q / (1.0 + x * x + y * y)).ln() + angles)
}

/// Form factor from a w × l face to an h × l face that meet at a right angle, h and w over l [Howell 2010].
pub fn adjacent_faces(h: f64, w: f64) -> f64 {
    let (h2, w2) = (h * h, w * w);
    let r = (h2 + w2).sqrt();
    let angles = w * (1.0 / w).atan() + h * (1.0 / h).atan() - r * (1.0 / r).atan();
    let first = (1.0 + w2) * (1.0 + h2) / (1.0 + w2 + h2);
    let second = w2 * (1.0 + w2 + h2) / ((1.0 + w2) * (w2 + h2));
    let third = h2 * (1.0 + h2 + w2) / ((1.0 + h2) * (h2 + w2));
    (angles + 0.25 * (first.ln() + w2 * second.ln() + h2 * third.ln())) / (PI * w)
}

/// Fraction of a disk on the inner side of a straight line, with `s` the distance of the line from the centre over the
/// radius (docs/science.md, "Thin lens").
pub fn disk_beside_line(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    0.5 + (s * (1.0 - s * s).sqrt() + libm::asin(s)) * FRAC_1_PI
}

/// Mean over the pixel [i, i + 1] of the coverage of a box of width `w` that moves by `delta` during the exposure; its
/// leading edge starts at 0 (docs/science.md, "Moving box").
pub fn moving_box(i: f64, w: f64, delta: f64) -> f64 {
    let square = |x: f64| x.max(0.0).powi(2);
    let g = |x: f64| (square(x) - square(x - w) - square(x - delta) + square(x - w - delta)) / (2.0 * delta);
    g(i + 1.0) - g(i)
}

/// Fraction of the unit cube in which Σ a_i ξ_i ≤ c: V = 1/(d! Π a_i) Σ_v (−1)^|v| (c − a·v)₊^d [Barrow & Smith 1979].
///
/// The coefficients may have any sign. Coefficients too small for the alternating sum in f64 are replaced by their
/// means; the error is of the order of their square.
pub fn linear_edge(coefficients: &[f64], c: f64) -> f64 {
    let mut a: Vec<f64> = coefficients.iter().map(|a| a.abs()).collect();
    let mut c = c - coefficients.iter().map(|a| a.min(0.0)).sum::<f64>();
    a.sort_by(|x, y| y.total_cmp(x));
    // Infinite or not a number where a coefficient is zero.
    let is_rounded_off = |a: &[f64]| {
        let scale = factorial(a.len()) * a.iter().product::<f64>();
        scale == 0.0 || f64::EPSILON * a.iter().sum::<f64>().powi(a.len() as i32) / scale > ROUNDING
    };
    while a.len() > 1 && is_rounded_off(&a) {
        c -= 0.5 * a.pop().unwrap_or(0.0);
    }
    if c <= 0.0 || a.iter().sum::<f64>() <= c {
        return f64::from(c > 0.0);
    }
    let power = a.len() as i32;
    let corner = |v: u32| {
        let at: f64 = (0..).zip(&a).map(|(i, a)| f64::from(v >> i & 1) * a).sum();
        let sign = if v.count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * (c - at).max(0.0).powi(power)
    };
    (0..1 << a.len()).map(corner).sum::<f64>() / (factorial(a.len()) * a.iter().product::<f64>())
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}

/// Radiance of a perfectly reflecting GGX surface with single scattering, seen along its normal, where the only light
/// is a white cap of half angle `theta` ≤ 90° about the normal (docs/science.md, "Rough mirror and cap").
pub fn ggx_cap(alpha: f64, theta: f64) -> f64 {
    let a2 = alpha * alpha;
    // x = tan²/(tan² + α²) makes the distribution of normals uniform.
    let at = |x: f64| {
        let tan2 = a2 * x / (1.0 - x);
        // tan 2θ = 2t/(1 − t²).
        let tan_wi = 2.0 * tan2.sqrt() / (1.0 - tan2);
        2.0 / (1.0 + (1.0 + a2 * tan_wi * tan_wi).sqrt())
    };
    let edge = libm::tan(0.5 * theta).powi(2);
    midpoints(at, 0.0, edge / (edge + a2), 200_000)
}

/// Diffuse reflectance of a smooth interface of index n > 1 from outside [Walsh 1926].
pub fn diffuse_fresnel(n: f64) -> f64 {
    let n2 = n * n;
    let n4 = n2 * n2;
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
        + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln()
}

/// Variance of one path in a closed room of albedo ρ and emission 1, which survives with the constant probability `q`;
/// infinite for q ≤ ρ² (docs/science.md, "Russian roulette").
pub fn roulette_variance(albedo: f64, q: f64) -> f64 {
    if q <= albedo * albedo {
        return f64::INFINITY;
    }
    (1.0 + albedo) / ((1.0 - albedo) * (1.0 - albedo * albedo / q)) - (1.0 - albedo).powi(-2)
}

/// ∫ f from `a` to `b` by the midpoint rule with `n` points.
pub fn midpoints(f: impl Fn(f64) -> f64, a: f64, b: f64, n: u32) -> f64 {
    let h = (b - a) / f64::from(n);
    (0..n).map(|i| f(a + h * (f64::from(i) + 0.5))).sum::<f64>() * h
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, LN_2};

    #[track_caller]
    fn near(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} {b}");
    }

    #[test]
    fn published_values() {
        near(opposite_faces(1.0, 1.0), 0.199_824_90, 1e-8);
        near(adjacent_faces(1.0, 1.0), 0.200_043_78, 1e-8);
        near(linear_edge(&[1.0, 0.37, 2.0, 0.9, 0.5], 2.3), 0.458_013, 5e-7);
        near(linear_edge(&[1.0; 4], 2.1), 0.566_345_8, 5e-8);
        near(linear_edge(&[-0.4, 1.0], 0.3), 0.5, 1e-14);
        near(moving_box(1.0, 1.3, 2.4), 0.522_916_7, 1e-7);
        for (n, f) in [(1.1, 0.025_157_4), (1.5, 0.091_778_0), (2.4, 0.210_181_3)] {
            near(diffuse_fresnel(n), f, 1e-7);
        }
        near(roulette_variance(0.5, 0.8), 0.3636, 5e-5);
        near(roulette_variance(0.9, 0.95), 28.93, 5e-3);
        near(ggx_cap(1.0, FRAC_PI_2), 1.0 - LN_2, 1e-6);
        near(ggx_cap(0.5, FRAC_PI_2), 0.68785, 5e-6);
        near(ggx_cap(0.1, FRAC_PI_2), 0.98830, 5e-6);
    }

    #[test]
    fn forms_agree_where_they_meet() {
        let corners = [[-0.2, 0.3, 0.7], [0.9, 0.3, 0.7], [0.9, 1.1, 0.7], [-0.2, 1.1, 0.7]];
        near(polygon(&corners), parallel_rectangle([-0.2, 0.3], [0.9, 1.1], 0.7), 1e-14);
        let wall = [[0.6, 0.0, 0.0], [0.6, 0.8, 0.0], [0.6, 0.8, 1.3], [0.6, 0.0, 1.3]];
        near(polygon(&wall), perpendicular_rectangle(1.3, 0.8, 0.6), 1e-14);
        near(parallel_disk(0.5, 1.0, 0.0), 0.2, 1e-15);
        near(sphere(1.5, 2.0 / 3.0 - 1e-9), sphere(1.5, 2.0 / 3.0 + 1e-9), 1e-8);
        near(furnace(1.0, 0.5, 1), 1.5, 0.0);
        near(disk_beside_line(0.0), 0.5, 0.0);
    }
}
