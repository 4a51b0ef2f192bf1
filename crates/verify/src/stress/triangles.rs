//! Stress cases A07 to A10: meshes of slivers, of invalid triangles, and of duplicate triangles.

use super::hits::lump;
use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{quad, run, seen_in_parallel, shadeless, square};
use crate::tally::Tally;
use dapple_integrator::geometry::bvh::{Opaque, Tree};
use dapple_integrator::geometry::{AccelBuilder, Hit, Mesh};
use dapple_integrator::math::Ray;
use glam::{DAffine3, DVec3, Vec3};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A07",
        title: "slivers of aspect 1e5",
        naive: "a determinant below a fixed 1e-6 counts as a parallel ray: slivers vanish",
        source: "Woop 2013; docs/science.md, \"Triangles\"",
        check: Check::Run(slivers),
    },
    Case {
        id: "A08",
        title: "degenerate and invalid triangles",
        naive: "a NaN box corrupts the acceleration structure, or its build does not terminate",
        source: "docs/science.md, \"Triangles\"",
        check: Check::Run(invalid),
    },
    Case {
        id: "A09",
        title: "duplicate triangles",
        naive: "equal centroids cannot be split: depth and build time explode",
        source: "docs/science.md, \"Triangles\"",
        check: Check::Run(duplicates),
    },
    Case {
        id: "A10",
        title: "the hit on coplanar surfaces is unambiguous",
        naive: "the order of threads or nodes decides: the image flickers",
        source: "docs/science.md, \"Triangles\"",
        check: Check::Run(coplanar),
    },
];

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

/// A disk of `n` slivers that meet at the centre, seen along its axis.
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
        let hit = tree.intersect(&Ray::new(Vec3::new(p.x, p.y, 2.0), -Vec3::Z), &Opaque).is_some();
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
    let mut builder = AccelBuilder::default();
    builder.add_mesh(strip);
    let accel = builder.build();
    let (mut lost, mut tilt) = (0, 0.0f64);
    for _ in 0..effort.of(5_000, 50_000, 2_000_000) {
        let p = noise.point();
        let ray = Ray::new(Vec3::new(p.x, p.y, 1.0), Vec3::new(0.0, 0.0, -1.0));
        match accel.intersect(&ray, 0.0, &Opaque) {
            Some(hit) => tilt = tilt.max(f64::from(accel.surface(&ray, 0.0, &hit).ng.angle_between(Vec3::Z))),
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
        let mut builder = AccelBuilder::default();
        builder.add_mesh(mesh.clone());
        builder.build()
    };
    let (a, b) = (build(&clean), build(&dirty));
    let mut noise = Noise(11);
    let bits = |hit: Option<Hit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive));
    let differ = (0..effort.of(10_000, 200_000, 10_000_000)).filter(|_| {
        let ray = Ray::new(noise.cube() * 2.0, noise.direction());
        bits(a.intersect(&ray, 0.0, &Opaque)) != bits(b.intersect(&ray, 0.0, &Opaque))
    });
    tally.none("rays whose hit the invalid triangles change", differ.count() as u64);
    // A triangle with edges of 1e-40 is small, but valid: it must neither prevent the build nor be hit from a distance.
    dirty.triangles.push([zero, sub_x, sub_y]);
    let c = build(&dirty);
    tally.holds(
        "a subnormal triangle does not hide the mesh",
        c.intersect(&Ray::new(Vec3::X * 0.3, Vec3::X), 0.0, &Opaque).is_some(),
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
            single.intersect(&ray, &Opaque) != tree.intersect(&ray, &Opaque)
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
        tree.intersect(&Ray::new(o, (target - o).normalize()), &Opaque).is_none_or(|h| h.t > 0.101)
    });
    tally.none("of 100 triangles of one centroid not hit", lost.count() as u64);
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
            let image = run(&scene, &square(32, 4).with_threads(threads));
            let wrong = image.film.mean().pixels.iter().filter(|p| p.x != colours[0]).count();
            tally.none(format!("pixels of the second quad, {threads} threads"), wrong as u64);
        }
    }
    tally.finish()
}
