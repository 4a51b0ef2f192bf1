//! The instruction sets for which traversal has kernels, and the detection of those that this machine supports.

/// The instruction set used by traversal. All kernels give bit-identical results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// 8 lanes in one register.
    Avx2,
    /// 8 lanes in two registers; available on every x86-64.
    Sse2,
    /// Plain arrays; available on any machine.
    Portable,
}

impl Kernel {
    /// The kernels that this machine can run, fastest first; never empty.
    pub fn available() -> Vec<Self> {
        [Self::Avx2, Self::Sse2, Self::Portable].into_iter().filter(|&kernel| kernel.runs()).collect()
    }

    pub(super) fn fastest() -> Self {
        [Self::Avx2, Self::Sse2].into_iter().find(|&kernel| kernel.runs()).unwrap_or(Self::Portable)
    }

    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx2 => "avx2",
            Self::Sse2 => "sse2",
            Self::Portable => "portable",
        }
    }

    /// Whether this machine can run the kernel.
    pub(super) fn runs(self) -> bool {
        match self {
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
