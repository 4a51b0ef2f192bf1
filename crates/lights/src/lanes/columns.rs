//! Lanes as columns of numbers, for the rare lanes that are computed one by one.
use dapple_math::lanes::{MAX_LANES, Real, Vec3x};
use glam::Vec3;

/// N numbers per lane.
pub(super) type Columns<const N: usize> = [[f32; MAX_LANES]; N];

#[inline(always)]
pub(super) fn stored<R: Real, const N: usize>(values: [R; N]) -> Columns<N> {
    let mut columns = [[0.0; MAX_LANES]; N];
    for i in 0..N {
        values[i].store(&mut columns[i]);
    }
    columns
}

#[inline(always)]
pub(super) fn three<R: Real>(v: Vec3x<R>) -> Columns<3> {
    stored([v.x, v.y, v.z])
}

/// The vector in one lane.
pub(super) fn lane(columns: &Columns<3>, i: usize) -> Vec3 {
    Vec3::new(columns[0][i], columns[1][i], columns[2][i])
}

/// The lanes of a mask, given as bits.
pub(super) fn lanes_of(bits: u32) -> impl Iterator<Item = usize> {
    (0..MAX_LANES).filter(move |i| bits >> i & 1 == 1)
}
