//! From linear radiance to display values.
use glam::Vec3;
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    #[default]
    Srgb,
    Agx,
    Aces,
    Neutral,
}
impl Tone {
    /// Display-referred sRGB-encoded value in [0,1].
    pub fn apply(self, _linear: Vec3) -> Vec3 {
        todo!()
    }
}
// plus FromStr and Display
