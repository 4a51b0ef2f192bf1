//! How a file is to be read, and what of it is to be shown.
use crate::{LightUnit, Reads};
use dapple_camera::Shutter;
use dapple_imaging::MemoryLimit;

/// How to read a file.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Seconds at which animation is evaluated.
    pub at: f64,
    /// When the picture is exposed, counted from `at`; what moves meanwhile is blurred.
    pub shutter: Shutter,
    /// Read files outside the scene's folder.
    pub allow_path: bool,
    /// Refuse a file that names an image which is not there, instead of leaving the texture out.
    pub strict: bool,
    /// What is looked at; the rest is not read.
    pub reads: Reads,
    /// How much memory the scene may take.
    pub memory: MemoryLimit,
    /// Which scene, variant and animation.
    pub choice: Choice,
    /// The unit of the punctual lights.
    pub light_unit: LightUnit,
}

/// What to show, each by its name or its index; a name is looked for first. None is what the file says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// The scene; without it the default scene, or the first one if the file names none.
    pub scene: Option<String>,
    /// The variant of KHR_materials_variants; without it every primitive has its own material.
    pub variant: Option<String>,
    /// The animation, or `all`; without it the first one. Where several move the same property of a node, the first of
    /// them counts.
    pub animation: Option<String>,
}
