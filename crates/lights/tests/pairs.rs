//! The samples of every light shape follow `pdf` for receivers of every kind, and the reported points lie on the rays.
mod support;
use dapple_lights::{AreaShape, Environment, Light};
use dapple_math::Image;
use dapple_testkit::{
    Rng,
    chi_square::{ChiSquare, Outcome},
};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};
use support::{area, hit, square};

fn slanted() -> [AreaShape; 2] {
    let corners = [Vec3::new(-1.0, 0.3, 0.5), Vec3::new(1.5, 0.1, 0.2), Vec3::new(0.2, 1.2, 1.5)];
    let [corner, a, b] = corners;
    [AreaShape::Triangle(corners), AreaShape::Quad { corner, e1: a - corner, e2: b - corner }]
}

/// Shape, receiver, two-sided.
fn cases() -> Vec<(AreaShape, Vec3, bool)> {
    let sphere = AreaShape::Sphere { centre: Vec3::new(1.0, 2.0, -1.0), radius: 0.5 };
    let disk =
        AreaShape::Disk { centre: Vec3::new(0.0, 0.5, 1.0), normal: Vec3::new(0.6, 0.0, -0.8), radius: 0.7 };
    let [triangle, skewed] = slanted();
    let wide = square(1.0, 0.4, 0.0);
    vec![
        (triangle, Vec3::ZERO, true),
        (triangle, Vec3::new(0.2, 0.5, 0.6), true),
        (triangle, Vec3::new(40.0, -10.0, 30.0), true),
        (skewed, Vec3::ZERO, true),
        (skewed, Vec3::new(1.0, 0.8, 0.9), true),
        (skewed, Vec3::new(-60.0, 20.0, 50.0), true),
        (wide, Vec3::new(0.0, 0.0, -1.0), false),
        (wide, Vec3::new(0.9, 0.8, -0.01), false),
        (wide, Vec3::new(3.0, 0.5, -0.2), false),
        (wide, Vec3::new(10.0, 70.0, -30.0), false),
        (sphere, Vec3::ZERO, false),
        (sphere, Vec3::new(1.0, 2.0, -0.49), false),
        (sphere, Vec3::new(100.0, 2.0, -1.0), true),
        (sphere, Vec3::new(1.1, 2.2, -1.1), true),
        (sphere, Vec3::new(1.0, 2.0, -1.0), true),
        (disk, Vec3::ZERO, true),
        (disk, Vec3::new(0.1, 0.5, 0.9), false),
        (disk, Vec3::new(20.0, -30.0, 10.0), true),
    ]
}

/// A flat shape parametrised over the unit square: point and area per area of the square, and the inverse map.
struct Chart {
    place: Box<dyn Fn(Vec2) -> (DVec3, f64)>,
    back: Box<dyn Fn(DVec3) -> Vec2>,
    n: DVec3,
}

fn chart(shape: &AreaShape) -> Option<Chart> {
    let (a, e1, e2, triangle) = match *shape {
        AreaShape::Triangle([a, b, c]) => (a.as_dvec3(), (b - a).as_dvec3(), (c - a).as_dvec3(), true),
        AreaShape::Quad { corner, e1, e2 } => (corner.as_dvec3(), e1.as_dvec3(), e2.as_dvec3(), false),
        AreaShape::Disk { centre, normal, radius } => {
            let (c, n, r) = (centre.as_dvec3(), normal.as_dvec3(), radius as f64);
            let (x, y) = n.any_orthonormal_pair();
            let place = move |s: Vec2| {
                let (r, phi) = (r * (s.x as f64).sqrt(), TAU * s.y as f64);
                (c + x * (r * phi.cos()) + y * (r * phi.sin()), PI * radius as f64 * radius as f64)
            };
            let back = move |q: DVec3| {
                let (x, y) = ((q - c).dot(x) / r, (q - c).dot(y) / r);
                Vec2::new((x * x + y * y) as f32, (0.5 + (-y).atan2(-x) / TAU) as f32)
            };
            return Some(Chart { place: Box::new(place), back: Box::new(back), n });
        }
        AreaShape::Sphere { .. } => return None,
    };
    let n = e1.cross(e2);
    let place = move |s: Vec2| {
        let s = s.as_dvec2();
        // The triangle as a square with one side collapsed to a point.
        let (at, stretch) = if triangle { (DVec2::new(s.x * (1.0 - s.y), s.x * s.y), s.x) } else { (s, 1.0) };
        (a + e1 * at.x + e2 * at.y, n.length() * stretch)
    };
    let back = move |q: DVec3| {
        let q = q - a;
        let at = DVec2::new(q.cross(e2).dot(n), e1.cross(q).dot(n)) / n.length_squared();
        let s = if triangle { DVec2::new(at.x + at.y, at.y / (at.x + at.y)) } else { at };
        s.clamp(DVec2::ZERO, DVec2::ONE).as_vec2()
    };
    Some(Chart { place: Box::new(place), back: Box::new(back), n: n.normalize() })
}

/// Directions in the cone that the sphere subtends (all directions from inside): 1 − cosθ over its maximum, and φ.
fn sphere_directions(test: &ChiSquare, light: &Light, shape: &AreaShape, p: Vec3) -> Outcome {
    let AreaShape::Sphere { centre, radius } = *shape else { panic!("a sphere") };
    let (to, r) = ((centre - p).as_dvec3(), radius as f64);
    let s2 = r * r / to.length_squared();
    let height = if s2 < 1.0 { s2 / (1.0 + (1.0 - s2).sqrt()) } else { 2.0 };
    let z = to.try_normalize().unwrap_or(DVec3::Z);
    let (x, y) = z.any_orthonormal_pair();
    test.plane(
        Vec2::ZERO,
        Vec2::ONE,
        |u, _| {
            let wi = light.sample(p, u, 0.0)?.wi.as_dvec3();
            let rise = 0.5 * (wi - z).length_squared() / height;
            let turn = 0.5 + (-wi.dot(y)).atan2(-wi.dot(x)) / TAU;
            Some(DVec2::new(rise, turn).min(DVec2::ONE).as_vec2())
        },
        |s| {
            let v = s.x as f64 * height;
            let (sin, phi) = ((v * (2.0 - v)).sqrt(), TAU * s.y as f64);
            let wi = (x * (sin * phi.cos()) + y * (sin * phi.sin()) + z * (1.0 - v)).as_vec3();
            // A direction on the edge of the cone may round to its outside.
            let (t, n) = hit(shape, p, wi).unwrap_or((to.length(), z));
            (light.pdf(p, wi, t as f32, n.as_vec3(), 0.0) as f64 * TAU * height) as f32
        },
    )
}

/// Flat shapes are tested as densities over the shape, pdf·cosθ/d², which have no silhouette to resolve; spheres as
/// directions about their centre.
#[test]
fn area_lights_follow_their_density() {
    let test = ChiSquare::family(cases().len());
    for (shape, p, two_sided) in cases() {
        let (light, p64) = (area(shape, two_sided), p.as_dvec3());
        let result = match chart(&shape) {
            Some(Chart { place, back, n }) => test.plane(
                Vec2::ZERO,
                Vec2::ONE,
                |u, _| {
                    let wi = light.sample(p, u, 0.0)?.wi.as_dvec3();
                    Some(back(p64 + wi * ((place(Vec2::ZERO).0 - p64).dot(n) / wi.dot(n))))
                },
                |s| {
                    let (q, stretch) = place(s);
                    let d = (q - p64).length();
                    let wi = (q - p64) / d;
                    let pdf = light.pdf(p, wi.as_vec3(), d as f32, n.as_vec3(), 0.0) as f64;
                    (pdf * wi.dot(n).abs() / (d * d) * stretch) as f32
                },
            ),
            None => sphere_directions(&test, &light, &shape, p),
        };
        assert!(result.passed(), "{shape:?} from {p}: {result}");
        assert!((result.integral - 1.0).abs() < 1e-3, "{shape:?} from {p}: {result}");
    }
}

/// `sample` and `pdf` give the same density, as MIS requires, at the reported distance, and the reported point is on
/// the ray.
#[test]
fn samples_carry_their_density_and_their_place() {
    let mut rng = Rng::new(11);
    for (shape, p, two_sided) in cases() {
        let light = area(shape, two_sided);
        for _ in 0..2000 {
            let s = light.sample(p, rng.vec2(), 0.0).unwrap();
            let pdf = light.pdf(p, s.wi, s.distance, Vec3::Z, 0.0);
            assert!((s.pdf / pdf - 1.0).abs() < 1e-6, "{shape:?} from {p}: {} {pdf}", s.pdf);
            assert!((s.wi.length() - 1.0).abs() < 1e-6);
            let point = s.point.unwrap();
            let reached = p.as_dvec3() + s.wi.as_dvec3() * s.distance as f64;
            let off = (reached - point.p.as_dvec3()).length() / (s.distance as f64 + p.length() as f64);
            // At grazing angles the rounding error of the direction is amplified.
            let slope = s.wi.dot(point.n).abs() as f64;
            assert!(off < 1e-6 / slope.max(1e-3), "{shape:?} from {p}: off by {off:.1e}, slope {slope}");
        }
    }
}

/// Barycentric coordinates of flat lights refer to the triangles named in the documentation.
#[test]
fn barycentrics_name_the_place() {
    let mut rng = Rng::new(12);
    for (shape, p, two_sided) in cases() {
        let light = area(shape, two_sided);
        for _ in 0..2000 {
            let point = light.sample(p, rng.vec2(), 0.0).unwrap().point.unwrap();
            let corners = match shape {
                AreaShape::Triangle(corners) => corners,
                AreaShape::Quad { corner, e1, e2 } if point.triangle == 0 => {
                    [corner, corner + e1, corner + e1 + e2]
                }
                AreaShape::Quad { corner, e1, e2 } => [corner, corner + e1 + e2, corner + e2],
                _ => continue,
            };
            let (u, v) = (point.u, point.v);
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-6);
            let q = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
            assert!((q - point.p).length() < 2e-6, "{q} {}", point.p);
            let exact = {
                let c = corners.map(|c| c.as_dvec3());
                (c[1] - c[0]).cross(c[2] - c[0]).normalize().as_vec3()
            };
            assert!((point.n - exact).length() < 1e-6, "the front is counter-clockwise");
        }
    }
}

#[test]
fn ends_of_the_unit_square_are_fine() {
    let end = 1.0 - f32::EPSILON / 2.0;
    for (shape, p, two_sided) in cases() {
        for u in [Vec2::ZERO, Vec2::splat(end), Vec2::new(0.0, end), Vec2::new(end, 0.0), Vec2::splat(0.5)] {
            if let Some(s) = area(shape, two_sided).sample(p, u, 0.0) {
                let point = s.point.unwrap();
                assert!(
                    s.wi.is_finite() && s.distance.is_finite() && point.p.is_finite() && point.n.is_finite()
                );
                assert!(s.pdf > 0.0 && s.pdf.is_finite());
            }
        }
    }
}

fn picture(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Image {
    let pixels = (0..width * height).map(|i| Vec3::splat(f(i % width, i / width))).collect();
    Image { width, height, pixels }
}

#[test]
fn environments_follow_their_density() {
    // Bumps, a bright texel near a pole, dark regions.
    let sky = |x: usize, y: usize| match (x, y) {
        (3, 0) => 50.0,
        (11, 5) => 200.0,
        _ if y > 9 => 0.0,
        _ => 1.0 + ((x * 7 + y * 3) % 5) as f32,
    };
    let test = ChiSquare::family(8);
    for filtered in [false, true] {
        for compensated in [false, true] {
            for rotation in [0.0, 1.234] {
                let env = Environment::picture(picture(16, 12, sky), rotation, 2.0, filtered).unwrap();
                let env = if compensated { env } else { env.without_compensation() };
                let light = Light::Environment(env.clone());
                let result = test.sphere(
                    |u, _| light.sample(Vec3::ZERO, u, 0.0).map(|s| s.wi),
                    |wi| light.pdf(Vec3::ZERO, wi, f32::INFINITY, Vec3::Z, 0.0),
                );
                assert!(result.passed(), "filtered {filtered}, compensated {compensated}: {result}");
                assert!((result.integral - 1.0).abs() < 2e-3, "{result}");
            }
        }
    }
}

/// A sample and a lookup in its direction give the same texel and density, except for directions on a border.
#[test]
fn environment_samples_look_up_their_own_texel() {
    let env = Environment::picture(picture(64, 32, |x, y| (1 + x + 64 * y) as f32), 0.7, 1.0, false).unwrap();
    let (env, mut rng) = (env.without_compensation(), Rng::new(2));
    let mut differ = 0;
    for _ in 0..100_000 {
        let s = env.sample(rng.vec2()).unwrap();
        differ += u32::from(env.radiance(s.wi) != s.radiance || (env.pdf(s.wi) / s.pdf - 1.0).abs() > 1e-6);
    }
    assert!(differ <= 10, "{differ} of 100 000");
}

/// The same for an interpolated map: the radiance is that of the sampled direction, to the last bit.
#[test]
fn interpolated_environment_samples_are_what_is_seen_there() {
    let sky = picture(64, 32, |x, y| if (x, y) == (40, 9) { 1e4 } else { (x % 7 + y) as f32 });
    for compensated in [false, true] {
        let env = Environment::picture(sky.clone(), 0.7, 1.0, true).unwrap();
        let env = if compensated { env } else { env.without_compensation() };
        let (mut rng, mut differ) = (Rng::new(3), 0);
        for _ in 0..100_000 {
            let s = env.sample(rng.vec2()).unwrap();
            assert_eq!(env.radiance(s.wi), s.radiance);
            differ += u32::from((env.pdf(s.wi) / s.pdf - 1.0).abs() > 1e-6);
        }
        assert!(differ <= 10, "{differ} of 100 000");
    }
}
