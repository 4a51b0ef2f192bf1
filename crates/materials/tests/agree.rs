//! Consistency of `sample_f`, `pdf` and `f`: chi-square tests of every lobe, alone and mixed, from both sides, and
//! weight = f·cos/pdf.

use dapple_materials::{Bsdf, Lobe, Lobes, Material, Mirror};
use dapple_testkit::Rng;
use dapple_testkit::chi_square::ChiSquare;
use glam::{Vec2, Vec3};

/// A direction with cosine `mu` (may be negative), rotated by `phi` about z.
fn direction(mu: f32, phi: f32) -> Vec3 {
    let s = ((1.0 - mu) * (1.0 + mu)).sqrt();
    Vec3::new(s * phi.cos(), s * phi.sin(), mu)
}

/// A test case: a name, a material, and the sampled lobes.
struct Case {
    name: &'static str,
    material: Material,
    lobes: Lobes,
}

fn cases(roughness: f32) -> Vec<Case> {
    let metal = Material { base_color: Vec3::new(1.0, 0.8, 0.4), roughness, ..Material::default() };
    let plastic = Material { metallic: 0.0, ..metal };
    let glass = Material { metallic: 0.0, transmission: 1.0, thin: false, roughness, ..Material::default() };
    let case = |name, material, lobes| Case { name, material, lobes };
    vec![
        case("metal", metal, Lobes::ALL),
        case("base alone", plastic, Lobes::of(Lobe::Diffuse)),
        case("plastic", plastic, Lobes::ALL),
        case("glass", glass, Lobes::ALL),
        case("glass, refraction alone", glass, Lobes::of(Lobe::GlossyTransmission)),
        case("glass of index 1.1", Material { ior: 1.1, ..glass }, Lobes::ALL),
        case("glass of index 2.4", Material { ior: 2.4, ..glass }, Lobes::ALL),
        case("pane", Material { thin: true, ..glass }, Lobes::ALL),
        case(
            "everything",
            Material { metallic: 0.3, transmission: 0.5, base_color: metal.base_color, ..glass },
            Lobes::ALL,
        ),
    ]
}

fn chi_square(cases: &[Case], roughness: f32, mus: &[f32], tests: usize, samples: u32) {
    for Case { name, material, lobes } in cases {
        for (k, &mu) in mus.iter().enumerate() {
            // An f32 direction determines its half vector to 6e-8/μ, which has to be small relative to the lobe.
            if roughness * roughness * mu.abs() < 3e-5 {
                continue;
            }
            // Weak refraction by narrow facets gives lobes that are too narrow for the quadrature of the test.
            if material.transmission > 0.0
                && !material.thin
                && roughness * roughness * (material.ior - 1.0) < 5e-4
            {
                continue;
            }
            let bsdf = Bsdf::new(material, direction(mu, 0.7 + k as f32));
            let test = ChiSquare { samples, cells: 200, seed: k as u64 + 1, ..ChiSquare::family(tests) };
            let result =
                test.sphere(|u, uc| bsdf.sample_f(uc, u, *lobes).map(|s| s.wi), |wi| bsdf.pdf(wi, *lobes));
            assert!(result.passed(), "{name}, roughness {roughness}, mu {mu}\n{result}");
        }
    }
}

#[test]
fn samples_follow_the_density() {
    let mus = [1.0, 0.5, 0.05, -0.3];
    let roughness = [0.1, 0.5, 1.0];
    let tests = cases(0.5).len() * mus.len() * roughness.len();
    for r in roughness {
        chi_square(&cases(r), r, &mus, tests, 40_000);
    }
}

/// 20 μ × 9 roughnesses × all cases; takes about a minute and a half.
#[test]
#[ignore = "long"]
fn samples_follow_the_density_everywhere() {
    let mut mus: Vec<f32> = (0..10).map(|i| ((i as f32 + 0.5) / 10.0).powi(2)).collect();
    mus.extend([1.0, 0.999, 1e-2, 1e-3, 1e-6]);
    mus.extend([-1.0, -0.9, -0.75, -0.2, -1e-3]);
    let roughness = [0.032, 0.05, 0.1, 0.2, 0.3162, 0.5, 0.7, 0.866, 1.0];
    let tests = cases(0.5).len() * mus.len() * roughness.len();
    for r in roughness {
        chi_square(&cases(r), r, &mus, tests, 50_000);
    }
}

/// Tested in the plane at distance one along the mirror direction, where the square is a square.
#[test]
fn square_mirror_follows_its_density() {
    let (blurs, mus) = ([1e-3, 0.1, 0.7, 3.0], [1.0, 0.8, 0.3, 0.02, -0.5]);
    for (blur, mu) in blurs.into_iter().flat_map(|blur| mus.map(|mu| (blur, mu))) {
        let material = Material { mirror: Some(Mirror { kr: Vec3::ONE, blur }), ..Material::default() };
        let wo = direction(mu, 0.4);
        let bsdf = Bsdf::new(&material, wo);
        let r = Vec3::new(-wo.x, -wo.y, wo.z);
        let u = if mu == 1.0 { Vec3::X } else { Vec3::Z.cross(r).normalize() };
        let v = r.cross(u);
        let side = Vec2::splat(0.5 * blur * (1.0 + 1e-3));
        let result = ChiSquare { samples: 40_000, ..ChiSquare::family(blurs.len() * mus.len()) }.plane(
            -side,
            side,
            |p, uc| {
                let wi = bsdf.sample_f(uc, p, Lobes::ALL)?.wi;
                Some(Vec2::new(wi.dot(u), wi.dot(v)) / wi.dot(r))
            },
            |p| {
                let w = r + u * p.x + v * p.y;
                let wi = w.normalize();
                bsdf.pdf(wi, Lobes::ALL) * wi.dot(r).powi(3)
            },
        );
        assert!(result.passed(), "blur {blur}, mu {mu}\n{result}");
    }
}

/// The weight is the quotient, the density of a sample is not zero, and every single lobe is consistent as well.
#[test]
fn weight_is_value_times_cosine_over_density() {
    let mut rng = Rng::new(11);
    for roughness in [0.032, 0.1, 0.4, 1.0] {
        let mirror =
            Material { mirror: Some(Mirror { kr: Vec3::ONE, blur: roughness }), ..Material::default() };
        let mirror = Case { name: "square mirror", material: mirror, lobes: Lobes::ALL };
        for Case { name, material, .. } in cases(roughness).into_iter().chain([mirror]) {
            for _ in 0..2000 {
                let wo = rng.direction().as_vec3();
                let bsdf = Bsdf::new(&material, wo);
                for lobes in std::iter::once(Lobes::ALL).chain((0..6).map(|bit| Lobes(1 << bit))) {
                    let Some(s) = bsdf.sample_f(rng.f32(), rng.vec2(), lobes) else { continue };
                    assert!(lobes.contains(s.lobe) && s.weight.min_element() >= 0.0 && s.weight.is_finite());
                    assert!((s.wi.length() - 1.0).abs() < 1e-6, "{name}: {s:?}");
                    if s.lobe.is_delta() {
                        continue;
                    }
                    let (f, pdf) = bsdf.eval(s.wi, lobes);
                    assert!(pdf > 0.0 && (pdf / s.pdf - 1.0).abs() < 1e-4, "{name}: {s:?} against pdf {pdf}");
                    let quotient = f * s.wi.z.abs() / pdf;
                    let error = (quotient - s.weight).abs().max_element() / s.weight.max_element().max(0.05);
                    // The sample uses its own facet; the quotient derives it from wo + wi, whose rounding error is
                    // 1e-7.
                    let eta = if s.lobe == Lobe::GlossyTransmission { s.eta.sqrt() } else { 1.0 };
                    let base = if s.lobe == Lobe::GlossyTransmission { 5e-4 } else { 1e-4 };
                    let tolerance = base + 2e-6 / (wo + s.wi * eta).length();
                    assert!(error < tolerance, "{name}, roughness {roughness}: {s:?} against {quotient}");
                }
            }
        }
    }
}

/// The values of the single lobes add up, and every lobe is selected often enough.
#[test]
fn lobes_add_up() {
    let mut rng = Rng::new(5);
    for Case { name, material, .. } in cases(0.4) {
        for _ in 0..200 {
            let bsdf = Bsdf::new(&material, rng.direction().as_vec3());
            let wi = rng.direction().as_vec3();
            let parts: Vec3 = (0..6).map(|bit| bsdf.f(wi, Lobes(1 << bit))).sum();
            let whole = bsdf.f(wi, Lobes::ALL);
            assert!((parts - whole).abs().max_element() <= 1e-5 * whole.max_element(), "{name}");
            assert!(bsdf.f(wi, Lobes::ALL.without(bsdf.lobes())) == Vec3::ZERO);
        }
        let bsdf = Bsdf::new(&material, direction(0.6, 0.0));
        let mut counts = [0u32; 6];
        for k in 0..10_000 {
            if let Some(s) = bsdf.sample_f(k as f32 / 10_000.0, Vec2::splat(0.4), Lobes::ALL) {
                counts[s.lobe as usize] += 1;
            }
        }
        // Clear dielectrics select by Fresnel reflectance, other lobes have a probability of at least one in twenty.
        let least = if material.transmission > 0.0 { 10 } else { 400 };
        for (bit, count) in counts.into_iter().enumerate() {
            assert!(!bsdf.lobes().contains(LOBES[bit]) || count > least, "{name}: {counts:?}");
        }
    }
}

const LOBES: [Lobe; 6] = [
    Lobe::Diffuse,
    Lobe::GlossyReflection,
    Lobe::GlossyTransmission,
    Lobe::DeltaReflection,
    Lobe::DeltaTransmission,
    Lobe::Mirror,
];

/// f·cos/pdf of the square mirror is k_r exactly, and the density is 1/(l²cos³θ) (docs/science.md, "Linear edges").
#[test]
fn square_mirror_weighs_kr() {
    let kr = Vec3::new(0.9, 0.5, 0.1);
    let mut rng = Rng::new(3);
    for blur in [1e-3, 0.1, 1.0] {
        let material = Material { mirror: Some(Mirror { kr, blur }), ..Material::default() };
        for _ in 0..5000 {
            let wo = rng.direction().as_vec3();
            let Some(s) = Bsdf::new(&material, wo).sample_f(rng.f32(), rng.vec2(), Lobes::ALL) else {
                continue;
            };
            assert_eq!(s.weight, kr);
            let cos = s.wi.dot(Vec3::new(-wo.x, -wo.y, wo.z));
            assert!((s.pdf * blur * blur * cos * cos * cos - 1.0).abs() < 1e-5, "blur {blur}: {s:?}");
            assert_eq!(s.wi.z > 0.0, wo.z > 0.0);
        }
    }
    let sharp = Material { mirror: Some(Mirror { kr, blur: 0.0 }), ..Material::default() };
    let s = Bsdf::new(&sharp, Vec3::new(0.6, 0.0, 0.8))
        .sample_f(0.1, Vec2::splat(0.2), Lobes::ALL)
        .expect("mirror");
    assert_eq!((s.wi, s.weight, s.lobe), (Vec3::new(-0.6, 0.0, 0.8), kr, Lobe::DeltaReflection));
}
