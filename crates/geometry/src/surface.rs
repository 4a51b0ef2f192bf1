//! The place a ray hit: position with error bound, normals.
use glam::Vec3;
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub p: Vec3,
    /// Bound of |computed − exact| per axis.
    pub p_error: Vec3,
    /// Unit geometric normal of the front side (counter-clockwise winding; sphere: outward; disk: local +Z).
    pub ng: Vec3,
    /// Unit shading normal, in the hemisphere of `ng`; equals `ng` on flat geometry.
    pub ns: Vec3,
}
