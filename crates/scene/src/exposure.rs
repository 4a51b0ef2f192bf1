//! The exposure of the image: time and shutter, and the placement of moving objects within it.
use crate::{Placement, Space};
use dapple_camera::Shutter;
use dapple_math::Motion;
use dapple_math::motion::Chain;
use std::sync::Arc;

/// Time interval in which the image is exposed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Exposure {
    /// Time of the animation in seconds.
    pub at: f64,
    /// Opening and closing time relative to `at`.
    pub shutter: Shutter,
}

impl Exposure {
    /// Motion of a chain in render space; its time counts in seconds from the opening of the shutter.
    pub fn motion(&self, chain: &Chain, space: &Space) -> Arc<Motion> {
        chain.motion(space.to_render_affine(), self.at + self.shutter.open)
    }

    /// World placement of the end of a chain when the shutter opens.
    pub fn placement(&self, chain: &Chain) -> Placement {
        self.motion(chain, &Space::IDENTITY).at(0.0).into()
    }

    pub fn is_moving(&self, motion: &Motion) -> bool {
        motion.is_moving_within(0.0, self.shutter.seconds().into())
    }
}
