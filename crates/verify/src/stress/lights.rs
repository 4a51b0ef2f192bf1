//! Stress cases B01 to B06, B15, B16, B20: single lights, from very small and distant to very large and close.

use super::{Case, Check, Effort, Outcome};
use crate::closed_form::{parallel_rectangle, polygon, sphere};
use crate::noise::Noise;
use crate::scenes::irradiance;
use crate::tally::Tally;
use dapple_integrator::lights::light::Light;
use dapple_integrator::lights::{Area, AreaShape, Point, Spot, solid_angle};
use dapple_integrator::sampling::mis;
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::PI;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "B01",
        title: "sphere light from R/d = 0.1 to 1e-6",
        naive: "1 − √(1 − sin²θ) cancels: 7 % too bright at 1e-3, black at 1e-4",
        source: "Pharr, Jakob & Humphreys 2023, §6.2.4; docs/science.md, \"Sphere lights\"",
        check: Check::Run(small_sphere),
    },
    Case {
        id: "B02",
        title: "sphere light from nearby, from its surface, from inside",
        naive: "sample and pdf disagree about the side of a point",
        source: "docs/science.md, \"Sphere lights\"",
        check: Check::Run(near_sphere),
    },
    Case {
        id: "B03",
        title: "triangle light from size/distance 1 to 3e-6",
        naive: "the sum of angles minus π has no correct digit below 3e-4",
        source: "Van Oosterom & Strackee 1983; docs/science.md, \"Polygons\"",
        check: Check::Run(small_triangle),
    },
    Case {
        id: "B04",
        title: "quad light, tiny and oblique",
        naive: "the angles of the spherical rectangle are wrong by 390 % at half side 1e-3, 3 to the side",
        source: "Ureña, Fajardo & King 2013; Van Oosterom & Strackee 1983; docs/science.md, \"Polygons\"",
        check: Check::Run(small_quad),
    },
    Case {
        id: "B05",
        title: "quad and triangle lights that fill the hemisphere",
        naive: "spherical sampling gives NaN near a hemisphere; area sampling has 600 times the variance",
        source: "Arvo 1995; docs/science.md, \"Polygons\"",
        check: Check::Run(huge),
    },
    Case {
        id: "B06",
        title: "receiver in the light's plane, on its edge, behind it",
        naive: "0/0 in the density",
        source: "docs/science.md, \"Polygons\"",
        check: Check::Run(coplanar),
    },
    Case {
        id: "B15",
        title: "point and spot lights at distance 1e-6 and at distance 0",
        naive: "1/d² overflows, and 0/0 is NaN",
        source: "docs/science.md, \"Point and spot lights\"",
        check: Check::Run(points),
    },
    Case {
        id: "B16",
        title: "MIS weights for densities of 1e±38",
        naive: "p² overflows above 1.8e19 and underflows below 2.6e-23: NaN, or energy lost",
        source: "Veach 1997, §9.2; docs/science.md, \"Weights of strategies\"",
        check: Check::Run(weights),
    },
    Case {
        id: "B20",
        title: "spot cones from 1e-4 rad to a right angle, including hard edges",
        naive: "a difference of cosines clamped to 0.001 leaves 2e-6 of a cone of 0.1°; in f32 it is 0 below 3e-4 rad",
        source: "KHR_lights_punctual; I on the axis, I·2π(h₁ + (h₂ − h₁)/3) in all, h = 1 − cosθ",
        check: Check::Run(cones),
    },
];

fn area(shape: AreaShape, two_sided: bool) -> Light {
    Light::Area(Area { shape, radiance: Vec3::ONE, two_sided })
}

fn ball(centre: DVec3, radius: f64, two_sided: bool) -> Light {
    area(AreaShape::Sphere { centre: centre.as_vec3(), radius: radius as f32 }, two_sided)
}

fn small_sphere(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for ratio in [0.1, 1e-2, 1e-3, 2e-4, 1e-4, 1e-5, 1e-6] {
        for (name, scale) in [("", 1.0), (", scale 1e-9", 1e-9), (", scale 1e9", 1e9)] {
            let centre = DVec3::new(0.6, 0.0, 0.8) * scale;
            let light = ball(centre, ratio * scale, false);
            let m = irradiance(&light, Vec3::ZERO, Vec3::Z, 1024, effort.of(8, 64, 1024));
            let (r, d) = (f64::from((ratio * scale) as f32), centre.as_vec3().as_dvec3());
            let exact = PI * (r / d.length()).powi(2) * d.normalize().z;
            tally.mean(format!("R/d = {ratio}{name}"), &m, exact, 1e-4);
        }
    }
    tally.finish()
}

fn near_sphere(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let sets = effort.of(16, 64, 1024);
    for q in [2.0, 1.001, 1.0001] {
        for degrees in [0.0f64, 30.0, 80.0, 100.0, 150.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            // The exact distance of the receiver is that of the centre rounded to f32.
            let centre = (DVec3::new(sin, 0.0, cos) * q).as_vec3();
            let light = ball(centre.as_dvec3(), 1.0, true);
            let m = irradiance(&light, Vec3::ZERO, Vec3::Z, 4096, sets);
            let d = centre.as_dvec3();
            let exact = PI * sphere(d.length(), d.z / d.length());
            tally.mean(format!("d/R = {q}, {degrees}° from the normal"), &m, exact, 0.02);
        }
    }
    for inside in [0.999, 0.5, 0.0] {
        let light = ball(DVec3::new(0.6, 0.0, 0.8) * inside, 1.0, true);
        let m = irradiance(&light, Vec3::ZERO, Vec3::Z, 4096, sets);
        tally.mean(format!("inside, d/R = {inside}"), &m, PI, 0.02);
        let dark = irradiance(&ball(DVec3::Z * inside, 1.0, false), Vec3::ZERO, Vec3::Z, 64, 2);
        tally.exactly(format!("inside a one-sided sphere, d/R = {inside}"), dark.mean, 0.0);
    }
    // A density of 0 for a sampled direction, or the reverse, loses or doubles energy.
    let (mut noise, mut apart) = (Noise(6), 0u64);
    for i in 0..effort.of(1_000, 20_000, 1_000_000) {
        let d = 1.0 + f64::from(i % 3 - 1) * 10f64.powf(-7.0 * f64::from(noise.unit()));
        let light = ball((noise.direction().as_dvec3() * d).as_vec3().as_dvec3(), 1.0, true);
        if let Some(s) = light.sample(Vec3::ZERO, noise.point(), 0.0) {
            let n = s.point.map_or(Vec3::Z, |p| p.n);
            let pdf = light.pdf(Vec3::ZERO, s.wi, s.distance, n, 0.0);
            let close = (pdf / s.pdf - 1.0).abs() <= 4.0 * f32::EPSILON;
            apart += u64::from(!close);
        }
    }
    tally.none("samples whose density differs from pdf", apart);
    tally.finish()
}

/// Solid angle of a triangle seen from the origin, in f64 and computed from edges.
fn omega([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot((b - a).cross(c - a)).abs();
    2.0 * numerator.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + a.dot(c) * lb)
}

fn small_triangle(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for size in [1.0f32, 0.3, 3e-2, 3e-3, 3e-4, 3e-6] {
        let (mut noise, mut worst) = (Noise(31), 0.0f64);
        for _ in 0..effort.of(500, 20_000, 1_000_000) {
            let at = noise.direction();
            let corners = [0; 3].map(|_| at + noise.cube() * size);
            let exact = omega(corners.map(|p| p.as_dvec3()));
            if exact > 0.0 {
                worst = worst.max((solid_angle::triangle(Vec3::ZERO, corners) / exact - 1.0).abs());
            }
        }
        tally.within(format!("solid angle at size/distance {size}"), worst, 0.0, 1e-5);
        let corners = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, size, 1.0), Vec3::new(size, 0.0, 1.0)];
        let m = irradiance(
            &area(AreaShape::Triangle(corners), false),
            Vec3::ZERO,
            Vec3::Z,
            1024,
            effort.of(8, 64, 1024),
        );
        let exact = PI * polygon(&corners.map(|p| p.as_dvec3().to_array()));
        tally.mean(format!("irradiance at size/distance {size}"), &m, exact, 1e-3);
    }
    tally.finish()
}

fn small_quad(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for half in [1.0f32, 0.1, 1e-2, 1e-3, 1e-4] {
        for aside in [0.0f32, 3.0, 30.0] {
            let corner = Vec3::new(aside - half, -half, 1.0);
            let (e1, e2) = (Vec3::Y * (2.0 * half), Vec3::X * (2.0 * half));
            let light = area(AreaShape::Quad { corner, e1, e2 }, false);
            let m = irradiance(&light, Vec3::ZERO, Vec3::Z, 1024, effort.of(8, 64, 1024));
            // The corners in f64, added as the light does.
            let [c, a, b] = [corner, e1, e2].map(|v| v.as_dvec3());
            let corners = [c, c + a, c + a + b, c + b];
            let exact = PI * polygon(&corners.map(|p| p.to_array()));
            // The contour integral of a tiny distant polygon cancels in f64 as well; there the centre is accurate to
            // (size/distance)².
            let d = c + (a + b) * 0.5;
            let small = f64::from(4.0 * half * half) * d.z * d.z / d.length().powi(4);
            let exact = if f64::from(half) < 1e-3 * d.length() { small } else { exact };
            let what = format!("half side {half}, {aside} to the side");
            tally.mean(&*what, &m, exact, 1e-3);
            let point = corner + (e1 + e2) * 0.37;
            let pdf = f64::from(light.pdf(Vec3::ZERO, point.normalize(), point.length(), -Vec3::Z, 0.0));
            let whole =
                omega([corners[0], corners[1], corners[2]]) + omega([corners[0], corners[2], corners[3]]);
            if whole >= 1.1e-3 {
                tally.within(format!("pdf·Ω, {what}"), pdf * whole, 1.0, 1e-5);
            }
        }
    }
    tally.finish()
}

fn huge(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let sets = effort.of(8, 64, 1024);
    for h in [1e-1f32, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let quad = AreaShape::Quad { corner: Vec3::new(-0.5, -0.5, h), e1: Vec3::Y, e2: Vec3::X };
        let m = irradiance(&area(quad, false), Vec3::ZERO, Vec3::Z, 4096, sets);
        let exact = PI * parallel_rectangle([-0.5; 2], [0.5; 2], f64::from(h));
        tally.mean(format!("unit quad at height {h}"), &m, exact, 5e-3);
        let corners = [Vec3::new(-0.5, -0.4, h), Vec3::new(0.1, 0.7, h), Vec3::new(0.6, -0.3, h)];
        let m = irradiance(&area(AreaShape::Triangle(corners), false), Vec3::ZERO, Vec3::Z, 4096, sets);
        let exact = PI * polygon(&corners.map(|p| p.as_dvec3().to_array()));
        tally.mean(format!("triangle at height {h}"), &m, exact, 5e-3);
    }
    tally.finish()
}

fn coplanar(_: Effort) -> Outcome {
    let mut tally = Tally::default();
    let quad = AreaShape::Quad { corner: Vec3::new(0.5, 0.0, 0.0), e1: Vec3::Y, e2: Vec3::X };
    let triangle =
        AreaShape::Triangle([Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.5, 1.0, 0.0), Vec3::new(1.5, 0.0, 0.0)]);
    let disk = AreaShape::Disk { centre: Vec3::X * 2.0, normal: -Vec3::Z, radius: 0.5 };
    for (name, shape) in [("quad", quad), ("triangle", triangle), ("disk", disk)] {
        for two_sided in [false, true] {
            let light = area(shape, two_sided);
            // The light faces −z: above its plane is behind it.
            for z in [0.0, 1e-38, -1e-38, 1e-7, -1e-7] {
                let m = irradiance(&light, Vec3::new(0.0, 0.0, z), Vec3::new(0.0, 0.6, 0.8), 256, 4);
                tally.within(format!("{name} from z = {z}"), m.mean, 0.0, 1e-6);
            }
            let behind = irradiance(&light, Vec3::new(1.0, 0.3, 1.0), -Vec3::Z, 256, 4);
            tally.holds(format!("{name} from behind"), (behind.mean > 0.0) == two_sided);
            for p in [Vec3::new(0.5, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.75, 0.25, 0.0)] {
                for n in [Vec3::Z, -Vec3::Z, Vec3::X] {
                    let m = irradiance(&light, p, n, 256, 4);
                    tally.holds(
                        format!("{name} from {p} on it: 0 ≤ E ≤ π"),
                        (0.0..=PI * 1.001).contains(&m.mean),
                    );
                }
            }
        }
    }
    tally.finish()
}

fn points(_: Effort) -> Outcome {
    let mut tally = Tally::default();
    for d in [1e-6f32, 1e-12, 1e-18, 1.0, 1e12] {
        let p = Vec3::new(0.0, 0.6, 0.8) * d;
        let exact = 0.8 / p.as_dvec3().length_squared();
        let range = f32::INFINITY;
        let spot = Spot { p, axis: -p.normalize(), intensity: Vec3::ONE, inner: 0.1, outer: 0.2, range };
        let lights = [Light::Point(Point { p, intensity: Vec3::ONE, range }), Light::Spot(spot)];
        for light in &lights {
            let m = irradiance(light, Vec3::ZERO, Vec3::Z, 1, 2);
            tally.within(format!("at distance {d}"), m.mean / exact, 1.0, 1e-6);
            tally.holds(
                "at distance 0: skipped",
                light.sample(p, Vec2::ZERO, 0.0).is_none_or(|s| s.radiance.is_finite()),
            );
        }
    }
    tally.finish()
}

fn cones(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let steps = effort.of(10, 40, 400);
    for k in 0..=steps {
        let outer = 1e-4 * (0.5 * PI / 1e-4).powf(f64::from(k) / f64::from(steps));
        for (share, axis) in
            [(0.0, DVec3::Z), (0.9, DVec3::new(0.3, -2.0, 0.7)), (1.0, DVec3::new(-1.0, 1e-4, 5.0))]
        {
            let axis = axis.normalize().as_vec3();
            let (inner, range) = (Spot::height(outer * share), f32::INFINITY);
            let (p, intensity) = (Vec3::ZERO, Vec3::ONE);
            let light = Light::Spot(Spot { p, axis, intensity, inner, outer: Spot::height(outer), range });
            let seen = |at: Vec3| light.sample(at, Vec2::ZERO, 0.0).map_or(0.0, |s| f64::from(s.radiance.x));
            tally.within(format!("on the axis of {outer} rad"), seen(axis), 1.0, 1e-4);
            // Rings about the axis, at their exact angle after rounding.
            let side = axis.any_orthonormal_vector().as_dvec3();
            let (rings, mut flux) = (2000, 0.0);
            for i in 0..rings {
                let angle = outer * (f64::from(i) + 0.5) / f64::from(rings);
                let at = axis.as_dvec3() * angle.cos() + side * angle.sin();
                flux += seen(at.as_vec3()) * angle.sin() * outer / f64::from(rings);
            }
            let power = f64::from(light.power(1.0).x);
            tally.within(format!("flux of {outer} rad, inner {share}"), 2.0 * PI * flux / power, 1.0, 2e-3);
        }
    }
    tally.finish()
}

fn weights(_: Effort) -> Outcome {
    let mut tally = Tally::default();
    let inf = f32::INFINITY;
    for (a, b) in [
        (1e20, 1e18),
        (1e-25, 1e-24),
        (3e38, 1.0),
        (inf, 1.0),
        (1.0, 0.0),
        (1e-30, 1e30),
        (inf, inf),
        (0.3, 0.7),
    ] {
        for (name, w) in [("power", mis::power as fn(f32, f32) -> f32), ("balance", mis::balance)] {
            tally.within(
                format!("{name}: w({a}, {b}) + w({b}, {a})"),
                f64::from(w(a, b) + w(b, a)),
                1.0,
                1e-6,
            );
        }
    }
    tally.exactly("w(0, 0)", f64::from(mis::power(0.0, 0.0)), 0.0);
    tally.exactly("w(0, 1)", f64::from(mis::power(0.0, 1.0)), 0.0);
    tally.within("w(1, 3)", f64::from(mis::power(1.0, 3.0)), 0.1, 1e-7);
    tally.finish()
}
