//! The traversal stack.
#![allow(unsafe_code)]

use super::node::Child;
use std::mem::MaybeUninit;

/// Number of entries of a stack that suffices for any tree of reasonable depth.
pub(super) const SMALL_STACK: usize = 264;

/// Nodes still to be visited, each with the bits of its entry distance (absent where the order does not matter).
///
/// Invariant: the first `len` slots are initialised. On a stack on which `push` or
/// [`Lanes::first`](super::lanes::Lanes::first) was used, only those of `child` are initialised, and `pop` and `insert`
/// must not be used.
pub(super) struct Stack<'a> {
    near: &'a mut [MaybeUninit<u32>],
    child: &'a mut [MaybeUninit<u32>],
    len: usize,
}

impl<'a> Stack<'a> {
    /// An empty stack in `memory`, half of which is used for distances.
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

    /// Removes and returns the last entry.
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

    /// The last child; the stack must not be empty.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub fn last(&self) -> Child {
        debug_assert!(self.len > 0);
        // SAFETY: as in `pop_child`.
        Child::from_bits(unsafe { self.child[self.len - 1].assume_init() })
    }

    /// Adds a child without a distance.
    #[inline(always)]
    pub fn push(&mut self, child: Child) {
        self.child[self.len] = MaybeUninit::new(child.bits());
        self.len += 1;
    }

    /// Removes and returns the last child.
    #[inline(always)]
    pub fn pop_child(&mut self) -> Option<Child> {
        if self.len == 0 {
            return None;
        }
        self.len -= 1;
        // SAFETY: slots of children below the old length are initialised, and the slice is longer.
        Some(Child::from_bits(unsafe { self.child.get_unchecked(self.len).assume_init() }))
    }

    /// Inserts an entry above `base`, below the entries with a smaller `near`.
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

    /// Pointers to the slots of the next eight entries, for which there must be room.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub fn top(&mut self) -> (*mut u32, *mut u32) {
        let end = self.len + 8;
        (self.near[self.len..end].as_mut_ptr().cast(), self.child[self.len..end].as_mut_ptr().cast())
    }

    /// Adds the first `n` of the entries at [`Self::top`] to the stack.
    ///
    /// # Safety
    /// The caller must have written these entries: distances and children, or only the children on a stack on which
    /// `pop` and `insert` are not used.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub unsafe fn grow(&mut self, n: usize) {
        self.len += n;
    }
}
