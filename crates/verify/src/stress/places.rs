//! Stress case B19: coincident surfaces.

use super::{Case, Check, Effort, Outcome};
use crate::scenes::{matte, quad, run, seen, square};
use crate::tally::Tally;
use dapple_integrator::geometry::Mesh;
use dapple_integrator::lights::Environment;
use dapple_integrator::sampling::{Pattern, SampleSet};
use dapple_integrator::scene::{Scene, SceneBuilder};
use dapple_integrator::{MethodKind, Settings};
use glam::{DAffine3, DQuat, DVec3, Vec3};

pub(super) const CASES: &[Case] = &[Case {
    id: "B19",
    title: "emitters coincident with a wall and with one another",
    naive: "light samples ignore occluders within the emitter's error bound, and rays hit the surface that is nearer by rounding: an emitter counts twice, not at all, or is speckled",
    source: "Pharr, Jakob & Humphreys 2023, §6.8 (error bounds); Veach & Guibas 1995 (both strategies must see the same)",
    check: Check::Run(shared_places),
}];

const METHODS: [MethodKind; 2] = [MethodKind::Path, MethodKind::Distribution];

/// A rotation by `i` steps about an axis that is not a coordinate axis.
fn turn(i: u32) -> DQuat {
    let half = 0.35 * f64::from(i);
    let v = DVec3::new(1.0, 2.0, 3.0).normalize() * libm::sin(half);
    DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(half))
}

/// A square in the plane z = `z`, with rotated and rounded corners, whose front faces −z.
fn panel(turn: DQuat, z: f64, centre: f64, half: f64) -> Mesh {
    let at = |x: f64, y: f64| (turn * DVec3::new(centre + x * half, centre + y * half, z)).as_vec3();
    let positions = vec![at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0)];
    Mesh { positions, ..quad(Vec3::ZERO, Vec3::X, Vec3::Y) }
}

/// A floor at z = 0 below a roof at z = 3; a ceiling at z = 2 + `gap` and `lamps` emitters at z = 2 are added in the
/// given order.
struct Place {
    turn: DQuat,
    gap: f64,
    lamps: u32,
    lamp_first: bool,
}

impl Place {
    fn builder(&self, from: DVec3, at: DVec3) -> SceneBuilder {
        let mut builder = seen(self.turn * from, self.turn * at, 0.05);
        builder.environment(Environment::constant(Vec3::ZERO));
        let (black, grey) = (builder.material(matte(0.0, 0.0)), builder.material(matte(0.8, 0.0)));
        let lamp = builder.material(matte(0.0, 5.0));
        let mut add = |z: f64, centre: f64, half: f64, material: u32| {
            builder.mesh("part", panel(self.turn, z, centre, half), DAffine3::IDENTITY, material);
        };
        add(0.0, 0.0, 1.0, grey);
        add(3.0, 0.0, 2.0, black);
        let ceiling = |add: &mut dyn FnMut(f64, f64, f64, u32)| add(2.0 + self.gap, 0.0, 1.5, black);
        if !self.lamp_first {
            ceiling(&mut add);
        }
        (0..self.lamps).for_each(|_| add(2.0, 0.1, 0.3, lamp));
        if self.lamp_first {
            ceiling(&mut add);
        }
        builder
    }

    fn of_floor(&self) -> Option<Scene> {
        self.builder(DVec3::new(0.1, 0.2, 1.2), DVec3::ZERO).build().ok()
    }

    fn of_lamp(&self) -> Option<Scene> {
        self.builder(DVec3::new(-0.5, 0.3, 0.4), DVec3::new(0.1, 0.1, 2.0)).build().ok()
    }
}

fn settings(method: MethodKind, bounces: u32, spp: u32) -> Settings {
    let mut settings = Settings { max_bounces: bounces, ..square(6, spp) }.with_method(method);
    settings.plans.pixel = SampleSet::new(spp, Pattern::Sobol);
    settings
}

fn values(scene: Option<Scene>, settings: &Settings) -> Vec<f64> {
    let Some(scene) = scene else { return vec![f64::NAN] };
    run(&scene, settings).film.mean().pixels.iter().map(|p| f64::from(p.x)).collect()
}

fn shared_places(effort: Effort) -> Outcome {
    let mut tally = Tally::default();
    for i in 0..effort.of(2, 8, 32) {
        for method in METHODS {
            for lamp_first in [false, true] {
                let place = Place { turn: turn(i), gap: 0.0, lamps: 1, lamp_first };
                let what =
                    format!("turn {i}, {method:?}, lamp {}", if lamp_first { "first" } else { "last" });
                let direct = settings(method, 1, 16);
                let raised = values(Place { gap: 1e-3, ..place }.of_floor(), &direct);
                let expected = mean(&raised);
                tally.exactly(format!("{what}: the floor is lit"), f64::from(u8::from(expected > 0.01)), 1.0);
                for lamps in [1, 3] {
                    let seen = values(Place { lamps, ..place }.of_floor(), &direct);
                    let what = format!("{what}, {lamps} emitters in the ceiling");
                    tally.within(what, mean(&seen), expected, 1e-4 * expected);
                }
                let looked_at = values(place.of_lamp(), &settings(method, 0, 4));
                for x in looked_at {
                    tally.exactly(format!("{what}, seen directly"), x, 5.0);
                }
            }
        }
    }
    tally.finish()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
