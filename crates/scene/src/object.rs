//! Per-object data other than geometry.
use std::sync::Arc;

/// Data of an object, by its index in the acceleration structure: names for reports, ids for AOVs.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name from the file, not necessarily unique.
    pub name: Arc<str>,
    /// Index into the scene's materials.
    pub material: u32,
    /// First area light on this object's surface; `u32::MAX` if it emits nothing.
    pub first_light: u32,
    /// Whether its material looks up textures.
    pub textured: bool,
    /// The body that it bounds, as an index into [`Bodies::all`](crate::Bodies::all); `u32::MAX` if none.
    pub body: u32,
}
