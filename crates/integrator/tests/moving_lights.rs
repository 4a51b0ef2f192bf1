//! Moving lights: light sampling and rays find them at the same position, at the same time.

use dapple_geometry::shapes::{Disk, Shape, Sphere};
use dapple_geometry::{Accel, AccelBuilder, Mesh, Opaque};
use dapple_lights::{
    Aiming, Area, AreaShape, Distant, Light, LightSample, LightSampler, Moving, Point, Spot,
};
use dapple_math::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_math::offset::offset_origin;
use dapple_math::{Motion, Ray};
use dapple_testkit::Rng;
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use std::sync::Arc;

const SECONDS: f32 = 2.0;
const CORNERS: [Vec3; 4] = [
    Vec3::new(-1.0, -0.5, 0.1),
    Vec3::new(1.0, -0.5, 0.1),
    Vec3::new(1.4, 0.7, 0.1),
    Vec3::new(-0.6, 0.7, 0.1),
];

fn vector(rng: &mut Rng, size: f64) -> DVec3 {
    let mut x = || (2.0 * f64::from(rng.f32()) - 1.0) * size;
    DVec3::new(x(), x(), x())
}

/// Translates, rotates and scales; with `round` the scale is uniform, otherwise it may be non-uniform and mirror.
fn motion(rng: &mut Rng, round: bool) -> Arc<Motion> {
    let times = || vec![0.0, 0.7, 1.5, 2.0];
    let quat = |rng: &mut Rng| {
        let v = vector(rng, 1.0);
        DQuat::from_xyzw(v.x, v.y, v.z, f64::from(rng.f32()) - 0.5).normalize()
    };
    let turns: Vec<_> = (0..4).map(|_| quat(rng)).collect();
    let places: Vec<_> = (0..4).map(|_| vector(rng, 3.0)).collect();
    let scale = |rng: &mut Rng| match round {
        true => DVec3::splat(0.5 + f64::from(rng.f32())),
        false => vector(rng, 1.0) + DVec3::splat(0.05),
    };
    let scales: Vec<_> = (0..4).map(|_| scale(rng)).collect();
    let trs = Trs {
        translation: Channel::Track(Arc::new(Track::new(times(), places, Interpolation::Linear).unwrap())),
        rotation: Channel::Track(Arc::new(Track::new(times(), turns, Interpolation::Linear).unwrap())),
        scale: Channel::Track(Arc::new(Track::new(times(), scales, Interpolation::Linear).unwrap())),
    };
    let fixed = DAffine3::from_translation(vector(rng, 1.0));
    Arc::new(Motion::new(
        vec![Node::Trs(trs), Node::Fixed(fixed)],
        DAffine3::from_scale(DVec3::splat(40.0)),
        0.0,
    ))
}

/// Shapes, each with whether it must remain round.
fn shapes() -> [(AreaShape, bool); 4] {
    let [a, b, c, d] = CORNERS;
    [
        (AreaShape::Triangle([a, b, c]), false),
        (AreaShape::Quad { corner: a, e1: b - a, e2: d - a }, false),
        (AreaShape::Sphere { centre: Vec3::ZERO, radius: 1.0 }, true),
        (AreaShape::Disk { centre: Vec3::ZERO, normal: Vec3::Z, radius: 1.0 }, true),
    ]
}

/// First 600 cases of all shapes, then only the round shapes, as ellipses and ellipsoids.
fn shape_of(case: usize) -> (AreaShape, bool) {
    if case < 600 { shapes()[case % 4] } else { (shapes()[2 + case % 2].0, false) }
}

/// Lights that may be non-round are sampled in their shape at that time.
fn light_of(area: Area, round: bool, motion: &Arc<Motion>) -> Light {
    let is_oval = !round && matches!(area.shape, AreaShape::Sphere { .. } | AreaShape::Disk { .. });
    let moving = Moving::area(area, motion.clone(), SECONDS, None);
    Light::Moving(Box::new(if is_oval { moving.oval() } else { moving }))
}

fn accel(shape: &AreaShape, motion: &Motion) -> Accel {
    let mut builder = AccelBuilder::default();
    let triangles =
        if let AreaShape::Triangle(_) = shape { vec![[0, 1, 2]] } else { vec![[0, 1, 2], [0, 2, 3]] };
    match *shape {
        AreaShape::Sphere { centre, radius } => {
            builder.add_moving_shape(Shape::Sphere(Sphere { centre, radius }), motion.clone())
        }
        AreaShape::Disk { centre, normal, radius } => {
            builder.add_moving_shape(Shape::Disk(Disk { centre, normal, radius }), motion.clone())
        }
        _ => {
            let mesh = Mesh { positions: CORNERS.to_vec(), triangles, ..Mesh::default() };
            builder.add_moving(mesh, motion.clone())
        }
    };
    builder.build_for(0.0, SECONDS)
}

/// The shadow ray as in the tracers.
fn shadow_ray(p: Vec3, sample: &LightSample) -> Ray {
    let point = sample.point.unwrap();
    let target = offset_origin(point.p, point.p_error, point.n, -sample.wi);
    Ray { o: p, d: target - p, t_max: 1.0 }
}

#[test]
fn what_is_aimed_at_is_what_a_ray_meets() {
    let mut rng = Rng::new(11);
    let (mut met, mut mirrored) = (0, 0);
    for case in 0..900 {
        let (shape, round) = shape_of(case);
        let motion = motion(&mut rng, round);
        let accel = accel(&shape, &motion);
        let area = Area { shape, radiance: Vec3::ONE, two_sided: false };
        let light = light_of(area, round, &motion);
        for k in 0..40 {
            let time = SECONDS * rng.f32();
            // Close by, and up to ten thousand sizes away.
            let reach = libm::exp2(f64::from(rng.f32()) * 14.0) * 20.0;
            let p = (motion.at(f64::from(time)).translation + vector(&mut rng, reach)).as_vec3();
            let aiming = [Aiming::SolidAngle, Aiming::Surface][k % 2];
            let Some(sample) = light.sample_as(aiming, p, rng.vec2(), time) else { continue };
            assert!(
                !accel.occluded(&shadow_ray(p, &sample), time, &Opaque),
                "{shape:?}, case {case}: hides itself"
            );
            let point = sample.point.unwrap();
            // At grazing angles and large distances, a ray may miss the edge.
            if sample.wi.dot(point.n) > -0.05 || reach > 2000.0 {
                continue;
            }
            let again = light.pdf_as(aiming, p, sample.wi, sample.distance, Vec3::Z, time);
            // For very flat shapes, the rounding of the direction is magnified in the local space of ellipses and
            // ellipsoids.
            let tolerance = if case < 600 { 1e-3 } else { 2e-2 };
            assert!((again / sample.pdf - 1.0).abs() < tolerance, "{shape:?}: {again} for {}", sample.pdf);
            let ray = Ray::new(p, sample.wi);
            let Some(hit) = accel.intersect(&ray, time, &Opaque) else { continue };
            let surface = accel.surface(&ray, time, &hit);
            let size = sample.distance * 1e-4;
            assert!((surface.p - point.p).length() < size, "{shape:?}: {} for {}", surface.p, point.p);
            assert!(surface.ng.dot(point.n) > 0.999, "{shape:?}: {} for {}", surface.ng, point.n);
            if let AreaShape::Triangle(_) = shape {
                assert!((Vec2::new(hit.u, hit.v) - Vec2::new(point.u, point.v)).length() < 0.02);
                mirrored += u32::from(motion.at(time.into()).matrix3.determinant() < 0.0);
            }
            met += 1;
        }
    }
    assert!(met > 3000 && mirrored > 100, "{met} {mirrored}");
}

/// With a light at rest in the scene, a moving light is chosen with high probability near its current position.
#[test]
fn bounds_hold_all_through_the_shutter() {
    let mut rng = Rng::new(12);
    for case in 0..200 {
        let (shape, round) = shape_of(case);
        let motion = motion(&mut rng, round);
        let area = Area { shape, radiance: Vec3::ONE, two_sided: false };
        let moving = light_of(area, round, &motion);
        let p = Vec3::new(1e4, 0.0, 0.0);
        let other = Light::Point(Point { p, intensity: Vec3::splat(1e3), range: f32::INFINITY });
        let lights = [moving, other];
        let choice = LightSampler::new(&lights, 200.0).unwrap();
        for _ in 0..20 {
            let time = SECONDS * rng.f32();
            let Light::Moving(l) = &lights[0] else { unreachable!() };
            let Some(Light::Area(now)) = l.at(time) else { continue };
            let seen = now.shape.centroid() + vector(&mut rng, 1.0).as_vec3();
            let n = (now.shape.centroid() - seen).normalize_or(Vec3::Z);
            if lights[0].sample(seen, Vec2::splat(0.4), time).is_some() {
                let pmf = choice.pmf(seen, n, 0);
                assert!(pmf > 0.3, "{shape:?}, case {case}: {pmf}");
            }
        }
    }
}

#[test]
fn delta_lights_stand_where_their_chain_ends() {
    let mut rng = Rng::new(13);
    let motion = motion(&mut rng, true);
    let (intensity, range) = (Vec3::splat(3.0), f32::INFINITY);
    let own = DVec3::new(0.1, 0.2, -0.3);
    let point = Point { p: own.as_vec3(), intensity, range };
    let spot = Spot { p: own.as_vec3(), axis: Vec3::NEG_Z, intensity, inner: 0.1, outer: 0.2, range };
    let distant = Distant { towards: Vec3::Y, irradiance: intensity };
    let boxed = |m: Moving| Light::Moving(Box::new(m));
    let lights = [
        boxed(Moving::point(point, motion.clone(), SECONDS)),
        boxed(Moving::spot(spot, motion.clone(), SECONDS)),
        boxed(Moving::distant(distant, motion.clone(), SECONDS)),
    ];
    for i in 0..=20 {
        let time = SECONDS * i as f32 / 20.0;
        let m = motion.at(time.into());
        let there = m.transform_point3(own);
        let axis = -m.matrix3.z_axis.normalize();
        // In the middle of the spot's cone.
        let p = (there + axis * 5.0).as_vec3();
        for light in &lights[..2] {
            let s = light.sample(p, Vec2::ZERO, time).unwrap();
            assert!(s.delta && light.is_delta() && !light.is_area());
            assert!((s.wi.as_dvec3() + axis).length() < 1e-4 && (s.distance - 5.0).abs() < 1e-3);
            assert!((s.radiance.x - 3.0 / 25.0).abs() < 1e-4);
            assert_eq!(light.pdf(p, s.wi, s.distance, Vec3::Z, time), 0.0);
        }
        let s = lights[2].sample(p, Vec2::ZERO, time).unwrap();
        assert!((s.wi.as_dvec3() - m.matrix3.y_axis.normalize()).length() < 1e-6);
    }
    assert!(LightSampler::new(&lights, 10.0).is_some());
}
