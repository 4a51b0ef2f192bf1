//! Irradiance under every light shape against its closed form, at distances from contact to far away.
mod support;
use dapple_lights::AreaShape;
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::PI;
use support::*;

const N: u32 = 40_000;

#[test]
fn square_lights_of_any_size_and_place() {
    for a in [1.0f32, 0.1, 1e-2, 1e-3, 1e-4] {
        for x in [0.0f32, 3.0, 30.0] {
            let (ad, xd) = (a as f64, x as f64);
            let exact = if a >= 0.05 {
                PI * rectangle([xd - ad, xd + ad], [-ad, ad], 1.0)
            } else {
                // The form factor of small squares suffers from cancellation; the point formula with its second-order
                // term does not.
                let d2 = 1.0 + xd * xd;
                let curvature = (24.0 * xd * xd / (d2 * d2) - 8.0 / d2) * ad * ad / 6.0;
                4.0 * ad * ad / (d2 * d2) * (1.0 + curvature)
            };
            // Corners near x = 30 have 24 bits of precision relative to 30, not to a.
            let rounding = 4e-6 + 3e-6 * xd * 1e-3 / ad;
            agree(
                &format!("a {a} x {x}"),
                irradiance(&area(square(a, x, 1.0), false), Vec3::ZERO, Vec3::Z, N),
                exact,
                rounding,
            );
        }
    }
}

#[test]
fn a_square_from_close_by() {
    for h in [1e-1f32, 1e-2, 1e-3, 1e-5, 1e-7] {
        let hd = h as f64;
        let exact = PI * rectangle([-0.5, 0.5], [-0.5, 0.5], hd);
        agree(
            &format!("h {h}"),
            irradiance(&area(square(0.5, 0.0, h), false), Vec3::ZERO, Vec3::Z, N),
            exact,
            4e-6,
        );
    }
}

#[test]
fn slanted_triangles_and_parallelograms() {
    let n = Vec3::new(0.2, -0.3, 0.9).normalize();
    let corners = [Vec3::new(-1.0, 0.3, 0.5), Vec3::new(1.5, 0.1, 0.2), Vec3::new(0.2, 1.2, 1.5)];
    for scale in [1e-6f32, 1.0, 1e6] {
        let c = corners.map(|c| c * scale);
        let exact = polygon(&c.map(|c| c.as_dvec3()), n.as_dvec3());
        let light = area(AreaShape::Triangle(c), true);
        agree("triangle", irradiance(&light, Vec3::ZERO, n, N), exact, 4e-6);
        let (e1, e2) = (c[1] - c[0], c[2] - c[0]);
        let quad = [c[0], c[0] + e1, c[0] + e1 + e2, c[0] + e2].map(|c| c.as_dvec3());
        let light = area(AreaShape::Quad { corner: c[0], e1, e2 }, true);
        agree("parallelogram", irradiance(&light, Vec3::ZERO, n, N), polygon(&quad, n.as_dvec3()), 4e-6);
    }
}

#[test]
fn a_triangle_from_close_by() {
    for h in [1e-1f32, 1e-3, 1e-5, 1e-7] {
        let c = [Vec3::new(-0.5, -0.4, h), Vec3::new(0.1, 0.6, h), Vec3::new(0.7, -0.3, h)];
        let exact = polygon(&c.map(|c| c.as_dvec3()), DVec3::Z);
        agree(
            &format!("h {h}"),
            irradiance(&area(AreaShape::Triangle(c), false), Vec3::ZERO, Vec3::Z, N),
            exact,
            4e-6,
        );
    }
}

/// The mean of 1/pdf is the solid angle, at every size: a triangle at a fixed position, shrunk towards its first
/// corner.
#[test]
fn mean_of_one_over_pdf_is_the_solid_angle() {
    for k in 0..13 {
        let s = 0.5f32.powi(2 * k);
        let c =
            [Vec3::new(0.1, 0.2, 1.0), Vec3::new(0.1 + s, 0.2, 1.0), Vec3::new(0.1, 0.2 + s, 1.0 + 0.5 * s)];
        let light = area(AreaShape::Triangle(c), true);
        // Quadrature of dω = h·dA/d³ over the triangle as stored.
        let [a, b, d] = c.map(|c| c.as_dvec3());
        let (e1, e2) = (b - a, d - a);
        let h = a.dot(e1.cross(e2)).abs();
        let omega = dapple_testkit::quadrature::rectangle(
            |s, t| (1.0 - s) * h / (a + e1 * s + e2 * (t * (1.0 - s))).length().powi(3),
            [0.0, 0.0],
            [1.0, 1.0],
            1e-9,
        );
        let got = mean(N, 3, |u| light.sample(Vec3::ZERO, u, 0.0).map_or(0.0, |s| 1.0 / s.pdf as f64));
        agree(&format!("size {s}"), got, omega, 1e-6);
    }
}

#[test]
fn tiny_spheres_far_away() {
    for s in [0.1f32, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        for n in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8)] {
            let sphere = AreaShape::Sphere { centre: Vec3::Z * 2.0, radius: 2.0 * s };
            let exact = PI * (s as f64).powi(2) * n.z as f64;
            let (e, se) = irradiance(&area(sphere, false), Vec3::ZERO, n, 400_000);
            assert!(se <= 1e-3 * e);
            agree(&format!("s {s}"), (e, se), exact, 1e-5);
        }
    }
}

#[test]
fn a_sphere_from_near_on_and_inside() {
    for q in [2.0f64, 1.1, 1.0 + 1e-3, 1.0 + 1e-6, 1.0] {
        for cos in [1.0f64, 0.7, 0.2, 0.0, -0.3] {
            let n = Vec3::new((1.0 - cos * cos).sqrt() as f32, 0.0, cos as f32);
            let sphere = AreaShape::Sphere { centre: Vec3::Z * q as f32, radius: 1.0 };
            let exact = self::sphere(q as f32 as f64, cos);
            let got = irradiance(&area(sphere, false), Vec3::ZERO, n, 200_000);
            if exact == 0.0 {
                assert_eq!(got.0, 0.0);
            } else {
                agree(&format!("q {q} cos {cos}"), got, exact, 2e-5);
            }
        }
    }
    for d in [0.999f32, 0.5, 0.0] {
        let sphere = AreaShape::Sphere { centre: Vec3::Z * d, radius: 1.0 };
        for n in [Vec3::Z, Vec3::X, Vec3::NEG_Z] {
            agree("inside", irradiance(&area(sphere, true), Vec3::ZERO, n, 200_000), PI, 1e-6);
        }
        let light = area(sphere, false);
        assert!(
            light.sample(Vec3::ZERO, Vec2::splat(0.3), 0.0).is_none(),
            "a one-sided sphere emits outward only"
        );
        assert_eq!(light.pdf(Vec3::ZERO, Vec3::Z, 1.0, Vec3::Z, 0.0), 0.0);
    }
}

/// A spherical room seen from its own wall: rounding puts the point on either side of the sphere, which must not
/// matter.
#[test]
fn a_spherical_room_from_its_own_wall() {
    let (centre, radius) = (Vec3::new(3.0, -5.0, 11.0), 7.0);
    let light = area(AreaShape::Sphere { centre, radius }, true);
    let (mut inside, mut outside) = (0, 0);
    let mut rng = dapple_testkit::Rng::new(5);
    for _ in 0..2000 {
        let d = Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5).normalize();
        let p = centre + d * radius;
        let rounded_in = (p - centre).as_dvec3().length() < radius as f64;
        *if rounded_in { &mut inside } else { &mut outside } += 1;
        let s = light.sample(p, rng.vec2(), 0.0).unwrap();
        assert!(s.wi.dot(d) < 1e-5, "sampled to the outside, where the wall itself is");
        let reached = (p + s.wi * s.distance - centre).length();
        assert!((reached - radius).abs() < 1e-5 * radius, "{reached}");
        assert!(s.distance > radius * s.wi.dot(-d), "not the far side");
        assert_eq!(s.pdf, light.pdf(p, s.wi, s.distance, Vec3::Z, 0.0));
    }
    assert!(inside > 100 && outside > 100);
    let p = centre + Vec3::X * radius;
    agree("room", irradiance(&light, p, Vec3::NEG_X, 200_000), PI, 1e-6);
    assert!(irradiance(&light, p, Vec3::X, 1000).0 < 1e-6);
}

#[test]
fn disks() {
    for (r, h, d) in
        [(1.0f32, 1.0f32, 0.0f32), (1.0, 0.5, 0.7), (0.3, 2.0, 3.0), (1e-3, 1.0, 0.0), (5.0, 3.0, 1.0)]
    {
        let shape = AreaShape::Disk { centre: Vec3::new(d, 0.0, h), normal: Vec3::NEG_Z, radius: r };
        let exact = PI * disk(r as f64, h as f64, d as f64);
        agree(
            &format!("r {r} h {h} d {d}"),
            irradiance(&area(shape, false), Vec3::ZERO, Vec3::Z, 400_000),
            exact,
            1e-5,
        );
    }
}

/// In the plane and behind a one-sided light the irradiance is zero; on a corner or edge, and one float off the plane,
/// it is finite.
#[test]
fn in_the_plane_behind_and_on_the_edge() {
    let quad = square(1.0, 0.0, 0.0);
    let flat = [
        quad,
        AreaShape::Triangle([Vec3::ZERO, Vec3::Y, Vec3::X]),
        AreaShape::Disk { centre: Vec3::ZERO, normal: Vec3::NEG_Z, radius: 1.0 },
    ];
    let u = Vec2::new(0.3, 0.6);
    for shape in flat {
        for two_sided in [false, true] {
            let light = area(shape, two_sided);
            for p in
                [Vec3::ZERO, Vec3::X, Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 5.0, Vec3::new(0.5, 0.2, 0.0)]
            {
                assert!(light.sample(p, u, 0.0).is_none());
                assert_eq!(light.pdf(p, Vec3::X, 1.0, Vec3::Z, 0.0), 0.0);
                for z in [f32::MIN_POSITIVE, 1e-30, 1e-10, -f32::MIN_POSITIVE, -1e-10] {
                    let above = p + Vec3::Z * z;
                    let n = Vec3::Z * if z < 0.0 { 1.0 } else { -1.0 };
                    let e = irradiance(&light, above, n, 2000).0;
                    assert!((0.0..=PI * 1.3).contains(&e), "{shape:?} {above}: {e}");
                    assert!(!light.pdf(above, Vec3::X, 1.0, Vec3::Z, 0.0).is_nan());
                }
            }
            let behind = light.sample(Vec3::new(0.1, 0.1, 1.0), u, 0.0);
            assert_eq!(behind.is_some(), two_sided);
            assert_eq!(light.pdf(Vec3::new(0.1, 0.1, 1.0), Vec3::NEG_Z, 1.0, Vec3::Z, 0.0) > 0.0, two_sided);
        }
    }
}

#[test]
fn degenerate_shapes_are_dark() {
    let p = Vec3::new(0.1, 0.2, -1.0);
    let shapes = [
        AreaShape::Triangle([Vec3::ONE; 3]),
        AreaShape::Triangle([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]),
        AreaShape::Quad { corner: Vec3::ZERO, e1: Vec3::X, e2: Vec3::ZERO },
        AreaShape::Sphere { centre: Vec3::Z, radius: 0.0 },
        AreaShape::Disk { centre: Vec3::ZERO, normal: Vec3::NEG_Z, radius: 0.0 },
    ];
    for shape in shapes {
        for two_sided in [false, true] {
            assert!(area(shape, two_sided).sample(p, Vec2::splat(0.5), 0.0).is_none(), "{shape:?}");
        }
    }
}
