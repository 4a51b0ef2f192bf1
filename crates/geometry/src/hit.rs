//! What does traversal return? Ids, distance and barycentrics; surface data come later, and only what is needed.

/// The place a ray met a triangle or a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Triangle: barycentric of corner 1 (corner 0 has 1 − u − v). Sphere: octahedral coordinate of the
    /// outward normal in \[−1, 1\]. Disk: coordinate in units of the radius.
    pub u: f32,
    /// As `u`, of corner 2 or along the second axis.
    pub v: f32,
    /// Triangle within the object's mesh; 0 for a shape.
    pub primitive: u32,
    /// Index of the object (in the order objects were added to the builder).
    pub object: u32,
}

impl Hit {
    /// Whether this hit wins over `other`: nearer, or as near with the lower object, then the lower primitive.
    /// A total order on finite distances, so the winner depends neither on the tree nor on the visiting order.
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
