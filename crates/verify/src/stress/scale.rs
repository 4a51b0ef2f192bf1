//! Stress cases A01, A02, A12, A15: independence of the image from the size and position of the scene.

use super::{Case, Check, Effort, Outcome};
use crate::closed_form::furnace;
use crate::scenes::{cube, matte, moments, pixels, quad, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::Settings;
use dapple_integrator::geometry::{Mesh, Opaque};
use dapple_integrator::imaging::Image;
use dapple_integrator::math::Ray;
use dapple_integrator::scene::{CameraPose, Scene, SceneBuilder, SceneError};
use dapple_integrator::settings::Strategy;
use glam::{DAffine3, DVec3, Vec3};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A01",
        title: "closed furnace, sizes 1e-12 to 1e12",
        naive: "with an absolute ray epsilon, rays leak out of small rooms (too dark) or hit them again (too bright)",
        source: "Pharr, Jakob & Humphreys 2023, §6.8; docs/science.md, \"Closed room\"",
        check: Check::Run(sizes),
    },
    Case {
        id: "A02",
        title: "closed furnace far from the origin",
        naive: "f32 coordinates have steps of 0.06 at 1e6 and of 1 at 1e7: walls and camera are rounded differently",
        source: "Pharr, Jakob & Humphreys 2023, §5.1.1; docs/science.md, \"Render space\" and \"Rounding\"",
        check: Check::Run(far),
    },
    Case {
        id: "A12",
        title: "no leak along concave edges",
        naive: "an offset along one wall's normal pushes the ray's origin through the other wall",
        source: "Pharr, Jakob & Humphreys 2023, §6.8; docs/science.md, \"Leaving a surface\"",
        check: Check::Run(concave_edges),
    },
    Case {
        id: "A15",
        title: "teapot in a stadium",
        naive: "tolerances proportional to the scene's bounding box hide the small object",
        source: "docs/science.md, \"Leaving a surface\"",
        check: Check::Run(stadium),
    },
];

/// A closed room of half side (or radius) `scale` about `centre`. Every wall emits 1 and reflects half.
fn room(scale: f64, centre: DVec3, baked: f32, round: bool) -> SceneBuilder {
    let place = |v: DVec3| centre + (v + DVec3::splat(f64::from(baked))) * scale;
    let eye = DVec3::new(0.3125, -0.21875, 0.40625);
    let mut builder = seen(place(eye), place(eye + DVec3::new(-0.625, 0.3125, -0.6875)), 1.6);
    let wall = builder.material(matte(0.5, 1.0));
    if round {
        builder.sphere("room", centre, scale, wall);
    } else {
        let transform = DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(scale));
        builder.mesh("room", cube(1.0, Vec3::splat(baked)), transform, wall);
    }
    builder
}

/// Without roulette and light sampling every path contributes exactly 2 − 2⁻⁴⁰, whatever it hits, so that any leak is
/// visible.
fn certain(side: u32) -> Settings {
    Settings { max_bounces: 40, strategy: Strategy::BsdfOnly, ..square(side, 4) }
        .with_path(|p| p.roulette = false)
}

fn both(side: u32, spp: u32) -> Settings {
    Settings { max_bounces: 40, ..square(side, spp) }.with_path(|p| p.roulette = false)
}

fn each_size(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let exact = furnace(1.0, 0.5, 40);
    for k in (-12..=12).step_by(effort.of(6, 3, 1)) {
        for (round, shape) in [(false, "cube"), (true, "sphere")] {
            let scene = room(10f64.powi(k), DVec3::ZERO, 0.0, round).build()?;
            let image = run(&scene, &certain(12)).film.mean();
            let worst = image
                .pixels
                .iter()
                .map(|p| f64::from(p.x))
                .fold(2.0, |a: f64, b| if (b - exact).abs() > (a - exact).abs() { b } else { a });
            tally.within(format!("{shape} of size 1e{k}, worst pixel"), worst, exact, 2e-5);
            let noisy = moments(&run(&scene, &both(effort.of(4, 12, 32), effort.of(4, 16, 256))));
            tally.mean(
                format!("{shape} of size 1e{k}, with light sampling"),
                &noisy,
                exact,
                effort.of(0.2, 0.02, 0.01),
            );
        }
    }
    Ok(())
}

fn sizes(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = each_size(&mut tally, effort);
    tally.holds("every room is built", built.is_ok());
    tally.finish()
}

/// Compares the room at the origin and elsewhere, with light sampling, and by deterministic paths alone.
fn each_place(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    // The mean of a pixel retains the rounding of its samples, which decreases with their number: up to 1.4e-6 at 4.
    let aimed = both(16, effort.of(4, 64, 256));
    let pictures = |centre: DVec3| -> Result<_, SceneError> {
        let scene = room(1.0, centre, 0.0, false).build()?;
        Ok([&aimed, &certain(16)].map(|settings| run(&scene, settings).film.mean()))
    };
    let home = pictures(DVec3::ZERO)?;
    // Multiples of the grid on which scenes are centred, then other values.
    for t in [1024.0, 131_072.0, 8_388_608.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1234.567, 7_654_321.1] {
        let away = pictures(DVec3::new(t, -t, t))?;
        for (how, home, away) in [("aimed", &home[0], &away[0]), ("certain", &home[1], &away[1])] {
            if t == f64::from(t as u32) {
                let changed = home.pixels.iter().zip(&away.pixels).filter(|(a, b)| a != b).count();
                tally.none(format!("pixels changed by moving the node to {t}, {how}"), changed as u64);
                continue;
            }
            let what =
                |measure: &str| format!("{measure} relative change of a pixel by moving to {t}, {how}");
            let (rms, worst) = changes(home, away);
            tally.within(what("RMS"), rms, 0.0, 1e-6);
            if effort == Effort::Quick && how == "aimed" {
                tally.remark(format!("{}: {worst:.1e}", what("largest")));
            } else {
                tally.within(what("largest"), worst, 0.0, 1e-6);
            }
        }
    }
    for power in [-20, 7, 33] {
        let scaled = run(&room(2f64.powi(power), DVec3::ZERO, 0.0, false).build()?, &aimed).film.mean();
        let changed = home[0].pixels.iter().zip(&scaled.pixels).filter(|(a, b)| a != b).count();
        tally.none(format!("pixels changed by the scale 2^{power}"), changed as u64);
    }
    for baked in [1e3, 1e4, 1e5] {
        let m = pixels(room(1.0, DVec3::ZERO, baked, false), &certain(16))?;
        tally.within(format!("vertices at {baked}"), m.mean, furnace(1.0, 0.5, 40), 0.01);
    }
    Ok(())
}

/// The root mean square and the largest of the relative changes between two images.
fn changes(a: &Image, b: &Image) -> (f64, f64) {
    let off: Vec<f64> =
        a.pixels.iter().zip(&b.pixels).map(|(a, b)| f64::from((a.x - b.x) / a.x).abs()).collect();
    let squares: f64 = off.iter().map(|x| x * x).sum();
    ((squares / off.len() as f64).sqrt(), off.into_iter().fold(0.0, f64::max))
}

fn far(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = each_place(&mut tally, effort);
    tally.holds("every room is built", built.is_ok());
    tally.finish()
}

/// A narrow view along edges and into a corner of the closed cube: every pixel must receive light from all walls.
fn along_edges(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let (exact, side) = (furnace(1.0, 0.5, 40), effort.of(16, 48, 256));
    for (scale, shift) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e5)] {
        for target in [DVec3::new(1.0, 1.0, 0.1), DVec3::new(-1.0, 0.2, 1.0), DVec3::ONE] {
            let centre = DVec3::splat(shift);
            let mut builder = room(scale, centre, 0.0, false);
            let eye = centre + DVec3::new(0.3125, -0.21875, 0.40625) * scale;
            let pose = CameraPose::look_at(eye, centre + target * scale, DVec3::new(0.3, 0.9, 0.1), 1e-4);
            builder.camera("edge", pose);
            let scene = builder.build()?;
            let camera = &scene.cameras[1].camera;
            let image = dapple_integrator::render(&scene, camera, &certain(side), &|_| {
                std::ops::ControlFlow::Continue(())
            });
            let dark = image.film.mean().pixels.iter().filter(|p| f64::from(p.x) < exact - 2e-5).count();
            tally.none(format!("dark pixels at an edge, size {scale}, at {shift}"), dark as u64);
        }
    }
    Ok(())
}

fn concave_edges(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = along_edges(&mut tally, effort);
    tally.holds("every room is built", built.is_ok());
    super::leaving::beside_edges(&mut tally, effort.of(2000, 20_000, 1_000_000));
    super::leaving::in_sharp_edges(&mut tally, effort.of(2000, 20_000, 1_000_000));
    tally.finish()
}

/// A ball of radius 5e-4, on a floor of side 1e6 or alone.
fn teapot(with_floor: bool) -> Result<Scene, SceneError> {
    let mut builder = seen(DVec3::new(0.0, 1e-3, 4e-3), DVec3::new(0.0, 5e-4, 0.0), 0.3);
    let body = builder.material(matte(0.5, 0.0));
    let mesh = crate::scenes::ball(4, 5e-4, Vec3::Y * 5e-4);
    builder.mesh("teapot", Mesh { normals: Vec::new(), ..mesh }, DAffine3::IDENTITY, body);
    if with_floor {
        let floor = quad(Vec3::new(-5e5, 0.0, 5e5), Vec3::X * 1e6, Vec3::Z * -1e6);
        builder.mesh("floor", floor, DAffine3::IDENTITY, body);
    }
    builder.build()
}

fn compare(tally: &mut Tally, effort: Effort) -> Result<(), SceneError> {
    let (alone, whole) = (teapot(false)?, teapot(true)?);
    let side = effort.of(64, 256, 1024);
    let (mut lost, mut furthest, mut seen) = (0u64, 0.0f64, 0u64);
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let hit = |scene: &Scene| {
            let half = glam::Vec2::splat(0.5);
            let ray: Ray = scene.cameras[0].camera.ray((x, y), half, (side, side), half);
            let hit = scene.accel.intersect(&ray, 0.0, &Opaque)?;
            let p = scene.accel.surface(&ray, 0.0, &hit).p;
            (hit.object == 0).then(|| (hit.primitive, scene.space.to_world(p).0))
        };
        match (hit(&alone), hit(&whole)) {
            (Some((_, a)), Some((_, b))) => {
                seen += 1;
                furthest = furthest.max((a - b).length() / 5e-4);
            }
            (None, None) => {}
            // On the silhouette the rounding of the camera position decides.
            _ => lost += 1,
        }
    }
    tally.at_most(
        "share of the object's pixels that appear or disappear with the floor",
        lost as f64 / seen as f64,
        2e-3,
    );
    tally.within("largest displacement of a visible point, in radii of the object", furthest, 0.0, 2e-3);
    let rays = rays_at_object(&alone, side);
    let hits =
        |scene: &Scene| rays.iter().filter(|ray| scene.accel.intersect(ray, 0.0, &Opaque).is_some()).count();
    let slower = crate::clock::ratio(|| hits(&whole), || hits(&alone));
    if effort == Effort::Quick {
        tally.remark(format!("{slower:.2} times the time of the object alone"));
    } else {
        tally.at_most("time of a ray over that with the object alone", slower, 2.0);
    }
    Ok(())
}

/// The rays through pixel centres that hit something.
fn rays_at_object(scene: &Scene, side: u32) -> Vec<Ray> {
    let (camera, half) = (&scene.cameras[0].camera, glam::Vec2::splat(0.5));
    let pixels = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let rays = pixels.map(|p| camera.ray(p, half, (side, side), half));
    rays.filter(|ray| scene.accel.intersect(ray, 0.0, &Opaque).is_some()).collect()
}

fn stadium(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let built = compare(&mut tally, effort);
    tally.holds("both scenes are built", built.is_ok());
    tally.finish()
}
