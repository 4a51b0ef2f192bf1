//! White furnace tests of single lobes: the directional albedo of f, of the samples and of the table, against f64
//! quadrature.

mod oracle;

use dapple_materials::albedo::AlbedoRow;
use dapple_materials::{Bsdf, Lobe, Lobes, Material};
use dapple_sampling::{Key, Pattern, pattern};
use glam::{DVec3, Vec2, Vec3};
use oracle::{albedo, over_normals, over_normals_roughly, tilted};

const ALPHAS: [f64; 7] = [1e-3, 0.01, 0.1, 0.25, 0.5, 0.75, 1.0];
const MUS: [f64; 9] = [1.0, 0.75, 0.5, 0.25, 0.1, 0.03, 0.01, 1e-3, 1e-4];

/// A perfect metal, F = 1.
fn silver(alpha: f64) -> Material {
    Material { base_color: Vec3::ONE, metallic: 1.0, roughness: (alpha as f32).sqrt(), ..Material::default() }
}

/// α as the crate computes it: roughness is squared in f32.
fn seen(alpha: f64) -> f64 {
    let r = (alpha as f32).sqrt();
    f64::from((r * r).max(1e-3))
}

/// Mean weight of one lobe over a scrambled net of 2^14 points.
fn mean_weight(bsdf: &Bsdf, lobes: Lobes) -> f64 {
    let n = 1 << 14;
    let key = Key::pixel(7, 0, 0);
    let sum: f64 = (0..n)
        .filter_map(|s| bsdf.sample_f(0.5, pattern::point_2d(Pattern::Sobol, s, n, key), lobes))
        .map(|s| f64::from(s.weight.x * s.eta))
        .sum();
    sum / f64::from(n)
}

/// The table of docs/science.md, "GGX" (quadrature ± 5e-5), and 1 − ln 2 in closed form.
#[test]
fn the_oracle_has_the_published_values() {
    let rows = [
        (0.10, [0.98830, 0.98315, 0.96921, 0.92161, 0.88346, 0.97653]),
        (0.25, [0.91581, 0.89153, 0.85726, 0.84008, 0.89162, 0.98196]),
        (0.50, [0.68785, 0.68208, 0.69825, 0.76520, 0.86011, 0.97441]),
        (0.75, [0.46392, 0.50141, 0.56462, 0.68025, 0.81071, 0.96425]),
        (1.00, [1.0 - std::f64::consts::LN_2, 0.36453, 0.45069, 0.59764, 0.76021, 0.95385]),
    ];
    for (alpha, row) in rows {
        for (mu, value) in [1.0, 0.75, 0.5, 0.25, 0.1, 0.01].into_iter().zip(row) {
            let e = albedo(tilted(mu), alpha, 1e-6, |_| 1.0);
            assert!((e - value).abs() < 6e-5, "alpha {alpha}, mu {mu}: {e} against {value}");
        }
    }
}

/// Weak white furnace [Heitz 2014, eq. 86]: visible normals integrate to one.
#[test]
fn visible_normals_integrate_to_one() {
    for alpha in ALPHAS {
        let ggx = dapple_materials::microfacet::Ggx::isotropic(seen(alpha) as f32).expect("rough");
        for mu in MUS {
            let wo = tilted(mu);
            let one = over_normals(seen(alpha), 1e-5, |m| {
                let pdf = ggx.visible_pdf(wo.as_vec3(), m.as_vec3(), wo.dot(m) as f32);
                f64::from(pdf) / (oracle::d(m, seen(alpha)) * m.z)
            });
            assert!((one - 1.0).abs() < 1e-4, "alpha {alpha}, mu {mu}: {one}");
        }
    }
}

#[test]
fn value_and_samples_have_the_lobes_albedo() {
    for alpha in ALPHAS {
        for mu in MUS {
            let wo = tilted(mu);
            let bsdf = Bsdf::new(&silver(alpha), wo.as_vec3());
            let exact = albedo(wo, seen(alpha), 1e-6, |_| 1.0);
            let (value, error) = over_normals_roughly(seen(alpha), |m| {
                let c = wo.dot(m);
                let wi = 2.0 * c * m - wo;
                if c <= 0.0 || wi.z <= 0.0 {
                    return 0.0;
                }
                let f = f64::from(bsdf.f(wi.as_vec3(), Lobes::ALL).x);
                f * wi.z * 4.0 * c / (oracle::d(m, seen(alpha)) * m.z)
            });
            let mean = mean_weight(&bsdf, Lobes::ALL);
            // f is evaluated for directions rounded to f32: the half vector of grazing directions is off by this
            // fraction of the lobe.
            let blur = 6e-8 / (seen(alpha) * mu);
            let tolerance = 2e-4 + error + 2.0 * blur * blur;
            assert!(
                blur > 0.3 || (value / exact - 1.0).abs() < tolerance,
                "alpha {alpha}, mu {mu}: f gives {value}, exact {exact}"
            );
            assert!(
                (mean / exact - 1.0).abs() < 5e-4,
                "alpha {alpha}, mu {mu}: samples {mean}, exact {exact}"
            );
        }
    }
}

/// The table is an upper bound, also between its nodes, and at most 0.005 above the exact value.
#[test]
fn the_table_bounds_the_albedo_from_above() {
    let mut worst = 0.0f64;
    for i in 0..24 {
        let roughness = 0.0317 + (1.0 - 0.0317) * (f64::from(i) / 23.0).powi(2);
        for k in 0..40 {
            let mu = ((f64::from(k) + 0.5) / 40.0).powi(4);
            let alpha = f64::from((roughness as f32) * (roughness as f32));
            let split = AlbedoRow::new(alpha as f32).at(mu as f32);
            let c = albedo(tilted(mu), alpha, 1e-5, |_| 1.0);
            let b = albedo(tilted(mu), alpha, 1e-5, |c| (1.0 - c).powi(5));
            for (table, exact) in [(split.c, c), (split.b, b)] {
                let above = f64::from(table) - exact;
                assert!(above > -2e-6, "roughness {roughness}, mu {mu}: {table} is below {exact}");
                worst = worst.max(above);
            }
        }
    }
    println!("at most {worst:.5} above");
    assert!(worst < 5e-3, "{worst}");
}

/// Base and coat together reflect no more than the incident light, and little less.
#[test]
fn a_coated_white_base_keeps_its_energy() {
    let mut range = [1.0f64, 0.0];
    for roughness in [0.0, 0.0317, 0.04, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0] {
        for (ior, specular, color) in [(1.5, 1.0, 1.0), (1.33, 0.5, 1.0), (2.4, 1.0, 1.0), (1.5, 1.0, 9.0)] {
            for mu in [1.0, 0.7, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-5] {
                let material = Material {
                    metallic: 0.0,
                    roughness,
                    ior,
                    specular,
                    specular_color: Vec3::splat(color),
                    ..Material::default()
                };
                let wo = tilted(mu);
                let bsdf = Bsdf::new(&material, wo.as_vec3());
                // The integrand depends on the cosine alone.
                let diffuse = dapple_testkit::quadrature::line(
                    |x| {
                        let wi = tilted(x * x);
                        f64::from(bsdf.f(wi.as_vec3(), Lobes::of(Lobe::Diffuse)).x) * wi.z * 2.0 * x
                    },
                    0.0,
                    1.0,
                    1e-6,
                ) * std::f64::consts::TAU;
                let r0 = f64::from((ior - 1.0) / (ior + 1.0)).powi(2);
                let (f0, f90) = ((r0 * f64::from(color)).min(1.0) * f64::from(specular), f64::from(specular));
                let fresnel = |c: f64| oracle::schlick(f0, f90, c);
                let alpha = f64::from(roughness * roughness);
                let coat = if alpha < 1e-3 { fresnel(mu) } else { albedo(wo, alpha, 1e-6, fresnel) };
                let total = diffuse + coat;
                range = [range[0].min(total), range[1].max(total)];
                assert!(
                    (1.0 - 5e-3..=1.0 + 1e-5).contains(&total),
                    "roughness {roughness}, ior {ior}, specular {specular}·{color}, mu {mu}: {total}"
                );
            }
        }
    }
    println!("furnace of coated white: {range:?}");
}

/// Without a coat the base is exactly Lambertian, and no lobe is selected.
#[test]
fn no_specular_is_bitwise_lambert() {
    let base_color = Vec3::new(0.8, 0.3, 0.123);
    let material =
        Material { base_color, metallic: 0.0, specular: 0.0, roughness: 0.4, ..Material::default() };
    for mu in [1.0, 0.3, 1e-6, -0.7] {
        let bsdf = Bsdf::new(&material, tilted(mu).as_vec3());
        assert_eq!(bsdf.lobes(), Lobes::of(Lobe::Diffuse));
        for x in [1.0, 0.2, 1e-5] {
            let wi = tilted(x * mu.signum()).as_vec3();
            assert_eq!(bsdf.f(wi, Lobes::ALL), base_color * std::f32::consts::FRAC_1_PI);
            assert_eq!(bsdf.f(-wi, Lobes::ALL), Vec3::ZERO);
        }
        let sample = bsdf.sample_f(0.99, Vec2::new(0.2, 0.9), Lobes::ALL).expect("a sampled direction");
        assert_eq!(sample.weight, base_color);
        assert_eq!(bsdf.albedo(), base_color);
    }
}

/// The albedo estimate for lobe selection is as accurate as the table.
#[test]
fn albedo_of_a_metal() {
    let gold = Material { base_color: Vec3::new(1.0, 0.77, 0.34), roughness: 0.6, ..Material::default() };
    let wo = DVec3::new(0.8, 0.0, 0.6);
    let estimate = Bsdf::new(&gold, wo.as_vec3()).albedo();
    for (channel, f0) in [1.0f32, 0.77, 0.34].into_iter().enumerate() {
        let alpha = f64::from(0.6f32 * 0.6);
        let exact = albedo(wo, alpha, 1e-5, |c| oracle::schlick(f64::from(f0), 1.0, c));
        assert!((f64::from(estimate[channel]) - exact).abs() < 5e-3);
    }
}
