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
