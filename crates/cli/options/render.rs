//! The options of a render, as one plain struct; `None` means that an option was not given.
//!
//! The same struct is filled from the sidecar beside the scene, from `--settings` and from the command line, in this
//! order; each later layer replaces the options that it names. All three are parsed by clap, so every key of a settings
//! file is an option of the command line, with the same values and the same error messages.

use super::choice::ChoiceOptions;
use super::effects::EffectOptions;
use super::frames::FrameOptions;
use super::long::LongOptions;
use super::sidecar::OfScene;
use super::view::ViewOptions;
use crate::aliases;
use crate::error::{self, Failure};
use crate::values::{self, Color, Crop, Layers, PlanKind, Seconds, Size};
use clap::{ArgMatches, Args, FromArgMatches};
use dapple_integrator::camera::{Filter, Shutter};
use dapple_integrator::imaging::Tone;
use dapple_integrator::imaging::write::PngDepth;
use dapple_integrator::sampling::Pattern;
use dapple_integrator::scene::{LightUnit, Reads};
use dapple_integrator::{Aov, Backfaces, MethodKind};
use std::path::{Path, PathBuf};

/// Value of `--env` that stands for no environment instead of a file.
pub const NO_ENVIRONMENT: &str = "none";

/// All options of `dapple render`; also the keys of settings files. A flag can be reset: `--half=false`.
#[derive(Args, Clone, Debug, Default)]
pub struct RenderOptions {
    /// Output file; the extension selects .exr, .png or .hdr. May be repeated [default: NAME.exr and NAME.png in the
    /// current folder]
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Option<Vec<PathBuf>>,
    /// Write colour channels of EXR files as 16-bit half floats; depth, positions and ids keep 32 bits
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Output")]
    pub half: Option<bool>,
    /// Make the background transparent and write alpha
    ///
    /// Alpha is the fraction of a pixel that surfaces cover; colours are associated (premultiplied) in an EXR and
    /// unassociated in a PNG. The environment is invisible but still lights the scene; clear glass counts as covered.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Output")]
    pub transparent: Option<bool>,
    /// Bits per channel of PNG output: 8 or 16 [default: 8]
    #[arg(long, value_name = "BITS", value_parser = values::png_depth, help_heading = "Output")]
    pub png_depth: Option<PngDepth>,
    /// Additional EXR layers, comma-separated: albedo, normal, depth, position, variance, samples, object, material,
    /// removed, cryptomatte (ids of objects and materials by name, for compositing), or all. If all requested layers
    /// need only the first hit (all but variance, samples and removed), the image itself is rendered only if `beauty`
    /// is listed too or an output is a PNG or HDR
    #[arg(long, value_parser = aliases::named::<Layers>(aliases::LAYERS), value_name = "LIST", value_delimiter = ',', help_heading = "Output")]
    pub aov: Option<Vec<Layers>>,
    /// Exposure of PNG output, in stops; 0 maps radiance 1 to white [default: metered on a small render of the whole
    /// frame, and printed]
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = values::finite, help_heading = "Output")]
    pub exposure: Option<f32>,
    /// Tone curve of PNG output: srgb, agx, aces or neutral [default: srgb]
    #[arg(long, value_name = "NAME", value_parser = values::tone, help_heading = "Output")]
    pub tone: Option<Tone>,

    /// Rendering method: path or distribution [default: path]
    #[arg(long, value_name = "NAME", value_parser = values::method, help_heading = "Sampling")]
    pub method: Option<MethodKind>,
    /// Samples per pixel [default: 64, or as many as --time-limit allows or --error-limit needs]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Sampling")]
    pub spp: Option<u32>,
    /// Stop rendering after this time: 30s, 5m, 1h
    #[arg(long, value_name = "TIME", value_parser = values::duration, help_heading = "Sampling")]
    pub time_limit: Option<Seconds>,
    /// Stop as soon as the relative RMSE of the image is known to be below X
    ///
    /// The error bound holds with --confidence, and is checked from 64 samples on. While light may still be unsampled,
    /// the bound is not reliable (error_reliable in --json) and the render continues; without --spp and --time-limit it
    /// ends with code 3 after 16 times the samples at which the bound first fell below X, and at least 4096
    #[arg(long, value_name = "X", value_parser = values::positive64, help_heading = "Sampling")]
    pub error_limit: Option<f64>,
    /// Confidence level of --error-limit and of the reported error bound [default: 0.95]
    #[arg(long, value_name = "P", value_parser = values::confidence, help_heading = "Sampling")]
    pub confidence: Option<f64>,
    /// Sampling pattern: sobol, stratified, random or grid [default: sobol]
    #[arg(long, value_parser = aliases::named::<Pattern>(aliases::PATTERNS), value_name = "NAME", help_heading = "Sampling")]
    pub pattern: Option<Pattern>,
    /// Adaptive sampling: after 16 samples of every pixel, take more where the error is large and fewer elsewhere;
    /// --spp is then the mean over the image
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub adaptive: Option<bool>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", help_heading = "Sampling")]
    pub seed: Option<u64>,
    /// Maximum number of scattering events: 0 = directly visible emitters, 1 = direct lighting [default: 16]
    #[arg(long, value_name = "N", help_heading = "Sampling")]
    pub max_bounces: Option<u32>,
    /// Disable Russian roulette: follow every path to --max-bounces
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub no_roulette: Option<bool>,
    /// Clamp every sample to X in each channel: fewer fireflies, but energy is lost, as the report states [default:
    /// off]
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = values::positive, help_heading = "Sampling")]
    pub clamp: Option<f32>,
    /// Disable the soft shadow terminator: coarse meshes with smooth normals then show the edges of their facets in
    /// shadow
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub no_soft_terminator: Option<bool>,
    /// Let shadow rays pass straight through smooth solid glass, attenuated by reflection and absorption: an
    /// approximation without caustics
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub transparent_shadows: Option<bool>,
    /// Pixel filter: box, box:RADIUS, tent, gaussian, mitchell or blackman-harris [default: box]
    #[arg(long, value_parser = aliases::named::<Filter>(aliases::FILTERS), value_name = "NAME", help_heading = "Sampling")]
    pub filter: Option<Filter>,
    /// Worker threads; the image does not depend on their number [default: the count granted by the scheduler or the
    /// system]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024), help_heading = "Sampling")]
    pub threads: Option<u32>,

    #[command(flatten)]
    pub effects: EffectOptions,

    /// Image size in pixels [default: 512 high, aspect ratio of the camera]
    #[arg(long, value_name = "WxH", help_heading = "View")]
    pub size: Option<Size>,
    /// Render only this region, in pixels from the top left, upper bounds exclusive
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, help_heading = "View")]
    pub crop: Option<Crop>,
    /// Camera, by name or index [default: the first]
    #[arg(long, value_name = "NAME|INDEX", help_heading = "View")]
    pub camera: Option<String>,
    #[command(flatten)]
    pub choice: ChoiceOptions,
    /// Time at which animations are evaluated, in seconds
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = values::finite64, help_heading = "View")]
    pub at: Option<f64>,
    /// Shutter interval in seconds relative to --at; objects that move during it are blurred
    #[arg(long, value_name = "OPEN:CLOSE", allow_hyphen_values = true, value_parser = values::shutter, help_heading = "View")]
    pub shutter: Option<Shutter>,
    #[command(flatten)]
    pub view: ViewOptions,
    /// Back faces of single-sided materials: camera = invisible to the camera, as glTF specifies, but not to light;
    /// shown = visible to all rays; culled = invisible to all rays, including shadow rays [default: camera]
    #[arg(long, value_parser = aliases::named::<Backfaces>(aliases::BACKFACES), value_name = "NAME", help_heading = "View")]
    pub backfaces: Option<Backfaces>,
    /// The same as --backfaces culled
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, conflicts_with = "backfaces", help_heading = "View")]
    pub cull_backfaces: Option<bool>,

    /// Environment map, latitude-longitude: .hdr or .exr; none = no environment
    ///
    /// The value none also disables the studio light that a scene without light of its own gets.
    #[arg(long, value_name = "FILE", conflicts_with = "env_color", help_heading = "Environment")]
    pub env: Option<PathBuf>,
    /// Environment of constant colour, linear radiance
    #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, help_heading = "Environment")]
    pub env_color: Option<Color>,
    /// Rotation of the environment about the vertical axis
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = values::finite, help_heading = "Environment")]
    pub env_rotation: Option<f32>,
    /// Factor on the radiance of the environment [default: 1]
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = values::non_negative, help_heading = "Environment")]
    pub env_intensity: Option<f32>,
    /// Look up the nearest texel of the environment map instead of interpolating
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Environment")]
    pub env_nearest: Option<bool>,
    /// Interpolate between the texels of the environment map (the default)
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, conflicts_with = "env_nearest", help_heading = "Environment")]
    pub env_smooth: Option<bool>,

    /// Interpretation of candela and lux of the file's point, spot and directional lights: radiometric (1 cd is 1 W/sr,
    /// 1 lx is 1 W/m²), photometric (divided by 683 lm/W), or auto: photometric if the file's generator is known to
    /// write photometric units, such as Blender's exporter since 3.4.39 [default: auto]
    #[arg(long, value_parser = aliases::named::<LightUnit>(aliases::NONE), value_name = "NAME", help_heading = "Environment")]
    pub light_unit: Option<LightUnit>,

    #[command(flatten)]
    pub frames: FrameOptions,
    #[command(flatten)]
    pub long: LongOptions,

    /// Rendering plan: smallest omits what the scene does not need; general omits nothing, for comparison [default:
    /// smallest]
    #[arg(long, value_name = "NAME", value_parser = values::plan_kind, help_heading = "General")]
    pub plan: Option<PlanKind>,
    /// Memory limit of the command, such as 800M or 12G; larger requests are refused before memory is allocated
    /// [default: the free memory of the machine or container, and for each file no more than is plausible for its size]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = "General")]
    pub memory_limit: Option<u64>,
    /// Read settings from a TOML file whose keys are these options
    #[arg(long, value_name = "FILE.toml", help_heading = "General")]
    pub settings: Option<PathBuf>,
    /// Allow the scene to refer to files outside its own folder
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub allow_path: Option<bool>,
    /// Reject a scene that refers to a missing image file, instead of omitting the texture
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub strict: Option<bool>,
    /// Write seconds, samples, rays and error at each doubling of the samples, one JSON object per line
    #[arg(long, value_name = "FILE.jsonl", help_heading = "General")]
    pub log: Option<PathBuf>,
    /// Print one JSON object as the last line of standard output
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub json: Option<bool>,
    /// Print no progress bar and no summary
    #[arg(short, long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub quiet: Option<bool>,
    /// Print more details
    #[arg(short, long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub verbose: Option<bool>,

    /// Images that are kept between the frames of a sequence.
    #[cfg(feature = "gltf")]
    #[arg(skip)]
    pub images: Option<dapple_integrator::scene::gltf::KeptImages>,
    /// Options whose values come from the sidecar and were not replaced by a later layer.
    #[arg(skip)]
    pub of_scene: OfScene,
}

/// Builds a command that has only the options; parses layers other than the command line.
pub fn command() -> clap::Command {
    RenderOptions::augment_args(clap::Command::new("settings").no_binary_name(true).disable_help_flag(true))
}

/// Returns the long names of all options.
pub fn names() -> Vec<String> {
    ids().into_iter().map(|(name, _)| name).collect()
}

/// Returns the long names of all options, each with its clap id.
pub fn ids() -> Vec<(String, String)> {
    let named = |a: &clap::Arg| Some((a.get_long()?.to_string(), a.get_id().to_string()));
    command().get_arguments().filter_map(named).collect()
}

impl RenderOptions {
    /// Overrides options with parsed arguments. A later environment of one kind replaces one of the other kind, and a
    /// later camera replaces a whole view.
    pub fn apply_matches(&mut self, matches: &ArgMatches) -> Result<(), Failure> {
        if matches.contains_id("env") {
            self.env_color = None;
        }
        if matches.contains_id("env_color") {
            self.env = None;
        }
        if ["camera", "look_from", "orbit"].iter().any(|id| matches.contains_id(id)) {
            (self.camera, self.view) = (None, ViewOptions::default());
        }
        if matches.contains_id("shutter") || matches.contains_id("shutter_angle") {
            (self.shutter, self.frames.shutter_angle) = (None, None);
        }
        if matches.contains_id("backfaces") || matches.contains_id("cull_backfaces") {
            (self.backfaces, self.cull_backfaces) = (None, None);
        }
        if matches.contains_id("env_nearest") || matches.contains_id("env_smooth") {
            (self.env_nearest, self.env_smooth) = (None, None);
        }
        let said = |key: &String| matches.try_contains_id(&key.replace('-', "_")).unwrap_or(false);
        self.of_scene.keys.retain(|key| !said(key));
        self.update_from_arg_matches(matches).map_err(|e| Failure::Arguments(error::clap_line(&e)))
    }

    /// Returns the requested samples per pixel: 64 when no count, time limit or error limit is given.
    pub fn samples(&self) -> Option<u32> {
        let limited = self.time_limit.is_some() || self.error_limit.is_some();
        self.spp.or(if limited { None } else { Some(64) })
    }

    /// Returns the requested layers, each once.
    pub fn layers(&self) -> Vec<Aov> {
        let mut layers = Vec::new();
        for &aov in self.aov.iter().flatten().flat_map(|named| &named.0) {
            if !layers.contains(&aov) {
                layers.push(aov);
            }
        }
        layers
    }

    /// Returns which rays intersect back faces.
    pub fn backfaces(&self) -> Backfaces {
        let older = |culled| if culled { Backfaces::Culled } else { Backfaces::Shown };
        self.backfaces.or(self.cull_backfaces.map(older)).unwrap_or_default()
    }

    /// Whether the environment is `--env none`: nothing surrounds the scene, even if that leaves it dark.
    pub fn has_no_environment(&self) -> bool {
        self.env.as_deref() == Some(Path::new(NO_ENVIRONMENT))
    }

    /// Whether lookups in the environment map are interpolated.
    pub fn is_env_smooth(&self) -> bool {
        self.env_smooth.unwrap_or(!Self::is(self.env_nearest))
    }

    /// Returns the shutter interval; an instant unless another one is requested.
    #[cfg(feature = "gltf")]
    pub fn exposure(&self) -> Shutter {
        let by_angle = || self.frames.shutter_seconds().map(|close| Shutter { open: 0.0, close });
        self.shutter.or_else(by_angle).unwrap_or_default()
    }

    /// Whether the general plan, which omits nothing, is requested.
    pub fn is_general(&self) -> bool {
        self.plan == Some(PlanKind::General)
    }

    /// Whether any output shows the image itself, or reports about it. First-hit layers do not; a sidecar may add
    /// layers but never suppress the image.
    pub fn shows_picture(&self) -> bool {
        let layers = self.layers();
        let first_hits = !layers.is_empty() && layers.iter().all(|aov| aov.needs_first_hit());
        let has_layers = |extension: &std::ffi::OsStr| {
            ["exr", "part"].iter().any(|known| extension.eq_ignore_ascii_case(known))
        };
        let is_exr = |path: &PathBuf| path.extension().is_some_and(has_layers);
        self.of_scene.set("aov")
            || !first_hits
            || !self.output.iter().flatten().all(is_exr)
            || self.error_limit.is_some()
            || self.log.is_some()
            || Self::is(self.adaptive)
    }

    /// Returns which surface properties the render reads.
    pub fn reads(&self) -> Reads {
        if self.is_general() {
            return Reads::EVERYTHING;
        }
        let layers = self.layers();
        let shows = |aov| layers.contains(&aov);
        let picture = self.shows_picture();
        Reads {
            light: picture,
            scattering: picture && self.max_bounces != Some(0),
            albedo: shows(Aov::Albedo),
            normals: shows(Aov::Normal),
            everything: false,
        }
    }

    /// Returns the value of a flag; a flag that was not given is off.
    pub fn is(flag: Option<bool>) -> bool {
        flag.unwrap_or(false)
    }
}
