//! Stress cases B11 to B14, B17: environment maps, sampling tables, and the sun.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{irradiance, irradiance_meter, matte, moments, quad, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::Settings;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::Image;
use dapple_integrator::lights::{Environment, Light};
use dapple_integrator::sampling::{Discrete, Moments};
use dapple_integrator::scene::{SceneBuilder, SceneError, TexturedMaterial};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "B11",
        title: "environment with a one-texel sun, 1e3 to 1e12 times brighter",
        naive: "sampling that ignores the sun finds it once in a million: fireflies or no sun",
        source: "Pharr, Jakob & Humphreys 2023, §12.5; docs/science.md, \"Skies\"",
        check: Check::Run(sun),
    },
    Case {
        id: "B12",
        title: "poles of the environment, any orientation",
        naive: "1/sinθ at the poles; texels weighted as if their solid angles were equal",
        source: "docs/science.md, \"Skies\"",
        check: Check::Run(poles),
    },
    Case {
        id: "B13",
        title: "tables of more than 2²⁴ bins",
        naive: "f32 sums stall at 16 777 216, and ⌊ξn⌋ of an f32 ξ never reaches an odd bin",
        source: "docs/science.md, \"Tables\"",
        check: Check::Run(tables),
    },
    Case {
        id: "B14",
        title: "constant environment with an empty sampling table",
        naive: "MIS compensation subtracts the mean, and the remaining table is 0/0",
        source: "Karlík 2019; docs/science.md, \"Skies\"",
        check: Check::Run(constant),
    },
    Case {
        id: "B17",
        title: "sunlight through a hole",
        naive: "clamping of fireflies removes the sunlit patch",
        source: "docs/science.md, \"Skies\"",
        check: Check::Run(hole),
    },
];

/// Irradiance of a floor that faces +y under an environment alone.
fn under(environment: Environment, settings: &Settings) -> Result<Moments, SceneError> {
    let mut builder = irradiance_meter();
    builder.environment(environment);
    Ok(moments(&run(&builder.build()?, settings)))
}

fn picture(width: usize, height: usize, value: impl Fn(usize, usize) -> f32) -> Image {
    let pixels = (0..width * height).map(|i| Vec3::splat(value(i % width, i / width))).collect();
    Image { width, height, pixels }
}

fn sun(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let (w, h) = (64, 32);
    for (row, m) in [(5, 1e3f32), (5, 1e6), (11, 1e9), (11, 1e12), (0, 1e6)] {
        let sky = Environment::picture(
            picture(w, h, |x, y| if (x, y) == (40, row) { m } else { 1.0 }),
            0.7,
            1.0,
            false,
        );
        let Ok(sky) = sky else {
            tally.holds("the environment is made", false);
            continue;
        };
        let settings = Settings { max_bounces: 1, ..square(effort.of(8, 16, 64), 64) };
        let estimate = under(sky, &settings).unwrap_or_default();
        let theta = |r: usize| PI * r as f64 / h as f64;
        let sines = theta(row + 1).sin().powi(2) - theta(row).sin().powi(2);
        let exact = 1.0 + (f64::from(m) - 1.0) / w as f64 * sines;
        tally.mean(format!("sun of {m} in row {row}, over π"), &estimate, exact, 0.02);
        let spread = estimate.variance().sqrt() / exact;
        tally.at_most(format!("relative deviation at 64 samples, sun of {m} in row {row}"), spread, 0.02);
    }
    tally.finish()
}

fn poles(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let polar = |y: usize| if y == 0 { 5.0 } else { 1.0 };
    for turn in [0.0f32, 1.0, 4.0] {
        let Ok(sky) = Environment::picture(picture(128, 64, |_, y| polar(y)), turn, 1.0, false) else {
            continue;
        };
        let settings = Settings { max_bounces: 1, ..square(effort.of(8, 16, 64), 256) };
        let m = under(sky.clone(), &settings).unwrap_or_default();
        let cap = (PI / 64.0).sin().powi(2);
        tally.mean(format!("a bright row at the pole, rotated by {turn}"), &m, 1.0 + 4.0 * cap, 0.01);
        for pole in [Vec3::Y, Vec3::NEG_Y] {
            tally.holds(
                "radiance and density at the pole",
                sky.radiance(pole).is_finite() && sky.pdf(pole).is_finite(),
            );
        }
        let aimed = Light::Environment(sky.without_compensation());
        for n in [Vec3::Y, Vec3::X, Vec3::new(0.36, -0.48, 0.8)] {
            // ∫ L cos over the hemisphere, with the bright part by quadrature over the cap.
            let m = irradiance(&aimed, Vec3::ZERO, n, 1024, effort.of(16, 64, 512));
            tally.mean(
                format!("light sampling alone, facing {n}"),
                &m,
                PI + 4.0 * cap_irradiance(n.as_dvec3()),
                0.01,
            );
        }
    }
    tally.finish()
}

/// ∫ max(0, n·ω) dω over the cap of θ < π/64 about +y.
fn cap_irradiance(n: DVec3) -> f64 {
    let (rings, sectors) = (200, 400);
    let edge = PI / 64.0;
    let mut sum = 0.0;
    for i in 0..rings {
        let theta = edge * (f64::from(i) + 0.5) / f64::from(rings);
        let (sin, cos) = theta.sin_cos();
        for j in 0..sectors {
            let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(sectors);
            sum += n.dot(DVec3::new(sin * phi.cos(), cos, sin * phi.sin())).max(0.0) * sin;
        }
    }
    sum * edge / f64::from(rings) * 2.0 * PI / f64::from(sectors)
}

fn tables(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let bits = effort.of(21, 25, 26u32);
    let n = 1usize << bits;
    let mut weights = vec![1.0; n];
    let sun = n / 3;
    weights[sun] = 1e7;
    let Some(table) = Discrete::new(&weights) else { return tally.finish() };
    drop(weights);
    let exact = 1e7 / (1e7 + (n - 1) as f64);
    tally.within("probability of the heavy bin", f64::from(table.pmf(sun)), exact, 1e-7);
    let tries = effort.of(1 << 14, 1u32 << 20, 1 << 26);
    let mut cells = vec![0u32; 1000];
    let (mut noise, mut heavy) = (Noise(23), 0u32);
    for _ in 0..tries {
        let i = table.sample_bits((noise.bits() >> 32) as u32).index;
        if i == sun {
            heavy += 1;
        } else {
            cells[i * 1000 / n] += 1;
        }
    }
    let deviation = (exact * (1.0 - exact) * f64::from(tries)).sqrt();
    tally.within("selections of the heavy bin", f64::from(heavy), exact * f64::from(tries), 4.0 * deviation);
    let even = f64::from(tries - heavy) / 1000.0;
    let chi: f64 = cells.iter().map(|&c| (f64::from(c) - even).powi(2) / even).sum();
    tally.within(
        "the others in 1000 groups, (χ² − k)/√2k",
        (chi - 999.0) / (2.0f64 * 999.0).sqrt(),
        0.0,
        4.5,
    );
    drop(table);
    let Some(table) = Discrete::new(&vec![1.0; n]) else { return tally.finish() };
    let shift = 32 - bits;
    let step = effort.of(7, 101, 1);
    let unreached = (0..n).step_by(step).filter(|&i| table.sample_bits((i as u32) << shift).index != i);
    tally.none(
        format!("bins of 2^{bits} that cannot be reached (every {step}th tried)"),
        unreached.count() as u64,
    );
    tally.finish()
}

fn constant(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let same = Environment::picture(picture(64, 32, |_, _| 1.0), 0.3, 1.0, false);
    // Two values that differ by an ulp: a table remains, with nearly zero weights.
    let nearly = Environment::picture(
        picture(64, 32, |x, _| if x == 0 { 1.0 + f32::EPSILON } else { 1.0 }),
        0.0,
        1.0,
        false,
    );
    let skies = [
        ("constant", Ok(Environment::constant(Vec3::ONE))),
        ("image of one colour", same),
        ("nearly of one colour", nearly),
    ];
    for (name, sky) in skies {
        let settings = Settings { max_bounces: 1, ..square(8, effort.of(16, 64, 1024)) };
        let m = sky.ok().and_then(|sky| under(sky, &settings).ok()).unwrap_or_default();
        tally.mean(name, &m, 1.0, 0.01);
    }
    tally.finish()
}

/// A sun of half angle 0.265° and radiance 1e9 as a distant disk, and a screen with a hole above the floor.
fn sun_scene(hole: f64, eye: DVec3) -> SceneBuilder {
    let mut builder = seen(eye + DVec3::new(0.02, 0.05, 0.03), eye, 1e-3);
    let white = builder.material(TexturedMaterial::lambert("white", Vec3::ONE));
    let black = builder.material(matte(0.0, 0.0));
    let bright = builder.material(TexturedMaterial { double_sided: false, ..matte(0.0, 1e9) });
    builder.mesh(
        "floor",
        quad(Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::Z * -4.0),
        DAffine3::IDENTITY,
        white,
    );
    let towards = DVec3::new(0.6, 0.8, 0.0);
    builder.disk("sun", towards * 1000.0, -towards, 1000.0 * 0.265f64.to_radians().tan(), bright);
    builder.mesh("screen", screen(hole), DAffine3::from_translation(DVec3::new(0.75, 1.0, 0.0)), black);
    builder
}

/// A square of side 20 in the plane y = 0 with a square hole.
fn screen(hole: f64) -> Mesh {
    let (a, b) = (10.0, (0.5 * hole) as f32);
    let ring =
        |r: f32| [Vec3::new(-r, 0.0, -r), Vec3::new(r, 0.0, -r), Vec3::new(r, 0.0, r), Vec3::new(-r, 0.0, r)];
    let positions = [ring(a), ring(b)].concat();
    let triangles = (0..4).flat_map(|i| {
        let j = (i + 1) % 4;
        [[i, j, 4 + j], [i, 4 + j, 4 + i]]
    });
    Mesh { positions, triangles: triangles.collect(), ..Mesh::default() }
}

fn hole(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let settings = Settings { max_bounces: 1, ..square(effort.of(8, 16, 64), 64) };
    // The screen is 1.25 away along the direction of the sun: the fully lit patch is smaller than the hole by 0.0116.
    for (x, whole) in [(0.0, true), (0.02, true), (0.2, false), (-0.2, false)] {
        let m = sun_scene(0.1, DVec3::X * x).build().map(|scene| moments(&run(&scene, &settings)));
        let exact = if whole { 1e9 * 0.265f64.to_radians().sin().powi(2) * 0.8 } else { 0.0 };
        let m = m.unwrap_or_default();
        if whole {
            // The distances of floor points differ by 1e-5 of the distance of the sun.
            let close = 4.0 * m.standard_error() + 1e-4 * exact;
            tally.within(format!("at {x}: πL·sin²θ·cos, over π"), m.mean, exact, close);
        } else {
            tally.exactly(format!("at {x}: shadow"), m.mean, 0.0);
        }
    }
    tally.finish()
}
