//! Transforms with their inverses, for mapping points and normals to render space and rays to object space. Mirrored,
//! non-uniform and singular transforms are supported.
//!
//! A transform that flattens an object (one scale is 0) has no inverse. It is given a thickness of 2⁻⁶⁰ of its size
//! instead (*approximation*, without visible effect: far below the rounding of any f32 coordinate). The flattened
//! object then stays visible, its triangles are found in the same acceleration structure, and its normals are correct.
use crate::Aabb;
use crate::vector::unit_or;
use glam::{DAffine3, DMat3, DVec3};

/// The transform from object space to render space at one instant, with its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// From object space to render space.
    pub to_world: DAffine3,
    /// From render space to object space.
    pub to_object: DAffine3,
}

/// Thickness of a flattened object relative to its size: enough to divide by, and its inverse square fits in an f32.
const THIN: f64 = 1.0 / (1u64 << 60) as f64;

/// Returns `scale` with a zero component replaced by a tiny one, or None when fewer than two components are not zero.
pub(super) fn thickened(scale: DVec3) -> Option<DVec3> {
    let zeros = scale.to_array().iter().filter(|&&s| s == 0.0).count();
    let thin = scale.abs().max_element() * THIN;
    let thick = scale.map(|s| if s.abs() < thin { thin.copysign(s) } else { s });
    (zeros < 2 && thin > 0.0 && thick.is_finite()).then_some(thick)
}

impl Pose {
    /// The identity transform.
    pub const IDENTITY: Self = Self { to_world: DAffine3::IDENTITY, to_object: DAffine3::IDENTITY };

    /// Creates the pose of an affine transform. It is None when the transform maps everything to a line or a point, or
    /// is not finite.
    pub fn of(m: &DAffine3) -> Option<Self> {
        if !m.is_finite() {
            return None;
        }
        let inverse = inverse(&m.matrix3)?;
        Some(Self {
            to_world: *m,
            to_object: DAffine3 { matrix3: inverse, translation: -(inverse * m.translation) },
        })
    }

    /// Returns the composition that applies `inner` first and `self` second.
    pub fn then_inner(&self, inner: &Self) -> Self {
        Self { to_world: self.to_world * inner.to_world, to_object: inner.to_object * self.to_object }
    }

    /// Returns whether no component is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        self.to_world.is_finite() && self.to_object.is_finite()
    }

    /// Returns whether the transform reverses orientation (its determinant is negative).
    pub fn is_mirrored(&self) -> bool {
        self.to_world.matrix3.determinant() < 0.0
    }

    /// Returns the map of normals to render space.
    pub fn normals(&self) -> NormalMap {
        let cofactor = cofactor(&self.to_world.matrix3);
        NormalMap { cofactor, plane: longest(&cofactor), mirrored: self.is_mirrored() }
    }

    /// Returns the bound per axis of the render-space error caused by the object-space error `e`.
    pub fn error(&self, e: DVec3) -> DVec3 {
        absolute(&self.to_world.matrix3) * e
    }

    /// Returns the bounding box of the transformed box.
    pub fn bounds(&self, b: Aabb) -> Aabb {
        transformed(&self.to_world, b)
    }
}

/// The map of normals to render space: the cofactor matrix \[a₂×a₃, a₃×a₁, a₁×a₂\], which needs no inverse, with the
/// sign of the determinant, so that the front side of a surface stays its front side.
#[derive(Clone, Copy, Debug)]
pub struct NormalMap {
    cofactor: DMat3,
    /// Normal of the plane that a singular transform flattens everything to.
    plane: DVec3,
    mirrored: bool,
}

impl NormalMap {
    /// Returns the unit normal of the transformed surface. A face that a singular transform flattens to a line gets the
    /// normal of the plane that everything is flattened to. The zero vector is mapped to itself.
    pub fn apply(&self, n: DVec3) -> DVec3 {
        let turned = self.cofactor * n;
        // Smaller lengths are rounding errors.
        let edge_on = turned.length() <= 1e-15 * self.plane.length() * n.length() && n != DVec3::ZERO;
        let n = unit_or(if edge_on { self.plane } else { turned }, DVec3::ZERO);
        if self.mirrored { -n } else { n }
    }
}

/// Returns the bounding box of the transformed box `b`: its centre is transformed by m, its half extents by |m|.
pub(super) fn transformed(m: &DAffine3, b: Aabb) -> Aabb {
    let (centre, half) = ((b.lo + b.hi) * 0.5, (b.hi - b.lo) * 0.5);
    let (centre, half) = (m.transform_point3(centre), absolute(&m.matrix3) * half);
    Aabb::new(centre - half, centre + half)
}

fn absolute(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

fn cofactor(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

/// Returns the inverse of `m`. If `m` has rank 2 in the precision of f64, it is the inverse of `m` with a thickness of
/// 2⁻⁶⁰. It is None if the rank is lower.
///
/// With w the unit vector perpendicular to the image of a rank-2 `m` and v the one that spans its null space,
/// N = m + σ·w vᵀ is well conditioned, and N⁻¹ + (1/ε − 1/σ)·v wᵀ is the inverse of m + ε·w vᵀ.
fn inverse(m: &DMat3) -> Option<DMat3> {
    let lengths = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    let thin = lengths.max_element() * THIN;
    let thick = lengths.map(|l| if l > 0.0 && l < thin { thin / l } else { 1.0 });
    let (m, lengths) = (&(*m * DMat3::from_diagonal(thick)), lengths * thick);
    let (c, det) = (cofactor(m), m.determinant());
    // Hadamard's ratio |det| / Π lengths is 1 for perpendicular columns of any length and 0 for dependent ones.
    if det.abs() > 1e-12 * lengths.element_product() {
        return Some(c.transpose() * (1.0 / det)).filter(DMat3::is_finite);
    }
    let size = lengths.max_element();
    let w = longest(&c);
    let v = longest(&c.transpose());
    if w.length() <= 1e-14 * size * size {
        return None;
    }
    let (w, v) = (w.normalize(), v.normalize());
    let outer = DMat3::from_cols(w * v.x, w * v.y, w * v.z);
    let n = *m + outer * size;
    let back = DMat3::from_cols(v * w.x, v * w.y, v * w.z);
    let inverse =
        cofactor(&n).transpose() * (1.0 / n.determinant()) + back * (1.0 / (size * THIN) - 1.0 / size);
    inverse.is_finite().then_some(inverse)
}

fn longest(m: &DMat3) -> DVec3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let first = if x.length_squared() >= y.length_squared() { x } else { y };
    if first.length_squared() >= z.length_squared() { first } else { z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn inverses_of_uneven_mirrored_and_flat_transforms() {
        let r = DMat3::from_quat(DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize());
        let flat = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
        for s in [flat(1.0, 2.0, 3.0), flat(-1.0, 1.0, 1.0), flat(1.0, 1e6, 1e-6), flat(1.0, 1.0, 1e-17)] {
            let m = r * s;
            let back = inverse(&m).unwrap();
            let off = (back * m - DMat3::IDENTITY).to_cols_array().iter().fold(0.0f64, |a, x| a.max(x.abs()));
            // Rounding of the rotated columns, amplified along the thinnest axis.
            let condition = s.to_cols_array().iter().fold(0.0f64, |a, x| a.max(x.abs()))
                / [s.x_axis.x, s.y_axis.y, s.z_axis.z].iter().fold(f64::MAX, |a, x| a.min(x.abs()));
            assert!(off < 1e-15 * condition.max(10.0), "{s:?} {off}");
        }
        assert!(inverse(&flat(1.0, 1.0, 1e-40)).unwrap().z_axis.z < 2e18);
        // Flat: points of the plane are mapped back to themselves, except for the lost coordinate.
        for m in
            [r * flat(1.0, 2.0, 0.0), flat(1.0, 2.0, 0.0) * r, flat(1.0, 0.0, 1.0) * r * flat(3.0, 2.0, 1.0)]
        {
            let back = inverse(&m).unwrap();
            let p = m * DVec3::new(0.3, -0.7, 0.9);
            assert!((m * (back * p) - p).length() < 1e-14);
        }
        for m in [DMat3::ZERO, flat(1.0, 0.0, 0.0), r * flat(0.0, 0.0, 1.0) * r] {
            assert_eq!(inverse(&m), None, "{m:?}");
        }
        assert_eq!(thickened(DVec3::new(1.0, 0.0, 0.0)), None);
        assert_eq!(thickened(DVec3::ZERO), None);
        assert!(thickened(DVec3::new(1.0, -2.0, 0.0)).unwrap().z > 0.0);
    }

    #[test]
    fn normals_stay_perpendicular_and_in_front() {
        let pose = Pose::of(&DAffine3::from_scale(DVec3::new(-2.0, 1.0, 0.5))).unwrap();
        let n = pose.normals().apply(DVec3::new(1.0, 1.0, 0.0).normalize());
        let along = pose.to_world.transform_vector3(DVec3::new(1.0, -1.0, 0.0));
        assert!(n.dot(along).abs() < 1e-15);
        // The outward normal of a convex body stays outward under a reflection.
        assert!(n.x < 0.0 && n.y > 0.0);
    }
}
