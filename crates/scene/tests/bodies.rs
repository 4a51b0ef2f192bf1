//! Bodies: their boundaries, their precedence, and the properties in files that define it.
#![cfg(feature = "gltf")]

mod file;

use dapple_geometry::Mesh;
use dapple_materials::Material;
use dapple_scene::{Scene, SceneBuilder, SceneError, TexturedMaterial, WorldPoint, gltf};
use file::{File, json};
use glam::{DAffine3, DVec3, Vec3};
use serde_json::Value;
use std::path::Path;

const NONE: u32 = u32::MAX;

fn solid(ior: f32, priority: f64) -> TexturedMaterial {
    let base = Material { metallic: 0.0, ior, transmission: 1.0, thin: false, ..Material::default() };
    TexturedMaterial { base, priority, ..TexturedMaterial::default() }
}

fn tetrahedron(size: f32) -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X * size, Vec3::Y * size, Vec3::Z * size],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Mesh::default()
    }
}

fn ranks(scene: &Scene) -> Vec<u32> {
    scene.objects.iter().map(|object| object.body).collect()
}

#[test]
fn the_strongest_body_comes_first() {
    let mut builder = SceneBuilder::new("test");
    let plain = builder.material(TexturedMaterial::lambert("plain", Vec3::ONE));
    let weak = builder.material(solid(1.1, -1.0));
    let even = builder.material(solid(1.2, 0.0));
    let strong = builder.material(solid(1.3, 2.5));
    let thin = builder.material(TexturedMaterial {
        base: Material { thin: true, ..solid(1.4, 9.0).base },
        ..solid(1.4, 9.0)
    });
    let metal = builder.material(TexturedMaterial {
        base: Material { metallic: 1.0, ..solid(1.4, 9.0).base },
        ..solid(1.4, 9.0)
    });
    let at = |x: f64| DAffine3::from_translation(DVec3::X * x);
    builder.mesh("plain", tetrahedron(1.0), at(0.0), plain);
    builder.mesh("weak", tetrahedron(0.1), at(1.0), weak);
    builder.mesh("large", tetrahedron(2.0), at(2.0), even);
    // Ranked by its placed size, between the sphere and the large body; the next object is flat and bounds no volume.
    builder.mesh("small", tetrahedron(0.5), DAffine3::from_scale(DVec3::splat(3.0)), even);
    let quad = Mesh { triangles: vec![[0, 1, 2]], ..tetrahedron(1.0) };
    builder.mesh("flat", quad, at(0.3), even);
    builder.sphere("sphere", DVec3::Y * 9.0, 0.25, even);
    builder.mesh("strong", tetrahedron(5.0), at(7.0), strong);
    builder.mesh("thin", tetrahedron(1.0), at(3.0), thin);
    builder.mesh("metal", tetrahedron(1.0), at(4.0), metal);
    let scene = builder.build().unwrap();
    assert_eq!(ranks(&scene), [NONE, 5, 3, 2, 4, 1, 0, NONE, NONE]);
    let iors: Vec<f32> = scene.bodies.all.iter().map(|body| body.ior).collect();
    assert_eq!(iors, [1.3, 1.2, 1.2, 1.2, 1.2, 1.1]);
    let (lo, hi) = scene.bodies.bounds.unwrap();
    let corner = scene.space.to_render(WorldPoint(DVec3::new(12.0, 0.0, 0.0)));
    assert!(hi.x >= corner.x && hi.x - corner.x < 1e-4 * (hi.x - lo.x) && lo.x < hi.x);
}

#[test]
fn equal_bodies_are_ranked_by_their_nodes_wherever_they_stand() {
    for turn in [0.0, 0.7, 2.0] {
        let mut builder = SceneBuilder::new("test");
        let of = builder.material(solid(1.5, 0.0));
        for (node, x) in [(7, 0.0), (3, 0.123), (5, -0.77)] {
            let place = DAffine3::from_rotation_y(turn) * DAffine3::from_translation(DVec3::new(x, 0.1, 0.3));
            let i = builder.mesh("body", tetrahedron(1.0), place, of);
            builder.one_body(i..i + 1, node);
        }
        assert_eq!(ranks(&builder.build().unwrap()), [2, 0, 1]);
    }
}

#[test]
fn objects_of_one_body_share_it_and_differences_are_told() {
    let mut builder = SceneBuilder::new("test");
    let (a, b) = (builder.material(solid(1.5, 0.0)), builder.material(solid(1.3, 0.0)));
    let plain = builder.material(TexturedMaterial::lambert("plain", Vec3::ONE));
    let first = builder.mesh("vase", tetrahedron(1.0), DAffine3::IDENTITY, a);
    builder.mesh("vase", tetrahedron(0.5), DAffine3::IDENTITY, plain);
    builder.mesh("vase", tetrahedron(0.5), DAffine3::IDENTITY, b);
    builder.one_body(first..first + 3, 4);
    let scene = builder.build().unwrap();
    assert_eq!(ranks(&scene), [0, NONE, 0]);
    assert_eq!(scene.bodies.all[0].ior, 1.5);
    assert!(scene.warnings.iter().any(|w| w.0.contains("'vase'")), "{:?}", scene.warnings);
}

/// Two instances of a mesh with two primitives, and a mesh with one primitive, with extras on the materials.
fn glasses(extras: [Value; 2]) -> Result<Scene, SceneError> {
    let mut file = File::new();
    let positions = file.floats(&tetrahedron(1.0).positions.iter().map(|p| p.to_array()).collect::<Vec<_>>());
    let indices = file.indices_u16(&[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    let primitive =
        |m: usize| json!({"attributes": {"POSITION": positions}, "indices": indices, "material": m});
    let glass = |extras: &Value| {
        json!({"extras": extras, "pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 1},
        }})
    };
    file.set("materials", json!([glass(&extras[0]), glass(&extras[1])]));
    file.set("meshes", json!([{"primitives": [primitive(0), primitive(0)]}, {"primitives": [primitive(1)]}]));
    let places = file.floats(&[[0.0, 0.0, 0.0], [0.0, 0.0, 5.0_f32]]);
    let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    file.set("nodes", json!([{"mesh": 0, "extensions": instancing}, {"mesh": 1, "scale": [9, 9, 9]}]));
    file.set("scenes", json!([{"nodes": [0, 1]}]));
    file.set(
        "extensionsUsed",
        json!(["EXT_mesh_gpu_instancing", "KHR_materials_transmission", "KHR_materials_volume"]),
    );
    gltf::read_bytes(Path::new("glasses.gltf"), &file.gltf(), &gltf::Options::default())?.build()
}

#[test]
fn files_say_which_body_wins() {
    // Every instance is one body that consists of both primitives.
    assert_eq!(ranks(&glasses([json!({}), json!({})]).unwrap()), [0, 0, 1, 1, 2]);
    let larger = json!({"dapple": {"priority": 1}});
    assert_eq!(ranks(&glasses([json!({}), larger.clone()]).unwrap()), [1, 1, 2, 2, 0]);
    assert_eq!(ranks(&glasses([json!({"priority": 2.5}), larger]).unwrap()), [0, 0, 1, 1, 2]);
    let error = glasses([json!({"dapple": {"priority": "high"}}), json!({})]).unwrap_err().to_string();
    assert!(error.contains("material 0") && error.contains("priority"), "{error}");
    let scene = glasses([json!({"priority": "high"}), json!({})]).unwrap();
    assert!(scene.warnings.iter().any(|w| w.0.contains("priority")), "{:?}", scene.warnings);
}
