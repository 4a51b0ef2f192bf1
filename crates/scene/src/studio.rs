//! Default environment for scenes without light: a soft studio.
//!
//! A large key light from the upper left of a viewer who looks along −Z, a weaker one from behind on the right, and
//! walls that darken towards the floor: every side of an object receives light, and no two sides the same amount, so
//! its shape is visible. The radiance at the centre of the key light is about 4, of the floor 0.25; the mean over all
//! directions is about 1.

use dapple_imaging::Image;
use dapple_lights::Environment;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Part of the warning when it is added.
pub const STUDIO: &str = "a soft studio environment is added (--env none prevents this)";

/// Width and height in texels; lookups interpolate.
const WIDTH: usize = 64;
const HEIGHT: usize = 32;

/// Radiance of floor and ceiling; in between it is linear in the y of the direction.
const FLOOR: f64 = 0.25;
const CEILING: f64 = 1.15;

/// Direction to a light, its peak radiance, added to that of the walls, and its falloff with the angle.
const LIGHTS: [(DVec3, f64, f64); 2] =
    [(DVec3::new(-0.62, 0.6, 0.5), 3.2, 7.0), (DVec3::new(0.85, 0.28, -0.45), 1.2, 9.0)];

/// Creates the studio environment.
pub fn studio() -> Environment {
    let texel = |i: usize| {
        let (x, y) = ((i % WIDTH) as f64 + 0.5, (i / WIDTH) as f64 + 0.5);
        let (phi, theta) = (TAU * (x / WIDTH as f64 - 0.5), PI * y / HEIGHT as f64);
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        Vec3::splat(radiance(DVec3::new(sin * libm::sin(phi), cos, -sin * libm::cos(phi))) as f32)
    };
    let pixels = (0..WIDTH * HEIGHT).map(texel).collect();
    let picture = Image { width: WIDTH, height: HEIGHT, pixels };
    // All texels are positive, so this does not fail.
    Environment::picture(picture, 0.0, 1.0, true).unwrap_or_else(|_| Environment::constant(Vec3::ONE))
}

/// Radiance from the unit direction `d`; +y is up.
fn radiance(d: DVec3) -> f64 {
    let walls = FLOOR + (CEILING - FLOOR) * (0.5 + 0.5 * d.y);
    let lights = LIGHTS.map(|(to, peak, fall)| peak * libm::exp(fall * (d.dot(to.normalize()) - 1.0)));
    walls + lights.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The six sides of a cube receive six different amounts of light, none of them small.
    #[test]
    fn shape_shows_from_every_side() {
        let studio = studio();
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let sides: Vec<f64> = axes.iter().flat_map(|n| [*n, -*n]).map(|n| irradiance(&studio, n)).collect();
        let most = sides.iter().copied().fold(0.0, f64::max);
        for (i, side) in sides.iter().enumerate() {
            assert!(*side > 0.2 * most, "{i}: {side} of {most}");
            for other in &sides[..i] {
                assert!((side / other - 1.0).abs() > 0.03, "{sides:?}");
            }
        }
        assert!((f64::from(studio.mean().x) - 1.0).abs() < 0.1, "{}", studio.mean());
    }

    /// Σ L·cos over a grid of directions.
    fn irradiance(studio: &Environment, n: Vec3) -> f64 {
        let mut sum = 0.0;
        for j in 0..90 {
            let theta = PI * (f64::from(j) + 0.5) / 90.0;
            for i in 0..180 {
                let phi = TAU * (f64::from(i) + 0.5) / 180.0;
                let d = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()).as_vec3();
                sum += f64::from(studio.radiance(d).x * d.dot(n).max(0.0)) * theta.sin();
            }
        }
        sum * (PI / 90.0) * (TAU / 180.0)
    }
}
