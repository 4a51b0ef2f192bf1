//! The instruction sets for which there are lanes, and the detection of those that this machine supports.

/// An instruction set and its number of lanes. All give bit-identical results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Isa {
    /// 16 lanes in one register.
    Avx512,
    /// 8 lanes in one register.
    Avx2,
    /// One lane, an `f32`; available on any machine.
    Portable,
}

impl Isa {
    /// All instruction sets, fastest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// Returns the instruction sets that this machine supports, fastest first; never empty.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|isa| isa.runs()).collect()
    }

    /// Returns the fastest instruction set that this machine supports. The machine is asked once per process. Whoever
    /// wants another one passes that to [`dispatch`](super::dispatch()).
    pub fn fastest() -> Self {
        Self::ALL.into_iter().find(|isa| isa.runs()).unwrap_or(Self::Portable)
    }

    /// Returns the name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        }
    }

    /// Returns the number of lanes.
    pub fn lanes(self) -> usize {
        match self {
            Self::Avx512 => 16,
            Self::Avx2 => 8,
            Self::Portable => 1,
        }
    }

    /// Whether this machine supports the instruction set, and the crate was compiled for it: with
    /// `--cfg dapple_portable`, and on other machines than x86-64, only [`Isa::Portable`] runs.
    #[inline]
    pub fn runs(self) -> bool {
        match self {
            #[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
            Self::Avx512 => Self::Avx2.runs() && has_avx512(),
            #[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
            Self::Avx2 => has_avx2(),
            #[cfg(not(all(target_arch = "x86_64", not(dapple_portable))))]
            Self::Avx512 | Self::Avx2 => false,
            Self::Portable => true,
        }
    }
}

#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
#[inline]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(all(target_arch = "x86_64", not(dapple_portable)))]
#[inline]
fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512cd")
}
