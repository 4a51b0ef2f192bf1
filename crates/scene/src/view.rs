//! Views that the user defines by position and direction instead of a camera of the scene.
use crate::{CameraPose, Scene, WorldPoint};
use dapple_camera::{Camera, Projection};
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Default vertical field of view, in radians.
pub const FIELD_OF_VIEW: f64 = 40.0 / 180.0 * std::f64::consts::PI;

/// Margin around the bounding sphere shown by an orbit, as a factor.
const MARGIN: f64 = 1.05;

/// A perspective projection with vertical field of view `yfov` in radians.
pub fn perspective(yfov: f64) -> Projection {
    Projection::Perspective { tan_half: libm::tan(yfov * 0.5) as f32 }
}

/// Camera position on a sphere around a point, which is at the centre of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Angle about the vertical axis in radians: 0 views from +Z, the front of glTF models, π/2 from +X.
    pub yaw: f64,
    /// Angle above the horizontal plane in radians, at most π/2.
    pub pitch: f64,
    /// Distance from the central point in world units; None selects the smallest one at which everything is in view
    /// from all sides.
    pub distance: Option<f64>,
}

impl Orbit {
    /// Pose of a camera that orbits `centre`, with everything within `radius` of it, up vector `up` (not zero) and
    /// vertical field of view `yfov` in radians.
    pub fn pose(&self, centre: DVec3, radius: f64, up: DVec3, yfov: f64) -> CameraPose {
        let ((sy, cy), (sp, cp)) = (libm::sincos(self.yaw), libm::sincos(self.pitch));
        let (right, backward) = (DVec3::new(cy, 0.0, -sy), DVec3::new(sy * cp, sp, cy * cp));
        let axes = upright(up) * DMat3::from_cols(right, backward.cross(right), backward);
        // The camera is at the apex of the cone tangent to the sphere. A point is visible from any other point.
        let nearest = if radius > 0.0 { MARGIN * radius / libm::sin(yfov * 0.5) } else { 1.0 };
        let distance = self.distance.unwrap_or(nearest);
        CameraPose {
            transform: DAffine3 { matrix3: axes, translation: centre + axes.z_axis * distance },
            projection: perspective(yfov),
            aspect: Some(1.0),
            clip: None,
        }
    }
}

/// The direction of a vector of any length; None for zero.
fn unit(v: DVec3) -> Option<DVec3> {
    (v / v.abs().max_element()).try_normalize()
}

/// The shortest rotation from +Y to `up`.
fn upright(up: DVec3) -> DMat3 {
    DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Y, unit(up).unwrap_or(DVec3::Y)))
}

/// Axes (right, up, backward) of a view from one point to another with up vector `up`. If the view is along `up`, the
/// orientation is that of an [`Orbit`] with yaw 0. None if both points coincide.
pub fn axes_towards(from: DVec3, at: DVec3, up: DVec3) -> Option<DMat3> {
    let backward = unit(from - at)?;
    let up = unit(up).unwrap_or(DVec3::Y);
    let side = up.cross(backward);
    let right = if side.length_squared() > 1e-24 { side.normalize() } else { upright(up) * DVec3::X };
    let right = (right - backward * backward.dot(right)).normalize();
    Some(DMat3::from_cols(right, backward.cross(right), backward))
}

impl Scene {
    /// Centre of the scene's bounding box.
    pub fn centre(&self) -> WorldPoint {
        let middle = self.accel.bounds().map(|(min, max)| (min.as_dvec3() + max.as_dvec3()) * 0.5);
        self.space.to_world_f64(middle.unwrap_or(DVec3::ZERO))
    }

    /// Largest distance from a world-space point to any point of the scene, in world units.
    pub fn reach(&self, from: WorldPoint) -> f64 {
        let from = self.space.to_render_f64(from);
        let Some((min, max)) = self.accel.bounds() else { return 0.0 };
        let corner = |i: u32| {
            let of = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
            DVec3::new(of(0).into(), of(1).into(), of(2).into())
        };
        let outermost = |points: &mut dyn Iterator<Item = DVec3>| {
            points.map(|p| p.distance_squared(from)).fold(0.0, f64::max).sqrt()
        };
        let of_box = outermost(&mut (0..8).map(corner));
        // For static meshes the corners give a tighter bound than the bounding box.
        let is_known = self.survey.shapes == 0 && !self.accel.has_motion();
        let radius = if is_known { outermost(&mut self.corners()) } else { of_box };
        self.space.length_to_world(radius.min(of_box))
    }

    /// Corners of all triangles, in render space.
    fn corners(&self) -> impl Iterator<Item = DVec3> {
        (0..self.objects.len() as u32).flat_map(move |object| {
            let count = self.accel.triangles_of(object) as u32;
            (0..count).flat_map(move |i| self.accel.corners(object, i)).map(|p| p.as_dvec3())
        })
    }

    /// Creates a render-space camera from a pose.
    ///
    /// # Errors
    /// A description of the problem if the pose is not valid.
    pub fn place_camera(&self, pose: &CameraPose) -> Result<Camera, &'static str> {
        pose.in_render_space(&self.space)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn orbit(yaw: f64, pitch: f64, up: DVec3) -> DMat3 {
        Orbit { yaw, pitch, distance: None }.pose(DVec3::ONE, 2.0, up, FIELD_OF_VIEW).transform.matrix3
    }

    fn is_near(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-12
    }

    #[test]
    fn an_orbit_goes_from_the_front_to_the_right_and_up() {
        assert!(is_near(orbit(0.0, 0.0, DVec3::Y).z_axis, DVec3::Z));
        assert!(is_near(orbit(FRAC_PI_2, 0.0, DVec3::Y).z_axis, DVec3::X));
        let above = orbit(0.0, FRAC_PI_2, DVec3::Y);
        assert!(is_near(above.z_axis, DVec3::Y) && is_near(above.y_axis, DVec3::NEG_Z));
        // Z up, seen from the front of Blender's world.
        let blender = orbit(0.0, 0.0, DVec3::Z);
        assert!(is_near(blender.z_axis, DVec3::NEG_Y) && is_near(blender.y_axis, DVec3::Z));
        for (yaw, pitch) in [(0.3, 0.2), (-2.0, -1.1), (5.0, 1.57)] {
            let axes = orbit(yaw, pitch, DVec3::new(1.0, 2.0, 0.5));
            assert!((axes.determinant() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_sphere_around_everything_touches_the_edge_of_the_frame() {
        let yfov: f64 = 0.7;
        let pose = Orbit { yaw: 1.0, pitch: 0.4, distance: None }.pose(DVec3::ONE, 2.0, DVec3::Y, yfov);
        let distance = pose.transform.translation.distance(DVec3::ONE);
        assert!(((2.0 * MARGIN / distance).asin() - yfov * 0.5).abs() < 1e-12);
        let told = Orbit { yaw: 1.0, pitch: 0.4, distance: Some(7.0) }.pose(DVec3::ONE, 2.0, DVec3::Y, yfov);
        assert!((told.transform.translation.distance(DVec3::ONE) - 7.0).abs() < 1e-12);
    }

    #[test]
    fn a_view_straight_down_is_the_orbit_s() {
        for up in [DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0)] {
            let from = DVec3::ONE + up * 3.0;
            let down = axes_towards(from, DVec3::ONE, up).unwrap();
            let expected = orbit(0.0, FRAC_PI_2, up);
            for (a, b) in [(down.x_axis, expected.x_axis), (down.y_axis, expected.y_axis)] {
                assert!((a - b).length() < 1e-9, "{up}: {a} {b}");
            }
        }
        assert!(axes_towards(DVec3::ONE, DVec3::ONE, DVec3::Y).is_none());
        let level = axes_towards(DVec3::Z, DVec3::ZERO, DVec3::new(0.0, 3.0, 0.1)).unwrap();
        assert!(is_near(level.y_axis, DVec3::Y) && is_near(level.x_axis, DVec3::X));
    }
}
