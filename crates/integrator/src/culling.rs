//! Surfaces that camera rays pass, computed once per render: back faces of single-sided materials, and everything
//! outside the near and far clipping planes.

use dapple_camera::{Camera, Clip, Projection};
use dapple_scene::{Scene, TexturedMaterial};
use glam::DVec3;
use std::{fmt, str::FromStr};

/// Which rays hit the back faces of triangles with a single-sided material. Exact spheres and disks have no back faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backfaces {
    /// Camera rays pass them, unless the material is transmissive; all other rays hit them. Images then match the
    /// culling of the glTF specification, and rooms with single-sided walls keep their light.
    #[default]
    Camera,
    /// All rays hit them.
    Shown,
    /// No ray hits them, whatever the material; they do not block light either.
    Culled,
}

impl FromStr for Backfaces {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "camera" => Ok(Self::Camera),
            "shown" => Ok(Self::Shown),
            "culled" => Ok(Self::Culled),
            _ => Err("expected camera, shown or culled".into()),
        }
    }
}

impl fmt::Display for Backfaces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Camera => "camera",
            Self::Shown => "shown",
            Self::Culled => "culled",
        })
    }
}

/// Whether camera rays pass the back faces of a material.
pub(crate) fn hides_back(m: &TexturedMaterial) -> bool {
    !m.double_sided && !m.transmits()
}

/// Whether camera rays pass the back faces of any object in the scene.
pub(crate) fn hides_backs(scene: &Scene, backfaces: Backfaces) -> bool {
    backfaces == Backfaces::Camera
        && scene.objects.iter().any(|object| hides_back(&scene.materials[object.material as usize]))
}

/// The clipping planes, without those that clip nothing; `None` if neither plane clips any part of the scene.
pub(crate) fn needed_clip(scene: &Scene, camera: &Camera) -> Option<Clip> {
    let clip = camera.clip?;
    let (min, max) = scene.accel.bounds()?;
    if camera.motion.is_some() {
        return Some(clip);
    }
    let depth = |i: usize| {
        let of = |axis: usize| f64::from(if i >> axis & 1 == 0 { min[axis] } else { max[axis] });
        (camera.origin.as_dvec3() - DVec3::new(of(0), of(1), of(2))).dot(camera.backward.as_dvec3())
    };
    let nearest = (0..8).map(depth).fold(f64::INFINITY, f64::min);
    let farthest = (0..8).map(depth).fold(f64::NEG_INFINITY, f64::max);
    let near = if nearest >= f64::from(clip.near) { 0.0 } else { clip.near };
    let far = if farthest <= f64::from(clip.far) { f32::INFINITY } else { clip.far };
    (near > 0.0 || far < f32::INFINITY).then_some(Clip { near, far })
}

/// Upper bound of the ray parameter of the near plane along a camera ray; 0 where nothing is clipped. The directions of
/// camera rays have a length of at least 1, and their tilt is bounded by the image corners, the widest pixel filter and
/// the rim of the lens.
pub(crate) fn farthest_near(camera: &Camera, size: (u32, u32)) -> f32 {
    let Some(Clip { near, .. }) = camera.clip else { return 0.0 };
    let (width, height) = (size.0 as f32, size.1.max(1) as f32);
    let tilt = match camera.projection {
        Projection::Perspective { tan_half } => tan_half * (width + height + 4.0 * WIDEST) / height,
        Projection::Orthographic { .. } => 0.0,
    };
    let by_lens = camera.lens.map_or(0.0, |lens| 2.0 * lens.radius / lens.focus_distance);
    near * 1.01 * (1.0 + tilt + by_lens)
}

/// Radius of the widest pixel filter, in pixels.
const WIDEST: f32 = 64.0;
