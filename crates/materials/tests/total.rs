//! All functions are total: for any parameters, directions and points no result is NaN, negative or infinite, and
//! energy is conserved at every corner of the parameter space.

use dapple_materials::{Bsdf, Lobes, Material, Mirror};
use dapple_sampling::{Key, Pattern, pattern};
use dapple_testkit::Rng;
use glam::{Vec2, Vec3};

const TOP: f32 = 1.0 - 1.0 / 16_777_216.0;
const COSINES: [f32; 14] =
    [1.0, -1.0, 0.9999999, 0.5, -0.5, 0.1, 1e-3, -1e-3, 1e-6, 1e-20, 1e-40, 0.0, -0.0, -1e-20];

fn tilted(mu: f32) -> Vec3 {
    Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

fn check(material: &Material, wo: Vec3, rng: &mut Rng) {
    let bsdf = Bsdf::new(material, wo);
    let said = || format!("{material:?}, wo {wo:?}");
    let fair = |v: Vec3| v.is_finite() && v.min_element() >= 0.0;
    assert!(fair(bsdf.albedo()) && bsdf.albedo().max_element() < 1.02, "{}: {}", said(), bsdf.albedo());
    if wo.z == 0.0 {
        assert!(bsdf.lobes().is_empty() && bsdf.is_delta());
    }
    let mut uc = vec![0.0, TOP, 0.5];
    uc.push(rng.f32());
    for uc in uc {
        for u in [
            Vec2::ZERO,
            Vec2::splat(TOP),
            Vec2::new(0.0, TOP),
            Vec2::new(TOP, 0.0),
            Vec2::splat(0.5),
            rng.vec2(),
        ] {
            for lobes in [Lobes::ALL, Lobes::REFLECTION, Lobes::TRANSMISSION, Lobes(1), Lobes::NONE] {
                let Some(s) = bsdf.sample_f(uc, u, lobes) else { continue };
                assert!(lobes.contains(s.lobe) && bsdf.lobes().contains(s.lobe), "{}: {s:?}", said());
                assert!(fair(s.weight) && s.pdf > 0.0 && s.pdf.is_finite(), "{}: {s:?}", said());
                assert!((s.wi.length() - 1.0).abs() < 1e-6 && s.eta > 0.0, "{}: {s:?}", said());
                assert_eq!(s.wi.z.signum() != wo.z.signum(), s.lobe.is_transmission(), "{}: {s:?}", said());
                let (f, pdf) = bsdf.eval(s.wi, lobes);
                assert!(f.min_element() >= 0.0 && !f.is_nan() && pdf >= 0.0, "{}: {s:?}, {f}, {pdf}", said());
                assert!(s.lobe.is_delta() || pdf > 0.0 || (wo + s.wi).length() < 1e-3, "{}: {s:?}", said());
            }
        }
    }
    for mu in COSINES {
        for wi in [tilted(mu), -tilted(mu), -wo, rng.direction().as_vec3()] {
            let (f, pdf) = bsdf.eval(wi, Lobes::ALL);
            assert!(f.min_element() >= 0.0 && !f.is_nan(), "{}, wi {wi}: {f}", said());
            assert!((0.0..f32::INFINITY).contains(&pdf), "{}, wi {wi}: {pdf}", said());
            assert!(wi.z != 0.0 || (f == Vec3::ZERO && pdf == 0.0));
        }
    }
}

fn each_corner(mut visit: impl FnMut(&Material)) {
    let colors = [Vec3::ZERO, Vec3::ONE, Vec3::new(1.0, 0.0, 0.5)];
    for (metallic, transmission, specular) in [0.0, 0.5, 1.0]
        .into_iter()
        .flat_map(|m| [0.0, 0.5, 1.0].map(|t| (m, t)))
        .flat_map(|(m, t)| [0.0, 0.5, 1.0].map(|s| (m, t, s)))
    {
        for (base_color, specular_color) in colors.into_iter().flat_map(|b| colors.map(|s| (b, s))) {
            for ior in [0.0, 1.0, 1.5] {
                for thin in [false, true] {
                    let shape = Material {
                        metallic,
                        transmission,
                        specular,
                        base_color,
                        specular_color,
                        ior,
                        thin,
                        ..Material::default()
                    };
                    for roughness in [0.0, 0.04, 0.4, 1.0] {
                        visit(&Material { roughness, ..shape });
                    }
                }
            }
        }
    }
}

#[test]
fn corners_survive_every_direction() {
    let mut rng = Rng::new(1);
    let mut k = 0;
    each_corner(|material| {
        // Every direction is tested with some corners, and every corner with some directions.
        k += 1;
        for i in 0..3 {
            check(material, tilted(COSINES[(k + 5 * i) % COSINES.len()]), &mut rng);
        }
    });
}

#[test]
fn nonsense_survives() {
    let mut rng = Rng::new(2);
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -1.0,
        0.0,
        1e-40,
        1e-7,
        1e-4,
        1.0,
        1.0 + 1e-7,
        2.0,
        1e3,
        1e6,
        1e30,
    ];
    let pick = |rng: &mut Rng| odd[rng.below(odd.len() as u32) as usize];
    for _ in 0..4000 {
        let material = Material {
            base_color: Vec3::new(rng.f32(), 0.0, 1.0),
            metallic: pick(&mut rng),
            roughness: pick(&mut rng),
            ior: pick(&mut rng),
            specular: pick(&mut rng),
            specular_color: Vec3::new(pick(&mut rng), 1.0, 0.0),
            transmission: pick(&mut rng),
            thin: rng.f32() < 0.5,
            mirror: (rng.f32() < 0.1).then(|| Mirror { kr: Vec3::splat(0.5), blur: pick(&mut rng) }),
            ..Material::default()
        };
        let mu = COSINES[rng.below(14) as usize];
        check(&material, tilted(mu), &mut rng);
    }
    assert!(Bsdf::new(&Material::default(), Vec3::splat(f32::NAN)).lobes().is_empty());
}

/// Near-normal and near-grazing directions at every roughness, with numerically difficult indices.
#[test]
fn awkward_indices_survive() {
    let mut rng = Rng::new(3);
    for ior in [1.0 - 1e-7, 1.0 + 1e-7, 1.00011, 1.001, 1.33, 1e3, 1e6, 0.5, 1e-3] {
        for k in 0..=40 {
            let roughness = k as f32 / 40.0;
            for thin in [false, true] {
                let material = Material {
                    metallic: 0.0,
                    transmission: 1.0,
                    ior,
                    thin,
                    roughness,
                    ..Material::default()
                };
                let wo = rng.direction().as_vec3();
                check(&material, wo, &mut rng);
                check(&material, tilted(COSINES[k % COSINES.len()]), &mut rng);
            }
        }
    }
}

/// C13: the sum of all lobes never exceeds the incident light, in any channel, at every corner.
#[test]
fn corners_keep_their_energy() {
    let n = 1024;
    let points: Vec<Vec2> =
        (0..n).map(|s| pattern::point_2d(Pattern::Sobol, s, n, Key::pixel(4, 0, 0))).collect();
    let mut k = 0usize;
    each_corner(|material| {
        k += 1;
        let mu = [1.0, 0.6, 0.2, 0.03, -0.9, -0.4, -0.1][k % 7];
        let bsdf = Bsdf::new(material, tilted(mu));
        let mut total = Vec3::ZERO;
        for lobes in (0..6).map(|bit| Lobes(1 << bit)) {
            let sum: Vec3 =
                points.iter().filter_map(|&u| bsdf.sample_f(0.5, u, lobes)).map(|s| s.weight * s.eta).sum();
            total += sum / n as f32;
        }
        // 1024 points leave an error of about 1e-3.
        assert!(
            total.max_element() < 1.0 + 3e-3 && total.min_element() >= 0.0,
            "{material:?}, mu {mu}: {total}"
        );
        let white = material.base_color == Vec3::ONE && material.specular_color == Vec3::ONE;
        if white && material.roughness == 0.0 {
            assert!(total.min_element() > 1.0 - 5e-3, "{material:?}, mu {mu}: {total}");
        }
    });
}

/// The ideal limit: a sharpened rough lobe equals the smooth one, with F at the macroscopic angle.
#[test]
fn sharp_lobes_are_smooth_ones() {
    let rough =
        Material { metallic: 0.0, transmission: 1.0, thin: false, roughness: 0.5, ..Material::default() };
    for mu in [0.9, -0.9, -0.3] {
        let wo = tilted(mu);
        let sharp = Bsdf::new(&rough, wo).sharp(Lobes::ALL);
        let smooth = Bsdf::new(&Material { roughness: 0.0, ..rough }, wo);
        assert!(sharp.is_delta() && sharp.lobes() == smooth.lobes());
        for lobes in [Lobes::REFLECTION, Lobes::TRANSMISSION] {
            let [a, b] = [sharp, smooth].map(|bsdf| bsdf.sample_f(0.5, Vec2::splat(0.5), lobes));
            assert_eq!(a.map(|s| (s.wi, s.weight)), b.map(|s| (s.wi, s.weight)));
        }
        let half = Bsdf::new(&rough, wo).sharp(Lobes::REFLECTION);
        assert_eq!(
            half.lobes(),
            Lobes::of(dapple_materials::Lobe::DeltaReflection)
                .with(dapple_materials::Lobe::GlossyTransmission)
        );
    }
    let blurred = Material { mirror: Some(Mirror { kr: Vec3::ONE, blur: 0.5 }), ..Material::default() };
    assert!(Bsdf::new(&blurred, tilted(0.5)).sharp(Lobes::ALL).is_delta());
}
