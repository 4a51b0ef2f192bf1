//! Tests moving objects: at every time they are where their keyframes place them, closed meshes have no leaks, bounding
//! boxes are valid over the whole shutter interval, and mirroring and flattening transforms cause no errors
//! (docs/science.md, "Turning wedge" and "Transforms").
mod solids;

use dapple_geometry::shapes::{Shape, Sphere};
use dapple_geometry::{Accel, AccelBuilder, Mesh, Opaque};
use dapple_math::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_math::{Motion, Ray};
use glam::{DAffine3, DQuat, DVec3, Vec3, Vec4};
use solids::{Noise, cube, leave, sphere};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

fn about_z(angle: f64) -> DQuat {
    DQuat::from_xyzw(0.0, 0.0, libm::sin(angle / 2.0), libm::cos(angle / 2.0))
}

/// Rotation by `total` about z within one second, with keyframes at most a quarter turn apart.
fn spin(total: f64) -> Channel<DQuat> {
    let n = (total / (PI / 2.0)).ceil() as usize;
    let times = (0..=n).map(|i| i as f64 / n as f64).collect();
    let values = (0..=n).map(|i| about_z(total * i as f64 / n as f64)).collect();
    Channel::Track(Arc::new(Track::new(times, values, Interpolation::Linear).unwrap()))
}

fn slide(from: DVec3, to: DVec3) -> Channel<DVec3> {
    Channel::Track(Arc::new(Track::new(vec![0.0, 1.0], vec![from, to], Interpolation::Linear).unwrap()))
}

fn moved(trs: Trs) -> Motion {
    Motion::new(vec![Node::Trs(trs)], DAffine3::IDENTITY, 0.0)
}

fn accel_of(mesh: Mesh, motion: Motion) -> Accel {
    let mut builder = AccelBuilder::default();
    builder.add_moving(mesh, motion);
    builder.build_for(0.0, 1.0)
}

fn quat(noise: &mut Noise) -> DQuat {
    let v = Vec4::new(noise.next(), noise.next(), noise.next(), noise.next() + 0.01);
    DQuat::from_xyzw(v.x.into(), v.y.into(), v.z.into(), v.w.into()).normalize()
}

fn vec3(noise: &mut Noise) -> DVec3 {
    noise.vec().as_dvec3()
}

/// A chain with all kinds of nodes and interpolations.
fn wild(noise: &mut Noise) -> Motion {
    fn track<T: dapple_math::motion::Value>(
        noise: &mut Noise,
        mut value: impl FnMut(&mut Noise) -> T,
    ) -> Channel<T> {
        let keys = 1 + noise.bits() as usize % 6;
        let kind = [Interpolation::Step, Interpolation::Linear, Interpolation::CubicSpline];
        let kind = kind[noise.bits() as usize % 3];
        let times = (0..keys).map(|i| -0.3 + 0.4 * i as f64 + 0.1 * f64::from(noise.unit())).collect();
        let per_key = if kind == Interpolation::CubicSpline { 3 } else { 1 };
        let values = (0..keys * per_key).map(|_| value(noise)).collect();
        Channel::Track(Arc::new(Track::new(times, values, kind).unwrap()))
    }
    let chain = (0..1 + noise.bits() % 3)
        .flat_map(|_| {
            let fixed = DAffine3::from_rotation_translation(quat(noise), vec3(noise));
            let trs = Trs {
                translation: track(noise, vec3),
                rotation: track(noise, quat),
                scale: track(noise, |n| vec3(n) * 2.0),
            };
            [Node::Fixed(fixed), Node::Trs(trs)]
        })
        .collect();
    Motion::new(chain, DAffine3::from_scale(DVec3::splat(4.0)), f64::from(noise.next()))
}

#[test]
fn the_box_holds_all_through_the_shutter() {
    let mut noise = Noise(1);
    for case in 0..300 {
        let motion = wild(&mut noise);
        let accel = accel_of(cube(1.0, Vec3::new(0.5, 0.0, -0.3)), motion);
        let (lo, hi) = accel.bounds().unwrap();
        for i in 0..=400 {
            let time = i as f32 / 400.0;
            for corners in (0..12).map(|t| accel.corners_at(0, t, time)) {
                for p in corners {
                    assert!(p.cmpge(lo).all() && p.cmple(hi).all(), "case {case} time {time}: {p} {lo} {hi}");
                }
            }
        }
    }
}

#[test]
fn the_box_of_a_spin_is_tight() {
    // A bar from 1 to 2 on the x axis with many turns: its bounding box is that of the disk.
    let bar = Mesh {
        positions: vec![Vec3::X, Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 1e-3, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    for turns in [1.0, 3.0, 300.0] {
        let accel = accel_of(bar.clone(), moved(Trs { rotation: spin(turns * TAU), ..Trs::default() }));
        let (lo, hi) = accel.bounds().unwrap();
        assert!(hi.x >= 2.0 && hi.x < 2.02 && lo.y <= -2.0 && lo.y > -2.02, "{turns}: {lo} {hi}");
        assert!(hi.z - lo.z < 0.05, "{turns}: {lo} {hi}");
    }
    // A quarter turn covers a quarter of the disk.
    let accel = accel_of(bar, moved(Trs { rotation: spin(PI / 2.0), ..Trs::default() }));
    let (lo, hi) = accel.bounds().unwrap();
    assert!(lo.x > -0.05 && lo.y > -0.05 && hi.x < 2.02 && hi.y < 2.02, "{lo} {hi}");
}

/// A18: a wedge of angle β rotating by Θ covers the polar angle φ exactly when (φ − τ) mod 2π ∈ [0, β].
#[test]
fn a_wedge_turns_by_any_angle() {
    let beta = 0.35;
    let edge = |a: f64| Vec3::new(libm::cos(a) as f32, libm::sin(a) as f32, 0.0) * 3.0;
    let wedge = Mesh {
        positions: vec![Vec3::ZERO, edge(0.0), edge(beta)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    for total in [90f64, 180.0, 360.0, 1080.0, 1e5].map(f64::to_radians) {
        let accel = accel_of(wedge.clone(), moved(Trs { rotation: spin(total), ..Trs::default() }));
        let phi = 1.234;
        let ray = Ray::new(edge(phi) * 0.3 + Vec3::Z, -Vec3::Z);
        let (mut covered, mut wrong) = (0, 0);
        let n = 20_000;
        for i in 0..n {
            let time = (i as f32 + 0.5) / n as f32;
            let hit = accel.intersect(&ray, time, &Opaque).is_some();
            assert_eq!(hit, accel.occluded(&ray, time, &Opaque));
            covered += usize::from(hit);
            let into = (phi - total * f64::from(time)).rem_euclid(TAU);
            let from_edge = into.min(TAU - into).min((into - beta).abs());
            wrong += usize::from(hit != (into <= beta) && from_edge > 1e-5);
        }
        assert_eq!(wrong, 0, "{total}");
        let turns = total / TAU;
        if (turns - turns.round()).abs() < 1e-9 {
            let share = covered as f64 / f64::from(n as u32);
            assert!(
                (share - beta / TAU).abs() < 3.0 * turns.max(1.0) / f64::from(n as u32),
                "{total}: {share}"
            );
        }
    }
}

#[test]
fn where_nothing_moves_yet_a_moving_object_equals_a_static_one() {
    let ball = sphere(3, 1.0, Vec3::new(0.1, 0.2, 0.3));
    let mut builder = AccelBuilder::default();
    builder.add_mesh(ball.clone());
    let still = builder.build();
    let motion =
        moved(Trs { translation: slide(DVec3::ZERO, DVec3::X), rotation: spin(9.0), ..Trs::default() });
    assert!(motion.is_moving_within(0.0, 1.0) && !motion.is_moving_within(0.5, 0.5));
    assert!(!motion.is_moving_within(1.0, 2.0));
    let moving = accel_of(ball.clone(), motion.clone());
    assert!(moving.has_motion());
    let mut builder = AccelBuilder::default();
    builder.add_moving(ball, motion);
    let flattened = builder.build();
    assert!(!flattened.has_motion());
    let mut noise = Noise(2);
    for _ in 0..5000 {
        let ray = Ray::new(noise.vec() * 2.0, noise.direction());
        let hit = still.intersect(&ray, 0.0, &Opaque);
        assert_eq!(moving.intersect(&ray, 0.0, &Opaque), hit);
        assert_eq!(flattened.intersect(&ray, 0.7, &Opaque), hit);
        let Some(hit) = hit else { continue };
        let (a, b) = (still.surface(&ray, 0.0, &hit), moving.surface(&ray, 0.0, &hit));
        assert_eq!((a.p, a.ng), (b.p, b.ng));
        assert!((a.ns - b.ns).length() < 1e-6);
        assert!(
            b.p_error.cmpge(a.p_error).all() && b.p_error.cmple(a.p_error * 2.0 + Vec3::splat(1e-12)).all()
        );
    }
}

#[test]
fn a_moving_object_equals_its_transformed_mesh() {
    let mut noise = Noise(3);
    let (mut compared, mut lifted) = (0, 0);
    for _ in 0..20 {
        let motion = wild(&mut noise);
        let ball = sphere(2, 1.0, Vec3::ZERO);
        let accel = accel_of(ball.clone(), motion.clone());
        for _ in 0..5 {
            let time = noise.unit();
            let m = motion.at(f64::from(time));
            let s = m.matrix3;
            let volume = s.determinant().abs();
            let size = s.x_axis.length() * s.y_axis.length() * s.z_axis.length();
            if volume < 0.05 * size {
                continue;
            }
            let mut builder = AccelBuilder::default();
            builder.add_instance(ball.clone(), m);
            let expected = builder.build();
            let (lo, hi) = expected.bounds().unwrap();
            for _ in 0..50 {
                let target = (lo + hi) * 0.5 + noise.vec() * (hi - lo) * 0.2;
                let d = noise.direction();
                let ray = Ray::new(target - d * (hi - lo).length(), d);
                let (Some(a), Some(b)) =
                    (accel.intersect(&ray, time, &Opaque), expected.intersect(&ray, 0.0, &Opaque))
                else {
                    continue;
                };
                let (s, e) = (accel.surface(&ray, time, &a), expected.surface(&ray, 0.0, &b));
                // Beside an edge the two may hit different faces.
                if a.primitive == b.primitive && s.ng.dot(d).abs() > 0.1 {
                    assert!((a.t / b.t - 1.0).abs() < 1e-4, "{a:?} {b:?}");
                    assert!((s.p - e.p).length() < 1e-4 * (hi - lo).length());
                    assert!((s.ng - e.ng).length() < 1e-3 && (s.ns - e.ns).length() < 1e-3, "{s:?} {e:?}");
                    for up in [s.ng, -s.ng] {
                        let lifts = [accel.lift(&a, up, time), expected.lift(&b, up, 0.0)];
                        assert!(lifts[0].distance(lifts[1]) < 1e-4 * (hi - lo).length(), "{lifts:?}");
                        lifted += usize::from(lifts[0].length() > 1e-3 * (hi - lo).length());
                    }
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 2000 && lifted > compared / 2, "{compared} {lifted}");
}

#[test]
fn no_ray_escapes_from_inside_a_moving_closed_mesh() {
    let motion = moved(Trs {
        translation: slide(DVec3::new(-3.0, 1.0, 0.0), DVec3::new(5.0, -2.0, 1.0)),
        rotation: spin(17.0),
        scale: slide(DVec3::new(1.0, 2.0, 0.5), DVec3::new(0.5, -2.0, 1.5)),
    });
    let ball = sphere(4, 1.0, Vec3::ZERO);
    let accel = accel_of(ball.clone(), motion.clone());
    let mut noise = Noise(4);
    let mut missed = 0;
    for i in 0..200_000 {
        let time = noise.unit();
        let m = motion.at(f64::from(time));
        if m.matrix3.determinant().abs() < 1e-2 {
            continue;
        }
        let world_point = |p: Vec3| m.transform_point3(p.as_dvec3()).as_vec3();
        let o = world_point(noise.vec() * 0.5);
        let corners = ball.corners(noise.bits() as u32 % ball.triangles.len() as u32);
        let d = match i % 3 {
            0 => noise.direction(),
            1 => world_point(corners[0]) - o,
            _ => world_point(corners[0].lerp(corners[1], noise.unit())) - o,
        };
        missed += usize::from(accel.intersect(&Ray::new(o, d), time, &Opaque).is_none());
    }
    assert_eq!(missed, 0);
}

#[test]
fn moving_bodies_are_left_and_entered_once() {
    let trs = Trs {
        translation: slide(DVec3::new(100.0, 1.0, 0.0), DVec3::new(50.0, -2.0, 1.0)),
        rotation: spin(17.0),
        scale: slide(DVec3::new(1.0, 2.0, -0.5), DVec3::new(0.5, 2.0, -1.5)),
    };
    let mut builder = AccelBuilder::default();
    builder.add_moving_shape(Shape::Sphere(Sphere { centre: Vec3::ZERO, radius: 1.0 }), moved(trs.clone()));
    let worlds = [
        accel_of(cube(1.0, Vec3::ZERO), moved(trs.clone())),
        accel_of(sphere(1, 1.0, Vec3::ZERO), moved(trs)),
        builder.build_for(0.0, 1.0),
    ];
    for (which, accel) in worlds.iter().enumerate() {
        let mut noise = Noise(5);
        let (mut out, mut into) = (0, 0);
        for _ in 0..500 {
            let time = noise.unit();
            let m = accel.placement(0, time).unwrap();
            let target = m.transform_point3(vec3(&mut noise) * 0.3).as_vec3();
            let d = noise.direction();
            let ray = Ray::new(target - d * 8.0, d);
            let hit = accel.intersect(&ray, time, &Opaque).expect("aimed at the body");
            let s = accel.surface(&ray, time, &hit);
            assert!(s.ng.dot(d) < 0.0, "front sides face outward, mirrored or not");
            let bad = leave(accel, &mut noise, &ray, time, &hit, 40);
            out += bad.0;
            into += bad.1;
        }
        assert_eq!((out, into), (0, 0), "body {which}");
    }
}

/// A19, in three variants: flattened into the static tree, as one of two instances, and as a moving object.
fn placed(scale: DVec3, rotation: DQuat) -> [Accel; 3] {
    let m = DAffine3::from_scale_rotation_translation(scale, rotation, DVec3::ZERO);
    let mesh = Arc::new(cube(1.0, Vec3::ZERO));
    let mut alone = AccelBuilder::default();
    alone.add_instance(cube(1.0, Vec3::ZERO), m);
    let mut shared = AccelBuilder::default();
    shared.add_instance(mesh.clone(), m);
    shared.add_instance(mesh.clone(), DAffine3::from_translation(DVec3::splat(1e7)));
    let trs = Trs {
        translation: slide(DVec3::ZERO, DVec3::X),
        rotation: Channel::Constant(rotation),
        scale: Channel::Constant(scale),
    };
    [alone.build(), shared.build(), accel_of(cube(1.0, Vec3::ZERO), moved(trs))]
}

#[test]
fn mirrored_uneven_and_flat_cubes_look_right() {
    let scales = [(-1.0, 1.0, 1.0), (1.0, 1e6, 1e-6), (1.0, 1.0, 0.0), (1.0, 1.0, 1e-20), (1.0, 1.0, 1e-40)];
    let turns = [DQuat::IDENTITY, DQuat::from_xyzw(0.1, -0.4, 0.2, 0.9).normalize()];
    let mut noise = Noise(6);
    for (scale, turn) in scales.iter().flat_map(|s| turns.map(|t| (DVec3::from(*s), t))) {
        for (way, accel) in placed(scale, turn).iter().enumerate() {
            // Corners that are rounded at a distance of 1e6 cannot represent a thickness of 1e-6, except along an axis.
            if way == 0 && scale.y > 1.0 && turn != DQuat::IDENTITY {
                continue;
            }
            // Rays from the front and from the back, slightly tilted, to points inside and outside of the square |x|,
            // |y| < 1.
            for i in 0..2000 {
                let inside = noise.unit() < 0.7;
                let (x, y) =
                    if inside { (noise.next() * 0.98, noise.next() * 0.98) } else { (1.1, noise.next()) };
                let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                let (tilt_x, tilt_y) = (noise.next() * 0.3, noise.next() * 0.3);
                let target = turn * DVec3::new(x.into(), y.into(), 0.0);
                let d = turn * DVec3::new(tilt_x.into(), tilt_y.into(), -side);
                // A cube with depth is viewed along its axis.
                let d = if scale.z.abs() > 0.1 { turn * DVec3::new(0.0, 0.0, -side) } else { d };
                let ray = Ray::new((target - d * 3.0).as_vec3(), d.as_vec3());
                let hit = accel.intersect(&ray, 0.0, &Opaque);
                assert_eq!(hit.is_some(), inside, "{scale} {turn} way {way} at {x} {y}");
                let Some(hit) = hit else { continue };
                let s = accel.surface(&ray, 0.0, &hit);
                let n = (turn * DVec3::Z).as_vec3();
                assert!(
                    s.ng.dot(n).abs() > 0.999 && s.p.is_finite() && s.p_error.is_finite(),
                    "{scale} {s:?}"
                );
                assert!(
                    scale.z.abs() < 0.1 || s.ng.dot(ray.d) < 0.0,
                    "{scale} way {way}: the front faces outward"
                );
                let off = (s.p.as_dvec3() - target).length();
                assert!(off < 1e-6 * scale.max_element() || scale.z.abs() > 0.1, "{scale} {}", s.p);
                let d = noise.about(s.ng * s.ng.dot(ray.d).signum() * -1.0, 0.01);
                assert!(
                    !accel.occluded(&Ray::new(s.origin_towards(d), d), 0.0, &Opaque),
                    "{scale} way {way}"
                );
            }
        }
    }
    for scale in [DVec3::ZERO, DVec3::X] {
        for accel in placed(scale, turns[1]) {
            for _ in 0..1000 {
                let ray = Ray::new(noise.vec() * 3.0, noise.direction());
                assert_eq!(accel.intersect(&ray, 0.0, &Opaque), None);
                assert!(!accel.occluded(&ray, 0.0, &Opaque));
            }
        }
    }
}

/// A20: object space 1e±6 times as large.
#[test]
fn an_instance_at_any_scale_has_the_flat_distance() {
    let mut noise = Noise(7);
    for scale in [1e-6f64, 1e6] {
        let m = DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale),
            DQuat::from_xyzw(0.3, 0.1, -0.2, 0.9).normalize(),
            DVec3::new(0.3, 0.2, 0.1) * scale,
        );
        let mesh = Arc::new(sphere(3, 1.0, Vec3::ZERO));
        let mut builder = AccelBuilder::default();
        builder.add_instance(mesh.clone(), m);
        builder.add_instance(mesh.clone(), DAffine3::from_translation(DVec3::splat(1e9 * scale)));
        let shared = builder.build();
        let mut builder = AccelBuilder::default();
        builder.add_instance(sphere(3, 1.0, Vec3::ZERO), m);
        let flat = builder.build();
        let mut compared = 0;
        for _ in 0..5000 {
            let d = noise.direction();
            let target = m.transform_point3(vec3(&mut noise) * 0.2);
            let ray = Ray::new((target - d.as_dvec3() * (3.0 * scale)).as_vec3(), d);
            let a = shared.intersect(&ray, 0.0, &Opaque).expect("aimed at the ball");
            let b = flat.intersect(&ray, 0.0, &Opaque).expect("aimed at the ball");
            assert!(a.object == 0 && (a.t / b.t - 1.0).abs() < 16.0 * f32::EPSILON, "{} {}", a.t, b.t);
            compared += usize::from(a.primitive == b.primitive);
        }
        assert!(compared > 4900);
    }
}

#[test]
fn a_moving_sphere_is_where_it_should_be() {
    let trs =
        Trs { translation: slide(DVec3::new(-1e3, 0.0, 0.0), DVec3::new(1e3, 0.0, 0.0)), ..Trs::default() };
    let mut builder = AccelBuilder::default();
    builder.add_moving_shape(Shape::Sphere(Sphere { centre: Vec3::ZERO, radius: 1.0 }), moved(trs));
    let accel = builder.build_for(0.0, 1.0);
    let mut noise = Noise(8);
    for _ in 0..20_000 {
        let time = noise.unit();
        let centre = -1e3 * (1.0 - f64::from(time)) + 1e3 * f64::from(time);
        let x = (centre + 1.5 * f64::from(noise.next())) as f32;
        let ray = Ray::new(Vec3::new(x, 0.0, 5.0), -Vec3::Z);
        let off = f64::from(x) - centre;
        match accel.intersect(&ray, time, &Opaque) {
            Some(hit) => {
                let exact = 5.0 - (1.0 - off * off).max(0.0).sqrt();
                assert!((f64::from(hit.t) - exact).abs() < 1e-5, "{} {exact}", hit.t);
                assert!((accel.surface(&ray, time, &hit).ng.x - off as f32).abs() < 1e-5);
            }
            None => assert!(off.abs() > 0.999_99),
        }
    }
}

#[test]
fn mirrors_turn_tangents_and_windings_together() {
    let mut mesh = cube(1.0, Vec3::ZERO);
    mesh.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 8];
    let m = DAffine3::from_scale(DVec3::new(1.0, -2.0, 1.0));
    let mut baked = AccelBuilder::default();
    baked.add_instance(mesh.clone(), m);
    let baked = baked.build();
    let shared = Arc::new(mesh);
    let mut twice = AccelBuilder::default();
    twice.add_instance(shared.clone(), m);
    twice.add_instance(shared, DAffine3::from_translation(DVec3::splat(50.0)));
    let twice = twice.build();
    let ray = Ray::new(Vec3::new(0.3, 0.2, 4.0), -Vec3::Z);
    for accel in [&baked, &twice] {
        let hit = accel.intersect(&ray, 0.0, &Opaque).unwrap();
        assert_eq!(accel.surface(&ray, 0.0, &hit).ng, Vec3::Z);
        assert!((accel.tangent(&hit).unwrap() - Vec4::new(1.0, 0.0, 0.0, -1.0)).length() < 1e-6);
    }
    assert_eq!((baked.triangle_count(), twice.triangle_count()), (12, 24));
    assert!(baked.placement(0, 0.0).is_none() && twice.placement(0, 0.0) == Some(m));
}

#[test]
fn nonsense_ends_without_a_panic() {
    let far = Trs { translation: slide(DVec3::splat(-1e300), DVec3::splat(1e300)), ..Trs::default() };
    let mut builder = AccelBuilder::default();
    builder.add_moving(cube(1.0, Vec3::ZERO), moved(far));
    builder.add_moving(cube(1.0, Vec3::ZERO), Motion::fixed(DAffine3::from_scale(DVec3::NAN)));
    builder.add_moving(Mesh::default(), moved(Trs { rotation: spin(9.0), ..Trs::default() }));
    builder.add_moving(cube(f32::NAN, Vec3::ZERO), moved(Trs { rotation: spin(9.0), ..Trs::default() }));
    let accel = builder.build_for(f32::NAN, f32::NEG_INFINITY);
    let mut noise = Noise(9);
    for time in [0.0, f32::NAN, f32::INFINITY, -1e30] {
        for _ in 0..100 {
            let ray = Ray::new(noise.vec(), noise.direction());
            accel.occluded(&ray, time, &Opaque);
            if let Some(hit) = accel.intersect(&ray, time, &Opaque) {
                accel.surface(&ray, time, &hit);
            }
        }
    }
}
