//! Irradiance from lights of every shape, by light sampling alone and combined with the directions of a diffuse lobe
//! (docs/science.md, "Rectangles", "Disks" and "Sphere lights").

use crate::common::maps::midpoint_bound;
use crate::common::tracers::*;
use crate::common::*;
use dapple_integrator::Effect;
use dapple_sampling::Pattern;
use dapple_scene::{Scene, SceneBuilder};
use dapple_testkit::closed_form as exact;
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, PI};

/// Radiance of every light in this file.
const L: f64 = 2.0;

type Integrand = Box<dyn Fn(f64, f64) -> f64>;

/// A lit floor: its irradiance over πL, and the integrands of a grid: over the light's surface, and in the coordinates
/// in which paths sample it (for quads those of either order).
struct Lit {
    name: &'static str,
    scene: Scene,
    exact: f64,
    surface: Integrand,
    aimed: Vec<Integrand>,
}

fn scene(light: impl FnOnce(&mut SceneBuilder, u32)) -> Scene {
    let mut builder = irradiance_meter();
    let bright = builder.material(matte(0.0, L as f32));
    light(&mut builder, bright);
    builder.build().unwrap()
}

/// cosθ·cosθ'/(πd²) from the point `s` of a surface with the normal `n` to the floor at the origin.
fn kernel(s: DVec3, n: DVec3) -> f64 {
    let d2 = s.length_squared();
    s.y.max(0.0) * (-s.dot(n)).max(0.0) / (d2 * d2) * FRAC_1_PI
}

fn quad_light(name: &'static str, corner: DVec3, e1: DVec3, e2: DVec3, exact: f64) -> Lit {
    let mesh = quad(corner.as_vec3(), e1.as_vec3(), e2.as_vec3());
    let cross = e1.cross(e2);
    let aimed = [(e1, e2), (e2, e1)].map(|(e1, e2)| {
        let (omega, direction) = maps::rectangle_in_solid_angle(corner, e1, e2);
        Box::new(move |u, v| omega * direction(u, v).y * FRAC_1_PI) as Integrand
    });
    Lit {
        name,
        scene: scene(|b, m| _ = b.mesh("light", mesh, DAffine3::IDENTITY, m)),
        exact,
        surface: Box::new(move |u, v| cross.length() * kernel(corner + e1 * u + e2 * v, cross.normalize())),
        aimed: aimed.into(),
    }
}

fn disk_light(centre: DVec3, radius: f64, exact: f64) -> Lit {
    let place = move |u, v| {
        let [x, z] = maps::disk(u, v);
        centre + DVec3::new(x, 0.0, z) * radius
    };
    let integrand = move |u, v| PI * radius * radius * kernel(place(u, v), DVec3::NEG_Y);
    Lit {
        name: "disk",
        scene: scene(|b, m| _ = b.disk("light", centre, DVec3::NEG_Y, radius, m)),
        exact,
        surface: Box::new(integrand),
        aimed: vec![Box::new(integrand)],
    }
}

/// A sphere whose centre is `q` radii away, at an angle to the floor's normal.
fn sphere_light(name: &'static str, degrees: f64, q: f64) -> Lit {
    let (radius, (sin, cos)) = (0.4, degrees.to_radians().sin_cos());
    let axis = DVec3::new(-sin, cos, 0.0);
    let centre = axis * (q * radius);
    let cap = 1.0 - (1.0 - 1.0 / (q * q)).sqrt();
    let normal = |u, v| maps::cone(DVec3::Z, 2.0, u, v);
    Lit {
        name,
        scene: scene(|b, m| _ = b.sphere("light", centre, radius, m)),
        exact: exact::sphere(q, cos),
        surface: Box::new(move |u, v| {
            4.0 * PI * radius * radius * kernel(centre + normal(u, v) * radius, normal(u, v))
        }),
        aimed: vec![Box::new(move |u, v| 2.0 * cap * maps::cone(axis, cap, u, v).y.max(0.0))],
    }
}

/// Quads above; a wall that stands on the floor; a disk to the side; spheres, two of them clipped by the horizon.
fn lights() -> Vec<Lit> {
    let (low, high) = (DVec2::new(-0.7, -0.5), DVec2::new(0.1, 0.4));
    vec![
        quad_light(
            "quad",
            DVec3::new(-0.7, 0.9, -0.5),
            DVec3::X * 0.8,
            DVec3::Z * 0.9,
            exact::parallel_rectangle(low, high, 0.9),
        ),
        quad_light(
            "standing quad",
            DVec3::new(-0.6, 0.0, 0.0),
            DVec3::Y * 1.1,
            DVec3::Z * 0.7,
            exact::perpendicular_rectangle(1.1, 0.7, 0.6),
        ),
        disk_light(DVec3::new(-0.5, 0.8, 0.0), 0.4, exact::parallel_disk(0.4, 0.8, 0.5)),
        sphere_light("clipped sphere", 80.0, 1.5),
        sphere_light("sphere below the horizon", 100.0, 1.3),
        sphere_light("sphere", 30.0, 3.0),
    ]
}

/// Light sampling alone, and combined with BSDF sampling.
#[test]
fn lights_of_every_shape() {
    for light in lights() {
        let camera = light.scene.cameras[0].camera.clone();
        let exact = L * light.exact;
        for tracer in TRACERS {
            for pattern in UNBIASED {
                for effects in [&[Effect::Light][..], &[Effect::Light, Effect::Diffuse]] {
                    let plans: Vec<_> = effects.iter().map(|e| (*e, [4, 4])).collect();
                    let settings = one_pixel(tracer, pattern, &plans, 16);
                    let moments = replicas(&light.scene, &camera, &settings, 800)[0];
                    let what = format!("{}, {tracer:?} {pattern} {effects:?}", light.name);
                    assert_mean_known_to(&what, &moments, exact, 0.02 * exact);
                }
            }
        }
    }
}

/// The error of a grid is below the bound from the variation of its integrand along lines.
#[test]
fn grids_on_lights() {
    let side = 256;
    let bound = |f: &Integrand| midpoint_bound(maps::variations(f), [side; 2]);
    for light in lights() {
        let camera = light.scene.cameras[0].camera.clone();
        let on_surface = bound(&light.surface);
        let aimed = light.aimed.iter().map(bound).fold(0.0, f64::max);
        assert!(
            on_surface.max(aimed) < 0.12 * light.exact,
            "{}: {on_surface} {aimed} are inconclusive",
            light.name
        );
        for tracer in TRACERS {
            let settings = one_pixel(tracer, Pattern::Grid, &[(Effect::Light, [side; 2])], side * side);
            let mean = values(&light.scene, &camera, &settings, 0)[0] / L;
            let bound = if tracer == Tracer::Path { aimed } else { on_surface };
            let what = format!("{}, {tracer:?}", light.name);
            assert!((mean - light.exact).abs() <= bound, "{what}: {mean}, exact {}, {bound}", light.exact);
        }
    }
}
