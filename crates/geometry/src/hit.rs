//! The result of a ray query: ids, distance and surface coordinates. Surface data are computed later, on request.

/// The intersection of a ray with a triangle or a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in units of the length of its direction.
    pub t: f32,
    /// Triangle: barycentric coordinate of corner 1 (that of corner 0 is 1 − u − v). Sphere: octahedral coordinate of
    /// the outward normal in \[−1, 1\]. Disk: coordinate in units of the radius.
    pub u: f32,
    /// As `u`, for corner 2 or along the second axis.
    pub v: f32,
    /// Index of the triangle within the object's mesh; 0 for a shape.
    pub primitive: u32,
    /// Index of the object, in the order in which objects were added to the builder.
    pub object: u32,
}

impl Hit {
    /// Whether this hit takes precedence over `other`: it is nearer, or equally near with the lower object, then the
    /// lower primitive. This is a total order on finite distances, so the result depends neither on the acceleration
    /// structure nor on the order of traversal.
    pub fn wins_over(&self, other: &Hit) -> bool {
        self.t < other.t
            || (self.t == other.t && (self.object, self.primitive) < (other.object, other.primitive))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearer_then_lower_wins_and_never_both() {
        let hit = |t, object, primitive| Hit { t, u: 0.0, v: 0.0, primitive, object };
        let order = [hit(1.0, 3, 9), hit(2.0, 0, 7), hit(2.0, 1, 4), hit(2.0, 1, 5), hit(2.5, 0, 0)];
        for (i, a) in order.iter().enumerate() {
            for (j, b) in order.iter().enumerate() {
                assert_eq!(a.wins_over(b), i < j, "{a:?} {b:?}");
            }
        }
    }
}
