//! Samples of the shapes of area lights, over lanes.
use crate::LightPoint;
use crate::aimed;
use dapple_math::lanes::{Real, Vec3x};
use glam::Vec3;

/// One sampled point of an area light per lane, independent of its emission.
#[derive(Clone, Copy, Debug)]
pub struct Aimed<R> {
    /// Unit direction from the receiver to the point.
    pub wi: Vec3x<R>,
    /// Distance to the point, in render units.
    pub distance: R,
    /// Density per solid angle at the receiver; 0 where there is no sample, and the other values are then arbitrary.
    pub pdf: R,
    /// The point.
    pub p: Vec3x<R>,
    /// Bound of the error of `p`, per axis.
    pub p_error: Vec3x<R>,
    /// Unit normal of the front at the point.
    pub n: Vec3x<R>,
    /// Coordinate along the first edge of a flat shape, in \[0, 1\].
    pub s: R,
    /// Coordinate along the second edge.
    pub t: R,
}

impl<R: Real> Aimed<R> {
    /// Sets the density to 0 where it is not positive and finite.
    #[inline(always)]
    pub(super) fn only_finite(self) -> Self {
        let usable = self.pdf.gt(R::splat(0.0)) & self.pdf.is_finite();
        Self { pdf: R::select(usable, self.pdf, R::splat(0.0)), ..self }
    }

    /// Triangle (0 or 1, as a number) and barycentric coordinates of its corners 1 and 2, as [`LightPoint`] has them,
    /// for a point of a parallelogram.
    #[inline(always)]
    pub fn quad_barycentrics(&self) -> [R; 3] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let first = self.t.le(self.s);
        let (low, high) = (R::select(first, self.t, self.s), R::select(first, self.s, self.t));
        let beside = high - low;
        [R::select(first, zero, one), R::select(first, beside, low), R::select(first, low, beside)]
    }
}

impl Aimed<f32> {
    pub(crate) fn triangle(&self) -> Option<aimed::Aimed> {
        self.at([0.0, self.s, self.t])
    }

    pub(crate) fn quad(&self) -> Option<aimed::Aimed> {
        self.at(self.quad_barycentrics())
    }

    /// For shapes without barycentric coordinates.
    pub(crate) fn round(&self) -> Option<aimed::Aimed> {
        self.at([0.0; 3])
    }

    /// The sample with the given triangle and barycentric coordinates; None where there is none.
    #[inline(always)]
    fn at(&self, [triangle, u, v]: [f32; 3]) -> Option<aimed::Aimed> {
        let (p, p_error, n) = (self.p.into(), self.p_error.into(), Vec3::from(self.n));
        let point = LightPoint { p, p_error, n, triangle: triangle as u32, u, v };
        let wi = self.wi.into();
        (self.pdf > 0.0).then_some(aimed::Aimed { wi, distance: self.distance, pdf: self.pdf, point })
    }
}
