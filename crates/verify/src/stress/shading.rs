//! Stress cases C14 to C16, C18: shading normals that differ from the geometric normals.

use super::{Case, Check, Effort, Outcome};
use crate::noise::Noise;
use crate::scenes::{ball, matte, metal, of, quad, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::Settings;
use dapple_integrator::geometry::{Mesh, Opaque};
use dapple_integrator::imaging::{Encoding, Image, Interpolation, Rgba8, Sampler, Texture, Wrap};
use dapple_integrator::lights::Environment;
use dapple_integrator::materials::Material;
use dapple_integrator::math::Ray;
use dapple_integrator::sampling::Moments;
use dapple_integrator::scene::{Scene, SceneError, TextureUse, TexturedMaterial, WorldPoint};
use dapple_integrator::settings::MethodKind;
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "C14",
        title: "normal maps that turn away from the camera",
        naive: "black pixels, or created energy",
        source: "docs/science.md, \"Normals that lean\"",
        check: Check::Run(turned_away),
    },
    Case {
        id: "C15",
        title: "degenerate tangents",
        naive: "0/0 in the tangent frame: NaN in the image",
        source: "Duff et al. 2017; Mikkelsen 2008; docs/science.md, \"Normals that lean\"",
        check: Check::Run(tangents),
    },
    Case {
        id: "C16",
        title: "smooth normals create no energy",
        naive: "the cosine to the shading normal exceeds that to the geometric normal: albedo above 1",
        source: "Veach 1997, §5.3; docs/science.md, \"Normals that lean\"",
        check: Check::Run(smooth),
    },
    Case {
        id: "C18",
        title: "normal maps conserve energy",
        naive: "light reflected below the surface is dropped: steep maps turn metals black",
        source: "Schüßler et al. 2017; ARCHITECTURE, integrator/src/normals.rs",
        check: Check::Run(kept),
    },
];

/// A normal map of constant direction.
fn normal_map(n: Vec3) -> Texture {
    let byte = |x: f32| ((x * 0.5 + 0.5) * 255.0).round() as u8;
    let image = Rgba8 {
        width: 2,
        height: 1,
        texels: vec![[byte(n.x), byte(n.y), byte(n.z), 255], [byte(n.x), byte(n.y), byte(n.z), 254]],
    };
    let sampler =
        Sampler { wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, interpolation: Interpolation::Nearest };
    Texture::new(image, Encoding::Linear, sampler)
}

fn with_uv(mesh: Mesh, uv: [Vec2; 4]) -> Mesh {
    Mesh { uv: [uv.to_vec(), Vec::new()], ..mesh }
}

const UV: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

/// A floor in a white sky whose normal map tilts by `tilt` towards the azimuth `azimuth` from +x, seen from +x at the
/// angle `view` from the normal.
fn tilted(material: TexturedMaterial, tilt: f32, azimuth: f32, view: f64) -> Result<Scene, SceneError> {
    let mut builder = seen(DVec3::new(view.sin(), view.cos(), 0.0) * 3.0, DVec3::ZERO, 0.02);
    let across = Vec2::from_angle(azimuth) * tilt.sin();
    let map = builder.texture(normal_map(across.extend(tilt.cos())));
    let material =
        builder.material(TexturedMaterial { normal_texture: Some(TextureUse::new(map)), ..material });
    let floor = with_uv(quad(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Z * -2.0), UV);
    builder.mesh("floor", floor, DAffine3::IDENTITY, material);
    builder.environment(Environment::constant(Vec3::ONE));
    builder.build()
}

/// A pane of the given roughness that absorbs nothing.
fn pane(roughness: f32) -> TexturedMaterial {
    let glass = matte(1.0, 0.0).base;
    of(Material { specular: 1.0, transmission: 1.0, roughness, ..glass })
}

/// In a white sky, a surface that absorbs nothing is white for any shading normal. At roughness 0.1, single scattering
/// loses up to 1.6 % at 85° (2.1 % with transmission).
fn kept(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let coated = Material { specular: 1.0, ..matte(1.0, 0.0).base };
    for (name, material, loss) in [
        ("metal", of(metal(0.01)), 0.02),
        ("mirror", of(metal(0.0)), 1e-4),
        ("white", matte(1.0, 0.0), 1e-4),
        ("coated white", of(Material { roughness: 0.3, ..coated }), 0.02),
        ("pane", pane(0.0), 1e-4),
        ("frosted pane", pane(0.1), 0.025),
    ] {
        for tilt in [30.0f32, 60.0] {
            for azimuth in [0.0f32, 100.0, 180.0] {
                for view in [0.0, 45.0, 85.0] {
                    let what =
                        format!("{name}, normal tilted by {tilt}° towards {azimuth}°, seen from {view}°");
                    let (lean, view) = (tilt.to_radians(), f64::to_radians(view));
                    let Ok(scene) = tilted(material.clone(), lean, azimuth.to_radians(), view) else {
                        tally.holds(format!("{what}: built"), false);
                        continue;
                    };
                    for method in [MethodKind::Path, MethodKind::Distribution] {
                        let base = square(4, effort.of(64, 1024, 16_384));
                        let settings = Settings { max_bounces: 3, ..base }.with_method(method);
                        let (mean, error) = mean_of(&run(&scene, &settings).film.mean());
                        tally.at_most(format!("{what}: energy lost"), 1.0 - mean - 4.0 * error, loss);
                        tally.at_most(format!("{what}: energy retained"), mean - 4.0 * error, 1.0 + 1e-3);
                    }
                }
            }
        }
    }
    tally.finish()
}

/// Mean of the pixels and its standard error.
fn mean_of(image: &Image) -> (f64, f64) {
    let moments: Moments = image.pixels.iter().map(|p| f64::from(p.x)).collect();
    (moments.mean, moments.standard_error())
}

fn turned_away(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for (name, material) in
        [("white", matte(1.0, 0.0)), ("rough metal", of(metal(0.25))), ("mirror", of(metal(1e-6)))]
    {
        for tilt in [-80.0f32, -40.0, 40.0, 80.0] {
            for view in [0.0, 45.0, 85.0] {
                let what = format!("{name}, normal tilted by {tilt}°, seen from {view}°");
                let Ok(scene) = tilted(material.clone(), tilt.to_radians(), 0.0, f64::to_radians(view))
                else {
                    tally.holds(format!("{what}: built"), false);
                    continue;
                };
                let settings = Settings { max_bounces: 3, ..square(4, effort.of(64, 1024, 16_384)) };
                let image = run(&scene, &settings).film.mean();
                let black = image.pixels.iter().filter(|p| p.x <= 0.0).count();
                tally.none(format!("{what}: black pixels"), black as u64);
                let most = image.pixels.iter().map(|p| f64::from(p.x)).fold(0.0, f64::max);
                tally.at_most(format!("{what}: brightest pixel"), most, 1.0 + 1e-3);
            }
        }
    }
    tally.finish()
}

fn tangents(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let flipped = [Vec2::X, Vec2::ZERO, Vec2::Y, Vec2::ONE];
    let line = [Vec2::ZERO, Vec2::X, Vec2::X * 2.0, Vec2::X * 3.0];
    let sets = [
        ("ordinary", UV),
        ("constant", [Vec2::splat(0.3); 4]),
        ("mirrored", flipped),
        ("on a line", line),
        ("not a number", [Vec2::NAN; 4]),
        ("infinite", [Vec2::INFINITY; 4]),
        ("huge", UV.map(|uv| uv * 1e30)),
        ("tiny", UV.map(|uv| uv * 1e-30)),
    ];
    for (name, uv) in sets {
        for given in [None, Some(Vec4::ZERO), Some(Vec4::new(0.0, 1.0, 0.0, 1.0)), Some(Vec4::NAN)] {
            let mut builder = seen(DVec3::Y * 3.0, DVec3::ZERO, 0.5);
            let map = builder.texture(normal_map(Vec3::new(0.3, 0.2, 0.93).normalize()));
            let material = builder
                .material(TexturedMaterial { normal_texture: Some(TextureUse::new(map)), ..matte(0.5, 0.0) });
            let mut floor = with_uv(quad(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Z * -2.0), uv);
            floor.normals = vec![Vec3::Y; 4];
            floor.tangents = given.map_or(Vec::new(), |t| vec![t; 4]);
            builder.mesh("floor", floor, DAffine3::IDENTITY, material);
            builder.environment(Environment::constant(Vec3::ONE));
            let what = format!("uv {name}, tangent {given:?}");
            match builder.build() {
                Ok(scene) => frames(&mut tally, &scene, &what, effort),
                // An error for values that are not finite is correct as well.
                Err(_) => tally.holds(
                    format!("{what}: refused"),
                    name == "not a number" || name == "infinite" || given.is_some_and(|t| t.is_nan()),
                ),
            }
        }
    }
    tally.remark("without anisotropy, which is not implemented");
    tally.finish()
}

fn frames(tally: &mut Tally, scene: &Scene, what: &str, effort: Effort) {
    let (mut noise, mut worst) = (Noise(61), 0.0f64);
    for _ in 0..effort.of(20, 500, 20_000) {
        let p = noise.cube();
        let o = scene.space.to_render(WorldPoint(DVec3::new(f64::from(p.x), 1.0, f64::from(p.z))));
        let ray = Ray::new(o, Vec3::NEG_Y);
        let Some(hit) = scene.accel.intersect(&ray, 0.0, &Opaque) else { continue };
        let surface = scene.accel.surface(&ray, 0.0, &hit);
        let f = scene.shading(&hit, &surface, 0.0).frame;
        let off = [
            f.x.length() - 1.0,
            f.y.length() - 1.0,
            f.z.length() - 1.0,
            f.x.dot(f.y),
            f.y.dot(f.z),
            f.z.dot(f.x),
        ];
        // `max` would ignore NaN.
        for x in off {
            worst = if x.is_nan() { f64::NAN } else { worst.max(f64::from(x.abs())) };
        }
    }
    tally.within(format!("frame: {what}"), worst, 0.0, 1e-5);
    let image: Image = run(scene, &square(4, 16)).film.mean();
    tally.holds(
        format!("image: {what}"),
        image.pixels.iter().all(|p| p.is_finite() && p.max_element() <= 0.501),
    );
}

fn smooth(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for level in [0, 1, 2, 4] {
        for (name, material) in [("white", matte(1.0, 0.0)), ("rough metal", of(metal(0.5)))] {
            let mut builder = seen(DVec3::new(0.3, 0.2, 4.0), DVec3::ZERO, 0.6);
            let material = builder.material(material);
            builder.mesh("ball", ball(level, 1.0, Vec3::ZERO), DAffine3::IDENTITY, material);
            builder.environment(Environment::constant(Vec3::ONE));
            let Ok(scene) = builder.build() else { continue };
            for (soft_terminator, how) in [(false, ""), (true, ", softened")] {
                let square = square(effort.of(16, 48, 256), 64);
                let settings = Settings { max_bounces: 100, soft_terminator, ..square }
                    .with_path(|p| p.roulette = false);
                let image = run(&scene, &settings).film.mean();
                let most = image.pixels.iter().map(|p| f64::from(p.x)).fold(0.0, f64::max);
                let what = format!("brightest pixel, {name} ball of level {level}{how}");
                tally.at_most(what, most, 1.0 + 1e-4);
            }
        }
    }
    tally.finish()
}
