//! Names of the ways light leaves a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lobe {
    Diffuse,
    GlossyReflection,
    GlossyTransmission,
    DeltaReflection,
    DeltaTransmission,
    Mirror,
}
impl Lobe {
    pub fn is_delta(self) -> bool {
        matches!(self, Self::DeltaReflection | Self::DeltaTransmission)
    }
    pub fn is_transmission(self) -> bool {
        matches!(self, Self::GlossyTransmission | Self::DeltaTransmission)
    }
}
/// Which lobes take part: the distribution tracer gives each its own integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(pub u8);
impl Lobes {
    pub const ALL: Self = Self(0xff);
    pub fn contains(self, lobe: Lobe) -> bool {
        self.0 & (1 << lobe as u8) != 0
    }
}
