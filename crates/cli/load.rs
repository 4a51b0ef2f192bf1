//! Loading: reads the file or built-in scene, and determines its environment, camera and image size.

use crate::effects;
use crate::error::{self, Failure};
use crate::first_sight;
use crate::memory;
use crate::options::RenderOptions;
use crate::say::say;
use crate::suggest;
use crate::values::Size;
use crate::verbose;
use crate::view;
use dapple_integrator::Aov;
use dapple_integrator::imaging::read;
use dapple_integrator::lights::Environment;
use dapple_integrator::math::PixelRect;
use dapple_integrator::scene::{NamedCamera, Scene, SceneBuilder, builtin};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Height of an image whose size is not given.
const DEFAULT_HEIGHT: u32 = 512;

/// Bytes per pixel at peak memory use: the films of the tiles and of the image, layers, the file being written.
const PIXEL_BYTES: u64 = 180;
/// Additional bytes per pixel for each extra layer.
const LAYER_BYTES: u64 = 100;
/// Additional bytes per pixel for each further node of the sums of its samples (see `dapple_camera::sums`).
const NODE_BYTES: u64 = 48;
/// Assumed number of samples, if it is not given.
const SAMPLES: u32 = 2500;

/// Source of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    Builtin(String),
    File(PathBuf),
}

impl Source {
    /// Parses `builtin:NAME` or a path; `None` means the Cornell box.
    pub fn new(scene: Option<&str>) -> Self {
        let scene = scene.unwrap_or("builtin:cornell");
        match scene.strip_prefix("builtin:") {
            Some(name) => Self::Builtin(name.into()),
            None => Self::File(scene.into()),
        }
    }

    /// Returns the path of a scene file; none for built-in scenes.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Builtin(_) => None,
        }
    }

    /// Returns the name of the scene, from which default output names are derived.
    pub fn name(&self) -> String {
        match self {
            Self::Builtin(name) => name.clone(),
            Self::File(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    /// Returns the scene file and the files that it refers to, which must not be overwritten. Meshes and images are not
    /// read.
    pub fn files(&self, options: &RenderOptions) -> Result<Vec<PathBuf>, Failure> {
        match self {
            Self::Builtin(_) => Ok(Vec::new()),
            Self::File(path) => files_of(path, options),
        }
    }

    /// Reads the parts of the scene, to which an environment may still be added.
    pub fn read(&self, options: &RenderOptions) -> Result<SceneBuilder, Failure> {
        match self {
            Self::Builtin(name) => {
                let mut builder = builtin::builtin(name).ok_or_else(|| unknown_builtin(name))?;
                options.choice.of_builtin(name)?;
                builder.reads(options.reads());
                Ok(builder)
            }
            Self::File(path) => read_file(path, options),
        }
    }
}

#[cfg(feature = "gltf")]
fn read_file(path: &Path, options: &RenderOptions) -> Result<SceneBuilder, Failure> {
    Ok(dapple_integrator::scene::gltf::read(path, &reader_options(options))?)
}

/// Converts the options for the glTF reader.
#[cfg(feature = "gltf")]
pub fn reader_options(options: &RenderOptions) -> dapple_integrator::scene::gltf::Options {
    let (at, shutter) = (options.at.unwrap_or(0.0), options.exposure());
    let (allow_path, strict) = (RenderOptions::is(options.allow_path), RenderOptions::is(options.strict));
    let (reads, choice) = (options.reads(), options.choice.of_file());
    let light_unit = options.light_unit.unwrap_or_default();
    let memory = memory::limit(options.memory_limit);
    let images = options.images.clone();
    dapple_integrator::scene::gltf::Options {
        at,
        shutter,
        allow_path,
        strict,
        reads,
        choice,
        light_unit,
        memory,
        images,
    }
}

#[cfg(feature = "gltf")]
fn files_of(path: &Path, options: &RenderOptions) -> Result<Vec<PathBuf>, Failure> {
    use dapple_integrator::scene::gltf;
    let (allow_path, memory) = (RenderOptions::is(options.allow_path), memory::limit(options.memory_limit));
    Ok(gltf::files(path, &gltf::Options { allow_path, memory, ..gltf::Options::default() })?)
}

#[cfg(not(feature = "gltf"))]
fn files_of(path: &Path, _: &RenderOptions) -> Result<Vec<PathBuf>, Failure> {
    Ok(vec![path.to_path_buf()])
}

#[cfg(not(feature = "gltf"))]
fn read_file(path: &Path, _: &RenderOptions) -> Result<SceneBuilder, Failure> {
    let said = format!("{}: this dapple was built without the glTF reader (feature gltf)", path.display());
    Err(Failure::Arguments(said))
}

fn unknown_builtin(name: &str) -> Failure {
    let names: Vec<&str> = builtin::NAMES.iter().map(|(name, _)| *name).collect();
    let meant = suggest::nearest(name, names.iter().copied());
    let meant = meant.map(|name| format!("did you mean builtin:{name}? ")).unwrap_or_default();
    let (name, all) = (error::short(name), names.join(", builtin:"));
    Failure::Arguments(format!(
        "builtin:{name}: there is no such built-in scene; {meant}choose from builtin:{all}"
    ))
}

/// A scene ready for rendering, and the time it took to load.
pub struct Loaded {
    pub scene: Scene,
    /// Notes for the user about further contents of the file.
    pub notes: Vec<String>,
    /// Seconds for reading and decoding files.
    pub load_seconds: f64,
    /// Seconds for validation and for building the acceleration structures and light tables.
    pub build_seconds: f64,
    /// Sum of both when the scene was loaded; both are zero for a scene that was kept.
    pub first_seconds: f64,
}

/// Reads the scene, adds the environment and builds the scene.
pub fn load(source: &Source, options: &RenderOptions) -> Result<Loaded, Failure> {
    let start = Instant::now();
    let mut builder = source.read(options)?;
    let environment = environment(options)?;
    let own_light_alone = environment.is_none() && !options.has_no_environment();
    if options.has_no_environment() {
        builder.no_default_light();
    }
    if let Some(environment) = environment {
        builder.environment(environment);
    }
    let quiet = RenderOptions::is(options.quiet);
    let notes = if quiet { Vec::new() } else { builder.notes().to_vec() };
    let load_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut scene = builder.build()?;
    let view = view::view(&scene, options)?;
    let Size { width, height } = size(options, &view);
    let bounds = first_sight::bounds(options, (width, height), own_light_alone);
    first_sight::settle(&mut scene, &view, &bounds);
    let build_seconds = start.elapsed().as_secs_f64();
    let first_seconds = load_seconds + build_seconds;
    let loaded = Loaded { scene, notes, load_seconds, build_seconds, first_seconds };
    if RenderOptions::is(options.verbose) {
        say(&verbose::scene(&loaded.scene, loaded.load_seconds, loaded.build_seconds));
    }
    Ok(loaded)
}

fn environment(options: &RenderOptions) -> Result<Option<Environment>, Failure> {
    if !options.reads().light {
        return Ok(None);
    }
    let intensity = options.env_intensity.unwrap_or(1.0);
    if let Some(color) = options.env_color {
        return Ok(Some(Environment::constant(color.0 * intensity)));
    }
    let Some(path) = options.env.as_ref().filter(|_| !options.has_no_environment()) else { return Ok(None) };
    let picture = read::picture_within(path, memory::left(options.memory_limit))?;
    let rotation = options.env_rotation.unwrap_or(0.0).to_radians();
    let smooth = options.is_env_smooth();
    let environment = Environment::picture(picture, rotation, intensity, smooth).map_err(|bad| {
        let reason = format!("texel ({}, {}) is {}, which is not a valid radiance", bad.x, bad.y, bad.value);
        Failure::Environment { path: path.clone(), reason }
    })?;
    Ok(Some(environment))
}

/// Returns the requested camera, with its lens.
pub fn camera(scene: &Scene, options: &RenderOptions) -> Result<NamedCamera, Failure> {
    let mut named = view::view(scene, options)?;
    view::note_held(scene, options);
    named.camera = effects::with_lens(named.camera, scene, options);
    Ok(named)
}

/// Returns the requested image size, or a height of 512 pixels with the aspect ratio of the camera.
pub fn size(options: &RenderOptions, camera: &NamedCamera) -> Size {
    options.size.unwrap_or_else(|| default_size(camera, DEFAULT_HEIGHT))
}

/// Returns the image size of the given height with the aspect ratio of the camera.
pub fn default_size(camera: &NamedCamera, height: u32) -> Size {
    let aspect = camera.aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(1.5);
    let width = (height as f32 * aspect.clamp(1.0 / 64.0, 64.0)).round().max(1.0) as u32;
    Size { width, height }
}

/// Returns the region to render, checked against the image size and the available memory.
pub fn rect(options: &RenderOptions, size: Size) -> Result<Option<PixelRect>, Failure> {
    let full = PixelRect { x0: 0, y0: 0, x1: size.width, y1: size.height };
    let rect = options.crop.map_or(full, |c| c.0);
    if rect.x1 > full.x1 || rect.y1 > full.y1 {
        let (w, h) = (size.width, size.height);
        return Err(Failure::Arguments(format!(
            "--crop: the region extends outside the image, which is {w}x{h}"
        )));
    }
    let pixels = u64::from(rect.x1 - rect.x0) * u64::from(rect.y1 - rect.y0);
    // Before the last sample there may be a node for each bit of a smaller number of samples.
    let nodes = NODE_BYTES * u64::from(samples(options).ilog2());
    let needed = pixels.saturating_mul(pixel_bytes(options) + nodes);
    memory::left(options.memory_limit).admit(needed, None).map_err(|overrun| {
        Failure::Arguments(format!(
            "--size: an image of {pixels} pixels {overrun}, or render it in parts with --crop"
        ))
    })?;
    Ok(options.crop.map(|c| c.0))
}

/// Returns the memory per pixel at peak use, in bytes.
pub fn pixel_bytes(options: &RenderOptions) -> u64 {
    // Cryptomatte has six layers of four channels, and intermediate data of each pixel.
    let layers = |aov: &Aov| if *aov == Aov::Cryptomatte { 6 } else { 1 };
    let layers = LAYER_BYTES * options.layers().iter().map(layers).sum::<u64>();
    // One node for each bit of the number of samples, in the tiles and in the image.
    let more = samples(options).count_ones() - 1;
    PIXEL_BYTES + layers + NODE_BYTES * u64::from(2 * more)
}

/// Samples per pixel; a typical number if it is not given.
fn samples(options: &RenderOptions) -> u32 {
    options.samples().unwrap_or(SAMPLES).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_have_names() {
        assert_eq!(Source::new(None), Source::Builtin("cornell".into()));
        assert_eq!(Source::new(Some("a/b.c.glb")).name(), "b.c");
        assert_eq!(Source::new(Some("builtin:x")).name(), "x");
    }

    #[test]
    fn crops_are_held_against_the_size() {
        let size = Size { width: 8, height: 4 };
        let crop = |text: &str| RenderOptions { crop: Some(text.parse().unwrap()), ..Default::default() };
        assert!(rect(&crop("0,0,8,4"), size).unwrap().is_some());
        assert!(rect(&crop("0,0,9,4"), size).is_err());
        assert!(rect(&crop("0,3,8,5"), size).is_err());
        assert!(rect(&RenderOptions::default(), size).unwrap().is_none());
        let huge = Size { width: 1 << 20, height: 1 << 20 };
        assert!(rect(&RenderOptions::default(), huge).is_err());
        assert!(rect(&crop("0,0,8,4"), huge).unwrap().is_some());
    }
}
