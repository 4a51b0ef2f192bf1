//! Where is an object at a time? A chain of node transforms, some of them key-framed, down to render space.
//!
//! `Motion::at(t)` = space · node₀(t) · … · nodeₙ(t), root first, in f64. Times count in seconds within the shutter;
//! tracks are read at `offset + t`. What does not change is folded when the chain is made, so a query evaluates only
//! the nodes that have tracks.
mod chain;
mod pose;
mod sweep;
mod track;

pub use chain::Chain;
pub use pose::{NormalMap, Pose};
pub use track::{Interpolation, Track, TrackError, Value};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::sync::Arc;

/// A number that stays, or one that follows keys.
#[derive(Clone, Debug)]
pub enum Channel<T> {
    /// The same at all times.
    Constant(T),
    /// Key-framed; shared, for many objects may hang on one node.
    Track(Arc<Track<T>>),
}

impl<T: Value> Channel<T> {
    /// The value at `time`.
    pub fn at(&self, time: f64) -> T {
        match self {
            Self::Constant(value) => value.settled(),
            Self::Track(track) => track.at(time),
        }
    }

    fn is_constant_within(&self, open: f64, close: f64) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Track(track) => track.is_constant_within(open, close),
        }
    }

    fn is_track(&self) -> bool {
        matches!(self, Self::Track(_))
    }
}

/// A node as glTF animates it: first scaled, then rotated, then moved.
#[derive(Clone, Debug)]
pub struct Trs {
    /// Scene units.
    pub translation: Channel<DVec3>,
    /// Unit quaternion.
    pub rotation: Channel<DQuat>,
    /// Factors; may be negative, zero or uneven.
    pub scale: Channel<DVec3>,
}

impl Default for Trs {
    fn default() -> Self {
        Self {
            translation: Channel::Constant(DVec3::ZERO),
            rotation: Channel::Constant(DQuat::IDENTITY),
            scale: Channel::Constant(DVec3::ONE),
        }
    }
}

impl Trs {
    /// The transform to the parent at `time`.
    pub fn at(&self, time: f64) -> DAffine3 {
        let (t, r, s) = (self.translation.at(time), self.rotation.at(time), self.scale.at(time));
        DAffine3::from_scale_rotation_translation(s, r, t)
    }

    fn has_tracks(&self) -> bool {
        self.translation.is_track() || self.rotation.is_track() || self.scale.is_track()
    }

    fn is_constant_within(&self, open: f64, close: f64) -> bool {
        self.translation.is_constant_within(open, close) && self.keeps_directions_within(open, close)
    }

    fn keeps_directions_within(&self, open: f64, close: f64) -> bool {
        self.rotation.is_constant_within(open, close) && self.scale.is_constant_within(open, close)
    }

    /// To the parent and back, piece by piece, so that uneven scales cost no digits; a zero scale counts as a tiny one
    /// (see [`Pose`]). None when fewer than two scales are left: the node's content has no area.
    fn pose_at(&self, time: f64) -> Option<Pose> {
        let (t, r, s) =
            (self.translation.at(time), self.rotation.at(time), pose::thickened(self.scale.at(time))?);
        let rotation = DMat3::from_quat(r);
        let to_parent = DAffine3 { matrix3: rotation * DMat3::from_diagonal(s), translation: t };
        let back = DMat3::from_diagonal(s.recip()) * rotation.transpose();
        Some(Pose { to_world: to_parent, to_object: DAffine3 { matrix3: back, translation: -(back * t) } })
    }
}

/// One link of a chain.
#[derive(Clone, Debug)]
pub enum Node {
    /// Any affine transform, the same at all times.
    Fixed(DAffine3),
    /// Translation, rotation, scale; each may follow keys.
    Trs(Trs),
}

/// A folded link.
#[derive(Clone, Debug)]
enum Link {
    /// With its pose; None when it flattens its content to a line or a point.
    Still(Arc<(DAffine3, Option<Pose>)>),
    Moving(Arc<Trs>),
}

impl Link {
    /// Of one node alone.
    fn of(node: Node) -> Self {
        match node {
            Node::Trs(trs) if trs.has_tracks() => Self::Moving(Arc::new(trs)),
            Node::Trs(trs) => Self::Still(Arc::new((trs.at(0.0), trs.pose_at(0.0)))),
            Node::Fixed(m) => Self::Still(Arc::new((m, Pose::of(&m)))),
        }
    }
}

/// The way from an object's own space to render space, at any time.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Root first.
    links: Vec<Link>,
    offset: f64,
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
    fn push(&mut self, link: &Link) {
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
