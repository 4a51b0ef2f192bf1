//! Closed bodies and a random number generator for the tests of this crate.
#![allow(dead_code)]
use dapple_geometry::{Accel, Hit, Mesh, Opaque};
use dapple_math::Ray;
use glam::Vec3;

/// SplitMix64, converted to numbers in [−1, 1).
pub struct Noise(pub u64);

impl Noise {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    }
    pub fn next(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 8_388_608.0 - 1.0
    }
    /// A number in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }
    pub fn vec(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
    /// A uniformly distributed direction.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vec();
            if v.length() <= 1.0 && v.length() > 0.1 {
                return v.normalize();
            }
        }
    }
    /// A unit direction with n·d = `cosine` and a random azimuth about n.
    pub fn about(&mut self, n: Vec3, cosine: f64) -> Vec3 {
        let n = n.as_dvec3();
        loop {
            let v = self.direction().as_dvec3();
            let across = v - n * v.dot(n);
            if across.length() > 0.1 {
                return (n * cosine + across.normalize() * (1.0 - cosine * cosine).sqrt()).as_vec3();
            }
        }
    }
}

/// Closed cube of half side `r` with outward winding.
pub fn cube(r: f32, offset: Vec3) -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - Vec3::ONE;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(|i| corner(i) * r + offset).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
        ..Mesh::default()
    }
}

/// Closed octasphere: an octahedron subdivided `level` times, with outward winding and smooth normals.
pub fn sphere(level: u32, r: f32, offset: Vec3) -> Mesh {
    let mut positions = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..level {
        let mut middles = std::collections::HashMap::new();
        let mut next = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    positions.push((positions[i as usize] + positions[j as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = next;
    }
    Mesh {
        normals: positions.clone(),
        positions: positions.iter().map(|p| *p * r + offset).collect(),
        triangles,
        ..Mesh::default()
    }
}

/// Whether every corner lies behind every face, computed in f64.
pub fn is_convex(mesh: &Mesh) -> bool {
    (0..mesh.triangles.len() as u32).all(|t| {
        let [a, b, c] = mesh.corners(t).map(|p| p.as_dvec3());
        let n = (b - a).cross(c - a);
        let own = mesh.triangles[t as usize];
        let behind = |i: usize| own.contains(&(i as u32)) || n.dot(mesh.positions[i].as_dvec3() - a) < 0.0;
        (0..mesh.positions.len()).all(behind)
    })
}

/// Casts rays from a hit on a convex body: outside, nothing may be hit, and inside exactly one more surface. The
/// outside is the side `ng` points to. Returns (outgoing rays that hit, ingoing rays without exactly one hit).
pub fn leave(
    accel: &Accel,
    noise: &mut Noise,
    ray: &Ray,
    time: f32,
    hit: &Hit,
    rays: usize,
) -> (usize, usize) {
    let s = accel.surface(ray, time, hit);
    assert!(s.p.is_finite() && s.p_error.is_finite() && (s.ng.length() - 1.0).abs() < 1e-6, "{s:?}");
    let (mut out, mut into) = (0, 0);
    for _ in 0..rays {
        // From grazing (1e-6) to perpendicular, with a uniformly distributed exponent.
        let cosine = 10f64.powf(-6.0 * f64::from(noise.unit()));
        let d = noise.about(s.ng, cosine);
        let ray = Ray::new(s.origin_towards(d), d);
        out += usize::from(accel.occluded(&ray, time, &Opaque));
        let d = -d;
        let ray = Ray::new(s.origin_towards(d), d);
        into += usize::from(!match accel.intersect(&ray, time, &Opaque) {
            None => false,
            Some(hit) => {
                let far = accel.surface(&ray, time, &hit);
                // Tilted towards the normal: a ray that has passed along the neighbouring face (1e-6 rad) misses its
                // edge by less than any f32 test can resolve.
                let d = d + far.ng;
                far.ng.dot(d) > 0.0 && !accel.occluded(&Ray::new(far.origin_towards(d), d), time, &Opaque)
            }
        });
    }
    (out, into)
}
