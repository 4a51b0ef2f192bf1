//! Prints the positions of a point on a rotating, key-framed node, and the bounding box of its motion.
//! `cargo run --release --example orbit -p dapple-math`

use dapple_math::Motion;
use dapple_math::glam::{DAffine3, DQuat, DVec3};
use dapple_math::motion::{Channel, Interpolation, Node, Track, TrackError, Trs};
use std::f64::consts::PI;
use std::sync::Arc;

fn main() -> Result<(), TrackError> {
    let turns = [0.0, 0.5, 1.0].map(|turn| DQuat::from_rotation_y(turn * PI)).to_vec();
    let track = Track::new(vec![0.0, 0.5, 1.0], turns, Interpolation::Linear)?;
    let node = Node::Trs(Trs { rotation: Channel::Track(Arc::new(track)), ..Trs::default() });
    let motion = Motion::new(vec![node], DAffine3::IDENTITY, 0.0);
    for step in 0..=8 {
        let time = f64::from(step) / 8.0;
        let p = motion.at(time).transform_point3(DVec3::X);
        println!("{time:.3} s  x {:+.4}  z {:+.4}", p.x, p.z);
    }
    let (lo, hi) = motion.bounds(DVec3::X, DVec3::X, 0.0, 1.0);
    println!("box     x {:+.4} to {:+.4}  z {:+.4} to {:+.4}", lo.x, hi.x, lo.z, hi.z);
    Ok(())
}
