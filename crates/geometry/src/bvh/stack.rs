//! The traversal stack.
#![allow(unsafe_code)]

use super::node::Child;
use std::mem::MaybeUninit;

/// Entries of a stack that fits any tree of reasonable depth.
pub(super) const SMALL_STACK: usize = 264;

/// Nodes still to visit, each with the bits of its entry distance (none where order does not matter).
///
/// Invariant: the first `len` slots are initialised; in a stack on which `push` or [`Lanes::any`](super::lanes::Lanes::any) was used, only those of
/// `child`, and `pop` and `insert` are not.
pub(super) struct Stack<'a> {
    near: &'a mut [MaybeUninit<u32>],
    child: &'a mut [MaybeUninit<u32>],
    len: usize,
}

impl<'a> Stack<'a> {
    /// An empty stack in `memory`, half of it for distances.
    #[inline(always)]
    pub fn new(memory: &'a mut [MaybeUninit<u32>]) -> Self {
        let half = memory.len() / 2;
        let (near, child) = memory.split_at_mut(half);
        Self { near, child: &mut child[..half], len: 0 }
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// The entry last pushed.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<(u32, Child)> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: slots below the old length are initialised, and both slices are longer.
        Some(unsafe {
            (
                self.near.get_unchecked(self.len).assume_init(),
                Child::from_bits(self.child.get_unchecked(self.len).assume_init()),
            )
        })
    }

    /// The child last pushed; there must be one.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub fn last(&self) -> Child {
        debug_assert!(self.len > 0);
        // SAFETY: as `pop_child`.
        Child::from_bits(unsafe { self.child[self.len - 1].assume_init() })
    }

    /// Puts a child on top, without a distance.
    #[inline(always)]
    pub fn push(&mut self, child: Child) {
        self.child[self.len] = MaybeUninit::new(child.bits());
        self.len += 1;
    }

    /// The child last pushed.
    #[inline(always)]
    pub fn pop_child(&mut self) -> Option<Child> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: slots of children below the old length are initialised, and the slice is longer.
        Some(Child::from_bits(unsafe { self.child.get_unchecked(self.len).assume_init() }))
    }

    /// Inserts an entry above `base`, below those with a smaller `near`.
    #[inline(always)]
    pub fn insert(&mut self, base: usize, near: u32, child: Child) {
        assert!(self.len < self.near.len() && self.len < self.child.len());
        let mut at = self.len;
        // SAFETY: slots below `len` are initialised.
        while at > base && unsafe { self.near[at - 1].assume_init() } < near {
            self.near[at] = self.near[at - 1];
            self.child[at] = self.child[at - 1];
            at -= 1;
        }
        self.near[at] = MaybeUninit::new(near);
        self.child[at] = MaybeUninit::new(child.bits());
        self.len += 1;
    }

    /// Where the next eight entries go. There must be room for them.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub fn top(&mut self) -> (*mut u32, *mut u32) {
        let end = self.len + 8;
        (self.near[self.len..end].as_mut_ptr().cast(), self.child[self.len..end].as_mut_ptr().cast())
    }

    /// Takes the first `n` of the entries at [`Self::top`].
    ///
    /// # Safety
    /// They were written, there or, where `pop` and `insert` are not used, the children alone.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub unsafe fn grow(&mut self, n: usize) {
        self.len += n;
    }
}
