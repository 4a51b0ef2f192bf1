//! Lobes of a BSDF, and sets of them.

/// A lobe of a BSDF. Delta lobes have a direction but no density.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Lobe {
    /// Diffuse reflection by the base.
    Diffuse,
    /// Reflection at a rough surface.
    GlossyReflection,
    /// Transmission through a rough surface.
    GlossyTransmission,
    /// Reflection at a smooth surface, and the perfect [`crate::Mirror`].
    DeltaReflection,
    /// Transmission through a smooth surface, or through one that does not refract.
    DeltaTransmission,
    /// The square blur of [`crate::Mirror`].
    Mirror,
}

impl Lobe {
    /// Whether the lobe has no density: next-event estimation cannot sample it, and its pdf has no MIS weight.
    pub fn is_delta(self) -> bool {
        matches!(self, Self::DeltaReflection | Self::DeltaTransmission)
    }

    /// Whether the light continues on the other side of the surface.
    pub fn is_transmission(self) -> bool {
        matches!(self, Self::GlossyTransmission | Self::DeltaTransmission)
    }
}

/// A set of lobes. The distribution ray tracer estimates each lobe by its own integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobes(pub u8);

impl Lobes {
    /// All lobes.
    pub const ALL: Self = Self(0xff);
    /// The empty set.
    pub const NONE: Self = Self(0);
    /// The lobes without a density.
    pub const DELTA: Self = Self::of(Lobe::DeltaReflection).with(Lobe::DeltaTransmission);
    /// All reflection lobes but the diffuse one.
    pub const REFLECTION: Self =
        Self::of(Lobe::GlossyReflection).with(Lobe::DeltaReflection).with(Lobe::Mirror);
    /// All transmission lobes.
    pub const TRANSMISSION: Self = Self::of(Lobe::GlossyTransmission).with(Lobe::DeltaTransmission);

    /// The set that contains one lobe.
    pub const fn of(lobe: Lobe) -> Self {
        Self(1 << lobe as u8)
    }

    /// This set with one lobe added.
    pub const fn with(self, lobe: Lobe) -> Self {
        Self(self.0 | 1 << lobe as u8)
    }

    /// The intersection of both sets.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The lobes of this set that are not in the other one.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether the sets have a lobe in common.
    pub const fn meets(self, other: Self) -> bool {
        !self.and(other).is_empty()
    }

    /// Whether some lobe scatters light into more than one direction.
    pub const fn spreads(self) -> bool {
        !self.without(Self::DELTA).is_empty()
    }

    /// This set with the rough lobes of `which` replaced by smooth ones.
    pub const fn sharpened(self, which: Self) -> Self {
        let rough = self.and(which);
        let mut set = self;
        if rough.contains(Lobe::GlossyReflection) {
            set = set.without(Self::of(Lobe::GlossyReflection)).with(Lobe::DeltaReflection);
        }
        if rough.contains(Lobe::Mirror) {
            set = set.without(Self::of(Lobe::Mirror)).with(Lobe::DeltaReflection);
        }
        if rough.contains(Lobe::GlossyTransmission) {
            set = set.without(Self::of(Lobe::GlossyTransmission)).with(Lobe::DeltaTransmission);
        }
        set
    }

    /// Whether the set contains `lobe`.
    pub const fn contains(self, lobe: Lobe) -> bool {
        self.0 & (1 << lobe as u8) != 0
    }

    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets() {
        let both = Lobes::of(Lobe::Diffuse).with(Lobe::Mirror);
        assert!(both.contains(Lobe::Mirror) && !both.contains(Lobe::DeltaReflection));
        assert_eq!(both.and(Lobes::REFLECTION), Lobes::of(Lobe::Mirror));
        assert!(both.without(Lobes::ALL).is_empty());
        for lobe in [Lobe::DeltaReflection, Lobe::DeltaTransmission] {
            assert!(lobe.is_delta() && Lobes::DELTA.contains(lobe));
            assert_eq!(lobe.is_transmission(), Lobes::TRANSMISSION.contains(lobe));
        }
    }
}
