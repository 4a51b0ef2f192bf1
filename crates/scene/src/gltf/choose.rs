//! Selection of the scene, material variant and animations to show: the requested ones, or else the file's defaults.
use super::document::Document;
use super::options::Choice;
use crate::{SceneError, error::quoted};
use gltf::json::{self, Index};

/// Maximum number of items that one message lists.
const LISTED: usize = 20;
/// Value that selects all animations.
const ALL: &str = "all";

/// Indices of the selected items; every index is in range.
pub(super) struct Selected {
    /// None if the file has no scenes: all of its nodes are shown.
    pub scene: Option<usize>,
    pub variant: Option<usize>,
    /// In the order of the file.
    pub animations: Vec<usize>,
}

impl Selected {
    pub fn new(doc: &Document<'_>) -> Result<Self, SceneError> {
        let Choice { scene, variant, animation } = &doc.options.choice;
        let animations = names(&doc.root.animations, |a| a.name.as_deref());
        Ok(Self {
            scene: match (scene, doc.root.scene) {
                (Some(wanted), _) => Some(find(doc, "scene", wanted, &scenes(doc))?),
                (None, Some(index)) => {
                    doc.get(&doc.root.scenes, index, "scene", "the file")?;
                    Some(index.value())
                }
                (None, None) => (!doc.root.scenes.is_empty()).then_some(0),
            },
            variant: match variant {
                Some(wanted) => Some(find(doc, "variant", wanted, &variants(doc))?),
                None => None,
            },
            animations: match animation.as_deref() {
                Some(ALL) => (0..animations.len()).collect(),
                Some(wanted) => vec![find(doc, "animation", wanted, &animations)?],
                None => (0..animations.len().min(1)).collect(),
            },
        })
    }

    /// The material of a primitive: the one to which the variant maps it, or else its own.
    pub fn material(&self, primitive: &json::mesh::Primitive) -> Option<Index<json::Material>> {
        let extensions = primitive.extensions.as_ref();
        let mappings = extensions.and_then(|e| e.khr_materials_variants.as_ref()).map(|e| &e.mappings);
        let chosen = self.variant.and_then(|v| u32::try_from(v).ok()).and_then(|variant| {
            mappings.into_iter().flatten().find(|mapping| mapping.variants.contains(&variant))
        });
        chosen.map_or(primitive.material, |mapping| Some(Index::new(mapping.material)))
    }

    /// Notes on the alternatives in the file: one line for each kind of item for which no choice was made.
    pub fn notes(&self, doc: &Document<'_>) -> Vec<String> {
        let choice = &doc.options.choice;
        let mut notes = Vec::new();
        let others = |names: &[Option<&str>], shown: usize| {
            let others: Vec<usize> = (0..names.len()).filter(|i| *i != shown).collect();
            list(names, &others)
        };
        let scenes = scenes(doc);
        if let (None, Some(shown), 2..) = (&choice.scene, self.scene, scenes.len()) {
            let (one, others) = (one(&scenes, shown), others(&scenes, shown));
            notes.push(format!("scene {one} is shown; the file also has {others} (--scene)"));
        }
        let variants = variants(doc);
        if choice.variant.is_none() && !variants.is_empty() {
            let others = others(&variants, usize::MAX);
            notes.push(format!("no material variant is used; the file has {others} (--variant)"));
        }
        let animations = names(&doc.root.animations, |a| a.name.as_deref());
        if choice.animation.is_none() && animations.len() > 1 {
            let (one, others) = (one(&animations, 0), others(&animations, 0));
            notes.push(format!(
                "animation {one} is selected; the file also has {others} (--animation, or all)"
            ));
        }
        notes
    }
}

fn scenes<'a>(doc: &'a Document<'_>) -> Vec<Option<&'a str>> {
    names(&doc.root.scenes, |s| s.name.as_deref())
}

/// Names of the variants of the file.
pub(super) fn variants<'a>(doc: &'a Document<'_>) -> Vec<Option<&'a str>> {
    let extension = doc.root.extensions.as_ref().and_then(|e| e.khr_materials_variants.as_ref());
    names(extension.map_or(&[][..], |e| &e.variants), |v| Some(v.name.as_str()))
}

/// Names of items; an empty name counts as none.
fn names<T>(all: &[T], name: impl Fn(&T) -> Option<&str>) -> Vec<Option<&str>> {
    all.iter().map(|one| name(one).filter(|name| !name.is_empty())).collect()
}

/// The index of the item named `wanted`, or else `wanted` itself as an index. If several have this name, the first one
/// is used, with a warning.
fn find(doc: &Document<'_>, kind: &str, wanted: &str, names: &[Option<&str>]) -> Result<usize, SceneError> {
    let called: Vec<usize> = (0..names.len()).filter(|&i| names[i] == Some(wanted)).collect();
    let by_index = || wanted.parse::<usize>().ok().filter(|&i| i < names.len());
    if let [first, _, ..] = called[..] {
        let all = called.iter().take(LISTED).map(usize::to_string).collect::<Vec<_>>().join(", ");
        doc.warn(format!(
            "{} {kind}s are named '{}' ({all}): {kind} {first} is used; select another one by its index",
            called.len(),
            quoted(wanted)
        ));
    }
    called.first().copied().or_else(by_index).ok_or_else(|| SceneError::Choice {
        file: doc.file.clone(),
        kind: kind.to_owned(),
        wanted: wanted.to_owned(),
        there: list(names, &(0..names.len()).collect::<Vec<_>>()),
    })
}

/// Index and name of an item for messages.
fn one(names: &[Option<&str>], index: usize) -> String {
    match names.get(index).copied().flatten() {
        Some(name) => format!("{index} '{}'", quoted(name)),
        None => index.to_string(),
    }
}

/// The items at `which`, at most [`LISTED`] of them; empty if there are none.
fn list(names: &[Option<&str>], which: &[usize]) -> String {
    let shown: Vec<String> = which.iter().take(LISTED).map(|&i| one(names, i)).collect();
    match which.len().saturating_sub(LISTED) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_end() {
        let names = vec![Some("a"); 1000];
        assert_eq!(list(&names, &[]), "");
        assert_eq!(list(&[None, Some("b\u{1b}")], &[0, 1]), "0, 1 'b'");
        let all: Vec<usize> = (0..1000).collect();
        assert!(list(&names, &all).ends_with("19 'a' and 980 more"));
    }
}
