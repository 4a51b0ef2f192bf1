//! Light selection: the probabilities add up, match the samples, are independent of units, and favour lights that
//! contribute.
mod support;
use dapple_lights::{Area, AreaShape, Distant, Environment, Light, LightSampler, Point, Spot};
use dapple_math::Image;
use dapple_sampling::{Key, Pattern, point_1d};
use dapple_testkit::{Rng, chi_square::ChiSquare};
use glam::Vec3;
use std::f64::consts::PI;
use support::{mean, square};

fn random_point(rng: &mut Rng, size: f32) -> Vec3 {
    (Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5) * size
}

/// `near` lights of all kinds in a box of size 10·scale; with `far` also an environment map, a distant light, and a
/// constant environment that is never selected. Scaling by a power of two scales every number exactly, intensities by
/// its square.
fn lights(near: usize, far: bool, scale: f32) -> Vec<Light> {
    let mut rng = Rng::new(77);
    let mut lights = Vec::new();
    if far {
        let mut sky = Image { width: 8, height: 4, pixels: vec![Vec3::splat(0.1); 32] };
        sky.pixels[5] = Vec3::new(10.0, 8.0, 6.0);
        let env = Environment::picture(sky, 0.0, 1.0, false).unwrap();
        let towards = Vec3::new(0.6, 0.8, 0.0);
        lights.push(Light::Environment(Environment::constant(Vec3::ONE)));
        lights.push(Light::Environment(env));
        lights.push(Light::Distant(Distant { towards, irradiance: Vec3::splat(0.5) }));
    }
    for i in 0..near {
        let p = random_point(&mut rng, 10.0) * scale;
        let e = [random_point(&mut rng, 1.0) * scale, random_point(&mut rng, 1.0) * scale];
        let axis = random_point(&mut rng, 1.0).normalize();
        let intensity = Vec3::splat(rng.f32()) * scale * scale;
        let radiance = Vec3::splat(libm::exp2f((rng.f32() * 8.0).floor()));
        let two_sided = i % 2 == 0;
        let area = |shape| Light::Area(Area { shape, radiance, two_sided });
        lights.push(match i % 6 {
            0 => Light::Point(Point { p, intensity, range: f32::INFINITY }),
            1 => Light::Spot(Spot { p, axis, intensity, inner: 0.1, outer: 0.3, range: f32::INFINITY }),
            2 => area(AreaShape::Quad { corner: p, e1: e[0], e2: e[1] }),
            3 => area(AreaShape::Sphere { centre: p, radius: 0.25 * scale }),
            4 => area(AreaShape::Disk { centre: p, normal: axis, radius: 0.25 * scale }),
            _ => area(AreaShape::Triangle([p, p + e[0], p + e[1]])),
        });
    }
    lights
}

fn sets(scale: f32) -> Vec<Vec<Light>> {
    [(1, false), (4, false), (5, true), (8, false), (40, false), (40, true), (700, true)]
        .map(|(near, far)| lights(near, far, scale))
        .to_vec()
}

/// Receivers among, near and far from the lights, with and without a normal.
fn receivers(count: usize) -> Vec<(Vec3, Vec3)> {
    let mut rng = Rng::new(3);
    (0..count)
        .map(|i| {
            let p = random_point(&mut rng, [2.0, 12.0, 500.0][i % 3]);
            (p, if i % 4 == 0 { Vec3::ZERO } else { rng.direction().as_vec3() })
        })
        .collect()
}

#[test]
fn probabilities_add_up_and_none_is_zero() {
    for lights in sets(1.0) {
        let choice = LightSampler::new(&lights, 10.0).unwrap();
        for (p, n) in receivers(60) {
            let pmf: Vec<f64> = (0..lights.len()).map(|i| choice.pmf(p, n, i) as f64).collect();
            assert!((pmf.iter().sum::<f64>() - 1.0).abs() < 1e-5, "{}", pmf.iter().sum::<f64>());
            for (light, pmf) in lights.iter().zip(pmf) {
                let never = matches!(light, Light::Environment(e) if e.is_constant());
                assert_eq!(pmf == 0.0, never);
            }
        }
        assert_eq!(choice.pmf(Vec3::ZERO, Vec3::Z, lights.len()), 0.0);
    }
}

#[test]
fn the_choice_carries_its_probability() {
    for lights in sets(1.0) {
        let choice = LightSampler::new(&lights, 10.0).unwrap();
        let mut rng = Rng::new(9);
        for (p, n) in receivers(60) {
            for _ in 0..50 {
                let c = choice.sample(p, n, rng.f32()).unwrap();
                assert_eq!(c.pmf.to_bits(), choice.pmf(p, n, c.index).to_bits());
                assert!(c.pmf > 0.0 && (0.0..1.0).contains(&c.u));
            }
            for uc in [0.0, 1.0 - f32::EPSILON / 2.0, 1.0] {
                assert!(choice.sample(p, n, uc).is_some_and(|c| c.pmf > 0.0));
            }
        }
    }
}

#[test]
fn frequencies_follow_the_probabilities() {
    let (sets, receivers) = (sets(1.0), receivers(4));
    let test = ChiSquare::family(sets.len() * receivers.len());
    for lights in sets {
        let choice = LightSampler::new(&lights, 10.0).unwrap();
        for &(p, n) in &receivers {
            let pmf: Vec<f64> = (0..lights.len()).map(|i| choice.pmf(p, n, i) as f64).collect();
            let result = test.indices(&pmf, |u| choice.sample(p, n, u).unwrap().index);
            assert!(result.passed(), "{} lights: {result}", lights.len());
        }
    }
}

/// The rescaled u is uniform given the light: its mean is ½.
#[test]
fn what_is_left_of_u_is_uniform() {
    for lights in sets(1.0) {
        let choice = LightSampler::new(&lights, 10.0).unwrap();
        let mut rng = Rng::new(21);
        let (m, se) = mean(100_000, 1, |_| choice.sample(Vec3::ONE, Vec3::Y, rng.f32()).unwrap().u as f64);
        assert!((m - 0.5).abs() < 4.5 * se, "{m} ± {se}");
    }
}

#[test]
fn units_do_not_matter() {
    for k in [-20, -3, 7, 20] {
        let scale = libm::exp2f(k as f32);
        for (a, b) in sets(1.0).iter().zip(&sets(scale)) {
            let one = LightSampler::new(a, 10.0).unwrap();
            let other = LightSampler::new(b, 10.0 * scale).unwrap();
            for (p, n) in receivers(12) {
                for i in 0..a.len() {
                    assert_eq!(one.pmf(p, n, i).to_bits(), other.pmf(p * scale, n, i).to_bits(), "2^{k}");
                }
            }
        }
    }
}

/// E at `p` for normal n by selecting and sampling lights, `count` samples; u of the selection from an Owen-scrambled
/// sequence.
fn irradiance(lights: &[Light], p: Vec3, n: Vec3, count: u32, seen: impl Fn(usize) -> bool) -> (f64, f64) {
    let choice = LightSampler::new(lights, 100.0).unwrap();
    let key = Key::pixel(5, 0, 0);
    let mut s = 0;
    mean(count, 6, |u| {
        let c = choice.sample(p, n, point_1d(Pattern::Sobol, s, count, key)).unwrap();
        s += 1;
        let sample = lights[c.index].sample(p, u, 0.0).filter(|_| seen(c.index));
        sample.map_or(0.0, |s| (s.radiance.x * s.wi.dot(n).max(0.0)) as f64 / (s.pdf * c.pmf) as f64)
    })
}

/// A dim visible light beside an occluded equal one that is 1e12 times brighter: 5 % error at 4096 samples.
#[test]
fn a_dim_light_beside_a_hidden_bright_one() {
    let make = |x: f32, radiance: f32| {
        Light::Area(Area { shape: square(0.5, x, 1.0), radiance: Vec3::splat(radiance), two_sided: false })
    };
    for others in [0, 20] {
        let mut lights = vec![make(0.0, 1e-6), make(2.0, 1e6)];
        lights.extend((0..others).map(|i| make(10.0 + i as f32, 1e-6)));
        let exact = PI * 1e-6 * support::rectangle([-0.5, 0.5], [-0.5, 0.5], 1.0);
        let (e, _) = irradiance(&lights, Vec3::ZERO, Vec3::Z, 4096, |i| i == 0);
        assert!((e / exact - 1.0).abs() < 0.05, "{others}: {e} {exact}");
    }
}

/// Many point lights on a square grid within a disk, and the sum of their contributions.
fn many_points(rings: i32) -> (Vec<Light>, f64) {
    let (mut lights, mut sum) = (Vec::new(), 0.0);
    let h = rings as f64 * 0.5;
    for y in -rings..=rings {
        for x in -rings..=rings {
            if x * x + y * y <= rings * rings {
                let p = Vec3::new(x as f32, y as f32, h as f32);
                lights.push(Light::Point(Point { p, intensity: Vec3::ONE, range: f32::INFINITY }));
                let d2 = (x * x + y * y) as f64 + h * h;
                sum += h / (d2 * d2.sqrt());
            }
        }
    }
    (lights, sum)
}

#[test]
fn thirty_thousand_lights() {
    let (lights, exact) = many_points(100);
    assert!(lights.len() > 31_000);
    let (h, r) = (50.0f64, 100.0f64);
    let formula = 2.0 * PI * (1.0 - h / (h * h + r * r).sqrt());
    assert!((exact / formula - 1.0).abs() < 1e-3);
    let (e, se) = irradiance(&lights, Vec3::ZERO, Vec3::Z, 100_000, |_| true);
    assert!((e - exact).abs() < 4.0 * se && se < 0.005 * exact, "{e} ± {se}, {exact}");
    // Uniform selection has a relative standard deviation of 0.9 here; that of the tree is far smaller.
    assert!(se * (100_000f64).sqrt() < 0.5 * exact, "{}", se / exact);
}

#[test]
fn one_quad_cut_into_many_is_the_same_light() {
    let exact = PI * support::rectangle([-0.5, 0.5], [-0.5, 0.5], 0.3);
    let mut deviations = Vec::new();
    for k in [1usize, 2, 10, 50] {
        let side = 1.0 / k as f32;
        let lights: Vec<Light> = (0..k * k)
            .map(|i| {
                let corner = Vec3::new((i % k) as f32 * side - 0.5, (i / k) as f32 * side - 0.5, 0.3);
                let shape = AreaShape::Quad { corner, e1: Vec3::Y * side, e2: Vec3::X * side };
                Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: false })
            })
            .collect();
        let (e, se) = irradiance(&lights, Vec3::ZERO, Vec3::Z, 40_000, |_| true);
        assert!((e - exact).abs() < 4.0 * se && se < 0.01 * exact, "{k}: {e} ± {se}, {exact}");
        deviations.push(se * 200.0 / exact);
    }
    let worst = deviations.iter().fold(0.0, |a: f64, b| a.max(*b));
    assert!(worst * worst <= 1.5 * deviations[0] * deviations[0], "by k: {deviations:.3?}");
}

#[test]
fn nothing_to_aim_at() {
    assert!(LightSampler::new(&[], 1.0).is_none());
    let sky = Light::Environment(Environment::constant(Vec3::ONE));
    let black = Light::Point(Point { p: Vec3::ZERO, intensity: Vec3::ZERO, range: f32::INFINITY });
    assert!(LightSampler::new(&[sky.clone(), black.clone()], 1.0).is_none());
    let lamp = Light::Point(Point { p: Vec3::ZERO, intensity: Vec3::X, range: f32::INFINITY });
    let choice = LightSampler::new(&[sky, black, lamp], 1.0).unwrap();
    for uc in [0.0, 0.1, 0.9] {
        let c = choice.sample(Vec3::ONE, Vec3::Y, uc).unwrap();
        assert_eq!((c.index, c.pmf), (2, 1.0));
    }
    assert_eq!([0, 1, 2, 3].map(|i| choice.pmf(Vec3::ONE, Vec3::Y, i)), [0.0, 0.0, 1.0, 0.0]);
}
