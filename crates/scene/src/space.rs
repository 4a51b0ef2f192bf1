//! Render space: the scene recentred and scaled by a power of two, so that traversal works near unit scale whatever
//! the units of the file (docs/science.md, "Render space").
//!
//! render = (world − centre) · scale, in f64, rounded to f32 once at the end. `scale` is a power of two, so scaling
//! does not round; `centre` is a multiple of 1/scale, so that a scene moved by a multiple of 1/scale, or scaled by a
//! power of two, has a bit-identical render space.
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// A point in world space: the units of the file, or of the builder, in f64. Points in render space are plain vectors,
/// mostly [`Vec3`]; [`Space`] converts between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldPoint(pub DVec3);

/// Golden-ratio offset of the rounding boundary of the centre. Centres of real scenes are mostly round numbers; with a
/// boundary half way between grid points, the rounding errors of a far translation could change the result.
const ROUNDING: f64 = 0.618_033_988_749_895;

/// The map between the world (the file's units) and render space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    /// Render-space origin in world units.
    pub centre: DVec3,
    /// Render units per world unit, a power of two.
    pub scale: f64,
}

impl Space {
    /// The identity: render space equals world space.
    pub const IDENTITY: Self = Self { centre: DVec3::ZERO, scale: 1.0 };

    /// Space in which the box from `min` to `max` is around the origin and has a diagonal in [256, 512). The scale is 1
    /// for a box without extent. Both corners must be finite.
    pub fn fit(WorldPoint(min): WorldPoint, WorldPoint(max): WorldPoint) -> Self {
        let size = (max - min).max(DVec3::ZERO);
        let largest = size.max_element();
        let scale = if largest > 0.0 {
            libm::ldexp(1.0, 8 - floor_log2(largest * (size / largest).length()))
        } else {
            1.0
        };
        let middle = (min * 0.5 + max * 0.5) * scale;
        Self { centre: (middle + ROUNDING).floor() / scale, scale }
    }

    /// Transforms a world-space point to render space.
    pub fn to_render(&self, p: WorldPoint) -> Vec3 {
        self.to_render_f64(p).as_vec3()
    }

    /// Transforms a world-space point to render space without rounding to f32.
    pub fn to_render_f64(&self, WorldPoint(p): WorldPoint) -> DVec3 {
        (p - self.centre) * self.scale
    }

    /// Transforms a render-space point to world space.
    pub fn to_world(&self, p: Vec3) -> WorldPoint {
        self.to_world_f64(p.as_dvec3())
    }

    /// Transforms a render-space point in f64, such as a mean of points, to world space.
    pub fn to_world_f64(&self, p: DVec3) -> WorldPoint {
        WorldPoint(p / self.scale + self.centre)
    }

    /// Transform from world to render space.
    pub(crate) fn to_render_affine(self) -> DAffine3 {
        let scale = DMat3::from_diagonal(DVec3::splat(self.scale));
        DAffine3 { matrix3: scale, translation: -self.centre * self.scale }
    }

    /// Transform from render to world space.
    pub(crate) fn to_world_affine(self) -> DAffine3 {
        let scale = DMat3::from_diagonal(DVec3::splat(1.0 / self.scale));
        DAffine3 { matrix3: scale, translation: self.centre }
    }

    /// Converts a length in render units to world units.
    pub fn length_to_world(&self, length: f64) -> f64 {
        length / self.scale
    }

    /// Converts a world-space length to render units.
    pub fn length_to_render(&self, length: f64) -> f32 {
        (length * self.scale) as f32
    }

    /// Render-space image of the point `v` of an object placed by `placement`. The centre is subtracted from the
    /// translation before the vertex is added, so that a far translation loses no precision.
    pub(crate) fn place(&self, placement: &Placement, v: DVec3) -> DVec3 {
        let origin = (placement.translation - self.centre) + placement.residual;
        (origin + placement.linear * v) * self.scale
    }
}

/// ⌊log₂ x⌋ for finite x > 0. x is first rounded to 24 bits, so that rounding errors do not change the result for round
/// sizes. The result is clamped to ±900, so that the scale and its inverse are normal numbers.
fn floor_log2(x: f64) -> i32 {
    let (mantissa, exponent) = libm::frexp(x.min(f64::MAX));
    let rounded_up = mantissa >= 1.0 - 0.5 / (1 << 24) as f64;
    (if rounded_up { exponent } else { exponent - 1 }).clamp(-900, 900)
}

/// Placement of an object: world = linear · v + translation + residual, where `residual` is the rounding error of
/// `translation` from the composition of transforms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Rotation, scale and shear.
    pub linear: DMat3,
    /// World-space origin, rounded.
    pub translation: DVec3,
    /// Rounding error of `translation`.
    pub residual: DVec3,
}

impl Placement {
    /// The identity: object space equals world space.
    pub const IDENTITY: Self =
        Self { linear: DMat3::IDENTITY, translation: DVec3::ZERO, residual: DVec3::ZERO };

    /// Placement of a child with placement `local` in this object's space.
    pub fn child(&self, local: &Self) -> Self {
        let moved = self.linear * local.translation;
        let sum = self.translation + moved;
        // Knuth's exact sum: the rounding error of `sum`.
        let virtual_part = sum - self.translation;
        let dropped = (self.translation - (sum - virtual_part)) + (moved - virtual_part);
        Self {
            linear: self.linear * local.linear,
            translation: sum,
            residual: dropped + self.residual + self.linear * local.residual,
        }
    }

    /// World-space image of a point.
    pub fn point(&self, v: DVec3) -> DVec3 {
        self.translation + (self.residual + self.linear * v)
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.translation.is_finite() && self.residual.is_finite()
    }
}

impl From<Placement> for DAffine3 {
    fn from(p: Placement) -> Self {
        Self { matrix3: p.linear, translation: p.point(DVec3::ZERO) }
    }
}

impl From<DAffine3> for Placement {
    fn from(t: DAffine3) -> Self {
        Self { linear: t.matrix3, translation: t.translation, residual: DVec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_diagonal_lands_between_256_and_512() {
        for k in -40..40 {
            let side = 1.37 * libm::exp2(k as f64 * 0.91);
            let space = Space::fit(WorldPoint(DVec3::splat(-side)), WorldPoint(DVec3::splat(side)));
            let diagonal = (space.to_render(WorldPoint(DVec3::splat(side)))
                - space.to_render(WorldPoint(DVec3::splat(-side))))
            .length();
            assert!((256.0..512.0).contains(&diagonal), "{side}: {diagonal}");
            assert_eq!(libm::frexp(space.scale).0, 0.5, "power of two");
        }
    }

    #[test]
    fn round_sizes_do_not_flip() {
        let a = Space::fit(WorldPoint(DVec3::ZERO), WorldPoint(DVec3::new(0.6, 0.8, 0.0)));
        let b = Space::fit(
            WorldPoint(DVec3::splat(1e5)),
            WorldPoint(DVec3::splat(1e5) + DVec3::new(0.6, 0.8, 0.0)),
        );
        assert_eq!(a.scale, 256.0);
        assert_eq!(b.scale, 256.0);
    }

    #[test]
    fn a_point_keeps_unit_scale() {
        let space = Space::fit(WorldPoint(DVec3::splat(3.0)), WorldPoint(DVec3::splat(3.0)));
        assert_eq!(space.scale, 1.0);
        assert_eq!(space.to_render(WorldPoint(DVec3::splat(3.0))), Vec3::ZERO);
    }

    #[test]
    fn extremes_stay_finite() {
        for size in [5e-324, 1e-300, 1e-45, 1e38, 1e300] {
            let space = Space::fit(WorldPoint(DVec3::splat(-size)), WorldPoint(DVec3::splat(size)));
            assert!(space.scale.is_finite() && space.scale > 0.0 && space.centre.is_finite());
            assert!(space.to_render(WorldPoint(DVec3::splat(size))).is_finite());
        }
    }

    #[test]
    fn far_translations_leave_no_trace() {
        let corner = DVec3::new(0.3, -1.7, 0.9);
        let local = Placement::from(DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.3)));
        let render = |t: f64| {
            let root = Placement::from(DAffine3::from_translation(DVec3::splat(t)));
            let placement = root.child(&local);
            let ends = [placement.point(-corner), placement.point(corner)];
            let space = Space::fit(WorldPoint(ends[0].min(ends[1])), WorldPoint(ends[0].max(ends[1])));
            (0..1000)
                .map(|i| space.place(&placement, corner * (i as f64 / 999.0)).as_vec3().to_array())
                .collect::<Vec<_>>()
        };
        for t in [1e3, 1e4, 1e5, 1e6, 1e7] {
            assert_eq!(render(0.0), render(t), "{t}");
        }
    }

    #[test]
    fn scaling_by_a_power_of_two_leaves_no_trace() {
        let (min, max) = (DVec3::new(-0.3, 0.1, 2.0), DVec3::new(1.9, 0.7, 2.2));
        let p = DVec3::new(0.123, 0.456, 2.1);
        let a = Space::fit(WorldPoint(min), WorldPoint(max)).to_render(WorldPoint(p));
        for k in [-40, -3, 1, 17] {
            let s = libm::ldexp(1.0, k);
            assert_eq!(a, Space::fit(WorldPoint(min * s), WorldPoint(max * s)).to_render(WorldPoint(p * s)));
        }
    }

    #[test]
    fn there_and_back() {
        let space =
            Space::fit(WorldPoint(DVec3::new(10.0, 20.0, 30.0)), WorldPoint(DVec3::new(11.0, 21.5, 30.2)));
        let p = DVec3::new(10.25, 20.5, 30.125);
        assert_eq!(space.to_world(space.to_render(WorldPoint(p))), WorldPoint(p));
    }
}
