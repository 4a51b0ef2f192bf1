//! When is the picture taken, and where do things on a chain of nodes stand then?
use crate::{Placement, Space};
use dapple_camera::Shutter;
use dapple_math::Motion;
use dapple_math::motion::Chain;
use std::sync::Arc;

/// When the picture is taken.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Exposure {
    /// Seconds of the animation.
    pub at: f64,
    /// Counted from `at`.
    pub shutter: Shutter,
}

impl Exposure {
    /// Motion along a chain, in seconds from the opening.
    pub fn motion(&self, chain: &Chain, space: &Space) -> Arc<Motion> {
        chain.motion(space.to_render_affine(), self.at + self.shutter.open)
    }

    /// Where the end of a chain stands in the world when the shutter opens.
    pub fn placement(&self, chain: &Chain) -> Placement {
        self.motion(chain, &Space::IDENTITY).at(0.0).into()
    }

    pub fn is_moving(&self, motion: &Motion) -> bool {
        motion.is_moving_within(0.0, self.shutter.seconds().into())
    }
}
