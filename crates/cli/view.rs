//! Which view is rendered: a camera of the scene, or one that the options place.
//!
//! `--look-from` and `--orbit` make a camera of their own. `--look-at`, `--up` and `--fov` change that one or, without it,
//! the scene's camera.

use crate::error::{self, Failure};
use crate::options::RenderOptions;
use crate::{report, values};
use clap::Args;
use dapple_integrator::camera::{Camera, Projection};
use dapple_integrator::scene::view::{self, FIELD_OF_VIEW};
use dapple_integrator::scene::{CameraPose, NamedCamera, Scene};
use glam::{DAffine3, DMat3, DVec3};
use std::str::FromStr;

/// Most cameras that a complaint names.
const NAMED: usize = 20;

/// Options that place a camera, or turn one. Lengths in scene units, angles in degrees.
#[derive(Args, Clone, Debug, Default)]
pub struct ViewOptions {
    /// Place a camera at a point; it looks at --look-at
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with_all = ["camera", "orbit"], help_heading = "View")]
    pub look_from: Option<Point>,
    /// Place a camera on a sphere around the scene, or around --look-at [default distance: as near as shows everything]
    ///
    /// YAW 0 is from the front (+Z), 90 from the right (+X), PITCH 90 from above; DISTANCE is counted from the centre.
    #[arg(
        long,
        value_name = "YAW,PITCH[,DISTANCE]",
        allow_hyphen_values = true,
        conflicts_with = "camera",
        help_heading = "View"
    )]
    pub orbit: Option<Orbit>,
    /// The point in the middle of the picture [default: the centre of the scene; a camera of the scene looks where it looks]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "View")]
    pub look_at: Option<Point>,
    /// The direction that is up in the picture; with --orbit the axis it turns about [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction, help_heading = "View")]
    pub up: Option<Point>,
    /// Vertical field of view [default: the camera's; 40 with --look-from and --orbit]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = field_of_view, help_heading = "View")]
    pub fov: Option<f64>,
}

impl ViewOptions {
    /// The lines of a settings file that say the same.
    pub fn lines(&self) -> Vec<String> {
        let list = |p: DVec3| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z);
        let mut lines = Vec::new();
        lines.extend(self.look_from.map(|p| format!("look-from = {}", list(p.0))));
        lines.extend(self.orbit.map(|o| match o.distance {
            Some(distance) => format!("orbit = [{:?}, {:?}, {distance:?}]", o.yaw, o.pitch),
            None => format!("orbit = [{:?}, {:?}]", o.yaw, o.pitch),
        }));
        lines.extend(self.look_at.map(|p| format!("look-at = {}", list(p.0))));
        lines.extend(self.up.map(|p| format!("up = {}", list(p.0))));
        lines.extend(self.fov.map(|degrees| format!("fov = {degrees:?}")));
        lines
    }

    /// Whether the camera is none of the scene's.
    pub fn places_camera(&self) -> bool {
        self.look_from.is_some() || self.orbit.is_some()
    }
}

/// `X,Y,Z` in scene units, finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub DVec3);

impl FromStr for Point {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let expected = "expected three finite numbers X,Y,Z";
        match numbers(s).as_deref() {
            Some(&[x, y, z]) => Ok(Self(DVec3::new(x, y, z))),
            _ => Err(expected.into()),
        }
    }
}

/// `YAW,PITCH` or `YAW,PITCH,DISTANCE`, in degrees and scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    yaw: f64,
    pitch: f64,
    distance: Option<f64>,
}

impl FromStr for Orbit {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let (yaw, pitch, distance) = match numbers(s).as_deref() {
            Some(&[yaw, pitch]) => (yaw, pitch, None),
            Some(&[yaw, pitch, distance]) => (yaw, pitch, Some(distance)),
            _ => {
                return Err("expected two or three finite numbers YAW,PITCH[,DISTANCE], such as 30,20".into());
            }
        };
        if !(-90.0..=90.0).contains(&pitch) {
            return Err("the pitch must lie between -90 (from below) and 90 degrees (from above)".into());
        }
        if distance.is_some_and(|d| d <= 0.0) {
            return Err("the distance must be above zero".into());
        }
        Ok(Self { yaw, pitch, distance })
    }
}

/// Finite numbers separated by commas; three at most are looked at.
fn numbers(s: &str) -> Option<Vec<f64>> {
    s.split(',').take(4).map(|part| values::finite64(part).ok()).collect()
}

/// A direction: three finite numbers, not all zero.
fn direction(s: &str) -> Result<Point, String> {
    let expected = || "expected a direction: three numbers, not all zero".into();
    s.parse().ok().filter(|p: &Point| p.0 != DVec3::ZERO).ok_or_else(expected)
}

/// Smaller fields of view have no tangent in single precision, in degrees.
const LEAST_ANGLE: f64 = 1e-36;

/// An angle that a picture can span.
fn field_of_view(s: &str) -> Result<f64, String> {
    let said = || "expected an angle above 0 and below 180 degrees".into();
    values::finite64(s).ok().filter(|a| *a > LEAST_ANGLE && *a < 180.0).ok_or_else(said)
}

/// The camera that the options ask for, without its lens.
pub fn view(scene: &Scene, options: &RenderOptions) -> Result<NamedCamera, Failure> {
    let asked = &options.view;
    let up = asked.up.map_or(DVec3::Y, |up| up.0);
    let yfov = asked.fov.map_or(FIELD_OF_VIEW, f64::to_radians);
    let centre = || asked.look_at.map_or_else(|| scene.centre(), |at| at.0);
    if let Some(Orbit { yaw, pitch, distance }) = asked.orbit {
        let orbit = view::Orbit { yaw: yaw.to_radians(), pitch: pitch.to_radians(), distance };
        let (centre, radius) = (centre(), distance.map_or_else(|| scene.reach(centre()), |_| 0.0));
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

/// Says where the view that was asked for stops the scene's camera.
pub fn note_held(scene: &Scene, options: &RenderOptions) {
    let asked = &options.view;
    if asked.places_camera() || (asked.look_at.is_none() && asked.up.is_none()) {
        return;
    }
    if named(scene, options.camera.as_deref()).is_ok_and(|named| named.camera.motion.is_some()) {
        report::say("note: the camera stands as when the shutter opens: --look-at and --up hold it still");
    }
}

fn placed(scene: &Scene, name: &str, pose: &CameraPose) -> Result<NamedCamera, Failure> {
    let camera = scene.place_camera(pose);
    let camera = camera.map_err(|what| Failure::Arguments(format!("--{name}: the camera {what}")))?;
    Ok(NamedCamera { name: name.into(), camera, aspect: None })
}

fn towards(option: &str, from: DVec3, at: DVec3, up: DVec3) -> Result<DMat3, Failure> {
    let axes = view::axes_towards(from, at, up).filter(DMat3::is_finite);
    axes.ok_or_else(|| Failure::Arguments(format!("{option}: the camera stands where it is to look at")))
}

/// The scene's camera, turned and zoomed as asked for.
fn changed(scene: &Scene, mut camera: Camera, asked: &ViewOptions) -> Result<Camera, Failure> {
    if let Some(degrees) = asked.fov {
        match &mut camera.projection {
            perspective @ Projection::Perspective { .. } => {
                *perspective = view::perspective(degrees.to_radians())
            }
            Projection::Orthographic { .. } => {
                let said =
                    "--fov: the camera is orthographic and has no field of view; choose another, or --orbit";
                return Err(Failure::Arguments(said.into()));
            }
        }
    }
    if asked.look_at.is_none() && asked.up.is_none() {
        return Ok(camera);
    }
    camera.motion = None;
    let from = scene.space.to_world(camera.origin);
    let ahead = -camera.backward.as_dvec3();
    let axes = match asked.look_at {
        Some(at) => towards("--look-at", from, at.0, asked.up.map_or(DVec3::Y, |up| up.0))?,
        None => towards("--up", DVec3::ZERO, ahead, asked.up.map_or(DVec3::Y, |up| up.0))?,
    };
    [camera.right, camera.up, camera.backward] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.as_vec3());
    Ok(camera)
}

/// The camera called `wanted`, else the one with that index, else the first.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_checked() {
        assert_eq!("1,-2,3e1".parse(), Ok(Point(DVec3::new(1.0, -2.0, 30.0))));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1,,3"] {
            assert!(bad.parse::<Point>().is_err(), "{bad}");
        }
        assert_eq!("-30,20".parse(), Ok(Orbit { yaw: -30.0, pitch: 20.0, distance: None }));
        assert_eq!("400,-90,2".parse(), Ok(Orbit { yaw: 400.0, pitch: -90.0, distance: Some(2.0) }));
        for bad in ["30", "30,91", "30,20,0", "30,20,-1", "30,20,1,1", "nan,0"] {
            assert!(bad.parse::<Orbit>().is_err(), "{bad}");
        }
        assert!(direction("0,0,0").is_err() && direction("0,-0.001,0").is_ok());
        assert!(field_of_view("0").is_err() && field_of_view("180").is_err() && field_of_view("179").is_ok());
    }
}
