//! Scenes built in code: add things in world space, f64; `build` recentres, rescales, finds lights, checks.
use crate::{
    AlphaMode, NamedCamera, Object, Placement, Scene, SceneError, Space, Survey, TexturedMaterial, Unread,
    Warning, bake, constants,
    emission::{AreaLights, Emitter, Form, Movement},
    framing,
    moving::{self, Body, Exposure, OwnSpaces},
    punctual,
    punctual::Punctual,
    scene, tangent,
};
use dapple_camera::{Camera, Projection, camera::axes};
use dapple_geometry::{
    Mesh, World, WorldBuilder,
    motion::Node,
    shapes::{Disk, Sphere},
};
use dapple_imaging::Texture;
use dapple_lights::{Environment, Light, LightChoice};
use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use std::sync::Arc;

/// Most triangles a scene may have once every instance is placed; what lies above would not fit into memory anyway.
const MAX_TRIANGLES: usize = 1 << 27;
/// World coordinates beyond this are taken for errors; f64 arithmetic on them stays finite.
const FARTHEST: f64 = 1e300;

/// Collects the parts of a scene. Indices returned count from zero in the order of addition.
#[derive(Debug, Default)]
pub struct SceneBuilder {
    name: String,
    /// What errors call the scene: its file, else its name.
    label: String,
    textures: Vec<Texture>,
    materials: Vec<TexturedMaterial>,
    placed: Vec<Placed>,
    /// With the chain of nodes that moves it, if one does.
    pub(crate) punctual: Vec<(Punctual, Option<Vec<Node>>)>,
    environment: Option<Environment>,
    /// Likewise.
    pub(crate) cameras: Vec<(String, CameraPose, Option<Vec<Node>>)>,
    pub(crate) exposure: Exposure,
    warnings: Vec<Warning>,
    unread: Unread,
    /// Keep attributes that nothing looks at.
    everything: bool,
}

/// An object in the world.
#[derive(Debug)]
struct Placed {
    name: String,
    material: u32,
    geometry: Geometry,
}

#[derive(Debug)]
pub(crate) enum Geometry {
    Mesh { mesh: Arc<Mesh>, placement: Placement },
    Sphere { centre: DVec3, radius: f64 },
    Disk { centre: DVec3, normal: DVec3, radius: f64 },
    Moving { body: Body, chain: Vec<Node> },
}

/// What an object looks like to a light, and how it moves if it does.
type Seen = (Form, Option<Movement>);

/// A camera in world space: looks along the −z of its transform, +y up; scale and shear of the transform are ignored.
#[derive(Clone, Copy, Debug)]
pub struct CameraPose {
    /// Camera to world.
    pub transform: DAffine3,
    /// Perspective or orthographic (half height in world units).
    pub projection: Projection,
    /// Width / height asked for.
    pub aspect: Option<f32>,
}

impl CameraPose {
    /// A perspective camera at `from` that looks at `at` with `up` upwards and spans `yfov` radians from bottom to
    /// top.
    pub fn look_at(from: DVec3, at: DVec3, up: DVec3, yfov: f64) -> Self {
        let backward = (from - at).normalize_or(DVec3::Z);
        let right = up.cross(backward).normalize_or(backward.any_orthonormal_vector());
        let axes = DMat3::from_cols(right, backward.cross(right), backward);
        Self {
            transform: DAffine3 { matrix3: axes, translation: from },
            projection: Projection::Perspective { tan_half: libm::tan(yfov * 0.5) as f32 },
            aspect: None,
        }
    }
}

impl SceneBuilder {
    /// An empty scene; `name` is what pictures of it are called.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), label: name.to_owned(), ..Self::default() }
    }

    /// An empty scene whose errors name `file`.
    #[cfg(feature = "gltf")]
    pub(crate) fn from_file(name: &str, file: &std::path::Path) -> Self {
        Self { name: name.to_owned(), label: file.display().to_string(), ..Self::default() }
    }

    /// What the file holds beyond the scene, and whether to keep `everything` of what was read.
    #[cfg(feature = "gltf")]
    pub(crate) fn leave_unread(&mut self, unread: Unread, everything: bool) {
        (self.unread, self.everything) = (unread, everything);
    }

    /// Adds a texture; returns its index.
    pub fn texture(&mut self, texture: Texture) -> u32 {
        self.textures.push(texture);
        self.textures.len() as u32 - 1
    }

    /// Adds a material (absorption per world unit); returns its index.
    pub fn material(&mut self, material: TexturedMaterial) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// A material added before.
    #[cfg(feature = "gltf")]
    pub(crate) fn material_at(&self, index: u32) -> &TexturedMaterial {
        &self.materials[index as usize]
    }

    /// Adds a mesh placed by `transform`; returns the object's index. A shared mesh (`Arc`) may be added many times.
    pub fn mesh(
        &mut self,
        name: &str,
        mesh: impl Into<Arc<Mesh>>,
        transform: impl Into<Placement>,
        material: u32,
    ) -> u32 {
        self.place(name, material, Geometry::Mesh { mesh: mesh.into(), placement: transform.into() })
    }

    /// Adds an exact sphere, front side outwards; returns the object's index.
    pub fn sphere(&mut self, name: &str, centre: DVec3, radius: f64, material: u32) -> u32 {
        self.place(name, material, Geometry::Sphere { centre, radius })
    }

    /// Adds an exact disk whose front side faces `normal`; returns the object's index.
    pub fn disk(&mut self, name: &str, centre: DVec3, normal: DVec3, radius: f64, material: u32) -> u32 {
        self.place(name, material, Geometry::Disk { centre, normal, radius })
    }

    pub(crate) fn place_moving(&mut self, name: &str, material: u32, body: Body, chain: Vec<Node>) -> u32 {
        self.place(name, material, Geometry::Moving { body, chain })
    }

    fn place(&mut self, name: &str, material: u32, geometry: Geometry) -> u32 {
        self.placed.push(Placed { name: name.to_owned(), material, geometry });
        self.placed.len() as u32 - 1
    }

    /// Adds a point light of `intensity` in W/sr per channel that ends at `range` world units (infinite: never).
    pub fn point_light(&mut self, p: DVec3, intensity: Vec3, range: f64) {
        self.punctual.push((Punctual::Point { p, intensity, range }, None));
    }

    /// Adds a spot light along `axis`; `inner` and `outer` are the cone's half angles in radians.
    pub fn spot_light(&mut self, p: DVec3, axis: DVec3, intensity: Vec3, range: f64, inner: f64, outer: f64) {
        self.punctual.push((Punctual::Spot { p, axis, intensity, range, inner, outer }, None));
    }

    /// Adds a light in the direction `towards`; `irradiance` in W/m² per channel on a surface that faces it.
    pub fn distant_light(&mut self, towards: DVec3, irradiance: Vec3) {
        self.punctual.push((Punctual::Distant { towards, irradiance }, None));
    }

    /// Sets what surrounds the scene; replaces an earlier one. A constant black one is "nothing, on purpose".
    pub fn environment(&mut self, environment: Environment) {
        self.environment = Some(environment);
    }

    /// Whether an environment has been set.
    pub fn has_environment(&self) -> bool {
        self.environment.is_some()
    }

    /// Adds a camera; the first one is the default.
    pub fn camera(&mut self, name: &str, pose: CameraPose) {
        self.cameras.push((name.to_owned(), pose, None));
    }

    /// Adds something to tell the user.
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// Checks everything and moves it to render space. Adds a framing camera when there is none, a white environment
    /// (with a warning) when nothing emits.
    ///
    /// # Errors
    /// The first thing that is wrong: a number that is not finite, an index out of range, attribute lengths that
    /// disagree, a radius that is not positive, a camera or light without direction.
    pub fn build(mut self) -> Result<Scene, SceneError> {
        self.check()?;
        self.settle();
        let constant_textures = constants::fold(&mut self.materials, &mut self.textures);
        let bounds = self.bounds()?;
        let space = bounds.map_or(Space::IDENTITY, |(min, max)| Space::fit(min, max));
        self.simplify_alpha();
        let mut cameras = self.cameras(&space)?;
        let mut lights = punctual::lights(&self.punctual, &space, &self.exposure)
            .map_err(|(i, what)| self.invalid(format!("light {i}"), what))?;
        let (world, mut objects, forms) = self.world(&space)?;
        if cameras.is_empty() {
            let counts = forms.iter().map(|form| form.0.triangles()).collect();
            let camera = framing::frame(&world, counts).in_render_space(&Space::IDENTITY);
            let camera = camera.map_err(|what| self.invalid("camera 'auto'", what))?;
            cameras.push(NamedCamera { name: "auto".into(), camera, aspect: None });
        }
        let Exposure { at, shutter } = self.exposure;
        let Self { name, textures, mut materials, environment, mut warnings, unread, .. } = self;
        for m in &mut materials {
            m.sigma_a = (m.sigma_a.as_dvec3() / space.scale).as_vec3();
        }
        let mut area = AreaLights::default();
        for (i, (object, (form, movement))) in objects.iter_mut().zip(&forms).enumerate() {
            let material = &materials[object.material as usize];
            let emitter = Emitter { world: &world, textures: &textures, material };
            area.add(&emitter, i as u32, *form, movement.as_ref());
            object.first_light = area.first(i as u32, form.primitives());
        }
        lights.splice(0..0, area.lights.drain(..));
        let shown = objects.iter().all(|o| materials[o.material as usize].unlit) && !objects.is_empty();
        let environment = environment.or_else(|| {
            (lights.is_empty() && !shown).then(|| {
                warnings.push(Warning(
                    "nothing in the scene emits light: a white environment of radiance 1 surrounds it".into(),
                ));
                Environment::constant(Vec3::ONE)
            })
        });
        let environment = environment.filter(|e| !(e.is_constant() && e.mean() == Vec3::ZERO)).map(|e| {
            lights.push(Light::Environment(e));
            lights.len() as u32 - 1
        });
        let radius = bounds.map_or(1.0, |(min, max)| space.length_to_render((max - min).length() * 0.5));
        let mut survey = Survey {
            triangles: world.triangle_count(),
            objects: objects.len(),
            shapes: forms.iter().filter(|(form, _)| !matches!(form, Form::Triangles(_))).count(),
            materials: materials.len(),
            textures: textures.len(),
            lights: lights.len(),
            has_motion: world.has_motion()
                || lights.iter().any(|light| matches!(light, Light::Moving(_)))
                || moving::any_moves(cameras.iter().map(|c| &c.camera)),
            constant_textures,
            unread,
            ..Survey::default()
        };
        scene::survey(&objects, &materials, &mut survey);
        let light_choice = LightChoice::new(&lights, radius);
        Ok(Scene {
            name,
            space,
            world,
            objects,
            materials,
            textures,
            lights,
            light_choice,
            environment,
            cameras,
            at,
            shutter,
            survey,
            warnings,
            area,
        })
    }

    /// What hangs on a chain but stands still while the shutter is open becomes a thing that stands still.
    fn settle(&mut self) {
        let exposure = self.exposure;
        for placed in &mut self.placed {
            if let Geometry::Moving { body, chain } = &placed.geometry
                && !exposure.is_moving(&exposure.motion(chain, &Space::IDENTITY))
            {
                placed.geometry = body.standing(&exposure.placement(chain));
            }
        }
    }

    fn invalid(&self, place: impl Into<String>, what: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.label, place, what)
    }

    fn check(&self) -> Result<(), SceneError> {
        for (i, m) in self.materials.iter().enumerate() {
            let place = || format!("material {i} '{}'", m.name);
            if let Some(factor) = m.bad_factor() {
                return Err(self.invalid(place(), format!("{factor} must be finite and not negative")));
            }
            if m.textures().any(|t| t.texture as usize >= self.textures.len() || t.uv_set > 1) {
                return Err(self.invalid(place(), "uses a texture or a set of coordinates that is not there"));
            }
        }
        let mut triangles = 0_usize;
        for (i, placed) in self.placed.iter().enumerate() {
            let fault = placed.fault(self.materials.len());
            if let Some(what) = fault {
                return Err(self.invalid(format!("object {i} '{}'", placed.name), what));
            }
            triangles += placed.form().primitives();
        }
        if triangles > MAX_TRIANGLES {
            let what = format!("has {triangles} triangles; at most {MAX_TRIANGLES} fit");
            return Err(self.invalid("the scene", what));
        }
        Ok(())
    }

    /// World box of everything that can be hit, when the shutter opens: a thing that then flies off changes nothing about
    /// the space the rest is rendered in.
    fn bounds(&self) -> Result<Option<(DVec3, DVec3)>, SceneError> {
        let mut all: Option<(DVec3, DVec3)> = None;
        for (i, placed) in self.placed.iter().enumerate() {
            let Some((min, max)) = placed.bounds(&self.exposure) else { continue };
            if !(min.min_element() >= -FARTHEST && max.max_element() <= FARTHEST) {
                let what = "is placed beyond every number dapple can work with";
                return Err(self.invalid(format!("object {i} '{}'", placed.name), what));
            }
            all = Some(all.map_or((min, max), |(a, b)| (a.min(min), b.max(max))));
        }
        Ok(all)
    }

    /// Masks and blends that let nothing through become opaque: traversal need not ask.
    fn simplify_alpha(&mut self) {
        let covers = |m: &TexturedMaterial| {
            let cutoff = match m.alpha_mode {
                AlphaMode::Opaque => return false,
                AlphaMode::Mask { cutoff } => cutoff,
                AlphaMode::Blend => 1.0,
            };
            let texture = m.base_color_texture.as_ref().map(|t| &self.textures[t.texture as usize]);
            m.alpha >= 1.0 && cutoff <= 1.0 && texture.is_none_or(|t| t.mean().w >= 1.0)
        };
        let mut solid: Vec<bool> = self.materials.iter().map(covers).collect();
        for placed in &self.placed {
            let solid = &mut solid[placed.material as usize];
            if let (true, Some(mesh)) = (*solid, placed.mesh()) {
                *solid = mesh.colors.iter().all(|c| c.w >= 1.0);
            }
        }
        for (material, _) in self.materials.iter_mut().zip(solid).filter(|(_, solid)| *solid) {
            material.alpha_mode = AlphaMode::Opaque;
        }
    }

    /// Moves the objects into the world.
    fn world(&mut self, space: &Space) -> Result<(World, Vec<Object>, Vec<Seen>), SceneError> {
        let mut world = WorldBuilder::default();
        let (mut objects, mut forms) = (Vec::new(), Vec::new());
        let (mut dropped, mut mended, mut own) = (0, 0, OwnSpaces::default());
        for (i, placed) in std::mem::take(&mut self.placed).into_iter().enumerate() {
            let material = &self.materials[placed.material as usize];
            let form = match placed.geometry {
                Geometry::Mesh { mesh, placement } => {
                    let baked = bake::bake(&mesh, &placement, space);
                    drop(mesh);
                    dropped += baked.dropped;
                    mended += baked.mended;
                    let mesh = for_material(baked.mesh, material, self.everything);
                    let form = Form::Triangles(mesh.triangles.len());
                    world.add_mesh(mesh);
                    form
                }
                Geometry::Sphere { centre, radius } => {
                    let (centre, radius) = (space.to_render(centre), space.length_to_render(radius));
                    world.add_sphere(Sphere { centre, radius });
                    Form::Sphere { centre, radius }
                }
                Geometry::Disk { centre, normal, radius } => {
                    let (centre, radius) = (space.to_render(centre), space.length_to_render(radius));
                    let normal = normal.normalize().as_vec3();
                    world.add_disk(Disk { centre, normal, radius });
                    Form::Disk { centre, normal, radius }
                }
                Geometry::Moving { body, chain } => {
                    let shared = own.get(&body, placed.material, material);
                    dropped += shared.as_ref().map_or(0, |own| own.dropped);
                    mended += shared.as_ref().map_or(0, |own| own.mended);
                    let entered = self.exposure.enter(&mut world, &body, chain, shared, space);
                    let (form, movement) = entered.map_err(|what| {
                        SceneError::invalid(&self.label, format!("object {i} '{}'", placed.name), what)
                    })?;
                    forms.push((form, Some(movement)));
                    objects.push(Object {
                        name: placed.name,
                        material: placed.material,
                        first_light: u32::MAX,
                    });
                    continue;
                }
            };
            forms.push((form, None));
            objects.push(Object { name: placed.name, material: placed.material, first_light: u32::MAX });
        }
        if dropped > 0 {
            self.warn(Warning(format!("{dropped} triangles without area are left out")));
        }
        if mended > 0 {
            self.warn(Warning(format!(
                "{mended} texture coordinates or vertex colours are not usable numbers: zero or white instead"
            )));
        }
        let seconds = self.exposure.shutter.seconds();
        Ok((world.build_for(0.0, seconds), objects, forms))
    }

    fn cameras(&self, space: &Space) -> Result<Vec<NamedCamera>, SceneError> {
        let convert = |(i, (name, pose, chain)): (usize, &(String, CameraPose, Option<Vec<Node>>))| {
            let mut pose = *pose;
            let motion = chain.as_ref().and_then(|c| self.exposure.camera(c, &pose.transform, space));
            if let Some(chain) = chain {
                pose.transform = DAffine3::from(self.exposure.placement(chain)) * pose.transform;
            }
            let camera = pose
                .in_render_space(space)
                .map_err(|what| self.invalid(format!("camera {i} '{name}'"), what))?;
            Ok(NamedCamera { name: name.clone(), camera: Camera { motion, ..camera }, aspect: pose.aspect })
        };
        self.cameras.iter().enumerate().map(convert).collect()
    }
}

/// Tangents only where a normal map needs them: generated if missing, dropped if useless; white vertex colours are
/// none. `everything` keeps what a file gives.
pub(crate) fn for_material(mut mesh: Mesh, material: &TexturedMaterial, everything: bool) -> Mesh {
    if !everything && mesh.colors.iter().all(|c| *c == Vec4::ONE) {
        mesh.colors = Vec::new();
    }
    match &material.normal_texture {
        None if everything => mesh,
        None => {
            mesh.tangents = Vec::new();
            mesh
        }
        // Tangents of a file that gives no normals do not count (glTF 2.0 §3.7.2.1).
        Some(map) if mesh.tangents.is_empty() || mesh.normals.is_empty() => {
            mesh.tangents = Vec::new();
            tangent::with_tangents(mesh, map)
        }
        Some(_) => mesh,
    }
}

impl CameraPose {
    fn in_render_space(&self, space: &Space) -> Result<Camera, &'static str> {
        let Some((right, up, backward)) = axes(&self.transform.matrix3) else {
            return Err("has no direction of view: its transform is singular or not finite");
        };
        let origin = space.to_render(self.transform.translation);
        let projection = match self.projection {
            Projection::Orthographic { half_height } => {
                Projection::Orthographic { half_height: space.length_to_render(f64::from(half_height)) }
            }
            perspective @ Projection::Perspective { .. } => perspective,
        };
        let (Projection::Perspective { tan_half: extent } | Projection::Orthographic { half_height: extent }) =
            projection;
        if !origin.is_finite() {
            return Err("is not at a place that numbers can express");
        }
        if !(extent > 0.0 && extent.is_finite()) {
            return Err("must span an angle between 0 and 180 degrees, or a height above 0");
        }
        Ok(Camera {
            origin,
            right: right.as_vec3(),
            up: up.as_vec3(),
            backward: backward.as_vec3(),
            projection,
            lens: None,
            motion: None,
        })
    }
}

impl Placed {
    fn form(&self) -> Form {
        match &self.geometry {
            Geometry::Mesh { mesh, .. } => Form::Triangles(mesh.triangles.len()),
            Geometry::Sphere { .. } => Form::Sphere { centre: Vec3::ZERO, radius: 1.0 },
            Geometry::Disk { .. } => Form::Disk { centre: Vec3::ZERO, normal: Vec3::Z, radius: 1.0 },
            Geometry::Moving { body, .. } => body.form(),
        }
    }

    fn mesh(&self) -> Option<&Mesh> {
        match &self.geometry {
            Geometry::Mesh { mesh, .. } | Geometry::Moving { body: Body::Mesh(mesh), .. } => Some(mesh),
            _ => None,
        }
    }

    /// What is wrong with the object, in words.
    fn fault(&self, materials: usize) -> Option<String> {
        if self.material as usize >= materials {
            return Some(format!("uses material {} of {materials}", self.material));
        }
        match &self.geometry {
            Geometry::Mesh { placement, .. } if !placement.is_finite() => {
                Some("its transform is not finite".into())
            }
            Geometry::Mesh { mesh, .. } | Geometry::Moving { body: Body::Mesh(mesh), .. } => {
                bake::fault(mesh)
            }
            Geometry::Moving { body, .. } => {
                let bad = body.radius().is_some_and(|radius| !(radius > 0.0 && radius.is_finite()));
                bad.then(|| "its radius must be finite and above 0".into())
            }
            Geometry::Sphere { centre, radius } | Geometry::Disk { centre, radius, .. }
                if !(centre.is_finite() && *radius > 0.0 && radius.is_finite()) =>
            {
                Some("its radius must be finite and above 0, and its centre finite".into())
            }
            Geometry::Disk { normal, .. } if normal.try_normalize().is_none() => {
                Some("its normal has no direction".into())
            }
            _ => None,
        }
    }

    /// In the world, when the shutter opens.
    fn bounds(&self, exposure: &Exposure) -> Option<(DVec3, DVec3)> {
        match &self.geometry {
            Geometry::Moving { body, chain } => body.bounds(&exposure.placement(chain)),
            Geometry::Mesh { mesh, placement } => bake::bounds(mesh, placement),
            // The disk's box is taken as the sphere's: an *approximation* that only makes render space a little
            // roomier.
            Geometry::Sphere { centre, radius } | Geometry::Disk { centre, radius, .. } => {
                Some((*centre - DVec3::splat(*radius), *centre + DVec3::splat(*radius)))
            }
        }
    }
}
