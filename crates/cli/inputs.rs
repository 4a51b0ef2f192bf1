//! Protection of input files: outputs are compared with every input before work begins, so that none is overwritten.

use crate::error::Failure;
use crate::load::Source;
use crate::options::{NO_ENVIRONMENT, RenderOptions};
use crate::settings_file;
use same_file::Handle;
use std::path::{Path, PathBuf};

/// Files that a command reads, each with a description for messages.
#[derive(Clone, Debug, Default)]
pub struct Inputs(Vec<(&'static str, PathBuf)>);

impl Inputs {
    /// Returns the inputs of a render of `source` with `options`, before the scene is opened.
    pub fn of_render(source: &Source, options: &RenderOptions) -> Self {
        let mut inputs = Self::default();
        inputs.add_render(source, options);
        inputs
    }

    /// Adds the inputs of a render.
    pub fn add_render(&mut self, source: &Source, options: &RenderOptions) {
        if let Some(scene) = source.path() {
            self.add("the scene", scene);
            if let Some(sidecar) = settings_file::sidecar(scene) {
                self.add("the scene's settings file", &sidecar);
            }
        }
        if let Some(settings) = &options.settings {
            self.add("the settings file", settings);
        }
        if let Some(environment) = options.env.as_ref().filter(|env| env.as_os_str() != NO_ENVIRONMENT) {
            self.add("the environment map", environment);
        }
    }

    /// Adds a file.
    pub fn add(&mut self, what: &'static str, path: &Path) {
        self.0.push((what, path.to_path_buf()));
    }

    /// Adds the files that the scene refers to: buffers and images, whether read or not.
    pub fn add_scene_files(&mut self, files: &[PathBuf]) {
        self.0.extend(files.iter().map(|path| ("a file of the scene", path.clone())));
    }

    /// Rejects an output that is one of the inputs, however its path is written: by another path, a symbolic or hard
    /// link, or in other letter case on a case-insensitive file system.
    pub fn spare<'a>(&self, outputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
        for output in outputs {
            let Some(there) = handle(output) else { continue };
            let same = |(_, input): &&(&str, PathBuf)| handle(input).is_some_and(|at| at == there);
            if let Some((what, input)) = self.0.iter().find(same) {
                let said = format!(
                    "{}: is {what} ({}), which would be overwritten; choose another output",
                    output.display(),
                    input.display()
                );
                return Err(Failure::Arguments(said));
            }
        }
        Ok(())
    }
}

/// Identifies the file that a path leads to. None for a missing or unreadable file, which has nothing to lose, and for
/// anything but a regular file: opening a pipe would wait for its other end.
fn handle(path: &Path) -> Option<Handle> {
    path.metadata().ok().filter(|at| at.is_file())?;
    Handle::from_path(path).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_file_is_known_by_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        fs::write(at("in.png"), "").unwrap();
        fs::write(at("other.png"), "").unwrap();
        let mut inputs = Inputs::default();
        inputs.add("the reference", &at("in.png"));
        inputs.add("the image", &at("missing.png"));
        let spare = |name: &str| inputs.spare([at(name).as_path()]);
        assert!(spare("other.png").is_ok() && spare("missing.png").is_ok() && spare("new.png").is_ok());
        for name in ["in.png", "sub/../in.png"] {
            let said = spare(name).unwrap_err().to_string();
            assert!(said.contains("the reference") && said.contains("in.png"), "{said}");
        }
        #[cfg(unix)]
        {
            fs::hard_link(at("in.png"), at("hard.png")).unwrap();
            std::os::unix::fs::symlink(at("in.png"), at("soft.png")).unwrap();
            assert!(spare("hard.png").is_err() && spare("soft.png").is_err());
        }
    }
}
