//! Stress cases A03 to A06: intersection tests find every hit, and no false ones.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{ball, cube};
use crate::tally::Tally;
use dapple_integrator::geometry::bvh::{Kernel, Opaque, Tree, TriangleHit};
use dapple_integrator::geometry::{Accel, AccelBuilder, Hit, HitFilter, Mesh};
use dapple_integrator::math::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_integrator::math::{Motion, Ray};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::cell::RefCell;
use std::sync::Arc;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A03",
        title: "watertight closed mesh",
        naive: "9 % of rays aimed at edges and vertices pass between two triangles",
        source: "Woop 2013; docs/science.md, \"Triangles\"",
        check: Check::Run(watertight),
    },
    Case {
        id: "A04",
        title: "rays enter as often as they leave",
        naive: "an edge counted twice or not at all turns inside into outside",
        source: "Woop 2013; docs/science.md, \"Triangles\"",
        check: Check::Run(parity),
    },
    Case {
        id: "A05",
        title: "boxes never miss their contents",
        naive: "rounding in the slab test skips flat boxes that the ray passes through",
        source: "Ize 2013; docs/science.md, \"Boxes\"",
        check: Check::Run(boxes),
    },
    Case {
        id: "A06",
        title: "length of the direction, 1e-30 to 1e30, and tiny components",
        naive: "inverse directions clamped at 1e-7, and boxes clamped at t = 1e-4, lose whole scenes",
        source: "docs/science.md, \"Boxes\"",
        check: Check::Run(directions),
    },
];

/// A closed, irregular ball whose lack of symmetry cannot hide errors, with outward faces.
pub(super) fn lump(level: u32) -> Mesh {
    let mut mesh = ball(level, 1.0, Vec3::ZERO);
    let lumpy = |p: Vec3| p * (1.0 + 0.1 * (p.x * 7.0).sin() * (p.y * 5.0).cos());
    mesh.positions.iter_mut().for_each(|p| *p = lumpy(*p));
    mesh.normals.clear();
    mesh
}

fn triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    (0..mesh.triangles.len() as u32).map(|t| mesh.corners(t)).collect()
}

/// Rays from inside: a tenth uniform, the others aimed at points on edges, at vertices, or along axes through vertices.
fn outward(noise: &mut Noise, corners: &[[Vec3; 3]], i: u64) -> Ray {
    let [a, b, _] = corners[noise.below(corners.len())];
    let o = noise.cube() * 0.4;
    let d = match i % 10 {
        0 => noise.direction(),
        1..=5 => a + (b - a) * noise.unit() - o,
        6..=8 => a - o,
        _ => {
            let axis = [Vec3::X, Vec3::Y, Vec3::Z][(i / 10 % 3) as usize];
            let toward = if a.dot(axis) < 0.0 { -axis } else { axis };
            let foot = a - axis * a.dot(axis);
            if foot.length() < 0.85 {
                return Ray::new(foot, toward);
            }
            a - o
        }
    };
    Ray::new(o, d.try_normalize().unwrap_or(Vec3::X))
}

fn watertight(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let (mesh, n) = (lump(4), effort.of(20_000, 500_000, 100_000_000));
    let corners = triangles(&mesh);
    for kernel in Kernel::available() {
        let tree = Tree::build(&corners).with_kernel(kernel);
        let mut noise = Noise(1);
        let leaks =
            (0..n).filter(|&i| tree.intersect(&outward(&mut noise, &corners, i), &Opaque).is_none()).count();
        tally.none(format!("leaks of {n} rays, {}", kernel.name()), leaks as u64);
        let leaks: u64 = (0..10).map(|seed| along_faces(kernel, seed, n / 20)).sum();
        tally.none(format!("leaks of {} rays in the planes of faces, {}", n / 2, kernel.name()), leaks);
    }
    for (name, accel) in [("shared by instances", instanced(&mesh)), ("rotating and moving", turning(&mesh))]
    {
        let mut noise = Noise(2);
        let leaks = (0..n / 10).filter(|i| {
            let time = noise.unit();
            let placed = accel.placement(0, time).unwrap_or(DAffine3::IDENTITY);
            let local = outward(&mut noise, &corners, *i);
            let o = placed.transform_point3(local.o.as_dvec3()).as_vec3();
            let d = placed.transform_vector3(local.d.as_dvec3()).as_vec3();
            accel.intersect(&Ray::new(o, d), time, &Opaque).is_none()
        });
        tally.none(format!("leaks of {} rays, {name}", n / 10), leaks.count() as u64);
    }
    tally.finish()
}

/// Number of rays along an axis, within the outline of a closed box, that miss it. In both other axes, a third each of
/// the rays runs in the plane of the lower face, in that of the upper face, and between them.
fn along_faces(kernel: Kernel, seed: u64, rays: u64) -> u64 {
    let mut noise = Noise(40 + seed);
    let (r, offset) = (0.1 + noise.unit(), noise.cube() * 10.0);
    let corners = triangles(&cube(r, offset));
    let tree = Tree::build(&corners).with_kernel(kernel);
    let (low, high) = corners.iter().flatten().fold((offset, offset), |(l, h), p| (l.min(*p), h.max(*p)));
    let missed = (0..rays).filter(|_| {
        let mut place = || match noise.below(3) {
            0 => 0.0,
            1 => 1.0,
            _ => noise.unit(),
        };
        let at = Vec3::new(place(), place(), place());
        let mut o = (low + (high - low) * at).min(high);
        o = Vec3::select(at.cmpeq(Vec3::ONE), high, o);
        let axis = Vec3::AXES[noise.below(3)] * if noise.below(2) == 0 { 1.0 } else { -1.0 };
        o = Vec3::select(axis.cmpeq(Vec3::ZERO), o, offset - axis * 3.0 * r);
        tree.intersect(&Ray::new(o, axis), &Opaque).is_none()
    });
    missed.count() as u64
}

/// The mesh as an instance, and a second instance far away that prevents flattening.
fn instanced(mesh: &Mesh) -> Accel {
    let mesh = Arc::new(mesh.clone());
    let mut builder = AccelBuilder::default();
    let turned = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    let place = DVec3::new(3.0, -2.0, 7.0);
    let scale = DVec3::new(2.0, 0.3, 5.0);
    builder.add_instance(mesh.clone(), DAffine3::from_scale_rotation_translation(scale, turned, place));
    builder.add_instance(mesh, DAffine3::from_translation(DVec3::splat(1e3)));
    builder.build()
}

fn turning(mesh: &Mesh) -> Accel {
    let turn = |angle: f64| DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle);
    let keys = vec![turn(0.0), turn(1.3), turn(2.6)];
    let rotation = Track::new(vec![0.0, 0.5, 1.0], keys, Interpolation::Linear).map(Arc::new);
    let places = vec![DVec3::ZERO, DVec3::new(3.0, 1.0, -2.0)];
    let translation = Track::new(vec![0.0, 1.0], places, Interpolation::Linear).map(Arc::new);
    let mut trs = Trs::default();
    if let (Ok(rotation), Ok(translation)) = (rotation, translation) {
        trs.rotation = Channel::Track(rotation);
        trs.translation = Channel::Track(translation);
    }
    let mut builder = AccelBuilder::default();
    builder.add_moving(mesh.clone(), Motion::new(vec![Node::Trs(trs)], DAffine3::IDENTITY, 0.0));
    builder.build_for(0.0, 1.0)
}

/// Records every candidate hit and accepts none.
struct All(RefCell<Vec<Hit>>);

impl HitFilter<Hit> for All {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        self.0.borrow_mut().push(*hit);
        false
    }
}

fn parity(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let mesh = lump(3);
    let mut builder = AccelBuilder::default();
    builder.add_mesh(mesh.clone());
    let accel = builder.build();
    let (mut noise, mut odd, mut out_of_turn, mut at_edges) = (Noise(7), 0, 0, 0);
    for i in 0..effort.of(5_000, 200_000, 10_000_000) {
        let o = noise.direction() * 5.0;
        let [a, b, _] = mesh.corners(noise.below(mesh.triangles.len()) as u32);
        let aimed = i % 2 == 1;
        let target = if aimed { a + (b - a) * noise.unit() } else { noise.cube() * 0.8 };
        let ray = Ray::new(o, (target - o).normalize());
        let all = All(RefCell::default());
        accel.intersect(&ray, 0.0, &all);
        let mut hits = all.0.into_inner();
        hits.sort_by(|a, b| a.t.total_cmp(&b.t));
        let side = |h: &Hit| accel.surface(&ray, 0.0, h).ng.dot(ray.d) > 0.0;
        if aimed {
            // A test that includes edges reports an edge hit for both triangles: hits at one point count once. Where
            // two triangles meet at a silhouette seen nearly edge-on, t is accurate to a few ulp over the cosine.
            let steep = |h: &Hit| accel.surface(&ray, 0.0, h).ng.dot(ray.d).abs().max(1e-3);
            let together =
                |a: &Hit, b: &Hit| (a.t - b.t).abs() * steep(a).min(steep(b)) <= 8.0 * f32::EPSILON * a.t;
            let first_in = hits.first().is_some_and(|f| hits.iter().any(|h| together(f, h) && !side(h)));
            let last_out = hits.last().is_some_and(|l| hits.iter().any(|h| together(l, h) && side(h)));
            at_edges += u64::from(!(hits.is_empty() || first_in && last_out));
        } else {
            odd += u64::from(hits.len() % 2 == 1);
            out_of_turn += hits.iter().enumerate().filter(|(k, h)| side(h) != (k % 2 == 1)).count() as u64;
        }
    }
    tally.none("rays with an odd number of hits", odd);
    tally.none("hits on the wrong side", out_of_turn);
    tally.none("rays aimed at edges that begin or end inside", at_edges);
    tally.finish()
}

fn boxes(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let mut noise = Noise(13);
    let mut flat = Vec::new();
    for i in 0..2000 {
        let (size, at) =
            (10f32.powf(noise.unit() * 12.0 - 6.0), noise.cube() * 10f32.powf(noise.unit() * 6.0));
        let axes = [[Vec3::X, Vec3::Y], [Vec3::Y, Vec3::Z], [Vec3::Z, Vec3::X]][i % 3];
        flat.push([at, at + axes[0] * size, at + axes[1] * size * noise.unit()]);
    }
    let area = |t: &[Vec3; 3]| (t[1] - t[0]).as_dvec3().cross((t[2] - t[0]).as_dvec3()).length();
    flat.retain(|t| area(t) > 0.0);
    let n = effort.of(10_000, 100_000, 100_000_000u64);
    let kernels =
        Kernel::available().into_iter().map(|kernel| (kernel, Tree::build(&flat).with_kernel(kernel)));
    for (kernel, tree) in kernels {
        let (mut lost, mut noise) = (0, Noise(17));
        for i in 0..n {
            let t = noise.below(flat.len());
            let [a, b, c] = flat[t].map(|p| p.as_dvec3());
            let (u, v) = (0.1 + 0.4 * f64::from(noise.unit()), 0.1 + 0.4 * f64::from(noise.unit()));
            let target = a + (b - a) * u + (c - a) * v;
            let normal = (b - a).cross(c - a).normalize();
            let far =
                (b - a).length().max((c - a).length()) * 10f64.powf(f64::from(noise.unit()) * 3.0 - 1.0);
            let across = if i % 4 == 0 { normal } else { noise.direction().as_dvec3() + normal * 0.3 };
            let o = (target + across.normalize() * far).as_vec3();
            let way = target - o.as_dvec3();
            // The ray must remain well inside the triangle despite rounding of its origin and direction.
            let slack = o.abs().max_element() as f64 * 3e-7 + way.length() * 3e-7;
            let least = (b - a).length().min((c - a).length()) * 0.05;
            if slack * 20.0 / way.normalize().dot(normal).abs() > least {
                continue;
            }
            let hit = tree.intersect(&Ray::new(o, way.normalize().as_vec3()), &Opaque);
            // The distance to a sliver is less accurate than its box; only finding it matters here.
            let other =
                |h: TriangleHit| h.triangle as usize != t && f64::from(h.t) > way.length() + slack * 40.0;
            lost += u64::from(hit.is_none_or(other));
        }
        tally.none(format!("flat triangles lost, {}", kernel.name()), lost);
    }
    tally.finish()
}

fn directions(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let corners = triangles(&lump(3));
    let tree = Tree::build(&corners);
    let (mut noise, mut other, mut worst) = (Noise(3), 0u64, 0.0f64);
    for _ in 0..effort.of(200, 5_000, 200_000) {
        let o = noise.cube() * 0.4;
        let tiny =
            Vec3::new(1.0, 10f32.powf(-9.0 + 2.0 * noise.unit()), -(10f32.powf(-9.0 + 2.0 * noise.unit())));
        for d in [noise.direction(), tiny, Vec3::new(tiny.y, 1.0, 0.0), Vec3::new(0.0, -0.0, -1.0)] {
            let Some(expected) = tree.intersect(&Ray::new(o, d), &Opaque) else {
                other += 1;
                continue;
            };
            for k in (-30..=30).step_by(3) {
                let length = 10f32.powi(k);
                match tree.intersect(&Ray::new(o, d * length), &Opaque) {
                    Some(hit) => {
                        let t = f64::from(hit.t) * f64::from(length);
                        worst = worst.max((t / f64::from(expected.t) - 1.0).abs());
                        // Components below 1e-38 are rounded: only accurate directions must hit the same triangle.
                        let whole = (d * length).abs().min_element() > 1e-37;
                        other += u64::from(whole && hit.triangle != expected.triangle);
                    }
                    None => other += 1,
                }
            }
        }
    }
    tally.none("rays that hit another triangle or none", other);
    // d·10^k is rounded as well, to half an ulp per component.
    tally.within("largest relative error of t·|d|", worst, 0.0, 8.0 * 1.2e-7);
    tally.finish()
}
