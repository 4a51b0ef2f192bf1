//! What is in a file, for people: counts, names, sizes, extensions. Only as much is read as that takes: mesh data
//! stay where they are.
use super::{
    animation, container,
    document::{Document, label},
    extensions, load, mesh,
    node::Hierarchy,
    texture,
};
use crate::{SceneError, memory::Load};
use gltf::json::{extensions::scene::khr_lights_punctual::Type, mesh::Semantic, validation::Checked};
use serde::Serialize;
use std::collections::BTreeSet;

/// What a file holds. Counts of triangles and vertices are those of the meshes as placed in the default scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Info {
    /// The file's generator, if it says.
    pub generator: Option<String>,
    /// How many of everything.
    pub counts: Counts,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Names of those that emit light.
    pub emissive: Vec<String>,
    /// Images that materials can use.
    pub textures: Vec<TextureInfo>,
    /// Punctual lights: "point 'Lamp'" and so on.
    pub lights: Vec<String>,
    /// Names of the cameras in the scene, as `--camera` takes them.
    pub cameras: Vec<String>,
    /// Animations with their length.
    pub animations: Vec<AnimationInfo>,
    /// Extensions the file uses.
    pub extensions: Vec<ExtensionInfo>,
    /// Memory that rendering will take for scene data at its peak, about: every instance counts.
    pub memory_bytes: u64,
    /// What will look different from what the file says.
    pub warnings: Vec<String>,
}

/// How many of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Nodes in the file.
    pub nodes: usize,
    /// Nodes the default scene shows.
    pub visible_nodes: usize,
    /// Meshes in the file.
    pub meshes: usize,
    /// Triangles the default scene shows.
    pub triangles: u64,
    /// Exact spheres and disks the default scene shows.
    pub shapes: usize,
    /// Vertices the default scene shows.
    pub vertices: u64,
    /// Materials in the file.
    pub materials: usize,
    /// Skins in the file (not applied).
    pub skins: usize,
    /// Primitives with morph targets (not applied).
    pub morphed: usize,
}

/// An image.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TextureInfo {
    /// Name or file name.
    pub name: String,
    /// Pixels across; 0 when it cannot be read.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Why it cannot be read.
    pub error: Option<String>,
}

/// An animation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AnimationInfo {
    /// Its name.
    pub name: String,
    /// First key in seconds.
    pub start: f64,
    /// Last key in seconds.
    pub end: f64,
    /// Channels that move nodes.
    pub channels: usize,
}

/// An extension.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ExtensionInfo {
    /// Its name.
    pub name: String,
    /// The file cannot be read without it.
    pub required: bool,
    /// dapple honours it.
    pub supported: bool,
}

pub(super) fn info(doc: &Document<'_>) -> Result<Info, SceneError> {
    let hierarchy = Hierarchy::new(doc)?;
    let counts = counts(doc, &hierarchy)?;
    let textures = textures(doc);
    let texels = textures.iter().map(|t| 4 * t.width as u64 * t.height as u64).sum();
    let texels = Load { bytes: texels, ..Load::default() };
    Ok(Info {
        generator: doc.root.asset.generator.clone(),
        counts,
        emissive: emissive(doc),
        materials: labels(doc.root.materials.iter().map(|m| m.name.as_deref()), "material"),
        lights: lights(doc),
        cameras: cameras(doc, &hierarchy)?,
        animations: animations(doc)?,
        extensions: extension_list(doc),
        memory_bytes: load::load(doc, &hierarchy).plus(texels).peak_bytes(),
        textures,
        warnings: doc.take_warnings().into_iter().map(|w| w.0).collect(),
    })
}

fn counts(doc: &Document<'_>, hierarchy: &Hierarchy) -> Result<Counts, SceneError> {
    let root = &doc.root;
    let primitives = || root.meshes.iter().flat_map(|m| &m.primitives);
    let mut counts = Counts {
        nodes: root.nodes.len(),
        visible_nodes: hierarchy.order.len(),
        meshes: root.meshes.len(),
        materials: root.materials.len(),
        skins: root.skins.len(),
        morphed: primitives().filter(|p| p.targets.as_ref().is_some_and(|t| !t.is_empty())).count(),
        ..Counts::default()
    };
    for &i in &hierarchy.order {
        let node = &root.nodes[i];
        let place = super::node::place(doc, i);
        let shape = doc.dapple(&node.extras, &place)?.is_some_and(|d| d.get("shape").is_some());
        counts.shapes += usize::from(shape);
        let Some(index) = node.mesh.filter(|_| !shape) else { continue };
        let (mesh, place) = mesh::named(doc, index, &place)?;
        for primitive in &mesh.primitives {
            counts.triangles = counts.triangles.saturating_add(mesh::triangle_count(doc, primitive, &place)?);
            if let Some(positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) {
                counts.vertices = counts.vertices.saturating_add(doc.count(*positions, &place)?);
            }
        }
    }
    Ok(counts)
}

fn textures(doc: &Document<'_>) -> Vec<TextureInfo> {
    let one = |(i, image): (usize, &gltf::json::Image)| {
        let name = label("image", i, image.name.as_deref());
        match texture::size(doc, i, &name) {
            Ok([width, height]) => TextureInfo { name, width, height, error: None },
            Err(e) => TextureInfo { name, error: Some(e.to_string()), ..TextureInfo::default() },
        }
    };
    doc.root.images.iter().enumerate().map(one).collect()
}

fn labels<'a>(names: impl Iterator<Item = Option<&'a str>>, kind: &str) -> Vec<String> {
    names.enumerate().map(|(i, name)| name.map_or_else(|| format!("{kind} {i}"), str::to_owned)).collect()
}

/// Factors alone decide: a texture may still be black.
fn emissive(doc: &Document<'_>) -> Vec<String> {
    let names = labels(doc.root.materials.iter().map(|m| m.name.as_deref()), "material");
    let emits = doc.root.materials.iter().map(|m| m.emissive_factor.0.iter().any(|&c| c > 0.0));
    names.into_iter().zip(emits).filter(|(_, emits)| *emits).map(|(name, _)| name).collect()
}

fn lights(doc: &Document<'_>) -> Vec<String> {
    let lights = doc.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let one = |(i, light): (usize, &gltf::json::extensions::scene::khr_lights_punctual::Light)| {
        let kind = match light.type_ {
            Checked::Valid(Type::Directional) => "directional",
            Checked::Valid(Type::Point) => "point",
            Checked::Valid(Type::Spot) => "spot",
            Checked::Invalid => "unknown",
        };
        format!("{kind} {}", label("light", i, light.name.as_deref()))
    };
    lights.map_or(&[][..], |l| &l.lights).iter().enumerate().map(one).collect()
}

fn cameras(doc: &Document<'_>, hierarchy: &Hierarchy) -> Result<Vec<String>, SceneError> {
    let mut names = Vec::new();
    for node in hierarchy.order.iter().map(|&i| &doc.root.nodes[i]) {
        let Some(index) = node.camera else { continue };
        let camera = doc.get(&doc.root.cameras, index, "camera", "a node")?;
        names.push(super::read::camera_name(index, camera, node.name.as_deref()));
    }
    Ok(names)
}

fn animations(doc: &Document<'_>) -> Result<Vec<AnimationInfo>, SceneError> {
    let spans = animation::spans(doc)?;
    let names = labels(doc.root.animations.iter().map(|a| a.name.as_deref()), "animation");
    let one = |((name, (start, end)), a): ((String, (f64, f64)), &gltf::json::Animation)| AnimationInfo {
        name,
        start,
        end,
        channels: a.channels.len(),
    };
    Ok(names.into_iter().zip(spans).zip(&doc.root.animations).map(one).collect())
}

fn extension_list(doc: &Document<'_>) -> Vec<ExtensionInfo> {
    let required: BTreeSet<&str> = container::names(&doc.value, "extensionsRequired").into_iter().collect();
    let mut names = container::names(&doc.value, "extensionsUsed");
    names.extend(required.iter().copied());
    names.sort_unstable();
    names.dedup();
    let one = |name: &str| ExtensionInfo {
        name: name.to_owned(),
        required: required.contains(name),
        supported: extensions::is_supported(name),
    };
    names.into_iter().map(one).collect()
}
