//! Options of the glTF reader.
use super::kept::KeptImages;
use crate::{LightUnit, Reads};
use dapple_camera::Shutter;
use dapple_imaging::MemoryLimit;

/// Options for reading a file.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Time in seconds at which animation is evaluated.
    pub at: f64,
    /// Opening and closing time of the shutter in seconds relative to `at`; motion in between is blurred.
    pub shutter: Shutter,
    /// Allows files outside the scene's folder.
    pub allow_path: bool,
    /// Treats a missing image file as an error instead of omitting the texture.
    pub strict: bool,
    /// The data that the render uses; everything else is not read.
    pub reads: Reads,
    /// Limit of the memory that the scene may take.
    pub memory: MemoryLimit,
    /// The scene, variant and animation to show.
    pub choice: Choice,
    /// The unit of the intensities of punctual lights.
    pub light_unit: LightUnit,
    /// Images that earlier readings of the same file have decoded; None decodes all images and keeps none.
    pub images: Option<KeptImages>,
}

/// The scene, variant and animation to show, each by name or index; names take precedence. None selects the default.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// The scene; None selects the file's default scene, or the first one if the file has no default.
    pub scene: Option<String>,
    /// The variant of KHR_materials_variants; None leaves every primitive its own material.
    pub variant: Option<String>,
    /// The animation, or `all`; None selects the first one. If several animate the same property of a node, the first
    /// of them is used.
    pub animation: Option<String>,
}
