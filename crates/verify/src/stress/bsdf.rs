//! Stress cases C06 to C08, C11, C13, C17: clear dielectrics, extremes of the material parameters, and the ends of the
//! unit interval.

use super::gloss::{albedo, direction};
use super::{Case, Check, Effort, Outcome};
use crate::scenes::{ball, cube, glass, matte, of, pixels, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::Dimension;
use dapple_integrator::Settings;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::Image;
use dapple_integrator::lights::{Area, AreaShape, Environment, Light};
use dapple_integrator::materials::{Bsdf, Lobes, Material, fresnel};
use dapple_integrator::sampling::{Key, Pattern, padded_1d, padded_2d, warp};
use dapple_integrator::scene::{SceneBuilder, SceneError};
use glam::{DAffine3, DVec3, Vec2, Vec3};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "C06",
        title: "rough glass keeps its energy",
        naive: "reflection and refraction are weighted separately: their sum exceeds 1",
        source: "Walter 2007; docs/science.md, \"Clear bodies\"",
        check: Check::Run(rough_glass),
    },
    Case {
        id: "C07",
        title: "index of refraction towards 1",
        naive: "the half vector of refraction goes to 0: NaN or black",
        source: "Walter 2007; docs/science.md, \"Clear bodies\"",
        check: Check::Run(matched),
    },
    Case {
        id: "C08",
        title: "index of refraction towards infinity, and glTF's 0",
        naive: "η² overflows; 0 is interpreted as a vacuum",
        source: "docs/science.md, \"Fresnel\"",
        check: Check::Run(dense),
    },
    Case {
        id: "C11",
        title: "clear glass in a white sky is invisible",
        naive: "a depth limit or roulette without η² darkens the inside",
        source: "docs/science.md, \"Clear bodies\"",
        check: Check::Run(invisible),
    },
    Case {
        id: "C13",
        title: "corners of the material's parameters",
        naive: "layers reflect more light than they receive",
        source: "docs/science.md, \"Sums of lobes\"",
        check: Check::Run(corners),
    },
    Case {
        id: "C17",
        title: "random numbers are below 1",
        naive: "u32/2³² rounds to 1 for its top 128 values: an index out of range, a tangent direction",
        source: "docs/science.md, \"Points\"",
        check: Check::Run(ends),
    },
];

const INDICES: [f32; 6] = [1.0001, 1.01, 1.5, 2.4, 10.0, 1000.0];

fn rough_glass(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for ior in INDICES {
        for alpha in [1e-6f32, 2e-3, 0.01, 0.1, 0.5, 1.0] {
            for mu in [1.0, 0.4, 0.05, -1.0, -0.6, -0.05] {
                let m = albedo(&glass(ior, alpha.sqrt()), direction(mu, 0.3), 256, effort.of(8, 32, 512));
                let what = format!("R + T at η = {ior}, α = {alpha}, μ = {mu}");
                tally.at_most(&*what, m.mean - 4.0 * m.standard_error(), 1.0 + 1e-5);
                if alpha < 1e-3 {
                    tally.within(format!("smooth {what}"), m.mean, 1.0, 1e-5);
                } else if alpha < 0.011 && mu.abs() > 0.3 {
                    tally.within(format!("nearly smooth {what}"), m.mean, 1.0, 0.03);
                }
            }
        }
    }
    tally.finish()
}

/// An environment with a different colour in every direction.
fn colourful() -> Option<Environment> {
    let value = |i: usize| Vec3::new((i % 37) as f32, (i % 53) as f32, (i % 71) as f32) * 0.02;
    let picture = Image { width: 256, height: 128, pixels: (0..256 * 128).map(value).collect() };
    Environment::picture(picture, 0.0, 1.0, false).ok()
}

fn without_body(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let view = |base: Option<Material>| {
        let mut builder = seen(DVec3::new(0.0, 0.5, 4.0), DVec3::ZERO, 0.6);
        let material = builder.material(base.map_or(matte(0.5, 0.0), of));
        let place = if base.is_some() { DVec3::ZERO } else { DVec3::Y * 1e3 };
        builder.sphere("ball", place, 1.0, material);
        colourful().into_iter().for_each(|sky| builder.environment(sky));
        builder
    };
    let settings = Settings { max_bounces: 20, ..square(effort.of(16, 32, 128), effort.of(4, 16, 64)) };
    let clear = run(&view(Some(glass(1.0, 0.0))).build()?, &settings).film.mean();
    let nothing = run(&view(None).build()?, &settings).film.mean();
    let changed = clear.pixels.iter().zip(&nothing.pixels).filter(|(a, b)| a != b).count();
    tally.none("pixels that a ball of index 1 changes", changed as u64);
    Ok(())
}

fn matched(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = without_body(&mut tally, effort);
    tally.holds("both scenes are built", built.is_ok());
    for ior in [1.0, 1.0 + 1.2e-7, 1.0 + 1e-6, 1.0001, 1.001] {
        for roughness in [0.0, 0.1, 1.0] {
            let material = glass(ior, roughness);
            for mu in [1.0, 0.3, 1e-3, -0.3] {
                let m = albedo(&material, direction(mu, 0.2), 256, 2);
                tally.holds(
                    format!("finite at η = {ior}, roughness {roughness}, μ = {mu}"),
                    m.mean.is_finite(),
                );
                if ior < 1.00001 && mu.abs() > 0.2 {
                    tally.within(
                        format!("full transmission at η = {ior}, roughness {roughness}, μ = {mu}"),
                        m.mean,
                        1.0,
                        1e-4,
                    );
                }
            }
        }
    }
    tally.finish()
}

fn dense(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (eta, exact) in [(1e3, 0.996_008), (1e6, 0.999_996), (1e9, 1.0), (0.0, 1.0), (1.5, 0.04)] {
        tally.within(format!("F0 at η = {eta}"), f64::from(fresnel::normal_reflectance(eta)), exact, 1e-6);
    }
    for eta in [1e3f32, 1e6, 1e8] {
        for c in [1.0f32, 0.5, 1e-3, 0.0] {
            let f = f64::from(fresnel::dielectric(c, eta));
            // F ≥ F0 holds only beyond Brewster's angle; near a conductor F is in between.
            tally.holds(format!("0 ≤ F ≤ 1 at η = {eta}, cos {c}"), (0.0..=1.0).contains(&f));
            let exact = exact_fresnel(f64::from(c), f64::from(eta));
            tally.within(format!("F at η = {eta}, cos {c}"), f, exact, 1e-6);
        }
    }
    for roughness in [0.0, 0.5] {
        for metallic in [0.0, 1.0] {
            for transmission in [0.0, 1.0] {
                let base = Material { ior: 0.0, metallic, transmission, roughness, ..glass(1.5, 0.0) };
                let m = albedo(&base, direction(0.7, 0.1), 256, effort.of(8, 64, 512));
                let what = format!(
                    "glTF's index 0, metallic {metallic}, transmission {transmission}, roughness {roughness}"
                );
                tally.at_most(&*what, m.mean - 4.0 * m.standard_error(), 1.0 + 1e-4);
                if roughness == 0.0 {
                    tally.within(format!("{what}: reflects everything"), m.mean, 1.0, 1e-4);
                }
            }
        }
    }
    tally.finish()
}

/// Unpolarised Fresnel reflectance in f64.
pub(super) fn exact_fresnel(c: f64, eta: f64) -> f64 {
    let squared = (eta - 1.0) * (eta + 1.0) + c * c;
    if squared < 0.0 {
        return 1.0;
    }
    let ct = squared.sqrt() / eta;
    let (s, p) = ((c - eta * ct) / (c + eta * ct), (eta * c - ct) / (eta * c + ct));
    0.5 * (s * s + p * p)
}

/// Clear bodies in an environment of radiance 1.
fn clear_body(kind: u32, roughness: f32) -> SceneBuilder {
    let mut builder = seen(DVec3::new(0.3, 0.4, 4.0), DVec3::ZERO, 0.6);
    let [crown, flint] = [1.5, 2.4].map(|ior| builder.material(of(glass(ior, roughness))));
    match kind {
        0 => builder.sphere("ball", DVec3::ZERO, 1.0, crown),
        1 => builder.mesh("cube", cube(0.8, Vec3::ZERO), DAffine3::from_rotation_y(0.5), flint),
        _ => {
            builder.sphere("outer", DVec3::ZERO, 1.0, crown);
            // Without smooth normals, which lose energy where they differ from the facets.
            builder.mesh(
                "inner",
                Mesh { normals: Vec::new(), ..ball(3, 0.6, Vec3::ZERO) },
                DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
                flint,
            )
        }
    };
    builder.environment(Environment::constant(Vec3::ONE));
    builder
}

fn invisible(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (kind, name) in [(0, "ball"), (1, "cube of index 2.4"), (2, "ball in a ball")] {
        for roulette in [false, true] {
            // Light trapped in a corner of a cube never leaves it: 0.5^∞ of it is lost at any depth.
            let settings =
                Settings { max_bounces: 1000, ..square(effort.of(8, 16, 64), effort.of(16, 64, 1024)) }
                    .with_path(|p| p.roulette = roulette);
            let m = pixels(clear_body(kind, 0.0), &settings).unwrap_or_default();
            tally.mean(format!("{name}, roulette {roulette}"), &m, 1.0, 0.01);
        }
    }
    tally.finish()
}

fn corners(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let bits = |i: u32, k: u32| if i >> k & 1 == 1 { 1.0f32 } else { 0.0 };
    for i in 0..64 {
        let material = Material {
            base_color: Vec3::splat(bits(i, 0)),
            metallic: bits(i, 1),
            roughness: bits(i, 2),
            specular: bits(i, 3),
            specular_color: Vec3::splat(if i >> 3 & 1 == 1 { 1.0 } else { 0.5 }),
            transmission: bits(i, 4),
            thin: i >> 5 & 1 == 1,
            ..Material::default()
        };
        for mu in [1.0, 0.5, 0.05, -0.4] {
            let m = albedo(&material, direction(mu, 0.9), 128, effort.of(16, 64, 512));
            let what = format!("corner {i:06b}, μ = {mu}");
            tally.at_most(&*what, m.mean - 4.0 * m.standard_error(), 1.0 + 1e-3);
            tally.holds(format!("{what}: not negative"), m.mean >= 0.0);
        }
    }
    tally.remark("without coat and sheen, which are not implemented");
    tally.finish()
}

const LAST: f32 = 1.0 - f32::EPSILON / 2.0;

fn ends(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let (mut largest, mut below) = (0.0f32, 0u64);
    for pattern in [Pattern::Grid, Pattern::Random, Pattern::Stratified, Pattern::Sobol] {
        let n = effort.of(10_000, 1_000_000, 100_000_000);
        for s in 0..n {
            let key = Key::pixel(u64::from(s % 97), s, 5).at(s % 7, Dimension::Lobe);
            let (x, p) = (padded_1d(pattern, s, n, key), padded_2d(pattern, s, n, key));
            largest = largest.max(x).max(p.max_element());
            below += u64::from(!(x >= 0.0 && p.min_element() >= 0.0));
        }
    }
    tally.at_most("largest random number of any pattern", f64::from(largest), f64::from(LAST));
    tally.none("numbers below 0", below);
    let mut bad = 0u64;
    for u in [0.0, LAST].into_iter().flat_map(|x| [0.0, LAST].map(|y| Vec2::new(x, y))) {
        let warps =
            [warp::hemisphere_cosine(u), warp::sphere(u), warp::cone(u, 1e-12), warp::disk(u).extend(0.0)];
        bad += warps.iter().filter(|w| !w.is_finite() || w.length() > 1.000_001).count() as u64;
        for shape in shapes() {
            let light = Light::Area(Area { shape, radiance: Vec3::ONE, two_sided: true });
            for p in [Vec3::ZERO, Vec3::new(0.3, 0.2, 0.9), Vec3::new(0.3, 0.2, 1.0)] {
                let sample = light.sample(p, u, 0.0);
                bad += u64::from(
                    sample.is_some_and(|s| !(s.wi.is_finite() && s.pdf > 0.0 && s.pdf.is_finite())),
                );
            }
        }
        for roughness in [0.0, 0.1, 1.0] {
            for (metallic, transmission) in [(1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (0.5, 0.5)] {
                let material = Material { metallic, transmission, ..glass(1.5, roughness) };
                for mu in [1.0, 0.5, 1e-4, -0.3] {
                    for uc in [0.0, LAST] {
                        let s = Bsdf::new(&material, direction(mu, 0.1)).sample_f(uc, u, Lobes::ALL);
                        bad += u64::from(
                            s.is_some_and(|s| !(s.wi.is_finite() && s.weight.is_finite() && s.pdf > 0.0)),
                        );
                    }
                }
            }
        }
    }
    tally.none("samples at the ends of the interval that are not finite", bad);
    tally.finish()
}

fn shapes() -> [AreaShape; 4] {
    let (corner, e1, e2) = (Vec3::new(-1.0, -1.0, 1.0), Vec3::Y * 2.0, Vec3::X * 2.0);
    [
        AreaShape::Quad { corner, e1, e2 },
        AreaShape::Triangle([corner, corner + e1, corner + e2]),
        AreaShape::Sphere { centre: Vec3::Z * 2.0, radius: 1.0 },
        AreaShape::Disk { centre: Vec3::Z, normal: -Vec3::Z, radius: 1.0 },
    ]
}
