//! Casts rays at a sphere on a plane and prints the image as text, shaded by the cosine to one light. Uses only this
//! crate.
//! `cargo run --release --example cast -p dapple-geometry`

use dapple_geometry::shapes::Sphere;
use dapple_geometry::{AccelBuilder, Mesh, Opaque};
use dapple_math::Ray;
use glam::Vec3;

fn main() {
    let mut builder = AccelBuilder::default();
    builder.add_sphere(Sphere { centre: Vec3::new(0.0, 1.0, 0.0), radius: 1.0 });
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    builder.add_mesh(Mesh {
        positions: vec![corner(-9.0, 9.0), corner(9.0, 9.0), corner(9.0, -9.0), corner(-9.0, -9.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    let accel = builder.build();
    let light = Vec3::new(1.0, 2.0, 1.5).normalize();
    for y in 0..28 {
        let row = (0..72).map(|x| {
            let d = Vec3::new((x as f32 - 36.0) / 36.0, (14.0 - y as f32) / 18.0 - 0.2, -1.6);
            let ray = Ray::new(Vec3::new(0.0, 1.6, 4.0), d);
            let Some(hit) = accel.intersect(&ray, 0.0, &Opaque) else { return ' ' };
            let surface = accel.surface(&ray, 0.0, &hit);
            let o = surface.origin_towards(light);
            let lit = if accel.occluded(&Ray::new(o, light), 0.0, &Opaque) {
                0.0
            } else {
                surface.ns.dot(light).max(0.0)
            };
            b".:-=+*#%@"[(lit * 8.99) as usize] as char
        });
        println!("{}", row.collect::<String>());
    }
}
