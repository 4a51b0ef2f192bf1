//! Environment lights: a constant or an environment map in latitude–longitude layout, importance-sampled with MIS
//! compensation.
//!
//! World direction d maps to u = ½ + atan2(d.x, −d.z)/2π, v = acos(d.y)/π of the map, v from the top row: the centre of
//! the map is −Z and u grows towards +X. A texel is a constant patch unless filtering is enabled. `rotation` rotates
//! the environment about +Y by the right-hand rule: what was at −Z moves towards −X.
use crate::lat_long::LatLong;
use crate::{LightSample, lanes};
use dapple_math::Image;
use dapple_math::lanes::{Real, Vec2x, Vec3x};
use glam::{Vec2, Vec3};
use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

/// Incident radiance as a function of direction. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Environment(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Constant(Vec3),
    LatLong(Arc<LatLong>),
}

impl Environment {
    /// An environment with the same radiance in every direction. It is never sampled directly.
    pub fn constant(radiance: Vec3) -> Self {
        Self(Kind::Constant(radiance))
    }

    /// An environment map: u = ½ + atan2(d.x, −d.z)/2π, v = acos(d.y)/π from the top row. Texels are constant patches
    /// unless `filtered`, which interpolates bilinearly between texel centres, wraps at the seam, and clamps beyond the
    /// centres of the first and last row. `rotation` is in radians about +Y; `intensity` is a factor. A texel that is
    /// negative or not finite, before or after multiplication, is an error that names it. A map of one colour becomes
    /// [`Environment::constant`]; an empty one is black.
    pub fn picture(picture: Image, rotation: f32, intensity: f32, filtered: bool) -> Result<Self, BadTexel> {
        let Image { width, height, mut pixels } = picture;
        pixels.truncate(width.saturating_mul(height));
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let value = *pixel;
            *pixel *= intensity;
            if !(pixel.is_finite() && pixel.min_element() >= 0.0) {
                return Err(BadTexel { x: i % width, y: i / width, value });
            }
        }
        let first = pixels.first().copied().unwrap_or(Vec3::ZERO);
        if pixels.len() < width.saturating_mul(height) || pixels.iter().all(|p| *p == first) {
            return Ok(Self::constant(first));
        }
        let turns = rotation as f64 / TAU;
        let shift = if turns.is_finite() { turns - turns.floor() } else { 0.0 };
        Ok(Self(Kind::LatLong(Arc::new(LatLong::new((width, height), pixels, shift, filtered)))))
    }

    /// The same environment, sampled in proportion to its full radiance, so that light sampling alone is an unbiased
    /// estimator. By default only the radiance above the mean is sampled, and the rest is left to BSDF sampling [Karlík
    /// 2019].
    pub fn without_compensation(self) -> Self {
        match &self.0 {
            Kind::Constant(_) => self,
            Kind::LatLong(map) => Self(Kind::LatLong(Arc::new(map.without_compensation()))),
        }
    }

    /// Radiance from the unit direction `d`.
    #[inline]
    pub fn radiance(&self, d: Vec3) -> Vec3 {
        match &self.0 {
            Kind::Constant(radiance) => *radiance,
            Kind::LatLong(map) => map.radiance::<f32>(d.into()).into(),
        }
    }

    /// Radiance from the unit directions `d`, and [`Environment::pdf`] there.
    #[inline(always)]
    pub fn radiance_and_pdf<R: Real>(&self, d: Vec3x<R>) -> (Vec3x<R>, R) {
        match &self.0 {
            Kind::Constant(radiance) => (Vec3x::splat(*radiance), R::splat(0.0)),
            Kind::LatLong(map) => map.radiance_and_pdf(d),
        }
    }

    /// Samples per lane, as [`Environment::sample`] does.
    #[inline(always)]
    pub(crate) fn sample_lanes<R: Real>(&self, u: Vec2x<R>) -> lanes::Sample<R> {
        match &self.0 {
            Kind::Constant(_) => lanes::Sample::none(),
            Kind::LatLong(map) => map.sample(u),
        }
    }

    /// Densities per lane, as [`Environment::pdf`] gives them.
    #[inline(always)]
    pub(crate) fn pdf_lanes<R: Real>(&self, wi: Vec3x<R>) -> R {
        match &self.0 {
            Kind::Constant(_) => R::splat(0.0),
            Kind::LatLong(map) => map.pdf(wi),
        }
    }

    /// Whether the radiance is the same in every direction.
    pub fn is_constant(&self) -> bool {
        matches!(self.0, Kind::Constant(_))
    }

    /// Whether light sampling is of use (a constant environment is left to BSDF sampling).
    pub fn is_sampled(&self) -> bool {
        matches!(&self.0, Kind::LatLong(map) if map.table.is_some())
    }

    /// Whether only the radiance above the mean is sampled (see [`Environment::without_compensation`]).
    pub fn is_compensated(&self) -> bool {
        matches!(&self.0, Kind::LatLong(map) if map.compensated)
    }

    /// Mean radiance over the sphere: ∫L dω/4π. *Approximation* with filtering: solid angle is assumed to be uniform
    /// within a texel; the value only affects the probabilities of selection.
    pub fn mean(&self) -> Vec3 {
        match &self.0 {
            Kind::Constant(radiance) => *radiance,
            Kind::LatLong(map) => map.mean,
        }
    }

    /// Samples a direction with `u` in \[0,1)². None if there is nothing to sample.
    pub fn sample(&self, u: Vec2) -> Option<LightSample> {
        let sample = self.sample_lanes::<f32>(u.into());
        (sample.pdf > 0.0).then_some(LightSample {
            wi: sample.wi.into(),
            pdf: sample.pdf,
            delta: false,
            radiance: sample.radiance.into(),
            distance: f32::INFINITY,
            point: None,
        })
    }

    /// Solid-angle density of `sample` at the unit direction `wi`; 0 if there is nothing to sample.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        self.pdf_lanes::<f32>(wi.into())
    }

    /// Memory use in bytes of texels and tables.
    pub fn memory_bytes(&self) -> usize {
        match &self.0 {
            Kind::Constant(_) => 0,
            Kind::LatLong(map) => map.memory_bytes(),
        }
    }
}

/// An invalid texel of an environment map: negative, infinite or not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BadTexel {
    /// Column from the left.
    pub x: usize,
    /// Row from the top.
    pub y: usize,
    /// Value of the texel in the image.
    pub value: Vec3,
}
impl fmt::Display for BadTexel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { x, y, value } = self;
        write!(
            f,
            "texel ({x}, {y}) of the environment is {value}: every texel must be finite and not negative, \
             also after multiplication by the intensity"
        )
    }
}
impl std::error::Error for BadTexel {}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Image {
        let pixels = (0..width * height).map(|i| Vec3::splat(f(i % width, i / width))).collect();
        Image { width, height, pixels }
    }

    #[test]
    fn directions_meet_the_texels_they_should() {
        let numbered = |rotation| {
            Environment::picture(picture(4, 2, |x, y| (y * 4 + x) as f32), rotation, 1.0, false).unwrap()
        };
        let env = numbered(0.0);
        let at = |env: &Environment, x: f32, y: f32, z: f32| env.radiance(Vec3::new(x, y, z).normalize()).x;
        assert_eq!(at(&env, 0.1, 0.1, -1.0), 2.0, "−Z is the centre, and +X is to its right");
        assert_eq!(at(&env, 1.0, 0.1, 0.1), 3.0);
        assert_eq!(at(&env, -1.0, -0.1, -0.1), 5.0);
        assert_eq!(at(&env, -0.1, 1.0, 0.1), 0.0);
        // A quarter turn: what was at −Z is now at −X.
        let turned = numbered(std::f32::consts::FRAC_PI_2);
        assert_eq!(at(&turned, -1.0, 0.1, -0.1), at(&env, 0.1, 0.1, -1.0));
        for pole in [Vec3::Y, Vec3::NEG_Y, Vec3::NAN] {
            assert!(env.radiance(pole).is_finite() && env.pdf(pole).is_finite());
        }
    }

    #[test]
    fn bad_texels_are_named() {
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            let p = picture(4, 3, |x, y| if (x, y) == (2, 1) { bad } else { 1.0 });
            let error = Environment::picture(p, 0.0, 1.0, false).unwrap_err();
            assert_eq!((error.x, error.y), (2, 1));
            assert!(error.to_string().contains("(2, 1)"));
        }
        assert!(Environment::picture(picture(2, 2, |_, _| 1e30), 0.0, 1e30, false).is_err());
    }

    #[test]
    fn one_colour_is_constant_and_empty_is_black() {
        let env = Environment::picture(picture(8, 4, |_, _| 3.0), 1.0, 2.0, false).unwrap();
        assert!(env.is_constant() && !env.is_sampled());
        assert_eq!((env.mean(), env.pdf(Vec3::Y)), (Vec3::splat(6.0), 0.0));
        assert!(env.sample(Vec2::splat(0.5)).is_none());
        let empty = Environment::picture(picture(0, 0, |_, _| 0.0), 0.0, 1.0, false).unwrap();
        assert_eq!(empty.radiance(Vec3::X), Vec3::ZERO);
    }

    #[test]
    fn filtering_meets_the_texels_at_their_centres_and_wraps() {
        let env = Environment::picture(picture(8, 4, |x, y| (x + 8 * y) as f32), 0.0, 1.0, true).unwrap();
        let at = |x: f32, y: f32| {
            let (phi, theta) = (TAU as f32 * (x / 8.0 - 0.5), TAU as f32 * (0.5 * y / 4.0));
            let sin = libm::sinf(theta);
            env.radiance(Vec3::new(sin * libm::sinf(phi), libm::cosf(theta), -sin * libm::cosf(phi))).x
        };
        let cases = [
            (3.5, 2.5, 19.0),
            (3.0, 2.5, 18.5),
            (0.0, 2.5, 0.5 * (16.0 + 23.0)),
            (8.0, 2.5, 0.5 * (16.0 + 23.0)),
            (3.5, 0.2, 3.0),
            (3.5, 3.0, 0.5 * (19.0 + 27.0)),
        ];
        for (x, y, expected) in cases {
            assert!((at(x, y) - expected).abs() < 2e-5, "{x} {y}: {}", at(x, y));
        }
    }
}
