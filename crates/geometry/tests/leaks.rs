//! Tests that no ray leaves a closed mesh (watertight test of [Woop 2013] plus conservative boxes) on any kernel, and
//! that all kernels agree bit for bit.

use dapple_geometry::bvh::{Kernel, Opaque, Tree, TriangleHit};
use dapple_math::Ray;
use glam::Vec3;

/// SplitMix64, converted to numbers in [−1, 1).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 40) as f32 / 8_388_608.0 - 1.0
    }
    fn vec(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

/// Icosphere by subdivision; shared corners are exactly equal.
fn icosphere(level: u32, scale: f32, offset: Vec3) -> Vec<[Vec3; 3]> {
    let p = (1.0 + 5f32.sqrt()) / 2.0;
    let v = |x: f32, y: f32, z: f32| Vec3::new(x, y, z).normalize();
    let c =
        [v(-1.0, p, 0.0), v(1.0, p, 0.0), v(-1.0, -p, 0.0), v(1.0, -p, 0.0), v(0.0, -1.0, p), v(0.0, 1.0, p)];
    let d = [
        v(0.0, -1.0, -p),
        v(0.0, 1.0, -p),
        v(p, 0.0, -1.0),
        v(p, 0.0, 1.0),
        v(-p, 0.0, -1.0),
        v(-p, 0.0, 1.0),
    ];
    let c: Vec<Vec3> = c.into_iter().chain(d).collect();
    let faces = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let mut triangles: Vec<[Vec3; 3]> = faces.iter().map(|f| f.map(|i: usize| c[i])).collect();
    for _ in 0..level {
        triangles = triangles
            .iter()
            .flat_map(|[a, b, c]| {
                // Midpoints computed from the sum are equal for both triangles of an edge.
                let [ab, bc, ca] = [(*a + *b).normalize(), (*b + *c).normalize(), (*c + *a).normalize()];
                [[*a, ab, ca], [*b, bc, ab], [*c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    // Slightly uneven, so that no symmetry hides an error.
    triangles
        .iter()
        .map(|t| t.map(|p| p * (1.0 + 0.1 * (p.x * 7.0).sin() * (p.y * 5.0).cos()) * scale + offset))
        .collect()
}

/// Casts rays from inside: 40 % random, 40 % at edges, 15 % at vertices, 5 % along axes. Returns how many escape, and a
/// digest of the hits.
fn escapes(tree: &Tree, triangles: &[[Vec3; 3]], scale: f32, offset: Vec3, rays: u64) -> (u64, u64) {
    let mut noise = Noise(7);
    let (mut missed, mut digest) = (0, 0u64);
    for i in 0..rays {
        let o = offset + noise.vec() * (0.4 * scale);
        let t = &triangles[(noise.next().abs() * triangles.len() as f32) as usize % triangles.len()];
        let d = match i % 20 {
            0..8 => noise.vec(),
            8..16 => t[0] + (t[1] - t[0]) * noise.next().abs() - o,
            16..19 => t[2] - o,
            _ => [Vec3::X, -Vec3::Y, Vec3::Z][(i / 20 % 3) as usize],
        };
        if d == Vec3::ZERO {
            continue;
        }
        match tree.intersect(&Ray::new(o, d.normalize()), &Opaque) {
            Some(h) => {
                let bits = [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.triangle];
                digest = bits
                    .iter()
                    .fold(digest, |d, &b| (d ^ u64::from(b)).wrapping_mul(0x100_0000_01B3).rotate_left(9));
            }
            None => missed += 1,
        }
    }
    (missed, digest)
}

fn check(level: u32, rays: u64, cases: &[(f32, f32)]) {
    for &(scale, shift) in cases {
        let offset = Vec3::splat(shift);
        let triangles = icosphere(level, scale, offset);
        let mut digests = Vec::new();
        for kernel in Kernel::available() {
            let tree = Tree::build(&triangles).with_kernel(kernel);
            let (missed, digest) = escapes(&tree, &triangles, scale, offset, rays);
            assert_eq!(missed, 0, "{} scale {scale} offset {shift}", kernel.name());
            digests.push(digest);
        }
        assert!(digests.windows(2).all(|d| d[0] == d[1]), "kernels disagree at scale {scale} offset {shift}");
    }
}

#[test]
fn no_ray_escapes_at_any_scale_and_offset() {
    check(
        4,
        60_000,
        &[(1.0, 0.0), (1e-4, 0.0), (1e4, 0.0), (1e-12, 0.0), (1.0, 1e3), (1.0, 1e5), (1e2, 1e6)],
    );
}

#[test]
#[ignore = "long: 1e7 rays on every kernel"]
fn ten_million_rays_and_none_escapes() {
    check(4, 10_000_000, &[(1.0, 0.0)]);
}

/// Rays with unit directions from inside a tessellated sphere, and their hits.
fn from_inside(rays: usize) -> (Tree, Vec<(Ray, TriangleHit)>) {
    let tree = Tree::build(&icosphere(3, 1.0, Vec3::ZERO));
    let mut noise = Noise(3);
    let mut ray = || Ray::new(noise.vec() * 0.4, noise.vec().normalize());
    let hits = (0..rays).map(|_| ray()).map(|ray| (ray, tree.intersect(&ray, &Opaque).unwrap())).collect();
    (tree, hits)
}

#[test]
fn scaled_directions_hit_the_same() {
    let (tree, hits) = from_inside(2000);
    for (ray, expected) in hits {
        for k in -30..=30 {
            let factor = 10f32.powi(k);
            let hit = tree.intersect(&Ray::new(ray.o, ray.d * factor), &Opaque).unwrap();
            let t = f64::from(hit.t) * f64::from(factor);
            assert!((t / f64::from(expected.t) - 1.0).abs() < 1e-5, "1e{k}: {t} {}", expected.t);
        }
    }
}

#[test]
fn directions_of_twice_the_length_hit_with_the_same_bits() {
    let (tree, hits) = from_inside(500);
    for (ray, expected) in hits {
        let ends = [expected.t.next_down(), expected.t, expected.t.next_up()]
            .map(|t_max| (t_max, tree.occluded(&ray.until(t_max), &Opaque)));
        for k in -100..=120 {
            let factor = 2f32.powi(k);
            let longer = Ray::new(ray.o, ray.d * factor);
            let hit = tree.intersect(&longer, &Opaque).unwrap();
            assert_eq!(TriangleHit { t: hit.t * factor, ..hit }, expected, "2^{k}");
            for (t_max, blocked) in ends {
                assert_eq!(tree.occluded(&longer.until(t_max / factor), &Opaque), blocked, "2^{k}");
            }
        }
    }
}

#[test]
fn coincident_and_degenerate_triangles_end() {
    let quad = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut many = vec![quad; 100_000];
    many.push([Vec3::ZERO; 3]);
    many.push([Vec3::NAN, Vec3::X, Vec3::Y]);
    many.push([Vec3::splat(f32::INFINITY), Vec3::X, Vec3::Y]);
    for kernel in Kernel::available() {
        let tree = Tree::build(&many).with_kernel(kernel);
        let hit = tree.intersect(&Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z), &Opaque).unwrap();
        assert_eq!((hit.triangle, hit.t), (0, 1.0));
    }
    assert!(Tree::build(&[]).intersect(&Ray::new(Vec3::ZERO, Vec3::X), &Opaque).is_none());
}

#[test]
fn rays_in_face_planes_and_along_axes_hit() {
    // A closed axis-aligned box, with orthographic rays through its edges and faces.
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[Vec3; 3]> =
        quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)).collect();
    for kernel in Kernel::available() {
        let tree = Tree::build(&triangles).with_kernel(kernel);
        for i in 0..=16 {
            for j in 0..=16 {
                let (a, b) = (i as f32 / 16.0, j as f32 / 16.0);
                for (o, d) in [
                    (Vec3::new(a, b, 3.0), -Vec3::Z),
                    (Vec3::new(3.0, a, b), -Vec3::X),
                    (Vec3::new(a, -3.0, b), Vec3::Y),
                ] {
                    let t = tree.intersect(&Ray::new(o, d), &Opaque).map(|h| h.t);
                    assert!(t.is_some(), "{} {o} {d}", kernel.name());
                }
            }
        }
    }
}

/// Strips of a wall, cut along an axis, with rays from nearby to points beside the cuts. The edge test locates a cut to
/// within roundings of the length of the strips, the box test to within roundings of the length of the ray; only padded
/// boxes contain both.
#[test]
fn rays_to_the_cuts_of_a_wall_from_near_by_hit() {
    for turn in 0..3 {
        let turned = |p: Vec3| [p, Vec3::new(p.y, p.z, p.x), Vec3::new(p.z, p.x, p.y)][turn];
        let strip = |k: i32| {
            let (a, b) = (k as f32 / 8.0, (k + 1) as f32 / 8.0);
            let corners =
                [(a, -1.0), (b, -1.0), (b, 1.0), (a, 1.0)].map(|(x, y)| turned(Vec3::new(x, y, 0.0)));
            [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
        };
        let triangles: Vec<[Vec3; 3]> = (-8..8).flat_map(strip).collect();
        for kernel in Kernel::available() {
            let tree = Tree::build(&triangles).with_kernel(kernel);
            let mut noise = Noise(13);
            let missed = (0..100_000).filter(|i| {
                let cut = (noise.next() * 7.4).round() / 8.0;
                let target = Vec3::new(cut + 1e-7 * noise.next(), 0.9 * noise.next(), 0.0);
                let d = noise.vec().normalize();
                let o = target - d * 10f32.powi(-1 - i % 5);
                o.z * d.z < 0.0 && tree.intersect(&Ray::new(turned(o), turned(d)), &Opaque).is_none()
            });
            assert_eq!(missed.count(), 0, "{} turn {turn}", kernel.name());
        }
    }
}
