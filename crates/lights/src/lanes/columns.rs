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
#[inline(always)]
pub(super) fn lane(columns: &Columns<3>, i: usize) -> Vec3 {
    Vec3::new(columns[0][i], columns[1][i], columns[2][i])
}

/// The lanes of a mask, given as bits.
#[inline(always)]
pub(super) fn lanes_of(bits: u32) -> LanesOf {
    LanesOf(bits)
}

/// Iterator over the set bits.
pub(super) struct LanesOf(u32);

impl Iterator for LanesOf {
    type Item = usize;
    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        // No mask has more lanes; the comparison spares that of every index.
        (lane < MAX_LANES).then_some(lane)
    }
}
