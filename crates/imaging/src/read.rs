//! Files to pictures.
use crate::{ImageError, Layers, Picture};
use std::path::Path;
/// .exr (first RGB layer), .hdr, .png/.jpg/.webp (sRGB decoded to linear).
pub fn picture(_path: &Path) -> Result<Picture, ImageError> {
    todo!()
}
/// All layers of an EXR.
pub fn layers(_path: &Path) -> Result<Layers, ImageError> {
    todo!()
}
/// Encoded bytes (png, jpeg, webp by content) to RGBA8; `name` is for the error message.
pub fn rgba8(_bytes: &[u8], _name: &str) -> Result<Rgba8, ImageError> {
    todo!()
}
#[derive(Clone, Debug)]
pub struct Rgba8 {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<[u8; 4]>,
}
