//! Keys of random numbers, one per lane.

use super::hash::mix;
use dapple_math::lanes::Word;

/// Identifies one stream of sample points per lane, by 64 hashed bits in two words. Equal keys give equal points on every
/// machine. [`Key`](crate::Key) is a single one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Keyx<W> {
    words: [W; 2],
}

/// Numbers of decisions are smaller, so that a branch is never the key of a decision.
const BRANCH: u32 = 0xb5ad_4ece;

/// The state of a key before the first name, which is not a fixed point of the hash.
const START: [u32; 2] = [0x9e37_79b9, 0x7f4a_7c15];

impl<W: Word> Keyx<W> {
    /// Returns the key of one pixel of a render with the given seed.
    #[inline(always)]
    pub fn pixel(seed: u64, x: W, y: W) -> Self {
        let [a, b] = mix([START[0] ^ seed as u32, START[1] ^ (seed >> 32) as u32]);
        Self { words: [W::splat(a), W::splat(b)] }.with(x, y)
    }

    /// Returns the key of the `n`-th branch where a path is split.
    #[inline(always)]
    pub fn branch(self, n: W) -> Self {
        self.with(n, W::splat(BRANCH))
    }

    /// Returns the key of one random decision at `depth`. `decision` is its number in the caller's table of decisions
    /// and is below 2³¹. The keys of different decisions, or of one decision at different depths, are different.
    #[inline(always)]
    pub fn at(self, depth: W, decision: impl Into<u32>) -> Self {
        self.with(depth, W::splat(decision.into()))
    }

    /// Returns the key of two words under this key: a bijection of the words for any key.
    #[inline(always)]
    pub fn with(self, first: W, second: W) -> Self {
        let [a, b] = self.words;
        Self { words: mix([a ^ first, b ^ second]) }
    }

    /// Returns the key of no words, from which a sequence of words is hashed by [`Keyx::with`].
    #[inline(always)]
    pub fn start() -> Self {
        Self { words: START.map(W::splat) }
    }

    /// Returns one random number in [0, 1), a multiple of 2⁻²⁴.
    #[inline(always)]
    pub fn unit(self) -> W::Real {
        self.words[1].unit()
    }

    /// Returns the key as two words of hashed bits, the lower one first.
    #[inline(always)]
    pub fn words(self) -> [W; 2] {
        self.words
    }

    /// Returns the key with the given words, as [`Keyx::words`] returned them.
    #[inline(always)]
    pub fn from_words(words: [W; 2]) -> Self {
        Self { words }
    }
}
