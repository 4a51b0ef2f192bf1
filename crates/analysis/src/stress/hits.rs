//! A03 to A10, A14: does every ray find what it must, and nothing else?

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{ball, matte, moments, quad, run, seen_in_parallel, shadeless, square};
use crate::tally::Tally;
use dapple_integrator::Settings;
use dapple_integrator::geometry::bvh::{Any, Kernel, Tree, TriangleHit};
use dapple_integrator::geometry::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_integrator::geometry::shapes::Sphere;
use dapple_integrator::geometry::{Filter, Hit, Mesh, Motion, Opaque, Ray, World, WorldBuilder};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::cell::RefCell;
use std::sync::Arc;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A03",
        title: "watertight closed mesh",
        naive: "9 % of rays aimed at edges and vertices slip between two triangles",
        source: "Woop 2013; SCIENCE A03",
        check: Check::Run(watertight),
    },
    Case {
        id: "A04",
        title: "rays enter as often as they leave",
        naive: "an edge counted twice or not at all turns inside into outside",
        source: "Woop 2013; SCIENCE A04",
        check: Check::Run(parity),
    },
    Case {
        id: "A05",
        title: "boxes never lose what is in them",
        naive: "the slab test's own rounding skips flat boxes that the ray goes through",
        source: "Ize 2013; SCIENCE A05",
        check: Check::Run(boxes),
    },
    Case {
        id: "A06",
        title: "length of the direction, 1e-30 to 1e30, and tiny components",
        naive: "inverse directions clamped at 1e-7, and boxes clamped at t = 1e-4, lose whole scenes",
        source: "SCIENCE A06",
        check: Check::Run(directions),
    },
    Case {
        id: "A07",
        title: "slivers of aspect 1e5",
        naive: "a determinant below a fixed 1e-6 is taken for a parallel ray: slivers vanish",
        source: "Woop 2013; SCIENCE A07",
        check: Check::Run(slivers),
    },
    Case {
        id: "A08",
        title: "degenerate and invalid triangles",
        naive: "a NaN box poisons the tree, or the build does not end",
        source: "SCIENCE A08",
        check: Check::Run(invalid),
    },
    Case {
        id: "A09",
        title: "duplicates",
        naive: "equal centroids cannot be split: depth and time explode",
        source: "SCIENCE A09",
        check: Check::Run(duplicates),
    },
    Case {
        id: "A10",
        title: "coplanar surfaces have one winner",
        naive: "whichever thread or tree comes first decides: the picture flickers",
        source: "SCIENCE A10",
        check: Check::Run(coplanar),
    },
    Case {
        id: "A14",
        title: "tiny and huge spheres",
        naive: "b² − 4ac cancels: at a distance of 1e4 radii nothing is left",
        source: "Haines, Günther, Akenine-Möller 2019; SCIENCE A14",
        check: Check::Run(spheres),
    },
];

/// A closed ball, lumpy so that no symmetry hides an error, wound outward.
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

/// From inside: a tenth even, the others aimed at points of edges, vertices, or along axes through vertices.
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
            (0..n).filter(|&i| tree.closest(&outward(&mut noise, &corners, i), &Any).is_none()).count();
        tally.none(format!("leaks of {n} rays, {}", kernel.name()), leaks as u64);
    }
    for (name, world) in [("shared by instances", instanced(&mesh)), ("turning and moving", turning(&mesh))] {
        let mut noise = Noise(2);
        let leaks = (0..n / 10).filter(|i| {
            let time = noise.unit();
            let placed = world.placement(0, time).unwrap_or(DAffine3::IDENTITY);
            let local = outward(&mut noise, &corners, *i);
            let o = placed.transform_point3(local.o.as_dvec3()).as_vec3();
            let d = placed.transform_vector3(local.d.as_dvec3()).as_vec3();
            world.closest(&Ray::new(o, d), time, &Opaque).is_none()
        });
        tally.none(format!("leaks of {} rays, {name}", n / 10), leaks.count() as u64);
    }
    tally.finish()
}

/// The mesh here and, out of the way, once more, so that it is not flattened.
fn instanced(mesh: &Mesh) -> World {
    let mesh = Arc::new(mesh.clone());
    let mut builder = WorldBuilder::default();
    let turned = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    let place = DVec3::new(3.0, -2.0, 7.0);
    let scale = DVec3::new(2.0, 0.3, 5.0);
    builder.add_instance(mesh.clone(), DAffine3::from_scale_rotation_translation(scale, turned, place));
    builder.add_instance(mesh, DAffine3::from_translation(DVec3::splat(1e3)));
    builder.build()
}

fn turning(mesh: &Mesh) -> World {
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
    let mut builder = WorldBuilder::default();
    builder.add_moving(mesh.clone(), Motion::new(vec![Node::Trs(trs)], DAffine3::IDENTITY, 0.0));
    builder.build_for(0.0, 1.0)
}

/// Notes every candidate and takes none.
struct All(RefCell<Vec<Hit>>);

impl Filter for All {
    const OPAQUE: bool = false;
    fn accept(&self, hit: &Hit) -> bool {
        self.0.borrow_mut().push(*hit);
        false
    }
}

fn parity(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let mesh = lump(3);
    let mut builder = WorldBuilder::default();
    builder.add_mesh(mesh.clone());
    let world = builder.build();
    let (mut noise, mut odd, mut out_of_turn, mut at_edges) = (Noise(7), 0, 0, 0);
    for i in 0..effort.of(5_000, 200_000, 10_000_000) {
        let o = noise.direction() * 5.0;
        let [a, b, _] = mesh.corners(noise.below(mesh.triangles.len()) as u32);
        let aimed = i % 2 == 1;
        let target = if aimed { a + (b - a) * noise.unit() } else { noise.cube() * 0.8 };
        let ray = Ray::new(o, (target - o).normalize());
        let all = All(RefCell::default());
        world.closest(&ray, 0.0, &all);
        let mut hits = all.0.into_inner();
        hits.sort_by(|a, b| a.t.total_cmp(&b.t));
        let side = |h: &Hit| world.surface(&ray, 0.0, h).ng.dot(ray.d) > 0.0;
        if aimed {
            // A test that includes edges reports one from both sides: what is met at one place counts once.
            // Where two triangles meet at an outline, seen nearly edge-on, t is known to some ulp over the cosine.
            let steep = |h: &Hit| world.surface(&ray, 0.0, h).ng.dot(ray.d).abs().max(1e-3);
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
    tally.none("hits from the wrong side", out_of_turn);
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
            // Rounding of the origin and of the direction must leave the ray well inside the triangle.
            let slack = o.abs().max_element() as f64 * 3e-7 + way.length() * 3e-7;
            let least = (b - a).length().min((c - a).length()) * 0.05;
            if slack * 20.0 / way.normalize().dot(normal).abs().max(1e-3) > least {
                continue;
            }
            let hit = tree.closest(&Ray::new(o, way.normalize().as_vec3()), &Any);
            lost += u64::from(hit.is_none_or(|h: TriangleHit| f64::from(h.t) > way.length() + slack * 40.0));
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
            let Some(expected) = tree.closest(&Ray::new(o, d), &Any) else {
                other += 1;
                continue;
            };
            for k in (-30..=30).step_by(3) {
                let length = 10f32.powi(k);
                match tree.closest(&Ray::new(o, d * length), &Any) {
                    Some(hit) => {
                        let t = f64::from(hit.t) * f64::from(length);
                        worst = worst.max((t / f64::from(expected.t) - 1.0).abs());
                        // Components below 1e-38 are rounded: only whole directions keep the triangle.
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

fn slivers(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let mut noise = Noise(5);
    fan(&mut tally, &mut noise, effort.of(2_000, 20_000, 100_000), effort.of(2_000, 5_000, 1_000_000));
    if effort != Effort::Quick {
        fan(&mut tally, &mut noise, 1_000_000, effort.of(0, 50, 10_000));
    }
    strip(&mut tally, &mut noise, effort);
    tally.finish()
}

/// A disk of `n` slivers that all meet in the middle, seen along its axis.
fn fan(tally: &mut Tally, noise: &mut Noise, n: u32, rays: u64) {
    let rim = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i % n) / f64::from(n);
        Vec3::new(angle.cos() as f32, angle.sin() as f32, 0.0)
    };
    let fan: Vec<[Vec3; 3]> = (0..n).map(|i| [Vec3::ZERO, rim(i), rim(i + 1)]).collect();
    let tree = Tree::build(&fan);
    let (mut leaks, mut covered) = (0, 0u64);
    for _ in 0..rays {
        let p = noise.cube();
        let hit = tree.closest(&Ray::new(Vec3::new(p.x, p.y, 2.0), -Vec3::Z), &Any).is_some();
        covered += u64::from(hit);
        leaks += u64::from(!hit && p.x.hypot(p.y) < 0.999_999);
    }
    tally.none(format!("leaks inside the fan of {n}"), leaks);
    let share = covered as f64 / rays as f64;
    let exact = 0.125 * f64::from(n) * (std::f64::consts::TAU / f64::from(n)).sin();
    let error = (exact * (1.0 - exact) / rays as f64).sqrt();
    tally.within(format!("coverage of the fan of {n}"), share, exact, 4.0 * error);
}

/// A square cut into slivers of width 1e-5.
fn strip(tally: &mut Tally, noise: &mut Noise, effort: Effort) {
    let strips = effort.of(5_000, 100_000, 100_000u32);
    let mut strip = Mesh::default();
    for i in 0..=strips {
        let x = (f64::from(i) / f64::from(strips)) as f32;
        strip.positions.extend([Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0)]);
    }
    strip.triangles =
        (0..strips).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]]).collect();
    let mut builder = WorldBuilder::default();
    builder.add_mesh(strip);
    let world = builder.build();
    let (mut lost, mut tilt) = (0, 0.0f64);
    for _ in 0..effort.of(5_000, 50_000, 2_000_000) {
        let p = noise.point();
        let ray = Ray::new(Vec3::new(p.x, p.y, 1.0), Vec3::new(0.0, 0.0, -1.0));
        match world.closest(&ray, 0.0, &Opaque) {
            Some(hit) => tilt = tilt.max(f64::from(world.surface(&ray, 0.0, &hit).ng.angle_between(Vec3::Z))),
            None => lost += 1,
        }
    }
    tally.none("leaks inside the strip", lost);
    tally.within("largest tilt of a normal", tilt, 0.0, 1e-3);
}

fn invalid(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let clean = lump(3);
    let mut dirty = clean.clone();
    let first = dirty.positions.len() as u32;
    dirty.positions.extend([
        Vec3::NAN,
        Vec3::INFINITY,
        Vec3::NEG_INFINITY,
        Vec3::splat(1e38),
        Vec3::X * 1e-40,
    ]);
    dirty.positions.extend([Vec3::Y * 1e-40, Vec3::ZERO, Vec3::X * 0.5, Vec3::X]);
    let [nan, inf, minus, huge, sub_x, sub_y, zero, half, one] =
        [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| first + i);
    dirty.triangles.extend([
        [zero, zero, zero],
        [zero, half, one],
        [nan, half, one],
        [inf, half, sub_x],
        [minus, one, sub_y],
        [huge, one, half],
        [zero, half, u32::MAX],
    ]);
    let build = |mesh: &Mesh| {
        let mut builder = WorldBuilder::default();
        builder.add_mesh(mesh.clone());
        builder.build()
    };
    let (a, b) = (build(&clean), build(&dirty));
    let mut noise = Noise(11);
    let bits = |hit: Option<Hit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive));
    let differ = (0..effort.of(10_000, 200_000, 10_000_000)).filter(|_| {
        let ray = Ray::new(noise.cube() * 2.0, noise.direction());
        bits(a.closest(&ray, 0.0, &Opaque)) != bits(b.closest(&ray, 0.0, &Opaque))
    });
    tally.none("rays that see the invalid triangles", differ.count() as u64);
    // A triangle with edges of 1e-40 is small, not invalid: it must neither stop the build nor be hit from afar.
    dirty.triangles.push([zero, sub_x, sub_y]);
    let c = build(&dirty);
    tally.holds(
        "a subnormal triangle does not hide the mesh",
        c.closest(&Ray::new(Vec3::X * 0.3, Vec3::X), 0.0, &Opaque).is_some(),
    );
    tally.finish()
}

fn duplicates(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let quad = [[Vec3::ZERO, Vec3::X, Vec3::ONE], [Vec3::ZERO, Vec3::ONE, Vec3::Y + Vec3::Z]];
    let ray = |noise: &mut Noise| Ray::new(Vec3::new(noise.unit(), noise.unit(), 3.0), -Vec3::Z);
    let single = Tree::build(&quad);
    for k in [2, 1000, effort.of(2_000, 100_000, 100_000)] {
        let many: Vec<[Vec3; 3]> = (0..k).flat_map(|_| quad).collect();
        let tree = Tree::build(&many);
        let mut noise = Noise(k as u64);
        let differ = (0..200).filter(|_| {
            let ray = ray(&mut noise);
            single.closest(&ray, &Any) != tree.closest(&ray, &Any)
        });
        tally.none(format!("rays changed by {k} copies"), differ.count() as u64);
    }
    let n = effort.of(2_000, 20_000, 1_000_000);
    let mut noise = Noise(4);
    let mut tiny = |_| {
        let (a, b) = (noise.cube() * 1e-3, noise.cube() * 1e-3);
        [a, b, -a - b]
    };
    let around: Vec<[Vec3; 3]> = (0..n).map(&mut tiny).collect();
    let start = std::time::Instant::now();
    let tree = Tree::build(&around);
    tally.remark(format!("{n} triangles of one centroid built in {:.1} s", start.elapsed().as_secs_f64()));
    let mut noise = Noise(9);
    let lost = (0..100).filter(|_| {
        let [a, b, c] = around[noise.below(n)];
        let target = a * 0.4 + b * 0.3 + c * 0.3;
        let o = noise.direction() * 0.1;
        tree.closest(&Ray::new(o, (target - o).normalize()), &Any).is_none_or(|h| h.t > 0.101)
    });
    tally.none("of 100 of them not found", lost.count() as u64);
    tally.finish()
}

fn coplanar(_: Effort) -> Outcome {
    let mut tally = Tally::default();
    for swap in [false, true] {
        let mut builder = seen_in_parallel(DVec3::Z, 0.5);
        let colours = if swap { [0.75, 0.25] } else { [0.25, 0.75] };
        for c in colours {
            let paint = builder.material(shadeless(c));
            builder.mesh(
                "quad",
                quad(Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0),
                DAffine3::IDENTITY,
                paint,
            );
        }
        let Ok(scene) = builder.build() else {
            tally.holds("the scene is built", false);
            continue;
        };
        for threads in [1, 2, 7] {
            let image = run(&scene, &Settings { threads: Some(threads), ..square(32, 4) });
            let wrong = image.film.mean().pixels.iter().filter(|p| p.x != colours[0]).count();
            tally.none(format!("pixels of the second quad, {threads} threads"), wrong as u64);
        }
    }
    tally.finish()
}

/// Nearest root in f64 of |o + t·d − c| = r in the form that does not cancel.
fn root(ray: &Ray, sphere: &Sphere) -> Option<f64> {
    let (d, f) = (ray.d.as_dvec3(), (ray.o - Vec3::ZERO).as_dvec3() - sphere.centre.as_dvec3());
    let (a, b) = (d.dot(d), -f.dot(d));
    let r = f64::from(sphere.radius);
    let delta = r * r - (f + d * (b / a)).length_squared();
    if delta < 0.0 {
        return None;
    }
    let q = b + b.signum() * (a * delta).sqrt();
    let c = (f.length() - r) * (f.length() + r);
    let (t0, t1) = (c / q, q / a);
    let (near, far) = (t0.min(t1), t0.max(t1));
    if near > 0.0 { Some(near) } else { (far > 0.0).then_some(far) }
}

fn spheres(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (r, distance) in
        [(1.0, 10.0), (1.0, 1e3), (1.0, 1e5), (1.0, 1e6), (1e-6, 1.0), (1e6f32, 1e6f64 + 1e-3)]
    {
        let sphere = Sphere { centre: Vec3::ZERO, radius: r };
        let mut builder = WorldBuilder::default();
        builder.add_sphere(sphere);
        let world = builder.build();
        let (mut noise, mut worst, mut lost) = (Noise(21), 0.0f64, 0u64);
        for _ in 0..effort.of(2_000, 50_000, 5_000_000) {
            let o = (noise.direction().as_dvec3() * distance).as_vec3();
            let target = noise.direction() * (0.95 * r * noise.unit());
            let ray = Ray::new(o, (target - o).normalize());
            match (root(&ray, &sphere), world.closest(&ray, 0.0, &Opaque)) {
                (Some(t), Some(hit)) => {
                    worst = worst.max((f64::from(hit.t) - t).abs() / t.max(f64::from(r) * 1e-9))
                }
                (None, None) => {}
                _ => lost += 1,
            }
        }
        tally.none(format!("rays that disagree, radius {r} at {distance}"), lost);
        tally.within(format!("relative error of t, radius {r} at {distance}"), worst, 0.0, 2.4e-7);
    }
    let lit = moments(&run(
        &match lone_sphere() {
            Ok(scene) => scene,
            Err(_) => return tally.finish(),
        },
        &square(8, 4),
    ));
    tally.exactly("an emitting sphere of radius 1 at 1e6", lit.mean, 3.0);
    tally.finish()
}

fn lone_sphere() -> Result<dapple_integrator::scene::Scene, dapple_integrator::scene::SceneError> {
    let mut builder = crate::scenes::seen(DVec3::Z * 1e6, DVec3::ZERO, 1e-6);
    let bright = builder.material(matte(0.0, 3.0));
    builder.sphere("ball", DVec3::ZERO, 1.0, bright);
    builder.build()
}
