//! Options of the view: camera position, target, up direction and field of view.

use crate::values;
use clap::Args;
use glam::DVec3;
use std::str::FromStr;

/// Options that place a camera or change its orientation. Lengths in scene units, angles in degrees.
#[derive(Args, Clone, Debug, Default)]
pub struct ViewOptions {
    /// Place a camera at this point, looking at --look-at
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with_all = ["camera", "orbit"], help_heading = "View")]
    pub look_from: Option<Point>,
    /// Place a camera on a sphere around the scene, or around --look-at [default distance: fits the whole scene]
    ///
    /// YAW 0 is the front (+Z) and 90 the right (+X), PITCH 90 is from above; DISTANCE is measured from the centre.
    #[arg(
        long,
        value_name = "YAW,PITCH[,DISTANCE]",
        allow_hyphen_values = true,
        conflicts_with = "camera",
        help_heading = "View"
    )]
    pub orbit: Option<Orbit>,
    /// Point at the image centre [default: the scene centre; a camera of the scene keeps its direction]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "View")]
    pub look_at: Option<Point>,
    /// Up direction of the image; with --orbit the axis of rotation [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction, help_heading = "View")]
    pub up: Option<Point>,
    /// Vertical field of view [default: the camera's; 40 with --look-from and --orbit]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = field_of_view, help_heading = "View")]
    pub fov: Option<f64>,
}

impl ViewOptions {
    /// Returns the lines of a settings file that set the same values.
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

    /// Whether the camera is placed by these options rather than taken from the scene.
    pub fn places_camera(&self) -> bool {
        self.look_from.is_some() || self.orbit.is_some()
    }
}

/// A point `X,Y,Z` in scene units; all coordinates are finite.
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

/// A camera position `YAW,PITCH` or `YAW,PITCH,DISTANCE`, in degrees and scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    pub yaw: f64,
    pub pitch: f64,
    pub distance: Option<f64>,
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

/// Parses finite numbers separated by commas; reads at most four.
fn numbers(s: &str) -> Option<Vec<f64>> {
    s.split(',').take(4).map(|part| values::finite64(part).ok()).collect()
}

/// Parses a direction: three finite numbers, not all zero.
fn direction(s: &str) -> Result<Point, String> {
    let expected = || "expected a direction: three numbers, not all zero".into();
    s.parse().ok().filter(|p: &Point| p.0 != DVec3::ZERO).ok_or_else(expected)
}

/// Lower bound of the field of view, in degrees: smaller angles have no tangent in single precision.
const LEAST_ANGLE: f64 = 1e-36;

/// Parses a field of view, in degrees, between 0 and 180 (exclusive).
fn field_of_view(s: &str) -> Result<f64, String> {
    let said = || "expected an angle above 0 and below 180 degrees".into();
    values::finite64(s).ok().filter(|a| *a > LEAST_ANGLE && *a < 180.0).ok_or_else(said)
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
