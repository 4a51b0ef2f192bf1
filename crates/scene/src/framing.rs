//! A camera for scenes that have none: looks at the scene's box from the front, a little from the right and above,
//! just far enough away to see all of it.
use crate::builder::CameraPose;
use dapple_camera::Projection;
use glam::{DAffine3, DMat3, DVec3};

/// tan of half the vertical field of view: 40° in all.
const TAN_HALF: f64 = 0.363_970_234_266_202_4;
/// From the scene to the camera.
const TOWARDS: DVec3 = DVec3::new(0.55, 0.4, 1.0);
/// Room around the box.
const MARGIN: f64 = 1.05;

/// A view of the world box from `min` to `max` whose square middle holds all of it.
pub(crate) fn frame(min: DVec3, max: DVec3) -> CameraPose {
    let backward = TOWARDS * (1.0 / TOWARDS.length());
    let right = DVec3::Y.cross(backward);
    let right = right * (1.0 / right.length());
    let up = backward.cross(right);
    let (centre, half) = (min * 0.5 + max * 0.5, (max - min) * 0.5);
    let distance = (0..8)
        .map(|corner| {
            let sign = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let p = half * DVec3::new(sign(0), sign(1), sign(2));
            p.dot(backward) + p.dot(right).abs().max(p.dot(up).abs()) * (MARGIN / TAN_HALF)
        })
        .fold(0.0, f64::max);
    let distance = if distance > 0.0 { distance } else { 1.0 };
    let axes = DMat3::from_cols(right, up, backward);
    CameraPose {
        transform: DAffine3 { matrix3: axes, translation: centre + backward * distance },
        projection: Projection::Perspective { tan_half: TAN_HALF as f32 },
        aspect: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_box_is_in_view() {
        for (min, max) in [
            (DVec3::splat(-1.0), DVec3::splat(1.0)),
            (DVec3::new(1e5, 0.0, -3.0), DVec3::new(1e5 + 7.0, 0.1, 2.0)),
            (DVec3::ZERO, DVec3::ZERO),
        ] {
            let pose = frame(min, max);
            let to_camera = pose.transform.inverse();
            for corner in 0..8 {
                let pick = |bit: u32, a: f64, b: f64| if corner >> bit & 1 == 0 { a } else { b };
                let p = DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z));
                let q = to_camera.transform_point3(p);
                assert!(q.z < 0.0 && q.x.abs().max(q.y.abs()) < -q.z * TAN_HALF, "{p} -> {q}");
            }
        }
    }
}
