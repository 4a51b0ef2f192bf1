//! Film points and directions of large images and narrow views, which need more than f32.

use glam::{DVec2, DVec3, Vec2, Vec3};

/// Returns the film point on the plane whose centre is 0, top edge y = 1 and bottom edge y = −1, with x to the right in
/// the same unit.
#[inline]
pub fn film_plane(pixel: (u32, u32), fraction: Vec2, size: (u32, u32)) -> DVec2 {
    let (w, h) = (size.0 as f64, size.1.max(1) as f64);
    let x = pixel.0 as f64 - 0.5 * w + fraction.x as f64;
    let y = pixel.1 as f64 - 0.5 * h + fraction.y as f64;
    DVec2::new(x, -y) * (2.0 / h)
}

/// Below this angle between pixels, in radians, the error of a unit vector in f32 (2⁻²⁴) exceeds 1/64 pixel.
pub const NARROW: f64 = 64.0 / (1u64 << 24) as f64;

/// Returns the f32 vector that is closest in direction to the unit vector `d` among [`LENGTHS`] lengths. The rounding
/// errors of different lengths are effectively random, so that the best of n is √n times as good as one. The direction
/// is off by 1e-9 rad typically and by 4e-9 at most (measured).
#[cold]
pub fn finest(d: DVec3) -> Vec3 {
    // A direction along an axis keeps the full precision of its small components.
    let (mut best, mut least) = (d.as_vec3(), f64::INFINITY);
    let unit = d / d.abs().max_element();
    for k in 0..LENGTHS {
        let rounded = (unit * (1.0 + f64::from(k) / f64::from(LENGTHS))).as_vec3();
        let off = unit.cross(rounded.as_dvec3()).length_squared() / rounded.as_dvec3().length_squared();
        if off < least {
            (best, least) = (rounded, off);
        }
    }
    best
}

/// Number of lengths between 1 and 2 that are tried. It is a power of two, so that the largest component is exact.
const LENGTHS: u32 = 1024;
