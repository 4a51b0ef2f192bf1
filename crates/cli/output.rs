//! Output files: the extension selects the format, and everything is checked before rendering starts.

use crate::error::Failure;
use crate::options::RenderOptions;
use crate::saving;
use dapple_integrator::imaging::picture::MetaValue;
use dapple_integrator::imaging::write::{self, Depth, PngDepth, PngOptions};
use dapple_integrator::imaging::{Image, ImageError, Tone};
use dapple_integrator::{Aov, Outcome};
use std::path::{Path, PathBuf};

/// Image formats, selected by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Exr,
    Png,
    Hdr,
    /// A part of a render for `dapple merge`.
    Part,
}

/// The files to write, with their formats and settings.
#[derive(Debug)]
pub struct Outputs {
    files: Vec<(PathBuf, Format)>,
    depth: Depth,
    png_depth: PngDepth,
    tone: Tone,
    /// Exposure in stops; none until it is metered.
    exposure: Option<f32>,
}

/// Rejects a default file name that is a symbolic link: whoever created the link would choose the file to overwrite.
pub fn refuse_link(path: &Path) -> Result<(), Failure> {
    if !path.is_symlink() {
        return Ok(());
    }
    Err(Failure::Arguments(format!(
        "{}: is a symbolic link; name the file with -o to overwrite its target",
        path.display()
    )))
}

impl Outputs {
    /// Returns the requested files, or `NAME.exr` and, if the image is shown, `NAME.png` in the current folder; fails
    /// if a file cannot be written.
    pub fn plan(options: &RenderOptions, name: &str) -> Result<Self, Failure> {
        let formats = if options.shows_picture() { &["exr", "png"][..] } else { &["exr"] };
        let default = || formats.iter().map(|format| PathBuf::from(format!("{name}.{format}"))).collect();
        let paths = options.output.clone().unwrap_or_else(default);
        let files = paths.into_iter().map(with_format).collect::<Result<Vec<_>, _>>()?;
        for (path, format) in &files {
            if options.output.is_none() {
                refuse_link(path)?;
            }
            match format {
                Format::Part => write::probe(path)?,
                _ => write::check(path)?,
            }
        }
        refuse_same(&files)?;
        let depth = if RenderOptions::is(options.half) { Depth::Half } else { Depth::Float };
        let (tone, exposure) = (options.tone.unwrap_or_default(), options.exposure);
        let png_depth = options.png_depth.unwrap_or_default();
        Ok(Self { files, depth, png_depth, tone, exposure })
    }

    /// Returns the same outputs under the names of images that are not finished: `NAME.partial.EXT`.
    pub fn partial(&self) -> Self {
        let named = |path: &PathBuf| match path.extension() {
            Some(extension) => path.with_extension(format!("partial.{}", extension.to_string_lossy())),
            None => path.with_extension("partial"),
        };
        let images = self.files.iter().filter(|(_, format)| *format != Format::Part);
        let files = images.map(|(path, format)| (named(path), *format)).collect();
        Self { files, ..*self }
    }

    /// Leaves out the files that are not to be kept.
    pub fn keep(&mut self, keep: impl Fn(&Path) -> bool) {
        self.files.retain(|(path, _)| keep(path));
    }

    /// Writes all files; returns those that were written, and the errors of the others.
    pub fn try_write(
        &self,
        outcome: &Outcome,
        picture: &Image,
        comment: Option<&str>,
    ) -> (Vec<PathBuf>, Vec<ImageError>) {
        let (mut written, mut failed) = (Vec::new(), Vec::new());
        for (path, format) in &self.files {
            match self.one(path, *format, (outcome, picture, comment)) {
                Ok(()) => written.push(path.clone()),
                Err(error) => failed.push(error),
            }
        }
        (written, failed)
    }

    fn one(
        &self,
        path: &Path,
        format: Format,
        (outcome, picture, comment): (&Outcome, &Image, Option<&str>),
    ) -> Result<(), ImageError> {
        match format {
            Format::Exr => write::exr(path, &outcome.layers, self.depth),
            Format::Png => self.png(path, outcome, picture, comment),
            Format::Hdr => write::hdr(path, picture),
            Format::Part => Ok(()),
        }
    }

    /// Writes all files, even if some fail; `comment` goes into the PNG metadata.
    pub fn write(&self, outcome: &Outcome, picture: &Image, comment: Option<&str>) -> Written {
        let mut written = Written::default();
        for (path, format) in self.files.iter().filter(|(_, format)| *format != Format::Part) {
            let at = saving::save(path, |path| self.one(path, *format, (outcome, picture, comment)));
            if at.as_ref() != Some(path) {
                written.failed.push(path.clone());
            }
            written.paths.extend(at);
        }
        written
    }

    /// Returns the size of an image per pixel in bytes, without compression; none for a part, and for other files.
    pub fn bytes_per_pixel(&self, path: &Path, options: &RenderOptions) -> Option<u64> {
        let (_, format) = self.files.iter().find(|(file, _)| file == path)?;
        let colours = if RenderOptions::is(options.transparent) { 4 } else { 3 };
        match format {
            Format::Exr => {
                let channels = |aov: &Aov| match aov {
                    Aov::Depth | Aov::SampleCount | Aov::ObjectId | Aov::MaterialId => 1,
                    Aov::Cryptomatte => 24,
                    _ => 4,
                };
                let layers: u64 = options.layers().iter().map(channels).sum();
                Some((colours + layers) * if self.depth == Depth::Half { 2 } else { 4 })
            }
            Format::Png => Some(colours * if self.png_depth == PngDepth::Sixteen { 2 } else { 1 }),
            Format::Hdr => Some(5),
            Format::Part => None,
        }
    }

    /// Returns the paths of the parts among the files.
    pub fn parts(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().filter(|(_, format)| *format == Format::Part).map(|(path, _)| path.as_path())
    }

    /// Writes the parts, and adds them to what was written; those that lack requested samples under the name
    /// `NAME.partial.part`.
    pub fn write_parts(&self, bytes: &[u8], is_whole: bool, written: &mut Written) {
        for path in self.parts() {
            let path = if is_whole { path.to_path_buf() } else { path.with_extension("partial.part") };
            let at = saving::save(&path, |path| write::replace(path, bytes));
            if at.as_ref() != Some(&path) {
                written.failed.push(path);
            }
            written.paths.extend(at);
        }
    }

    fn png(
        &self,
        path: &Path,
        outcome: &Outcome,
        picture: &Image,
        comment: Option<&str>,
    ) -> Result<(), ImageError> {
        let said = |key: &str| outcome.layers.metadata.iter().find(|(name, _)| name == key);
        let text = |key: &str| match said(key) {
            Some((_, MetaValue::Text(text))) => text.clone(),
            _ => String::new(),
        };
        let (software, exposure) = (text("software"), self.exposure.unwrap_or(0.0));
        let bits = if self.png_depth == PngDepth::Sixteen { 16 } else { 8 };
        let shown = format!("exposure = {exposure}\ntone = \"{}\"\npng-depth = {bits}", self.tone);
        let settings = format!("{}\n{shown}", text("settings"));
        let mut texts = vec![("Software", software.as_str()), ("settings", settings.as_str())];
        texts.extend(comment.map(|comment| ("Comment", comment)));
        let beauty = outcome.layers.layer("");
        let alpha = beauty.and_then(|layer| layer.channels.iter().find(|(name, _)| name == "A"));
        let options = PngOptions {
            tone: self.tone,
            exposure,
            depth: self.png_depth,
            alpha: alpha.map(|(_, values)| values.as_slice()),
            texts: &texts,
        };
        write::png_with(path, picture, &options)
    }

    /// Whether one of the formats cannot store alpha.
    pub fn drops_alpha(&self) -> bool {
        self.files.iter().any(|(_, format)| *format == Format::Hdr)
    }

    /// Sets the exposure by `meter` if a PNG needs one and none was given.
    pub fn expose(&mut self, meter: impl FnOnce() -> f32) {
        if self.exposure.is_none() && self.files.iter().any(|(_, format)| *format == Format::Png) {
            self.exposure = Some(meter());
        }
    }

    /// Returns the exposure of PNG output in stops; none if no PNG is written.
    pub fn exposure(&self) -> Option<f32> {
        self.exposure.filter(|_| self.files.iter().any(|(_, format)| *format == Format::Png))
    }

    /// Returns the paths of the files.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|(path, _)| path.as_path())
    }
}

/// Result of writing the files.
#[derive(Debug, Default)]
pub struct Written {
    /// Paths of the written images.
    pub paths: Vec<PathBuf>,
    /// Requested paths at which nothing was written.
    pub failed: Vec<PathBuf>,
}

/// Rejects two outputs that are the same file, by whatever paths: one image would overwrite the other.
fn refuse_same(files: &[(PathBuf, Format)]) -> Result<(), Failure> {
    let mut known: Vec<(PathBuf, &Path)> = Vec::new();
    for (path, _) in files {
        let at = write::destination(path)?;
        if let Some((_, other)) = known.iter().find(|(there, _)| *there == at) {
            return Err(Failure::Arguments(format!(
                "{}: is the same file as the output {}; name every output once",
                path.display(),
                other.display()
            )));
        }
        known.push((at, path));
    }
    Ok(())
}

fn with_format(path: PathBuf) -> Result<(PathBuf, Format), Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("exr") => Ok((path, Format::Exr)),
        Some("png") => Ok((path, Format::Png)),
        Some("hdr") => Ok((path, Format::Hdr)),
        Some("part") => Ok((path, Format::Part)),
        _ => Err(Failure::Arguments(format!(
            "{}: unknown image format; the extension selects it: use .exr, .png or .hdr, or .part for a part of a render",
            path.display()
        ))),
    }
}
