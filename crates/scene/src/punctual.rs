//! Point, spot and distant lights from the world to render space.
//!
//! Units as in KHR_lights_punctual with photometric numbers read as radiometric ones, per channel: 1 cd is 1 W/sr,
//! 1 lx is 1 W/m². Irradiance I/d² does not depend on the unit of length, so I goes to render space times scale².
use crate::Space;
use dapple_lights::{Distant, Light, Point, Spot};
use glam::{DVec3, Vec3};

#[derive(Clone, Copy, Debug)]
pub(crate) enum Punctual {
    Point { p: DVec3, intensity: Vec3, range: f64 },
    Spot { p: DVec3, axis: DVec3, intensity: Vec3, range: f64, inner: f64, outer: f64 },
    Distant { towards: DVec3, irradiance: Vec3 },
}

/// The lights that shine; or the index of a bad one and what is wrong with it.
pub(crate) fn lights(all: &[Punctual], space: &Space) -> Result<Vec<Light>, (usize, &'static str)> {
    let mut lights = Vec::with_capacity(all.len());
    for (i, light) in all.iter().enumerate() {
        lights.extend(light.to_render(space).map_err(|what| (i, what))?);
    }
    Ok(lights)
}

impl Punctual {
    fn to_render(self, space: &Space) -> Result<Option<Light>, &'static str> {
        let strength = match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Distant { irradiance, .. } => irradiance,
        };
        if !(strength.is_finite() && strength.min_element() >= 0.0) {
            return Err("its intensity must be finite and not negative");
        }
        let per_area = |intensity: Vec3| (intensity.as_dvec3() * (space.scale * space.scale)).as_vec3();
        let light = match self {
            Self::Point { p, intensity, range } => Light::Point(Point {
                p: place(p, space)?,
                intensity: per_area(intensity),
                range: reach(range, space)?,
            }),
            Self::Spot { p, axis, intensity, range, inner, outer } => {
                let right_angle = std::f64::consts::FRAC_PI_2;
                if !(0.0 <= inner && inner <= outer && outer <= right_angle) {
                    return Err("its cone needs 0 ≤ inner ≤ outer ≤ 90 degrees");
                }
                Light::Spot(Spot {
                    p: place(p, space)?,
                    axis: direction(axis)?,
                    intensity: per_area(intensity),
                    cos_inner: libm::cos(inner) as f32,
                    cos_outer: libm::cos(outer) as f32,
                    range: reach(range, space)?,
                })
            }
            Self::Distant { towards, irradiance } => {
                Light::Distant(Distant { towards: direction(towards)?, irradiance })
            }
        };
        Ok((strength != Vec3::ZERO).then_some(light))
    }
}

fn place(p: DVec3, space: &Space) -> Result<Vec3, &'static str> {
    Some(space.to_render(p)).filter(|p| p.is_finite()).ok_or("it is not at a place that numbers can express")
}

fn direction(d: DVec3) -> Result<Vec3, &'static str> {
    d.try_normalize().map(DVec3::as_vec3).filter(|d| d.is_finite()).ok_or("it has no direction")
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
        let Light::Point(p) = &lights(&[light], &space).unwrap()[0] else { panic!() };
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
            assert!(lights(&[light], &Space::IDENTITY).is_err(), "{i}");
        }
        let dark = Punctual::Distant { towards: DVec3::Y, irradiance: Vec3::ZERO };
        assert!(lights(&[dark], &Space::IDENTITY).unwrap().is_empty());
    }
}
