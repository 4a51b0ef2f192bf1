//! Columns: one number or vector per row, read and written by row or over lanes.

use dapple_math::lanes::{MAX_LANES, Real, Vec3x, Word};
use glam::Vec3;

/// The largest number of rows.
pub(super) const ROWS: usize = 1024;

/// Number of places of a column: writes over lanes may reach beyond the last row.
const PLACES: usize = ROWS + MAX_LANES;

/// All columns have the same constant length, so that one comparison checks an index for all of them.
type Column<T> = Box<[T; PLACES]>;

/// A column of numbers.
pub(super) struct Numbers(Column<f32>);

/// A column of words.
pub(super) struct Words(Column<u32>);

/// A column of vectors.
pub(super) struct Vectors([Column<f32>; 3]);

impl Numbers {
    pub fn new() -> Self {
        Self(Box::new([0.0; PLACES]))
    }

    #[inline(always)]
    pub fn get(&self, i: usize) -> f32 {
        self.0[i]
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, x: f32) {
        self.0[i] = x;
    }

    #[inline(always)]
    pub fn load<R: Real>(&self, i: usize) -> R {
        R::load(&self.0[i..])
    }

    /// The numbers of all rows.
    #[inline(always)]
    pub fn all(&self) -> &[f32] {
        &*self.0
    }

    /// Reads the row `i` of every lane.
    #[inline(always)]
    pub fn gather<R: Real>(&self, i: R::Word) -> R {
        R::gather(&*self.0, i)
    }

    #[inline(always)]
    pub fn store<R: Real>(&mut self, i: usize, x: R) {
        x.store(&mut self.0[i..]);
    }

    /// Packs the lanes of `mask` from row `i` on.
    #[inline(always)]
    pub fn pack<R: Real>(&mut self, i: usize, mask: R::Mask, x: R) {
        x.compress_store(mask, &mut self.0[i..]);
    }
}

impl Words {
    pub fn new() -> Self {
        Self(Box::new([0; PLACES]))
    }

    #[inline(always)]
    pub fn get(&self, i: usize) -> u32 {
        self.0[i]
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, x: u32) {
        self.0[i] = x;
    }

    #[inline(always)]
    pub fn load<W: Word>(&self, i: usize) -> W {
        W::load(&self.0[i..])
    }

    #[inline(always)]
    pub fn store<W: Word>(&mut self, i: usize, x: W) {
        x.store(&mut self.0[i..]);
    }

    /// As [`Numbers::gather`].
    #[inline(always)]
    pub fn gather<W: Word>(&self, i: W) -> W {
        W::gather(&*self.0, i)
    }

    /// As [`Numbers::pack`]; returns the number of lanes.
    #[inline(always)]
    pub fn pack<W: Word>(&mut self, i: usize, mask: W::Mask, x: W) -> usize {
        x.compress_store(mask, &mut self.0[i..])
    }
}

impl Vectors {
    pub fn new() -> Self {
        Self(std::array::from_fn(|_| Box::new([0.0; PLACES])))
    }

    /// The components of all rows.
    #[inline(always)]
    pub fn all(&self) -> [&[f32]; 3] {
        let [x, y, z] = &self.0;
        [&**x, &**y, &**z]
    }

    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.0;
        Vec3::new(x[i], y[i], z[i])
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        let [x, y, z] = &mut self.0;
        (x[i], y[i], z[i]) = (v.x, v.y, v.z);
    }

    #[inline(always)]
    pub fn load<R: Real>(&self, i: usize) -> Vec3x<R> {
        let [x, y, z] = &self.0;
        Vec3x::load([&x[i..], &y[i..], &z[i..]])
    }

    #[inline(always)]
    pub fn store<R: Real>(&mut self, i: usize, v: Vec3x<R>) {
        let [x, y, z] = &mut self.0;
        v.store([&mut x[i..], &mut y[i..], &mut z[i..]]);
    }

    /// As [`Numbers::gather`].
    #[inline(always)]
    pub fn gather<R: Real>(&self, i: R::Word) -> Vec3x<R> {
        let [x, y, z] = &self.0;
        Vec3x::gather([&**x, &**y, &**z], i)
    }

    /// As [`Numbers::pack`].
    #[inline(always)]
    pub fn pack<R: Real>(&mut self, i: usize, mask: R::Mask, v: Vec3x<R>) {
        let [x, y, z] = &mut self.0;
        v.compress_store(mask, [&mut x[i..], &mut y[i..], &mut z[i..]]);
    }
}
