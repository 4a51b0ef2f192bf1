//! The render plan: the random decisions, kernel, data and buffers that a render uses, and what is omitted and why.
//!
//! The plan is derived from the same data that the render uses (`DimensionsUsed`, the kernel table, the survey), so
//! that it describes what actually happens.

use crate::culling::Backfaces;
use crate::effects::{Combine, Effect};
use crate::first_hit_sums::FirstHits;
use crate::job::Job;
use crate::kernel;
use crate::settings::{MethodKind, Settings};
use dapple_camera::Camera;
use dapple_lights::Light;
use dapple_materials::{Lobe, Lobes};
use dapple_scene::Scene;

/// A random decision, and the number of random numbers that it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// Name as in the table of dimensions.
    pub name: &'static str,
    /// Random numbers per decision.
    pub size: u32,
}

/// A feature that the render omits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The omitted feature.
    pub what: String,
    /// The reason why it is not needed.
    pub why: String,
}

/// The render plan. See [`plan`].
#[derive(Clone, Debug)]
pub struct RenderPlan {
    /// Kind of the integrator.
    pub method: MethodKind,
    /// Names of the sample kernel and the traversal kernel.
    pub kernel: String,
    /// Decisions drawn once per camera ray.
    pub camera: Vec<Decision>,
    /// Decisions drawn at every vertex (roulette from the fourth on).
    pub bounce: Vec<Decision>,
    /// Lobes of the surfaces in the scene.
    pub lobes: Vec<&'static str>,
    /// How direct light is sampled.
    pub lights: String,
    /// Structure of the ray acceleration.
    pub geometry: String,
    /// Bytes of the acceleration structure per triangle; 0 without triangles.
    pub bytes_per_triangle: f64,
    /// Bytes of film and layers per pixel.
    pub bytes_per_pixel: usize,
    /// Bytes of the scene.
    pub scene_bytes: usize,
    /// Omitted features.
    pub left_out: Vec<LeftOut>,
}

/// Bytes per pixel of the film: means and squared deviations of three channels and a count, in f64, if the number of
/// samples is a power of two. Other numbers take up to 48 bytes more for every further bit that is set in them.
const FILM_BYTES: usize = 56;

/// The plan of a render with these settings.
pub fn plan(scene: &Scene, camera: &Camera, settings: &Settings) -> RenderPlan {
    let job = Job::new(scene, camera, settings);
    let (_, name) = kernel::choose(&job);
    let bounds = scene.lobe_bounds();
    let watched = name.contains("first-hit");
    let triangles = scene.survey.triangles;
    RenderPlan {
        method: settings.kind(),
        kernel: format!("{name}/{}", scene.accel.kernel().name()),
        camera: camera_decisions(&job),
        bounce: bounce_decisions(&job),
        lobes: lobes(&bounds),
        lights: lights(&job),
        geometry: geometry(scene),
        bytes_per_triangle: scene.accel.memory_bytes() as f64 / triangles.max(1) as f64,
        bytes_per_pixel: FILM_BYTES + FirstHits::bytes_per_pixel(settings),
        scene_bytes: scene.memory_bytes(),
        left_out: left_out(&job, &bounds, watched),
    }
}

fn chosen(all: &[(bool, &'static str, u32)]) -> Vec<Decision> {
    all.iter().filter(|(there, ..)| *there).map(|&(_, name, size)| Decision { name, size }).collect()
}

fn camera_decisions(job: &Job<'_>) -> Vec<Decision> {
    let n = &job.needs;
    chosen(&[(n.pixel, "pixel", 2), (n.lens, "lens", 2), (n.time, "time", 1)])
}

fn bounce_decisions(job: &Job<'_>) -> Vec<Decision> {
    let n = &job.needs;
    let path = job.settings.kind() == MethodKind::Path;
    let sky = job.has_no_interreflection() && job.scene.environment.is_some();
    chosen(&[
        (n.lobe && path, "lobe", 1),
        (n.direction, "direction", 2),
        (n.next_event && n.light_choice && path, "light choice", 1),
        (n.next_event && n.light_point, "light point", 2),
        (sky, "sky", 2),
        (n.roulette && path, "roulette", 1),
    ])
}

fn lobes(bounds: &[Lobes]) -> Vec<&'static str> {
    let of = |kind: Lobes| bounds.iter().map(move |lobes| lobes.and(kind)).filter(|lobes| !lobes.is_empty());
    let smooth = |kind| of(kind).any(|lobes| !lobes.spreads());
    let rough = |kind| of(kind).any(Lobes::spreads);
    [
        (rough(Lobes::of(Lobe::Diffuse)), "diffuse"),
        (smooth(Lobes::REFLECTION), "smooth reflection"),
        (rough(Lobes::REFLECTION), "rough reflection"),
        (smooth(Lobes::TRANSMISSION), "smooth transmission"),
        (rough(Lobes::TRANSMISSION), "rough transmission"),
    ]
    .into_iter()
    .filter(|(there, _)| *there)
    .map(|(_, name)| name)
    .collect()
}

fn lights(job: &Job<'_>) -> String {
    let through = match (job.needs.next_event && job.clear_ways, job.settings.transparent_shadows) {
        (false, _) => "",
        (true, false) => "; shadow rays pass smooth thin walls and boundaries between equal indices",
        (true, true) => {
            "; shadow rays pass all smooth transparent surfaces in a straight line (approximation)"
        }
    };
    aimed(job) + through
}

fn aimed(job: &Job<'_>) -> String {
    let count = job.scene.lights.len();
    match (job.needs.next_event, job.settings.kind()) {
        (false, _) => "BSDF sampling only".into(),
        (true, MethodKind::Distribution) => format!("each of {count} lights sampled"),
        (true, MethodKind::Path) if !job.needs.light_choice => "the only light sampled".into(),
        (true, MethodKind::Path) => {
            format!("one of {count} lights sampled, chosen by estimated contribution")
        }
    }
}

fn geometry(scene: &Scene) -> String {
    match scene.accel.second_level() {
        0 => "one flat BVH".into(),
        n => format!("one flat BVH, with {n} shapes, instances or moving objects in a second level"),
    }
}

/// Omitted features, in the order of the output.
#[derive(Default)]
struct Omissions(Vec<LeftOut>);

impl Omissions {
    /// Adds `what`, unless the render has it.
    fn unless(&mut self, is_there: bool, what: &str, why: &str) {
        if !is_there {
            self.0.push(LeftOut { what: what.into(), why: why.into() });
        }
    }

    /// Adds the omitted features of camera rays.
    fn of_the_camera(&mut self, job: &Job<'_>) {
        let off = |effect| job.settings.plans.is_off(effect);
        let why = |effect, else_: &'static str| if off(effect) { "switched off" } else { else_ };
        let n = &job.needs;
        let only = "only layers of the first hit are requested";
        self.unless(job.settings.picture, "image and light transport", only);
        self.unless(n.pixel, "pixel dimension", "switched off");
        self.unless(n.lens, "lens dimension", why(Effect::Lens, "the camera is a pinhole"));
        self.unless(n.time, "time dimension", why(Effect::Time, "nothing moves while the shutter is open"));
        let second = job.scene.accel.second_level() > 0;
        self.unless(second, "second level of the BVH", "no shapes, instances or moving objects");
        self.unless(job.camera.clip.is_some(), "near and far plane", "no surface lies outside of them");
        let shown = match job.settings.backfaces {
            Backfaces::Camera => "every surface is double-sided or transmissive",
            Backfaces::Shown => "back faces are shown",
            Backfaces::Culled => "back faces are culled for all rays",
        };
        self.unless(job.hides_backs, "hidden back faces", shown);
    }

    /// Adds the decisions at vertices that are not drawn.
    fn of_decisions(&mut self, job: &Job<'_>, bounds: &[Lobes]) {
        let n = &job.needs;
        let is_path = job.settings.kind() == MethodKind::Path;
        self.unless(job.asks_alpha(), "alpha tests", "every surface is opaque");
        self.unless(n.next_event, "next-event estimation and its dimensions", no_next_event(job, bounds));
        if n.next_event && is_path {
            self.unless(
                n.light_choice,
                "light-choice dimension, light tree",
                "there is only one light to sample",
            );
        }
        if n.next_event {
            self.unless(n.light_point, "light-point dimension", "every light is a point");
        }
        if is_path {
            self.unless(n.lobe, "lobe dimension", "every surface has one lobe");
            let why = "paths end before roulette begins, or it is switched off";
            self.unless(n.roulette, "roulette dimension", why);
        }
        let why = "all surfaces are specular, or no light is scattered";
        self.unless(n.direction, "direction dimension", why);
    }

    /// Adds the features that the scene does not have.
    fn of_the_scene(&mut self, job: &Job<'_>) {
        let survey = &job.scene.survey;
        self.unless(
            job.scene.shared_places.is_some(),
            "resolution of coincident surfaces",
            "no surfaces or lights coincide such that the order matters",
        );
        self.unless(
            !job.media.is_empty(),
            "media and overlapping bodies",
            "no object has an interior medium",
        );
        self.unless(survey.has_transmission, "transmission", "no surface transmits light");
        self.unless(survey.has_textures, "textures, texture coordinates", "no material uses a texture");
        self.unless(survey.has_normal_maps, "tangents", "no normal maps");
        let environment = job.scene.environment.map(|i| &job.scene.lights[i as usize]);
        let has_table = matches!(environment, Some(Light::Environment(e)) if !e.is_constant());
        let why =
            if environment.is_some() { "the environment is constant" } else { "there is no environment" };
        self.unless(has_table, "environment tables", why);
    }
}

fn left_out(job: &Job<'_>, bounds: &[Lobes], watched: bool) -> Vec<LeftOut> {
    let mut all = Omissions::default();
    all.of_the_camera(job);
    all.of_decisions(job, bounds);
    all.of_the_scene(job);
    all.unless(watched, "first-hit buffers", "no layer needs them");
    let is_paired = job.settings.combine() == Combine::Paired;
    all.unless(is_paired, "pairing of strata", "integrals are nested, or there is only one");
    all.0.extend(unread(job.scene));
    all.0
}

fn no_next_event(job: &Job<'_>, bounds: &[Lobes]) -> &'static str {
    if job.bounces == 0 {
        "no light is scattered"
    } else if job.scene.light_choice.is_none() {
        "no light benefits from light sampling"
    } else if !bounds.iter().any(|lobes| lobes.spreads()) {
        "all surfaces are specular"
    } else {
        "every light is black"
    }
}

fn unread(scene: &Scene) -> Vec<LeftOut> {
    let (unread, survey) = (&scene.survey.unread, &scene.survey);
    [
        (unread.nodes, "nodes", "not in the rendered scene, or hidden"),
        (unread.meshes, "meshes, not read", "no node of the rendered scene uses them"),
        (unread.materials, "materials, not read", "no surface uses them"),
        (unread.images, "images, not decoded", "no material of the scene uses them in this render"),
        (survey.constant_textures, "textures, replaced by factors", "they are constant"),
        (
            survey.dropped_channels,
            "texture channels, not kept",
            "no material reads them, or they are redundant",
        ),
    ]
    .into_iter()
    .filter(|(count, ..)| *count > 0)
    .map(|(count, what, why)| LeftOut { what: format!("{count} {what}"), why: why.into() })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dimension;
    use crate::sample::drawn;
    use dapple_geometry::Mesh;
    use dapple_scene::{CameraPose, SceneBuilder, TexturedMaterial};
    use glam::{DAffine3, DVec3, Vec3};

    fn quad(a: Vec3, u: Vec3, v: Vec3) -> Mesh {
        Mesh {
            positions: vec![a, a + u, a + u + v, a + v],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }
    }

    /// A Lambertian floor and wall under one quad light, seen through a pinhole, without motion.
    fn plain() -> Scene {
        let mut builder = SceneBuilder::new("plain");
        builder.camera("eye", CameraPose::look_at(DVec3::new(0.0, 1.0, 3.0), DVec3::ZERO, DVec3::Y, 0.8));
        let grey = builder.material(TexturedMaterial::lambert("grey", Vec3::splat(0.5)));
        let bright = builder.material(TexturedMaterial::emitter("light", Vec3::splat(4.0)));
        let floor = quad(Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::Z * -4.0);
        builder.mesh("floor", floor, DAffine3::IDENTITY, grey);
        let wall = quad(Vec3::new(-2.0, 0.0, -2.0), Vec3::X * 4.0, Vec3::Y * 3.0);
        builder.mesh("wall", wall, DAffine3::IDENTITY, grey);
        let light = quad(Vec3::new(-0.5, 2.5, -0.5), Vec3::X, Vec3::Z);
        builder.mesh("light", light, DAffine3::IDENTITY, bright);
        builder.build().unwrap()
    }

    fn names(decisions: &[Decision]) -> Vec<&'static str> {
        decisions.iter().map(|d| d.name).collect()
    }

    #[test]
    fn a_path_draws_exactly_what_the_plan_lists() {
        let scene = plain();
        let camera = &scene.cameras[0].camera;
        let settings = Settings { size: (16, 16), ..Settings::default() };
        let plan = plan(&scene, camera, &settings);
        assert_eq!(names(&plan.camera), ["pixel"]);
        assert_eq!(names(&plan.bounce), ["direction", "light point", "roulette"]);
        let mut seen = std::collections::HashSet::new();
        for i in 0..256 {
            drawn::take();
            crate::replay(&scene, camera, &settings, (i % 16, i / 16), 0);
            let all = drawn::take();
            let mut once = all.clone();
            once.sort_by_key(|(depth, d)| (*depth, *d as u32));
            once.dedup();
            assert_eq!(once.len(), all.len(), "nothing is drawn twice");
            for (depth, dimension) in all {
                let listed = match dimension {
                    Dimension::Pixel => depth == 0,
                    Dimension::Direction | Dimension::LightPoint => true,
                    Dimension::Roulette => depth >= crate::settings::ROULETTE_FROM,
                    _ => false,
                };
                assert!(listed, "{dimension:?} at {depth}");
                seen.insert(dimension);
            }
        }
        assert_eq!(seen.len(), 4, "{seen:?}");
    }

    #[test]
    fn the_general_plan_draws_all() {
        let scene = plain();
        let settings = Settings { size: (16, 16), general: true, ..Settings::default() };
        let plan = plan(&scene, &scene.cameras[0].camera, &settings);
        assert_eq!(names(&plan.camera), ["pixel", "lens", "time"]);
        assert_eq!(names(&plan.bounce), ["lobe", "direction", "light choice", "light point", "roulette"]);
    }

    #[test]
    fn what_is_left_out_has_a_reason() {
        let scene = plain();
        let camera = &scene.cameras[0].camera;
        let seen = plan(&scene, camera, &Settings { max_bounces: 0, ..Settings::default() });
        assert!(seen.bounce.is_empty(), "{:?}", seen.bounce);
        let event = seen.left_out.iter().find(|l| l.what.starts_with("next-event")).unwrap();
        assert_eq!(event.why, "no light is scattered");
    }
}
