//! Triangles with textured emission, and spheres under non-uniform transforms: the samples follow `pdf`, the density
//! integrates to one, and the irradiance agrees with quadrature.
use dapple_lights::pattern::{Emitted, Part, Pattern, Patterned};
use dapple_lights::{Aiming, Area, AreaShape, Light, Moving, Reached};
use dapple_math::Motion;
use dapple_math::motion::{Channel, Interpolation, Node, Track, Trs};
use dapple_testkit::{Rng, chi_square::ChiSquare};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};
use std::sync::Arc;

const CORNERS: [Vec3; 3] = [Vec3::new(-1.0, -0.7, 0.5), Vec3::new(1.3, -0.4, 0.9), Vec3::new(-0.1, 1.2, 0.6)];

/// Emission at barycentric coordinates: a bright square, a ramp, and black.
fn emission(at: DVec2) -> f64 {
    let lit = (at - DVec2::new(0.62, 0.21)).abs().max_element() < 0.02;
    if lit {
        40.0
    } else if at.x < 0.4 {
        at.y * 2.0
    } else {
        0.0
    }
}

/// Bounds of the emission in a part, as the mip pyramid of a texture would give them.
fn judge(part: &Part) -> Emitted {
    let [a, b, c] = part.corners();
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let (from, to) = (DVec2::new(0.6, 0.19), DVec2::new(0.64, 0.23));
    let inside = low.cmpge(from).all() && high.cmple(to).all();
    let touches = low.cmplt(to).all() && high.cmpgt(from).all();
    let ramp = |x: f64, y: f64| if x < 0.4 { 2.0 * y } else { 0.0 };
    let (least, most) = match (inside, touches) {
        (true, _) => (40.0, 40.0),
        (_, true) => (0.0, 40.0),
        _ if high.x < 0.4 => (ramp(0.0, low.y), ramp(0.0, high.y)),
        _ => (0.0, ramp(low.x, high.y)),
    };
    let mean = emission((a + b + c) / 3.0);
    Emitted { low: least, high: most, mean, is_fine: part.step.abs() < 1e-3 }
}

fn patterned() -> Light {
    let (pattern, _) = Pattern::new(4000, Vec2::new(0.4, 0.3), judge);
    let area = Area { shape: AreaShape::Triangle(CORNERS), radiance: Vec3::ONE, two_sided: true };
    Light::Patterned(Box::new(Patterned { area, pattern: Arc::new(pattern.unwrap()) }))
}

const PLACES: [Vec3; 4] =
    [Vec3::ZERO, Vec3::new(0.2, 0.1, 0.6), Vec3::new(40.0, -10.0, 30.0), Vec3::new(0.9, 0.4, 1.2)];

/// The triangle as a square with one side collapsed to a point: position, barycentric coordinates, area per area of the
/// square.
fn place(s: Vec2) -> (DVec3, DVec2, f64) {
    let s = s.as_dvec2();
    let at = DVec2::new(s.x * (1.0 - s.y), s.x * s.y);
    let [a, b, c] = CORNERS.map(Vec3::as_dvec3);
    let n = (b - a).cross(c - a).length();
    (a + (b - a) * at.x + (c - a) * at.y, at, n * s.x)
}

fn normal() -> DVec3 {
    let [a, b, c] = CORNERS.map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize()
}

/// Density per area of the square over which `place` parametrises the triangle.
fn density(light: &Light, aiming: Aiming, p: Vec3, s: Vec2) -> f32 {
    let (q, at, stretch) = place(s);
    let to = q - p.as_dvec3();
    let (d, wi) = (to.length(), to.normalize());
    let n = normal();
    let reached = Reached { wi: wi.as_vec3(), distance: d as f32, n: n.as_vec3(), at: at.as_vec2() };
    let pdf = f64::from(light.pdf_at(aiming, p, &reached, 0.0));
    (pdf * wi.dot(n).abs() / (d * d) * stretch) as f32
}

#[test]
fn patterns_follow_their_density() {
    let light = patterned();
    let test = ChiSquare::family(4);
    let (by_angle, by_area) = (Aiming::SolidAngle, Aiming::Surface);
    for (p, aiming) in [(0, by_angle), (1, by_angle), (1, by_area), (3, by_angle)] {
        let p = PLACES[p];
        let outcome = test.plane(
            Vec2::ZERO,
            Vec2::ONE,
            |u, _| {
                let at = light.sample_as(aiming, p, u, 0.0)?.point?;
                let sum = at.u + at.v;
                Some(Vec2::new(sum, if sum > 0.0 { at.v / sum } else { 0.0 }).min(Vec2::ONE))
            },
            |s| density(&light, aiming, p, s),
        );
        assert!(outcome.passed(), "{aiming:?} from {p}: {outcome}");
    }
}

/// Samples and hits have equal densities unless rounding moves the hit to the next part; dark points are never sampled.
#[test]
fn samples_carry_their_density_and_their_place() {
    let light = patterned();
    let mut rng = Rng::new(3);
    for p in PLACES {
        for aiming in [Aiming::SolidAngle, Aiming::Surface] {
            let (mut differ, n) = (0, 4000);
            for _ in 0..n {
                let s = light.sample_as(aiming, p, rng.vec2(), 0.0).unwrap();
                let point = s.point.unwrap();
                let q = place_of(point.u, point.v);
                assert!((q - point.p.as_dvec3()).length() < 1e-6);
                let at = Vec2::new(point.u, point.v);
                let reached = Reached { wi: s.wi, distance: s.distance, n: point.n, at };
                let pdf = light.pdf_at(aiming, p, &reached, 0.0);
                differ += u32::from((pdf / s.pdf - 1.0).abs() > 1e-5);
            }
            assert!(differ < n / 500, "{aiming:?} from {p}: {differ} of {n}");
        }
    }
}

fn place_of(u: f32, v: f32) -> DVec3 {
    let [a, b, c] = CORNERS.map(Vec3::as_dvec3);
    a + (b - a) * f64::from(u) + (c - a) * f64::from(v)
}

/// ∫ emission·|cosθ| dω by Monte Carlo agrees with the midpoint rule over the triangle.
#[test]
fn irradiance_is_that_of_quadrature() {
    let light = patterned();
    for p in PLACES {
        let n = 1000;
        let mut exact = 0.0;
        for i in 0..n * n {
            let s = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let (q, at, stretch) = place(s);
            let to = q - p.as_dvec3();
            exact += emission(at) * to.normalize().dot(normal()).abs() / to.length_squared() * stretch;
        }
        exact /= f64::from(n * n);
        for aiming in [Aiming::SolidAngle, Aiming::Surface] {
            let mut rng = Rng::new(7);
            let (mut sum, mut squares, samples) = (0.0, 0.0, 40_000);
            for _ in 0..samples {
                let Some(s) = light.sample_as(aiming, p, rng.vec2(), 0.0) else { continue };
                let point = s.point.unwrap();
                let value = emission(DVec2::new(point.u.into(), point.v.into())) / f64::from(s.pdf);
                (sum, squares) = (sum + value, squares + value * value);
            }
            let mean = sum / f64::from(samples);
            let variance = squares / f64::from(samples) - mean * mean;
            let error = (variance / f64::from(samples)).sqrt();
            assert!(
                (mean - exact).abs() < 4.0 * error + 2e-3 * exact,
                "{aiming:?} {p}: {mean} ± {error}, {exact}"
            );
            // Near receivers are included. With uniform sampling the bright square alone would make it about 16.
            // Uniform sampling of the surface has the variation of the distance in addition.
            let relative = variance / (mean * mean);
            assert!(aiming == Aiming::Surface || relative < 0.5, "{aiming:?} {p}: {relative}");
        }
    }
}

/// A motion that is constant in time: rotated, sheared and non-uniformly scaled.
fn still(m: DAffine3) -> Arc<Motion> {
    let translation = Track::new(vec![0.0, 1.0], vec![DVec3::ZERO; 2], Interpolation::Linear).unwrap();
    let trs = Trs { translation: Channel::Track(Arc::new(translation)), ..Trs::default() };
    Arc::new(Motion::new(vec![Node::Trs(trs), Node::Fixed(m)], DAffine3::IDENTITY, 0.0))
}

/// Directions towards an ellipsoid, from near, far and inside, against the density of directions that hit it.
#[test]
fn ovals_follow_their_density() {
    let shear =
        DMat3::from_cols(DVec3::new(0.9, 0.2, 0.0), DVec3::new(0.1, 0.3, 0.2), DVec3::new(0.0, 0.3, -1.7));
    let m = DAffine3::from_mat3_translation(shear, DVec3::new(0.3, 0.2, 2.5));
    let motion = still(m);
    let test = ChiSquare::family(4);
    for (p, two_sided) in [
        (Vec3::ZERO, false),
        (Vec3::new(3.0, 1.0, 2.0), false),
        (Vec3::new(-9.0, 20.0, 30.0), true),
        (Vec3::new(0.35, 0.2, 2.4), true),
    ] {
        let shape = AreaShape::Sphere { centre: Vec3::ZERO, radius: 1.0 };
        let area = Area { shape, radiance: Vec3::ONE, two_sided };
        let light = Light::Moving(Box::new(Moving::area(area, motion.clone(), 1.0, None).oval()));
        let to_object = m.inverse();
        let meets = |wi: Vec3| {
            let (o, d) = (to_object.transform_point3(p.into()), to_object.transform_vector3(wi.into()));
            let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
            let root = b * b - a * c;
            (root >= 0.0)
                .then(|| (-b + if c > 0.0 { -root.sqrt() } else { root.sqrt() }) / a)
                .filter(|t| *t > 0.0)
        };
        let outcome = test.sphere(
            |u, _| light.sample(p, u, 0.5).map(|s| s.wi),
            |wi| meets(wi).map_or(0.0, |t| light.pdf(p, wi, t as f32, Vec3::Z, 0.5)),
        );
        assert!(outcome.passed(), "from {p}: {outcome}");
        // Both sampling methods give the same irradiance.
        let irradiance = |aiming| {
            let n = 500;
            let mut sum = 0.0;
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let Some(s) = light.sample_as(aiming, p, u, 0.5) else { continue };
                let first = meets(s.wi).is_some_and(|t| (t as f32 / s.distance - 1.0).abs() < 1e-3);
                sum += if first { f64::from(s.wi.z.abs() / s.pdf) } else { 0.0 };
            }
            sum / f64::from(n * n)
        };
        let (a, b) = (irradiance(Aiming::SolidAngle), irradiance(Aiming::Surface));
        assert!((a / b - 1.0).abs() < 5e-3, "from {p}: {a} {b}");
        if p.length() > 20.0 {
            let point = light.sample_as(Aiming::Centroid, p, Vec2::ZERO, 0.5).unwrap();
            let seen = f64::from(point.radiance.x * point.wi.z.abs());
            assert!((a / seen - 1.0).abs() < 5e-3, "from {p}: {a}, as a point {seen}");
        }
    }
}
