//! Closed-form scenes E6, E7, E15, E16: multiple scattering.

use super::form::Form;
use crate::closed_form::opposite_faces;
use crate::scenes::{glass, matte, of, quad, seen};
use dapple_integrator::Effect;
use dapple_integrator::camera::Projection;
use dapple_integrator::lights::Environment;
use dapple_integrator::materials::{Material, Mirror};
use dapple_integrator::scene::{CameraPose, SceneBuilder, SceneError, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;

pub(super) fn forms() -> Result<Vec<Form>, SceneError> {
    Ok(vec![faces()?, integrating_sphere()?, pane()?, mirrors()?])
}

/// The whole floor of a unit square is one pixel; the ceiling of radiance 1 is one unit above.
fn faces() -> Result<Form, SceneError> {
    let mut builder = SceneBuilder::new("check");
    let pose = CameraPose::look_at(DVec3::Y * 0.5, DVec3::ZERO, DVec3::Z, 0.1);
    builder
        .camera("camera", CameraPose { projection: Projection::Orthographic { half_height: 0.5 }, ..pose });
    let white = builder.material(matte(1.0, 0.0));
    let bright = builder.material(matte(0.0, 1.0));
    let face = |y: f32| quad(Vec3::new(-0.5, y, 0.5), Vec3::X, -Vec3::Z);
    builder.mesh("floor", face(0.0), DAffine3::IDENTITY, white);
    builder.mesh("ceiling", face(1.0), DAffine3::IDENTITY, bright);
    let exact = opposite_faces(1.0, 1.0);
    let effects = &[Effect::Pixel, Effect::Light];
    Ok(Form::new(
        "E6",
        "mean irradiance of a cube's face from the opposite one",
        builder.build()?,
        exact,
        effects,
    ))
}

/// A diffuse sphere lit by a point light inside: E = E_dir + Φ/4πR²·ρ/(1 − ρ).
fn integrating_sphere() -> Result<Form, SceneError> {
    let albedo = 0.5;
    let mut builder = seen(DVec3::new(0.1, 0.2, 0.1), DVec3::NEG_Z, 1e-4);
    let wall = builder.material(matte(albedo, 0.0));
    builder.sphere("sphere", DVec3::ZERO, 1.0, wall);
    let lamp = DVec3::new(0.3, 0.1, -0.2);
    builder.point_light(lamp, Vec3::ONE, f64::INFINITY);
    let to = lamp - DVec3::NEG_Z;
    let direct = to.normalize().z / to.length_squared();
    let rho = f64::from(albedo);
    let exact = rho / PI * (direct + rho / (1.0 - rho));
    let form = Form::new("E7", "integrating sphere", builder.build()?, exact, &[Effect::Diffuse]);
    Ok(Form { max_bounces: 24, ..form })
}

/// A clear pane in a white sky is invisible.
fn pane() -> Result<Form, SceneError> {
    let mut builder = seen(DVec3::new(1.0, 0.5, 1.0), DVec3::ZERO, 1e-3);
    let clear = builder.material(of(Material { thin: true, ..glass(1.5, 0.0) }));
    builder.mesh("pane", quad(Vec3::new(-0.5, -0.5, 0.0), Vec3::X, Vec3::Y), DAffine3::IDENTITY, clear);
    builder.environment(Environment::constant(Vec3::ONE));
    Ok(Form {
        max_bounces: 4,
        certain: true,
        ..Form::new("E15", "a clear pane in a white sky", builder.build()?, 1.0, &[])
    })
}

/// Two parallel mirrors; the visible one emits.
fn mirrors() -> Result<Form, SceneError> {
    let (first, second) = (0.8f32, 0.7f32);
    let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 1e-4);
    let mirror = |kr: f32, emission: f32| TexturedMaterial {
        emission: Vec3::splat(emission),
        ..of(Material { mirror: Some(Mirror { kr: Vec3::splat(kr), blur: 0.0 }), ..Material::default() })
    };
    let bright = builder.material(mirror(first, 1.0));
    let dark = builder.material(mirror(second, 0.0));
    let size = Vec3::X * 10.0;
    builder.mesh(
        "first",
        quad(Vec3::new(-5.0, -5.0, -1.0), size, Vec3::Y * 10.0),
        DAffine3::IDENTITY,
        bright,
    );
    builder.mesh("second", quad(Vec3::new(5.0, -5.0, 1.0), -size, Vec3::Y * 10.0), DAffine3::IDENTITY, dark);
    let exact = 1.0 / (1.0 - f64::from(first) * f64::from(second));
    Ok(Form {
        max_bounces: 100,
        certain: true,
        ..Form::new("E16", "two parallel mirrors", builder.build()?, exact, &[Effect::Light])
    })
}
