//! Construction of scenes in code: objects are added in world space, f64; `build` validates them, transforms them to
//! render space and detects lights.
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

/// Collects the parts of a scene. Returned indices count from zero in the order of addition.
#[derive(Debug, Default)]
pub struct SceneBuilder {
    name: String,
    /// Name of the scene in errors: its file, or else its name.
    label: String,
    textures: Vec<Texture>,
    materials: Vec<TexturedMaterial>,
    placed: Vec<Placed>,
    /// Punctual lights, each with the chain of nodes that moves it, if any.
    pub(crate) punctual: Vec<(Punctual, Option<Chain>)>,
    /// Unit of the punctual lights of a file.
    pub(crate) light_unit: Option<TakenUnit>,
    environment: Option<Environment>,
    /// Whether a scene without light stays dark.
    no_default_light: bool,
    /// Cameras, each with the chain of nodes that moves it, if any.
    pub(crate) cameras: Vec<(Arc<str>, CameraPose, Option<Chain>)>,
    pub(crate) exposure: Exposure,
    warnings: Vec<Warning>,
    /// Notes on the alternatives in the file.
    pub(crate) notes: Vec<String>,
    pub(crate) files: Vec<PathBuf>,
    unread: Unread,
    /// Whether the contents depend on the time of the animation.
    is_animated: bool,
    /// The surface data that the render uses.
    reads: Reads,
}

impl SceneBuilder {
    /// Creates an empty scene; `name` is used for the names of its images.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), label: name.to_owned(), ..Self::default() }
    }

    /// Creates an empty scene whose errors name `file`.
    #[cfg(feature = "gltf")]
    pub(crate) fn from_file(name: &str, file: &std::path::Path) -> Self {
        Self { name: name.to_owned(), label: file.display().to_string(), ..Self::default() }
    }

    /// Sets the counts of the parts of the file that were not read.
    #[cfg(feature = "gltf")]
    pub(crate) fn unread(&mut self, unread: Unread) {
        self.unread = unread;
    }

    /// Sets whether the contents depend on the time of the animation.
    #[cfg(feature = "gltf")]
    pub(crate) fn animated(&mut self, is_animated: bool) {
        self.is_animated = is_animated;
    }

    /// Sets the surface data that the render uses; other data are not kept. The default is everything that light
    /// transport uses.
    pub fn reads(&mut self, reads: Reads) {
        self.reads = reads;
    }

    /// Disables the default environment for a scene without light.
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

    /// Adds a mesh placed by `transform`; returns the object's index. The mesh and the name may be shared (`Arc`)
    /// between many objects.
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

    /// Combines the volumes among these consecutive objects into one body of node `node`: of two overlapping bodies
    /// with equal priorities and equal bounding volumes, the one with the lower node takes precedence. By default every
    /// object is a separate body, with its own index as the node.
    pub fn one_body(&mut self, objects: std::ops::Range<u32>, node: u32) {
        let first = objects.start;
        let range = objects.start as usize..(objects.end as usize).min(self.placed.len());
        for placed in self.placed.get_mut(range).into_iter().flatten() {
            (placed.group, placed.node) = (first, node);
        }
    }

    /// Number of objects.
    #[cfg(feature = "gltf")]
    pub(crate) fn object_count(&self) -> u32 {
        self.placed.len() as u32
    }

    /// Adds a point light of `intensity` in W/sr per channel that ends at `range` world units (may be infinite).
    pub fn point_light(&mut self, p: DVec3, intensity: Vec3, range: f64) {
        self.punctual.push((Punctual::Point { p, intensity, range }, None));
    }

    /// Adds a spot light along `axis`, with `intensity` and `range` as for [`SceneBuilder::point_light`]; `inner` and
    /// `outer` are the half angles of the cone in radians.
    pub fn spot_light(&mut self, p: DVec3, axis: DVec3, intensity: Vec3, range: f64, inner: f64, outer: f64) {
        self.punctual.push((Punctual::Spot { p, axis, intensity, range, inner, outer }, None));
    }

    /// Adds a distant light in the direction `towards`; `irradiance` is in W/m² per channel on a surface that faces it.
    pub fn distant_light(&mut self, towards: DVec3, irradiance: Vec3) {
        self.punctual.push((Punctual::Distant { towards, irradiance }, None));
    }

    /// Sets the unit of the punctual lights added so far, and converts their intensities.
    #[cfg(feature = "gltf")]
    pub(crate) fn light_unit(&mut self, unit: TakenUnit) {
        if unit.is_photometric {
            self.punctual.iter_mut().for_each(|(light, _)| light.divide(crate::light_unit::LUMENS_PER_WATT));
        }
        self.light_unit = Some(unit).filter(|_| !self.punctual.is_empty());
    }

    /// Sets the environment and replaces an earlier one. A constant black environment makes the scene intentionally
    /// dark.
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

    /// Adds a warning.
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// Notes on the alternatives in the file from which the scene was read (other scenes, variants, animations): one
    /// line for each kind for which no choice was made.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    fn invalid(&self, place: impl Into<String>, what: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.label, place, what)
    }
}
