//! Where pictures go: the extension decides the format, and everything is checked before rendering starts.

use crate::error::Failure;
use crate::options::RenderOptions;
use dapple_integrator::Outcome;
use dapple_integrator::imaging::write::{self, Depth};
use dapple_integrator::imaging::{Picture, Tone};
use std::path::{Path, PathBuf};

/// Formats by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Exr,
    Png,
    Hdr,
}

/// The files to write and how.
#[derive(Debug)]
pub struct Outputs {
    files: Vec<(PathBuf, Format)>,
    depth: Depth,
    tone: Tone,
    /// Stops; None until it is metered.
    exposure: Option<f32>,
}

impl Outputs {
    /// The files asked for, or `NAME.exr` and, of a picture, `NAME.png` in the current folder; fails if one cannot be written.
    pub fn plan(options: &RenderOptions, name: &str) -> Result<Self, Failure> {
        let formats = if options.shows_picture() { &["exr", "png"][..] } else { &["exr"] };
        let default = || formats.iter().map(|format| PathBuf::from(format!("{name}.{format}"))).collect();
        let paths = options.output.clone().unwrap_or_else(default);
        let files = paths.into_iter().map(with_format).collect::<Result<Vec<_>, _>>()?;
        for (path, _) in &files {
            write::check(path)?;
        }
        let depth = if RenderOptions::is(options.half) { Depth::Half } else { Depth::Float };
        let (tone, exposure) = (options.tone.unwrap_or_default(), options.exposure);
        Ok(Self { files, depth, tone, exposure })
    }

    /// Writes them all; a PNG says `comment` about itself.
    pub fn write(&self, outcome: &Outcome, picture: &Picture, comment: Option<&str>) -> Result<(), Failure> {
        for (path, format) in &self.files {
            match format {
                Format::Exr => write::exr(path, &outcome.layers, self.depth)?,
                Format::Png => {
                    let exposure = self.exposure.unwrap_or(0.0);
                    write::png_with_comment(path, picture, self.tone, exposure, comment)?;
                }
                Format::Hdr => write::hdr(path, picture)?,
            }
        }
        Ok(())
    }

    /// Sets the exposure by `meter` if a picture needs one and none was given.
    pub fn expose(&mut self, meter: impl FnOnce() -> f32) {
        if self.exposure.is_none() && self.files.iter().any(|(_, format)| *format == Format::Png) {
            self.exposure = Some(meter());
        }
    }

    /// Exposure of the PNG pictures in stops, if there are any.
    pub fn exposure(&self) -> Option<f32> {
        self.exposure.filter(|_| self.files.iter().any(|(_, format)| *format == Format::Png))
    }

    /// Their paths.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|(path, _)| path.as_path())
    }
}

fn with_format(path: PathBuf) -> Result<(PathBuf, Format), Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("exr") => Ok((path, Format::Exr)),
        Some("png") => Ok((path, Format::Png)),
        Some("hdr") => Ok((path, Format::Hdr)),
        _ => Err(Failure::Arguments(format!(
            "{}: the extension decides the format; use .exr, .png or .hdr",
            path.display()
        ))),
    }
}
