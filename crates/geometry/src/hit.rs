//! What traversal returns: ids, distance, barycentrics. Surface data come later, only what is needed.

/// The place a ray hit, as numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric of corner 1 (corner 0 has 1 − u − v); 0 on a shape.
    pub u: f32,
    /// Barycentric of corner 2; 0 on a shape.
    pub v: f32,
    /// Triangle within the object's mesh; 0 on a shape.
    pub primitive: u32,
    /// Index of the object, in the order objects were added to the builder.
    pub object: u32,
}
