//! The implementation of [`Double`](super::Double) by two registers.

/// Implements `Double` by the type's own methods of the same names.
macro_rules! double {
    ($double:ident, $real:ident, $mask:ident) => {
        impl Double for $double {
            type Real = $real;
            type Mask = $mask;

            #[inline(always)]
            fn splat(x: f64) -> Self {
                Self::splat(x)
            }
            #[inline(always)]
            fn from_real(x: $real) -> Self {
                Self::from_real(x.0)
            }
            #[inline(always)]
            fn to_real(self) -> $real {
                $real(self.to_real())
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.max(other)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                $mask(self.lt(other))
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                Self::select(mask.0, yes, no)
            }
        }
    };
}

pub(super) use double;
