//! What is in a file, for people: counts, names, sizes, extensions. Only as much is read as that takes: mesh data
//! stay where they are.
mod choices;
mod objects;
mod views;

use super::{
    choose::Selected,
    container,
    document::{Document, label},
    extensions, load,
    node::Hierarchy,
    texture, visible,
};
use crate::{SceneError, light_unit::TakenUnit, memory::Load};
pub use choices::{AnimationInfo, SceneInfo, VariantInfo};
use gltf::json;
pub use objects::{MorphInfo, ObjectInfo, SkinInfo};
use serde::Serialize;
use std::collections::BTreeSet;
pub use views::{CameraInfo, LightInfo};

/// What a file holds. What is placed is that of the scene, the variant and the time that are shown.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Info {
    /// The file's generator, if it says.
    pub generator: Option<String>,
    /// How many of everything.
    pub counts: Counts,
    /// Scenes to choose from.
    pub scenes: Vec<SceneInfo>,
    /// Material variants to choose from.
    pub variants: Vec<VariantInfo>,
    /// Animations to choose from.
    pub animations: Vec<AnimationInfo>,
    /// What is placed.
    pub objects: Vec<ObjectInfo>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Those that emit light.
    pub emissive: Vec<EmissiveInfo>,
    /// Images that materials can use.
    pub textures: Vec<TextureInfo>,
    /// Punctual lights.
    pub lights: Vec<LightInfo>,
    /// What their intensities are taken as, and why; None without such lights.
    pub light_unit: Option<LightUnitInfo>,
    /// Cameras.
    pub cameras: Vec<CameraInfo>,
    /// Skins.
    pub skins: Vec<SkinInfo>,
    /// Morph targets.
    pub morphs: Vec<MorphInfo>,
    /// Extensions the file uses.
    pub extensions: Vec<ExtensionInfo>,
    /// Memory that rendering will take for scene data at its peak, about: every instance counts.
    pub memory_bytes: u64,
    /// What will look different from what the file says, as far as it shows without reading meshes.
    pub warnings: Vec<String>,
}

/// How many of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Nodes in the file.
    pub nodes: usize,
    /// Nodes the scene shows.
    pub visible_nodes: usize,
    /// Meshes in the file.
    pub meshes: usize,
    /// Triangles the scene shows: those of a mesh once for every place where it stands.
    pub triangles: u64,
    /// Triangles of the meshes that the scene shows, each counted once.
    pub stored_triangles: u64,
    /// Places where meshes stand.
    pub instances: u64,
    /// Exact spheres and disks the scene shows.
    pub shapes: usize,
    /// Vertices the scene shows, counted like the triangles.
    pub vertices: u64,
    /// Materials in the file.
    pub materials: usize,
    /// Skins in the file (not applied).
    pub skins: usize,
    /// Primitives with morph targets (not applied).
    pub morphed: usize,
}

/// A material that emits light.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EmissiveInfo {
    /// The material's name.
    pub name: String,
    /// Radiance in W·m⁻²·sr⁻¹ per channel: factor times strength, before the texture.
    pub radiance: [f32; 3],
    /// A texture says how much of it there is where.
    pub textured: bool,
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

/// What intensities of punctual lights are taken as.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LightUnitInfo {
    /// `radiometric`, or `photometric`: divided by 683 lm/W.
    pub unit: String,
    /// Why, as a clause.
    pub why: String,
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
    let selected = Selected::new(doc)?;
    let hierarchy = Hierarchy::new(doc, &selected)?;
    visible::warn(doc, &selected, &hierarchy);
    let (open, close) =
        (doc.options.at + doc.options.shutter.open, doc.options.at + doc.options.shutter.close);
    let (placements, moving) = (hierarchy.placements(open), hierarchy.moving(open, close));
    let mut counts = counts(doc, &hierarchy);
    let objects = objects::objects(doc, &hierarchy, &mut counts)?;
    let textures = textures(doc);
    let texels = textures.iter().map(|t| 4 * t.width as u64 * t.height as u64).sum();
    let texels = Load { bytes: texels, ..Load::default() };
    Ok(Info {
        generator: doc.root.asset.generator.clone(),
        counts,
        scenes: choices::scenes(doc, &selected),
        variants: choices::variants(doc, &selected),
        animations: choices::animations(doc, &selected),
        objects,
        emissive: emissive(doc),
        materials: objects::materials(doc),
        light_unit: light_unit(doc),
        lights: views::lights(doc, &hierarchy),
        cameras: views::cameras(doc, &hierarchy, (&placements, &moving))?,
        skins: objects::skins(doc, &hierarchy),
        morphs: objects::morphs(doc),
        extensions: extension_list(doc),
        memory_bytes: load::load(doc, &hierarchy).plus(texels).peak_bytes(),
        textures,
        warnings: doc.take_warnings().into_iter().map(|w| w.0).collect(),
    })
}

fn counts(doc: &Document<'_>, hierarchy: &Hierarchy) -> Counts {
    let root = &doc.root;
    let primitives = root.meshes.iter().flat_map(|m| &m.primitives);
    Counts {
        nodes: root.nodes.len(),
        visible_nodes: hierarchy.order.len(),
        meshes: root.meshes.len(),
        materials: root.materials.len(),
        skins: root.skins.len(),
        morphed: primitives.filter(|p| p.targets.as_ref().is_some_and(|t| !t.is_empty())).count(),
        ..Counts::default()
    }
}

fn textures(doc: &Document<'_>) -> Vec<TextureInfo> {
    let one = |(i, image): (usize, &json::Image)| {
        let name = label("image", i, image.name.as_deref());
        match texture::size(doc, i, &name) {
            Ok([width, height]) => TextureInfo { name, width, height, error: None },
            Err(e) => TextureInfo { name, error: Some(e.to_string()), ..TextureInfo::default() },
        }
    };
    doc.root.images.iter().enumerate().map(one).collect()
}

/// Factors alone decide: a texture may still be black.
fn emissive(doc: &Document<'_>) -> Vec<EmissiveInfo> {
    let one = |(name, m): (String, &json::Material)| {
        let strength = m.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |e| e.emissive_strength.0);
        let radiance = m.emissive_factor.0.map(|c| c * strength);
        let emits = radiance.iter().any(|&c| c > 0.0);
        emits.then(|| EmissiveInfo { name, radiance, textured: m.emissive_texture.is_some() })
    };
    objects::materials(doc).into_iter().zip(&doc.root.materials).filter_map(one).collect()
}

fn light_unit(doc: &Document<'_>) -> Option<LightUnitInfo> {
    let taken = TakenUnit::new(doc.options.light_unit, doc.root.asset.generator.as_deref());
    let there = doc.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    there
        .filter(|l| !l.lights.is_empty())
        .map(|_| LightUnitInfo { unit: taken.unit().to_string(), why: taken.why })
}

fn extension_list(doc: &Document<'_>) -> Vec<ExtensionInfo> {
    let required: BTreeSet<&str> = container::names(&doc.value, "extensionsRequired").into_iter().collect();
    let mut names = container::names(&doc.value, "extensionsUsed");
    names.extend(required.iter().copied());
    names.extend(extensions::used(&doc.value));
    names.sort_unstable();
    names.dedup();
    let required: std::collections::BTreeSet<&str> = required.into_iter().collect();
    let one = |name: &str| ExtensionInfo {
        name: name.to_owned(),
        required: required.contains(name),
        supported: extensions::is_supported(name),
    };
    names.into_iter().map(one).collect()
}
