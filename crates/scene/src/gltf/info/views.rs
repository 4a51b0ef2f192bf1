//! Cameras and punctual lights, in the units of the file.
use super::super::{document::Document, node::Hierarchy, read};
use super::choices::own;
use crate::{Placement, SceneError, error::quoted};
use dapple_camera::camera::axes;
use glam::DVec3;
use gltf::json::{self, extensions::scene::khr_lights_punctual as punctual, validation::Checked};
use serde::Serialize;

/// Length in bytes beyond which a camera's name is truncated.
const LONGEST: usize = 1000;

/// A camera of the selected scene, when the shutter opens.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CameraInfo {
    /// Name, which `--camera` accepts as well as the index in this list, counted from 0.
    pub name: String,
    /// "perspective" or "orthographic".
    pub kind: &'static str,
    /// Position in world space, in scene units.
    pub position: [f64; 3],
    /// Viewing direction, a unit vector; None if the scale of its node is zero.
    pub direction: Option<[f64; 3]>,
    /// Up direction of the image, a unit vector; None in the same case.
    pub up: Option<[f64; 3]>,
    /// Vertical field of view of a perspective camera, in degrees.
    pub yfov_degrees: Option<f64>,
    /// Width and height of the view of an orthographic camera, in scene units.
    pub size: Option<[f64; 2]>,
    /// Aspect ratio (width / height) given by the file.
    pub aspect: Option<f64>,
    /// Distance of the near plane, in scene units.
    pub znear: f64,
    /// Distance of the far plane, in scene units; None if it is infinite.
    pub zfar: Option<f64>,
    /// Whether it moves while the shutter is open.
    pub moves: bool,
}

/// A punctual light of the file (KHR_lights_punctual).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LightInfo {
    /// Index in the file's list.
    pub index: usize,
    /// Name, if it has one.
    pub name: Option<String>,
    /// "point", "spot" or "directional".
    pub kind: &'static str,
    /// Intensity as given by the file, in `unit`; it is multiplied by the colour.
    pub intensity: f64,
    /// Unit of the intensity in the file: "cd" or "lx".
    pub unit: &'static str,
    /// Linear Rec. 709 colour.
    pub color: [f32; 3],
    /// Distance at which the light ends, in scene units; None if it is unlimited.
    pub range: Option<f64>,
    /// Half angles of the inner and outer cone of a spot light, in degrees.
    pub cone_degrees: Option<[f64; 2]>,
    /// Number of nodes of the selected scene that use it.
    pub placed: usize,
}

pub(super) fn cameras(
    doc: &Document<'_>,
    hierarchy: &Hierarchy,
    (placements, moving): (&[Placement], &[bool]),
) -> Result<Vec<CameraInfo>, SceneError> {
    let mut cameras = Vec::new();
    let open = doc.options.at + doc.options.shutter.open;
    for &i in &hierarchy.order {
        let node = &doc.root.nodes[i];
        let Some(index) = node.camera else { continue };
        let camera = doc.get(&doc.root.cameras, index, "camera", "a node")?;
        // Many nodes may share a camera: a long name is not copied for each.
        let name = read::camera_name(index, camera, node.name.as_deref());
        let name = if name.len() > LONGEST { quoted(&name) } else { name.into_owned() };
        let placement = hierarchy.camera(i, placements, open);
        cameras.push(CameraInfo { name, moves: moving[i], ..posed(camera, &placement) });
    }
    Ok(cameras)
}

fn posed(camera: &json::Camera, placement: &Placement) -> CameraInfo {
    // Adding zero turns −0 into 0.
    let unit = |v: DVec3| (v + DVec3::ZERO).to_array();
    let axes = axes(&placement.linear);
    let posed = CameraInfo {
        position: placement.point(DVec3::ZERO).to_array(),
        direction: axes.map(|(_, _, backward)| unit(-backward)),
        up: axes.map(|(_, up, _)| unit(up)),
        ..CameraInfo::default()
    };
    let positive = |x: f32| Some(f64::from(x)).filter(|x| *x > 0.0 && x.is_finite());
    match (&camera.perspective, &camera.orthographic) {
        (Some(p), _) => CameraInfo {
            kind: "perspective",
            yfov_degrees: Some(f64::from(p.yfov).to_degrees()),
            aspect: p.aspect_ratio.and_then(positive),
            znear: p.znear.into(),
            zfar: p.zfar.and_then(positive),
            ..posed
        },
        (None, Some(o)) => {
            let (width, height) = (2.0 * f64::from(o.xmag.abs()), 2.0 * f64::from(o.ymag.abs()));
            CameraInfo {
                kind: "orthographic",
                size: Some([width, height]),
                aspect: positive((width / height) as f32),
                znear: o.znear.into(),
                zfar: positive(o.zfar),
                ..posed
            }
        }
        (None, None) => CameraInfo { kind: "unknown", ..posed },
    }
}

pub(super) fn lights(doc: &Document<'_>, hierarchy: &Hierarchy) -> Vec<LightInfo> {
    let lights = doc.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let lights = lights.map_or(&[][..], |l| &l.lights);
    let mut placed = vec![0; lights.len()];
    for node in hierarchy.order.iter().map(|&i| &doc.root.nodes[i]) {
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(count) = light.and_then(|l| placed.get_mut(l.light.value())) {
            *count += 1;
        }
    }
    lights.iter().zip(placed).enumerate().map(|(index, (light, placed))| one(index, light, placed)).collect()
}

fn one(index: usize, light: &punctual::Light, placed: usize) -> LightInfo {
    let (kind, unit) = match light.type_ {
        Checked::Valid(punctual::Type::Directional) => ("directional", "lx"),
        Checked::Valid(punctual::Type::Point) => ("point", "cd"),
        Checked::Valid(punctual::Type::Spot) => ("spot", "cd"),
        Checked::Invalid => ("unknown", ""),
    };
    LightInfo {
        index,
        name: own(light.name.as_deref()),
        kind,
        intensity: light.intensity.into(),
        unit,
        color: light.color,
        range: light.range.map(f64::from),
        cone_degrees: (kind == "spot").then(|| {
            let (inner, outer) = read::cone(light);
            [inner.to_degrees(), outer.to_degrees()]
        }),
        placed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::borrow::Cow;

    /// All nodes of a file may share one camera, whose name may be as long as the file.
    #[test]
    fn a_name_is_not_copied_for_each_node() {
        let plane = serde_json::json!({
            "type": "orthographic", "name": "a".repeat(1 << 20),
            "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 1 },
        });
        let camera: json::Camera = serde_json::from_value(plane).unwrap();
        let name = |node| read::camera_name(json::Index::new(0), &camera, node);
        assert!(matches!(name(None), Cow::Borrowed(all) if all.len() == 1 << 20));
        assert!(matches!(name(Some("node")), Cow::Borrowed("node")));
    }
}
