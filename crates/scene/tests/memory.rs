//! Memory of the reader: predicted beforehand, an error if it is too much, and shared for equal data.
#![cfg(feature = "gltf")]
mod file;

use dapple_imaging::MemoryLimit;
use dapple_scene::{SceneBuilder, SceneError, gltf};
use file::{File, json};
use std::path::Path;
use std::sync::Arc;

/// A strip of `triangles` triangles with `instances` instances.
fn strips(triangles: usize, instances: usize) -> File {
    let mut file = File::new();
    let corners: Vec<[f32; 3]> = (0..triangles + 2).map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
    let positions = file.floats(&corners);
    let places: Vec<[f32; 3]> = (0..instances).map(|i| [0.0, 0.0, i as f32]).collect();
    let places = file.floats(&places);
    file.set("meshes", json!([{"primitives": [{"attributes": {"POSITION": positions}, "mode": 5}]}]));
    let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    file.set("nodes", json!([{"mesh": 0, "name": "strip", "extensions": instancing}]));
    file.set("scenes", json!([{"nodes": [0]}]));
    file.set("extensionsRequired", json!(["EXT_mesh_gpu_instancing"]));
    file
}

fn read(file: &File, memory: MemoryLimit) -> Result<SceneBuilder, SceneError> {
    let options = gltf::Options { memory, ..gltf::Options::default() };
    gltf::read_bytes(Path::new("test.gltf"), &file.gltf(), &options)
}

#[test]
fn the_triangles_of_all_instances_count() {
    let file = strips(1000, 300);
    let needed = 300 * (1000 * 480 + 1002 * 44 + 1000);
    assert!(read(&file, MemoryLimit::free(needed)).is_ok());
    let refused = read(&file, MemoryLimit::free(needed - 1)).unwrap_err();
    assert!(matches!(refused, SceneError::Memory { .. }));
    let said = refused.to_string();
    for word in
        ["test.gltf", "300000 triangles in 300 objects", "node 0 'strip'", "157.5 MB", "--memory-limit 1G"]
    {
        assert!(said.contains(word), "'{word}' is not in: {said}");
    }
}

#[test]
fn what_is_called_the_same_shares_its_name() {
    let scene = read(&strips(2, 50), MemoryLimit::NONE).unwrap().build().unwrap();
    assert_eq!(scene.objects.len(), 50);
    assert!(scene.objects.iter().all(|object| Arc::ptr_eq(&object.name, &scene.objects[0].name)));
}
