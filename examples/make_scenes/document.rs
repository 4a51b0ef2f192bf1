//! Builder of a glTF document: everything in one file, with buffers in base64.

use crate::shape::Shape;
use base64::Engine;
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// A glTF document under construction; ids are indices in the order of adding.
#[derive(Default)]
pub struct Document {
    bytes: Vec<u8>,
    /// Accessors by content, so that equal meshes are stored once.
    stored: BTreeMap<(String, Vec<u8>), usize>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
    textures: Vec<Value>,
    meshes: Vec<Value>,
    cameras: Vec<Value>,
    nodes: Vec<Value>,
    lights: Vec<Value>,
    /// Samplers and channels of the only animation.
    tracks: (Vec<Value>, Vec<Value>),
    extensions: BTreeSet<String>,
}

impl Document {
    /// Adds a material and records the extensions that it uses.
    pub fn material(&mut self, material: Value) -> usize {
        if let Some(used) = material.get("extensions").and_then(Value::as_object) {
            self.extensions.extend(used.keys().cloned());
        }
        push(&mut self.materials, material)
    }

    /// Adds a texture with nearest filtering and repeated texels.
    pub fn nearest_texture(&mut self, png: &[u8]) -> usize {
        let uri = format!("data:image/png;base64,{}", base64(png));
        let source = push(&mut self.images, json!({ "uri": uri, "mimeType": "image/png" }));
        const NEAREST: u32 = 9728;
        let sampler = push(&mut self.samplers, json!({ "magFilter": NEAREST, "minFilter": NEAREST }));
        push(&mut self.textures, json!({ "source": source, "sampler": sampler }))
    }

    /// Adds a node with a mesh of its own.
    pub fn object(&mut self, name: &str, shape: &Shape, material: usize) -> usize {
        let mesh = self.mesh(name, shape, material);
        push(&mut self.nodes, json!({ "name": name, "mesh": mesh }))
    }

    /// Sets the translation of a node.
    pub fn place(&mut self, node: usize, at: DVec3) {
        self.nodes[node]["translation"] = json!(at.to_array());
    }

    /// Adds a sphere: exact for dapple (`extras`), a mesh for other renderers.
    pub fn sphere(&mut self, name: &str, centre: DVec3, radius: f64, detail: u32, material: usize) -> usize {
        let node = self.object(name, &Shape::sphere(radius, detail), material);
        self.nodes[node]["translation"] = json!(centre.to_array());
        self.nodes[node]["extras"] = json!({ "dapple": { "shape": "sphere", "radius": radius } });
        node
    }

    /// Adds a camera at `eye` that looks at `target`, +y up; `yfov` in radians.
    pub fn camera(&mut self, eye: DVec3, target: DVec3, yfov: f64, aspect: f64) {
        let perspective = json!({ "yfov": yfov, "aspectRatio": aspect, "znear": 0.01 });
        let camera = push(&mut self.cameras, json!({ "type": "perspective", "perspective": perspective }));
        let backward = (eye - target).normalize();
        let right = DVec3::Y.cross(backward).normalize();
        let up = backward.cross(right);
        let columns = [right.extend(0.0), up.extend(0.0), backward.extend(0.0), eye.extend(1.0)];
        let matrix: Vec<f64> = columns.iter().flat_map(|c| c.to_array()).collect();
        push(&mut self.nodes, json!({ "name": "camera", "camera": camera, "matrix": matrix }));
    }

    /// Adds a distant light in the direction `towards`; `irradiance` is that of surfaces facing it.
    pub fn sun(&mut self, name: &str, towards: DVec3, irradiance: [f64; 3]) {
        let intensity = irradiance.iter().fold(0.0, |a: f64, &b| a.max(b));
        let light = json!({
            "name": name, "type": "directional", "color": irradiance.map(|c| c / intensity), "intensity": intensity,
        });
        let light = push(&mut self.lights, light);
        // The light points along −z of its node.
        let turn = DQuat::from_rotation_arc(DVec3::Z, towards.normalize());
        let extension = json!({ "KHR_lights_punctual": { "light": light } });
        push(&mut self.nodes, json!({ "name": name, "rotation": turn.to_array(), "extensions": extension }));
        self.extensions.insert("KHR_lights_punctual".into());
    }

    /// Animates a node: `path` is translation, rotation or scale, with a value for every time in seconds.
    pub fn track<const N: usize>(&mut self, node: usize, path: &str, times: &[f64], values: &[[f64; N]]) {
        let input = self.keys(&times.iter().map(|&t| [t]).collect::<Vec<_>>());
        let (low, high) = (times[0] as f32, times[times.len() - 1] as f32);
        (self.accessors[input]["min"], self.accessors[input]["max"]) = (json!([low]), json!([high]));
        let output = self.keys(values);
        let sampler = push(&mut self.tracks.0, json!({ "input": input, "output": output }));
        self.tracks.1.push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }

    fn keys<const N: usize>(&mut self, values: &[[f64; N]]) -> usize {
        const FLOAT: u32 = 5126;
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let bytes = values.iter().flatten().flat_map(|&x| (x as f32).to_le_bytes()).collect();
        self.accessor(bytes, None, FLOAT, values.len(), kind)
    }

    fn mesh(&mut self, name: &str, shape: &Shape, material: usize) -> usize {
        let (low, high) = shape.bounds();
        let mut attributes = json!({ "POSITION": self.floats(&shape.positions, "VEC3") });
        let position = &mut self.accessors[attributes["POSITION"].as_u64().unwrap_or(0) as usize];
        (position["min"], position["max"]) = (json!(low), json!(high));
        if !shape.normals.is_empty() {
            attributes["NORMAL"] = json!(self.floats(&shape.normals, "VEC3"));
        }
        if !shape.uvs.is_empty() {
            attributes["TEXCOORD_0"] = json!(self.floats(&shape.uvs, "VEC2"));
        }
        let indices = self.indices(&shape.triangles);
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": material });
        push(&mut self.meshes, json!({ "name": name, "primitives": [primitive] }))
    }

    fn floats<const N: usize>(&mut self, values: &[[f64; N]], kind: &str) -> usize {
        const FLOAT: u32 = 5126;
        const ARRAY_BUFFER: u32 = 34962;
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|&x| (x as f32).to_le_bytes()).collect();
        self.accessor(bytes, Some(ARRAY_BUFFER), FLOAT, values.len(), kind)
    }

    fn indices(&mut self, triangles: &[[u16; 3]]) -> usize {
        const UNSIGNED_SHORT: u32 = 5123;
        const ELEMENT_ARRAY_BUFFER: u32 = 34963;
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(bytes, Some(ELEMENT_ARRAY_BUFFER), UNSIGNED_SHORT, 3 * triangles.len(), "SCALAR")
    }

    fn accessor(
        &mut self,
        bytes: Vec<u8>,
        target: Option<u32>,
        component: u32,
        count: usize,
        kind: &str,
    ) -> usize {
        let key = (kind.to_string(), bytes);
        if let Some(&accessor) = self.stored.get(&key) {
            return accessor;
        }
        let bytes = &key.1;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        let view = push(&mut self.views, view);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        let accessor = push(&mut self.accessors, accessor);
        self.stored.insert(key, accessor);
        accessor
    }

    /// Returns the finished file.
    pub fn to_text(&self) -> String {
        let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "dapple make_scenes" },
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "buffers": [{ "byteLength": self.bytes.len(), "uri": uri }],
        });
        let lists = [
            ("nodes", &self.nodes),
            ("cameras", &self.cameras),
            ("meshes", &self.meshes),
            ("materials", &self.materials),
            ("textures", &self.textures),
            ("images", &self.images),
            ("samplers", &self.samplers),
            ("accessors", &self.accessors),
            ("bufferViews", &self.views),
        ];
        for (key, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            root[key] = json!(list);
        }
        if !self.lights.is_empty() {
            root["extensions"] = json!({ "KHR_lights_punctual": { "lights": self.lights } });
        }
        let (samplers, channels) = &self.tracks;
        if !channels.is_empty() {
            root["animations"] = json!([{ "name": "motion", "samplers": samplers, "channels": channels }]);
        }
        if !self.extensions.is_empty() {
            root["extensionsUsed"] = json!(self.extensions);
        }
        format!("{root:#}\n")
    }
}

fn push(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}

fn base64(bytes: &[u8]) -> String {
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

/// A purely diffuse material (`specularFactor` 0 removes the dielectric coat).
pub fn lambert(name: &str, rgb: [f64; 3]) -> Value {
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [rgb[0], rgb[1], rgb[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0,
        },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } },
    })
}

/// A metal; `roughness` is glTF's, the square root of GGX's alpha.
pub fn metal(name: &str, rgb: [f64; 3], roughness: f64) -> Value {
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [rgb[0], rgb[1], rgb[2], 1.0], "metallicFactor": 1.0, "roughnessFactor": roughness,
        },
    })
}

/// A mirror of reflectance `kr` with a square blur of side `blur` (dapple's `extras`); a smooth metal in other
/// renderers.
pub fn mirror(name: &str, kr: [f64; 3], blur: f64) -> Value {
    let mut material = metal(name, kr, 0.0);
    material["extras"] = json!({ "dapple": { "mirror": { "kr": kr, "blur": blur } } });
    material
}

/// A dielectric coat over a diffuse base.
pub fn plastic(name: &str, rgb: [f64; 3], roughness: f64) -> Value {
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [rgb[0], rgb[1], rgb[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness,
        },
    })
}

/// Clear solid glass.
pub fn glass(name: &str) -> Value {
    json!({
        "name": name,
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_ior": { "ior": 1.5 },
            // Above zero: the surface bounds a solid.
            "KHR_materials_volume": { "thicknessFactor": 1.0 },
        },
    })
}

/// A black surface that emits `radiance`.
pub fn emitter(name: &str, radiance: [f64; 3]) -> Value {
    let strength = radiance.iter().fold(0.0, |a: f64, &b| a.max(b));
    let mut material = lambert(name, [0.0; 3]);
    material["emissiveFactor"] = json!(radiance.map(|c| c / strength));
    if strength > 1.0 {
        material["extensions"]["KHR_materials_emissive_strength"] = json!({ "emissiveStrength": strength });
    }
    material
}
