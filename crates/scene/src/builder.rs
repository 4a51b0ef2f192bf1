//! Scenes built in code: add things in world space, f64; `build` recentres, rescales, finds lights, checks.
mod build;
mod check;
mod placed;
mod pose;

pub(crate) use placed::{Body, Geometry, Placed};
pub use pose::CameraPose;

use crate::{
    Placement, Reads, SceneError, TexturedMaterial, Unread, Warning, exposure::Exposure,
    light_unit::TakenUnit, punctual::Punctual,
};
use dapple_geometry::Mesh;
use dapple_imaging::Texture;
use dapple_lights::Environment;
use dapple_math::motion::Chain;
use glam::{DVec3, Vec3};
use std::path::PathBuf;
use std::sync::Arc;

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
    pub(crate) punctual: Vec<(Punctual, Option<Chain>)>,
    /// Of the punctual lights of a file.
    pub(crate) light_unit: Option<TakenUnit>,
    environment: Option<Environment>,
    /// The scene stays dark where nothing gives light.
    no_default_light: bool,
    /// Likewise.
    pub(crate) cameras: Vec<(Arc<str>, CameraPose, Option<Chain>)>,
    pub(crate) exposure: Exposure,
    warnings: Vec<Warning>,
    /// What else the file could show.
    pub(crate) notes: Vec<String>,
    pub(crate) files: Vec<PathBuf>,
    unread: Unread,
    /// What the render looks at.
    reads: Reads,
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

    /// What the file holds beyond the scene.
    #[cfg(feature = "gltf")]
    pub(crate) fn leave_unread(&mut self, unread: Unread) {
        self.unread = unread;
    }

    /// What the render looks at; the rest is not kept. Without a word: whatever light can do.
    pub fn reads(&mut self, reads: Reads) {
        self.reads = reads;
    }

    /// Adds no light of its own to a scene that has none.
    pub fn no_default_light(&mut self) {
        self.no_default_light = true;
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

    /// The materials added so far.
    #[cfg(feature = "gltf")]
    pub(crate) fn materials(&self) -> &[TexturedMaterial] {
        &self.materials
    }

    /// Adds a mesh placed by `transform`; returns the object's index. A shared mesh (`Arc`) may be added many times, as may
    /// a shared name.
    pub fn mesh(
        &mut self,
        name: impl Into<Arc<str>>,
        mesh: impl Into<Arc<Mesh>>,
        transform: impl Into<Placement>,
        material: u32,
    ) -> u32 {
        self.place(name, material, Geometry::Mesh { mesh: mesh.into(), placement: transform.into() })
    }

    /// Adds an exact sphere, front side outwards; returns the object's index.
    pub fn sphere(&mut self, name: impl Into<Arc<str>>, centre: DVec3, radius: f64, material: u32) -> u32 {
        self.place(name, material, Geometry::Sphere { centre, radius })
    }

    /// Adds an exact disk whose front side faces `normal`; returns the object's index.
    pub fn disk(
        &mut self,
        name: impl Into<Arc<str>>,
        centre: DVec3,
        normal: DVec3,
        radius: f64,
        material: u32,
    ) -> u32 {
        self.place(name, material, Geometry::Disk { centre, normal, radius })
    }

    pub(crate) fn place_moving(
        &mut self,
        name: impl Into<Arc<str>>,
        material: u32,
        body: Body,
        chain: Chain,
    ) -> u32 {
        self.place(name, material, Geometry::Moving { body, chain })
    }

    fn place(&mut self, name: impl Into<Arc<str>>, material: u32, geometry: Geometry) -> u32 {
        let index = self.placed.len() as u32;
        self.placed.push(Placed { name: name.into(), material, geometry, group: index, node: index });
        index
    }

    /// Makes the volumes among these objects, which were added one after the other, one body, that of node `node`: of two
    /// bodies that overlap, with equal priorities and equal bounding volumes, the one of the lower node wins. Otherwise
    /// every object is a body of its own, and its own index stands for the node's.
    pub fn one_body(&mut self, objects: std::ops::Range<u32>, node: u32) {
        let first = objects.start;
        let range = objects.start as usize..(objects.end as usize).min(self.placed.len());
        for placed in self.placed.get_mut(range).into_iter().flatten() {
            (placed.group, placed.node) = (first, node);
        }
    }

    /// How many objects there are.
    #[cfg(feature = "gltf")]
    pub(crate) fn object_count(&self) -> u32 {
        self.placed.len() as u32
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

    /// Takes the intensities of the punctual lights so far as they are, or divides them.
    #[cfg(feature = "gltf")]
    pub(crate) fn take_lights_as(&mut self, unit: TakenUnit) {
        if unit.is_photometric {
            self.punctual.iter_mut().for_each(|(light, _)| light.divide(crate::light_unit::LUMENS_PER_WATT));
        }
        self.light_unit = Some(unit).filter(|_| !self.punctual.is_empty());
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
    pub fn camera(&mut self, name: impl Into<Arc<str>>, pose: CameraPose) {
        self.cameras.push((name.into(), pose, None));
    }

    /// Adds something to tell the user.
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// What else the file that the scene was read from could show (other scenes, variants, animations): one line each,
    /// for those that nobody chose from.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    fn invalid(&self, place: impl Into<String>, what: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.label, place, what)
    }
}
