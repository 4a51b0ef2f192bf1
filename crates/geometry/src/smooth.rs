//! Smooth surfaces that the normals of the corners of a triangle stand for: interpolated normals, and the height of the
//! surface over the facet. In f64, for any number of lanes.

use crate::barycentric::weighted_sum;
use dapple_math::lanes::{Double, Real};
use dapple_math::offset::gamma;
use glam::Vec3;

/// A vector per lane.
pub(crate) type Vector<D> = [D; 3];

/// The triangle at a hit: corners, unit normals of the corners, and barycentric coordinates of the three.
#[derive(Clone, Copy)]
pub(crate) struct Rounded<D> {
    pub corners: [Vector<D>; 3],
    pub normals: [Vector<D>; 3],
    pub shares: [D; 3],
}

#[inline(always)]
fn dot<D: Double>(a: Vector<D>, b: Vector<D>) -> D {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn minus<D: Double>(a: Vector<D>, b: Vector<D>) -> Vector<D> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross<D: Double>(a: Vector<D>, b: Vector<D>) -> Vector<D> {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

impl<D: Double> Rounded<D> {
    /// The mean of three vectors.
    #[inline(always)]
    fn mean(&self, [a, b, c]: [Vector<D>; 3]) -> Vector<D> {
        [
            weighted_sum([a[0], b[0], c[0]], self.shares).0,
            weighted_sum([a[1], b[1], c[1]], self.shares).0,
            weighted_sum([a[2], b[2], c[2]], self.shares).0,
        ]
    }

    /// The interpolated unit normal on the side of the winding; not finite where the normals cancel.
    #[inline(always)]
    pub fn normal(&self) -> Vector<D> {
        let mean = self.mean(self.normals);
        let inverse = D::splat(1.0) / dot(mean, mean).sqrt();
        let n = [mean[0] * inverse, mean[1] * inverse, mean[2] * inverse];
        let [a, b, c] = self.corners;
        let winding = cross(minus(b, a), minus(c, a));
        let is_back = dot(n, winding).lt(D::splat(0.0));
        let side = D::select(is_back, D::splat(-1.0), D::splat(1.0));
        [n[0] * side, n[1] * side, n[2] * side]
    }

    /// Offset from the point of the facet to the smooth surface that the normals of its corners span above it: Σ bᵢ·max(0,
    /// (vᵢ − p)·nᵢ)·nᵢ [Hanika 2021]. It is zero where the normals span nothing above the facet, as on a flat or concave
    /// one, and where they are tilted together without diverging: Σ bᵢ(vᵢ − p)·nᵢ, which a common tilt does not change,
    /// must exceed the rounding of f32 normals; distances are sums over the axes. `up` is a normal of the facet on the
    /// side of interest.
    #[inline(always)]
    pub fn lift(&self, up: Vector<D>) -> Vector<D> {
        let (zero, one) = (D::splat(0.0), D::splat(1.0));
        let (p, mean) = (self.mean(self.corners), self.mean(self.normals));
        let side = D::select(dot(mean, up).lt(zero), D::splat(-1.0), one);
        let (mut lift, mut bulge, mut size) = ([zero; 3], zero, zero);
        for i in 0..3 {
            let [x, y, z] = self.normals[i];
            let (n, way) = ([x * side, y * side, z * side], minus(self.corners[i], p));
            let height = dot(way, n);
            let share = self.shares[i] * height.max(zero);
            lift = [lift[0] + n[0] * share, lift[1] + n[1] * share, lift[2] + n[2] * share];
            bulge = bulge + self.shares[i] * height;
            size = size + self.shares[i] * (way[0].abs() + way[1].abs() + way[2].abs());
        }
        let spans = (D::splat(f64::from(gamma(8))) * size).lt(bulge);
        [D::select(spans, lift[0], zero), D::select(spans, lift[1], zero), D::select(spans, lift[2], zero)]
    }
}

/// Converts numbers in f32 to a vector.
#[inline(always)]
pub(crate) fn vector<R: Real>([x, y, z]: [R; 3]) -> Vector<R::Double> {
    [R::Double::from_real(x), R::Double::from_real(y), R::Double::from_real(z)]
}

/// Whether a vector is of unit length, but for the rounding of f32.
pub(crate) fn is_unit(n: Vec3) -> bool {
    (n.length_squared() - 1.0).abs() <= gamma(16)
}
