//! Tests of the glTF reader on generated files.
#![cfg(feature = "gltf")]
#[path = "../file/mod.rs"]
mod file;

mod cameras;
mod circulation;
mod contents;
mod graph;
mod refusals;
mod storage;

use dapple_camera::Shutter;
use dapple_scene::{AlphaMode, LightUnit, Reads, Scene, gltf};
use file::{File, json};
use glam::{DVec3, Vec3};
use serde_json::Value;
use std::path::Path;

const OPTIONS: gltf::Options = gltf::Options {
    at: 0.0,
    shutter: Shutter { open: 0.0, close: 0.0 },
    allow_path: false,
    strict: false,
    reads: Reads::EVERYTHING,
    memory: dapple_imaging::MemoryLimit::NONE,
    choice: gltf::Choice { scene: None, variant: None, animation: None },
    light_unit: LightUnit::Auto,
    images: None,
};

fn read(bytes: &[u8]) -> Result<Scene, dapple_scene::SceneError> {
    gltf::read_bytes(Path::new("test.gltf"), bytes, &OPTIONS)?.build()
}

fn load(file: &File) -> Scene {
    read(&file.gltf()).unwrap_or_else(|e| panic!("{e}"))
}

fn error(file: &File) -> String {
    match read(&file.gltf()) {
        Ok(_) => panic!("this should not load"),
        Err(e) => {
            let text = e.to_string();
            assert!(!text.contains('\n') && text.contains("test.gltf"), "{text}");
            text
        }
    }
}

/// World-space corners of a triangle.
fn corners(scene: &Scene, object: u32, primitive: u32) -> [DVec3; 3] {
    scene.accel.corners(object, primitive).map(|p| scene.space.to_world(p).0)
}

fn assert_near(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-5, "{a} is not {b}");
}

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

/// A file with one node, one mesh and one primitive: a square of two triangles.
fn square() -> File {
    let mut file = File::new();
    let positions = file.floats(&SQUARE);
    let indices = file.indices_u16(&[0, 1, 2, 0, 2, 3]);
    file.set(
        "meshes",
        json!([{"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]}]),
    );
    file.set("nodes", json!([{"mesh": 0}]));
    file
}
