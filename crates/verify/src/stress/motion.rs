//! Stress cases A16 to A18: the shadow terminator, linear motion, and rotation.

use super::{Case, Check, Effort, Outcome};
use crate::closed_form::moving_box;
use crate::scenes::{ball, quad, run, seen, seen_in_parallel, shadeless};
use crate::tally::Tally;
use dapple_integrator::camera::Shutter;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::imaging::Image;
use dapple_integrator::math::motion::{Channel, Interpolation, Node, Track, Trs, Value};
use dapple_integrator::sampling::Moments;
use dapple_integrator::scene::{Scene, SceneError, TexturedMaterial};
use dapple_integrator::{Effect, SampleSets, Settings};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::TAU;
use std::sync::Arc;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A16",
        title: "shadow terminator of a tessellated ball",
        naive: "shading normals and flat facets disagree at the terminator: hard facet edges that no refinement removes",
        source: "Hanika 2021; docs/science.md, \"Shadow terminator\"",
        check: Check::Run(terminator),
    },
    Case {
        id: "A17",
        title: "linear motion from none to 1e7 pixels",
        naive: "boxes at one instant miss moving objects; the wrong form of a(1 − t) + bt does not reach b at t = 1",
        source: "docs/science.md, \"Moving box\"",
        check: Check::Run(streak),
    },
    Case {
        id: "A18",
        title: "rotation beyond 180° in the shutter",
        naive: "interpolated matrices collapse at 180°, quaternions take the shorter arc",
        source: "docs/science.md, \"Turning wedge\"",
        check: Check::Run(turns),
    },
];

fn track<T: Value>(times: Vec<f64>, values: Vec<T>) -> Option<Channel<T>> {
    Track::new(times, values, Interpolation::Linear).ok().map(|t| Channel::Track(Arc::new(t)))
}

fn lit(triangles: u32) -> Result<Scene, SceneError> {
    let mut builder = seen(DVec3::new(0.0, 0.0, 6.0), DVec3::ZERO, 0.34);
    let white = builder.material(TexturedMaterial::lambert("white", Vec3::ONE));
    if triangles == 0 {
        builder.sphere("ball", DVec3::ZERO, 1.0, white);
    } else {
        builder.mesh("ball", ball(triangles, 1.0, Vec3::ZERO), DAffine3::IDENTITY, white);
    }
    builder.point_light(DVec3::new(20.0, 5.0, 4.0), Vec3::splat(1e3), f64::INFINITY);
    builder.build()
}

/// Compares images of the tessellated ball with the exact sphere, away from the silhouette, with the hard terminator of
/// the facets and with the softened one.
fn terminator(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let side = effort.of(64, 128, 512);
    let picture = |level, soft_terminator| {
        let size = (side, side);
        let settings = Settings { max_bounces: 1, size, soft_terminator, ..Settings::default() }.with_spp(16);
        lit(level).ok().map_or_else(nothing, |scene| run(&scene, &settings).film.mean())
    };
    let exact = picture(0, false);
    tally.holds("an exact sphere is not softened", picture(0, true).pixels == exact.pixels);
    let inside = |i: usize| {
        let at = |k: usize| 2.0 * (k as f64 + 0.5) / f64::from(side) - 1.0;
        at(i % side as usize).hypot(at(i / side as usize)) < 0.85
    };
    let off = |soft| [2, 3, 4, 5].map(|level| Off::of(&exact, &picture(level, soft), side as usize, inside));
    let (hard, soft) = (off(false), off(true));
    for (how, off) in [("hard", &hard), ("softened", &soft)] {
        refined(&mut tally, how, off);
        tally.remark(format!("{how}: {off:.5?}"));
    }
    for (hard, soft) in hard.iter().zip(&soft) {
        tally.at_most("mean error, softened over hard", soft.mean / hard.mean, 0.9);
        tally.at_most("largest step of the error, softened over hard", soft.step / hard.step, 0.25);
    }
    tally.finish()
}

/// Checks the error when the facet size is halved three times. n⁻² is a factor of 64 in the mean error, n⁻¹ one of 8.
fn refined(tally: &mut Tally, how: &str, off: &[Off; 4]) {
    let [first, .., last] = off;
    let name = |what: &str| format!("{how}: {what}, finest over coarsest");
    tally.at_most(name("mean error over the lit side"), last.mean / first.mean, 1.0 / 16.0);
    tally.at_most(format!("{how}: mean error over the lit side, finest"), last.mean, 1e-3);
    tally.at_most(name("largest difference near the terminator"), last.worst / first.worst, 0.5);
    // Facets have another shape than the sphere, which alone may add light of order n⁻².
    tally.at_most(name("light gained"), last.gain / first.gain, 1.0 / 16.0);
}

/// An empty image, whose comparison yields NaN and fails.
fn nothing() -> Image {
    Image { width: 0, height: 0, pixels: Vec::new() }
}

/// The deviation of an image of facets from that of the sphere, relative to the mean of the latter.
#[derive(Debug)]
struct Off {
    /// Mean absolute difference.
    mean: f64,
    /// Mean difference: light gained or, if negative, lost.
    gain: f64,
    /// The largest absolute difference of a pixel.
    worst: f64,
    /// The largest step of the difference from a pixel to its right or lower neighbour: a false edge.
    step: f64,
}

impl Off {
    /// The deviation over the pixels for which `inside` is true.
    fn of(exact: &Image, image: &Image, side: usize, inside: impl Fn(usize) -> bool) -> Self {
        let pairs = exact.pixels.iter().zip(&image.pixels).enumerate();
        let off: Vec<Option<f64>> =
            pairs.map(|(i, (a, b))| inside(i).then_some(f64::from(b.x - a.x))).collect();
        let all: f64 =
            (0..).zip(&exact.pixels).filter(|(i, _)| inside(*i)).map(|(_, p)| f64::from(p.x)).sum();
        let count = off.iter().flatten().count() as f64;
        let largest = |x: &mut dyn Iterator<Item = f64>| x.map(f64::abs).fold(0.0, f64::max) * count / all;
        let neighbours = (0..off.len().saturating_sub(side)).flat_map(|i| [(i, i + 1), (i, i + side)]);
        Self {
            mean: off.iter().flatten().map(|x| x.abs()).sum::<f64>() / all,
            gain: off.iter().flatten().sum::<f64>() / all,
            worst: largest(&mut off.iter().flatten().copied()),
            step: largest(&mut neighbours.filter_map(|(i, j)| Some(off[i]? - off[j]?))),
        }
    }
}

/// A bar `w` pixels wide that moves by `delta` pixels to the right while the shutter is open; its right edge starts at
/// 0.
fn bar(w: f64, delta: f64) -> Result<Scene, SceneError> {
    let mut builder = seen_in_parallel(DVec3::new(0.0, 0.0, 1.0), 0.5);
    let white = builder.material(shadeless(1.0));
    let mesh = quad(Vec3::new(-w as f32, -4.0, 0.0), Vec3::X * w as f32, Vec3::Y * 8.0);
    let moved = track(vec![0.0, 1.0], vec![DVec3::ZERO, DVec3::X * delta]);
    let translation = moved.unwrap_or(Channel::Constant(DVec3::ZERO));
    builder.moving_mesh("bar", mesh, vec![Node::Trs(Trs { translation, ..Trs::default() })], white);
    builder.exposure(0.0, Shutter { open: 0.0, close: 1.0 });
    builder.build()
}

fn streak(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    let w = f64::from(1.3f32);
    for delta in [1e-3, 1.0, 2.4, 1e3, 1e7] {
        let Ok(scene) = bar(w, delta) else {
            tally.holds(format!("the bar that moves by {delta} is built"), false);
            continue;
        };
        // One row of 8 pixels of side 1, x from −4 to 4.
        let mut columns = [Moments::default(); 8];
        let replicas = effort.of(40, 400, 4000);
        let spp = if delta > 100.0 { 1024 } else { 64 };
        for seed in 0..replicas {
            let settings = Settings { size: (8, 1), seed, ..Settings::default() }.with_spp(spp);
            let image = run(&scene, &settings).film.mean();
            columns.iter_mut().zip(&image.pixels).for_each(|(m, p)| m.add(f64::from(p.x)));
        }
        for (i, m) in columns.iter().enumerate() {
            let x = i as f64 - 4.0;
            // G of docs/science.md, "Moving box", is measured along the streak, which begins w behind the edge that
            // starts at 0.
            let exact = if delta > 100.0 { plateau(x, w, delta) } else { moving_box(x + w, w, delta) };
            let what = format!("pixel {i}, moved by {delta}");
            let error = m.standard_error();
            // If all samples agree, the variance is unknown: one of all samples could differ.
            let floor = 4.0 / (replicas as f64 * f64::from(spp));
            tally.within(&*what, m.mean, exact, 4.0 * error + floor + 1e-6);
        }
    }
    tally.finish()
}

/// The coverage of a pixel [x, x + 1] in the rising part or on the plateau of a streak much longer than the bar.
fn plateau(x: f64, w: f64, delta: f64) -> f64 {
    // Point coverage clamp(x + w, 0, w)/Δ.
    let area = |a: f64| {
        if a <= 0.0 {
            0.0
        } else if a < w {
            0.5 * a * a
        } else {
            0.5 * w * w + (a - w) * w
        }
    };
    (area(x + w + 1.0) - area(x + w)) / delta
}

/// A wedge of 40° about the view axis that rotates by `total` in steps of less than 180°.
fn wedge(total: f64) -> Result<Scene, SceneError> {
    let mut builder = seen_in_parallel(DVec3::new(0.0, 0.0, 1.0), 1.0);
    let white = builder.material(shadeless(1.0));
    let beta = 40f64.to_radians();
    let rim: Vec<Vec3> = (0..=8)
        .map(|i| DVec3::new((beta * f64::from(i) / 8.0).cos(), (beta * f64::from(i) / 8.0).sin(), 0.0) * 4.0)
        .map(|p| p.as_vec3())
        .collect();
    let mut mesh = Mesh { positions: vec![Vec3::ZERO], ..Mesh::default() };
    mesh.positions.extend(rim);
    mesh.triangles = (1..9).map(|i| [0, i, i + 1]).collect();
    let steps = (total / 2.0).ceil().max(1.0) as usize;
    let part = |i: usize| i as f64 / steps as f64;
    let keys = (0..=steps).map(|i| DQuat::from_rotation_z(total * part(i))).collect();
    let rotation = track((0..=steps).map(part).collect(), keys).unwrap_or(Channel::Constant(DQuat::IDENTITY));
    builder.moving_mesh("wedge", mesh, vec![Node::Trs(Trs { rotation, ..Trs::default() })], white);
    builder.exposure(0.0, Shutter { open: 0.0, close: 1.0 });
    builder.build()
}

/// |{τ ∈ [0, Θ]: (φ − τ) mod 2π ∈ [0, β]}|/Θ.
fn covered(phi: f64, total: f64) -> f64 {
    let beta = 40f64.to_radians();
    let whole = (total / TAU).floor();
    let rest = total - whole * TAU;
    // τ from φ − β to φ, on the circle, within [0, rest].
    let overlap = |low: f64, high: f64| (high.min(rest) - low.max(0.0)).max(0.0);
    let phi = phi.rem_euclid(TAU);
    let within = overlap(phi - beta, phi) + overlap(phi - beta + TAU, phi + TAU);
    (whole * beta + within) / total
}

fn turns(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for degrees in [90.0, 180.0, 360.0, 1080.0, 1e5, 360_000.0] {
        let total = f64::to_radians(degrees);
        let Ok(scene) = wedge(total) else {
            tally.holds(format!("the wedge that rotates by {degrees}° is built"), false);
            continue;
        };
        let mut moments = [Moments::default(); 64];
        let mut plans = SampleSets::default();
        *plans.of_mut(Effect::Pixel) = dapple_integrator::sampling::SampleSet::OFF;
        for seed in 0..effort.of(10, 60, 1000) {
            let settings = Settings { size: (8, 8), seed, plans, ..Settings::default() }.with_spp(128);
            let image = run(&scene, &settings).film.mean();
            moments.iter_mut().zip(&image.pixels).for_each(|(m, p)| m.add(f64::from(p.x)));
        }
        for (i, m) in moments.iter().enumerate() {
            let (x, y) = ((i % 8) as f64 - 3.5, 3.5 - (i / 8) as f64);
            let exact = covered(y.atan2(x), total);
            // The variance of few sets is uncertain; the standard error is assumed to be at least half that of
            // independent times.
            let floor = 0.5 * (exact * (1.0 - exact) / (128.0 * m.n as f64)).sqrt();
            let what = format!("pixel {i} of a wedge rotated by {degrees}°");
            tally.within(what, m.mean, exact, 4.0 * m.standard_error().max(floor) + 1e-6);
        }
    }
    tally.finish()
}
