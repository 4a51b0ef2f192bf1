//! What traversal returns: ids, distance, barycentrics. Surface data come later, only what is needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f32,
    /// Barycentric of corner 1 and corner 2 (corner 0 has 1 − u − v). For a shape: 0, 0.
    pub u: f32,
    pub v: f32,
    /// Triangle within the object's mesh.
    pub primitive: u32,
    /// Index of the object (in the order objects were added to the builder).
    pub object: u32,
}
