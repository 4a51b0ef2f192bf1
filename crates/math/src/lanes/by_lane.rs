//! Arguments outside of the domain of a formula: single lanes are computed by a scalar function.

use super::mask::Mask;
use super::real::{MAX_LANES, Real};

/// Replaces the lanes of `mask` in `value` by `f(x, y)`. The lanes are expected to be few or none.
#[inline(always)]
pub fn replace_where<R: Real>(mask: R::Mask, value: R, x: R, y: R, f: fn(f32, f32) -> f32) -> R {
    if !mask.any() {
        return value;
    }
    let (mut values, mut xs, mut ys) = ([0.0; MAX_LANES], [0.0; MAX_LANES], [0.0; MAX_LANES]);
    value.store(&mut values);
    x.store(&mut xs);
    y.store(&mut ys);
    replace_lanes(mask.bitmask(), &mut values, &xs, &ys, f);
    R::load(&values)
}

#[cold]
#[inline(never)]
fn replace_lanes(
    mask: u32,
    values: &mut [f32; MAX_LANES],
    x: &[f32; MAX_LANES],
    y: &[f32; MAX_LANES],
    f: fn(f32, f32) -> f32,
) {
    for (lane, value) in values.iter_mut().enumerate() {
        if mask >> lane & 1 == 1 {
            *value = f(x[lane], y[lane]);
        }
    }
}
