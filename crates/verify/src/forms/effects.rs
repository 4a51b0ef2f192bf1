//! Closed-form scenes E9 to E14: lenses, motion, edges, rough mirrors.

use super::form::{Form, with_lens};
use crate::closed_form::{disk_beside_line, ggx_cap, linear_edge, moving_box};
use crate::scenes::{matte, metal, of, quad, seen, seen_in_parallel, shadeless};
use dapple_integrator::Effect;
use dapple_integrator::camera::{Aperture, Lens, Projection, Shutter};
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::Image;
use dapple_integrator::lights::Environment;
use dapple_integrator::math::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_integrator::scene::{CameraPose, SceneBuilder, SceneError};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

pub(super) fn forms() -> Result<Vec<Form>, SceneError> {
    Ok(vec![defocus()?, motion()?, edge()?, everything()?, half_mirror()?, plate()?])
}

/// The half-plane n·(x, y) ≤ c at z = `z`, as a large square.
fn half_plane(n: DVec2, c: f64, z: f64) -> Mesh {
    let along = n.perp();
    let corner = |s: f64, t: f64| (n * (c - s) + along * t).extend(z).as_vec3();
    Mesh {
        positions: vec![corner(0.0, -20.0), corner(0.0, 20.0), corner(20.0, 20.0), corner(20.0, -20.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// An edge 3 units away beside a round lens focused at 7.
fn defocus() -> Result<Form, SceneError> {
    let (radius, focus, e) = (0.2, 7.0, 0.04);
    let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 0.1);
    let white = builder.material(shadeless(1.0));
    builder.mesh("half-plane", half_plane(DVec2::X, e, -3.0), DAffine3::IDENTITY, white);
    builder.environment(Environment::constant(Vec3::ZERO));
    let lens = Lens { aperture: Aperture::Disk, radius, focus_distance: focus };
    let scene = with_lens(builder.build()?, lens);
    let blur = f64::from(radius) * (1.0 - 3.0 / f64::from(focus));
    let exact = disk_beside_line(e / blur);
    Ok(Form {
        certain: true,
        ..Form::new("E9", "an edge beside a round lens", scene, exact, &[Effect::Lens])
    })
}

/// A bar 1.3 pixels wide that moves by 2.4 pixels.
fn motion() -> Result<Form, SceneError> {
    let mut builder = seen_in_parallel(DVec3::Z, 0.5);
    let white = builder.material(shadeless(1.0));
    let bar = quad(Vec3::new(-1.5, -4.0, 0.0), Vec3::X * 1.3, Vec3::Y * 8.0);
    let keys = vec![DVec3::ZERO, DVec3::X * 2.4];
    let track = Track::new(vec![0.0, 1.0], keys, Interpolation::Linear);
    let translation = track.map_or(Channel::Constant(DVec3::ZERO), |t| Channel::Track(Arc::new(t)));
    builder.moving_mesh("bar", bar, vec![Node::Trs(Trs { translation, ..Trs::default() })], white);
    builder.exposure(0.0, Shutter { open: 0.0, close: 1.0 });
    builder.environment(Environment::constant(Vec3::ZERO));
    let exact = moving_box(1.0, 1.3, 2.4);
    Ok(Form::new("E10", "a moving bar", builder.build()?, exact, &[Effect::Pixel, Effect::Time]))
}

fn edge() -> Result<Form, SceneError> {
    let n = DVec2::from_angle(33f64.to_radians());
    let c = 0.1213;
    let mut builder = seen_in_parallel(DVec3::Z, 0.5);
    let white = builder.material(shadeless(1.0));
    builder.mesh("half-plane", half_plane(n, c, 0.0), DAffine3::IDENTITY, white);
    builder.environment(Environment::constant(Vec3::ZERO));
    let exact = linear_edge(&n.to_array(), c + 0.5 * (n.x + n.y));
    // The edge crosses at most 2n of n² cells, each wrong by at most its own area.
    let grid = Some(2.0);
    Ok(Form {
        grid,
        ..Form::new("E11", "an edge under the pixel", builder.build()?, exact, &[Effect::Pixel])
    })
}

/// An edge seen through a pixel and a square lens, both linear in their random numbers.
fn everything() -> Result<Form, SceneError> {
    let (tan, distance, radius, focus, c) = (0.125, 3.0, 0.4, 4.4, -0.1219);
    let n = DVec2::from_angle(62f64.to_radians());
    let mut builder = seen(DVec3::ZERO, DVec3::NEG_Z, 2.0 * f64::atan(tan));
    let white = builder.material(shadeless(1.0));
    builder.mesh("half-plane", half_plane(n, c, -distance), DAffine3::IDENTITY, white);
    builder.environment(Environment::constant(Vec3::ZERO));
    let lens = Lens { aperture: Aperture::Square, radius, focus_distance: focus };
    let scene = with_lens(builder.build()?, lens);
    let pixel = 2.0 * tan * distance;
    let blur = 2.0 * f64::from(radius) * (1.0 - distance / f64::from(focus));
    let a = [n.x * pixel, -n.y * pixel, n.x * blur, n.y * blur];
    let exact = linear_edge(&a, c + 0.5 * a.iter().sum::<f64>());
    Ok(Form::new(
        "E12",
        "an edge under pixel and square lens at once",
        scene,
        exact,
        &[Effect::Pixel, Effect::Lens],
    ))
}

/// A metal plate at the origin that faces +y, seen along its normal from `height`.
fn plate_of(alpha: f32, height: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new("check");
    let pose = CameraPose::look_at(DVec3::Y * height, DVec3::ZERO, DVec3::Z, 0.1);
    builder
        .camera("camera", CameraPose { projection: Projection::Orthographic { half_height: 1e-5 }, ..pose });
    let rough = builder.material(of(metal(alpha)));
    builder.mesh(
        "plate",
        quad(Vec3::new(-0.1, 0.0, 0.1), Vec3::X * 0.2, Vec3::Z * -0.2),
        DAffine3::IDENTITY,
        rough,
    );
    builder
}

fn half_mirror() -> Result<Form, SceneError> {
    let mut builder = plate_of(0.36, 1.0);
    let picture = Image { width: 2, height: 1, pixels: vec![Vec3::ZERO, Vec3::ONE] };
    let sky = Environment::picture(picture, 0.0, 1.0, false);
    builder.environment(sky.unwrap_or(Environment::constant(Vec3::ZERO)));
    let alpha = f64::from(metal(0.36).roughness).powi(2);
    let effects = &[Effect::Light, Effect::Glossy];
    Ok(Form::new(
        "E13",
        "half a sky in a rough mirror",
        builder.build()?,
        0.5 * ggx_cap(alpha, FRAC_PI_2),
        effects,
    ))
}

/// A disk light of half angle 20° above a rough plate, with the camera between them.
fn plate() -> Result<Form, SceneError> {
    let theta = 20f64.to_radians();
    let mut builder = plate_of(0.16, 0.5);
    let bright = builder.material(matte(0.0, 3.0));
    builder.disk("lamp", DVec3::Y, DVec3::NEG_Y, theta.tan(), bright);
    let alpha = f64::from(metal(0.16).roughness).powi(2);
    let effects = &[Effect::Light, Effect::Glossy];
    Ok(Form::new(
        "E14",
        "a disk light in a rough plate",
        builder.build()?,
        3.0 * ggx_cap(alpha, theta),
        effects,
    ))
}
