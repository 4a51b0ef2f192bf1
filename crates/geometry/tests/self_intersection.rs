//! Tests that a ray leaving a surface does not hit it again, and that a ray entering a body hits its other side:
//! origins are moved just out of their error bound (docs/science.md, "Leaving a surface").
mod solids;

use dapple_geometry::shapes::{Disk, Sphere};
use dapple_geometry::{Accel, AccelBuilder, Hit, Mesh, Opaque};
use dapple_math::Ray;
use glam::Vec3;
use solids::{Noise, cube, is_convex, leave, sphere};

/// Radius and offset. A body smaller than 1e5 ulp of its coordinates (1e-3 at 1e3) is omitted, because the error bound
/// extends through it.
const CASES: [(f32, f32); 7] =
    [(1e-3, 0.0), (1.0, 0.0), (1e3, 0.0), (1.0, 1e3), (1e3, 1e3), (1.0, 1e5), (1e3, 1e5)];

fn accel_of(mesh: Mesh) -> Accel {
    let mut builder = AccelBuilder::default();
    builder.add_mesh(mesh);
    builder.build()
}

fn check(accel: &Accel, r: f32, offset: Vec3, name: &str) {
    let mut noise = Noise(11);
    let (mut out, mut into) = (0, 0);
    for _ in 0..400 {
        let d = noise.direction();
        let ray = Ray::new(offset + noise.vec() * (0.3 * r) - d * (4.0 * r), d);
        let hit = accel.intersect(&ray, 0.0, &Opaque).expect("aimed at the body");
        // If a coordinate is rounded to the neighbouring wall, the point lies on both walls, and neither side is wrong.
        let q = (accel.surface(&ray, 0.0, &hit).p - offset).abs();
        if name == "cube" && [q.x == r, q.y == r, q.z == r].iter().filter(|&&on| on).count() != 1 {
            continue;
        }
        let bad = leave(accel, &mut noise, &ray, 0.0, &hit, 100);
        out += bad.0;
        into += bad.1;
    }
    assert_eq!((out, into), (0, 0), "{name} radius {r} at {offset}");
}

#[test]
fn convex_bodies_are_left_and_entered_once() {
    for (r, shift) in CASES {
        let offset = Vec3::new(shift, -shift, shift);
        check(&accel_of(cube(r, offset)), r, offset, "cube");
        let ball = sphere(1, r, offset);
        assert!(is_convex(&ball), "rounding of corners dents the ball: {r} {shift}");
        check(&accel_of(ball), r, offset, "ball of triangles");
        let mut builder = AccelBuilder::default();
        builder.add_sphere(Sphere { centre: offset, radius: r });
        check(&builder.build(), r, offset, "exact sphere");
    }
}

#[test]
fn no_leak_beside_a_concave_edge() {
    for (r, shift) in CASES {
        let offset = Vec3::new(shift, -shift, shift);
        let accel = accel_of(cube(r, offset));
        let mut noise = Noise(5);
        let (mut leaks, mut back) = (0, 0);
        for i in 0..20_000u32 {
            // A few ulp from one of the edges of a wall.
            let tiny = f32::EPSILON * (1 + i % 4) as f32;
            let s = noise.unit();
            let (u, v) = [(tiny, s), (s, tiny), (s, 1.0 - s - tiny)][(i % 3) as usize];
            let hit = Hit { t: 1.0, u, v: v.max(0.0), primitive: i % 12, object: 0 };
            let surface = accel.surface(&Ray::new(Vec3::ZERO, Vec3::X), 0.0, &hit);
            // If a coordinate is rounded to the neighbouring wall, the point lies on both walls, and neither side is
            // wrong.
            let q = (surface.p - offset).abs();
            if [q.x == r, q.y == r, q.z == r].iter().filter(|&&on| on).count() != 1 {
                continue;
            }
            let d = noise.about(surface.ng, f64::from(noise.0 as u32) / 4.3e9 * 0.999 + 1e-6);
            back += usize::from(accel.occluded(&Ray::new(surface.origin_towards(d), d), 0.0, &Opaque));
            let inward = Ray::new(surface.origin_towards(-d), -d);
            leaks += usize::from(accel.intersect(&inward, 0.0, &Opaque).is_none());
        }
        assert_eq!((leaks, back), (0, 0), "radius {r} at {shift}");
    }
}

#[test]
fn a_grazing_hit_lies_on_its_plane() {
    // A square of side 1e6 with a tilted horizon, seen from height 1 at angles down to 1e-4 rad.
    let (x, z) = (Vec3::new(0.96, 0.28, 0.0), Vec3::new(-0.168, 0.576, 0.8));
    let up = x.cross(z) * -1.0;
    let corner = |a: f32, b: f32| x * (a * 5e5) + z * (b * 5e5);
    let accel = accel_of(Mesh {
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    let mut noise = Noise(3);
    for i in 0..40_000 {
        let below = 1e-4 * 10f32.powf(4.0 * noise.unit());
        let angle = i as f32;
        let d = (x * angle.cos() + z * angle.sin()) - up * below;
        let ray = Ray::new(up, d);
        let hit = accel.intersect(&ray, 0.0, &Opaque).expect("aimed at the plane");
        let s = accel.surface(&ray, 0.0, &hit);
        let [a, b, c] = accel.corners(0, hit.primitive).map(|p| p.as_dvec3());
        let n = (b - a).cross(c - a).normalize();
        let residual = n.dot(s.p.as_dvec3() - a).abs();
        assert!(residual <= n.abs().dot(s.p_error.as_dvec3()), "{residual} at {below}");
        // The next ray leaves the surface at any grazing angle.
        let d = noise.about(s.ng, 1e-6);
        assert!(!accel.occluded(&Ray::new(s.origin_towards(d), d), 0.0, &Opaque));
    }
}

#[test]
fn a_disk_is_left_on_both_sides() {
    let mut noise = Noise(9);
    for (radius, shift) in CASES {
        let centre = Vec3::splat(shift);
        let normal = Vec3::new(0.48, -0.6, 0.64);
        let mut builder = AccelBuilder::default();
        builder.add_disk(Disk { centre, normal, radius });
        let accel = builder.build();
        for _ in 0..5000 {
            let d = noise.direction();
            let ray = Ray::new(centre - d * radius, d);
            let Some(hit) = accel.intersect(&ray, 0.0, &Opaque) else { continue };
            let s = accel.surface(&ray, 0.0, &hit);
            for side in [1.0, -1.0] {
                let d = noise.about(s.ng, 1e-6) * side;
                assert!(!accel.occluded(&Ray::new(s.origin_towards(d), d), 0.0, &Opaque), "{radius} {shift}");
            }
        }
    }
}
