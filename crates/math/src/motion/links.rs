//! The motion of one object: a chain of folded links, root first, evaluated at a time.
use super::node::{Link, Node};
use super::pose::Pose;
use glam::DAffine3;
use std::sync::Arc;

/// The way from an object's own space to render space, at any time.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Root first.
    pub(super) links: Vec<Link>,
    pub(super) offset: f64,
}

impl Motion {
    /// `chain` from the root to the object's node, then `space` from world to render space; tracks are read `offset`
    /// seconds after the time asked for (the time of the picture).
    pub fn new(chain: Vec<Node>, space: DAffine3, offset: f64) -> Self {
        let mut motion = Self { links: Vec::new(), offset };
        motion.push_still(space, Pose::of(&space));
        chain.into_iter().for_each(|node| motion.push(&Link::of(node)));
        motion
    }

    /// One more node at the end.
    pub(super) fn push(&mut self, link: &Link) {
        match link {
            Link::Moving(_) => self.links.push(link.clone()),
            Link::Still(still) => self.push_still(still.0, still.1),
        }
    }

    /// The same transform at all times.
    pub fn fixed(transform: DAffine3) -> Self {
        Self::new(Vec::new(), transform, 0.0)
    }

    /// Neighbouring constant links become one.
    fn push_still(&mut self, m: DAffine3, pose: Option<Pose>) {
        match self.links.last_mut() {
            Some(Link::Still(before)) => {
                let before = Arc::make_mut(before);
                before.0 *= m;
                before.1 = before.1.and_then(|a| pose.map(|b| a.then_inner(&b)));
            }
            _ => self.links.push(Link::Still(Arc::new((m, pose)))),
        }
    }

    /// Object space to render space at `time` seconds within the shutter.
    pub fn at(&self, time: f64) -> DAffine3 {
        let time = self.offset + time;
        let link = |link: &Link| match link {
            Link::Still(still) => still.0,
            Link::Moving(trs) => trs.at(time),
        };
        self.links.iter().map(link).reduce(|a, b| a * b).unwrap_or(DAffine3::IDENTITY)
    }

    /// As [`Motion::at`], with the way back; None when the object is a line, a point or not finite then.
    pub fn pose_at(&self, time: f64) -> Option<Pose> {
        let time = self.offset + time;
        let mut pose = Pose::IDENTITY;
        for link in &self.links {
            let inner = match link {
                Link::Still(still) => still.1?,
                Link::Moving(trs) => trs.pose_at(time)?,
            };
            pose = pose.then_inner(&inner);
        }
        pose.is_finite().then_some(pose)
    }

    /// Whether anything changes between the two times (seconds within the shutter).
    pub fn is_moving_within(&self, open: f64, close: f64) -> bool {
        let (open, close) = (self.offset + open, self.offset + close);
        let constant = |link: &Link| match link {
            Link::Still(..) => true,
            Link::Moving(trs) => trs.is_constant_within(open, close),
        };
        close > open && !self.links.iter().all(constant)
    }

    /// Whether what moves between the two times (seconds within the shutter) is only shifted, neither turned nor scaled.
    pub fn keeps_directions_within(&self, open: f64, close: f64) -> bool {
        let (open, close) = (self.offset + open, self.offset + close);
        self.links.iter().all(|link| match link {
            Link::Still(..) => true,
            Link::Moving(trs) => trs.keeps_directions_within(open, close),
        })
    }

    /// The same motion of a part that stands at `inner` in the object's own space.
    pub fn then_inner(&self, inner: DAffine3) -> Self {
        let mut motion = self.clone();
        motion.push_still(inner, Pose::of(&inner));
        motion
    }
}
