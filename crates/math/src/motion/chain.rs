//! Shared chains of node transforms from the root of the scene to an object. All objects below a node share its chain
//! and the motions computed for it, so that a file of n nodes takes memory and time for n links, however deep its
//! hierarchy is.
use super::links::Motion;
use super::node::{Channel, Link, Node, Trs};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::{Arc, OnceLock};

/// Relative difference up to which the scales along different axes count as equal.
const EVEN: f64 = 1e-6;
/// A motion with more links than this is not cached for the nodes below, because each of them would copy it.
const SHORT: usize = 16;

/// The nodes from the root to an object.
#[derive(Clone, Debug, Default)]
pub struct Chain(Option<Arc<Joint>>);

#[derive(Debug)]
struct Joint {
    above: Chain,
    link: Link,
    /// Whether the transforms from the root to this node keep spheres spherical.
    round: bool,
    /// Cached motions of this node, one to world space and one to one other space.
    folded: [OnceLock<Folded>; 2],
}

/// A cached motion with the space and time offset that it was computed for.
#[derive(Debug)]
struct Folded {
    space: DAffine3,
    offset: f64,
    motion: Arc<Motion>,
}

impl Chain {
    /// Returns the chain with one more node at its end.
    #[must_use]
    pub fn then(&self, node: Node) -> Self {
        let round = self.stays_round() && is_even(&node);
        let link = Link::of(node);
        Self(Some(Arc::new(Joint {
            above: self.clone(),
            link,
            round,
            folded: [const { OnceLock::new() }; 2],
        })))
    }

    /// Returns whether a sphere at the end of the chain stays a sphere at all times.
    pub fn stays_round(&self) -> bool {
        self.0.as_ref().is_none_or(|joint| joint.round)
    }

    /// Returns the same motion as [`Motion::new`], to the last bit. The cached motions of the nodes above are reused.
    pub fn motion(&self, space: DAffine3, offset: f64) -> Arc<Motion> {
        let slot = usize::from(space != DAffine3::IDENTITY);
        let mut below = Vec::new();
        let mut at = self;
        let mut known = None;
        while let Some(joint) = &at.0 {
            let folded = joint.folded[slot].get();
            if let Some(folded) = folded.filter(|f| f.space == space && f.offset == offset) {
                known = Some(folded.motion.clone());
                break;
            }
            below.push(joint);
            at = &joint.above;
        }
        let mut motion =
            known.as_ref().map_or_else(|| Motion::new(Vec::new(), space, offset), |known| (**known).clone());
        for joint in below.into_iter().rev() {
            motion.push(&joint.link);
            known = (motion.links.len() <= SHORT).then(|| Arc::new(motion.clone()));
            if let Some(motion) = known.clone() {
                let _ = joint.folded[slot].set(Folded { space, offset, motion });
            }
        }
        known.unwrap_or_else(|| Arc::new(motion))
    }
}

impl From<Vec<Node>> for Chain {
    fn from(nodes: Vec<Node>) -> Self {
        nodes.into_iter().fold(Self::default(), |chain, node| chain.then(node))
    }
}

/// Drops the chain link by link, because recursion over a long chain would overflow the stack.
impl Drop for Chain {
    fn drop(&mut self) {
        let mut at = self.0.take();
        while let Some(mut joint) = at.and_then(Arc::into_inner) {
            at = joint.above.0.take();
        }
    }
}

fn is_even(node: &Node) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= EVEN * a.abs().max(b.abs());
    let equal = |v: DVec3| near(v.x, v.y) && near(v.y, v.z) && near(v.x, v.z);
    match node {
        Node::Fixed(m) => is_even_matrix(&m.matrix3),
        Node::Trs(Trs { scale: Channel::Constant(scale), .. }) => equal(scale.abs()),
        Node::Trs(Trs { scale: Channel::Track(track), .. }) => track.values().iter().all(|v| equal(*v)),
    }
}

fn is_even_matrix(m: &DMat3) -> bool {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let size = x.length_squared().max(y.length_squared()).max(z.length_squared());
    let small = |value: f64| value.abs() <= EVEN * size;
    let equal =
        small(x.length_squared() - y.length_squared()) && small(y.length_squared() - z.length_squared());
    equal && small(x.dot(y)) && small(y.dot(z)) && small(z.dot(x))
}

#[cfg(test)]
mod tests {
    use super::super::{Interpolation, Track};
    use super::*;
    use glam::DQuat;

    fn nodes(count: usize, moving: impl Fn(usize) -> bool) -> Vec<Node> {
        let node = |i: usize| {
            let at = |t: f64| DVec3::new(0.1 + t, 0.3 * i as f64, -0.7);
            let track = || Track::new(vec![0.0, 1.0], vec![at(0.0), at(1.0)], Interpolation::Linear).unwrap();
            let translation =
                if moving(i) { Channel::Track(Arc::new(track())) } else { Channel::Constant(at(0.0)) };
            let rotation = Channel::Constant(DQuat::from_rotation_y(0.1 * i as f64));
            Node::Trs(Trs { translation, rotation, ..Trs::default() })
        };
        (0..count).map(node).collect()
    }

    #[test]
    fn a_shared_chain_moves_to_the_last_bit_as_one_of_its_own() {
        let space = DAffine3::from_scale(DVec3::splat(0.25)) * DAffine3::from_translation(DVec3::X);
        for moving in [|_| false, |i| i == 0, |i| i % 5 == 2, |_| true] as [fn(usize) -> bool; 4] {
            let all = nodes(40, moving);
            let mut chain = Chain::default();
            for (i, node) in all.iter().enumerate() {
                chain = chain.then(node.clone());
                for space in [space, DAffine3::IDENTITY, DAffine3::from_translation(DVec3::Z)] {
                    let alone = Motion::new(all[..=i].to_vec(), space, 0.25);
                    for _ in 0..2 {
                        let shared = chain.motion(space, 0.25);
                        assert!(shared.at(0.4) == alone.at(0.4) && shared.pose_at(0.4) == alone.pose_at(0.4));
                    }
                }
            }
        }
    }

    #[test]
    fn a_chain_longer_than_the_stack_is_deep_takes_memory_once() {
        let mut chain = Chain::default();
        for node in nodes(200_000, |i| i == 0) {
            chain = chain.then(node);
            // In this order, each motion is computed from the one above.
            assert!(chain.motion(DAffine3::IDENTITY, 0.0).links.len() <= 3);
        }
        drop(chain);
    }

    #[test]
    fn uneven_scales_make_nothing_round() {
        let scaled = |s| Chain::from(vec![Node::Fixed(DAffine3::from_scale(s))]);
        assert!(Chain::default().stays_round() && scaled(DVec3::splat(-2.0)).stays_round());
        let uneven = scaled(DVec3::new(1.0, 2.0, 1.0));
        assert!(!uneven.stays_round() && !uneven.then(Node::Fixed(DAffine3::IDENTITY)).stays_round());
    }
}
