//! The nodes of a scene as glTF animates them: any fixed transform, or translation, rotation and scale, each of which may
//! follow keys.
use super::pose::{self, Pose};
use super::track::{Track, Value};
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

    pub(super) fn is_constant_within(&self, open: f64, close: f64) -> bool {
        self.translation.is_constant_within(open, close) && self.keeps_directions_within(open, close)
    }

    pub(super) fn keeps_directions_within(&self, open: f64, close: f64) -> bool {
        self.rotation.is_constant_within(open, close) && self.scale.is_constant_within(open, close)
    }

    /// To the parent and back, piece by piece, so that uneven scales cost no digits; a zero scale counts as a tiny one
    /// (see [`Pose`]). None when fewer than two scales are left: the node's content has no area.
    pub(super) fn pose_at(&self, time: f64) -> Option<Pose> {
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
pub(super) enum Link {
    /// With its pose; None when it flattens its content to a line or a point.
    Still(Arc<(DAffine3, Option<Pose>)>),
    Moving(Arc<Trs>),
}

impl Link {
    /// Of one node alone.
    pub(super) fn of(node: Node) -> Self {
        match node {
            Node::Trs(trs) if trs.has_tracks() => Self::Moving(Arc::new(trs)),
            Node::Trs(trs) => Self::Still(Arc::new((trs.at(0.0), trs.pose_at(0.0)))),
            Node::Fixed(m) => Self::Still(Arc::new((m, Pose::of(&m)))),
        }
    }
}
