//! The motion of one object: its chain of transforms, root first, with constant transforms combined.
use super::node::{Link, Node};
use super::pose::Pose;
use glam::DAffine3;
use std::sync::Arc;

/// The transform from object space to render space as a function of time.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Root first.
    pub(super) links: Vec<Link>,
    pub(super) offset: f64,
}

impl Motion {
    /// Creates the motion of an object. `chain` has the nodes from the root to the object's node, and `space` maps
    /// world space to render space. Tracks are evaluated at `offset` (the animation time at which the shutter
    /// opens) plus the time of a query, in seconds.
    pub fn new(chain: Vec<Node>, space: DAffine3, offset: f64) -> Self {
        let mut motion = Self { links: Vec::new(), offset };
        motion.push_still(space, Pose::of(&space));
        chain.into_iter().for_each(|node| motion.push(&Link::of(node)));
        motion
    }

    /// Appends a node at the end.
    pub(super) fn push(&mut self, link: &Link) {
        match link {
            Link::Moving(_) => self.links.push(link.clone()),
            Link::Still(still) => self.push_still(still.0, still.1),
        }
    }

    /// Creates a motion with the same transform at all times.
    pub fn fixed(transform: DAffine3) -> Self {
        Self::new(Vec::new(), transform, 0.0)
    }

    /// Appends a constant transform, multiplied into the last link if that is constant too.
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

    /// Returns the transform from object space to render space, `time` seconds after the shutter opens.
    pub fn at(&self, time: f64) -> DAffine3 {
        let time = self.offset + time;
        let link = |link: &Link| match link {
            Link::Still(still) => still.0,
            Link::Moving(trs) => trs.at(time),
        };
        self.links.iter().map(link).reduce(|a, b| a * b).unwrap_or(DAffine3::IDENTITY)
    }

    /// Returns the transform of [`Motion::at`] with its inverse. It is None when the transform flattens the object to a
    /// line or a point at that time, or is not finite.
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

    /// Returns whether the transform can change between the two times (seconds after the shutter opens).
    pub fn is_moving_within(&self, open: f64, close: f64) -> bool {
        let (open, close) = (self.offset + open, self.offset + close);
        let constant = |link: &Link| match link {
            Link::Still(..) => true,
            Link::Moving(trs) => trs.is_constant_within(open, close),
        };
        close > open && !self.links.iter().all(constant)
    }

    /// Returns whether only translations change between the two times (seconds after the shutter opens), and neither
    /// rotations nor scales.
    pub fn keeps_directions_within(&self, open: f64, close: f64) -> bool {
        let (open, close) = (self.offset + open, self.offset + close);
        self.links.iter().all(|link| match link {
            Link::Still(..) => true,
            Link::Moving(trs) => trs.keeps_directions_within(open, close),
        })
    }

    /// Returns the motion of a part whose constant transform within the object is `inner`.
    pub fn then_inner(&self, inner: DAffine3) -> Self {
        let mut motion = self.clone();
        motion.push_still(inner, Pose::of(&inner));
        motion
    }
}
