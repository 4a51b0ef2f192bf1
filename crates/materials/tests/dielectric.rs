//! Clear dielectrics: smooth interfaces lose no energy, rough ones gain none, and both directions agree.

mod oracle;

use dapple_materials::fresnel::{dielectric, normal_reflectance};
use dapple_materials::{Bsdf, Lobe, Lobes, Material};
use dapple_sampling::{Key, Pattern, pattern};
use dapple_testkit::{Rng, quadrature};
use glam::{DVec3, Vec2, Vec3};
use oracle::{tilted, turned};

const INDICES: [f32; 10] = [1.0, 1.0002, 1.01, 1.5, 2.4, 10.0, 1000.0, 0.9, 0.6667, 0.1];
const MUS: [f64; 9] = [1.0, 0.9, 0.7, 0.5, 0.2, 0.05, 1e-2, 1e-4, 1e-6];

fn glass(ior: f32, roughness: f32, thin: bool) -> Material {
    Material { metallic: 0.0, transmission: 1.0, ior, roughness, thin, ..Material::default() }
}

/// Sum of the weights of both delta lobes, each sampled alone, with radiance scaling undone.
fn smooth_total(material: &Material, wo: DVec3) -> Vec3 {
    let bsdf = Bsdf::new(material, wo.as_vec3());
    assert!(bsdf.is_delta());
    [Lobes::REFLECTION, Lobes::TRANSMISSION]
        .into_iter()
        .filter_map(|lobes| bsdf.sample_f(0.5, Vec2::splat(0.5), lobes))
        .map(|s| s.weight * s.eta)
        .sum()
}

/// C10, C11: glass is invisible in a white furnace, at every angle, from both sides, thick or thin.
#[test]
fn smooth_glass_loses_nothing() {
    for ior in INDICES {
        for mu in MUS.into_iter().chain(MUS.map(|mu| -mu)) {
            for thin in [false, true] {
                let total = smooth_total(&glass(ior, 0.0, thin), tilted(mu));
                assert!(
                    (total - 1.0).abs().max_element() < 3e-7,
                    "index {ior}, mu {mu}, thin {thin}: {total}"
                );
            }
        }
    }
}

/// Sampling both lobes together gives the same: weight times selection probability is the weight of the lobe alone.
#[test]
fn smooth_glass_mixes() {
    for mu in [1.0, 0.3, -0.8, -0.1] {
        let bsdf = Bsdf::new(&glass(1.5, 0.0, false), tilted(mu).as_vec3());
        let n = 4096;
        let mut sum = 0.0;
        for k in 0..n {
            if let Some(s) = bsdf.sample_f((k as f32 + 0.5) / n as f32, Vec2::splat(0.5), Lobes::ALL) {
                sum += f64::from(s.weight.x * s.eta) / f64::from(n);
            }
        }
        assert!((sum - 1.0).abs() < 1e-3, "mu {mu}: {sum}");
    }
}

/// Diffuse reflectance of an interface [Walsh 1926], from outside and from inside.
#[test]
fn fresnel_average_has_its_closed_form() {
    for (n, outside) in [(1.1, 0.0251574), (1.5, 0.0917780), (2.4, 0.2101813)] {
        let mean = |eta: f64| {
            quadrature::line(
                |x| f64::from(dielectric((x * x) as f32, eta as f32)) * 4.0 * x * x * x,
                0.0,
                1.0,
                1e-6,
            )
        };
        assert!((mean(n) - outside).abs() < 1e-6, "{n}: {}", mean(n));
        let inside = 1.0 - (1.0 - outside) / (n * n);
        assert!((mean(1.0 / n) - inside).abs() < 2e-5, "1/{n}: {} against {inside}", mean(1.0 / n));
    }
}

/// Agreement with Snell's law in f64, including the edge of total internal reflection to ±4 ulp, where F rises without
/// a jump.
#[test]
fn fresnel_agrees_with_snell() {
    for eta in [1.0001f32, 1.1, 1.5, 2.4, 10.0, 1e3, 0.99, 0.6667, 0.1] {
        for k in 1..=1000 {
            let c = k as f32 / 1000.0;
            let (f, exact) = (f64::from(dielectric(c, eta)), oracle::fresnel(f64::from(c), f64::from(eta)));
            let edge = 1.0 - f64::from(eta).powi(2) - f64::from(c).powi(2);
            // F behaves like a square root at the edge, which amplifies an ulp of c.
            let tolerance = 2e-6 + 1e-6 / edge.abs().max(1e-6).sqrt();
            assert!((f - exact).abs() < tolerance, "eta {eta}, c {c}: {f} against {exact}");
        }
    }
    for eta in [0.6667f32, 0.9, 0.1] {
        let edge = ((1.0 - eta) * (1.0 + eta)).sqrt();
        let mut last = 2.0;
        for ulp in -4i32..=4 {
            let f = dielectric(f32::from_bits((edge.to_bits() as i32 + ulp) as u32), eta);
            assert!((0.8..=1.0).contains(&f) && f <= last, "eta {eta}, ulp {ulp}: {f}");
            last = f;
        }
        assert_eq!(dielectric(0.5 * edge, eta), 1.0);
    }
}

/// C08, and the special case of glTF.
#[test]
fn normal_reflectance_at_the_limits() {
    for (eta, r) in
        [(1.5f32, 0.04f64), (1e3, 0.996_008), (1e6, 0.999_996), (1e30, 1.0), (0.0, 1.0), (1.0, 0.0)]
    {
        assert!((f64::from(normal_reflectance(eta)) - r).abs() < 1e-6, "{eta}");
    }
    let schlick = Material { metallic: 0.0, roughness: 0.0, ior: 0.0, ..Material::default() };
    let sample =
        |mu: f64| Bsdf::new(&schlick, tilted(mu).as_vec3()).sample_f(0.0, Vec2::ZERO, Lobes::REFLECTION);
    assert_eq!(sample(0.7).expect("reflects").weight, Vec3::ONE);
}

/// C07: matched indices preserve every bit of direction and weight.
#[test]
fn matched_indices_are_not_there() {
    for ior in [1.0, 1.0 + 1e-7, 1.0 - 1e-7, 1.00009] {
        for (roughness, mu) in [(0.0, 0.4), (0.5, 0.4), (1.0, -0.01)] {
            let wo = tilted(mu).as_vec3();
            let bsdf = Bsdf::new(&glass(ior, roughness, false), wo);
            assert_eq!(bsdf.lobes(), Lobes::of(Lobe::DeltaTransmission));
            let s = bsdf.sample_f(0.3, Vec2::splat(0.3), Lobes::ALL).expect("a transmitted direction");
            assert_eq!((s.wi, s.weight, s.eta), (-wo, Vec3::ONE, 1.0));
        }
    }
}

/// A thin wall is a slab: R = 2F/(1+F), T = (1−F)/(1+F), 0.923077 at normal incidence for 1.5.
#[test]
fn a_pane_is_a_slab() {
    let bsdf = Bsdf::new(&glass(1.5, 0.0, true), Vec3::Z);
    let weight = |lobes| bsdf.sample_f(0.5, Vec2::splat(0.5), lobes).expect("lobe").weight.x;
    assert!((weight(Lobes::TRANSMISSION) - 0.923_077).abs() < 1e-6);
    assert!((weight(Lobes::REFLECTION) - 0.076_923).abs() < 1e-6);
}

/// C06: single scattering only loses energy, and the loss vanishes as the surface becomes smooth. C01 for transmission.
#[test]
fn rough_glass_gains_nothing() {
    let n = 1 << 13;
    let mean = |bsdf: &Bsdf, lobes: Lobes| -> f64 {
        let key = Key::pixel(1, 2, 3);
        let points = (0..n).map(|s| pattern::point_2d(Pattern::Sobol, s, n, key));
        points
            .filter_map(|u| bsdf.sample_f(0.5, u, lobes))
            .map(|s| f64::from(s.weight.x * s.eta))
            .sum::<f64>()
            / f64::from(n)
    };
    for ior in INDICES {
        for mu in MUS.into_iter().chain(MUS.map(|mu| -mu)) {
            for thin in [false, true] {
                for roughness in [0.0317f32, 0.1, 0.3, 0.6, 1.0] {
                    let bsdf = Bsdf::new(&glass(ior, roughness, thin), tilted(mu).as_vec3());
                    let total = mean(&bsdf, Lobes::REFLECTION) + mean(&bsdf, Lobes::TRANSMISSION);
                    // The two lobes are sampled differently, so their sum carries some quadrature error.
                    let top = 1.0 + 3e-4;
                    let bottom = if roughness < 0.05 && mu.abs() > 0.15 { 0.985 } else { 0.0 };
                    assert!(
                        (bottom..top).contains(&total),
                        "index {ior}, mu {mu}, thin {thin}, roughness {roughness}: {total}"
                    );
                }
            }
        }
    }
}

/// F and 1 − F use the same facet, so no sample weighs more than its share of the light.
#[test]
fn no_sample_of_rough_glass_weighs_more_than_one() {
    let mut rng = Rng::new(2);
    for _ in 0..200_000 {
        let ior = INDICES[rng.below(10) as usize];
        let material = glass(ior, rng.f32(), rng.f32() < 0.5);
        let bsdf = Bsdf::new(&material, rng.direction().as_vec3());
        for lobes in [Lobes::REFLECTION, Lobes::TRANSMISSION] {
            if let Some(s) = bsdf.sample_f(rng.f32(), rng.vec2(), lobes) {
                let weight = s.weight.max_element() * s.eta;
                assert!(weight <= 1.0 + 2e-4, "{material:?}: {s:?}");
            }
        }
    }
}

/// C05: f(wo, wi) is symmetric for reflection; for radiance through an interface f(wo, wi)/η_o² is symmetric.
#[test]
fn reciprocity() {
    let mut rng = Rng::new(17);
    let base_color = Vec3::new(0.9, 0.5, 0.2);
    let tint = Material {
        base_color,
        specular: 0.8,
        specular_color: Vec3::new(1.0, 0.6, 2.0),
        ..Material::default()
    };
    let materials = [
        Material { metallic: 0.0, ..tint },
        Material { metallic: 0.4, ..tint },
        Material { metallic: 0.3, transmission: 0.6, thin: false, ..tint },
        Material { metallic: 0.3, transmission: 0.6, thin: true, ..tint },
        Material { metallic: 0.0, transmission: 1.0, thin: false, ior: 1.05, ..Material::default() },
        Material { metallic: 0.0, transmission: 1.0, thin: false, ior: 2.4, ..Material::default() },
    ];
    let (mut seen, mut through) = (0, 0);
    for k in 0..100_000 {
        let material = Material { roughness: 0.2 + 0.8 * rng.f32(), ..materials[k % materials.len()] };
        let wo = rng.direction().as_vec3();
        // A pair that the material connects.
        let Some(sample) = Bsdf::new(&material, wo).sample_f(rng.f32(), rng.vec2(), Lobes::ALL) else {
            continue;
        };
        let wi = sample.wi;
        let there = Bsdf::new(&material, wo).f(wi, Lobes::ALL);
        let back = Bsdf::new(&material, wi).f(wo, Lobes::ALL);
        let crossed = wo.z * wi.z < 0.0 && !material.thin && material.transmission > 0.0;
        let index = |w: Vec3| if crossed && w.z < 0.0 { material.ior } else { 1.0 };
        let (a, b) = (there / index(wo).powi(2), back / index(wi).powi(2));
        let error = (a - b).abs().max_element() / a.max_element();
        // Half vectors are accurate to 1e-7 over the length of their sum; the lobe has a width of roughness².
        let eta = if crossed { index(wi) / index(wo) } else { 1.0 };
        let tolerance = 2e-5 + 2e-6 / ((wo + wi * eta).length() * material.roughness.powi(2));
        assert!(error < tolerance, "{material:?}\n{wo} {wi}: {a} against {b}");
        seen += 1;
        through += usize::from(crossed);
    }
    assert!(seen > 50_000 && through > 10_000, "{seen} {through}");
}

/// Values agree with the textbook formulas in f64.
#[test]
fn values_agree_with_the_oracle() {
    let mut rng = Rng::new(23);
    let mut worst = [0.0f64; 2];
    for _ in 0..50_000 {
        let roughness = 0.05 + 0.95 * rng.f32();
        let ior = [1.1, 1.5, 2.4][rng.below(3) as usize];
        let material = glass(ior, roughness, false);
        let alpha = f64::from(roughness * roughness);
        let wo = turned(0.02 + 0.98 * rng.f64(), 6.0 * rng.f64()) * if rng.f32() < 0.5 { 1.0 } else { -1.0 };
        let bsdf = Bsdf::new(&material, wo.as_vec3());
        let Some(s) = bsdf.sample_f(rng.f32(), rng.vec2(), Lobes::ALL) else { continue };
        let (wo, wi) = (wo.as_vec3().as_dvec3().normalize(), s.wi.as_dvec3().normalize());
        let up = |w: DVec3| if wo.z < 0.0 { DVec3::new(w.x, w.y, -w.z) } else { w };
        let ior = f64::from(ior);
        let eta = if wo.z > 0.0 { ior } else { 1.0 / ior };
        if wi.z.abs() < 0.02 {
            continue;
        }
        let through = wo.z * wi.z < 0.0;
        let exact = if through {
            oracle::refraction(up(wo), up(wi), alpha, eta, |c| 1.0 - oracle::fresnel(c, eta))
        } else {
            oracle::reflection(up(wo), up(wi), alpha, |c| oracle::fresnel(c, eta))
        };
        let error = f64::from(bsdf.f(s.wi, Lobes::ALL).x) / exact - 1.0;
        // Half vectors are accurate to 1e-7 over the length of their sum; the lobe has a width of α. F behaves like a
        // square root at the edge of total internal reflection.
        let sharpness = alpha * if through { (wo + wi * eta).length() } else { (wo + wi).length() };
        let edge = if wo.z < 0.0 { 1e-3 } else { 0.0 };
        assert!(error.abs() < 2e-5 + 3e-6 / sharpness + edge, "{material:?} {wo} {wi}: off by {error:e}");
        worst[usize::from(through)] = worst[usize::from(through)].max(error.abs());
    }
    println!("largest deviation, reflection and refraction: {worst:?}");
}
