//! Closed forms of radiances, irradiances and coverages, in f64.
//!
//! The linear edge is used most: antialiasing, a square lens, linear motion and the square blur all shift the image
//! linearly in their random numbers, so that the coverage of an edge with all of them combined is the volume of the
//! part of a cube below a plane.

use crate::quadrature;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// Largest rounding error of [`linear_edge`].
const ROUNDING: f64 = 1e-9;

/// Returns the fraction of the unit cube in which Σ a_i ξ_i ≤ c:
/// V = 1/(d! Π a_i) Σ_v (−1)^|v| (c − a·v)₊^d [Barrow & Smith 1979].
///
/// The coefficients may have any signs. Terms whose coefficients are so small that the alternating sum would lose its
/// precision in f64 are replaced by their means, with an error of the order of the square of the coefficient.
pub fn linear_edge(coefficients: &[f64], c: f64) -> f64 {
    let mut a: Vec<f64> = coefficients.iter().map(|a| a.abs()).collect();
    let mut c = c - coefficients.iter().map(|a| a.min(0.0)).sum::<f64>();
    a.sort_by(|x, y| y.total_cmp(x));
    // The estimate of the rounding error is infinite or NaN if a coefficient is zero.
    let is_rounded_off = |a: &[f64]| {
        let scale = factorial(a.len()) * product(a);
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
    (0..1 << a.len()).map(corner).sum::<f64>() / (factorial(a.len()) * product(&a))
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}

fn product(a: &[f64]) -> f64 {
    a.iter().product()
}

/// Returns the irradiance divided by πL from a rectangle parallel to the receiver at unit distance, with one corner
/// above the receiver and sides `x` and `y` of either sign [Howell 2010].
pub fn corner_rectangle(x: f64, y: f64) -> f64 {
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI)
}

/// Returns the irradiance divided by πL from the rectangle between two corners in the plane at `height` above a
/// receiver at the origin.
pub fn parallel_rectangle(low: DVec2, high: DVec2, height: f64) -> f64 {
    let corner = |x: f64, y: f64| corner_rectangle(x / height, y / height);
    corner(high.x, high.y) - corner(low.x, high.y) - corner(high.x, low.y) + corner(low.x, low.y)
}

/// Returns the irradiance divided by πL from a rectangle perpendicular to the receiver's plane at distance `c`. It
/// extends by `b` to one side from its nearest point to the receiver and has the height `a` [Howell 2010].
pub fn perpendicular_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / b, c / b);
    let r = (x * x + y * y).sqrt();
    ((1.0 / y).atan() - y / r * (1.0 / r).atan()) / (2.0 * PI)
}

/// Returns the irradiance divided by πL from a disk of `radius` parallel to the receiver at `height`, whose centre is
/// offset sideways by `d` [Howell 2010].
pub fn parallel_disk(radius: f64, height: f64, d: f64) -> f64 {
    let (r2, s2) = (radius * radius, height * height + d * d);
    0.5 * (1.0 - (s2 - r2) / ((s2 + r2).powi(2) - 4.0 * r2 * d * d).sqrt())
}

/// Returns the irradiance divided by πL from a sphere whose centre is at a distance of `q` ≥ 1 radii, at an angle of
/// cosine `cos` to the receiver's normal. The part below the horizon does not contribute [Howell 2010].
pub fn sphere(q: f64, cos: f64) -> f64 {
    if q * cos >= 1.0 || q * cos <= -1.0 {
        return cos.max(0.0) / (q * q);
    }
    let (x, sin) = ((q * q - 1.0).sqrt(), (1.0 - cos * cos).sqrt());
    let y = -x * cos / sin;
    let s = sin * (1.0 - y * y).max(0.0).sqrt();
    ((cos * y.acos() - x * s) / (q * q) + s.atan2(x)) * FRAC_1_PI
}

/// Returns the irradiance divided by πL at the origin from a polygon above the receiver's plane z = 0 [Lambert 1760]:
/// the sum over edges of the angle of the edge times the cosine of its plane's normal, divided by 2π.
pub fn polygon(corners: &[DVec3]) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let cross = a.cross(b);
        let sine = cross.length();
        if sine == 0.0 { 0.0 } else { sine.atan2(a.dot(b)) * cross.z / sine }
    };
    ((0..corners.len()).map(edge).sum::<f64>() / (2.0 * PI)).abs()
}

/// Returns the part of a convex polygon where `inside` ≥ 0. `inside` must be linear.
pub fn clipped(corners: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (x, y) = (inside(a), inside(b));
        if x >= 0.0 {
            kept.push(a);
        }
        if (x < 0.0) != (y < 0.0) {
            kept.push(a + (b - a) * (x / (x - y)));
        }
    }
    kept
}

/// Returns ∫∫ h/(h² + x² + y²)^(3/2) over the rectangle between two corners: the flux from an isotropic point light of
/// unit intensity at height `h` above the origin, which is the solid angle of the rectangle.
pub fn flux_of_point_light(low: DVec2, high: DVec2, h: f64) -> f64 {
    let corner = |x: f64, y: f64| (x * y / (h * (h * h + x * x + y * y).sqrt())).atan();
    corner(high.x, high.y) - corner(low.x, high.y) - corner(high.x, low.y) + corner(low.x, low.y)
}

/// Returns ∫ h/(h² + x² + y²)^(3/2) dx between two positions on a line that is offset by `y` from an isotropic point
/// light at height `h`.
pub fn point_light_along_line(from: f64, to: f64, y: f64, h: f64) -> f64 {
    let d2 = h * h + y * y;
    let up_to = |x: f64| h * x / (d2 * (d2 + x * x).sqrt());
    up_to(to) - up_to(from)
}

/// Returns the radiance of the inside of a sphere of albedo `rho` and `radius` with a point light of unit intensity in
/// it, from direct light at distance `d` and cosine `cos` and from one interreflection. The latter is the same
/// everywhere, because the form factor between two points on the inside of a sphere is constant, so that only the mean
/// direct irradiance, 4π/(4πR²), has an effect.
pub fn inside_of_sphere(rho: f64, radius: f64, d: f64, cos: f64) -> f64 {
    rho * FRAC_1_PI * (cos / (d * d) + rho / (radius * radius))
}

/// Returns the width of the penumbra on the floor of a straight edge at height `h` below a light of width `w` at height
/// `light`.
pub fn penumbra_width(w: f64, h: f64, light: f64) -> f64 {
    w * h / (light - h)
}

/// Returns the fraction of a disk on the inner side of a straight line, whose distance from the centre is `s` radii.
pub fn disk_beside_line(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    0.5 + (s * (1.0 - s * s).sqrt() + s.asin()) * FRAC_1_PI
}

/// Returns the diameter in pixels of the circle of confusion of a point at distance `z` along the axis. `aperture` is
/// the diameter of the lens, and `height` is the height of the image in pixels.
pub fn blur_diameter(aperture: f64, z: f64, focus: f64, height: f64, tan_half: f64) -> f64 {
    aperture * (1.0 / z - 1.0 / focus).abs() * height / (2.0 * tan_half)
}

/// Returns the radiance of a perfectly reflecting GGX surface with single scattering, seen along its normal, if the
/// only light is a white cap of half angle `theta` ≤ 90° about the normal [Heitz 2014; Walter 2007].
pub fn ggx_cap(alpha: f64, theta: f64) -> f64 {
    let a2 = alpha * alpha;
    let integrand = |m: f64| {
        let (tan, tan_wi) = (m.tan(), (2.0 * m).tan());
        let g2 = 2.0 / (1.0 + (1.0 + a2 * tan_wi * tan_wi).sqrt());
        g2 * 2.0 * a2 * tan * (1.0 + tan * tan) / (tan * tan + a2).powi(2)
    };
    quadrature::line(integrand, 0.0, 0.5 * theta, 1e-9)
}

/// Returns the radiance as [`ggx_cap`] does, for transmitted light: a surface that reflects nothing, seen along its
/// normal from outside, with a white cap of half angle `theta` about the normal inside, where the index of refraction
/// is `eta` times as high. A facet at θ_m refracts light by θ_m − asin(sin θ_m/η), and radiance is divided by η²
/// [Walter 2007].
pub fn ggx_refracted_cap(alpha: f64, eta: f64, theta: f64) -> f64 {
    let a2 = alpha * alpha;
    let bent = |m: f64| m - (m.sin() / eta).asin();
    let integrand = |m: f64| {
        let (tan, tan_wi) = (m.tan(), bent(m).tan());
        let g2 = 2.0 / (1.0 + (1.0 + a2 * tan_wi * tan_wi).sqrt());
        g2 * 2.0 * a2 * tan * (1.0 + tan * tan) / (tan * tan + a2).powi(2)
    };
    // Bisection for the facet that refracts light to the edge of the cap, because `bent` increases with the angle.
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if bent(middle) < theta { low = middle } else { high = middle }
    }
    quadrature::line(integrand, 0.0, low, 1e-9) / (eta * eta)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn near(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} {b}");
    }

    #[test]
    fn linear_edges_in_every_dimension() {
        near(linear_edge(&[2.0], 0.5), 0.25, 1e-15);
        near(linear_edge(&[1.0, 0.37, 2.0, 0.9, 0.5], 2.3), 0.458_013, 5e-7);
        near(linear_edge(&[1.0; 4], 2.1), 0.566_345_8, 5e-8);
        // ax + by ≤ c in the unit square is a trapezoid, and changing a sign mirrors it.
        near(linear_edge(&[0.4, 1.0], 0.7), 0.5, 1e-14);
        near(linear_edge(&[-0.4, 1.0], 0.3), 0.5, 1e-14);
        near(linear_edge(&[1.0, 1e-12], 0.3), 0.3, 1e-11);
        near(linear_edge(&[1.0, 0.0], 0.3), 0.3, 1e-15);
        assert_eq!((linear_edge(&[1.0, 1.0], -0.1), linear_edge(&[1.0, 1.0], 2.1)), (0.0, 1.0));
        let mixed = linear_edge(&[0.8, -0.5, 0.3], 0.2);
        let by_lines = |x: f64, y: f64| ((0.2 - 0.8 * x + 0.5 * y) / 0.3).clamp(0.0, 1.0);
        near(mixed, quadrature::rectangle(by_lines, [0.0; 2], [1.0; 2], 1e-7), 1e-6);
    }

    #[test]
    fn rectangles_and_disks_are_their_integrals() {
        // L cosθ cosθ'/d² over the surface, divided by πL.
        let parallel = |x: f64, y: f64| 0.49 / (0.49 + x * x + y * y).powi(2) * FRAC_1_PI;
        let (low, high) = (DVec2::new(-0.2, 0.3), DVec2::new(0.9, 1.1));
        let sum = quadrature::rectangle(parallel, low.to_array(), high.to_array(), 1e-9);
        near(parallel_rectangle(low, high, 0.7), sum, 1e-9);
        let standing = |y: f64, z: f64| 0.6 * z / (0.36 + y * y + z * z).powi(2) * FRAC_1_PI;
        let sum = quadrature::rectangle(standing, [0.0; 2], [0.8, 1.3], 1e-9);
        near(perpendicular_rectangle(1.3, 0.8, 0.6), sum, 1e-9);
        let disk = |r: f64, phi: f64| r * parallel(0.5 + r * phi.cos(), r * phi.sin());
        let sum = quadrature::rectangle(disk, [0.0; 2], [0.8, 2.0 * PI], 1e-9);
        near(parallel_disk(0.8, 0.7, 0.5), sum, 1e-8);
        let point = |x: f64, y: f64| 0.7 / (0.49 + x * x + y * y).powf(1.5);
        let sum = quadrature::rectangle(point, low.to_array(), high.to_array(), 1e-9);
        near(flux_of_point_light(low, high, 0.7), sum, 1e-9);
    }

    #[test]
    fn polygons_are_rectangles_and_spheres_are_caps() {
        let corners = [(-0.2, 0.3), (0.9, 0.3), (0.9, 1.1), (-0.2, 1.1)].map(|(x, y)| DVec3::new(x, y, 0.7));
        let whole = parallel_rectangle(DVec2::new(-0.2, 0.3), DVec2::new(0.9, 1.1), 0.7);
        near(polygon(&corners), whole, 1e-14);
        let line = |p: DVec3| p.x + 0.4 * p.y - 0.5;
        let (right, left) = (clipped(&corners, line), clipped(&corners, |p| -line(p)));
        near(polygon(&right) + polygon(&left), whole, 1e-14);
        assert!(polygon(&right) > 0.1 * whole && polygon(&left) > 0.1 * whole);
        for (q, cos) in [(1.5, 0.2), (1.2, -0.3), (3.0, 0.9), (1.01, 0.0)] {
            // The integral of cosθ₊ over the cone about the direction to the centre.
            let (sin, edge) = ((1.0f64 - cos * cos).sqrt(), (1.0f64 / q).asin());
            let seen = |a: f64, phi: f64| a.sin() * (a.cos() * cos + a.sin() * sin * phi.cos()).max(0.0);
            let sum = quadrature::rectangle(seen, [0.0; 2], [edge, 2.0 * PI], 1e-7);
            near(sphere(q, cos), sum * FRAC_1_PI, 1e-6);
        }
        near(sphere(1.5, 2.0 / 3.0 - 1e-9), sphere(1.5, 2.0 / 3.0 + 1e-9), 1e-8);
    }

    /// Compared with the integral of the BTDF over the directions of the cap: f = o·i/(cosθ_o·cosθ_i)·D·G2/(o/η −
    /// i)²/η², with o and i the cosines at the facet [Walter 2007, eq. 21, of radiance].
    #[test]
    fn rough_interfaces_are_their_btdf() {
        for (alpha, eta, theta) in [(0.3f64, 1.5f64, 0.4), (0.8, 1.33, 0.3), (0.5, 2.0, 0.6)] {
            let a2 = alpha * alpha;
            let radiance = |i: f64| {
                let (wo, wi) = (DVec3::Z, DVec3::new(i.sin(), 0.0, -i.cos()));
                let m = -(wo + wi * eta).normalize();
                let (o, inner) = (wo.dot(m), -wi.dot(m));
                if o <= 0.0 || inner <= 0.0 {
                    return 0.0;
                }
                let tan2 = (1.0 - m.z * m.z) / (m.z * m.z);
                let d = a2 / (PI * m.z.powi(4) * (a2 + tan2).powi(2));
                let g2 = 2.0 / (1.0 + (1.0 + a2 * i.tan().powi(2)).sqrt());
                o * inner * d * g2 / ((o / eta - inner).powi(2) * eta * eta) * 2.0 * PI * i.sin()
            };
            let sum = quadrature::line(radiance, 0.0, theta, 1e-9);
            near(ggx_refracted_cap(alpha, eta, theta), sum, 1e-6);
        }
    }

    #[test]
    fn point_lights_over_lines_and_in_spheres() {
        let along = |x: f64| 0.7 / (0.49 + x * x + 0.04).powf(1.5);
        near(point_light_along_line(-0.3, 0.8, 0.2, 0.7), quadrature::line(along, -0.3, 0.8, 1e-10), 1e-9);
        // With the light in the middle, the direct irradiance is 1/R², and the interreflected one is ρ times that.
        near(inside_of_sphere(0.5, 2.0, 2.0, 1.0), 0.5 * FRAC_1_PI * 0.25 * 1.5, 1e-15);
    }

    #[test]
    fn rough_mirrors_and_disks_beside_lines() {
        near(ggx_cap(1.0, FRAC_PI_2), 1.0 - std::f64::consts::LN_2, 1e-6);
        near(ggx_cap(0.5, FRAC_PI_2), 0.68785, 5e-6);
        near(ggx_cap(0.1, FRAC_PI_2), 0.98830, 5e-6);
        let chord = |x: f64| 2.0 * (1.0 - x * x).sqrt() * FRAC_1_PI;
        near(disk_beside_line(0.3), quadrature::line(chord, -1.0, 0.3, 1e-9), 1e-8);
        near(penumbra_width(0.5, 1.0, 3.0), 0.25, 0.0);
        // The blur of a point at infinity is A/z_f in units of the tangent.
        near(blur_diameter(0.1, f64::INFINITY, 2.0, 400.0, 0.5), 20.0, 1e-12);
    }
}
