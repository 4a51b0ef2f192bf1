//! Lobes of a BSDF, and sets of them.

use dapple_math::lanes::Word;

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
    pub fn sharpened(self, which: Self) -> Self {
        Self(sharpened::<u32>(self.splat(), which) as u8)
    }

    /// This set for every lane.
    #[inline(always)]
    pub fn splat<W: Word>(self) -> W {
        W::splat(u32::from(self.0))
    }

    /// Whether the set contains `lobe`.
    pub const fn contains(self, lobe: Lobe) -> bool {
        self.0 & (1 << lobe as u8) != 0
    }

    /// The first lobe of the set in the order of [`Lobe`]; `None` if it is empty.
    pub fn first(self) -> Option<Lobe> {
        match self.0.trailing_zeros() {
            0 => Some(Lobe::Diffuse),
            1 => Some(Lobe::GlossyReflection),
            2 => Some(Lobe::GlossyTransmission),
            3 => Some(Lobe::DeltaReflection),
            4 => Some(Lobe::DeltaTransmission),
            5 => Some(Lobe::Mirror),
            _ => None,
        }
    }

    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Returns the lanes in which a set, given by its bits, has a lobe in common with `lobes`.
#[inline(always)]
pub fn meets<W: Word>(set: W, lobes: Lobes) -> W::Mask {
    (set & lobes.splat()).ne(W::splat(0))
}

/// Returns the sets with the rough lobes of `which` replaced by smooth ones.
#[inline(always)]
pub fn sharpened<W: Word>(set: W, which: Lobes) -> W {
    // The bit of a smooth lobe lies two places above that of the rough one; the mirror's two places below.
    const GLOSSY: Lobes = Lobes::of(Lobe::GlossyReflection).with(Lobe::GlossyTransmission);
    let glossy = set & which.and(GLOSSY).splat();
    let mirror = set & which.and(Lobes::of(Lobe::Mirror)).splat();
    (set & !(glossy | mirror)) | glossy << 2 | mirror >> 2
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
        let rough = both.with(Lobe::GlossyTransmission);
        let sharp = Lobes::of(Lobe::Diffuse).with(Lobe::DeltaReflection).with(Lobe::DeltaTransmission);
        assert_eq!(rough.sharpened(Lobes::ALL), sharp);
        assert_eq!(Lobes::of(Lobe::GlossyReflection).sharpened(Lobes::REFLECTION), Lobes(8));
        assert_eq!(rough.sharpened(Lobes::of(Lobe::Diffuse)), rough);
        for lobe in [Lobe::DeltaReflection, Lobe::DeltaTransmission] {
            assert!(lobe.is_delta() && Lobes::DELTA.contains(lobe));
            assert_eq!(lobe.is_transmission(), Lobes::TRANSMISSION.contains(lobe));
        }
    }
}
