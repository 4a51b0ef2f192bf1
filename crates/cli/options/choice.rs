//! Options that select a scene, material variant and animation of a file.

use crate::error::Failure;
use clap::Args;
#[cfg(feature = "gltf")]
use dapple_integrator::scene::gltf;

/// Names or indices; the file's defaults apply where none is given. They depend on the file, so they count as view
/// options.
#[derive(Args, Clone, Debug, Default)]
pub struct ChoiceOptions {
    /// Scene of the file, by name or index [default: the file's default scene, else the first]
    // The id `scene` belongs to the positional argument.
    #[arg(id = "scene_name", long = "scene", value_name = "NAME|INDEX", help_heading = "View")]
    pub scene: Option<String>,
    /// Material variant, by name or index (KHR_materials_variants) [default: the file's own materials]
    #[arg(long, value_name = "NAME|INDEX", help_heading = "View")]
    pub variant: Option<String>,
    /// Animation, by name or index, or all; if several animate the same property of a node, the first one applies
    /// [default: the first]
    #[arg(long, value_name = "NAME|INDEX|all", help_heading = "View")]
    pub animation: Option<String>,
}

impl ChoiceOptions {
    /// Converts the options for the glTF reader.
    #[cfg(feature = "gltf")]
    pub fn of_file(&self) -> gltf::Choice {
        let Self { scene, variant, animation } = self.clone();
        gltf::Choice { scene, variant, animation }
    }

    /// Checks the options for a built-in scene, which has no scenes, variants or animations to select.
    pub fn of_builtin(&self, name: &str) -> Result<(), Failure> {
        match self.given().next() {
            None => Ok(()),
            Some((option, value)) => Err(Failure::Arguments(format!(
                "--{option} {value}: builtin:{name} has no alternatives; the option applies to .gltf and .glb files"
            ))),
        }
    }

    /// Iterates over the given options as keys and values of a settings file.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let all = [("scene", &self.scene), ("variant", &self.variant), ("animation", &self.animation)];
        all.into_iter().filter_map(|(key, value)| Some((key, value.as_deref()?)))
    }
}
