//! Directional albedo of the GGX reflection lobe over lanes, from a table.
//!
//! E(μ) = F0·C(μ,α) + (F90 − F0)·B(μ,α) for Schlick's Fresnel term. Smooth surfaces have C = 1, B = (1 − μ)⁵. Rough
//! surfaces use a table (see `examples/albedo_table.rs`), bilinear in μ and roughness, whose values are nowhere below
//! the exact ones — *approximation*, above them by at most 0.005 — and whose mean over the hemisphere is exact for the
//! interpolant.

use super::fresnel::schlick_weight;
use super::microfacet::SMOOTH_ALPHA;
use crate::albedo_table::{MEAN, NX, NY, TABLE};
use dapple_math::lanes::{Mask, Real, Word};

/// √1e-3, the roughness of the first row.
const R0: f32 = 0.031_622_78;

/// The nodes of the table, row by row: (C, B) and their differences to the next node of the row.
static NODES: [[f32; 4]; NX * NY] = {
    let mut nodes = [[0.0; 4]; NX * NY];
    let mut k = 0;
    while k < NX * NY {
        let (j, i) = (k / NX, k % NX);
        let (here, next) = (TABLE[j][i], TABLE[j][if i + 1 < NX { i + 1 } else { i }]);
        nodes[k] = [here[0], here[1], next[0] - here[0], next[1] - here[1]];
        k += 1;
    }
    nodes
};

/// The mean of every row: (C, B) and their differences to the next row.
static MEANS: [[f32; 4]; NY] = {
    let mut means = [[0.0; 4]; NY];
    let mut j = 0;
    while j < NY {
        let (here, next) = (MEAN[j], MEAN[if j + 1 < NY { j + 1 } else { j }]);
        means[j] = [here[0], here[1], next[0] - here[0], next[1] - here[1]];
        j += 1;
    }
    means
};

/// A position between two rows of the table for one roughness, or a smooth surface.
#[derive(Clone, Copy, Debug)]
pub struct AlbedoRow<R: Real> {
    rough: R::Mask,
    row: R::Word,
    fraction: R,
}

/// The two parts of a directional albedo: E = F0·`c` + (F90 − F0)·`b`.
#[derive(Clone, Copy, Debug)]
pub struct DirectionalAlbedo<R> {
    /// Albedo of the perfectly reflecting lobe.
    pub c: R,
    /// Albedo weighted by (1 − wo·m)⁵.
    pub b: R,
}

impl<R: Real> DirectionalAlbedo<R> {
    /// Returns F0·c + (F90 − F0)·b.
    #[inline(always)]
    pub fn with(self, f0: R, f90: R) -> R {
        f0 * self.c + (f90 - f0) * self.b
    }

    /// Returns both parts times `gain`.
    #[inline(always)]
    pub fn times(self, gain: R) -> Self {
        Self { c: gain * self.c, b: gain * self.b }
    }
}

impl<R: Real> AlbedoRow<R> {
    /// Returns the row of smooth surfaces.
    #[inline(always)]
    pub fn smooth() -> Self {
        Self { rough: R::Mask::splat(false), row: R::Word::splat(0), fraction: R::splat(0.0) }
    }

    /// Returns the row of one α.
    #[inline(always)]
    pub fn new(alpha: R) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let rough = alpha.ge(R::splat(SMOOTH_ALPHA));
        if !rough.any() {
            return Self { rough, row: R::Word::splat(0), fraction: zero };
        }
        let last = R::splat((NY - 1) as f32);
        let r = alpha.min(one).sqrt();
        let y = ((r - R::splat(R0)).max(zero) * R::splat(1.0 / (1.0 - R0))).sqrt() * last;
        let row = y.min(R::splat((NY - 2) as f32)).to_int();
        let j = row.int_to_real();
        let (low, high) = (roughness(j), roughness(j + one));
        let fraction = ((r - low) / (high - low)).max(zero).min(one);
        Self { rough, row, fraction }
    }

    /// Returns the directional albedo at the cosine `mu` (0..1).
    #[inline(always)]
    pub fn at(self, mu: R) -> DirectionalAlbedo<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let smooth = DirectionalAlbedo { c: one, b: schlick_weight(mu) };
        if !self.rough.any() {
            return smooth;
        }
        let mu = mu.max(zero).min(one);
        let x = (mu.sqrt().sqrt() * R::splat((NX - 1) as f32)).min(R::splat((NX - 2) as f32));
        let i = x.to_int();
        let (low, high) = (node(i.int_to_real()), node(i.int_to_real() + one));
        let x = ((mu - low) / (high - low)).max(zero).min(one);
        let index = (self.row << NX.ilog2()).wrapping_add(i);
        let [c, b, dc, db] = R::gather_rows(&NODES, index);
        let [c1, b1, dc1, db1] = R::gather_rows(&NODES, index.wrapping_add(R::Word::splat(NX as u32)));
        let (c, c1) = (c + x * dc, c1 + x * dc1);
        let (b, b1) = (b + x * db, b1 + x * db1);
        DirectionalAlbedo {
            c: R::select(self.rough, c + self.fraction * (c1 - c), smooth.c),
            b: R::select(self.rough, b + self.fraction * (b1 - b), smooth.b),
        }
    }

    /// Returns 2∫₀¹ E(μ) μ dμ of the interpolant; 1 and 1/21 for smooth surfaces.
    #[inline(always)]
    pub fn mean(self) -> DirectionalAlbedo<R> {
        let [c, b, dc, db] = R::gather_rows(&MEANS, self.row);
        DirectionalAlbedo {
            c: R::select(self.rough, c + self.fraction * dc, R::splat(1.0)),
            b: R::select(self.rough, b + self.fraction * db, R::splat(1.0 / 21.0)),
        }
    }
}

/// Returns the roughness of row j.
#[inline(always)]
fn roughness<R: Real>(j: R) -> R {
    let y = j * R::splat(1.0 / (NY - 1) as f32);
    R::splat(R0) + R::splat(1.0 - R0) * (y * y)
}

/// Returns the cosine of node i of a row.
#[inline(always)]
fn node<R: Real>(i: R) -> R {
    let x = i * R::splat(1.0 / (NX - 1) as f32);
    (x * x) * (x * x)
}
