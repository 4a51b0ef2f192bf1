//! What is known of an object beside its surface.
use std::sync::Arc;

/// Names for reports and ids for AOVs; index = world object index.
#[derive(Clone, Debug)]
pub struct Object {
    /// The file's name for it, which many may share.
    pub name: Arc<str>,
    /// Index into the scene's materials.
    pub material: u32,
    /// First area light of this object's surface; `u32::MAX` = emits nothing.
    pub first_light: u32,
    /// Its material looks up textures.
    pub textured: bool,
    /// The body whose boundary it is, as an index into [`Bodies::all`](crate::Bodies::all); `u32::MAX` = none.
    pub body: u32,
}
