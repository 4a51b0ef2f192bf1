//! Ray origins from error bounds [Pharr, Jakob & Humphreys 2023, §6.8], which avoid self-intersection without an
//! epsilon in world units.
//!
//! The exact position lies somewhere in the box `p ± p_error` around the computed position `p`. The ray origin is moved
//! along the geometric normal until the whole box lies behind it, and each coordinate is then rounded outward.
use glam::Vec3;

/// The unit roundoff of f32, 2⁻²⁴.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// Returns γₙ = n·u / (1 − n·u), the bound of the relative error of n rounded operations [Higham 2002, §3.1].
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// Moves `p` along the normal `ng` out of its error box, to the side that `d` points to, and rounds each coordinate
/// outward.
///
/// The distance is |ng|·p_error along `ng` [Pharr, Jakob & Humphreys 2023, §6.8.6]. A coordinate whose component of
/// `ng` is not zero moves by at least one ulp, so that the origin leaves the plane even where `p_error` underflows or
/// is zero. A coordinate whose component of `ng` is zero does not change.
pub fn offset_origin(p: Vec3, p_error: Vec3, ng: Vec3, d: Vec3) -> Vec3 {
    let n = if d.dot(ng) < 0.0 { -ng } else { ng };
    let step = n.abs().dot(p_error);
    Vec3::new(outward(p.x, step * n.x, n.x), outward(p.y, step * n.y, n.y), outward(p.z, step * n.z, n.z))
}

/// Returns `x + step`, moved to the next float in the direction of `side`.
fn outward(x: f32, step: f32, side: f32) -> f32 {
    let y = x + step;
    if side > 0.0 {
        y.next_up()
    } else if side < 0.0 {
        y.next_down()
    } else {
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_the_error_box_on_the_side_of_the_direction() {
        let scales = [1e-42f32, 1e-30, 1e-6, 1.0, 1e5, 1e30];
        let normals =
            [Vec3::Z, Vec3::new(0.6, -0.8, 0.0), Vec3::new(-0.48, 0.64, 0.6), Vec3::splat(0.57735026)];
        for s in scales {
            for n in normals {
                let p = Vec3::new(1.0, -2.0, 0.5) * s;
                let error = p.abs() * gamma(7);
                for side in [1.0f32, -1.0] {
                    let q = offset_origin(p, error, n, n * side);
                    let moved = (q.as_dvec3() - p.as_dvec3()).dot(n.as_dvec3()) * side as f64;
                    assert!(moved > n.abs().as_dvec3().dot(error.as_dvec3()) * 0.999, "{s} {n:?} {moved}");
                }
            }
        }
    }

    #[test]
    fn grows_with_the_error_and_never_stands_still() {
        let (p, n) = (Vec3::new(0.0, 3.0, -7.0), Vec3::new(0.36, 0.48, 0.8));
        let mut last = 0.0;
        for k in 0..60 {
            let error = Vec3::splat(if k == 0 { 0.0 } else { 2f32.powi(k - 50) });
            let moved = (offset_origin(p, error, n, n).as_dvec3() - p.as_dvec3()).dot(n.as_dvec3());
            assert!(moved > 0.0 && moved >= last, "{k}: {moved} after {last}");
            last = moved;
        }
        assert!(offset_origin(Vec3::ZERO, Vec3::ZERO, Vec3::Z, Vec3::Z).z > 0.0);
        assert_eq!(offset_origin(p, Vec3::ONE, Vec3::Z, Vec3::Z).truncate(), p.truncate());
    }
}
