//! Many rays in one query have the hits of single rays, with every kernel, with and without a second level.
mod solids;

use dapple_geometry::bvh::Kernel;
use dapple_geometry::shapes::Sphere;
use dapple_geometry::{Accel, AccelBuilder, Hit, Mesh, Opaque, Rays};
use dapple_math::Ray;
use glam::Vec3;
use solids::{Noise, cube, sphere};

/// The columns of rays.
struct Columns([Vec<f32>; 7]);

impl Columns {
    fn new(rays: &[Ray]) -> Self {
        let numbers = |r: &Ray| [r.o.x, r.o.y, r.o.z, r.d.x, r.d.y, r.d.z, r.t_max];
        Self(std::array::from_fn(|k| rays.iter().map(|r| numbers(r)[k]).collect()))
    }

    fn rays(&self) -> Rays<'_> {
        let [x, y, z, dx, dy, dz, t_max] = &self.0;
        let is_infinite = t_max.iter().all(|t| *t == f32::INFINITY);
        Rays::new(x.len(), [x, y, z], [dx, dy, dz], if is_infinite { None } else { Some(t_max) })
    }
}

/// The kernel-independent part of a hit.
fn bits(hit: Option<Hit>) -> Option<[u32; 5]> {
    hit.map(|h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive, h.object])
}

/// Compares one query of all rays with single ones.
fn check(accel: &Accel, rays: &[Ray]) {
    let (mut hits, mut shadows) = (vec![None; rays.len()], vec![None; rays.len()]);
    let columns = Columns::new(rays);
    let mut set = |i: usize, hit| assert!(hits[i].replace(bits(hit)).is_none(), "ray {i} is found twice");
    accel.intersect_each(&columns.rays(), |_| 0.0, &mut set);
    let mut set = |i: usize, is_occluded| assert!(shadows[i].replace(is_occluded).is_none());
    accel.occluded_each(&columns.rays(), |_| 0.0, &mut set);
    for (i, ray) in rays.iter().enumerate() {
        let name = accel.kernel().name();
        assert_eq!(hits[i], Some(bits(accel.intersect(ray, 0.0, &Opaque))), "{name}, {ray:?}");
        assert_eq!(shadows[i], Some(accel.occluded(ray, 0.0, &Opaque)), "{name}, {ray:?}");
    }
}

fn with_every_kernel(build: impl Fn() -> AccelBuilder, rays: &[Ray]) {
    let single = build().build().with_kernel(Kernel::Portable);
    for kernel in Kernel::ALL {
        let accel = build().build().with_kernel(kernel);
        check(&accel, rays);
        for ray in rays {
            let hits = [&accel, &single].map(|accel| bits(accel.intersect(ray, 0.0, &Opaque)));
            assert_eq!(hits[0], hits[1], "{kernel:?}, {ray:?}");
        }
    }
}

fn with_meshes(meshes: &[Mesh], rays: &[Ray]) {
    let build = || {
        let mut builder = AccelBuilder::default();
        for mesh in meshes {
            builder.add_mesh(mesh.clone());
        }
        builder
    };
    with_every_kernel(build, rays);
}

/// Triangles that share no corners.
fn soup(triangles: &[[Vec3; 3]]) -> Mesh {
    Mesh {
        positions: triangles.concat(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

/// Random triangles of very different sizes, some of which share edges or are degenerate.
fn random_triangles(noise: &mut Noise, n: usize) -> Vec<[Vec3; 3]> {
    let mut all: Vec<[Vec3; 3]> = Vec::new();
    for i in 0..n {
        let size = 4f32.powf(noise.next() * 3.0);
        let p = noise.vec();
        let mut t = [p, p + noise.vec() * size, p + noise.vec() * size];
        if i % 3 == 1 {
            (t[0], t[1]) = (all[i - 1][1], all[i - 1][0]);
        }
        if i % 7 == 3 {
            t[2] = t[0].lerp(t[1], 0.5);
        }
        if i % 5 == 4 {
            t = t.map(|p| Vec3::new(p.x, p.y, 0.25));
        }
        all.push(t);
    }
    all
}

/// Rays from anywhere to points of triangles: inside, on edges, at corners, along edges, and in their planes.
fn aimed(noise: &mut Noise, triangles: &[[Vec3; 3]], n: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for i in 0..n {
        let [a, b, c] = triangles[noise.bits() as usize % triangles.len()];
        let (s, t) = (noise.unit(), noise.unit());
        let target = match i % 5 {
            0 => a,
            1 => a.lerp(b, s),
            2 => a.lerp(c, 0.5),
            _ => a.lerp(b, s).lerp(c, t),
        };
        let o = match i % 7 {
            0 => b,
            1 => c.lerp(b, t),
            2 => a.lerp(b, t).lerp(c, s),
            _ => noise.vec() * 3.0,
        };
        let end = [f32::INFINITY, 1.0, 1.0f32.next_up(), 1.0 - 1e-6, 0.5, noise.unit() * 2.0][i % 6];
        rays.push(Ray { o, d: target - o, t_max: end });
    }
    rays
}

/// Rays along axes, and such as no ray should be.
fn odd(noise: &mut Noise) -> Vec<Ray> {
    let mut rays = Vec::new();
    for i in 0..120 {
        let mut d = Vec3::ZERO;
        d[i % 3] = [1.0, -1.0, 3e-20, -1e30, 65535.0, 1.6e-5][i / 3 % 6];
        d[(i + 1) % 3] = if i % 2 == 0 { 0.0 } else { -0.0 };
        rays.push(Ray::new((noise.vec() * 4.0).round() * 0.5, d));
    }
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, 3e38, -1e-42];
    for i in 0..60 {
        let mut ray = Ray::new(noise.vec() * 2.0, noise.direction());
        let x = bad[i / 7 % 6];
        match i % 7 {
            k @ 0..=2 => ray.o[k] = x,
            k @ 3..=5 => ray.d[k - 3] = x,
            _ => ray.t_max = x,
        }
        rays.push(ray);
    }
    rays.extend([-1.0, 0.0, f32::NAN, 0.5].map(|t_max| Ray::new(Vec3::Z * 3.0, -Vec3::Z).until(t_max)));
    rays
}

fn random(noise: &mut Noise, n: usize) -> Vec<Ray> {
    (0..n).map(|_| Ray::new(noise.vec() * 3.0, noise.direction())).collect()
}

#[test]
fn many_rays_have_the_hits_of_single_rays_with_a_second_level() {
    let mut noise = Noise(5);
    let mut rays = random(&mut noise, 500);
    rays.extend(odd(&mut noise));
    for has_cube in [false, true] {
        let build = || {
            let mut builder = AccelBuilder::default();
            if has_cube {
                builder.add_mesh(cube(1.0, Vec3::ZERO));
            }
            builder.add_sphere(Sphere { centre: Vec3::new(0.4, 0.2, 0.9), radius: 0.5 });
            builder
        };
        with_every_kernel(build, &rays);
    }
    with_every_kernel(AccelBuilder::default, &rays);
}

#[test]
fn any_number_of_rays_fills_packets() {
    let mut noise = Noise(6);
    let rays = random(&mut noise, 40);
    for n in 0..=40 {
        with_meshes(&[cube(1.0, Vec3::ZERO)], &rays[..n]);
    }
}

#[test]
fn bodies_of_many_sizes() {
    let mut noise = Noise(7);
    let mut rays = random(&mut noise, 1500);
    rays.extend(odd(&mut noise));
    for (level, offset) in [(0, 0.0), (1, 0.0), (2, 100.0), (3, 0.0)] {
        let offset = Vec3::new(offset, -offset, offset);
        let moved: Vec<Ray> = rays.iter().map(|r| Ray { o: r.o + offset, ..*r }).collect();
        with_meshes(&[sphere(level, 1.0, offset), cube(2.5, offset)], &moved);
    }
}

#[test]
fn edges_corners_and_planes_of_random_triangles() {
    let mut noise = Noise(8);
    for n in [1, 2, 7, 8, 9, 20, 60, 110, 128, 129, 200, 256, 257] {
        for scale in [1.0, 1e-20, 3e18] {
            let triangles = random_triangles(&mut noise, n);
            let mut rays = aimed(&mut noise, &triangles, 800);
            rays.extend(odd(&mut noise));
            let scaled: Vec<_> = triangles.iter().map(|t| t.map(|p| p * scale)).collect();
            let rays: Vec<_> =
                rays.into_iter().map(|r| Ray { o: r.o * scale, d: r.d * scale, ..r }).collect();
            with_meshes(&[soup(&scaled)], &rays);
        }
    }
}

/// The same triangles again and again, and their copies with other ids.
#[test]
fn coincident_triangles() {
    let mut noise = Noise(9);
    let triangles = random_triangles(&mut noise, 12);
    let mut many = triangles.repeat(8);
    many.reverse();
    let rays = aimed(&mut noise, &triangles, 3000);
    with_meshes(&[soup(&triangles), soup(&many), soup(&triangles)], &rays);
    // All rays of a packet meet a hundred triangles on their edges.
    let fan: Vec<_> = (0..120).map(|_| [Vec3::ZERO, Vec3::X, noise.vec()]).collect();
    let rays: Vec<_> = (0..100).map(|_| noise.vec()).map(|o| Ray::new(o, Vec3::X * 0.5 - o)).collect();
    with_meshes(&[soup(&fan)], &rays);
}

/// Rays that start on triangles or just beside them, and end there.
#[test]
fn rays_between_surfaces() {
    let mut noise = Noise(10);
    let room = [cube(3.0, Vec3::ZERO), cube(0.5, Vec3::new(0.3, -2.5, 0.2)), sphere(1, 0.7, Vec3::X)];
    let mut builder = AccelBuilder::default();
    for mesh in &room {
        builder.add_mesh(mesh.clone());
    }
    let accel = builder.build();
    let mut rays = Vec::new();
    while rays.len() < 4000 {
        let ray = Ray::new(noise.vec() * 2.9, noise.direction());
        let Some(hit) = accel.intersect(&ray, 0.0, &Opaque) else { continue };
        let surface = accel.surface(&ray, 0.0, &hit);
        let d = noise.direction();
        rays.extend([Ray::new(surface.p, d), Ray::new(surface.origin_towards(d), d), ray.until(hit.t)]);
        rays.extend([ray.until(hit.t.next_up()), ray.until(hit.t * (1.0 + 3e-5))]);
        rays.push(Ray { o: surface.p + d * 1e-5, d: ray.o - surface.p, t_max: 1.0 });
    }
    with_meshes(&room, &rays);
}
