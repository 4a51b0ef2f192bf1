//! Irradiance under environments, by light sampling and cosine-weighted sampling combined, against closed forms.
mod support;
use dapple_lights::{Environment, Light};
use dapple_math::Image;
use dapple_sampling::{mis, warp};
use dapple_testkit::Rng;
use glam::{DVec3, Mat3, Vec3};
use std::f64::consts::PI;
use support::{agree, mean};

fn picture(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Image {
    let pixels = (0..width * height).map(|i| Vec3::splat(f(i % width, i / width))).collect();
    Image { width, height, pixels }
}

fn frame(n: Vec3) -> Mat3 {
    let (x, y) = n.any_orthonormal_pair();
    Mat3::from_cols(x, y, n)
}

/// One light sample and one cosine-weighted sample, combined by the power heuristic.
fn irradiance(env: &Environment, n: Vec3, count: u32) -> (f64, f64) {
    let (light, to_world) = (Light::Environment(env.clone()), frame(n));
    let mut rng = Rng::new(99);
    mean(count, 4, |u| {
        let mut e = 0.0;
        if let Some(s) = light.sample(Vec3::ZERO, u, 0.0) {
            let cos = s.wi.dot(n).max(0.0);
            let weight = mis::power(s.pdf, warp::hemisphere_cosine_pdf(cos));
            e += (s.radiance.x * cos * weight) as f64 / s.pdf as f64;
        }
        let local = warp::hemisphere_cosine(rng.vec2());
        let wi = to_world * local;
        let pdf = warp::hemisphere_cosine_pdf(local.z);
        let aimed = light.pdf(Vec3::ZERO, wi, f32::INFINITY, Vec3::ZERO, 0.0);
        e + (env.radiance(wi).x * std::f32::consts::PI * mis::power(pdf, aimed)) as f64
    })
}

/// ∫ of the cosine with +Y over the texels of row r, all columns: π(sin²θ_{r+1} − sin²θ_r) in the upper half.
fn row_irradiance(height: usize, r: usize) -> f64 {
    let sin2 = |r: usize| (r as f64 * PI / height as f64).sin().powi(2);
    PI * (sin2(r + 1) - sin2(r))
}

#[test]
fn a_sun_of_one_texel() {
    for (width, height, row) in [(64, 32, 3), (256, 128, 0), (1024, 512, 100)] {
        for m in [1e3f32, 1e6, 1e9, 1e12] {
            let sky = |x, y| if (x, y) == (width / 3, row) { m } else { 1.0 };
            let exact = PI + (m as f64 - 1.0) * row_irradiance(height, row) / width as f64;
            let env = Environment::picture(picture(width, height, sky), 0.4, 1.0, false).unwrap();
            for env in [env.clone(), env.without_compensation()] {
                // 64 samples are accurate to 2 %: the sun is sampled every time.
                let (_, se) = irradiance(&env, Vec3::Y, 64);
                assert!(se < 0.02 * exact || !env.is_compensated(), "{width}×{height}, {m}: {se} of {exact}");
                // Cosine-weighted directions hit the texel too rarely to contribute to the standard error; the
                // resulting deficit is at most the contribution of the texel at radiance 1.
                let rare = row_irradiance(height, row) / width as f64 / exact;
                let got = irradiance(&env, Vec3::Y, 20_000);
                agree(&format!("{width}×{height}, {m}"), got, exact, 2e-6 + rare);
            }
        }
    }
}

#[test]
fn a_white_row_at_the_pole_and_a_white_sky() {
    let (width, height) = (32, 16);
    let cap =
        Environment::picture(picture(width, height, |_, y| f32::from(y == 0)), 0.0, 1.0, false).unwrap();
    agree("cap", irradiance(&cap, Vec3::Y, 100_000), row_irradiance(height, 0), 1e-6);
    let sides =
        Environment::picture(picture(width, height, |_, y| f32::from(y != 0)), 0.0, 1.0, false).unwrap();
    agree("sides", irradiance(&sides, Vec3::Y, 100_000), PI - row_irradiance(height, 0), 1e-6);
    // White and almost constant: everything is left to cosine-weighted sampling, exactly π in every orientation.
    let mut rng = Rng::new(1);
    for i in 0..20 {
        let speck = |x, y| if (x, y) == (5, 9) { 1.0 - 1e-6 } else { 1.0 };
        let env = Environment::picture(picture(width, height, speck), i as f32, 1.0, i % 2 == 0).unwrap();
        let n = rng.direction().as_vec3();
        let (e, se) = irradiance(&env, n, 20_000);
        assert!((e - PI).abs() < 4.0 * se + 1e-5, "{e} ± {se}");
    }
}

#[test]
fn a_constant_picture_is_never_aimed_at() {
    let env = Environment::picture(picture(32, 16, |_, _| 2.0), 0.3, 0.5, false).unwrap();
    assert!(env.is_constant() && !env.is_sampled());
    let (e, se) = irradiance(&env, Vec3::Y, 1000);
    assert!((e - PI).abs() < 1e-6 && se < 1e-9, "{e} ± {se}");
    let black = Environment::picture(picture(32, 16, |_, _| 0.0), 0.0, 1.0, false).unwrap();
    assert_eq!(irradiance(&black, Vec3::Y, 10), (0.0, 0.0));
}

/// L = 1 + ω·y, sampled by texels: E = π + 2π/3 on a floor, up to the discretisation; likewise with filtering.
#[test]
fn a_gradient() {
    let (width, height) = (128, 64);
    let centre = |y: usize| ((y as f64 + 0.5) * PI / height as f64).cos();
    for filtered in [false, true] {
        let sky = picture(width, height, |_, y| (1.0 + centre(y)) as f32);
        let env = Environment::picture(sky, 1.0, 1.0, filtered).unwrap();
        let (e, se) = irradiance(&env, Vec3::Y, 200_000);
        let exact = PI + 2.0 * PI / 3.0;
        assert!((e - exact).abs() < 4.0 * se + 1e-3 * exact && se < 1e-3 * exact, "{e} ± {se}");
        assert!((env.mean().x - 1.0).abs() < 1e-5, "{}", env.mean());
    }
}

/// Light sampling alone, without compensation, is unbiased: the mean of L/pdf is 4π times the mean radiance, for every
/// rotation.
#[test]
fn mean_and_power_are_the_integral() {
    for filtered in [false, true] {
        let sky = picture(24, 12, |x, y| if y < 2 { 0.0 } else { ((x * 5 + y * 11) % 7) as f32 });
        let env = Environment::picture(sky, 2.0, 3.0, filtered).unwrap();
        let whole = env.clone().without_compensation();
        let got = mean(400_000, 8, |u| whole.sample(u).map_or(0.0, |s| (s.radiance.x / s.pdf) as f64));
        // With filtering, `Environment::mean` assumes uniform solid angle within texels.
        let rounding = if filtered { 5e-3 } else { 1e-6 };
        agree("mean", got, 4.0 * PI * env.mean().x as f64, rounding);
        let power = Light::Environment(env.clone()).power(3.0).x as f64;
        assert!((power / (4.0 * PI * PI * 9.0 * env.mean().x as f64) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn poles_and_seams_are_finite() {
    let env = Environment::picture(picture(8, 4, |x, y| (1 + x * y) as f32), 0.3, 1.0, true).unwrap();
    for env in [env.clone(), env.without_compensation()] {
        for d in [Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::new(-0.0, 1.0, -0.0)] {
            assert!(env.radiance(d).is_finite() && env.pdf(d).is_finite());
            // Continuous across the seam and near the poles.
            let near = (d.as_dvec3() + DVec3::splat(1e-6)).normalize().as_vec3();
            assert!(d.y.abs() > 0.5 || (env.radiance(d) - env.radiance(near)).length() < 1e-3);
        }
    }
}
