//! Scenes in which few samples carry most of the light, as glTF text.
#![allow(dead_code)]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// A scene under construction; materials are numbered in the order in which they are added.
#[derive(Default)]
struct Gltf {
    bytes: Vec<u8>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    lights: Vec<Value>,
}

impl Gltf {
    /// Adds a quad with four corners in order.
    fn quad(mut self, corners: [[f32; 3]; 4], material: usize) -> Self {
        let ends = |f: fn(f32, f32) -> f32| {
            corners.iter().copied().reduce(|a, b| std::array::from_fn(|k| f(a[k], b[k]))).unwrap()
        };
        let (low, high) = (ends(f32::min), ends(f32::max));
        let positions = corners.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        let indices = [0u32, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
        let of = [
            json!({ "componentType": 5126, "count": 4, "type": "VEC3", "min": low, "max": high }),
            json!({ "componentType": 5125, "count": 6, "type": "SCALAR" }),
        ];
        for (mut accessor, bytes) in of.into_iter().zip::<[Vec<u8>; 2]>([positions, indices]) {
            accessor["bufferView"] = self.views.len().into();
            self.accessors.push(accessor);
            let (offset, length) = (self.bytes.len(), bytes.len());
            self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }));
            self.bytes.extend(bytes);
        }
        let at = self.accessors.len();
        let attributes = json!({ "POSITION": at - 2 });
        self.meshes.push(
            json!({ "primitives": [{ "attributes": attributes, "indices": at - 1, "material": material }] }),
        );
        self.nodes.push(json!({ "mesh": self.meshes.len() - 1 }));
        self
    }

    fn sphere(mut self, centre: [f64; 3], radius: f64, material: usize) -> Self {
        let shape = json!({ "shape": "sphere", "radius": radius, "material": material });
        self.nodes.push(json!({ "extras": { "dapple": shape }, "translation": centre }));
        self
    }

    /// Adds a spot light that points along −z of its node.
    fn spot(mut self, intensity: f64, half_angle: f64, place: [f64; 3], rotation: [f64; 4]) -> Self {
        let cone = json!({ "innerConeAngle": 0.9 * half_angle, "outerConeAngle": half_angle });
        self.lights.push(json!({ "type": "spot", "intensity": intensity, "spot": cone }));
        let of = json!({ "KHR_lights_punctual": { "light": self.lights.len() - 1 } });
        self.nodes.push(json!({ "translation": place, "rotation": rotation, "extensions": of }));
        self
    }

    fn point(mut self, intensity: f64, place: [f64; 3]) -> Self {
        self.lights.push(json!({ "type": "point", "intensity": intensity }));
        let of = json!({ "KHR_lights_punctual": { "light": self.lights.len() - 1 } });
        self.nodes.push(json!({ "translation": place, "extensions": of }));
        self
    }

    fn material(mut self, albedo: f64, [metallic, roughness]: [f64; 2], mut extensions: Value) -> Self {
        if metallic == 0.0 && extensions.get("KHR_materials_transmission").is_none() {
            extensions["KHR_materials_specular"] = json!({ "specularFactor": 0.0 });
        }
        let of = json!({ "baseColorFactor": [albedo, albedo, albedo, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness });
        let mut material =
            json!({ "pbrMetallicRoughness": of, "doubleSided": true, "extensions": extensions });
        if extensions.get("KHR_materials_emissive_strength").is_some() {
            material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
        }
        self.materials.push(material);
        self
    }

    fn matte(self, albedo: f64) -> Self {
        self.material(albedo, [0.0, 1.0], json!({}))
    }

    fn emitter(self, radiance: f64) -> Self {
        let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": radiance } });
        self.material(0.0, [0.0, 1.0], strength)
    }

    fn glass(self) -> Self {
        let volume = json!({ "thicknessFactor": 1.0 });
        let clear = json!({ "transmissionFactor": 1.0 });
        let of = json!({ "KHR_materials_transmission": clear, "KHR_materials_volume": volume });
        self.material(1.0, [0.0, 0.0], of)
    }

    fn camera(mut self, camera: Value, place: [f64; 3], rotation: [f64; 4]) -> String {
        self.nodes.push(json!({ "camera": 0, "translation": place, "rotation": rotation }));
        let data = STANDARD.encode(&self.bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        let mut all = json!({
            "asset": { "version": "2.0" }, "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "nodes": self.nodes, "meshes": self.meshes, "materials": self.materials,
            "accessors": self.accessors, "bufferViews": self.views, "cameras": [camera],
            "buffers": [{ "byteLength": self.bytes.len(), "uri": uri }],
            "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_materials_specular",
                "KHR_materials_transmission", "KHR_materials_volume", "KHR_lights_punctual"],
        });
        if !self.lights.is_empty() {
            all["extensions"] = json!({ "KHR_lights_punctual": { "lights": self.lights } });
        }
        all.to_string()
    }

    /// Adds a camera that looks from above onto the floor in front.
    fn seen(self) -> String {
        let perspective = json!({ "yfov": 0.7, "aspectRatio": 4.0 / 3.0, "znear": 0.001 });
        let camera = json!({ "type": "perspective", "perspective": perspective });
        self.camera(camera, [0.0, 2.2, 4.0], [-0.209_855_3, 0.0, 0.0, 0.977_732_45])
    }

    fn floor(self) -> Self {
        self.quad([[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]], 0)
    }

    fn side_wall(self) -> Self {
        self.quad([[-3.0, 0.0, 3.0], [-3.0, 0.0, -3.0], [-3.0, 6.0, -3.0], [-3.0, 6.0, 3.0]], 0)
    }
}

/// A plane of radiance 1 and, in front of it, a square of an eighth of a pixel's side and radiance 500. In images of
/// 16×12 pixels it lies within pixel (9, 4).
pub fn star() -> String {
    let square = |x: f32, y: f32, r: f32, z: f32| {
        [[x - r, y - r, z], [x + r, y - r, z], [x + r, y + r, z], [x - r, y + r, z]]
    };
    let pixel = 2.0 / 12.0;
    let scene = Gltf::default().emitter(1.0).emitter(500.0).quad(square(0.0, 0.0, 9.0, 0.0), 0);
    let scene = scene.quad(square(1.5 * pixel, 1.5 * pixel, pixel / 16.0, 0.1), 1);
    let flat = json!({ "xmag": 4.0 / 3.0, "ymag": 1.0, "znear": 0.001, "zfar": 1000.0 });
    let camera = json!({ "type": "orthographic", "orthographic": flat });
    scene.camera(camera, [0.0, 0.0, 2.0], [0.0, 0.0, 0.0, 1.0])
}

/// A glass ball and a small bright lamp: the caustic on the floor is found only by chance.
pub fn caustic() -> String {
    let scene = Gltf::default().matte(0.7).glass().emitter(300.0).floor();
    scene.sphere([0.2, 0.8, -0.3], 0.6, 1).sphere([-1.6, 3.0, 0.4], 0.1, 2).seen()
}

/// A tiny lamp close to a wall, which lights a spot of it very brightly; the spot lights the floor.
pub fn near_wall() -> String {
    let scene = Gltf::default().matte(0.7).emitter(4000.0).floor().side_wall();
    scene.sphere([-2.9, 2.5, 0.0], 0.01, 1).seen()
}

/// A ball of nearly smooth metal reflects a small bright lamp onto the floor.
pub fn glossy() -> String {
    let scene = Gltf::default().matte(0.7).material(0.9, [1.0, 0.2], json!({})).emitter(2700.0).floor();
    scene.sphere([0.0, 0.75, 0.0], 0.7, 1).sphere([1.8, 3.2, 0.5], 0.04, 2).seen()
}

/// A narrow spot light on a wall out of view, and a point light that lights the floor.
pub fn spot_patch() -> String {
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let scene = Gltf::default().matte(0.7).floor().side_wall();
    scene
        .spot(4000.0, 0.02, [0.0, 3.0, 0.0], [0.0, quarter, 0.0, quarter])
        .point(10.0, [1.0, 3.0, 1.0])
        .seen()
}

/// Sixty lamps above the floor, all out of view.
pub fn many_lamps() -> String {
    let lamp = |i: u32| {
        let t = f64::from(i);
        [2.5 * (2.4 * t).cos(), 2.6 + 0.02 * t, 2.5 * (2.4 * t).sin()]
    };
    let scene = Gltf::default().matte(0.7).emitter(60.0).floor().side_wall();
    (0..60).fold(scene, |scene, i| scene.sphere(lamp(i), 0.05, 1)).seen()
}

/// A matte ball on the floor below one large lamp.
pub fn soft_light() -> String {
    let scene = Gltf::default().matte(0.6).emitter(6.0).floor();
    scene.sphere([0.0, 0.6, 0.0], 0.6, 0).sphere([1.0, 4.0, 1.0], 0.6, 1).seen()
}

/// Writes a scene into `folder`; returns its path.
pub fn written(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(format!("{name}.gltf"));
    fs::write(&path, text).unwrap();
    path
}
