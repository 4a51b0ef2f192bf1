//! Shading frames of normal maps.

use dapple_math::lanes::{Framex, Real, Vec3x};

/// A normal map at a hit, per lane.
#[derive(Clone, Copy, Debug)]
pub struct MappedNormal<R: Real> {
    /// Tangent of the surface, of any length.
    pub tangent: Vec3x<R>,
    /// Negative where the bitangent is mirrored.
    pub sign: R,
    /// Unit normal in tangent space, in the lanes of `is_sound`.
    pub normal: Vec3x<R>,
    /// The lanes whose normal in tangent space is not degenerate.
    pub is_sound: R::Mask,
}

impl<R: Real> MappedNormal<R> {
    /// Frames about the mapped normals of surfaces with interpolated normals `ns` and geometric normals `ng`. The mapped
    /// normal is x·T + y·B + z·N with T the tangent made orthogonal to N and B = w·(N × T), as in the glTF
    /// specification. A mapped normal that points below the surface is reflected to the upper side (z·ng > 0 always); a
    /// degenerate one is replaced by the interpolated normal.
    #[inline(always)]
    pub fn frame(&self, ns: Vec3x<R>, ng: Vec3x<R>) -> Framex<R> {
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let base = Framex::from_z_tangent(ns, self.tangent, self.sign);
        let n = base.to_world(self.normal);
        let height = n.dot(ng);
        let n = Vec3x::select(height.lt(zero), n - ng * (two * height), n);
        let inverse = one / n.length();
        let n = n * inverse;
        let is_upper = inverse.is_finite() & inverse.gt(zero) & n.dot(ng).gt(zero);
        let mapped = Framex::from_z_tangent(n, self.tangent, self.sign);
        Framex::select(self.is_sound & is_upper, mapped, base)
    }
}
