//! Stress cases A19 to A21: singular transforms, instances, and a camera on a surface or inside glass.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{ball, cube, glass, matte, of, pixels, quad, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::geometry::{AccelBuilder, Opaque};
use dapple_integrator::lights::Environment;
use dapple_integrator::math::Ray;
use dapple_integrator::math::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_integrator::scene::{SceneBuilder, SceneError};
use dapple_integrator::{Settings, settings::Strategy};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::sync::Arc;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A19",
        title: "negative, non-uniform and singular transforms",
        naive: "with normals by the inverse transpose, a flattened object (scale 1, 1, 0) turns black",
        source: "Turkowski 1990; docs/science.md, \"Transforms\"",
        check: Check::Run(singular),
    },
    Case {
        id: "A20",
        title: "instanced and flattened geometry agree",
        naive: "normalising the direction in object space changes t",
        source: "docs/science.md, \"Transforms\"",
        check: Check::Run(instances),
    },
    Case {
        id: "A21",
        title: "camera on a surface, and inside glass",
        naive: "a near plane, or a first hit at t = 0, turns the image black or NaN",
        source: "docs/science.md, \"Transforms\"",
        check: Check::Run(eye),
    },
];

/// A convex body of albedo ½ in a white sky, transformed by `matrix`: its radiance is 0.5 everywhere.
fn body(matrix: DMat3, from: DVec3, round: bool) -> SceneBuilder {
    let mut builder = seen(from, DVec3::ZERO, 0.02);
    let grey = builder.material(matte(0.5, 0.0));
    let mesh = if round { ball(3, 1.0, Vec3::ZERO) } else { cube(1.0, Vec3::ZERO) };
    let transform = DAffine3 { matrix3: matrix, translation: DVec3::ZERO };
    builder.mesh("body", mesh, transform, grey);
    builder.environment(Environment::constant(Vec3::ONE));
    builder
}

fn each(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let spp = effort.of(16, 256, 4096);
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(3.0, 1.0, 0.0), DVec3::new(-2.0, 0.7, 1.0));
    let scaled = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
    for (name, matrix) in [
        ("mirrored", scaled(-1.0, 1.0, 1.0)),
        ("non-uniform", scaled(1.0, 1e6, 1e-6)),
        ("sheared", shear),
        ("flattened", scaled(1.0, 1.0, 0.0)),
        ("nearly flattened", scaled(1.0, 1.0, 1e-20)),
    ] {
        for z in [4.0, -4.0] {
            let m = pixels(body(matrix, DVec3::new(0.01, 0.02, z), false), &square(8, spp))?;
            tally.mean(format!("{name} cube seen from z = {z}"), &m, 0.5, 0.02);
        }
        if !name.contains("flattened") {
            // Smooth normals of a coarse ball lose energy at grazing angles, but not from the front.
            let m = pixels(body(matrix, DVec3::new(0.01, 0.02, 8.0), true), &square(8, spp))?;
            tally.within(format!("{name} ball"), m.mean, 0.5, 0.01);
        }
    }
    let m = pixels(body(DMat3::ZERO, DVec3::Z * 4.0, false), &square(8, 4))?;
    tally.exactly("an object of scale 0 is invisible", m.mean, 1.0);
    Ok(())
}

fn singular(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = each(&mut tally, effort);
    tally.holds("every scene is built", built.is_ok());
    tally.finish()
}

fn instances(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let mesh = super::hits::lump(3);
    for size in [1e-6, 1.0, 1e6] {
        let turned = glam::DQuat::from_axis_angle(DVec3::new(0.48, 0.6, 0.64), 0.7);
        let place = DVec3::new(2.0, -3.0, 5.0) * size;
        let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(size), turned, place);
        let mut flat = mesh.clone();
        flat.positions.iter_mut().for_each(|p| *p = transform.transform_point3(p.as_dvec3()).as_vec3());
        let mut builder = AccelBuilder::default();
        builder.add_mesh(flat);
        let one = builder.build();
        let shared = Arc::new(mesh.clone());
        let mut builder = AccelBuilder::default();
        builder.add_instance(shared.clone(), transform);
        builder.add_instance(shared, DAffine3::from_translation(DVec3::splat(-1e3 * size)));
        let two = builder.build();
        let (mut noise, mut worst, mut lost) = (Noise(8), 0.0f64, 0);
        for _ in 0..effort.of(2_000, 50_000, 2_000_000) {
            let o = (place + noise.direction().as_dvec3() * (3.0 * size)).as_vec3();
            let target = (place + noise.cube().as_dvec3() * (0.5 * size)).as_vec3();
            let ray = Ray::new(o, (target - o).normalize());
            let [a, b] = [&one, &two].map(|w| w.intersect(&ray, 0.0, &Opaque));
            match (a, b) {
                (Some(a), Some(b)) if a.primitive == b.primitive => {
                    // Rounding moves the intersection with a triangle seen edge-on far along the ray.
                    let steep = one.surface(&ray, 0.0, &a).ng.dot(ray.d).abs();
                    worst = worst.max(f64::from((a.t / b.t - 1.0).abs() * steep));
                }
                (Some(a), Some(b)) => worst = worst.max(f64::from((a.t / b.t - 1.0).abs()) * 1e-2),
                _ => lost += 1,
            }
        }
        tally.none(format!("rays that hit one only, scale {size}"), lost);
        tally.within(format!("relative difference of t, scale {size}"), worst, 0.0, 16.0 * 1.2e-7);
    }
    tally.finish()
}

fn eyes(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let settings =
        Settings { max_bounces: 200, ..square(8, effort.of(8, 64, 1024)) }.with_path(|p| p.roulette = false);
    // Exactly on a wall of the furnace, looking inward, where the radiance is 2, and along the wall.
    for (from, at) in
        [(DVec3::new(1.0, 0.25, 0.5), DVec3::ZERO), (DVec3::new(1.0, 0.25, 0.5), DVec3::new(1.0, 0.3, -1.0))]
    {
        let mut builder = seen(from, at, 0.8);
        let wall = builder.material(matte(0.5, 1.0));
        builder.mesh("room", cube(1.0, Vec3::ZERO), DAffine3::IDENTITY, wall);
        let settings = Settings { strategy: Strategy::BsdfOnly, ..settings.clone() };
        let image = run(&builder.build()?, &settings);
        tally.none("samples that are not finite, camera on a wall", image.stats.bad_sample_count);
        // Rays that start in the wall may leave through it: their radiance is 0 or 2, never anything else.
        let odd = image.film.mean().pixels.iter().filter(|p| !(p.x >= 0.0 && p.x <= 2.0001)).count();
        tally.none("pixels that are not a mixture of room and outside", odd as u64);
    }
    let mut builder = seen(DVec3::new(0.2, 0.1, -0.3), DVec3::new(0.9, 0.4, 0.1), 1.2);
    let clear = builder.material(of(glass(1.5, 0.0)));
    builder.sphere("ball", DVec3::ZERO, 1.0, clear);
    builder.environment(Environment::constant(Vec3::ONE));
    let m = pixels(builder, &settings)?;
    tally.mean("from inside glass, radiance over n²", &m, 2.25, 0.02);
    let mut builder = seen(DVec3::Y, DVec3::new(0.0, 1.0, -5.0), 0.8);
    let grey = builder.material(matte(0.5, 0.0));
    builder.mesh(
        "plane",
        quad(Vec3::new(-5.0, 1.0, 5.0), Vec3::X * 10.0, Vec3::Z * -10.0),
        DAffine3::IDENTITY,
        grey,
    );
    builder.environment(Environment::constant(Vec3::ONE));
    let image = run(&builder.build()?, &settings);
    tally.none("samples that are not finite, camera in a plane", image.stats.bad_sample_count);
    Ok(())
}

fn eye(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = eyes(&mut tally, effort);
    tally.holds("every scene is built", built.is_ok());
    // A chain of nodes whose scale is 0 half way through the exposure.
    let keys = vec![DVec3::ONE, DVec3::ZERO, DVec3::ONE];
    if let Ok(scale) = Track::new(vec![0.0, 0.5, 1.0], keys, Interpolation::Linear) {
        let trs = Trs { scale: Channel::Track(Arc::new(scale)), ..Trs::default() };
        let mut builder = AccelBuilder::default();
        let motion = dapple_integrator::math::Motion::new(vec![Node::Trs(trs)], DAffine3::IDENTITY, 0.0);
        builder.add_moving(cube(1.0, Vec3::ZERO), motion);
        let accel = builder.build_for(0.0, 1.0);
        let hit = accel.intersect(&Ray::new(Vec3::ZERO, Vec3::X), 0.5, &Opaque);
        tally.holds(
            "an object shrunk to the position of the camera is not hit, or at a finite distance",
            hit.is_none_or(|h| h.t.is_finite()),
        );
    }
    tally.finish()
}
