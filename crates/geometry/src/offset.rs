//! Error-bounded ray origins [pbrt-v4 §6.8]: no epsilon.

use glam::Vec3;

/// u = 2^-24, the unit roundoff of f32.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// γ_n = n·u / (1 − n·u): bound of the relative error of n roundings.
pub const fn gamma(n: u32) -> f32 {
    n as f32 * UNIT_ROUNDOFF / (1.0 - n as f32 * UNIT_ROUNDOFF)
}

/// `p` moved along unit `ng` out of its own error box to the side `d` points to; each coordinate is rounded outward.
pub fn offset_origin(p: Vec3, p_error: Vec3, ng: Vec3, d: Vec3) -> Vec3 {
    let distance = ng.abs().dot(p_error);
    let shift = if d.dot(ng) < 0.0 { -ng * distance } else { ng * distance };
    let moved = p + shift;
    Vec3::new(outward(moved.x, shift.x), outward(moved.y, shift.y), outward(moved.z, shift.z))
}

fn outward(x: f32, shift: f32) -> f32 {
    if shift > 0.0 {
        x.next_up()
    } else if shift < 0.0 {
        x.next_down()
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_out_of_the_error_box() {
        for scale in [1e-30f32, 1e-6, 1.0, 1e6, 1e30] {
            let p = Vec3::new(0.3, -0.7, 0.2) * scale;
            let error = p.abs() * gamma(7);
            let n = Vec3::new(0.6, 0.0, 0.8);
            let q = offset_origin(p, error, n, n);
            assert!((q - p).as_dvec3().dot(n.as_dvec3()) > n.abs().dot(error).into());
            let q = offset_origin(p, error, n, -n);
            assert!((q - p).as_dvec3().dot(n.as_dvec3()) < -f64::from(n.abs().dot(error)));
        }
        assert!(offset_origin(Vec3::ZERO, Vec3::ZERO, Vec3::Z, Vec3::Z).is_finite());
    }
}
