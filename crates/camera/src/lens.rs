//! Thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    Disk,
    Square,
    Blades { n: u32, rotation: f32 },
}
/// `radius` (half side for the square) and focus distance along the view axis, render units; infinite focus allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    pub aperture: Aperture,
    pub radius: f32,
    pub focus_distance: f32,
}
