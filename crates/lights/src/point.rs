//! Point and spot lights as KHR_lights_punctual defines them. Its photometric values are read as radiometric ones, 1 cd
//! as 1 W/sr per channel.
use crate::LightSample;
use crate::falloff::falloff;
use crate::lanes::{Point as Pointx, Shone, Spot as Spotx};
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// A point light: the same intensity in all directions.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Position.
    pub p: Vec3,
    /// Intensity in W·sr⁻¹ per channel.
    pub intensity: Vec3,
    /// glTF range in render units, beyond which the light is zero; infinite for none.
    pub range: f32,
}

/// A spot light: a point light restricted to a cone with a soft edge.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Position.
    pub p: Vec3,
    /// Unit direction in which the light emits.
    pub axis: Vec3,
    /// Intensity in W·sr⁻¹ per channel inside the inner cone.
    pub intensity: Vec3,
    /// 1 − cosine of the angle at which the fall-off begins, as returned by [`Spot::height`].
    pub inner: f64,
    /// 1 − cosine of the angle at which the light ends, not less than `inner`; equal to it for a hard edge.
    pub outer: f64,
    /// glTF range in render units; infinite for none.
    pub range: f32,
}

impl Point {
    /// Irradiance on a facing surface I/d² times the range window of glTF. None at the light itself, out of range, and
    /// where the value is not finite.
    pub(crate) fn sample(&self, p: Vec3) -> Option<LightSample> {
        shone(self.lanes().sample(p.into()))
    }

    /// The light as the lanes take it.
    pub(crate) fn lanes(&self) -> Pointx<f32> {
        Pointx { p: self.p.into(), intensity: self.intensity.into(), range: self.range }
    }

    /// Power in W per channel, 4πI.
    pub(crate) fn power(&self) -> Vec3 {
        self.intensity * (2.0 * TAU) as f32
    }
}

fn shone(shone: Shone<f32>) -> Option<LightSample> {
    shone.reaches.then(|| LightSample {
        wi: shone.wi.into(),
        pdf: 1.0,
        delta: true,
        radiance: shone.irradiance.into(),
        distance: shone.distance,
        point: None,
    })
}

impl Spot {
    /// 1 − cosθ = 2·sin²(θ/2) of an angle in radians: the height of the cap that a cone of this half-angle cuts from
    /// the unit sphere. Unlike the cosine it keeps its precision at every angle.
    pub fn height(angle: f64) -> f64 {
        let sin = libm::sin(0.5 * angle);
        2.0 * sin * sin
    }

    pub(crate) fn sample(&self, p: Vec3) -> Option<LightSample> {
        shone(self.lanes().sample(p.into()))
    }

    /// The light as the lanes take it.
    pub(crate) fn lanes(&self) -> Spotx<f32> {
        let &Self { p, intensity, range, .. } = self;
        Spotx {
            point: Point { p, intensity, range }.lanes(),
            axis: self.axis.as_dvec3().normalize_or_zero().as_vec3().into(),
            inner: self.inner as f32,
            outer: self.outer as f32,
        }
    }

    /// Fraction of the intensity in the direction `d` (unit, away from the light): 1 inside the inner cone, 0 outside
    /// the outer one, between them ((cosθ − cos_outer)/(cos_inner − cos_outer))² as in KHR_lights_punctual. Differences
    /// of cosines are computed as differences of heights 1 − cosθ = |d − axis|²/2, which do not cancel, so that cones
    /// of any width have their full intensity. The minimum difference of 0.001 in the extension's sample code is not
    /// applied: it would dim every cone narrower than 2.6°.
    pub fn falloff(&self, d: DVec3) -> f64 {
        falloff(d, self.axis.as_dvec3().normalize_or_zero(), self.inner, self.outer)
    }

    /// The angle in radians at which the light ends.
    pub(crate) fn outer_angle(&self) -> f64 {
        2.0 * libm::asin((0.5 * self.outer).clamp(0.0, 1.0).sqrt())
    }

    /// Power in W per channel, I·2π∫ falloff dcos = I·2π·(h_inner + (h_outer − h_inner)/3), with the heights
    /// h = 1 − cosθ.
    pub(crate) fn power(&self) -> Vec3 {
        self.intensity * (TAU * (self.inner + (self.outer - self.inner) / 3.0)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn spot(inner: f64, outer: f64) -> Spot {
        Spot {
            p: Vec3::ZERO,
            axis: Vec3::NEG_Z,
            intensity: Vec3::ONE,
            inner: Spot::height(inner),
            outer: Spot::height(outer),
            range: f32::INFINITY,
        }
    }

    /// Direction at `angle` from the axis.
    fn at(angle: f64) -> DVec3 {
        DVec3::new(libm::sin(angle), 0.0, -libm::cos(angle))
    }

    #[test]
    fn inverse_square_and_range() {
        let light = Point { p: Vec3::new(0.0, 0.0, 2.0), intensity: Vec3::splat(8.0), range: f32::INFINITY };
        assert_eq!(light.sample(Vec3::ZERO).unwrap().radiance, Vec3::splat(2.0));
        let ranged = Point { range: 4.0, ..light };
        assert_eq!(ranged.sample(Vec3::ZERO).unwrap().radiance, Vec3::splat(2.0 * (1.0 - 1.0 / 16.0)));
        assert!(ranged.sample(Vec3::new(0.0, 0.0, -2.0)).is_none(), "out of range");
        assert!(light.sample(light.p).is_none(), "at the light");
        let near = light.sample(Vec3::new(0.0, 1e-6, 2.0)).unwrap();
        assert!(near.radiance.is_finite() && near.wi == Vec3::NEG_Y);
        assert!(light.sample(Vec3::new(0.0, 1e-30, 2.0)).is_none(), "not representable");
    }

    /// Cones from 1e-4 rad to a right angle, soft, nearly hard and hard; the integral over the angle by the midpoint
    /// rule.
    #[test]
    fn spot_power_is_the_integral_of_its_falloff() {
        for outer in [1e-4, 1e-3, 0.0175, 0.3, 1.0, PI / 2.0] {
            for share in [0.0, 0.5, 0.999, 1.0] {
                let spot = spot(outer * share, outer);
                let n = 100_000;
                let width = outer / f64::from(n);
                let ring = |i: i32| (f64::from(i) + 0.5) * width;
                let sum: f64 = (0..n).map(|i| spot.falloff(at(ring(i))) * libm::sin(ring(i))).sum();
                let power = spot.power().x as f64;
                assert!((power / (TAU * sum * width) - 1.0).abs() < 1e-5, "{outer} {share} {power}");
            }
        }
    }

    /// The intensity on the axis is the specified one for any cone, direction and distance.
    #[test]
    fn every_cone_has_its_full_intensity_on_the_axis() {
        for k in 0..=80 {
            let outer = 1e-4 * libm::pow(PI / 2.0 / 1e-4, f64::from(k) / 80.0);
            for (share, axis) in
                [(0.0, Vec3::NEG_Z), (0.5, Vec3::new(2.0, -1.0, 3.0)), (1.0, Vec3::new(-1.0, 1e-3, 0.3))]
            {
                let axis = axis.normalize();
                let spot = Spot { axis, ..spot(outer * share, outer) };
                for d in [1e-2, 1.0, 300.0] {
                    let sample = spot.sample(axis * d);
                    let seen = sample.map_or(0.0, |s| s.radiance.x * d * d);
                    assert!((seen - 1.0).abs() < 1e-4, "{outer} {share} {axis} {d}: {seen}");
                }
            }
        }
    }

    #[test]
    fn spot_is_full_inside_and_dark_outside() {
        for scale in [1.0, 1e-3] {
            let spot = spot(0.4 * scale, 0.6 * scale);
            assert_eq!((spot.falloff(at(0.3 * scale)), spot.falloff(at(0.61 * scale))), (1.0, 0.0));
            let middle = 0.5 * (spot.inner + spot.outer);
            let angle = 2.0 * libm::asin((0.5 * middle).sqrt());
            assert!((spot.falloff(at(angle)) - 0.25).abs() < 1e-5);
            assert!((spot.outer_angle() / (0.6 * scale) - 1.0).abs() < 1e-12);
            assert!(spot.sample(Vec3::new(0.0, 0.0, -2.0)).is_some());
            assert!(spot.sample(Vec3::new(0.0, 0.0, 2.0)).is_none());
        }
    }
}
