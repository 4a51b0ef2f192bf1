//! The instruction sets for which traversal has kernels, and the detection of those that this machine supports.

use dapple_math::lanes::{Isa, MAX_LANES};

/// Packets are faster than single rays in trees of at most this many triangles per lane (benches/README.md).
const PER_LANE: usize = 16;

/// The instruction set used by traversal. All kernels give bit-identical results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// As `Avx2`; packets of rays have 16 lanes.
    Avx512,
    /// 8 lanes in one register.
    Avx2,
    /// 8 lanes in two registers; available on every x86-64.
    Sse2,
    /// Plain arrays; available on any machine.
    Portable,
}

impl Kernel {
    /// All kernels, fastest first.
    pub const ALL: [Self; 4] = [Self::Avx512, Self::Avx2, Self::Sse2, Self::Portable];

    /// The kernels that this machine can run, fastest first; never empty.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|&kernel| kernel.runs()).collect()
    }

    pub(super) fn fastest() -> Self {
        Self::ALL.into_iter().find(|&kernel| kernel.runs()).unwrap_or(Self::Portable)
    }

    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Sse2 => "sse2",
            Self::Portable => "portable",
        }
    }

    /// The largest number of triangles of a tree that is traversed by packets of any kernel.
    pub(super) const MOST_IN_PACKETS: usize = PER_LANE * MAX_LANES;

    /// The lanes of packets for a tree of so many triangles; None where rays are traced one by one.
    #[inline]
    pub(super) fn packets(self, triangles: usize) -> Option<Isa> {
        let isa = match self {
            Self::Avx512 => Isa::Avx512,
            Self::Avx2 => Isa::Avx2,
            Self::Sse2 | Self::Portable => return None,
        };
        (triangles <= PER_LANE * isa.lanes() && isa.runs()).then_some(isa)
    }

    /// Whether this machine can run the kernel.
    pub(super) fn runs(self) -> bool {
        match self {
            Self::Avx512 => Self::Avx2.runs() && Isa::Avx512.runs(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("popcnt")
            }
            Self::Sse2 => cfg!(target_arch = "x86_64"),
            Self::Portable => true,
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 => false,
        }
    }
}
