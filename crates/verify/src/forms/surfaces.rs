//! Closed-form scenes E1 to E5, E8, E17, E18: irradiance of a floor.

use super::form::Form;
use crate::closed_form::{parallel_disk, parallel_rectangle, perpendicular_rectangle, polygon, sphere};
use crate::scenes::{irradiance_meter, matte, quad};
use dapple_integrator::Effect;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::Image;
use dapple_integrator::lights::Environment;
use dapple_integrator::scene::{Scene, SceneBuilder, SceneError};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// Radiance of every light in these scenes.
const L: f64 = 2.0;

const LIGHT: &[Effect] = &[Effect::Light];
const SKY: &[Effect] = &[Effect::Light, Effect::Diffuse];

fn lit(light: impl FnOnce(&mut SceneBuilder, u32) -> u32) -> Result<Scene, SceneError> {
    let mut builder = irradiance_meter();
    let bright = builder.material(matte(0.0, L as f32));
    light(&mut builder, bright);
    builder.build()
}

pub(super) fn forms() -> Result<Vec<Form>, SceneError> {
    let mut all = vec![rectangle()?, wall()?, triangle()?, disk()?, ball()?, penumbra()?];
    all.extend([half_sky()?, gradient()?]);
    Ok(all)
}

/// A scene with the error bound of its grid: each factor of cosθ·cosθ'/d² rises and falls at most once along a line of
/// the light, so that the error of n midpoints is at most its largest value over n, on both axes; `most` is the area
/// times that value.
fn lamp(id: &'static str, title: &'static str, scene: Scene, exact: f64, most: f64) -> Form {
    Form { grid: Some(4.0 * L * most * FRAC_1_PI), ..Form::new(id, title, scene, L * exact, LIGHT) }
}

fn rectangle() -> Result<Form, SceneError> {
    let above = quad(Vec3::new(-0.7, 0.9, -0.5), Vec3::X * 0.8, Vec3::Z * 0.9);
    let scene = lit(|b, m| b.mesh("lamp", above, DAffine3::IDENTITY, m))?;
    let exact = parallel_rectangle([-0.7, -0.5], [0.1, 0.4], 0.9);
    Ok(lamp("E1", "rectangle parallel to the floor", scene, exact, 0.72 / 0.81))
}

fn wall() -> Result<Form, SceneError> {
    let wall = quad(Vec3::new(-0.6, 0.0, 0.0), Vec3::Y * 1.1, Vec3::Z * 0.7);
    let scene = lit(|b, m| b.mesh("lamp", wall, DAffine3::IDENTITY, m))?;
    // cosθ·cosθ'/d² = cz/(c² + y² + z²)² is largest at y = 0, z = c/√3.
    let (c, z) = (0.6f64, 0.6 / 3f64.sqrt());
    let most = 1.1 * 0.7 * c * z / (c * c + z * z).powi(2);
    Ok(lamp("E2", "rectangle that stands on the floor", scene, perpendicular_rectangle(1.1, 0.7, 0.6), most))
}

/// Clips a polygon to the part above the floor; y is up.
fn clipped(corners: &[DVec3]) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        if a.y >= 0.0 {
            kept.push(a);
        }
        if (a.y < 0.0) != (b.y < 0.0) {
            kept.push(a + (b - a) * (a.y / (a.y - b.y)));
        }
    }
    kept
}

fn triangle() -> Result<Form, SceneError> {
    let corners = [Vec3::new(-0.7, -0.35, 0.2), Vec3::new(-0.5, 0.8, -0.4), Vec3::new(-0.4, 0.6, 0.7)];
    let mesh = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let scene = lit(|b, m| b.mesh("lamp", mesh, DAffine3::IDENTITY, m))?;
    let above: Vec<[f64; 3]> =
        clipped(&corners.map(|p| p.as_dvec3())).iter().map(|p| [p.x, p.z, p.y]).collect();
    Ok(Form::new("E3", "triangle that the horizon cuts", scene, L * polygon(&above), LIGHT))
}

fn disk() -> Result<Form, SceneError> {
    let scene = lit(|b, m| b.disk("lamp", DVec3::new(-0.5, 0.8, 0.0), DVec3::NEG_Y, 0.4, m))?;
    let most = std::f64::consts::PI * 0.16 / 0.64;
    Ok(lamp("E4", "disk beside the receiver", scene, parallel_disk(0.4, 0.8, 0.5), most))
}

fn ball() -> Result<Form, SceneError> {
    let (sin, cos) = 80f64.to_radians().sin_cos();
    let scene = lit(|b, m| b.sphere("lamp", DVec3::new(-sin, cos, 0.0) * 0.6, 0.4, m))?;
    Ok(Form::new("E5", "sphere that the horizon cuts", scene, L * sphere(1.5, cos), LIGHT))
}

/// A rectangular light 0.5 × 0.8 at height 1.5, and a half-plane at height 0.6 whose edge is near the receiver's
/// normal.
fn penumbra() -> Result<Form, SceneError> {
    let p = -0.07;
    let (w, l, height, edge) = (0.5f32, 0.8f32, 1.5f32, 0.6f32);
    // The camera is below the half-plane.
    let mut builder = crate::scenes::seen(DVec3::new(0.2, 0.4, 0.1), DVec3::ZERO, 1e-4);
    let white = builder.material(matte(1.0, 0.0));
    let floor = quad(Vec3::new(-0.05, 0.0, 0.05), Vec3::X * 0.1, Vec3::Z * -0.1);
    builder.mesh("floor", floor, DAffine3::IDENTITY, white);
    let bright = builder.material(matte(0.0, L as f32));
    let black = builder.material(matte(0.0, 0.0));
    // The scene is moved by −p, so that the receiver stays at the origin.
    let at = |x: f32| x - p as f32;
    let lamp = quad(Vec3::new(at(-0.5 * w), height, -0.5 * l), Vec3::X * w, Vec3::Z * l);
    builder.mesh("lamp", lamp, DAffine3::IDENTITY, bright);
    let plane = quad(Vec3::new(at(-5.0), edge, -5.0), Vec3::X * 5.0, Vec3::Z * 10.0);
    builder.mesh("half-plane", plane, DAffine3::IDENTITY, black);
    let scene = builder.build()?;
    let [w, l, height, edge] = [w, l, height, edge].map(f64::from);
    let from = (-p * (height - edge) / edge).clamp(-0.5 * w, 0.5 * w);
    let exact = parallel_rectangle([from - p, -0.5 * l], [0.5 * w - p, 0.5 * l], height);
    Ok(lamp_in_shadow(scene, exact, w * l / (height * height)))
}

fn lamp_in_shadow(scene: Scene, exact: f64, most: f64) -> Form {
    lamp("E8", "penumbra of a straight edge", scene, exact, most)
}

fn under(value: impl Fn(usize) -> f32, rows: usize, tilt: f64) -> Result<Scene, SceneError> {
    let mut builder = crate::scenes::seen(DVec3::new(0.1, 0.8, 0.0), DVec3::ZERO, 1e-4);
    let white = builder.material(matte(1.0, 0.0));
    let floor = quad(Vec3::new(-0.05, 0.0, 0.05), Vec3::X * 0.1, Vec3::Z * -0.1);
    builder.mesh("floor", floor, DAffine3::from_rotation_x(tilt), white);
    let pixels = (0..2 * rows).map(|i| Vec3::splat(value(i / 2))).collect();
    let sky = Environment::picture(Image { width: 2, height: rows, pixels }, 0.0, 1.0, false);
    builder.environment(sky.unwrap_or(Environment::constant(Vec3::ZERO)));
    builder.build()
}

fn half_sky() -> Result<Form, SceneError> {
    let beta = 50f64.to_radians();
    let scene = under(|row| if row < 8 { 1.0 } else { 0.0 }, 16, beta)?;
    Ok(Form::new("E17", "a tilted floor under half a sky", scene, 0.5 * (1.0 + beta.cos()), SKY))
}

/// L = 1 + cosθ; each row of texels holds its mean.
fn gradient() -> Result<Form, SceneError> {
    let rows = 1024;
    let cos = |row: usize| (std::f64::consts::PI * row as f64 / rows as f64).cos();
    let scene = under(|row| (1.0 + 0.5 * (cos(row) + cos(row + 1))) as f32, rows, 0.0)?;
    Ok(Form::new("E18", "a sky that brightens towards the zenith", scene, 5.0 / 3.0, SKY))
}
