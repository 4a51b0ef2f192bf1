//! Which of a file's scenes, material variants and animations is rendered.

use crate::error::Failure;
use clap::Args;
#[cfg(feature = "gltf")]
use dapple_integrator::scene::gltf;

/// Names or indices; without them what the file says. Scene and variant are the file's own, so these are options of the view.
#[derive(Args, Clone, Debug, Default)]
pub struct ChoiceOptions {
    /// Scene of the file by name or by index [default: the file's default scene, else the first]
    // The scene to render has the plain id.
    #[arg(id = "scene_name", long = "scene", value_name = "NAME|INDEX", help_heading = "View")]
    pub scene: Option<String>,
    /// Material variant by name or by index (KHR_materials_variants) [default: the file's own materials]
    #[arg(long, value_name = "NAME|INDEX", help_heading = "View")]
    pub variant: Option<String>,
    /// Animation by name or by index, or all: where several move one node in the same way, the first of them counts [default: the first]
    #[arg(long, value_name = "NAME|INDEX|all", help_heading = "View")]
    pub animation: Option<String>,
}

impl ChoiceOptions {
    /// For the reader.
    #[cfg(feature = "gltf")]
    pub fn of_file(&self) -> gltf::Choice {
        let Self { scene, variant, animation } = self.clone();
        gltf::Choice { scene, variant, animation }
    }

    /// A built-in scene is one scene, without variants and animations.
    pub fn of_builtin(&self, name: &str) -> Result<(), Failure> {
        match self.given().next() {
            None => Ok(()),
            Some((option, value)) => Err(Failure::Arguments(format!(
                "--{option} {value}: builtin:{name} has nothing to choose from; the option is for .gltf and .glb files"
            ))),
        }
    }

    /// What was given, as keys and values of a settings file.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let all = [("scene", &self.scene), ("variant", &self.variant), ("animation", &self.animation)];
        all.into_iter().filter_map(|(key, value)| Some((key, value.as_deref()?)))
    }
}
