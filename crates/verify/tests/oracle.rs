//! f32 compared with f64: every warp, BSDF, light and intersection against `testkit::oracle`, over its whole domain.
//! With `--nocapture` the tests print the largest deviation of each function and the input at which it occurs.
//!
//! Deviations are relative, except for directions and positions, for which the unit is the length of the vector. The
//! bounds follow from the conditioning of the function and the rounding of its arguments: a few ulp (6e-8), times 1/α²
//! if the density of microfacets depends on a direction, times 1/cos if the direction is nearly in the plane of the
//! surface.

use dapple_integrator::geometry::{Accel, AccelBuilder, Opaque, shapes};
use dapple_integrator::lights::{Area, AreaShape, Environment, Light, Point};
use dapple_integrator::materials::{Bsdf, Lobes, Material, fresnel, microfacet::Ggx};
use dapple_integrator::math::Ray;
use dapple_integrator::sampling::{mis, warp};
use dapple_testkit::oracle::{self, Deviation};
use dapple_testkit::{Rng, intersect};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

/// Prints all deviations, then fails if one exceeds its bound.
fn judge(all: Vec<Deviation>) {
    all.iter().for_each(|d| println!("{d}"));
    let bad: Vec<String> = all.iter().filter(|d| !d.passed()).map(ToString::to_string).collect();
    assert!(bad.is_empty(), "{bad:#?}");
}

/// Points of the unit square: a grid that includes edges and corners, the smallest numbers, and random points.
fn square() -> Vec<Vec2> {
    let last = 1.0 - f32::EPSILON / 2.0;
    let line = [0.0, f32::EPSILON / 2.0, 1e-4, 0.25, 0.5 - f32::EPSILON / 4.0, 0.5, 0.7, 1.0 - 1e-4, last];
    let grid = line.into_iter().flat_map(|x| line.map(|y| Vec2::new(x, y)));
    let mut rng = Rng::new(1);
    let random: Vec<Vec2> = (0..100_000).map(|_| rng.vec2()).collect();
    grid.chain(random).collect()
}

/// A direction with cosine `mu` at azimuth `phi`, rounded to f32.
fn at(mu: f64, phi: f64) -> Vec3 {
    let s = ((1.0 - mu) * (1.0 + mu)).sqrt();
    DVec3::new(s * phi.cos(), s * phi.sin(), mu).as_vec3()
}

/// 10^x for x uniform in low..high.
fn decades(rng: &mut Rng, low: f64, high: f64) -> f64 {
    10f64.powf(low + (high - low) * rng.f64())
}

#[test]
fn warps() {
    // An angle below 2π is rounded to f32 and accurate to 4e-7; near the horizon the cosine is the square root of the
    // rounding error.
    let mut all =
        ["disk", "cosine hemisphere, times cos", "sphere", "cone of 1 − cosθ = 1e-12", "triangle", "tent"]
            .map(|name| Deviation::new(format!("warp: {name}"), 6e-7));
    let mut pdfs = Deviation::new("density: cone, 1e-12 to 2", 2e-7);
    for u in square() {
        let exact: DVec2 = u.as_dvec2();
        let two = |a: Vec2, b: DVec2| (a.as_dvec2() - b).length();
        let three = |a: Vec3, b: DVec3| (a.as_dvec3() - b).length();
        all[0].off(two(warp::disk(u), oracle::warp::disk(exact)), u);
        let up = oracle::warp::hemisphere_cosine(exact);
        all[1].off(three(warp::hemisphere_cosine(u), up) * up.z.max(2.5e-4), u);
        all[2].off(three(warp::sphere(u), oracle::warp::sphere(exact)), u);
        let (narrow, true_one) = (warp::cone(u, 1e-12), oracle::warp::cone(exact, f64::from(1e-12f32)));
        // The offset from the axis, in radii of the cone.
        all[3].off(two(narrow.truncate(), true_one.truncate()) / 2e-12f64.sqrt(), u);
        all[4].off(two(warp::triangle(u), oracle::warp::triangle(exact)), u);
        all[5].absolute(warp::tent(u.x, 1.0), oracle::warp::tent(exact.x), 1.0, u.x);
        let height = 2e-12f64.powf(exact.x) as f32 * 2f32.powf(1.0 - u.x);
        pdfs.relative(warp::cone_pdf(height), 1.0 / (TAU * f64::from(height)), height);
    }
    let mut weights = Deviation::new("power heuristic, densities 1e-38 to 1e38", 3e-7);
    let mut rng = Rng::new(2);
    for _ in 0..100_000 {
        let (a, b) = (decades(&mut rng, -37.9, 38.5) as f32, decades(&mut rng, -37.9, 38.5) as f32);
        let r = f64::from(b) / f64::from(a);
        weights.absolute(mis::power(a, b), 1.0 / (1.0 + r * r), 1.0, (a, b));
    }
    judge(all.into_iter().chain([pdfs, weights]).collect());
}

#[test]
fn fresnel_and_facets() {
    let mut rng = Rng::new(3);
    let mut f = Deviation::new("Fresnel, η 1 ± 1e-7 to 1e±3, times η cosθ_t", 1e-6);
    let mut f0 = Deviation::new("normal reflectance, η 1e-3 to 1e3", 1e-6);
    let mut d = Deviation::new("GGX D, α 1e-3 to 1, tan to 10 α", 1e-6);
    let mut g1 = Deviation::new("Smith G1, cosine 1e-6 to 1", 1e-6);
    let mut visible = Deviation::new("density of visible normals", 2e-6);
    for _ in 0..200_000 {
        let c = if rng.f64() < 0.5 { rng.f32() } else { decades(&mut rng, -7.0, 0.0) as f32 };
        let eta = (1.0 + decades(&mut rng, -7.0, 3.0)).powf(if rng.f64() < 0.5 { 1.0 } else { -1.0 }) as f32;
        // At the critical angle F behaves as a square root: rounding of its argument is amplified by 1/(η cosθ_t)
        // there.
        let edge = ((f64::from(eta) - 1.0) * (f64::from(eta) + 1.0) + f64::from(c).powi(2)).abs().sqrt();
        let off =
            (f64::from(fresnel::dielectric(c, eta)) - oracle::bsdf::fresnel(c.into(), eta.into())).abs();
        f.off(off * edge.clamp(2.5e-4, 1.0), (c, eta));
        let e = decades(&mut rng, -3.0, 3.0) as f32;
        if (e - 1.0).abs() > 1e-3 {
            f0.relative(
                fresnel::normal_reflectance(e),
                ((f64::from(e) - 1.0) / (f64::from(e) + 1.0)).powi(2),
                e,
            );
        }
        let alpha = decades(&mut rng, -3.0, 0.0).max(1.001e-3) as f32;
        let Some(ggx) = Ggx::isotropic(alpha) else { continue };
        let tan = 10.0 * f64::from(alpha) * rng.f64();
        let m = at(1.0 / (1.0 + tan * tan).sqrt(), TAU * rng.f64());
        d.relative(ggx.d(m), oracle::bsdf::d(m.as_dvec3(), alpha.into()), (alpha, m));
        let wo = at(decades(&mut rng, -6.0, 0.0), TAU * rng.f64());
        g1.relative(ggx.g1(wo), oracle::bsdf::g1(wo.as_dvec3(), alpha.into()), (alpha, wo));
        let cos = wo.dot(m);
        // wo·m itself is accurate to an ulp of 1.
        if cos > 0.1 {
            let exact = oracle::bsdf::visible(wo.as_dvec3(), m.as_dvec3(), alpha.into());
            visible.relative(ggx.visible_pdf(wo, m, cos), exact, (alpha, wo, m));
        }
    }
    judge(vec![f, f0, d, g1, visible]);
}

/// Lambert, rough metal and rough glass through the complete [`Bsdf`], value and density, seen at cosines from 0.01 to
/// 1.
#[test]
fn surfaces() {
    let mut rng = Rng::new(4);
    let metal = |roughness| Material { roughness, ..Material::default() };
    let mut lambert = Deviation::new("Lambert, f and density", 3e-7);
    let mut reflected = Deviation::new("rough metal f, times α²", 2e-6);
    let mut refracted = Deviation::new("rough glass, refraction f, times α²(η−1)", 5e-6);
    let mut refracted_pdf = Deviation::new("rough glass, density of refraction, times α²(η−1)", 5e-6);
    let mut turned_pdf = Deviation::new("rough glass, density of reflection, times α²", 2e-5);
    for _ in 0..100_000 {
        let wo = at(decades(&mut rng, -2.0, 0.0), TAU * rng.f64());
        let matte =
            Material { base_color: Vec3::splat(0.5), metallic: 0.0, specular: 0.0, ..Material::default() };
        let wi = at(rng.f64().max(1e-6), TAU * rng.f64());
        let (f, pdf) = Bsdf::new(&matte, wo).eval(wi, Lobes::ALL);
        lambert.relative(f.x, 0.5 / PI, wi);
        lambert.relative(pdf, f64::from(wi.z) / PI, wi);
        let roughness = decades(&mut rng, -1.0, 0.0) as f32;
        let alpha32 = roughness * roughness;
        let alpha = f64::from(alpha32);
        // Directions sampled from the lobe, so that the comparison is where its energy is.
        let bsdf = Bsdf::new(&metal(roughness), wo);
        if let Some(s) = bsdf.sample_f(rng.f32(), rng.vec2(), Lobes::ALL).filter(|s| s.wi.z > 0.01) {
            let exact = oracle::bsdf::reflection(wo.as_dvec3(), s.wi.as_dvec3(), alpha);
            let off = (f64::from(bsdf.f(s.wi, Lobes::ALL).x) / exact - 1.0).abs();
            reflected.off(off * alpha * alpha, (roughness, wo, s.wi));
        }
        let eta32 = 1.1 + 1.4 * rng.f32();
        let glass = Material {
            metallic: 0.0,
            transmission: 1.0,
            thin: false,
            ior: eta32,
            roughness,
            ..Material::default()
        };
        let bsdf = Bsdf::new(&glass, wo);
        let Some(s) = bsdf.sample_f(rng.f32(), rng.vec2(), Lobes::ALL).filter(|s| s.wi.z.abs() > 0.01) else {
            continue;
        };
        let (o, i, eta) = (wo.as_dvec3(), s.wi.as_dvec3(), f64::from(eta32));
        let (f, pdf) = bsdf.eval(s.wi, Lobes::ALL);
        if s.wi.z > 0.0 {
            let exact = oracle::bsdf::reflection_pdf(o, i, alpha, eta);
            // Skips facets whose reflectance is below 2e-3.
            if oracle::bsdf::fresnel(o.dot((o + i).normalize()), eta) > 2e-3 {
                turned_pdf
                    .off((f64::from(pdf) / exact - 1.0).abs() * alpha * alpha, (roughness, eta32, wo, s.wi));
            }
        } else if let Some(m) = oracle::bsdf::refracting(o, i, eta).filter(|m| o.dot(*m) > 0.05) {
            let steep = alpha * alpha * (eta - 1.0);
            let exact = oracle::bsdf::refraction(o, i, alpha, eta);
            refracted.off((f64::from(f.x) / exact - 1.0).abs() * steep, (roughness, eta32, wo, s.wi));
            let exact = oracle::bsdf::refraction_pdf(o, i, alpha, eta);
            if oracle::bsdf::fresnel(o.dot(m), eta) < 0.998 {
                refracted_pdf.off((f64::from(pdf) / exact - 1.0).abs() * steep, (roughness, eta32, wo, s.wi));
            }
        }
    }
    judge(vec![lambert, reflected, refracted, refracted_pdf, turned_pdf]);
}

/// Lights in front of the receiver at the origin, of size about 1 times `size`.
fn shapes_of(size: f32) -> [AreaShape; 4] {
    let (corner, e1, e2) = (Vec3::new(-0.3, 0.2, 1.0), Vec3::new(0.1, 1.0, 0.2), Vec3::new(0.9, -0.1, 0.1));
    let normal = Vec3::new(0.36, 0.48, -0.8);
    [
        AreaShape::Triangle([corner, corner + e1 * size, corner + e2 * size]),
        AreaShape::Quad { corner, e1: e1 * size, e2: e2 * size },
        AreaShape::Sphere { centre: corner, radius: 0.5 * size },
        AreaShape::Disk { centre: corner, normal, radius: 0.5 * size },
    ]
}

/// Density of sampling the position `place` on a light, in f64.
fn density(shape: &AreaShape, place: DVec3) -> f64 {
    let facet = |solid_angle: f64, normal: DVec3, area: f64| {
        // Below this solid angle points are uniform in area.
        if solid_angle > 1e-3 { 1.0 / solid_angle } else { oracle::light::by_area(place, normal, area) }
    };
    match *shape {
        AreaShape::Triangle([a, b, c]) => {
            let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
            let n = (b - a).cross(c - a);
            facet(oracle::light::triangle(a, b, c), n.normalize(), 0.5 * n.length())
        }
        AreaShape::Quad { corner, e1, e2 } => {
            let [a, e1, e2] = [corner, e1, e2].map(|p| p.as_dvec3());
            let solid_angle = oracle::light::triangle(a, a + e1, a + e2)
                + oracle::light::triangle(a + e1, a + e1 + e2, a + e2);
            let n = e1.cross(e2);
            facet(solid_angle, n.normalize(), n.length())
        }
        AreaShape::Sphere { centre, radius } => 1.0 / oracle::light::sphere(centre.as_dvec3(), radius.into()),
        AreaShape::Disk { normal, radius, .. } => {
            oracle::light::by_area(place, normal.as_dvec3(), PI * f64::from(radius).powi(2))
        }
    }
}

#[test]
fn lights() {
    let mut rng = Rng::new(5);
    let names = ["triangle", "quad", "sphere", "disk"];
    let mut densities = names.map(|n| Deviation::new(format!("density: {n} light, Ω 1e-13 to 1"), 6e-7));
    let mut again = names.map(|n| Deviation::new(format!("density by pdf: {n} light"), 6e-7));
    let mut places = names.map(|n| Deviation::new(format!("position on a {n} light over its bound"), 1.0));
    for _ in 0..20_000 {
        let size = decades(&mut rng, -6.5, 0.0) as f32;
        for (k, shape) in shapes_of(size).into_iter().enumerate() {
            let light = Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: true });
            let Some(s) = light.sample(Vec3::ZERO, rng.vec2(), 0.0) else { continue };
            let place = s.wi.as_dvec3() * f64::from(s.distance);
            let exact = density(&shape, place);
            densities[k].relative(s.pdf, exact, (size, s.wi));
            let back = light.pdf(Vec3::ZERO, s.wi, s.distance, Vec3::ZERO, 0.0);
            again[k].relative(back, exact, (size, s.wi));
            if let Some(point) = s.point {
                // wi and the distance are rounded as well, each by an ulp of the distance.
                let room = point.p_error.as_dvec3() + DVec3::splat(1.2e-7 * place.length());
                let off = ((point.p.as_dvec3() - place).abs() / room).max_element();
                places[k].off(off, (size, s.wi));
            }
        }
    }
    let mut points = Deviation::new("point light, distance 1e-6 to 1e6, range", 3e-7);
    for _ in 0..100_000 {
        let p = at(2.0 * rng.f64() - 1.0, TAU * rng.f64()) * decades(&mut rng, -6.0, 6.0) as f32;
        let range = decades(&mut rng, -3.0, 8.0) as f32;
        let light = Light::Point(Point { p, intensity: Vec3::ONE, range });
        let exact = oracle::light::point(p.as_dvec3(), range.into());
        if exact > 1e-3 / p.as_dvec3().length_squared() {
            let value = light.sample(Vec3::ZERO, Vec2::ZERO, 0.0).map_or(0.0, |s| s.radiance.x);
            points.relative(value, exact, (p, range));
        }
    }
    judge(densities.into_iter().chain(again).chain(places).chain([points]).collect());
}

/// The density of an environment map, including poles and a hot texel, is proportional to its radiance.
#[test]
fn environments() {
    let (w, h) = (64usize, 32usize);
    let mut rng = Rng::new(6);
    let mut pixels: Vec<Vec3> = (0..w * h).map(|_| Vec3::splat(rng.f32() + 0.1)).collect();
    pixels[5 * w + 17] = Vec3::splat(1e6);
    let weight = |i: usize| f64::from(pixels[i].x);
    let total: f64 = (0..w * h).map(|i| weight(i) * oracle::light::texel_solid_angle(i / w, w, h)).sum();
    let picture = dapple_integrator::imaging::Image { width: w, height: h, pixels: pixels.clone() };
    let sky = Environment::picture(picture, 0.0, 1.0, false).unwrap().without_compensation();
    let mut pdfs = Deviation::new("density: environment of 1e6 contrast", 1e-6);
    let mut radiances = Deviation::new("radiance of the environment", 0.0);
    for _ in 0..200_000 {
        let Some(s) = sky.sample(rng.vec2()) else { continue };
        // The texel is identified by its radiance, which is different for each texel (with high probability).
        let seen = sky.radiance(s.wi).x;
        radiances.absolute(s.radiance.x, seen.into(), 1.0, s.wi);
        pdfs.relative(s.pdf, oracle::light::texel(seen.into(), total), s.wi);
    }
    judge(vec![pdfs, radiances]);
}

fn accel_of(add: impl FnOnce(&mut AccelBuilder) -> u32) -> Accel {
    let mut builder = AccelBuilder::default();
    add(&mut builder);
    builder.build()
}

/// Distance t and position of hits, at distances of 1e-3 to 1e6 times the size of the shape.
#[test]
fn intersections() {
    let mut rng = Rng::new(7);
    let corners = [Vec3::new(-0.7, 0.1, 0.3), Vec3::new(0.8, -0.2, 0.1), Vec3::new(0.1, 0.9, -0.4)];
    let mesh = dapple_integrator::geometry::Mesh {
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let (centre, normal) = (Vec3::new(0.1, -0.2, 0.3), Vec3::new(0.48, -0.6, 0.64));
    let worlds = [
        ("triangle", accel_of(|b| b.add_mesh(mesh))),
        ("sphere", accel_of(|b| b.add_sphere(shapes::Sphere { centre, radius: 0.8 }))),
        ("disk", accel_of(|b| b.add_disk(shapes::Disk { centre, normal, radius: 0.8 }))),
    ];
    let mut all = Vec::new();
    for (name, accel) in &worlds {
        let mut ts = Deviation::new(format!("t of a {name}, relative to the distance"), 1e-6);
        let mut places = Deviation::new(format!("distance of a hit from its {name} over the bound"), 1.0);
        for _ in 0..100_000 {
            let target = centre + at(2.0 * rng.f64() - 1.0, TAU * rng.f64()) * (0.7 * rng.f32());
            let o = at(2.0 * rng.f64() - 1.0, TAU * rng.f64()) * decades(&mut rng, -3.0, 6.0) as f32;
            let ray = Ray::new(o, (target - o).normalize());
            let Some(hit) = accel.intersect(&ray, 0.0, &Opaque) else { continue };
            let (o, d, s) = (o.as_dvec3(), ray.d.as_dvec3(), accel.surface(&ray, 0.0, &hit));
            let (p, room) = (s.p.as_dvec3(), s.p_error.as_dvec3());
            let [a, b, c] = corners.map(|p| p.as_dvec3());
            let (n, radius) = (normal.as_dvec3().normalize(), f64::from(0.8f32));
            let (t, off) = match *name {
                "triangle" => {
                    let n = (b - a).cross(c - a).normalize();
                    (
                        intersect::triangle(o, d, [a, b, c]).map(|h| h.0),
                        n.dot(p - a).abs() / n.abs().dot(room),
                    )
                }
                "sphere" => {
                    let n = (p - centre.as_dvec3()).normalize();
                    let off = (p - centre.as_dvec3()).length() - radius;
                    (oracle::shape::sphere(o, d, centre.as_dvec3(), radius), off.abs() / n.abs().dot(room))
                }
                _ => {
                    let off = n.dot(p - centre.as_dvec3()).abs() / n.abs().dot(room);
                    (Some(oracle::shape::plane(o, d, centre.as_dvec3(), n)), off)
                }
            };
            // For grazing rays from afar, the rounding of the corners is amplified.
            let steep = s.ng.dot(ray.d).abs();
            if let Some(t) = t.filter(|_| steep > 0.1) {
                ts.absolute(hit.t, t, t.max(1.0), (ray.o, ray.d));
            }
            places.off(off, (ray.o, ray.d));
        }
        all.extend([ts, places]);
    }
    judge(all);
}
