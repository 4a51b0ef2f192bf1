//! Point and spot lights as KHR_lights_punctual defines them; its photometric numbers are read as radiometric ones,
//! 1 cd as 1 W/sr per channel.
use crate::LightSample;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// The same intensity in all directions.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Position.
    pub p: Vec3,
    /// W·sr⁻¹ per channel.
    pub intensity: Vec3,
    /// glTF range in render units, beyond which there is no light; infinite = none.
    pub range: f32,
}

/// A point light through a cone with a soft edge.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Position.
    pub p: Vec3,
    /// Unit direction the light shines in.
    pub axis: Vec3,
    /// W·sr⁻¹ per channel inside the inner cone.
    pub intensity: Vec3,
    /// Cosine of the angle at which the fall-off begins.
    pub cos_inner: f32,
    /// Cosine of the angle at which the light ends.
    pub cos_outer: f32,
    /// glTF range in render units; infinite = none.
    pub range: f32,
}

impl Point {
    pub(crate) fn sample(&self, p: Vec3) -> Option<LightSample> {
        towards(self.p, p, self.intensity, self.range)
    }
    /// 4πI.
    pub(crate) fn power(&self) -> Vec3 {
        self.intensity * (2.0 * TAU) as f32
    }
}

impl Spot {
    pub(crate) fn sample(&self, p: Vec3) -> Option<LightSample> {
        let mut sample = towards(self.p, p, self.intensity, self.range)?;
        let falloff = self.falloff(-sample.wi.dot(self.axis));
        sample.radiance *= falloff;
        (falloff > 0.0).then_some(sample)
    }

    /// Scale and offset of the fall-off; the least width 0.001 of the edge is glTF's.
    fn edge(&self) -> (f32, f32) {
        let scale = 1.0 / (self.cos_inner - self.cos_outer).max(0.001);
        (scale, -self.cos_outer * scale)
    }

    /// Share of the intensity at the angle of cosine `cos` to the axis: clamp(cos·scale + offset, 0, 1)², with
    /// scale = 1/max(0.001, cos_inner − cos_outer), offset = −cos_outer·scale. (KHR_lights_punctual.)
    pub fn falloff(&self, cos: f32) -> f32 {
        let (scale, offset) = self.edge();
        let a = (cos * scale + offset).clamp(0.0, 1.0);
        a * a
    }

    /// I·2π∫ falloff dcos.
    pub(crate) fn power(&self) -> Vec3 {
        let scale = self.edge().0 as f64;
        let from_edge = 1.0 - self.cos_outer as f64;
        let soft = from_edge.min(1.0 / scale);
        let integral = scale * scale * soft * soft * soft / 3.0 + (from_edge - soft);
        self.intensity * (2.0 * PI * integral) as f32
    }
}

/// From `p` to a point light: irradiance on a facing surface I/d² times glTF's window. None at the light itself, out of
/// range, and where the value is not finite.
fn towards(light: Vec3, p: Vec3, intensity: Vec3, range: f32) -> Option<LightSample> {
    let v: DVec3 = light.as_dvec3() - p.as_dvec3();
    let d2 = v.length_squared();
    let d = d2.sqrt();
    let radiance = intensity * (window(d, range as f64) / d2) as f32;
    let reaches = d2 > 0.0 && radiance.is_finite() && radiance != Vec3::ZERO;
    reaches.then(|| LightSample {
        wi: (v / d).as_vec3(),
        pdf: 1.0,
        delta: true,
        radiance,
        distance: d as f32,
        point: None,
    })
}

/// clamp(1 − (d/range)⁴, 0, 1): the fall-off to the range recommended by KHR_lights_punctual. 1 for an infinite range.
fn window(d: f64, range: f64) -> f64 {
    let r = d / range;
    (1.0 - r * r * r * r).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(cos_inner: f32, cos_outer: f32) -> Spot {
        Spot {
            p: Vec3::ZERO,
            axis: Vec3::NEG_Z,
            intensity: Vec3::ONE,
            cos_inner,
            cos_outer,
            range: f32::INFINITY,
        }
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

    #[test]
    fn spot_power_is_the_integral_of_its_falloff() {
        for (inner, outer) in [(1.0, 0.0), (0.9, 0.5), (0.7, 0.7), (1.0, 0.99999)] {
            let spot = spot(inner, outer);
            let n = 2_000_000;
            let width = (1.0 - outer as f64) / n as f64;
            let sum: f64 =
                (0..n).map(|i| spot.falloff((outer as f64 + (i as f64 + 0.5) * width) as f32) as f64).sum();
            let power = spot.power().x as f64;
            assert!((power / (2.0 * PI * sum * width) - 1.0).abs() < 1e-2, "{inner} {outer} {power}");
        }
    }

    #[test]
    fn spot_is_full_inside_and_dark_outside() {
        let spot = spot(0.9, 0.8);
        assert_eq!((spot.falloff(0.95), spot.falloff(0.79)), (1.0, 0.0));
        assert!((spot.falloff(0.85) - 0.25).abs() < 1e-5);
        assert!(spot.sample(Vec3::new(0.0, 0.0, -2.0)).is_some());
        assert!(spot.sample(Vec3::new(0.0, 0.0, 2.0)).is_none());
    }
}
