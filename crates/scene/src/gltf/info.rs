//! What is in a file, for people: counts, names, sizes, extensions. Only as much is read as that takes: mesh data
//! stay where they are.
mod choices;
mod counts;
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
pub use counts::Counts;
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
    let mut counts = counts::counts(doc, &hierarchy);
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
