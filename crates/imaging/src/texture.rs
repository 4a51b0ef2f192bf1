//! Texture lookup.
use crate::read::Rgba8;
use glam::{Vec2, Vec4};
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    Nearest,
    #[default]
    Linear,
}
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    pub wrap_s: Wrap,
    pub wrap_t: Wrap,
    pub interpolation: Interpolation,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Srgb,
    Linear,
}
#[derive(Clone, Debug)]
pub struct Texture {}
impl Texture {
    /// `Encoding::Srgb` decodes RGB (never alpha) on lookup, before filtering.
    pub fn new(_image: Rgba8, _encoding: Encoding, _sampler: Sampler) -> Self {
        todo!()
    }
    /// uv in glTF convention: (0,0) is the top-left corner of the first texel.
    pub fn lookup(&self, _uv: Vec2) -> Vec4 {
        todo!()
    }
    pub fn mean(&self) -> Vec4 {
        todo!()
    }
    pub fn memory_bytes(&self) -> usize {
        todo!()
    }
}
