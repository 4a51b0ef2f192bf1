//! Scene nodes as glTF animates them: a constant affine transform, or a translation, rotation and scale, each of which
//! may be key-framed.
use super::pose::{self, Pose};
use super::track::{Track, Value};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::sync::Arc;

/// A constant or key-framed value.
#[derive(Clone, Debug)]
pub enum Channel<T> {
    /// The same at all times.
    Constant(T),
    /// Key-framed. The track is shared because a node may have many objects below it.
    Track(Arc<Track<T>>),
}

impl<T: Value> Channel<T> {
    /// Returns the value at `time`.
    pub fn at(&self, time: f64) -> T {
        match self {
            Self::Constant(value) => value.normalized(),
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

/// A node as glTF animates it: a scale, followed by a rotation and a translation.
#[derive(Clone, Debug)]
pub struct Trs {
    /// Translation in scene units.
    pub translation: Channel<DVec3>,
    /// Rotation as a unit quaternion.
    pub rotation: Channel<DQuat>,
    /// Scale factors, which may be negative, zero or unequal.
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
    /// Returns the transform to the parent's space at `time`.
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

    /// Returns the transform to the parent's space and its inverse. The inverse is composed from the inverses of the
    /// factors, so that unequal scales lose no precision, and a zero scale is replaced by a tiny one (see [`Pose`]). It
    /// is None when fewer than two scales are not zero, because the content of the node then has no area.
    pub(super) fn pose_at(&self, time: f64) -> Option<Pose> {
        let (t, r, s) =
            (self.translation.at(time), self.rotation.at(time), pose::thickened(self.scale.at(time))?);
        let rotation = DMat3::from_quat(r);
        let to_parent = DAffine3 { matrix3: rotation * DMat3::from_diagonal(s), translation: t };
        let back = DMat3::from_diagonal(s.recip()) * rotation.transpose();
        Some(Pose { to_world: to_parent, to_object: DAffine3 { matrix3: back, translation: -(back * t) } })
    }
}

/// One node of a chain.
#[derive(Clone, Debug)]
pub enum Node {
    /// A constant affine transform.
    Fixed(DAffine3),
    /// A translation, rotation and scale, each of which may be key-framed.
    Trs(Trs),
}

/// One or more constant nodes combined, or one animated node.
#[derive(Clone, Debug)]
pub(super) enum Link {
    /// A constant transform with its pose, which is None when the transform flattens its content to a line or a point.
    Still(Arc<(DAffine3, Option<Pose>)>),
    Moving(Arc<Trs>),
}

impl Link {
    /// Converts one node.
    pub(super) fn of(node: Node) -> Self {
        match node {
            Node::Trs(trs) if trs.has_tracks() => Self::Moving(Arc::new(trs)),
            Node::Trs(trs) => Self::Still(Arc::new((trs.at(0.0), trs.pose_at(0.0)))),
            Node::Fixed(m) => Self::Still(Arc::new((m, Pose::of(&m)))),
        }
    }
}
