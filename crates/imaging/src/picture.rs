//! Pictures in memory: linear Rec.709 RGB, row by row from the top left.
use glam::Vec3;
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Vec3>,
}
/// Named channels of one kind, e.g. name "normal", channels X, Y, Z; name "" is the beauty layer with R, G, B.
#[derive(Clone, Debug)]
pub struct Layer {
    pub name: String,
    pub channels: Vec<(String, Vec<f32>)>,
}
/// What an EXR holds. `offset`/`full_size`: data window of a crop within the full picture.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    pub width: usize,
    pub height: usize,
    pub offset: (i32, i32),
    pub full_size: (usize, usize),
    pub layers: Vec<Layer>,
    pub metadata: Vec<(String, MetaValue)>,
}
#[derive(Clone, Debug)]
pub enum MetaValue {
    Text(String),
    Int(i32),
    Float(f32),
    Matrix([f32; 16]),
}
