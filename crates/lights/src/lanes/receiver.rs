//! Receivers, and hits on lights, over lanes.
use dapple_math::lanes::Vec3x;

/// One receiver per lane.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<R> {
    /// Position.
    pub p: Vec3x<R>,
    /// Seconds after the shutter opened.
    pub time: R,
}

/// One hit on a light per lane.
#[derive(Clone, Copy, Debug)]
pub struct Hit<R> {
    /// Unit direction from the receiver.
    pub wi: Vec3x<R>,
    /// Distance to the hit; infinite for the environment.
    pub distance: R,
    /// Geometric normal at the hit.
    pub n: Vec3x<R>,
}
