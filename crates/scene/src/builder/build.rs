//! Building of the scene: conversion of objects, cameras and lights to render space, light detection, and statistics.
use super::{CameraPose, Geometry, SceneBuilder, placed::Placed};
use crate::{
    AlphaMode, NamedCamera, Object, Scene, SceneError, SharedPlaces, Space, Survey, TexturedMaterial,
    Warning, WorldPoint,
    attributes::for_material,
    bake,
    bodies::Finder,
    channels,
    coincident::Kind,
    constants,
    emission::AreaLights,
    error::quoted,
    form::{Form, Movement},
    framing,
    moving::{self, OwnSpaces},
    patterns::Patterns,
    punctual, scene, studio,
    studio::STUDIO,
    warnings::Warnings,
};
use dapple_camera::Camera;
use dapple_geometry::{
    Accel, AccelBuilder,
    shapes::{Disk, Sphere},
};
use dapple_lights::{Environment, Light, LightSampler};
use dapple_math::motion::Chain;
use glam::{DAffine3, Vec3};
use std::sync::Arc;

/// Shape of an object for light creation, and its motion if it moves.
type ObjectForm = (Form, Option<Movement>);

impl SceneBuilder {
    /// Validates everything and converts it to render space. Adds a framing camera if there is none, and a soft studio
    /// environment (with a warning) if nothing emits.
    ///
    /// # Errors
    /// The first problem found: a number that is not finite, an index out of range, attributes of different lengths, a
    /// radius that is not positive, a camera or light without direction.
    pub fn build(mut self) -> Result<Scene, SceneError> {
        self.check()?;
        self.make_static();
        let emitted: Vec<bool> = self.materials.iter().map(TexturedMaterial::is_light).collect();
        self.strip_emission();
        let constant_textures = constants::fold(&mut self.materials, &mut self.textures);
        let bounds = self.bounds()?;
        let space = bounds.map_or(Space::IDENTITY, |(min, max)| Space::fit(WorldPoint(min), WorldPoint(max)));
        self.simplify_alpha();
        channels::drop_others(&self.materials, &mut self.textures, &self.reads);
        let mut cameras = self.cameras(&space)?;
        let mut lights = punctual::lights(&self.punctual, &space, &self.exposure)
            .map_err(|(i, what)| self.invalid(format!("light {i}"), what))?;
        let bodies = Finder::new(&self.placed, &self.materials, &self.exposure);
        let (accel, mut objects, seen) = self.accel(&space)?;
        if cameras.is_empty() {
            cameras.push(self.framed(&accel, &seen)?);
        }
        self.scale_absorption(&space);
        let whole = |i: usize| seen[i].1.as_ref().map(|movement| movement.whole);
        let (bodies, warnings) = bodies.rank(&mut objects, &self.materials, &space, whole);
        self.warnings.extend(warnings);
        let mut area = self.area_lights(&accel, &mut objects, &seen);
        let kinds = (&objects[..], self.kinds(&objects, &emitted));
        let mut shared_places = SharedPlaces::find(&accel, kinds, (&area, &lights), &space);
        if let Some(shared) = &mut shared_places {
            self.remove_hidden(shared, &mut area, &mut objects, &seen, &space);
        }
        lights.splice(0..0, area.lights.drain(..));
        let environment = self.surroundings(&objects, &lights).map(|e| {
            lights.push(Light::Environment(e));
            lights.len() as u32 - 1
        });
        let mut survey = count(&accel, &seen, &lights, &cameras);
        survey.constant_textures = constant_textures;
        self.survey(&objects, &mut survey);
        let radius = bounds.map_or(1.0, |(min, max)| space.length_to_render((max - min).length() * 0.5));
        Ok(Scene {
            name: self.name,
            space,
            accel,
            objects,
            bodies,
            materials: self.materials,
            textures: self.textures,
            light_choice: LightSampler::new(&lights, radius),
            lights,
            environment,
            cameras,
            at: self.exposure.at,
            is_animated: self.is_animated,
            shutter: self.exposure.shutter,
            survey,
            light_unit: self.light_unit,
            warnings: Warnings::of(self.warnings).summed(),
            bounds,
            radius,
            files: self.files,
            shared_places,
            area,
        })
    }

    /// The properties of each object that decide how coincident surfaces are treated. `emitted` tells for each material
    /// whether it emits in the file; if light is not rendered, this still decides which of two coincident surfaces is
    /// visible.
    fn kinds(&self, objects: &[Object], emitted: &[bool]) -> Vec<Kind> {
        let kind = |o: &Object| {
            let m = o.material as usize;
            let is_light = if self.reads.light { self.materials[m].is_light() } else { emitted[m] };
            Kind::new(&self.materials[m], is_light)
        };
        objects.iter().map(kind).collect()
    }

    /// Converts absorption coefficients to render space.
    fn scale_absorption(&mut self, space: &Space) {
        for m in &mut self.materials {
            m.sigma_a = (m.sigma_a.as_dvec3() / space.scale).as_vec3();
        }
    }

    /// Adds the statistics of materials and textures.
    fn survey(&self, objects: &[Object], survey: &mut Survey) {
        (survey.materials, survey.textures) = (self.materials.len(), self.textures.len());
        survey.dropped_channels = self.textures.iter().map(|t| 4 - t.channels()).sum();
        survey.unread = self.unread;
        scene::survey(objects, &self.materials, survey);
    }

    /// Removes all emission, lights and the environment if light is not rendered.
    fn strip_emission(&mut self) {
        if !self.reads.light {
            self.materials.iter_mut().for_each(|m| m.emission = Vec3::ZERO);
            self.punctual.clear();
            self.environment = None;
        }
    }

    fn area_lights(&self, accel: &Accel, objects: &mut [Object], seen: &[ObjectForm]) -> AreaLights {
        let mut area = AreaLights::default();
        let mut patterns = Patterns::new(accel, &self.textures, &self.materials);
        for (i, (object, (form, movement))) in objects.iter_mut().zip(seen).enumerate() {
            area.add(&mut patterns, (i as u32, object.material), *form, movement.as_ref());
            object.first_light = area.first(i as u32, form.primitives());
        }
        patterns.refine(&mut area.lights, &area.sources, |object| objects[object as usize].material);
        area
    }

    /// Removes lights that coincide with another light that covers them.
    fn remove_hidden(
        &mut self,
        shared: &mut SharedPlaces,
        area: &mut AreaLights,
        objects: &mut [Object],
        seen: &[ObjectForm],
        space: &Space,
    ) {
        let is_solid = |object: u32| {
            let material = &self.materials[objects[object as usize].material as usize];
            material.alpha_mode == AlphaMode::Opaque
        };
        let hidden = shared.hidden(area, is_solid, space);
        let count = hidden.iter().filter(|hidden| **hidden).count();
        if count == 0 {
            return;
        }
        shared.remove(&hidden);
        area.remove(&hidden);
        for (i, (object, (form, _))) in objects.iter_mut().zip(seen).enumerate() {
            object.first_light = area.first(i as u32, form.primitives());
        }
        let lie = if count == 1 { "1 light lies".into() } else { format!("{count} lights lie") };
        self.warn(Warning(format!(
            "{lie} in the place of another light and cannot be seen: remove the copies"
        )));
    }

    /// The environment, unless it is black, or the studio environment for a scene without light. This depends on the
    /// factors of the materials, not on how much light textures and alpha leave.
    fn surroundings(&mut self, objects: &[Object], lights: &[Light]) -> Option<Environment> {
        let material = |o: &Object| &self.materials[o.material as usize];
        let shown = !objects.is_empty() && objects.iter().all(|o| material(o).unlit);
        let emits = objects.iter().any(|o| material(o).is_light());
        let lit = self.environment.is_some() || !lights.is_empty() || emits || self.no_default_light;
        if self.reads.light && !lit && !shown {
            self.warn(Warning(format!("nothing in the scene emits light: {STUDIO}")));
            return Some(studio::studio());
        }
        self.environment.take().filter(|e| !(e.is_constant() && e.mean() == Vec3::ZERO))
    }

    fn framed(&self, accel: &Accel, seen: &[ObjectForm]) -> Result<NamedCamera, SceneError> {
        let counts = seen.iter().map(|(form, _)| form.triangles()).collect();
        let camera = framing::frame(accel, counts).in_render_space(&Space::IDENTITY);
        let camera = camera.map_err(|what| self.invalid("camera 'auto'", what))?;
        Ok(NamedCamera { name: "auto".into(), camera, aspect: None })
    }

    /// Builds the acceleration structure.
    fn accel(&mut self, space: &Space) -> Result<(Accel, Vec<Object>, Vec<ObjectForm>), SceneError> {
        let mut entry = Assembly {
            space,
            accel: AccelBuilder::default(),
            own: OwnSpaces::default(),
            dropped: 0,
            repaired: 0,
        };
        let (mut objects, mut seen) = (Vec::new(), Vec::new());
        for (i, Placed { name, material, geometry, .. }) in
            std::mem::take(&mut self.placed).into_iter().enumerate()
        {
            let entered = entry.insert(self, geometry, material);
            seen.push(entered.map_err(|what| self.invalid(format!("object {i} '{}'", quoted(&name)), what))?);
            let textured =
                self.materials.get(material as usize).is_some_and(|m| m.textures().next().is_some());
            objects.push(Object { name, material, first_light: u32::MAX, textured, body: u32::MAX });
        }
        let Assembly { accel, dropped, repaired, .. } = entry;
        if dropped > 0 {
            self.warn(Warning(format!("{dropped} triangles without area are left out")));
        }
        if repaired > 0 {
            self.warn(Warning(format!(
                "{repaired} texture coordinates or vertex colours are not valid numbers: zero or white is used"
            )));
        }
        let seconds = self.exposure.shutter.seconds();
        Ok((accel.build_for(0.0, seconds), objects, seen))
    }

    fn cameras(&self, space: &Space) -> Result<Vec<NamedCamera>, SceneError> {
        let convert = |(i, (name, pose, chain)): (usize, &(Arc<str>, CameraPose, Option<Chain>))| {
            let mut pose = *pose;
            let motion = chain.as_ref().and_then(|c| self.exposure.camera(c, &pose.transform, space));
            if let Some(chain) = chain {
                pose.transform = DAffine3::from(self.exposure.placement(chain)) * pose.transform;
            }
            let camera = pose
                .in_render_space(space)
                .map_err(|what| self.invalid(format!("camera {i} '{}'", quoted(name)), what))?;
            Ok(NamedCamera { name: name.clone(), camera: Camera { motion, ..camera }, aspect: pose.aspect })
        };
        self.cameras.iter().enumerate().map(convert).collect()
    }
}

/// The acceleration structure under construction, with counts of the changes to the input.
struct Assembly<'a> {
    space: &'a Space,
    accel: AccelBuilder,
    own: OwnSpaces,
    dropped: usize,
    repaired: usize,
}

impl Assembly<'_> {
    /// Adds one object to the acceleration structure. The error describes the problem.
    fn insert(
        &mut self,
        from: &SceneBuilder,
        geometry: Geometry,
        material: u32,
    ) -> Result<ObjectForm, String> {
        let (space, index) = (self.space, material);
        let material = &from.materials[index as usize];
        let form = match geometry {
            Geometry::Mesh { mesh, placement } => {
                let baked = bake::bake(&mesh, &placement, space);
                drop(mesh);
                self.changed(baked.dropped, baked.repaired);
                let mesh = for_material(baked.mesh, material, from.reads.everything);
                let form = Form::Triangles(mesh.triangles.len());
                self.accel.add_mesh(mesh);
                form
            }
            Geometry::Sphere { centre, radius } => {
                let (centre, radius) = (space.to_render(WorldPoint(centre)), space.length_to_render(radius));
                self.accel.add_sphere(Sphere { centre, radius });
                Form::Sphere { centre, radius }
            }
            Geometry::Disk { centre, normal, radius } => {
                let (centre, radius) = (space.to_render(WorldPoint(centre)), space.length_to_render(radius));
                let normal = normal.normalize().as_vec3();
                self.accel.add_disk(Disk { centre, normal, radius });
                Form::Disk { centre, normal, radius }
            }
            Geometry::Moving { body, chain } => {
                let shared = self.own.get(&body, index, material);
                if let Some(own) = &shared {
                    self.changed(own.dropped, own.repaired);
                }
                let (form, movement) = from.exposure.insert(&mut self.accel, &body, &chain, shared, space)?;
                return Ok((form, Some(movement)));
            }
        };
        Ok((form, None))
    }

    fn changed(&mut self, dropped: usize, repaired: usize) {
        self.dropped += dropped;
        self.repaired += repaired;
    }
}

/// Statistics of the geometry, lights and cameras.
fn count(accel: &Accel, seen: &[ObjectForm], lights: &[Light], cameras: &[NamedCamera]) -> Survey {
    Survey {
        triangles: accel.triangle_count(),
        objects: seen.len(),
        shapes: seen.iter().filter(|(form, _)| !matches!(form, Form::Triangles(_))).count(),
        lights: lights.len(),
        has_motion: accel.has_motion()
            || lights.iter().any(|light| matches!(light, Light::Moving(_)))
            || moving::any_moves(cameras.iter().map(|c| &c.camera)),
        ..Survey::default()
    }
}
