//! Coincident surfaces: the emitting side of an emitter wins, then the lowest object, independently of rounding.
//!
//! Most tests compare a scene in which a lamp lies in the plane of a ceiling with the same scene whose ceiling is one
//! millimetre higher. Everything else in the two scenes is the same to the last bit, including the random numbers, so
//! that the images agree pixel by pixel, at any number of samples.

mod common;

use common::moving::{AT, SHUTTER, slide};
use common::{matte, metal, quad, run};
use dapple_geometry::Mesh;
use dapple_integrator::camera::Projection;
use dapple_integrator::{Effect, MethodKind, Outcome, Settings};
use dapple_lights::Environment;
use dapple_sampling::{Pattern, SampleSet};
use dapple_scene::{AlphaMode, CameraPose, Scene, SceneBuilder, TexturedMaterial};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

/// The lamp in the plane of the ceiling.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lamp {
    Quad,
    /// Rotated in its plane, so that its triangles share no vertices with those of the ceiling.
    Triangle,
    Disk,
    /// Moves in the plane while the shutter is open.
    Moving,
    /// Without extent.
    Point,
    Spot,
}

const LAMPS: [Lamp; 6] = [Lamp::Quad, Lamp::Triangle, Lamp::Disk, Lamp::Moving, Lamp::Point, Lamp::Spot];

/// A floor at 0, a ceiling at 2 with a lamp that shines down, a roof at 3; all rotated by `turn` and then translated.
#[derive(Clone, Copy, Debug)]
struct Room {
    lamp: Lamp,
    turn: DQuat,
    to: DVec3,
    /// Whether coordinates are rotated before they are rounded to f32, or by the nodes.
    baked: bool,
    lamp_first: bool,
    /// Height of the ceiling above the lamp.
    gap: f64,
    metal: bool,
}

impl Room {
    const PLAIN: Self = Self {
        lamp: Lamp::Quad,
        turn: DQuat::IDENTITY,
        to: DVec3::ZERO,
        baked: false,
        lamp_first: false,
        gap: 0.0,
        metal: false,
    };

    fn at(&self, p: DVec3) -> DVec3 {
        self.turn * p + self.to
    }

    /// A horizontal rectangle about the axis, facing down or up.
    fn level(&self, builder: &mut SceneBuilder, y: f64, half: f64, down: bool, material: u32) {
        let side = if down { 1.0 } else { -1.0 };
        let corner = DVec3::new(-half, y, -half * side);
        self.mesh(builder, [corner, DVec3::X * (2.0 * half), DVec3::Z * (2.0 * half * side)], material);
    }

    fn mesh(&self, builder: &mut SceneBuilder, [a, u, v]: [DVec3; 3], material: u32) {
        if self.baked {
            let corners = [a, a + u, a + u + v, a + v].map(|p| self.at(p).as_vec3());
            let mesh = Mesh {
                positions: corners.to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            };
            builder.mesh("part", mesh, DAffine3::IDENTITY, material);
        } else {
            let own = quad(a.as_vec3() * Vec3::new(1.0, 0.0, 1.0), u.as_vec3(), v.as_vec3());
            let lift = DAffine3::from_translation(DVec3::Y * a.y);
            builder.mesh(
                "part",
                own,
                DAffine3::from_rotation_translation(self.turn, self.to) * lift,
                material,
            );
        }
    }

    fn put_lamp(&self, builder: &mut SceneBuilder) {
        let emitter = builder.material(matte(0.3, 5.0));
        let down = self.turn * -DVec3::Y;
        let centre = DVec3::new(0.1, 2.0, -0.05);
        match self.lamp {
            Lamp::Quad => {
                let corner = centre - DVec3::new(0.2, 0.0, 0.2);
                self.mesh(builder, [corner, DVec3::X * 0.4, DVec3::Z * 0.4], emitter);
            }
            Lamp::Triangle => {
                let corners = [(0.3, 0.02), (-0.1, -0.3), (-0.17, 0.31)];
                let positions = corners.map(|(x, z)| self.at(centre + DVec3::new(x, 0.0, z)).as_vec3());
                let mesh =
                    Mesh { positions: positions.to_vec(), triangles: vec![[0, 2, 1]], ..Mesh::default() };
                builder.mesh("lamp", mesh, DAffine3::IDENTITY, emitter);
            }
            Lamp::Disk => {
                builder.disk("lamp", self.at(centre), down, 0.25, emitter);
            }
            Lamp::Moving => {
                let mesh = quad(Vec3::new(-0.2, 0.0, -0.2), Vec3::X * 0.4, Vec3::Z * 0.4);
                let mut chain = slide(self.at(centre), self.at(centre + DVec3::new(0.3, 0.0, 0.1)));
                chain.push(dapple_math::motion::Node::Fixed(DAffine3::from_quat(self.turn)));
                builder.moving_mesh("lamp", mesh, chain, emitter);
            }
            Lamp::Point => builder.point_light(self.at(centre), Vec3::splat(3.0), f64::INFINITY),
            Lamp::Spot => {
                builder.spot_light(self.at(centre), down, Vec3::splat(3.0), f64::INFINITY, 0.5, 1.0);
            }
        }
    }

    fn builder(&self) -> SceneBuilder {
        let mut builder = SceneBuilder::new("test");
        builder.environment(Environment::constant(Vec3::ZERO));
        builder.exposure(AT, SHUTTER);
        let grey = match self.metal {
            true => builder.material(metal(Vec3::splat(0.9), 0.3)),
            false => builder.material(matte(0.8, 0.0)),
        };
        let black = builder.material(TexturedMaterial { double_sided: true, ..matte(0.0, 0.0) });
        self.level(&mut builder, 3.0, 2.0, true, black);
        self.level(&mut builder, 0.0, 1.0, false, grey);
        if self.lamp_first {
            self.put_lamp(&mut builder);
        }
        self.level(&mut builder, 2.0 + self.gap, 1.5, true, black);
        if !self.lamp_first {
            self.put_lamp(&mut builder);
        }
        builder
    }

    /// Looks at `target` from `from`, with a field of view so narrow that perspective is negligible.
    fn scene(&self, from: DVec3, target: DVec3, half_height: f32) -> Scene {
        let mut builder = self.builder();
        let up = self.turn * DVec3::Z;
        let pose = CameraPose::look_at(self.at(from), self.at(target), up, 1.0);
        builder.camera("camera", CameraPose { projection: Projection::Orthographic { half_height }, ..pose });
        builder.build().unwrap()
    }

    fn of_floor(&self) -> Scene {
        let from = if self.metal { DVec3::new(0.9, 1.5, 0.2) } else { DVec3::new(0.05, 1.0, 0.0) };
        self.scene(from, DVec3::new(-0.2, 0.0, 0.1), 0.1)
    }

    fn of_lamp(&self) -> Scene {
        // A region that the moving lamp covers all the time.
        let (centre, half_height) = match self.lamp {
            Lamp::Moving => (DVec3::new(0.25, 2.0, 0.0), 0.02),
            _ => (DVec3::new(0.1, 2.0, -0.05), 0.06),
        };
        self.scene(DVec3::new(-0.4, 0.3, 0.2), centre, half_height)
    }
}

fn turns() -> [DQuat; 4] {
    let turn = |axis: DVec3, angle: f64| {
        let (s, c) = libm::sincos(0.5 * angle);
        let v = axis.normalize() * s;
        DQuat::from_xyzw(v.x, v.y, v.z, c)
    };
    [
        DQuat::IDENTITY,
        turn(DVec3::new(1.0, 2.0, 3.0), 0.7),
        turn(DVec3::new(-1.0, 0.3, 0.2), 2.1),
        turn(DVec3::Z, 1.0471975511965976),
    ]
}

fn rooms() -> Vec<Room> {
    let mut all = Vec::new();
    for (i, turn) in turns().into_iter().enumerate() {
        for (baked, lamp_first) in [(false, false), (false, true), (true, false), (true, true)] {
            let to = if i == 2 { DVec3::new(30.0, -7.0, 12.0) } else { DVec3::ZERO };
            all.push(Room { turn, to, baked, lamp_first, ..Room::PLAIN });
        }
    }
    all
}

fn settings(method: MethodKind, spp: u32) -> Settings {
    let mut settings =
        Settings { size: (4, 4), pattern: Pattern::Random, max_bounces: 2, ..Settings::default() }
            .with_method(method)
            .with_threads(1)
            .with_spp(spp);
    settings.plans.light = SampleSet::new(2, Pattern::Random);
    settings.plans.pixel = SampleSet::new(spp, Pattern::Random);
    settings
}

fn pixels(outcome: &Outcome) -> Vec<f32> {
    assert_eq!(outcome.stats.bad_sample_count, 0);
    outcome.film.mean().pixels.iter().map(|p| p.x).collect()
}

/// Asserts that both images are equal up to rounding.
#[track_caller]
fn assert_same(what: &str, a: &Scene, b: &Scene, settings: &Settings) {
    let (a, b) = (pixels(&run(a, settings)), pixels(&run(b, settings)));
    let mean = b.iter().sum::<f32>() / b.len() as f32;
    assert!(mean > 0.0, "{what}: the image is black");
    for (i, (a, b)) in a.iter().zip(&b).enumerate() {
        assert!((a - b).abs() <= 2e-4 * mean, "{what}, pixel {i}: {a}, apart {b}");
    }
}

fn compare_with_raised_ceiling(method: MethodKind, change: impl Fn(&mut Settings)) {
    let mut settings = settings(method, 8);
    change(&mut settings);
    for room in rooms() {
        for lamp in LAMPS {
            for metal in [false, true] {
                let room = Room { lamp, metal, ..room };
                let raised = Room { gap: 1e-3, ..room }.of_floor();
                assert!(lamp == Lamp::Moving || raised.shared_places.is_none(), "{room:?}: nothing is near");
                let scene = room.of_floor();
                assert!(scene.shared_places.is_some(), "{room:?}");
                assert_same(&format!("{method:?} {room:?}"), &scene, &raised, &settings);
            }
        }
    }
}

#[test]
fn a_lamp_in_the_plane_of_a_ceiling_shines_as_below_it_on_paths() {
    compare_with_raised_ceiling(MethodKind::Path, |_| {});
}

#[test]
fn a_lamp_in_the_plane_of_a_ceiling_shines_as_below_it_in_the_distribution_tracer() {
    compare_with_raised_ceiling(MethodKind::Distribution, |settings| settings.max_bounces = 1);
}

#[test]
fn a_lamp_in_the_plane_of_a_ceiling_shines_as_below_it_from_its_centroid() {
    compare_with_raised_ceiling(MethodKind::Path, |settings| {
        *settings.plans.of_mut(Effect::Light) = SampleSet::OFF
    });
}

#[test]
fn a_lamp_in_the_plane_of_a_ceiling_has_no_speckle() {
    let settings = Settings { max_bounces: 0, size: (16, 16), ..settings(MethodKind::Path, 4) };
    for room in rooms() {
        for lamp in [Lamp::Quad, Lamp::Triangle, Lamp::Disk, Lamp::Moving] {
            let room = Room { lamp, ..room };
            for method in [MethodKind::Path, MethodKind::Distribution] {
                let seen = pixels(&run(&room.of_lamp(), &settings.clone().with_method(method)));
                assert!(seen.iter().all(|x| *x == 5.0), "{method:?} {room:?}: {seen:?}");
            }
        }
    }
}

/// From above: the back of the lamp and the ceiling; rays that hit back faces, such as those of light, see the object
/// that was added first.
#[test]
fn the_dark_side_is_decided_by_order() {
    for turn in turns() {
        for lamp_first in [false, true] {
            let room = Room { turn, lamp_first, ..Room::PLAIN };
            let scene = room.scene(DVec3::new(0.15, 2.5, 0.0), DVec3::new(0.1, 2.0, -0.05), 0.1);
            let settings = Settings {
                max_bounces: 0,
                backfaces: dapple_integrator::Backfaces::Shown,
                aovs: vec![dapple_integrator::Aov::ObjectId],
                ..settings(MethodKind::Path, 1)
            };
            let outcome = run(&scene, &settings);
            let seen = outcome.layers.layer("object").unwrap();
            let all: Vec<f32> = seen.channels.iter().flat_map(|c| c.1.clone()).collect();
            assert!(all.iter().all(|id| *id == 3.0), "{room:?}: {all:?}");
        }
    }
}

/// Copies of a lamp, with the same vertex order and in other orders: as separate objects, or in one mesh.
fn copies(lamp: Lamp, count: usize, sphere: bool) -> SceneBuilder {
    let mut builder = SceneBuilder::new("test");
    builder.environment(Environment::constant(Vec3::ZERO));
    builder.exposure(AT, SHUTTER);
    builder.camera("camera", CameraPose::look_at(DVec3::new(0.3, 1.0, 0.4), DVec3::ZERO, DVec3::Y, 0.4));
    let floor = builder.material(metal(Vec3::splat(0.7), 0.5));
    let emitter = builder.material(TexturedMaterial { double_sided: true, ..matte(0.4, 5.0) });
    builder.mesh(
        "floor",
        quad(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Z * -2.0),
        DAffine3::IDENTITY,
        floor,
    );
    let room = Room { lamp, turn: turns()[1], ..Room::PLAIN };
    for _ in 0..count {
        if sphere {
            builder.sphere("lamp", DVec3::new(0.2, 1.3, -0.1), 0.2, emitter);
        } else {
            room.put_lamp(&mut builder);
        }
    }
    builder
}

#[test]
fn lamps_in_one_place_shine_as_one() {
    for (lamp, sphere) in
        [(Lamp::Quad, true), (Lamp::Quad, false), (Lamp::Triangle, false), (Lamp::Disk, false)]
    {
        let [one, ten] = [1, 10].map(|n| copies(lamp, n, sphere).build().unwrap());
        assert_eq!((one.lights.len(), ten.lights.len()), (1, 1), "copies are no lights");
        assert!(ten.warnings.iter().any(|w| w.0.contains("9 lights lie in the place of another")));
        for method in [MethodKind::Path, MethodKind::Distribution] {
            let settings = settings(method, 16);
            let [a, b] = [&one, &ten].map(|scene| pixels(&run(scene, &settings)));
            assert_eq!(a, b, "{lamp:?} {method:?}");
        }
    }
}

/// Moving lights are not known to be covered: they are sampled in vain, and the estimate is unbiased.
#[test]
fn moving_lamps_in_one_place_shine_as_one() {
    let [one, three] = [1, 3].map(|n| copies(Lamp::Moving, n, false).build().unwrap());
    assert_eq!((one.lights.len(), three.lights.len()), (1, 3));
    // Each of the three lights has as many samples as the single one.
    let mut settings = Settings { size: (2, 2), max_bounces: 1, ..settings(MethodKind::Distribution, 4096) };
    let once = SampleSet::new(1, Pattern::Random);
    (settings.plans.time, settings.plans.glossy) = (once, once);
    let [a, b] = [&one, &three].map(|scene| {
        let pixels = pixels(&run(scene, &settings));
        f64::from(pixels.iter().sum::<f32>() / pixels.len() as f32)
    });
    assert!((a / b - 1.0).abs() < 0.02, "{a} {b}");
}

#[test]
fn an_unlit_panel_and_a_masked_lamp_do_not_win() {
    let unlit = TexturedMaterial { unlit: true, ..matte(0.5, 0.0) };
    let mut hole = matte(0.3, 5.0);
    hole.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    hole.alpha = 0.0;
    for (material, seen) in [(unlit, 1.0), (hole, 1.0), (matte(0.3, 5.0), 5.0)] {
        let mut builder = SceneBuilder::new("test");
        builder.environment(Environment::constant(Vec3::ZERO));
        builder.camera("camera", CameraPose::look_at(DVec3::new(0.1, 0.2, 2.0), DVec3::ZERO, DVec3::Y, 0.1));
        let wall = builder.material(TexturedMaterial { unlit: true, ..matte(1.0, 0.0) });
        let panel = builder.material(material);
        let square =
            |half: f32| quad(Vec3::new(-half, -half, 0.0), Vec3::X * (2.0 * half), Vec3::Y * (2.0 * half));
        let turn = DAffine3::from_mat3(DMat3::from_rotation_z(0.3));
        builder.mesh("wall", square(1.0), turn, wall);
        builder.mesh("panel", square(0.5), DAffine3::IDENTITY, panel);
        let pixels = pixels(&run(&builder.build().unwrap(), &settings(MethodKind::Path, 4)));
        assert!(pixels.iter().all(|x| *x == seen), "{pixels:?} for {seen}");
    }
}
