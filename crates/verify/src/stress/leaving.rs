//! Stress cases A11, A13: rays that leave a surface do not hit it again.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{ball, cube};
use crate::tally::Tally;
use dapple_integrator::geometry::shapes::Sphere;
use dapple_integrator::geometry::{Accel, AccelBuilder, Hit, Mesh, Opaque};
use dapple_integrator::math::Ray;
use glam::{DQuat, DVec2, Vec3};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A11",
        title: "a convex body does not shadow itself",
        naive: "a fixed offset is too small far from the origin (shadow acne) and too large near it (missed walls)",
        source: "Pharr, Jakob & Humphreys 2023, §6.8; docs/science.md, \"Leaving a surface\"",
        check: Check::Run(convex),
    },
    Case {
        id: "A13",
        title: "grazing hits lie on their plane",
        naive: "o + t·d is wrong by t·2⁻²⁴, many times its height above the plane",
        source: "Pharr, Jakob & Humphreys 2023, §6.8; docs/science.md, \"Leaving a surface\"",
        check: Check::Run(grazing),
    },
];

/// Radius and offset. Bodies smaller than 1e5 ulp of their coordinates are excluded, because the error bound itself
/// exceeds their size.
const BODIES: [(f32, f32); 7] =
    [(1e-3, 0.0), (1.0, 0.0), (1e3, 0.0), (1.0, 1e3), (1e3, 1e3), (1.0, 1e5), (1e3, 1e5)];

fn accel_of(mesh: Mesh) -> Accel {
    let mut builder = AccelBuilder::default();
    builder.add_mesh(mesh);
    builder.build()
}

/// Shoots rays from a hit, outward and inward, from grazing (cosine 1e-6) to perpendicular. Returns the number of
/// outgoing rays that hit, and of ingoing rays that do not hit exactly once.
fn leave(accel: &Accel, noise: &mut Noise, ray: &Ray, hit: &Hit, rays: usize) -> [u64; 2] {
    let s = accel.surface(ray, 0.0, hit);
    let mut wrong = [0; 2];
    for _ in 0..rays {
        let cosine = 10f64.powf(-6.0 * f64::from(noise.unit()));
        let d = noise.about(s.ng, cosine);
        wrong[0] += u64::from(accel.occluded(&Ray::new(s.origin_towards(d), d), 0.0, &Opaque));
        let into = Ray::new(s.origin_towards(-d), -d);
        let once = accel.intersect(&into, 0.0, &Opaque).is_some_and(|hit| {
            let far = accel.surface(&into, 0.0, &hit);
            // The body is left along the mean of ray and normal: a ray along the neighbouring face passes its edge at a
            // distance that f32 cannot resolve.
            let d = far.ng - d;
            far.ng.dot(d) > 0.0 && !accel.occluded(&Ray::new(far.origin_towards(d), d), 0.0, &Opaque)
        });
        wrong[1] += u64::from(!once);
    }
    wrong
}

fn body(tally: &mut Tally, name: &str, accel: &Accel, r: f32, offset: Vec3, effort: Effort) {
    let (mut noise, mut sum) = (Noise(11), [0; 2]);
    for _ in 0..effort.of(20, 300, 10_000) {
        let d = noise.direction();
        let ray = Ray::new(offset + noise.cube() * (0.3 * r) - d * (4.0 * r), d);
        let Some(hit) = accel.intersect(&ray, 0.0, &Opaque) else {
            sum[1] += 1;
            continue;
        };
        let wrong = leave(accel, &mut noise, &ray, &hit, 50);
        sum = [sum[0] + wrong[0], sum[1] + wrong[1]];
    }
    tally.none(format!("outgoing rays that hit the {name} of radius {r} at {}", offset.x), sum[0]);
    tally.none(format!("ingoing rays without exactly one hit, {name} of radius {r} at {}", offset.x), sum[1]);
}

fn convex(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (r, shift) in BODIES {
        let offset = Vec3::new(shift, -shift, shift);
        body(&mut tally, "cube", &accel_of(cube(r, offset)), r, offset, effort);
        body(&mut tally, "ball of triangles", &accel_of(ball(1, r, offset)), r, offset, effort);
        let mut builder = AccelBuilder::default();
        builder.add_sphere(Sphere { centre: offset, radius: r });
        body(&mut tally, "exact sphere", &builder.build(), r, offset, effort);
    }
    tally.finish()
}

/// From points a few ulp from the edges of a cube, inward rays must hit a wall and outward rays none.
pub(super) fn beside_edges(tally: &mut Tally, points: u32) {
    for (r, shift) in BODIES {
        let offset = Vec3::new(shift, -shift, shift);
        let accel = accel_of(cube(r, offset));
        let (mut noise, mut leaks, mut back) = (Noise(5), 0, 0);
        for i in 0..points {
            let (tiny, s) = (f32::EPSILON * (1 + i % 4) as f32, noise.unit());
            let (u, v) = [(tiny, s), (s, tiny), (s, 1.0 - s - tiny)][(i % 3) as usize];
            let hit = Hit { t: 1.0, u, v: v.max(0.0), primitive: i % 12, object: 0 };
            let surface = accel.surface(&Ray::new(Vec3::ZERO, Vec3::X), 0.0, &hit);
            let cosine = f64::from(noise.unit()) * 0.999 + 1e-6;
            let d = noise.about(surface.ng, cosine);
            back += u64::from(accel.occluded(&Ray::new(surface.origin_towards(d), d), 0.0, &Opaque));
            let inward = Ray::new(surface.origin_towards(-d), -d);
            leaks += u64::from(accel.intersect(&inward, 0.0, &Opaque).is_none());
        }
        tally.none(format!("leaks beside an edge, radius {r} at {shift}"), leaks);
        tally.none(format!("rays back onto the wall beside an edge, radius {r} at {shift}"), back);
    }
}

/// A closed prism of length 2, rotated and moved, of which two walls of width 1 meet at `angle` in an edge, which
/// belongs to triangles 3 and 6.
fn prism(angle: f64, noise: &mut Noise, away: f64) -> Mesh {
    let turn =
        DQuat::from_axis_angle(noise.direction().as_dvec3().normalize(), 6.0 * f64::from(noise.unit()));
    let offset = noise.direction().as_dvec3() * away;
    let section = [DVec2::ZERO, DVec2::X, DVec2::from_angle(angle)];
    let corner = |i: usize| turn * section[i % 3].extend(if i < 3 { -1.0 } else { 1.0 }) + offset;
    Mesh {
        positions: (0..6).map(|i| corner(i).as_vec3()).collect(),
        triangles: vec![
            [0, 2, 1],
            [3, 4, 5],
            [0, 1, 4],
            [0, 4, 3],
            [1, 2, 5],
            [1, 5, 4],
            [2, 0, 3],
            [2, 3, 5],
        ],
        ..Mesh::default()
    }
}

/// From points a few ulp from a sharp edge of a closed body, inward rays must hit a wall.
pub(super) fn in_sharp_edges(tally: &mut Tally, points: u32) {
    for degrees in [90, 60, 45, 30, 20] {
        let (mut noise, mut leaks) = (Noise(77), 0);
        for away in [0.0, 1.0, 10.0, 100.0] {
            let accel = accel_of(prism(f64::from(degrees).to_radians(), &mut noise, away));
            for i in 0..points {
                let (tiny, s) = (f32::EPSILON * (i % 8) as f32, 0.05 + 0.9 * noise.unit());
                // Corner 1 of triangle 3 and corner 0 of triangle 6 are opposite to the edge.
                let (primitive, u, v) =
                    if i % 2 == 0 { (3, tiny, s) } else { (6, s * (1.0 - tiny), (1.0 - s) * (1.0 - tiny)) };
                let hit = Hit { t: 1.0, u, v, primitive, object: 0 };
                let surface = accel.surface(&Ray::new(Vec3::ZERO, Vec3::X), 0.0, &hit);
                let d = noise.direction();
                // A direction exactly in the plane of the wall, as represented in f32, leads neither in nor out.
                if d.dot(surface.ng) == 0.0 {
                    continue;
                }
                let d = if d.dot(surface.ng) > 0.0 { -d } else { d };
                let inward = Ray::new(surface.origin_towards(d), d);
                leaks += u64::from(accel.intersect(&inward, 0.0, &Opaque).is_none());
            }
        }
        tally.none(format!("leaks from an edge of {degrees}°"), leaks);
    }
}

/// A square of side 1e6, rotated against the axes, seen from height 1 at angles down to 1e-4 rad.
fn grazing(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let (x, z) = (Vec3::new(0.96, 0.28, 0.0), Vec3::new(-0.168, 0.576, 0.8));
    let up = x.cross(z) * -1.0;
    let corner = |a: f32, b: f32| x * (a * 5e5) + z * (b * 5e5);
    let accel = accel_of(Mesh {
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    let (mut noise, mut missed, mut again, mut worst) = (Noise(3), 0, 0, 0.0f64);
    for i in 0..effort.of(5_000, 100_000, 5_000_000) {
        let below = 1e-4 * 10f32.powf(4.0 * noise.unit());
        let angle = i as f32;
        let ray = Ray::new(up, (x * angle.cos() + z * angle.sin()) - up * below);
        let Some(hit) = accel.intersect(&ray, 0.0, &Opaque) else {
            missed += 1;
            continue;
        };
        let s = accel.surface(&ray, 0.0, &hit);
        let [a, b, c] = accel.corners(0, hit.primitive).map(|p| p.as_dvec3());
        let n = (b - a).cross(c - a).normalize();
        let residual = n.dot(s.p.as_dvec3() - a).abs();
        worst = worst.max(residual / n.abs().dot(s.p_error.as_dvec3()));
        let d = noise.about(s.ng, 1e-6);
        again += u64::from(accel.occluded(&Ray::new(s.origin_towards(d), d), 0.0, &Opaque));
    }
    tally.none("rays aimed at the plane that miss it", missed);
    tally.none("grazing rays that hit it again", again);
    tally.at_most("distance of a hit from its plane over its error bound", worst, 1.0);
    tally.finish()
}
