//! Trees of rays that are deeper than any stack: between mirrors, paths of ten thousand bounces.
//!
//! Down to [`DEEP`] scattering events a tree grows by recursion. A vertex below traces all of its rays but the heaviest in
//! the same way, one within the other, and hands the heaviest back to a loop, which multiplies throughputs and adds up. So
//! a chain takes no stack, however long it is. A ray that is not the heaviest of its vertex carries at most half of what
//! arrived there, for no surface sends out more than it gets; after a hundred such halvings nothing is left of it
//! ([`FAINT`]), and that bounds the stack by any number of bounces.

use super::branch::{Branch, DEEP};
use super::tree::Tree;
use crate::bias_report::{FAINT, Truncation};
use crate::observer::PathObserver;
use crate::visibility::Visibility;
use glam::{DVec3, Vec3};

/// Most branches within each other: more than [`FAINT`] leaves of halvings. What would exceed it, where rounding or a
/// surface makes light of nothing, is cut and told in the ledger.
const NESTED: u32 = 128;

impl<V: Visibility, O: PathObserver> Tree<'_, V, O> {
    /// What `new` brings, times its factor; of a deep vertex's rays, the heaviest so far is held and the other one traced.
    #[cold]
    #[inline(never)]
    pub(super) fn deeper(&mut self, new: Branch) -> Vec3 {
        if new.place.depth <= DEEP {
            return new.factor * self.branch(new);
        }
        let Some(held) = self.held.take() else {
            self.held = Some(new);
            return Vec3::ZERO;
        };
        let heavier = new.beta.element_sum() > held.beta.element_sum();
        let (heavy, light) = if heavier { (new, held) } else { (held, new) };
        let brought = light.factor * self.branch(light);
        self.held = Some(heavy);
        brought
    }

    /// Radiance along a ray, and along the heaviest of those that it leads to, to the end.
    fn branch(&mut self, first: Branch) -> Vec3 {
        if self.nested >= NESTED {
            if first.beta.max_element() >= FAINT {
                self.observer.cut(Truncation::Depth, first.beta);
            }
            return Vec3::ZERO;
        }
        self.nested += 1;
        let (mut sum, mut through, mut next) = (DVec3::ZERO, Vec3::ONE, first);
        loop {
            let radiance = self.li(&next.ray, &next.arrival, next.place, &next.stack, next.beta);
            sum += (through * radiance).as_dvec3();
            let Some(held) = self.held.take() else { break };
            through *= held.factor;
            next = held;
        }
        self.nested -= 1;
        sum.as_vec3()
    }
}
