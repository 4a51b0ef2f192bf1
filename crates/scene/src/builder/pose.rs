//! World-space pose of a camera, and its conversion to render space.
use crate::{Space, WorldPoint};
use dapple_camera::{Camera, Clip, Projection, camera::axes};
use glam::{DAffine3, DMat3, DVec3};

/// A camera in world space. It looks along the −z of its transform, with +y up; scale and shear of the transform are
/// ignored.
#[derive(Clone, Copy, Debug)]
pub struct CameraPose {
    /// Transform from camera to world.
    pub transform: DAffine3,
    /// Perspective or orthographic (half height in world units).
    pub projection: Projection,
    /// Aspect ratio (width / height) of the frame that the image must contain.
    pub aspect: Option<f32>,
    /// Near and far clipping planes of camera rays, in world units.
    pub clip: Option<Clip>,
}

impl CameraPose {
    /// A perspective camera at `from` that looks at `at`, with up vector `up` and a vertical field of view of `yfov`
    /// radians.
    pub fn look_at(from: DVec3, at: DVec3, up: DVec3, yfov: f64) -> Self {
        let backward = (from - at).normalize_or(DVec3::Z);
        let right = up.cross(backward).normalize_or(backward.any_orthonormal_vector());
        let axes = DMat3::from_cols(right, backward.cross(right), backward);
        Self {
            transform: DAffine3 { matrix3: axes, translation: from },
            projection: Projection::Perspective { tan_half: libm::tan(yfov * 0.5) as f32 },
            aspect: None,
            clip: None,
        }
    }
}

impl CameraPose {
    /// The camera in render space, or a description of the problem.
    pub(crate) fn in_render_space(&self, space: &Space) -> Result<Camera, &'static str> {
        let Some((right, up, backward)) = axes(&self.transform.matrix3) else {
            return Err("has no viewing direction: its transform is singular or not finite");
        };
        let origin = space.to_render(WorldPoint(self.transform.translation));
        let projection = match self.projection {
            Projection::Orthographic { half_height } => {
                Projection::Orthographic { half_height: space.length_to_render(f64::from(half_height)) }
            }
            perspective @ Projection::Perspective { .. } => perspective,
        };
        let (Projection::Perspective { tan_half: extent } | Projection::Orthographic { half_height: extent }) =
            projection;
        if !origin.is_finite() {
            return Err("is too far away: its position is not finite");
        }
        if !(extent > 0.0 && extent.is_finite()) {
            return Err("must have a field of view between 0 and 180 degrees, or a height above 0");
        }
        Ok(Camera {
            origin,
            right: right.as_vec3(),
            up: up.as_vec3(),
            backward: backward.as_vec3(),
            projection,
            lens: None,
            motion: None,
            aspect: self.aspect,
            clip: self.clip.map(|clip| clip_in_render_space(clip, space)),
        })
    }
}

/// Converts clipping planes; planes whose distance is not a finite positive number are disabled.
fn clip_in_render_space(clip: Clip, space: &Space) -> Clip {
    let length = |world: f32| space.length_to_render(f64::from(world));
    let near = Some(length(clip.near)).filter(|near| *near > 0.0 && near.is_finite());
    Clip {
        near: near.unwrap_or(0.0),
        far: Some(length(clip.far)).filter(|far| *far > 0.0).unwrap_or(f32::INFINITY),
    }
}
