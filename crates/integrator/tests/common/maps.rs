//! Sample positions of a midpoint grid on a light, reimplemented in f64, and the variation of an integrand there.

use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// |∫f − midpoint rule on nx×ny cells| ≤ V_x/(2 nx) + V_y/(2 ny), where V is the mean of the total variation of f over
/// the lines of either direction: in each cell of a line the midpoint differs from the mean by at most half the
/// variation there, and the rule is applied to x on every line, then to y on the lines through the midpoints.
pub fn midpoint_bound([vx, vy]: [f64; 2], [nx, ny]: [u32; 2]) -> f64 {
    0.5 * (vx / f64::from(nx) + vy / f64::from(ny))
}

/// Mean total variations along x and along y of f on the unit square, from 64 lines of 400 steps each, increased by 5
/// %.
pub fn variations(f: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    let at = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let along =
        |g: &dyn Fn(f64) -> f64| (1..400).map(|i| (g(at(i, 400)) - g(at(i - 1, 400))).abs()).sum::<f64>();
    let mean = |v: &dyn Fn(f64) -> f64| (0..64).map(|j| v(at(j, 64))).sum::<f64>() / 64.0 * 1.05;
    [mean(&|y| along(&|x| f(x, y))), mean(&|x| along(&|y| f(x, y)))]
}

/// Concentric rings [Shirley & Chiu 1997].
pub fn disk(u: f64, v: f64) -> [f64; 2] {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (r, phi) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * y / x) } else { (y, FRAC_PI_2 - FRAC_PI_4 * x / y) };
    [r * phi.cos(), r * phi.sin()]
}

/// Uniform direction in a cone about `axis`; the parameter is 1 − cos of its half angle.
pub fn cone(axis: DVec3, one_minus_cos: f64, u: f64, v: f64) -> DVec3 {
    let cos = 1.0 - u * one_minus_cos;
    let sin = (1.0 - cos * cos).sqrt();
    let side = axis.any_orthonormal_vector();
    let (s, c) = (TAU * v).sin_cos();
    axis * cos + (side * c + axis.cross(side) * s) * sin
}

/// Solid angle of a rectangle seen from the origin, and the direction at (u, v) of its uniform parametrisation: first
/// the strip along `e2` by solid angle, then the position in it [Ureña, Fajardo & King 2013].
pub fn rectangle_in_solid_angle(corner: DVec3, e1: DVec3, e2: DVec3) -> (f64, impl Fn(f64, f64) -> DVec3) {
    let axes = DMat3::from_cols(e1.normalize(), e2.normalize(), e1.cross(e2).normalize());
    let low = axes.transpose() * corner;
    let (x0, y0, z0) = (low.x, low.y, low.z);
    let (x1, y1) = (x0 + e1.length(), y0 + e2.length());
    // Solid angle from the z axis to x, for all of y.
    let corner_angle = move |x: f64, y: f64| (x * y / (z0.abs() * (x * x + y * y + z0 * z0).sqrt())).atan();
    let up_to = move |x: f64| corner_angle(x, y1) - corner_angle(x, y0);
    let omega = up_to(x1) - up_to(x0);
    let direction = move |u: f64, v: f64| {
        // Bisection, because the share grows with x.
        let (mut a, mut b) = (x0, x1);
        for _ in 0..50 {
            let x = 0.5 * (a + b);
            if up_to(x) - up_to(x0) < u * omega { a = x } else { b = x }
        }
        let d = (a * a + z0 * z0).sqrt();
        let sine = |y: f64| y / (d * d + y * y).sqrt();
        let h = sine(y0) + v * (sine(y1) - sine(y0));
        axes * DVec3::new(a, h * d / (1.0 - h * h).sqrt(), z0)
    };
    (omega, move |u, v| direction(u, v).normalize())
}
