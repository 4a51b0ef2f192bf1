//! Selection of the view: a camera of the scene, or one that the options place.
//!
//! `--look-from` and `--orbit` create a camera. `--look-at`, `--up` and `--fov` modify it or, without it, the scene's
//! camera.

use crate::error::{self, Failure};
use crate::options::{Orbit, RenderOptions, ViewOptions};
use crate::say::say;
use dapple_integrator::camera::{Camera, Projection};
use dapple_integrator::scene::view::{self, FIELD_OF_VIEW};
use dapple_integrator::scene::{CameraPose, NamedCamera, Scene, WorldPoint};
use glam::{DAffine3, DMat3, DVec3};

/// Maximum number of cameras that an error message lists.
const NAMED: usize = 20;

/// Returns the requested camera, without its lens.
pub fn view(scene: &Scene, options: &RenderOptions) -> Result<NamedCamera, Failure> {
    let asked = &options.view;
    let up = asked.up.map_or(DVec3::Y, |up| up.0);
    let yfov = asked.fov.map_or(FIELD_OF_VIEW, f64::to_radians);
    let centre = || asked.look_at.map_or_else(|| scene.centre().0, |at| at.0);
    if let Some(Orbit { yaw, pitch, distance }) = asked.orbit {
        let orbit = view::Orbit { yaw: yaw.to_radians(), pitch: pitch.to_radians(), distance };
        let (centre, radius) =
            (centre(), distance.map_or_else(|| scene.reach(WorldPoint(centre())), |_| 0.0));
        return placed(scene, "orbit", &orbit.pose(centre, radius, up, yfov));
    }
    if let Some(from) = asked.look_from {
        let axes = towards("--look-from", from.0, centre(), up)?;
        let pose = CameraPose {
            transform: DAffine3 { matrix3: axes, translation: from.0 },
            projection: view::perspective(yfov),
            aspect: None,
            clip: None,
        };
        return placed(scene, "look-from", &pose);
    }
    let mut named = named(scene, options.camera.as_deref())?.clone();
    named.camera = changed(scene, named.camera, asked)?;
    Ok(named)
}

/// Prints a note if the view options stop the motion of the scene's camera.
pub fn note_held(scene: &Scene, options: &RenderOptions) {
    let asked = &options.view;
    if asked.places_camera() || (asked.look_at.is_none() && asked.up.is_none()) {
        return;
    }
    if named(scene, options.camera.as_deref()).is_ok_and(|named| named.camera.motion.is_some()) {
        say(
            "note: the camera does not move: --look-at and --up fix its position at the opening of the shutter",
        );
    }
}

fn placed(scene: &Scene, name: &str, pose: &CameraPose) -> Result<NamedCamera, Failure> {
    let camera = scene.place_camera(pose);
    let camera = camera.map_err(|what| Failure::Arguments(format!("--{name}: the camera {what}")))?;
    Ok(NamedCamera { name: name.into(), camera, aspect: None })
}

fn towards(option: &str, from: DVec3, at: DVec3, up: DVec3) -> Result<DMat3, Failure> {
    let axes = view::axes_towards(from, at, up).filter(DMat3::is_finite);
    axes.ok_or_else(|| {
        Failure::Arguments(format!("{option}: the camera position equals the point to look at"))
    })
}

/// Returns the scene's camera with the requested direction and field of view.
fn changed(scene: &Scene, mut camera: Camera, asked: &ViewOptions) -> Result<Camera, Failure> {
    if let Some(degrees) = asked.fov {
        match &mut camera.projection {
            perspective @ Projection::Perspective { .. } => {
                *perspective = view::perspective(degrees.to_radians())
            }
            Projection::Orthographic { .. } => {
                let said = "--fov: the camera is orthographic and has no field of view; choose another camera, or use --orbit";
                return Err(Failure::Arguments(said.into()));
            }
        }
    }
    if asked.look_at.is_none() && asked.up.is_none() {
        return Ok(camera);
    }
    camera.motion = None;
    let WorldPoint(from) = scene.space.to_world(camera.origin);
    let ahead = -camera.backward.as_dvec3();
    let axes = match asked.look_at {
        Some(at) => towards("--look-at", from, at.0, asked.up.map_or(DVec3::Y, |up| up.0))?,
        None => towards("--up", DVec3::ZERO, ahead, asked.up.map_or(DVec3::Y, |up| up.0))?,
    };
    [camera.right, camera.up, camera.backward] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.as_vec3());
    Ok(camera)
}

/// Returns the camera named `wanted`, else the one with that index; the first camera if none is given.
fn named<'a>(scene: &'a Scene, wanted: Option<&str>) -> Result<&'a NamedCamera, Failure> {
    let Some(wanted) = wanted else {
        return scene.cameras.first().ok_or_else(|| Failure::Arguments("the scene has no camera".into()));
    };
    let by_name = scene.cameras.iter().find(|c| *c.name == *wanted);
    let by_index = || wanted.parse::<usize>().ok().and_then(|i| scene.cameras.get(i));
    by_name.or_else(by_index).ok_or_else(|| {
        let names = scene.cameras.iter().enumerate().map(|(i, c)| format!("{i} '{}'", error::short(&c.name)));
        let mut names = names.take(NAMED).collect::<Vec<_>>().join(", ");
        if let more @ 1.. = scene.cameras.len().saturating_sub(NAMED) {
            names += &format!(" and {more} more");
        }
        let wanted = error::short(wanted);
        Failure::Arguments(format!("--camera {wanted}: there is no such camera; the scene has {names}"))
    })
}
