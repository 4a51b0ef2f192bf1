//! Writer of small glTF files in memory.
#![allow(dead_code, reason = "each test binary uses a part")]
use base64::Engine;
use serde_json::Value;
pub use serde_json::json;

/// A glTF file under construction: JSON and one buffer.
#[derive(Clone)]
pub struct File {
    pub json: Value,
    /// URI of the buffer; None embeds it.
    pub uri: Option<String>,
    buffer: Vec<u8>,
}

/// Little-endian bytes of vectors.
pub fn bytes<const N: usize>(all: &[[f32; N]]) -> Vec<u8> {
    all.iter().flatten().flat_map(|v| v.to_le_bytes()).collect()
}

impl File {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "accessors": [], "bufferViews": [],
        });
        Self { json, uri: None, buffer: Vec::new() }
    }

    pub fn set(&mut self, key: &str, value: Value) {
        self.json[key] = value;
    }

    fn push(&mut self, key: &str, value: Value) -> usize {
        let list = self.json[key].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Adds a buffer view.
    pub fn view(&mut self, data: &[u8], stride: Option<usize>) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.buffer.len(), "byteLength": data.len()});
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.buffer.extend(data);
        self.push("bufferViews", view)
    }

    /// Adds an accessor.
    pub fn accessor(&mut self, accessor: Value) -> usize {
        self.push("accessors", accessor)
    }

    /// Adds an accessor of float vectors.
    pub fn floats<const N: usize>(&mut self, all: &[[f32; N]]) -> usize {
        let view = self.view(&bytes(all), None);
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        self.accessor(json!({"bufferView": view, "componentType": 5126, "count": all.len(), "type": kind}))
    }

    /// Adds an accessor of floats.
    pub fn scalars(&mut self, all: &[f32]) -> usize {
        self.floats(&all.iter().map(|&v| [v]).collect::<Vec<_>>())
    }

    /// Adds an accessor of 16-bit indices.
    pub fn indices_u16(&mut self, all: &[u16]) -> usize {
        let data: Vec<u8> = all.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&data, None);
        self.accessor(
            json!({"bufferView": view, "componentType": 5123, "count": all.len(), "type": "SCALAR"}),
        )
    }

    /// The bytes of the buffer.
    pub fn buffer(&self) -> Vec<u8> {
        self.buffer.clone()
    }

    fn with_buffer(&self, uri: Option<String>) -> String {
        let mut json = self.json.clone();
        let length = json.pointer("/buffers/0/byteLength").cloned().unwrap_or(json!(self.buffer.len()));
        json["buffers"] = json!([{"byteLength": length}]);
        if let Some(uri) = uri {
            json["buffers"][0]["uri"] = json!(uri);
        }
        json.to_string()
    }

    /// The file as .gltf.
    pub fn gltf(&self) -> Vec<u8> {
        let data = || base64::engine::general_purpose::STANDARD.encode(&self.buffer);
        let uri =
            self.uri.clone().unwrap_or_else(|| format!("data:application/octet-stream;base64,{}", data()));
        self.with_buffer(Some(uri)).into_bytes()
    }

    /// The file as .glb.
    pub fn glb(&self) -> Vec<u8> {
        let json = self.with_buffer(None);
        let mut body = Vec::new();
        for (kind, filler, content) in [(b"JSON", b' ', json.as_bytes()), (b"BIN\0", 0, &self.buffer)] {
            body.extend((content.len().next_multiple_of(4) as u32).to_le_bytes());
            body.extend(kind);
            body.extend(content);
            body.resize(body.len().next_multiple_of(4), filler);
        }
        [b"glTF", &2_u32.to_le_bytes()[..], &(12 + body.len() as u32).to_le_bytes(), &body].concat()
    }
}

/// A red texel and a green one.
const PNG: &str =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAADklEQVR4nGP4z8DwHwQBEPgD/U6VwW8AAAAASUVORK5CYII=";

/// A file with textures, extensions, extras, a light, a camera, shapes and an animation.
pub fn showcase() -> File {
    let mut file = File::new();
    let positions = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0_f32]]);
    let normals = file.floats(&[[0.0, 0.0, 1.0_f32]; 4]);
    let uv = file.floats(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0_f32]]);
    let colors = file.floats(&[[1.0, 1.0, 1.0, 0.875_f32]; 4]);
    let indices = file.indices_u16(&[0, 1, 2, 0, 2, 3]);
    let times = file.scalars(&[0.0, 2.0]);
    let places = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0_f32]]);
    let png = base64::engine::general_purpose::STANDARD.decode(PNG).unwrap();
    let image = file.view(&png, None);
    file.set("buffers", json!([{"byteLength": file.buffer.len()}]));
    file.set("images", json!([{"bufferView": image, "mimeType": "image/png"}]));
    file.set("samplers", json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]));
    file.set("textures", json!([{"source": 0, "sampler": 0}]));
    file.set("materials", materials());
    let attributes = json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uv, "TEXCOORD_1": uv, "COLOR_0": colors});
    file.set(
        "meshes",
        json!([{"name": "card", "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}]),
    );
    file.set(
        "cameras",
        json!([{"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1}}]),
    );
    file.set(
        "nodes",
        json!([
            {"name": "card", "mesh": 0, "translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1],
             "children": [3]},
            {"name": "eye", "camera": 0, "translation": [0, 1, 8]},
            {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 0, 5]},
            {"name": "ball", "extras": {"dapple": {"shape": "sphere", "radius": 0.5, "material": 1}},
             "translation": [3, 0, 0]},
            {"name": "plate", "mesh": 0, "extras": {"dapple": {"shape": "disk", "radius": 0.25}},
             "translation": [-3, 0, 0]},
        ]),
    );
    file.set("scenes", json!([{"nodes": [0, 1, 2, 4]}]));
    file.set(
        "animations",
        json!([{
            "name": "slide",
            "samplers": [{"input": times, "output": places}],
            "channels": [{"sampler": 0, "target": {"node": 4, "path": "translation"}}],
        }]),
    );
    file.set("extensions", lights());
    file.set("extensionsUsed", json!(["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_ior"]));
    file
}

fn materials() -> Value {
    json!([
        {
            "name": "painted",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0.25, "roughnessFactor": 0.5,
                "baseColorTexture": {"index": 0, "extensions": {
                    "KHR_texture_transform": {"offset": [0.5, 0.25], "texCoord": 1}}},
            },
            "normalTexture": {"index": 0, "scale": 0.5},
            "emissiveFactor": [0.5, 0, 1],
            "alphaMode": "MASK", "alphaCutoff": 0.75, "doubleSided": true,
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": 4},
                "KHR_materials_ior": {"ior": 1.33},
                "KHR_materials_transmission": {"transmissionFactor": 0.5},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 3,
                                         "attenuationColor": [0.5, 1, 1]},
            },
        },
        {"name": "mirror", "extras": {"dapple": {"mirror": {"kr": [0.9, 0.8, 0.7], "blur": 0.125}}}},
    ])
}

fn lights() -> Value {
    json!({"KHR_lights_punctual": {"lights": [{
        "name": "lamp", "type": "spot", "color": [1, 0.5, 0], "intensity": 10,
        "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5},
    }]}})
}
