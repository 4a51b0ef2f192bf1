//! Conversion of point, spot and distant lights from world to render space.
//!
//! Units are radiometric, per channel: W/sr and W/m² (see [`crate::light_unit`] for those of files). Irradiance I/d²
//! does not depend on the unit of length, so I is multiplied by scale² in render space.
use crate::{Space, WorldPoint, exposure::Exposure};
use dapple_lights::{Distant, Light, Moving, Point, Spot};
use dapple_math::motion::Chain;
use glam::{DVec3, Vec3};

#[derive(Clone, Copy, Debug)]
pub(crate) enum Punctual {
    Point { p: DVec3, intensity: Vec3, range: f64 },
    Spot { p: DVec3, axis: DVec3, intensity: Vec3, range: f64, inner: f64, outer: f64 },
    Distant { towards: DVec3, irradiance: Vec3 },
}

/// Converts all lights that are not black; those with a chain move along it. The error is the index of an invalid light
/// and a description of the problem.
pub(crate) fn lights(
    all: &[(Punctual, Option<Chain>)],
    space: &Space,
    exposure: &Exposure,
) -> Result<Vec<Light>, (usize, &'static str)> {
    let mut lights = Vec::with_capacity(all.len());
    for (i, (light, chain)) in all.iter().enumerate() {
        let light = match chain {
            None => light.to_render(space),
            Some(chain) => light.to_render_moving(chain, space, exposure),
        };
        lights.extend(light.map_err(|what| (i, what))?);
    }
    Ok(lights)
}

impl Punctual {
    /// Divides the intensity or irradiance by `by`.
    #[cfg(feature = "gltf")]
    pub(crate) fn divide(&mut self, by: f32) {
        match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => *intensity /= by,
            Self::Distant { irradiance, .. } => *irradiance /= by,
        }
    }

    fn to_render(self, space: &Space) -> Result<Option<Light>, &'static str> {
        self.strengths(space)?.map_or(Ok(None), |strength| {
            let p = |p| place(space.to_render(WorldPoint(p)));
            self.light(strength, p).map(Some)
        })
    }

    /// Converts a light on a chain; its position and direction stay in the space at the end of the chain.
    fn to_render_moving(
        self,
        chain: &Chain,
        space: &Space,
        exposure: &Exposure,
    ) -> Result<Option<Light>, &'static str> {
        let Some(strength) = self.strengths(space)? else { return Ok(None) };
        let light = self.light(strength, |p| place(p.as_vec3()))?;
        let (motion, seconds) = (exposure.motion(chain, space), exposure.shutter.seconds());
        let is_moving = exposure.is_moving(&motion);
        let moving = match light {
            Light::Point(l) => Moving::point(l, motion, seconds),
            Light::Spot(l) => Moving::spot(l, motion, seconds),
            Light::Distant(l) => Moving::distant(l, motion, seconds),
            other => return Ok(Some(other)),
        };
        if is_moving { Ok(Some(Light::Moving(Box::new(moving)))) } else { Ok(moving.at(0.0)) }
    }

    /// Intensity (or irradiance) and range in render units; None for a black light.
    fn strengths(self, space: &Space) -> Result<Option<(Vec3, f32)>, &'static str> {
        let (strength, range) = match self {
            Self::Point { intensity, range, .. } | Self::Spot { intensity, range, .. } => (intensity, range),
            Self::Distant { irradiance, .. } => (irradiance, f64::INFINITY),
        };
        if !(strength.is_finite() && strength.min_element() >= 0.0) {
            return Err("its intensity must be finite and not negative");
        }
        let range = reach(range, space)?;
        let per_area = |intensity: Vec3| (intensity.as_dvec3() * (space.scale * space.scale)).as_vec3();
        let in_render_units = if let Self::Distant { .. } = self { strength } else { per_area(strength) };
        Ok((strength != Vec3::ZERO).then_some((in_render_units, range)))
    }

    fn light(
        self,
        (strength, range): (Vec3, f32),
        place: impl Fn(DVec3) -> Result<Vec3, &'static str>,
    ) -> Result<Light, &'static str> {
        Ok(match self {
            Self::Point { p, .. } => Light::Point(Point { p: place(p)?, intensity: strength, range }),
            Self::Spot { p, axis, inner, outer, .. } => {
                let right_angle = std::f64::consts::FRAC_PI_2;
                if !(0.0 <= inner && inner <= outer && outer <= right_angle) {
                    return Err("its cone needs 0 ≤ inner ≤ outer ≤ 90 degrees");
                }
                Light::Spot(Spot {
                    p: place(p)?,
                    axis: direction(axis)?,
                    intensity: strength,
                    inner: Spot::height(inner),
                    outer: Spot::height(outer),
                    range,
                })
            }
            Self::Distant { towards, .. } => {
                Light::Distant(Distant { towards: direction(towards)?, irradiance: strength })
            }
        })
    }
}

fn place(p: Vec3) -> Result<Vec3, &'static str> {
    Some(p).filter(|p| p.is_finite()).ok_or("its position is not finite or too far away")
}

fn direction(d: DVec3) -> Result<Vec3, &'static str> {
    d.try_normalize().map(DVec3::as_vec3).filter(|d| d.is_finite()).ok_or("its direction must not be zero")
}

fn reach(range: f64, space: &Space) -> Result<f32, &'static str> {
    if range > 0.0 { Ok(space.length_to_render(range)) } else { Err("its range must be above 0") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn irradiance_does_not_depend_on_the_scale() {
        let space = Space { centre: DVec3::new(3.0, 0.0, 0.0), scale: 64.0 };
        let light =
            Punctual::Point { p: DVec3::new(3.0, 2.0, 0.0), intensity: Vec3::splat(5.0), range: 10.0 };
        let Light::Point(p) = &lights(&[(light, None)], &space, &Exposure::default()).unwrap()[0] else {
            panic!()
        };
        assert_eq!(p.intensity.x / p.p.length_squared(), 5.0 / 4.0);
        assert_eq!(p.range, 640.0);
    }

    #[test]
    fn nonsense_is_named() {
        let bad = [
            Punctual::Point { p: DVec3::NAN, intensity: Vec3::ONE, range: 1.0 },
            Punctual::Point { p: DVec3::ZERO, intensity: -Vec3::ONE, range: 1.0 },
            Punctual::Point { p: DVec3::ZERO, intensity: Vec3::ONE, range: f64::NAN },
            Punctual::Distant { towards: DVec3::ZERO, irradiance: Vec3::ONE },
        ];
        for (i, light) in bad.into_iter().enumerate() {
            assert!(lights(&[(light, None)], &Space::IDENTITY, &Exposure::default()).is_err(), "{i}");
        }
        let dark = Punctual::Distant { towards: DVec3::Y, irradiance: Vec3::ZERO };
        assert!(lights(&[(dark, None)], &Space::IDENTITY, &Exposure::default()).unwrap().is_empty());
    }
}
