//! Summary of the contents of a file: counts, names, sizes, extensions. Mesh data are not read.
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

/// Contents of a file. Objects, lights and cameras are those of the selected scene, variant and time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Info {
    /// The generator of the file, if given.
    pub generator: Option<String>,
    /// Counts of all items.
    pub counts: Counts,
    /// All scenes.
    pub scenes: Vec<SceneInfo>,
    /// All material variants.
    pub variants: Vec<VariantInfo>,
    /// All animations.
    pub animations: Vec<AnimationInfo>,
    /// Objects of the selected scene.
    pub objects: Vec<ObjectInfo>,
    /// Names of all materials.
    pub materials: Vec<String>,
    /// Materials that emit light.
    pub emissive: Vec<EmissiveInfo>,
    /// All images.
    pub textures: Vec<TextureInfo>,
    /// Punctual lights.
    pub lights: Vec<LightInfo>,
    /// Unit of the intensities of the punctual lights, and the reason; None without such lights.
    pub light_unit: Option<LightUnitInfo>,
    /// Cameras.
    pub cameras: Vec<CameraInfo>,
    /// Skins.
    pub skins: Vec<SkinInfo>,
    /// Morph targets.
    pub morphs: Vec<MorphInfo>,
    /// Extensions that the file uses.
    pub extensions: Vec<ExtensionInfo>,
    /// Approximate peak memory in bytes of the scene data while rendering; every instance counts.
    pub memory_bytes: u64,
    /// Differences between the file and what is rendered, as far as they are known without reading meshes.
    pub warnings: Vec<String>,
}

/// A material that emits light.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EmissiveInfo {
    /// Name of the material.
    pub name: String,
    /// Radiance in W·m⁻²·sr⁻¹ per channel: factor × strength, without the texture.
    pub radiance: [f32; 3],
    /// Whether a texture modulates the radiance.
    pub textured: bool,
}

/// An image.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TextureInfo {
    /// Name or file name.
    pub name: String,
    /// Width in pixels; 0 if the image cannot be read.
    pub width: usize,
    /// Height in pixels; 0 if the image cannot be read.
    pub height: usize,
    /// The reason why the image cannot be read, if so.
    pub error: Option<String>,
}

/// Unit of the intensities of punctual lights.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LightUnitInfo {
    /// `radiometric`, or `photometric` (intensities are divided by 683 lm/W).
    pub unit: String,
    /// The reason, as a clause.
    pub why: String,
}

/// A glTF extension.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ExtensionInfo {
    /// Name of the extension.
    pub name: String,
    /// Whether the file requires it.
    pub required: bool,
    /// Whether dapple supports it.
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

/// Materials whose emission factors are not zero; their textures may still be black.
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
