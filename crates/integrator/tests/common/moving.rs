//! Objects that move while the shutter is open.

use dapple_camera::Shutter;
use dapple_math::motion::{Channel, Interpolation, Node, Track, Trs, Value};
use glam::DVec3;
use std::sync::Arc;

/// Open for half a second at a late time, so that time offsets matter.
pub const SHUTTER: Shutter = Shutter { open: 1.5, close: 2.0 };
pub const AT: f64 = 40.0;

/// Keys that are spaced evenly over the shutter interval.
pub fn over_shutter<T: Value>(values: Vec<T>) -> Channel<T> {
    let last = (values.len() - 1).max(1) as f64;
    let time = |i: usize| AT + SHUTTER.open + (SHUTTER.close - SHUTTER.open) * i as f64 / last;
    let times = (0..values.len()).map(time).collect();
    Channel::Track(Arc::new(Track::new(times, values, Interpolation::Linear).unwrap()))
}

pub fn slide(from: DVec3, to: DVec3) -> Vec<Node> {
    vec![Node::Trs(Trs { translation: over_shutter(vec![from, to]), ..Trs::default() })]
}
