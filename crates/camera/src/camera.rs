//! Pixel to ray: where does a point of the picture look?
//!
//! Conventions: the camera looks along −z of its frame with +y up (glTF); pixels are square; the picture's height spans
//! the vertical field of view and its width follows from the size in pixels; film coordinates start at the top left.
use crate::Lens;
use dapple_math::{Motion, Ray};
use glam::{DMat3, DVec2, DVec3, Vec2, Vec3};
use std::sync::Arc;

/// How the film plane is projected into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// `tan_half` = tan(yfov/2): spans the image height.
    Perspective {
        /// tan(yfov/2), > 0.
        tan_half: f32,
    },
    /// Parallel rays; glTF's `ymag`.
    Orthographic {
        /// Half height of the view in scene units.
        half_height: f32,
    },
}

/// Looks along −z of its frame, +y up (glTF). Units: render space.
#[derive(Clone, Debug)]
pub struct Camera {
    /// The eye (centre of the lens); like the axes, when the shutter opens.
    pub origin: Vec3,
    /// Unit +x of the frame.
    pub right: Vec3,
    /// Unit +y of the frame.
    pub up: Vec3,
    /// Unit +z of the frame: away from the scene.
    pub backward: Vec3,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// `None` is a pinhole.
    pub lens: Option<Lens>,
    /// From the camera's own space to render space while the shutter is open, scale and shear ignored. `None` stands
    /// still.
    pub motion: Option<Arc<Motion>>,
    /// Width / height of the frame that the view has to show whole (see [`Camera::fitted`]). `None`: the height alone.
    pub aspect: Option<f32>,
    /// Planes before and beyond which camera rays see nothing. `None`: there are none.
    pub clip: Option<Clip>,
}

/// Clipping planes, as distances along the view axis from the camera's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// What lies nearer is not seen; 0 = everything in front of the camera is.
    pub near: f32,
    /// What lies farther is not seen; may be infinite.
    pub far: f32,
}

impl Camera {
    /// The camera as it stands `time` seconds after the shutter opened. A transform that leaves no direction of view
    /// then keeps the axes of the opening.
    pub fn at(&self, time: f32) -> Self {
        let Self { origin, right, up, backward, projection, lens, aspect, clip, .. } = *self;
        let still = Self { origin, right, up, backward, projection, lens, motion: None, aspect, clip };
        let Some(motion) = &self.motion else { return still };
        let placed = motion.at(f64::from(time));
        let Some((right, up, backward)) = axes(&placed.matrix3) else { return still };
        let (right, up, backward) = (right.as_vec3(), up.as_vec3(), backward.as_vec3());
        Self { origin: placed.translation.as_vec3(), right, up, backward, ..still }
    }

    /// The camera whose view of a picture of `size` pixels holds the whole frame of its aspect ratio: a picture that is
    /// narrower than the frame shows more above and below it, a wider one more on both sides. A frame that fits to within
    /// half a pixel is left as it is.
    pub fn fitted(mut self, size: (u32, u32)) -> Self {
        let (width, height) = (f64::from(size.0.max(1)), f64::from(size.1.max(1)));
        let Some(aspect) = self.aspect.map(f64::from).filter(|a| *a > 0.0 && a.is_finite()) else {
            return self;
        };
        if width >= height * aspect - 0.5 {
            return self;
        }
        let larger =
            |extent: f32| (f64::from(extent) * (aspect * height / width)).min(f32::MAX.into()) as f32;
        self.projection = match self.projection {
            Projection::Perspective { tan_half } => Projection::Perspective { tan_half: larger(tan_half) },
            Projection::Orthographic { half_height } => {
                Projection::Orthographic { half_height: larger(half_height) }
            }
        };
        self
    }

    /// How far along a camera ray its near plane lies, in lengths of the ray's direction; 0 without one. `self`: as it
    /// stands at the ray's time.
    pub fn near(&self, ray: &Ray) -> f32 {
        let near = self.clip.map_or(0.0, |clip| clip.near);
        // The direction's part along the axis is above zero: the ray points forward.
        if near > 0.0 { near / -ray.d.dot(self.backward) } else { 0.0 }
    }

    /// The ray through the point `pixel + fraction` of a picture of `size` pixels (from the top left, x right, y down),
    /// leaving the lens at `lens_u` in \[0,1)². The direction is unit.
    ///
    /// `pixel` and `fraction` are kept apart, and everything is worked out in f64 and rounded once, so that no jitter is
    /// lost in large pictures and a pixel of a narrow view keeps its own direction. `fraction` may lie outside \[0,1)
    /// (wide filters). A rotated frame still rounds each direction component to 2⁻²⁴: below 6e-8 rad per pixel only a
    /// camera aligned with the axes of render space resolves every pixel, because small components keep their digits.
    ///
    /// With a lens, all rays of one film point meet in the plane at `focus_distance` along the view axis, exactly as
    /// far as f32 can hold: the pinhole direction (x, y, −1) is moved by −lens/focus instead of being multiplied by
    /// focus, which stays accurate for focus = 1e9 and includes infinity. Radius 0 gives the bits of the pinhole.
    ///
    /// The ray starts at the lens and ends at the far plane; where the near plane is, [`Camera::near`] says.
    #[inline]
    pub fn ray(&self, pixel: (u32, u32), fraction: Vec2, size: (u32, u32), lens_u: Vec2) -> Ray {
        let plane = film_plane(pixel, fraction, size);
        let (film, tilt, step) = match self.projection {
            Projection::Perspective { tan_half } => {
                let tan_half = f64::from(tan_half);
                (DVec2::ZERO, plane * tan_half, 2.0 * tan_half / f64::from(size.1.max(1)))
            }
            Projection::Orthographic { half_height } => {
                (plane * f64::from(half_height), DVec2::ZERO, f64::INFINITY)
            }
        };
        match self.lens {
            Some(lens) if cfg!(not(without = "lens")) && lens.radius > 0.0 => {
                let on_lens = lens.point(lens_u).as_dvec2();
                self.leave(film + on_lens, tilt - on_lens * lens.inverse_focus(), step)
            }
            _ => self.leave(film, tilt, step),
        }
    }

    /// From the point `offset` of the lens plane along (tilt.x, tilt.y, −1), both in the camera's frame. `step`: how far
    /// apart pixels are in `tilt`.
    #[inline]
    fn leave(&self, offset: DVec2, tilt: DVec2, step: f64) -> Ray {
        let (right, up) = (self.right.as_dvec3(), self.up.as_dvec3());
        let d: DVec3 = right * tilt.x + up * tilt.y - self.backward.as_dvec3();
        let o = if offset == DVec2::ZERO {
            self.origin
        } else {
            (self.origin.as_dvec3() + right * offset.x + up * offset.y).as_vec3()
        };
        let length = d.length();
        let d = d / length;
        let ray = Ray::new(o, if step < NARROW { finest(d) } else { d.as_vec3() });
        match self.clip {
            // A unit along the axis is `length` along the ray.
            Some(Clip { far, .. }) if far < f32::INFINITY => {
                ray.until((f64::from(far) * length / f64::from(ray.d.length())) as f32)
            }
            _ => ray,
        }
    }
}

/// Below this angle between pixels a unit vector in f32, known to 2⁻²⁴, is off by more than 1/64 pixel.
const NARROW: f64 = 64.0 / (1u64 << 24) as f64;

/// The f32 vector nearest in direction to the unit vector `d` among [`LENGTHS`] lengths: its rounding errors are as good as
/// random, so the best of n is √n times as good as one. Off by 1e-9 rad typically, 4e-9 at most (measured).
#[cold]
fn finest(d: DVec3) -> Vec3 {
    // A direction along an axis keeps all digits of its small components.
    let (mut best, mut least) = (d.as_vec3(), f64::INFINITY);
    let unit = d / d.abs().max_element();
    for k in 0..LENGTHS {
        let rounded = (unit * (1.0 + f64::from(k) / f64::from(LENGTHS))).as_vec3();
        let off = unit.cross(rounded.as_dvec3()).length_squared() / rounded.as_dvec3().length_squared();
        if off < least {
            (best, least) = (rounded, off);
        }
    }
    best
}

/// How many lengths between 1 and 2 are tried, a power of two: the largest component is then exact.
const LENGTHS: u32 = 1024;

/// Unit right, up and backward of a transform without its scale, shear and mirroring; None when it has no direction of
/// view. The direction of view is kept; one axis that is scaled to nothing follows from the two others. Of the two ways to
/// undo a mirroring that leaves, in x and in y, the one is taken with the top of the view towards +y, and x in a view
/// straight up or down, where no rounding may decide.
pub fn axes(m: &DMat3) -> Option<(DVec3, DVec3, DVec3)> {
    let unit = |v: DVec3| v.try_normalize();
    let backward = unit(m.z_axis).or_else(|| unit(m.x_axis.cross(m.y_axis)))?;
    let across = |v: DVec3| unit(v - backward * backward.dot(v));
    let up = match unit(m.y_axis) {
        Some(_) => across(m.y_axis)?,
        None => backward.cross(across(m.x_axis)?),
    };
    let is_mirrored = m.x_axis.dot(up.cross(backward)) < 0.0;
    let up = if is_mirrored && up.y < -LEVEL { -up } else { up };
    let right = up.cross(backward);
    (right.is_finite() && up.is_finite() && backward.is_finite()).then_some((right, up, backward))
}

/// Height of a unit vector that is level but for its rounding in f32.
const LEVEL: f64 = 1e-6;

/// The film point on a plane whose top edge is y = 1 and bottom edge y = −1, centre 0, x to the right in the same unit.
#[inline]
fn film_plane(pixel: (u32, u32), fraction: Vec2, size: (u32, u32)) -> DVec2 {
    let (w, h) = (size.0 as f64, size.1.max(1) as f64);
    let x = pixel.0 as f64 - 0.5 * w + fraction.x as f64;
    let y = pixel.1 as f64 - 0.5 * h + fraction.y as f64;
    DVec2::new(x, -y) * (2.0 / h)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Aperture;

    fn camera(projection: Projection, lens: Option<Lens>) -> Camera {
        Camera {
            origin: Vec3::new(0.0, 0.0, 0.0),
            right: Vec3::X,
            up: Vec3::Y,
            backward: Vec3::Z,
            projection,
            lens,
            motion: None,
            aspect: None,
            clip: None,
        }
    }

    #[test]
    fn picture_centre_looks_along_minus_z_and_the_top_row_looks_up() {
        let c = camera(Projection::Perspective { tan_half: 1.0 }, None);
        let centre = c.ray((8, 4), Vec2::ZERO, (16, 8), Vec2::ZERO);
        assert_eq!(centre.d, Vec3::NEG_Z);
        let top = c.ray((8, 0), Vec2::ZERO, (16, 8), Vec2::ZERO).d;
        assert!((top.y / -top.z - 1.0).abs() < 1e-6, "tan(yfov/2) at the top edge");
        let right = c.ray((16, 4), Vec2::ZERO, (16, 8), Vec2::ZERO).d;
        assert!((right.x / -right.z - 2.0).abs() < 1e-6, "the width follows the size");
    }

    #[test]
    fn radius_zero_is_the_pinhole_to_the_last_bit() {
        let lens = Lens { aperture: Aperture::Disk, radius: 0.0, focus_distance: 3.0 };
        for projection in
            [Projection::Perspective { tan_half: 0.4 }, Projection::Orthographic { half_height: 2.0 }]
        {
            let (a, b) = (camera(projection, None), camera(projection, Some(lens)));
            for i in 0..100u32 {
                let u = Vec2::new(i as f32 * 0.01, 1.0 - i as f32 * 0.01 - 0.005);
                let (p, q) = (a.ray((i, 7), u, (100, 50), u), b.ray((i, 7), u, (100, 50), u));
                assert_eq!(p.o.to_array().map(f32::to_bits), q.o.to_array().map(f32::to_bits));
                assert_eq!(p.d.to_array().map(f32::to_bits), q.d.to_array().map(f32::to_bits));
            }
        }
    }

    #[test]
    fn the_frame_is_whole_in_every_size() {
        for (projection, aspect) in [
            (Projection::Perspective { tan_half: 0.5 }, 2.0),
            (Projection::Orthographic { half_height: 3.0 }, 0.7),
        ] {
            let frame = Camera { aspect: Some(aspect), ..camera(projection, None) };
            let half = |c: &Camera| match c.projection {
                Projection::Perspective { tan_half: h } | Projection::Orthographic { half_height: h } => h,
            };
            for size in [(200, 100), (100, 100), (100, 500), (500, 100), (70, 100)] {
                let fitted = frame.clone().fitted(size);
                let (high, wide) = (half(&fitted), half(&fitted) * size.0 as f32 / size.1 as f32);
                let (least_high, least_wide) = (half(&frame), half(&frame) * aspect);
                assert!(high >= least_high * 0.9999 && wide >= least_wide * 0.9999, "{size:?}");
                assert!(
                    high < least_high * 1.0001 || wide < least_wide * 1.0001,
                    "{size:?}: no smaller than need be"
                );
            }
            assert_eq!(frame.clone().fitted(((aspect * 99.0).round() as u32, 99)).projection, projection);
            let free = camera(projection, None);
            assert_eq!(free.clone().fitted((10, 1000)).projection, projection);
        }
    }

    #[test]
    fn rays_end_at_the_far_plane_and_know_the_near_one() {
        let clip = Some(Clip { near: 2.0, far: 5.0 });
        for projection in [
            Projection::Perspective { tan_half: 0.8 },
            Projection::Orthographic { half_height: 2.0 },
            Projection::Perspective { tan_half: 1e-7 },
        ] {
            for lens in [None, Some(Lens { aperture: Aperture::Disk, radius: 0.3, focus_distance: 3.0 })] {
                let c = Camera { clip, ..camera(projection, lens) };
                for i in 0..50u32 {
                    let ray =
                        c.ray((i, 7 * i % 50), Vec2::splat(0.3), (50, 50), Vec2::new(0.9, 0.02 * i as f32));
                    assert!((ray.at(c.near(&ray)).z + 2.0).abs() < 1e-5);
                    assert!((ray.at(ray.t_max).z + 5.0).abs() < 1e-5);
                }
            }
        }
        let open = camera(Projection::Perspective { tan_half: 0.8 }, None);
        let ray = open.ray((1, 2), Vec2::ZERO, (9, 9), Vec2::ZERO);
        assert_eq!((open.near(&ray), ray.t_max), (0.0, f32::INFINITY));
    }

    #[test]
    fn mirrored_transforms_look_the_same_way_upright() {
        let turned = DMat3::from_rotation_y(0.4) * DMat3::from_rotation_x(-0.3);
        for mirror in [DVec3::new(-2.0, 2.0, 2.0), DVec3::new(3.0, -1.0, 2.0), DVec3::splat(5.0)] {
            let (right, up, backward) = axes(&(turned * DMat3::from_diagonal(mirror))).unwrap();
            let off =
                (right - turned.x_axis).abs() + (up - turned.y_axis).abs() + (backward - turned.z_axis).abs();
            assert!(off.max_element() < 1e-12, "{mirror}");
        }
        // Straight down there is no top: the rounding of either sign decides nothing.
        for tilt in [-1e-8, 1e-8] {
            let down = DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2 + tilt);
            let (right, up, _) = axes(&(down * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)))).unwrap();
            assert!(
                (right - DVec3::X).length() < 1e-6 && (up - DVec3::NEG_Z).length() < 1e-6,
                "{right} {up}"
            );
        }
        // Upside down, but not mirrored.
        let (_, up, _) = axes(&DMat3::from_rotation_z(3.0)).unwrap();
        assert!(up.y < -0.9);
    }

    #[test]
    fn one_axis_follows_from_the_two_others() {
        let turned = DMat3::from_rotation_y(0.4) * DMat3::from_rotation_x(-0.3);
        for lost in 0..3 {
            let mut scale = DVec3::new(2.0, 0.5, 3.0);
            scale[lost] = 0.0;
            let (right, up, backward) = axes(&(turned * DMat3::from_diagonal(scale))).unwrap();
            let off = DMat3::from_cols(right, up, backward) - turned;
            assert!(off.to_cols_array().iter().all(|x| x.abs() < 1e-12), "{lost}: {off}");
        }
        for scale in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
            assert!(axes(&DMat3::from_diagonal(scale)).is_none(), "{scale}");
        }
    }
}
