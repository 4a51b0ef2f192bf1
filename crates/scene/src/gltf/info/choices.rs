//! Scenes, material variants and animations of a file.
use super::super::{animation, choose, choose::Selected, document::Document};
use serde::Serialize;

/// A scene of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SceneInfo {
    /// Index, which `--scene` accepts as well as the name.
    pub index: usize,
    /// Name, if it has one.
    pub name: Option<String>,
    /// Number of its root nodes.
    pub roots: usize,
    /// Whether it is the default scene of the file.
    pub default: bool,
    /// Whether it is the selected one.
    pub shown: bool,
}

/// A variant of KHR_materials_variants.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct VariantInfo {
    /// Index, which `--variant` accepts as well as the name.
    pub index: usize,
    /// Name, if it has one.
    pub name: Option<String>,
    /// Number of primitives of the file whose material it replaces.
    pub primitives: usize,
    /// Whether it is the selected one.
    pub shown: bool,
}

/// An animation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AnimationInfo {
    /// Index, which `--animation` accepts as well as the name.
    pub index: usize,
    /// Name, if it has one.
    pub name: Option<String>,
    /// Time of the first key in seconds.
    pub start: f64,
    /// Time of the last key in seconds.
    pub end: f64,
    /// Time from the first key to the last one in seconds.
    pub length: f64,
    /// Number of channels that animate nodes.
    pub channels: usize,
    /// Whether it is played.
    pub played: bool,
    /// The reason why its keys cannot be read, if so.
    pub error: Option<String>,
}

pub(super) fn scenes(doc: &Document<'_>, selected: &Selected) -> Vec<SceneInfo> {
    let one = |(index, scene): (usize, &gltf::json::Scene)| SceneInfo {
        index,
        name: own(scene.name.as_deref()),
        roots: scene.nodes.len(),
        default: doc.root.scene.is_some_and(|s| s.value() == index),
        shown: selected.scene == Some(index),
    };
    doc.root.scenes.iter().enumerate().map(one).collect()
}

pub(super) fn variants(doc: &Document<'_>, selected: &Selected) -> Vec<VariantInfo> {
    let names = choose::variants(doc);
    let mut primitives = vec![0; names.len()];
    for primitive in doc.root.meshes.iter().flat_map(|m| &m.primitives) {
        let mappings = primitive.extensions.as_ref().and_then(|e| e.khr_materials_variants.as_ref());
        for variant in mappings.into_iter().flat_map(|e| &e.mappings).flat_map(|m| &m.variants) {
            if let Some(count) = primitives.get_mut(*variant as usize) {
                *count += 1;
            }
        }
    }
    let one = |(index, (name, primitives)): (usize, (Option<&str>, usize))| VariantInfo {
        index,
        name: own(name),
        primitives,
        shown: selected.variant == Some(index),
    };
    names.into_iter().zip(primitives).enumerate().map(one).collect()
}

pub(super) fn animations(doc: &Document<'_>, selected: &Selected) -> Vec<AnimationInfo> {
    let spans = animation::spans(doc).into_iter();
    let mut played = vec![false; doc.root.animations.len()];
    selected.animations.iter().for_each(|&i| played[i] = true);
    let all = doc.root.animations.iter().zip(spans).zip(played).enumerate();
    all.map(|(index, ((animation, span), played))| {
        let error = span.as_ref().err().map(ToString::to_string);
        let (start, end) = span.unwrap_or_default();
        let (name, channels) = (own(animation.name.as_deref()), animation.channels.len());
        AnimationInfo { index, name, start, end, length: end - start, channels, played, error }
    })
    .collect()
}

/// A name, unless it is empty.
pub(super) fn own(name: Option<&str>) -> Option<String> {
    name.filter(|name| !name.is_empty()).map(str::to_owned)
}
