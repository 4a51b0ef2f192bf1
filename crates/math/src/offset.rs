//! Ray origins from error bounds [Pharr, Jakob & Humphreys 2023, §6.8], which avoid self-intersection without an
//! epsilon in world units.
//!
//! The exact position lies somewhere in the box `p ± p_error` around the computed position `p`. The ray origin is moved
//! along the geometric normal until the whole box lies behind it, and each coordinate is then rounded outward.
use crate::lanes::{Real, Vec3x, Word};
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
#[inline]
pub fn offset_origin(p: Vec3, p_error: Vec3, ng: Vec3, d: Vec3) -> Vec3 {
    offset_origins::<f32>(p.into(), p_error.into(), ng.into(), d.into()).into()
}

/// [`offset_origin`] over lanes.
#[inline(always)]
pub fn offset_origins<R: Real>(p: Vec3x<R>, p_error: Vec3x<R>, ng: Vec3x<R>, d: Vec3x<R>) -> Vec3x<R> {
    let n = Vec3x::select(d.dot(ng).lt(R::splat(0.0)), -ng, ng);
    let step = n.abs().dot(p_error);
    Vec3x::new(outward(p.x, step * n.x, n.x), outward(p.y, step * n.y, n.y), outward(p.z, step * n.z, n.z))
}

/// Returns `x + step`, moved to the next float in the direction of `side`.
#[inline(always)]
fn outward<R: Real>(x: R, step: R, side: R) -> R {
    let (zero, sign) = (R::splat(0.0), side.to_bits() & R::Word::splat(SIGN));
    let y = x + step;
    let moved = R::from_bits(next_up(R::from_bits(y.to_bits() ^ sign)).to_bits() ^ sign);
    R::select(side.lt(zero) | side.gt(zero), moved, y)
}

const SIGN: u32 = 0x8000_0000;

/// Returns the next larger float; +∞ and NaN are kept.
#[inline(always)]
pub(crate) fn next_up<R: Real>(x: R) -> R {
    let (zero, one, bits) = (R::splat(0.0), R::Word::splat(1), x.to_bits());
    let larger = bits.wrapping_add(one);
    let smaller = bits.wrapping_sub(one);
    let next = R::Word::select(x.lt(zero), smaller, R::Word::select(x.eq(zero), one, larger));
    R::select(x.lt(R::splat(f32::INFINITY)), R::from_bits(next), x)
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

    #[test]
    fn the_next_float_is_that_of_the_standard_library() {
        let tiny = f32::from_bits(1);
        let numbers = [0.0, tiny, 1e-40, f32::MIN_POSITIVE, 1.0, 1.5, 3e7, f32::MAX, f32::INFINITY];
        for x in numbers.into_iter().flat_map(|x| [x, -x]) {
            assert_eq!(next_up(x).to_bits(), x.next_up().to_bits(), "{x:e}");
            assert_eq!(outward(x, 0.0, -0.5), x.next_down(), "{x:e}");
        }
        assert!(next_up(f32::NAN).is_nan());
        assert_eq!([outward(1.0, 0.5, 0.0), outward(1.0, 0.5, f32::NAN)], [1.5; 2]);
    }
}
