//! Rays through a still camera over lanes, in f32.

use dapple_math::lanes::{Real, Vec2x, Vec3x, Word};
use glam::Vec3;

/// One ray per lane: the points o + t·d with 0 < t < t_max.
#[derive(Clone, Copy, Debug)]
pub struct Rayx<R> {
    /// Origin in render-space units.
    pub o: Vec3x<R>,
    /// Direction, unit within rounding.
    pub d: Vec3x<R>,
    /// Exclusive end of the ray.
    pub t_max: R,
}

/// A still camera with an image size, as far as rays depend on it.
#[derive(Clone, Copy, Debug)]
pub struct View {
    pub origin: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    pub backward: Vec3,
    /// Half the size of the image in pixels.
    pub half: [f32; 2],
    /// Slope of a ray per pixel; 0 for an orthographic camera.
    pub slope: f32,
    /// Distance of the origins of rays per pixel; 0 for a perspective camera.
    pub spacing: f32,
    /// Size of the lens; 0 for a pinhole.
    pub lens_radius: f32,
    /// 1/focus, and 0 for infinity.
    pub inverse_focus: f32,
    /// Distance of the far plane along the view axis.
    pub far: f32,
}

/// The slope per pixel below which directions in f32, whose error is up to 3e-7, are not accurate enough.
const LEAST_SLOPE: f32 = 1e-4;

/// A slope per pixel, or of the edge of a lens, with which no square overflows.
const LARGEST_SLOPE: f32 = 1e12;

/// Half of the largest side of an image in which a fraction in f32 keeps 2⁻¹¹ of a pixel.
const LARGEST_HALF: f32 = 4096.0;

impl View {
    /// Whether f32 is accurate enough for all rays of the image: for 1/300 pixel, and without overflow. NaN are not.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        // The slope of an orthographic camera is 0.
        (self.slope >= LEAST_SLOPE || self.spacing != 0.0)
            && self.slope < LARGEST_SLOPE
            && self.half[0].max(self.half[1]) <= LARGEST_HALF
            && self.lens_radius * self.inverse_focus < LARGEST_SLOPE
    }

    /// Returns the ray through `pixel + fraction`, pixel < 2³¹, from a point of the lens, or from its centre if there is none.
    #[inline(always)]
    pub fn ray<R: Real>(
        &self,
        pixel: [R::Word; 2],
        fraction: Vec2x<R>,
        on_lens: Option<Vec2x<R>>,
    ) -> Rayx<R> {
        let x = (pixel[0].int_to_real() - R::splat(self.half[0])) + fraction.x;
        let y = (R::splat(self.half[1]) - pixel[1].int_to_real()) - fraction.y;
        let place = Vec2x::new(x, y);
        let (mut offset, mut tilt) = (place * R::splat(self.spacing), place * R::splat(self.slope));
        if let Some(on_lens) = on_lens {
            offset = offset + on_lens;
            tilt = tilt - on_lens * R::splat(self.inverse_focus);
        }
        let (right, up) = (Vec3x::splat(self.right), Vec3x::splat(self.up));
        let d = right * tilt.x + up * tilt.y - Vec3x::splat(self.backward);
        let length = d.length();
        let mut o = Vec3x::splat(self.origin);
        if self.spacing != 0.0 || on_lens.is_some() {
            o += right * offset.x + up * offset.y;
        }
        // A unit distance along the view axis is `length` along the ray.
        let t_max = if self.far < f32::INFINITY { R::splat(self.far) * length } else { R::splat(self.far) };
        Rayx { o, d: d / length, t_max }
    }
}
