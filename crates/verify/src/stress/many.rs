//! Stress cases B07 to B10, B18: many lights, and high contrast between them.

use super::{Case, Check, Effort, Outcome};
use crate::closed_form::parallel_rectangle;
use crate::noise::Noise;
use crate::scenes::{irradiance_meter, matte, pixels, quad, run, square};
use crate::tally::Tally;
use dapple_integrator::Dimension;
use dapple_integrator::Settings;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::{Encoding, Interpolation, Rgba8, Sampler, Texture, Wrap};
use dapple_integrator::lights::{Area, AreaShape, Light, LightSampler, Point};
use dapple_integrator::sampling::{Key, Moments, Pattern, point_1d, point_2d};
use dapple_integrator::scene::{Scene, SceneError, TextureUse, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use std::f64::consts::{FRAC_1_PI, PI};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "B07",
        title: "a visible dim light beside an occluded one 1e12 times brighter",
        naive: "selection by power never picks the dim light: variance 1e12",
        source: "Conty Estevez & Kulla 2018; docs/science.md, \"Choosing lights\"",
        check: Check::Run(hidden),
    },
    Case {
        id: "B08",
        title: "a field of point lights, and a plane of small quads",
        naive: "one light in a million is picked uniformly: nothing but noise",
        source: "Conty Estevez & Kulla 2018; docs/science.md, \"Choosing lights\"",
        check: Check::Run(field),
    },
    Case {
        id: "B09",
        title: "a light cut into k² pieces",
        naive: "noise or brightness depend on the tessellation of the light",
        source: "docs/science.md, \"Choosing lights\"",
        check: Check::Run(pieces),
    },
    Case {
        id: "B10",
        title: "probabilities of light selection",
        naive: "probabilities that do not add up to 1, that differ in MIS, or that depend on the unit of length",
        source: "Conty Estevez & Kulla 2018; docs/science.md, \"Choosing lights\"",
        check: Check::Run(probabilities),
    },
    Case {
        id: "B18",
        title: "an emissive texture with one hot texel",
        naive: "uniform points on the light miss the texel: fireflies",
        source: "docs/science.md, \"Choosing lights\"",
        check: Check::Run(hot_texel),
    },
];

/// Irradiance at the origin with normal +z from many lights by light selection: moments over independent sets.
fn chosen(lights: &[Light], sampler: &LightSampler, points: u32, sets: u64) -> Moments {
    let set = |seed: u64| {
        let pixel = Key::pixel(seed, 0, 0);
        let value = |s: u32| {
            let uc = point_1d(Pattern::Sobol, s, points, pixel.at(0, Dimension::Light));
            let u = point_2d(Pattern::Sobol, s, points, pixel.at(0, Dimension::LightPoint));
            let c = sampler.sample(Vec3::ZERO, Vec3::Z, uc)?;
            let s = lights[c.index].sample(Vec3::ZERO, u, 0.0)?;
            Some(f64::from(s.radiance.x) * f64::from(s.wi.z.max(0.0)) / (f64::from(s.pdf) * f64::from(c.pmf)))
        };
        (0..points).filter_map(value).sum::<f64>() / f64::from(points)
    };
    (0..sets).map(set).collect()
}

/// A floor lit by point lights.
fn lit_by(lights: &[Light]) -> Result<Scene, SceneError> {
    let mut builder = irradiance_meter();
    for light in lights {
        if let Light::Point(light) = light {
            let p = light.p.as_dvec3();
            builder.point_light(DVec3::new(p.x, p.z, p.y), light.intensity, f64::INFINITY);
        }
    }
    builder.build()
}

fn two_lights(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let mut builder = irradiance_meter();
    let lamp = |at: f32, y: f32| quad(Vec3::new(at - 0.2, y, -0.2), Vec3::X * 0.4, Vec3::Z * 0.4);
    let dim = builder.material(TexturedMaterial { double_sided: false, ..matte(0.0, 1e-6) });
    let bright = builder.material(TexturedMaterial { double_sided: false, ..matte(0.0, 1e6) });
    let black = builder.material(matte(0.0, 0.0));
    builder.mesh("dim", lamp(-0.6, 0.7), DAffine3::IDENTITY, dim);
    builder.mesh("bright", lamp(0.9, 0.9), DAffine3::IDENTITY, bright);
    // A closed box around the bright light.
    builder.mesh("cover", crate::scenes::cube(0.4, Vec3::new(0.9, 0.9, 0.0)), DAffine3::IDENTITY, black);
    let settings = Settings { max_bounces: 1, ..square(effort.of(2, 8, 32), 4096) };
    let m = pixels(builder, &settings)?;
    let exact = 1e-6 * parallel_rectangle([-0.8, -0.2], [-0.4, 0.2], 0.7);
    tally.mean("the dim light alone", &m, exact, 0.05 / 4.0);
    Ok(())
}

fn hidden(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = two_lights(&mut tally, effort);
    tally.holds("the scene is built", built.is_ok());
    tally.finish()
}

fn field(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    // A regular grid of point lights on a disk of radius 1 at height 0.2.
    let side = effort.of(100, 400, 1128i32);
    let (h, intensity) = (0.2f32, 1.0);
    let mut lights = Vec::new();
    let mut sum = 0.0;
    for i in -side / 2..side / 2 {
        for j in -side / 2..side / 2 {
            let p = Vec3::new((i as f32 + 0.5) / (side / 2) as f32, (j as f32 + 0.5) / (side / 2) as f32, h);
            if p.truncate().length() <= 1.0 {
                let d2 = p.as_dvec3().length_squared();
                sum += f64::from(h) / (d2 * d2.sqrt());
                lights.push(Light::Point(Point {
                    p,
                    intensity: Vec3::splat(intensity),
                    range: f32::INFINITY,
                }));
            }
        }
    }
    let start = std::time::Instant::now();
    let Some(sampler) = LightSampler::new(&lights, 2.0) else { return tally.finish() };
    tally.remark(format!(
        "light sampler of {} lights built in {:.1} s",
        lights.len(),
        start.elapsed().as_secs_f64()
    ));
    let density = f64::from(side / 2).powi(2);
    let exact = 2.0 * PI * density * (1.0 - f64::from(h) / (f64::from(h).powi(2) + 1.0).sqrt());
    tally.within("sum over the lights over its integral", sum / exact, 1.0, 1e-3);
    let m = chosen(&lights, &sampler, 4096, effort.of(8, 64, 256));
    tally.mean(format!("{} point lights", lights.len()), &m, sum, 0.02);
    if effort != Effort::Quick
        && let [Ok(many), Ok(few)] = [lights.len(), 10].map(|n| lit_by(&lights[..n]))
    {
        let settings = Settings { max_bounces: 1, ..square(32, 64) };
        let slower = crate::clock::ratio(|| run(&many, &settings), || run(&few, &settings));
        tally.at_most("render time over that with 10 lights", slower, 3.0);
    }
    let tiles = tiled(effort.of(30, 200, 1000));
    if let Some(sampler) = LightSampler::new(&tiles, 2.0) {
        let m = chosen(&tiles, &sampler, 4096, effort.of(8, 64, 256));
        tally.mean(
            format!("{} quads that tile one", tiles.len()),
            &m,
            PI * parallel_rectangle([-0.5; 2], [0.5; 2], 0.5),
            0.02,
        );
    }
    tally.finish()
}

/// A unit square light at height ½ with radiance 1 downward, in k² pieces.
fn tiled(k: u32) -> Vec<Light> {
    let at = |i: u32| i as f32 / k as f32 - 0.5;
    let tile = |i: u32, j: u32| {
        let corner = Vec3::new(at(i), at(j), 0.5);
        let shape =
            AreaShape::Quad { corner, e1: Vec3::Y * (at(j + 1) - at(j)), e2: Vec3::X * (at(i + 1) - at(i)) };
        Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: false })
    };
    (0..k).flat_map(|i| (0..k).map(move |j| tile(i, j))).collect()
}

fn pieces(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let exact = PI * parallel_rectangle([-0.5; 2], [0.5; 2], 0.5);
    let mut first = None;
    for k in [1, 2, 7, 30, effort.of(30, 100, 1000)] {
        let lights = tiled(k);
        let Some(sampler) = LightSampler::new(&lights, 1.0) else { continue };
        let m = chosen(&lights, &sampler, 1024, effort.of(32, 256, 1024));
        tally.mean(format!("{k}² pieces"), &m, exact, 0.01);
        let single: Moments = {
            let set = chosen(&lights, &sampler, 1, effort.of(2_000, 40_000, 400_000));
            tally.mean(format!("{k}² pieces, single points"), &set, exact, 0.05);
            set
        };
        let base = *first.get_or_insert(single.variance());
        tally.at_most(
            format!("variance of single points, {k}² pieces over one"),
            single.variance() / base,
            1.5,
        );
    }
    tally.finish()
}

/// Lights of many kinds, sizes and powers about the origin, with lengths multiplied by `unit`.
fn assortment(unit: f32, n: usize) -> Vec<Light> {
    let mut noise = Noise(77);
    let mut light = |i: usize| {
        let p = noise.cube() * unit;
        let power = Vec3::splat(10f32.powf(noise.unit() * 6.0 - 3.0));
        let (a, b) = (noise.direction(), noise.direction());
        let size = 10f32.powf(noise.unit() * -3.0) * unit;
        match i % 4 {
            // For equal irradiances, an intensity is proportional to the square of lengths.
            0 => Light::Point(Point { p, intensity: power * (unit * unit), range: f32::INFINITY }),
            1 => area(AreaShape::Sphere { centre: p, radius: size }, power),
            2 => area(AreaShape::Triangle([p, p + a * size, p + b * size]), power),
            _ => area(AreaShape::Quad { corner: p, e1: a * size, e2: b * size }, power),
        }
    };
    (0..n).map(&mut light).collect()
}

fn area(shape: AreaShape, radiance: Vec3) -> Light {
    Light::Area(Area { shape, radiance, two_sided: false })
}

fn probabilities(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for n in [3, 40, 700] {
        let lights = assortment(1.0, n);
        let Some(sampler) = LightSampler::new(&lights, 1.0) else { continue };
        let scaled = LightSampler::new(&assortment(1024.0, n), 1024.0);
        let (mut noise, mut differ, mut none, mut apart) = (Noise(5), 0u64, 0u64, 0u64);
        for _ in 0..effort.of(20, 200, 5_000) {
            let (p, normal) = (noise.cube(), noise.direction());
            let pmf: Vec<f32> = (0..n).map(|i| sampler.pmf(p, normal, i)).collect();
            let sum: f64 = pmf.iter().map(|p| f64::from(*p)).sum();
            tally.within(format!("sum of {n} probabilities"), sum, 1.0, 1e-5);
            if let Some(scaled) = &scaled {
                let same = |i: usize| scaled.pmf(p * 1024.0, normal, i).to_bits() == pmf[i].to_bits();
                differ += (0..n).filter(|&i| !same(i)).count() as u64;
            }
            none += pmf.iter().filter(|p| **p <= 0.0).count() as u64;
            for _ in 0..50 {
                if let Some(c) = sampler.sample(p, normal, noise.unit()) {
                    apart += u64::from((c.pmf / pmf[c.index] - 1.0).abs() > 4.0 * f32::EPSILON);
                }
            }
        }
        tally.none(format!("probabilities of {n} lights that change with the unit of length"), differ);
        tally.none(format!("lights of {n} that are never chosen"), none);
        tally.none(format!("selections of {n} lights whose probability differs from pmf()"), apart);
        frequencies(&mut tally, &sampler, n, effort);
    }
    tally.finish()
}

/// Compares the selection frequencies of the lights with their probabilities, as z = (χ² − k)/√2k.
fn frequencies(tally: &mut Tally, sampler: &LightSampler, n: usize, effort: Effort) {
    let (p, normal) = (Vec3::new(0.1, -0.2, 0.3), Vec3::Z);
    let tries = effort.of(20_000u32, 1_000_000, 100_000_000);
    let (mut noise, mut counts) = (Noise(19), vec![0u32; n]);
    for _ in 0..tries {
        if let Some(c) = sampler.sample(p, normal, noise.unit()) {
            counts[c.index] += 1;
        }
    }
    let (mut chi, mut cells, mut rest) = (0.0, 0, [0.0; 2]);
    for (i, &count) in counts.iter().enumerate() {
        let expected = f64::from(sampler.pmf(p, normal, i)) * f64::from(tries);
        if expected < 20.0 {
            rest = [rest[0] + f64::from(count), rest[1] + expected];
            continue;
        }
        chi += (f64::from(count) - expected).powi(2) / expected;
        cells += 1;
    }
    if rest[1] >= 20.0 {
        chi += (rest[0] - rest[1]).powi(2) / rest[1];
        cells += 1;
    }
    let k = f64::from(cells - 1).max(1.0);
    tally.within(format!("frequencies of {n} lights, (χ² − k)/√2k"), (chi - k) / (2.0 * k).sqrt(), 0.0, 4.5);
}

fn texel(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    // 32 × 32 texels on an emitter of 32 × 32 × 2 triangles, one of them at full strength.
    let n = 32usize;
    let mut texels = vec![[0u8, 0, 0, 255]; n * n];
    let (column, row) = (20, 9);
    texels[row * n + column] = [255; 4];
    let image = Rgba8 { width: n, height: n, texels };
    let sampler = Sampler { wrap_s: Wrap::Clamp, wrap_t: Wrap::Clamp, interpolation: Interpolation::Nearest };
    let mut builder = irradiance_meter();
    let texture = builder.texture(Texture::new(image, Encoding::Linear, sampler));
    let mut hot = matte(0.0, 1e6);
    hot.emissive_texture = Some(TextureUse::new(texture));
    let hot = builder.material(hot);
    let mut mesh = Mesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
            // Outside the line of sight of the camera.
            mesh.positions.push(Vec3::new(u * 0.4 - 0.6, 0.9, v * 0.4 - 0.2));
            mesh.uv[0].push(Vec2::new(u, v));
        }
    }
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    builder.mesh("lamp", mesh, DAffine3::IDENTITY, hot);
    let settings = Settings { max_bounces: 1, ..square(effort.of(4, 8, 32), 256) };
    let m = pixels(builder, &settings)?;
    let low = |k: usize, from: f64| from + 0.4 * k as f64 / n as f64;
    let (x, z) = (low(column, -0.6), low(row, -0.2));
    let side = 0.4 / n as f64;
    let exact = 1e6 * parallel_rectangle([x, z], [x + side, z + side], 0.9);
    tally.mean("irradiance of one texel, over π", &m, exact, 0.02);
    tally.remark(format!("E = {:.3e}", m.mean / FRAC_1_PI));
    Ok(())
}

fn hot_texel(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = texel(&mut tally, effort);
    tally.holds("the scene is built", built.is_ok());
    tally.finish()
}
