//! Tilted shading normals of the vertices of a batch, by row.

use super::columns::{Numbers, Vectors, Words};
use crate::normals::Tilt;
use dapple_math::lanes::{Real, Vec2x, Word};

const TILTED: u32 = 1;
const OVER: u32 = 2;
const MAPPED: u32 = 4;

/// The tilts of all rows. The columns are those of [`Tilt`].
pub(super) struct Tilts {
    /// Whether any row has a tilt.
    pub any: bool,
    flags: Words,
    horizon: Vectors,
    lean: Vectors,
    angle: Numbers,
    end: [Numbers; 2],
    unmapped: Numbers,
}

impl Tilts {
    pub fn new() -> Self {
        let (vectors, numbers) = (Vectors::new, Numbers::new);
        Self {
            any: false,
            flags: Words::new(),
            horizon: vectors(),
            lean: vectors(),
            angle: numbers(),
            end: [numbers(), numbers()],
            unmapped: numbers(),
        }
    }

    /// Sets the tilt of a row, or that it has none.
    #[inline(always)]
    pub fn set(&mut self, i: usize, tilt: Option<&Tilt<f32>>) {
        match tilt {
            Some(tilt) => self.store::<f32>(i, true, tilt),
            None => self.flags.set(i, 0),
        }
    }

    /// Sets that lanes from row `i` on have no tilt.
    #[inline(always)]
    pub fn store_none<W: Word>(&mut self, i: usize) {
        self.flags.store(i, W::splat(0));
    }

    /// Sets the tilts of the lanes of `mask` from row `i` on, and that the others have none.
    #[inline(always)]
    pub fn store<R: Real>(&mut self, i: usize, mask: R::Mask, tilt: &Tilt<R>) {
        let (none, over, mapped) = (R::Word::splat(0), R::Word::splat(OVER), R::Word::splat(MAPPED));
        let over = R::Word::select(tilt.is_over, over, none);
        let mapped = R::Word::select(tilt.is_mapped, mapped, none);
        let flags = R::Word::splat(TILTED) | over | mapped;
        self.any = true;
        self.flags.store(i, R::Word::select(mask, flags, none));
        self.horizon.store(i, tilt.horizon);
        self.lean.store(i, tilt.lean);
        self.angle.store(i, tilt.angle);
        let [x, y] = &mut self.end;
        x.store(i, tilt.end.x);
        y.store(i, tilt.end.y);
        self.unmapped.store(i, tilt.unmapped);
    }

    /// The tilts from row `i` on, and the lanes that have one.
    #[inline(always)]
    pub fn load<R: Real>(&self, i: usize) -> (Tilt<R>, R::Mask) {
        let (flags, none) = (self.flags.load::<R::Word>(i), R::Word::splat(0));
        let [x, y] = &self.end;
        let tilt = Tilt {
            horizon: self.horizon.load(i),
            lean: self.lean.load(i),
            angle: self.angle.load(i),
            end: Vec2x::new(x.load(i), y.load(i)),
            is_over: (flags & R::Word::splat(OVER)).ne(none),
            is_mapped: (flags & R::Word::splat(MAPPED)).ne(none),
            unmapped: self.unmapped.load(i),
        };
        (tilt, (flags & R::Word::splat(TILTED)).ne(none))
    }
}
