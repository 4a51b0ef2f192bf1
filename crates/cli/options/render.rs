//! The options of a render, as one plain struct: what is `None` was not said.
//!
//! The same struct is filled from the sidecar beside the scene, from `--settings` and from the command line,
//! in this order, each later layer replacing what it names. All three go through clap, so a key of a settings
//! file is by construction an option of the command line, with the same values and the same complaints.

use super::choice::ChoiceOptions;
use super::effects::EffectOptions;
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

/// What `--env` takes in place of a file.
pub const NO_ENVIRONMENT: &str = "none";

/// All options of `dapple render`; also the keys of settings files. A flag can be taken back: `--half=false`.
#[derive(Args, Clone, Debug, Default)]
pub struct RenderOptions {
    /// Where to write; the extension decides: .exr, .png or .hdr. May be repeated [default: NAME.exr and NAME.png in the current folder]
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Option<Vec<PathBuf>>,
    /// Write EXR channels as 16-bit half floats
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Output")]
    pub half: Option<bool>,
    /// Show nothing where no surface is, and write alpha
    ///
    /// Alpha is the share of a pixel that is covered, with associated colours in an EXR and unassociated ones in a PNG. The environment is not seen but still lights the scene; clear panes cover.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Output")]
    pub transparent: Option<bool>,
    /// Bits per channel of PNG output: 8 or 16 [default: 8]
    #[arg(long, value_name = "BITS", value_parser = values::png_depth, help_heading = "Output")]
    pub png_depth: Option<PngDepth>,
    /// EXR layers beside the picture, comma-separated: albedo, normal, depth, position, variance, samples, object, material, removed, cryptomatte (ids of objects and materials by name, for compositing), or all. Where these show first hits alone (all but variance, samples and removed), the picture is rendered only if `beauty` is named too, or a PNG or HDR shows it
    #[arg(long, value_parser = aliases::named::<Layers>(aliases::LAYERS), value_name = "LIST", value_delimiter = ',', help_heading = "Output")]
    pub aov: Option<Vec<Layers>>,
    /// Exposure of PNG output, in stops; 0 shows radiance 1 as white [default: metered on a small render of the whole frame, and said]
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = values::finite, help_heading = "Output")]
    pub exposure: Option<f32>,
    /// Tone curve of PNG output: srgb, agx, aces or neutral [default: srgb]
    #[arg(long, value_name = "NAME", value_parser = values::tone, help_heading = "Output")]
    pub tone: Option<Tone>,

    /// Which tracer: path or distribution [default: path]
    #[arg(long, value_name = "NAME", value_parser = values::method, help_heading = "Sampling")]
    pub method: Option<MethodKind>,
    /// Samples per pixel [default: 64, or as many as --time-limit allows or --error-limit needs]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Sampling")]
    pub spp: Option<u32>,
    /// Stop after this much rendering: 30s, 5m, 1h
    #[arg(long, value_name = "TIME", value_parser = values::duration, help_heading = "Sampling")]
    pub time_limit: Option<Seconds>,
    /// Stop as soon as the relative RMSE of the picture is known to be below X
    ///
    /// Known with --confidence, at 64 samples or more. Where light may be unseen so far no bound can be relied on (error_reliable in --json): the render goes on, without --spp and --time-limit to 16 times the samples at which the bound fell below X and 4096 at least, and ends with code 3
    #[arg(long, value_name = "X", value_parser = values::positive64, help_heading = "Sampling")]
    pub error_limit: Option<f64>,
    /// How sure --error-limit and the stated error bound are [default: 0.95]
    #[arg(long, value_name = "P", value_parser = values::confidence, help_heading = "Sampling")]
    pub confidence: Option<f64>,
    /// How sample points are placed: sobol, stratified, random or grid [default: sobol]
    #[arg(long, value_parser = aliases::named::<Pattern>(aliases::PATTERNS), value_name = "NAME", help_heading = "Sampling")]
    pub pattern: Option<Pattern>,
    /// After 16 samples of every pixel, take more where the error is and fewer elsewhere; --spp is then the mean over the picture
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub adaptive: Option<bool>,
    /// Seed of all random decisions
    #[arg(long, value_name = "N", help_heading = "Sampling")]
    pub seed: Option<u64>,
    /// Scattering events: 0 = emitters seen directly, 1 = direct light [default: 16]
    #[arg(long, value_name = "N", help_heading = "Sampling")]
    pub max_bounces: Option<u32>,
    /// Follow every path to --max-bounces
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub no_roulette: Option<bool>,
    /// Let no sample be brighter than X in any channel: fewer sparks, but light is lost, as the report says [default: off]
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = values::positive, help_heading = "Sampling")]
    pub clamp: Option<f32>,
    /// Let flat facets with smooth normals shadow themselves: the light's edge then runs along the facets
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub no_soft_terminator: Option<bool>,
    /// Let shadow rays pass smooth solid glass straight on, losing what is reflected and absorbed: an approximation without caustics
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Sampling")]
    pub transparent_shadows: Option<bool>,
    /// Pixel filter: box, box:RADIUS, tent, gaussian, mitchell or blackman-harris [default: box]
    #[arg(long, value_parser = aliases::named::<Filter>(aliases::FILTERS), value_name = "NAME", help_heading = "Sampling")]
    pub filter: Option<Filter>,
    /// Worker threads; the picture does not depend on it [default: what the scheduler or the system grants]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024), help_heading = "Sampling")]
    pub threads: Option<u32>,

    #[command(flatten)]
    pub effects: EffectOptions,

    /// Image size in pixels [default: 512 high, as wide as the camera asks for]
    #[arg(long, value_name = "WxH", help_heading = "View")]
    pub size: Option<Size>,
    /// Render only this part, in pixels from the top left, upper bounds exclusive
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, help_heading = "View")]
    pub crop: Option<Crop>,
    /// Camera by name or by index [default: the first]
    #[arg(long, value_name = "NAME|INDEX", help_heading = "View")]
    pub camera: Option<String>,
    #[command(flatten)]
    pub choice: ChoiceOptions,
    /// Time at which animation is evaluated, in seconds
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = values::finite64, help_heading = "View")]
    pub at: Option<f64>,
    /// When the shutter opens and closes, in seconds counted from --at: what moves meanwhile is blurred
    #[arg(long, value_name = "OPEN:CLOSE", allow_hyphen_values = true, value_parser = values::shutter, help_heading = "View")]
    pub shutter: Option<Shutter>,
    #[command(flatten)]
    pub view: ViewOptions,
    /// Back faces of single-sided materials: camera = hidden from the camera, as glTF asks, but not from light; shown = there for all; culled = there for none, not even for light [default: camera]
    #[arg(long, value_parser = aliases::named::<Backfaces>(aliases::BACKFACES), value_name = "NAME", help_heading = "View")]
    pub backfaces: Option<Backfaces>,
    /// The same as --backfaces culled
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, conflicts_with = "backfaces", help_heading = "View")]
    pub cull_backfaces: Option<bool>,

    /// Environment picture, latitude-longitude: .hdr or .exr; none = nothing
    ///
    /// None leaves out even the studio light that a scene without light of its own gets.
    #[arg(long, value_name = "FILE", conflicts_with = "env_color", help_heading = "Environment")]
    pub env: Option<PathBuf>,
    /// Environment of one colour, linear radiance
    #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, help_heading = "Environment")]
    pub env_color: Option<Color>,
    /// Turn the environment about the vertical axis
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = values::finite, help_heading = "Environment")]
    pub env_rotation: Option<f32>,
    /// Factor on the environment [default: 1]
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = values::non_negative, help_heading = "Environment")]
    pub env_intensity: Option<f32>,
    /// Take the nearest texel of the environment picture instead of interpolating between texels
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Environment")]
    pub env_nearest: Option<bool>,
    /// Interpolate between the texels of the environment picture, as is the default
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, conflicts_with = "env_nearest", help_heading = "Environment")]
    pub env_smooth: Option<bool>,

    /// What candela and lux of the file's point, spot and directional lights are taken as: radiometric (1 cd is 1 W/sr, 1 lx is 1 W/m²), photometric (divided by 683 lm/W), or auto: photometric if the file's generator is known to write that, such as Blender's exporter since 3.4.39 [default: auto]
    #[arg(long, value_parser = aliases::named::<LightUnit>(aliases::NONE), value_name = "NAME", help_heading = "Environment")]
    pub light_unit: Option<LightUnit>,

    /// smallest: leave out what the scene does not need; general: nothing, for comparison [default: smallest]
    #[arg(long, value_name = "NAME", value_parser = values::plan_kind, help_heading = "General")]
    pub plan: Option<PlanKind>,
    /// How much memory the command may take, such as 800M or 12G; more than that is refused before it is taken [default: what the machine or its container has free, and no more for a file than suits its size]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = "General")]
    pub memory_limit: Option<u64>,
    /// Settings from a TOML file whose keys are these options
    #[arg(long, value_name = "FILE.toml", help_heading = "General")]
    pub settings: Option<PathBuf>,
    /// Let the scene name files outside its own folder
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub allow_path: Option<bool>,
    /// Refuse a scene that names an image file which is not there, instead of leaving the texture out
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub strict: Option<bool>,
    /// Write seconds, samples, rays and error at each doubling of the samples, one JSON object per line
    #[arg(long, value_name = "FILE.jsonl", help_heading = "General")]
    pub log: Option<PathBuf>,
    /// Print one JSON object as the last line of standard output
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub json: Option<bool>,
    /// No progress bar, no summary
    #[arg(short, long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub quiet: Option<bool>,
    /// Say more about what is done
    #[arg(short, long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "General")]
    pub verbose: Option<bool>,

    /// What of all this a file beside the scene said, and nobody after it.
    #[arg(skip)]
    pub of_scene: OfScene,
}

/// A command that knows nothing but the options; parses layers that are not the command line.
pub fn command() -> clap::Command {
    RenderOptions::augment_args(clap::Command::new("settings").no_binary_name(true).disable_help_flag(true))
}

/// The long names of all options.
pub fn names() -> Vec<String> {
    ids().into_iter().map(|(name, _)| name).collect()
}

/// The long names of all options, each with the id by which matches know it.
pub fn ids() -> Vec<(String, String)> {
    let named = |a: &clap::Arg| Some((a.get_long()?.to_string(), a.get_id().to_string()));
    command().get_arguments().filter_map(named).collect()
}

impl RenderOptions {
    /// Lays parsed arguments over what is there. A later environment of one kind replaces one of the other kind, and a
    /// later camera a whole view.
    pub fn lay_matches(&mut self, matches: &ArgMatches) -> Result<(), Failure> {
        if matches.contains_id("env") {
            self.env_color = None;
        }
        if matches.contains_id("env_color") {
            self.env = None;
        }
        if ["camera", "look_from", "orbit"].iter().any(|id| matches.contains_id(id)) {
            (self.camera, self.view) = (None, ViewOptions::default());
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

    /// The samples asked for: 64 when neither a count nor a time nor an error is given.
    pub fn samples(&self) -> Option<u32> {
        let limited = self.time_limit.is_some() || self.error_limit.is_some();
        self.spp.or(if limited { None } else { Some(64) })
    }

    /// The layers asked for, each once.
    pub fn layers(&self) -> Vec<Aov> {
        let mut layers = Vec::new();
        for &aov in self.aov.iter().flatten().flat_map(|named| &named.0) {
            if !layers.contains(&aov) {
                layers.push(aov);
            }
        }
        layers
    }

    /// Which rays meet back faces.
    pub fn backfaces(&self) -> Backfaces {
        let older = |culled| if culled { Backfaces::Culled } else { Backfaces::Shown };
        self.backfaces.or(self.cull_backfaces.map(older)).unwrap_or_default()
    }

    /// `--env none`: nothing surrounds the scene, even if that leaves it dark.
    pub fn has_no_environment(&self) -> bool {
        self.env.as_deref() == Some(Path::new(NO_ENVIRONMENT))
    }

    /// Whether the environment picture is interpolated.
    pub fn is_env_smooth(&self) -> bool {
        self.env_smooth.unwrap_or(!Self::is(self.env_nearest))
    }

    /// When the shutter is open; an instant unless something else was asked for.
    #[cfg(feature = "gltf")]
    pub fn exposure(&self) -> Shutter {
        self.shutter.unwrap_or_default()
    }

    /// Whether everything is to be kept.
    pub fn is_general(&self) -> bool {
        self.plan == Some(PlanKind::General)
    }

    /// Whether anything shows the picture itself, or says something about it. Layers of the first hit do not; a file beside
    /// the scene may add some, but leave out no picture.
    pub fn shows_picture(&self) -> bool {
        let layers = self.layers();
        let first_hits = !layers.is_empty() && layers.iter().all(|aov| aov.needs_first_hit());
        let is_exr = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        self.of_scene.set("aov")
            || !first_hits
            || !self.output.iter().flatten().all(is_exr)
            || self.error_limit.is_some()
            || self.log.is_some()
            || Self::is(self.adaptive)
    }

    /// What the render looks at of surfaces.
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

    /// A flag that was never mentioned is off.
    pub fn is(flag: Option<bool>) -> bool {
        flag.unwrap_or(false)
    }
}
