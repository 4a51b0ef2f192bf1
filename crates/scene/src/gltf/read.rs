//! Conversion of a checked document to a [`SceneBuilder`].
use super::{
    choose::Selected,
    document::{Document, label},
    instancing, load,
    material::Materials,
    mesh::{self, Wanted},
    node::{self, Hierarchy},
    visible,
};
use crate::light_unit::TakenUnit;
use crate::{CameraPose, Placement, SceneBuilder, SceneError, Unread};
use dapple_camera::{Clip, Projection};
use dapple_geometry::Mesh;
use dapple_math::motion::{self, Chain};
use glam::{DAffine3, DVec3, Vec3};
use gltf::json::{
    self, Index, camera, extensions::scene::khr_lights_punctual as punctual, validation::Checked,
};
use serde_json::Value;
use std::{borrow::Cow, collections::HashMap, f64::consts::FRAC_PI_2, sync::Arc};

const SHAPES: &str = "extras.dapple.shape must be \"sphere\" or \"disk\"";

/// Builds the chosen scene.
pub(super) fn scene(doc: &Document<'_>) -> Result<SceneBuilder, SceneError> {
    let selected = Selected::new(doc)?;
    let hierarchy = Hierarchy::new(doc, &selected)?;
    visible::warn(doc, &selected, &hierarchy);
    load::check(doc, &hierarchy)?;
    let (at, shutter) = (doc.options.at, doc.options.shutter);
    let placements = hierarchy.placements(at + shutter.open);
    let moving = hierarchy.moving(at + shutter.open, at + shutter.close);
    let mut builder = SceneBuilder::from_file(&name(doc), &doc.file);
    builder.exposure(at, shutter);
    builder.animated(hierarchy.is_animated());
    builder.files = doc.files();
    builder.notes = selected.notes(doc);
    let meshes = vec![None; doc.root.meshes.len()];
    let (materials, firsts, cameras) = (Materials::default(), HashMap::new(), HashMap::new());
    let mut assembly = Assembly { doc, selected, builder, materials, meshes, firsts, cameras };
    let mut chains = HashMap::new();
    for &index in &hierarchy.order {
        let node = &doc.root.nodes[index];
        let shows = node.mesh.is_some() || node.extensions.is_some() || node.extras.is_some();
        let chain = (moving[index] && shows).then(|| hierarchy.chain(index, &mut chains));
        assembly.node(index, &NodePose { placement: placements[index], chain })?;
        if let Some(camera) = node.camera {
            let placement = hierarchy.camera(index, &placements, at + shutter.open);
            let chain = moving[index].then(|| hierarchy.camera_chain(index, &mut chains));
            assembly.camera(camera, node.name.as_deref(), &NodePose { placement, chain })?;
        }
    }
    assembly.materials.decode(doc, &mut assembly.builder)?;
    let unread = assembly.unread(hierarchy.order.len());
    let mut builder = assembly.builder;
    builder.light_unit(TakenUnit::new(doc.options.light_unit, doc.root.asset.generator.as_deref()));
    builder.unread(unread);
    builder.reads(doc.options.reads);
    doc.take_warnings().into_iter().for_each(|w| builder.warn(w));
    Ok(builder)
}

/// Name of the scene: the stem of the file's name.
fn name(doc: &Document<'_>) -> String {
    doc.file.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned())
}

/// Primitives of one mesh, each with the index of its material in the builder.
type Primitives = Vec<(Arc<Mesh>, u32)>;

/// Pose of a node: its placement when the shutter opens and, if it moves while the shutter is open, its chain of nodes.
struct NodePose {
    placement: Placement,
    chain: Option<Chain>,
}

struct Assembly<'a, 'o> {
    doc: &'a Document<'o>,
    selected: Selected,
    builder: SceneBuilder,
    materials: Materials,
    /// Meshes read so far.
    meshes: Vec<Option<Primitives>>,
    /// Names of cameras that several nodes may share.
    cameras: HashMap<usize, Arc<str>>,
    /// Materials of the first primitives of meshes, cached.
    firsts: HashMap<usize, Option<Index<json::Material>>>,
}

impl Assembly<'_, '_> {
    /// Counts of the parts of the file that were not read.
    fn unread(&self, nodes: usize) -> Unread {
        let root = &self.doc.root;
        Unread {
            nodes: root.nodes.len() - nodes,
            meshes: self.meshes.iter().filter(|m| m.is_none()).count(),
            materials: root.materials.len() - self.materials.count(),
            images: root.images.len() - self.materials.images(),
        }
    }

    fn node(&mut self, index: usize, pose: &NodePose) -> Result<(), SceneError> {
        let (doc, placement) = (self.doc, &pose.placement);
        let node = &doc.root.nodes[index];
        let place = node::place(doc, index);
        if !placement.is_finite() {
            return Err(doc.invalid(
                place,
                "its transform overflows: check the translations and scales of it and its parents",
            ));
        }
        let shape = doc.dapple(&node.extras, &place)?.filter(|d| d.get("shape").is_some());
        match (shape, node.mesh) {
            (Some(shape), mesh) => {
                let first = self.builder.object_count();
                self.shape(&shape, mesh, index, pose)?;
                self.builder.one_body(first..self.builder.object_count(), index as u32);
            }
            (None, Some(mesh)) => self.instances(mesh, index, pose)?,
            (None, None) => {}
        }
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(light) = light {
            self.light(light.light, &place, pose)?;
        }
        if node.skin.is_some() {
            doc.warn(
                "skins are not applied: skinned meshes are shown undeformed; bake the pose into the meshes"
                    .into(),
            );
        }
        Ok(())
    }

    fn instances(
        &mut self,
        mesh: Index<json::Mesh>,
        index: usize,
        pose: &NodePose,
    ) -> Result<(), SceneError> {
        let doc = self.doc;
        let (_, mesh_place) = mesh::named(doc, mesh, &node::place(doc, index))?;
        self.read_mesh(mesh, &mesh_place)?;
        if self.meshes[mesh.value()].as_ref().is_none_or(Vec::is_empty) {
            return Ok(());
        }
        let name: Arc<str> = match doc.root.nodes[index].name.as_deref() {
            Some(name) if !name.is_empty() => name.into(),
            _ => mesh_place.into(),
        };
        let instances = instancing::placements(doc, index)?.unwrap_or_else(|| vec![Placement::IDENTITY]);
        for instance in instances {
            let first = self.builder.object_count();
            for (mesh, material) in self.meshes[mesh.value()].iter().flatten() {
                let (mesh, material) = (mesh.clone(), *material);
                match &pose.chain {
                    None => {
                        let placement = pose.placement.child(&instance);
                        self.builder.mesh(name.clone(), mesh, placement, material)
                    }
                    Some(chain) => {
                        let last = motion::Node::Fixed(instance.into());
                        self.builder.moving_mesh(name.clone(), mesh, chain.then(last), material)
                    }
                };
            }
            self.builder.one_body(first..self.builder.object_count(), index as u32);
        }
        Ok(())
    }

    /// Reads the primitives of a mesh if this has not been done yet.
    fn read_mesh(&mut self, index: Index<json::Mesh>, place: &str) -> Result<(), SceneError> {
        if self.meshes[index.value()].is_some() {
            return Ok(());
        }
        let doc = self.doc;
        let mut primitives = Vec::new();
        for (i, primitive) in doc.root.meshes[index.value()].primitives.iter().enumerate() {
            let place = format!("{place}, primitive {i}");
            let material = self.selected.material(primitive);
            let material = self.materials.resolve(doc, &mut self.builder, material, &place)?;
            let wanted = Wanted::by(&self.builder.materials()[material as usize], &doc.options.reads);
            if let Some(mesh) = mesh::read(doc, primitive, &place, &wanted)? {
                primitives.push((Arc::new(mesh), material));
            }
        }
        self.meshes[index.value()] = Some(primitives);
        Ok(())
    }

    /// Adds the shape of `extras: {"dapple": {"shape": "sphere" | "disk", "radius": r}}`: an exact surface in place of
    /// the node's mesh, with the mesh's first material or the one given by `"material": index`. A disk faces local +Z.
    fn shape(
        &mut self,
        shape: &Value,
        mesh: Option<Index<json::Mesh>>,
        index: usize,
        pose: &NodePose,
    ) -> Result<(), SceneError> {
        let doc = self.doc;
        let place = node::place(doc, index);
        let material = match shape.get("material") {
            Some(value) => {
                let index = value.as_u64().and_then(|i| u32::try_from(i).ok());
                let index =
                    index.ok_or_else(|| doc.invalid(&*place, "extras.dapple.material must be an index"))?;
                Some(Index::new(index))
            }
            None => match mesh {
                Some(mesh) => self.first_material(mesh, &place)?,
                None => None,
            },
        };
        let material = self.materials.resolve(doc, &mut self.builder, material, &place)?;
        let radius = shape.get("radius").and_then(Value::as_f64).filter(|r| *r > 0.0);
        let Some(radius) = radius else {
            return Err(doc.invalid(place, "extras.dapple.radius must be a number above 0"));
        };
        let kind = shape.get("shape").and_then(Value::as_str);
        if let Some(chain) = &pose.chain {
            let name = doc.root.nodes[index].name.as_deref().unwrap_or(&place);
            return self
                .moving_shape(kind, name, radius, chain.clone(), material)
                .map_err(|w| doc.invalid(&*place, w));
        }
        let placement = &pose.placement;
        let m = &placement.linear;
        let lengths = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length);
        let (centre, name) = (placement.point(DVec3::ZERO), doc.root.nodes[index].name.as_deref());
        let name = name.unwrap_or(&place);
        match kind {
            Some("sphere") => {
                self.uniform(&lengths, &place);
                let scale = (lengths[0] + lengths[1] + lengths[2]) / 3.0;
                self.builder.sphere(name, centre, radius * scale, material);
            }
            Some("disk") => {
                self.uniform(&lengths[..2], &place);
                let scale = (lengths[0] + lengths[1]) / 2.0;
                // The front side follows that of a mesh: a mirroring transform reverses x × y, but not the side that
                // faces +Z.
                let facing = m.x_axis.cross(m.y_axis);
                let facing = if facing.dot(m.z_axis) < 0.0 { -facing } else { facing };
                self.builder.disk(name, centre, facing, radius * scale, material);
            }
            _ => return Err(doc.invalid(place, SHAPES)),
        }
        Ok(())
    }

    /// Material of the first primitive of a mesh.
    fn first_material(
        &mut self,
        mesh: Index<json::Mesh>,
        place: &str,
    ) -> Result<Option<Index<json::Material>>, SceneError> {
        if let Some(first) = self.firsts.get(&mesh.value()) {
            return Ok(*first);
        }
        let first = mesh::named(self.doc, mesh, place)?.0.primitives.first();
        let first = first.and_then(|primitive| self.selected.material(primitive));
        self.firsts.insert(mesh.value(), first);
        Ok(first)
    }

    fn moving_shape(
        &mut self,
        kind: Option<&str>,
        name: &str,
        radius: f64,
        chain: Chain,
        material: u32,
    ) -> Result<(), &'static str> {
        match kind {
            Some("sphere") => self.builder.moving_sphere(name, radius, chain, material),
            Some("disk") => self.builder.moving_disk(name, radius, chain, material),
            _ => return Err(SHAPES),
        };
        Ok(())
    }

    fn uniform(&self, lengths: &[f64], place: &str) {
        let (min, max) = lengths.iter().fold((f64::MAX, 0.0_f64), |(a, b), &l| (a.min(l), b.max(l)));
        if max - min > 1e-6 * max {
            self.doc.warn(format!("{place} has a non-uniform scale; its sphere or disk uses the mean scale"));
        }
    }

    /// Adds a camera. `pose` excludes the scale of the camera's node.
    fn camera(
        &mut self,
        index: Index<json::Camera>,
        node: Option<&str>,
        pose: &NodePose,
    ) -> Result<(), SceneError> {
        let doc = self.doc;
        let camera = doc.get(&doc.root.cameras, index, "camera", node.unwrap_or("a node"))?;
        let place = label("camera", index.value(), camera.name.as_deref());
        let (projection, aspect) = projection(camera).map_err(|what| doc.invalid(&*place, what))?;
        let clip = clip(camera);
        if clip.is_none() {
            doc.warn(format!(
                "{place}: nothing is clipped, because 0 ≤ znear < zfar does not hold: correct znear and zfar"
            ));
        }
        let own = |camera: &json::Camera| node.filter(|n| !n.is_empty()).is_none() && camera.name.is_some();
        let name: Arc<str> = match own(camera) {
            // All nodes that show the camera share one name.
            true => self
                .cameras
                .entry(index.value())
                .or_insert_with(|| camera_name(index, camera, node).into())
                .clone(),
            false => camera_name(index, camera, node).into(),
        };
        let camera_pose = |transform| CameraPose { transform, projection, aspect, clip };
        let placement = &pose.placement;
        // A chain that is singular when the shutter opens is ignored.
        let chain = pose.chain.as_ref();
        match chain.filter(|chain| !node::is_flat(&self.builder.exposure.placement(chain).linear)) {
            None => self.builder.camera(name, camera_pose((*placement).into())),
            Some(chain) => self.builder.moving_camera(name, camera_pose(DAffine3::IDENTITY), chain.clone()),
        }
        Ok(())
    }

    fn light(
        &mut self,
        index: Index<punctual::Light>,
        place: &str,
        pose: &NodePose,
    ) -> Result<(), SceneError> {
        let doc = self.doc;
        let lights = doc.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        let lights = lights.map_or(&[][..], |l| &l.lights);
        let light = doc.get(lights, index, "light", place)?;
        let place = label("light", index.value(), light.name.as_deref());
        let strength = Vec3::from_array(light.color) * light.intensity;
        if !(strength.is_finite() && strength.min_element() >= 0.0) {
            return Err(doc.invalid(place, "its colour and intensity must be finite and not negative"));
        }
        // The pose of a moving light is given in the space of its node: at the origin, along −z.
        let placement = match pose.chain {
            None => pose.placement,
            Some(_) => Placement::IDENTITY,
        };
        let p = placement.point(DVec3::ZERO);
        let range = light.range.map_or(f64::INFINITY, f64::from);
        if range.is_nan() || range <= 0.0 {
            return Err(doc.invalid(place, "its range must be above 0"));
        }
        let forward = -placement.linear.z_axis;
        if light.type_ != Checked::Valid(punctual::Type::Point) && forward.try_normalize().is_none() {
            doc.warn(format!(
                "{place} is left out: its node has a scale of zero, and so it has no direction"
            ));
            return Ok(());
        }
        match light.type_ {
            Checked::Valid(punctual::Type::Point) => self.builder.point_light(p, strength, range),
            Checked::Valid(punctual::Type::Directional) => self.builder.distant_light(-forward, strength),
            Checked::Valid(punctual::Type::Spot) => {
                let (inner, outer) = cone(light);
                self.builder.spot_light(p, forward, strength, range, inner, outer);
            }
            Checked::Invalid => {
                return Err(doc.invalid(place, "has an unknown type (expected point, spot or directional)"));
            }
        }
        if let Some(chain) = &pose.chain {
            self.builder.moving_light(chain.clone());
        }
        Ok(())
    }
}

/// Inner and outer half angle of a spot light, in radians.
pub(super) fn cone(light: &punctual::Light) -> (f64, f64) {
    let spot = light
        .spot
        .clone()
        .unwrap_or(punctual::Spot { inner_cone_angle: 0.0, outer_cone_angle: std::f32::consts::FRAC_PI_4 });
    let outer = f64::from(spot.outer_cone_angle).clamp(0.0, FRAC_PI_2);
    (f64::from(spot.inner_cone_angle).clamp(0.0, outer), outer)
}

/// Name of a camera: that of its node, or else its own.
pub(super) fn camera_name<'a>(
    index: Index<json::Camera>,
    camera: &'a json::Camera,
    node: Option<&'a str>,
) -> Cow<'a, str> {
    let name = node.filter(|n| !n.is_empty()).or(camera.name.as_deref().filter(|n| !n.is_empty()));
    name.map_or_else(|| label("camera", index.value(), None).into(), Cow::from)
}

/// Near and far plane of a glTF camera; None unless 0 ≤ near < far.
fn clip(c: &json::Camera) -> Option<Clip> {
    let (near, far) = match (c.type_, &c.perspective, &c.orthographic) {
        (Checked::Valid(camera::Type::Perspective), Some(p), _) => (p.znear, p.zfar),
        (_, _, Some(o)) => (o.znear, Some(o.zfar)),
        _ => return None,
    };
    let far = far.unwrap_or(f32::INFINITY);
    (near >= 0.0 && near < far).then_some(Clip { near, far })
}

/// Projection and aspect ratio of a glTF camera.
fn projection(c: &json::Camera) -> Result<(Projection, Option<f32>), &'static str> {
    match (c.type_, &c.perspective, &c.orthographic) {
        (Checked::Valid(camera::Type::Perspective), Some(p), _) => {
            if !(p.yfov > 0.0 && p.yfov < std::f32::consts::PI) {
                return Err("its yfov must lie between 0 and π");
            }
            let tan_half = libm::tan(f64::from(p.yfov) / 2.0) as f32;
            let aspect = p.aspect_ratio.filter(|a| *a > 0.0 && a.is_finite());
            Ok((Projection::Perspective { tan_half }, aspect))
        }
        (Checked::Valid(camera::Type::Orthographic), _, Some(o)) => {
            let (x, y) = (o.xmag.abs(), o.ymag.abs());
            if !(y > 0.0 && y.is_finite()) {
                return Err("its ymag must be finite and above 0");
            }
            let aspect = Some(x / y).filter(|a| *a > 0.0 && a.is_finite());
            Ok((Projection::Orthographic { half_height: y }, aspect))
        }
        _ => Err("has neither a perspective nor an orthographic projection"),
    }
}
