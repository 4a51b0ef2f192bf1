//! Ray trees of unbounded depth: between mirrors, paths can have ten thousand bounces.
//!
//! Down to [`DEEP`] scattering events a tree is traced by recursion. A deeper vertex traces all of its rays but the
//! heaviest recursively, and returns the heaviest to a loop, which multiplies throughputs and adds up radiance. A chain
//! of rays therefore needs no stack, however long it is. A ray that is not the heaviest of its vertex carries at most
//! half of the throughput that arrived there, because no surface reflects more than it receives; after a hundred such
//! halvings the throughput is below [`FAINT`], which bounds the stack for any number of bounces.

use super::branch::{Branch, DEEP};
use super::tree::Tree;
use crate::bias_report::{FAINT, Truncation};
use crate::observer::PathObserver;
use crate::visibility::Visibility;
use glam::{DVec3, Vec3};

/// Maximum number of nested branches: more halvings than [`FAINT`] allows. Deeper branches, which only rounding or a
/// surface that creates energy can cause, are truncated and counted in the bias report.
const NESTED: u32 = 128;

impl<V: Visibility, O: PathObserver> Tree<'_, V, O> {
    /// Radiance of `new` times its factor. Of the rays of a deep vertex, the heaviest so far is held back and the other
    /// one is traced.
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

    /// Radiance along a ray, and along the heaviest rays that follow from it, to the end of the chain.
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
