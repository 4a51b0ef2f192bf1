//! Perspective and orthographic cameras: rays through points of the image.
//!
//! Conventions: the camera looks along −z of its frame with +y up (glTF); pixels are square; the height of the image
//! spans the vertical field of view and its width follows from the size in pixels; film coordinates start at the top
//! left.
use crate::Lens;
use crate::precise::{NARROW, film_plane, finest};
use crate::view::{Rayx, View};
use dapple_math::lanes::{MAX_LANES, Real, Vec2x, Vec3x, Word};
use dapple_math::{Motion, Ray};
use glam::{DMat3, DVec2, DVec3, Vec2, Vec3};
use std::sync::Arc;

/// The projection of the film plane into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective projection, where yfov is the angle that the image height spans.
    Perspective {
        /// tan(yfov/2), > 0.
        tan_half: f32,
    },
    /// Orthographic projection with parallel rays.
    Orthographic {
        /// Half height of the view in scene units; glTF's `ymag`.
        half_height: f32,
    },
}

/// A camera that looks along −z of its frame, with +y up (glTF), in render-space units.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Position of the pinhole or lens centre. Like the axes, it is that at the time when the shutter opens.
    pub origin: Vec3,
    /// Unit +x axis of the frame.
    pub right: Vec3,
    /// Unit +y axis of the frame.
    pub up: Vec3,
    /// Unit +z axis of the frame, which points away from the scene.
    pub backward: Vec3,
    /// Perspective or orthographic projection.
    pub projection: Projection,
    /// Thin lens, or `None` for a pinhole.
    pub lens: Option<Lens>,
    /// Motion from camera space to render space while the shutter is open, whose scale and shear are ignored. `None` if
    /// the camera does not move.
    pub motion: Option<Arc<Motion>>,
    /// Width / height of the frame that has to be visible entirely (see [`Camera::fitted`]). If `None`, only the height
    /// is given.
    pub aspect: Option<f32>,
    /// Near and far plane of camera rays, or `None` for no clipping.
    pub clip: Option<Clip>,
}

/// Clipping planes, as distances along the view axis from the camera's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Nearer surfaces are not visible. 0 makes everything in front of the camera visible.
    pub near: f32,
    /// Farther surfaces are not visible. May be infinite.
    pub far: f32,
}

impl Camera {
    /// Returns the camera at `time` seconds after the shutter opens. If its transform at that time has no direction of
    /// view, the position and axes of the time when the shutter opens are kept.
    pub fn at(&self, time: f32) -> Self {
        let Self { origin, right, up, backward, projection, lens, aspect, clip, .. } = *self;
        let still = Self { origin, right, up, backward, projection, lens, motion: None, aspect, clip };
        let Some(motion) = &self.motion else { return still };
        let placed = motion.at(f64::from(time));
        let Some((right, up, backward)) = axes(&placed.matrix3) else { return still };
        let (right, up, backward) = (right.as_vec3(), up.as_vec3(), backward.as_vec3());
        Self { origin: placed.translation.as_vec3(), right, up, backward, ..still }
    }

    /// Returns the camera whose image of `size` pixels contains the whole frame of its aspect ratio. An image that is
    /// narrower than the frame shows more above and below it; a wider one shows more on both sides. The projection is
    /// not changed if the frame fits to within half a pixel.
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

    /// Returns the distance of the near plane along a camera ray, in units of the length of the ray's direction. It is
    /// 0 without a near plane. `self` is the camera at the time of the ray.
    pub fn near(&self, ray: &Ray) -> f32 {
        let near = self.clip.map_or(0.0, |clip| clip.near);
        // The component of the direction along the view axis is positive, because the ray points forward.
        if near > 0.0 { near / -ray.d.dot(self.backward) } else { 0.0 }
    }

    /// Returns the ray through the point `pixel + fraction` of an image of `size` pixels (from the top left, x right, y
    /// down). It leaves the lens at the point sampled by `lens_u` in \[0,1)², and its direction is unit.
    ///
    /// `pixel` and `fraction` are separate arguments. Images with more than 8192 pixels along a side, and views with less
    /// than 1e-4 rad per pixel, are computed in f64 and rounded once, so that no jitter is lost in large images and every
    /// pixel of a narrow view has its own direction. `fraction` may lie
    /// outside \[0,1) (wide filters). A rotated frame still rounds each direction component to 2⁻²⁴: below 6e-8 rad per
    /// pixel only a camera aligned with the axes of render space resolves every pixel, because small components keep
    /// their precision.
    ///
    /// With a lens, all rays of one film point meet in the plane at `focus_distance` along the view axis, to the
    /// precision of f32: the lens point divided by the focus distance is subtracted from the pinhole direction (x, y,
    /// −1), instead of multiplying the direction by the focus distance, which stays accurate for a focus of 1e9 and
    /// includes infinity. For radius 0 the ray is that of the pinhole to the last bit.
    ///
    /// The ray starts at the lens and ends at the far plane. [`Camera::near`] returns the distance of the near plane.
    #[inline]
    pub fn ray(&self, pixel: (u32, u32), fraction: Vec2, size: (u32, u32), lens_u: Vec2) -> Ray {
        let view = self.view(size);
        if !view.is_plain() {
            return self.exact_ray(pixel, fraction, size, lens_u);
        }
        let ray = self.plain_rays::<f32>(&view, pixel.into(), fraction.into(), lens_u.into());
        Ray { o: ray.o.into(), d: ray.d.into(), t_max: ray.t_max }
    }

    /// Returns one ray per lane, as [`Camera::ray`] does.
    #[inline(always)]
    pub fn rays<R: Real>(
        &self,
        pixel: [R::Word; 2],
        fraction: Vec2x<R>,
        size: (u32, u32),
        lens_u: Vec2x<R>,
    ) -> Rayx<R> {
        let view = self.view(size);
        if !view.is_plain() {
            return self.rays_by_lane(pixel, fraction, size, lens_u);
        }
        self.plain_rays(&view, pixel, fraction, lens_u)
    }

    #[inline(always)]
    fn plain_rays<R: Real>(
        &self,
        view: &View,
        pixel: [R::Word; 2],
        fraction: Vec2x<R>,
        lens_u: Vec2x<R>,
    ) -> Rayx<R> {
        match self.open_lens() {
            Some(lens) => view.ray(pixel, fraction, Some(lens.point_lanes(lens_u))),
            None => view.ray(pixel, fraction, None),
        }
    }

    /// Returns the lens, if it has an area.
    #[inline(always)]
    fn open_lens(&self) -> Option<Lens> {
        self.lens.filter(|lens| cfg!(not(without = "lens")) && lens.radius > 0.0)
    }

    #[inline(always)]
    fn view(&self, size: (u32, u32)) -> View {
        let half = [size.0 as f32 * 0.5, size.1.max(1) as f32 * 0.5];
        let (slope, spacing) = match self.projection {
            Projection::Perspective { tan_half } => (tan_half / half[1], 0.0),
            Projection::Orthographic { half_height } => (0.0, half_height / half[1]),
        };
        View {
            origin: self.origin,
            right: self.right,
            up: self.up,
            backward: self.backward,
            half,
            slope,
            spacing,
            lens_radius: self.lens.map_or(0.0, |lens| lens.radius),
            inverse_focus: self.lens.map_or(0.0, |lens| lens.inverse_focus() as f32),
            far: self.clip.map_or(f32::INFINITY, |clip| clip.far),
        }
    }

    /// Computes the rays of delicate images one by one in f64.
    #[inline(always)]
    fn rays_by_lane<R: Real>(
        &self,
        pixel: [R::Word; 2],
        fraction: Vec2x<R>,
        size: (u32, u32),
        lens_u: Vec2x<R>,
    ) -> Rayx<R> {
        let mut lanes = Lanes { pixel: [[0; MAX_LANES]; 2], u: [[0.0; MAX_LANES]; 4] };
        pixel[0].store(&mut lanes.pixel[0]);
        pixel[1].store(&mut lanes.pixel[1]);
        fraction.x.store(&mut lanes.u[0]);
        fraction.y.store(&mut lanes.u[1]);
        lens_u.x.store(&mut lanes.u[2]);
        lens_u.y.store(&mut lanes.u[3]);
        let [a, b, c, d, e, f, t_max] = self.exact_rays(&lanes, R::LANES, size);
        let (o, d) = (Vec3x::load([&a, &b, &c]), Vec3x::load([&d, &e, &f]));
        Rayx { o, d, t_max: R::load(&t_max) }
    }

    /// Returns origins, directions and ends of `count` rays, a column per number.
    #[cold]
    #[inline(never)]
    fn exact_rays(&self, lanes: &Lanes, count: usize, size: (u32, u32)) -> [[f32; MAX_LANES]; 7] {
        let mut rays = [[0.0; MAX_LANES]; 7];
        for i in 0..count {
            let ([x, y], [a, b, c, d]) = (lanes.pixel.map(|from| from[i]), lanes.u.map(|from| from[i]));
            let ray = self.exact_ray((x, y), Vec2::new(a, b), size, Vec2::new(c, d));
            let numbers = [ray.o.x, ray.o.y, ray.o.z, ray.d.x, ray.d.y, ray.d.z, ray.t_max];
            rays.iter_mut().zip(numbers).for_each(|(column, x)| column[i] = x);
        }
        rays
    }

    /// Returns the ray computed in f64 and rounded once.
    fn exact_ray(&self, pixel: (u32, u32), fraction: Vec2, size: (u32, u32), lens_u: Vec2) -> Ray {
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
        let Some(lens) = self.open_lens() else { return self.ray_from(film, tilt, step) };
        let on_lens = lens.point(lens_u).as_dvec2();
        self.ray_from(film + on_lens, tilt - on_lens * lens.inverse_focus(), step)
    }

    /// Returns the ray from the point `offset` of the lens plane along (tilt.x, tilt.y, −1), both in the camera's
    /// frame. `step` is the distance between pixels in units of `tilt`.
    #[inline]
    fn ray_from(&self, offset: DVec2, tilt: DVec2, step: f64) -> Ray {
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
            // A unit distance along the view axis is `length` along the ray.
            Some(Clip { far, .. }) if far < f32::INFINITY => {
                ray.until((f64::from(far) * length / f64::from(ray.d.length())) as f32)
            }
            _ => ray,
        }
    }
}

/// Pixels, fractions and lens numbers of rays, a column per coordinate.
struct Lanes {
    pixel: [[u32; MAX_LANES]; 2],
    u: [[f32; MAX_LANES]; 4],
}

/// Returns the unit right, up and backward axes of a transform without its scale, shear and reflection, or None when it
/// has no direction of view. The direction of view is kept. One axis of length zero is derived from the two others. A
/// reflection can be undone by flipping x or y: the choice is the one with the top of the view towards +y, and x for a
/// view straight up or down, so that the result does not depend on rounding.
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

/// Largest |y| of a unit vector that counts as horizontal within the rounding of f32.
const LEVEL: f64 = 1e-6;

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
                    "{size:?}: the view is larger than necessary"
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
        // A view straight down has no top, so that rounding of either sign must not change the result.
        for tilt in [-1e-8, 1e-8] {
            let down = DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2 + tilt);
            let (right, up, _) = axes(&(down * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)))).unwrap();
            assert!(
                (right - DVec3::X).length() < 1e-6 && (up - DVec3::NEG_Z).length() < 1e-6,
                "{right} {up}"
            );
        }
        // A camera that is upside down without a reflection stays upside down.
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
