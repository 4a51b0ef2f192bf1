//! Arguments of the commands that compare images, renderers and estimators; available with the feature `report`.

use crate::aliases;
use crate::options::RenderOptions;
use crate::values::{self, Seconds, Threshold};
use clap::{Args, Subcommand, ValueEnum};
use dapple_integrator::Effect;
use dapple_integrator::sampling::Pattern;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub enum Study {
    /// Run the numerical stress cases on this build and machine
    Stress(StressArgs),
    /// Check both tracers and every estimator against closed-form solutions
    Verify(VerifyArgs),
    /// Measure the error of an image against a reference
    ///
    /// Measures are means over pixels and channels of linear radiance, I the image, R the reference: mse of (I - R)^2,
    /// relmse of (I - R)^2 / (R^2 + epsilon) with R of the same channel of the same pixel, mape of |I - R| / (|R| +
    /// epsilon), smape of
    /// |I - R| / (|I| + |R| + epsilon); relative_rmse is the root of mse over the mean of R. With --reference-half the square is
    /// (I - R1)(I - R2), which is free of the noise of both, and any other R is their mean. `dapple converge` and
    /// `dapple sheet` use the same measures. For crops (.exr), only the pixels that all files contain are compared.
    Diff(DiffArgs),
    /// Plot error against render time for several methods
    Converge(Box<ConvergeArgs>),
    /// Attribute the error of an image to its sources, and predict the cost of less error
    ///
    /// The estimates come from a pilot render, which continues while confidence intervals are wider than a factor of 4,
    /// up to a fixed number of rays or to --time-limit if that is given. An interval whose ends differ by more than a
    /// factor of 100 is reported as unknown.
    Budget(Box<BudgetArgs>),
    /// Render a contact sheet of one effect with several sample counts and estimators
    ///
    /// Uses the distribution tracer. Effects that no option mentions are off, so that only the varied effect
    /// contributes error; lights keep their samples only where reflections or refractions are varied. Cells are 256
    /// pixels high unless --size or --reference sets another size. The expected cost is printed first; when
    /// --time-limit, which includes the reference, expires, the sheet is written with the finished cells, the cheapest
    /// first (exit code 3).
    Sheet(Box<SheetArgs>),
}

/// Replaces help texts of render options that have another meaning for `converge` and `sheet`.
pub fn reworded(command: clap::Command) -> clap::Command {
    let said = "Output folder; an existing comparison in it is continued";
    command
        .mut_subcommand("sheet", |sheet| {
            sheet
                .mut_arg("output", |a| a.help("Output file, a .png [default: sheet.png]"))
                .mut_arg("spp", |a| a.help("Samples over the pixel area [default: 1, at its centre]"))
        })
        .mut_subcommand("converge", |converge| {
            let seed =
                "First seed of the runs; later runs count up from it, references use other seeds [default: 1]";
            let output = |a: clap::Arg| a.value_name("DIR").help(said).required(true);
            converge.mut_arg("output", output).mut_arg("seed", |a| a.help(seed))
        })
}

#[derive(Debug, Args)]
pub struct StressArgs {
    /// Run only these cases: comma-separated ids such as A03, or B* for all ids that begin with B
    #[arg(long, value_name = "ID,...")]
    pub case: Option<String>,
    /// Print the ids and titles of the cases without running them
    #[arg(long)]
    pub list: bool,
    /// Run every case at full length: up to 1e8 rays per case
    #[arg(long)]
    pub thorough: bool,
    /// Write a report page, stress.html, into this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print one JSON object instead of the table
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Print one JSON object instead of the table
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct DiffArgs {
    /// Image to measure: .exr, .hdr, .png, .jpg or .webp
    pub image: PathBuf,
    /// Reference image
    pub reference: PathBuf,
    /// A second, independent render of the reference; the errors then exclude the noise of the reference
    #[arg(long, value_name = "FILE")]
    pub reference_half: Option<PathBuf>,
    /// Write an error map: false colours as .png, the signed difference as .exr
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Quantity that the false colours show
    #[arg(long, value_name = "NAME", default_value = "relative")]
    pub map: ErrorMap,
    /// Exit with code 1 if the measure exceeds X; may be repeated
    #[arg(long, value_name = "MEASURE=X")]
    pub fail_above: Vec<Threshold>,
    /// Added to R^2 in relmse, to R in mape and smape
    #[arg(long, value_name = "X", default_value_t = 0.01, value_parser = values::positive64)]
    pub epsilon: f64,
    /// Peak signal value of psnr
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = values::positive64)]
    pub peak: f64,
    /// Memory limit of the command, such as 800M or 12G [default: the free memory of the machine or container, and for
    /// each file no more than is plausible for its size]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub memory_limit: Option<u64>,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Quantity that an error map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ErrorMap {
    /// Root of each pixel's relmse, on a logarithmic scale from 0.001 to 1
    Relative,
    /// Relative difference of luminance up to 1: red where too bright, blue where too dark
    Signed,
    /// FLIP from 0 to 1
    Flip,
}

#[derive(Debug, Args)]
pub struct ConvergeArgs {
    /// .gltf or .glb files, or builtin:NAME
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// Method to compare: a name and options of dapple render; may be repeated [default: path and distribution, each
    /// with three patterns]
    #[arg(long = "run", value_name = "NAME: OPTIONS", allow_hyphen_values = true)]
    pub runs: Vec<String>,
    /// Wall-clock time of the whole command
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = values::duration)]
    pub budget: Seconds,
    /// Minimum number of independent renders of each run
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub seeds: u32,
    /// Reference image, taken as exact [default: rendered, as two independent halves]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Another renderer: a name and a command with {scene}, {spp}, {out} and optionally {seed}, {threads} and {time};
    /// may be repeated
    ///
    /// The command writes an image of {spp} samples per pixel to {out}. Only its rendering time counts: with {time},
    /// the command writes into that file the seconds of rendering and, optionally, the processor seconds, as two
    /// numbers; without it, the start-up time is measured by runs at one sample per pixel and subtracted. The images
    /// are compared with a reference rendered by the same command, unless --shared-reference is given.
    #[arg(long, value_name = "NAME=COMMAND", allow_hyphen_values = true)]
    pub external: Vec<String>,
    /// Compare all runs with one reference, that of the first run or of --reference; systematic differences between two
    /// renderers or options then count as error
    #[arg(long)]
    pub shared_reference: bool,
    /// Effect whose sample count grows in runs of the distribution tracer
    #[arg(long, value_name = "EFFECT", default_value = "pixel", value_parser = values::effect)]
    pub vary: Effect,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[derive(Debug, Args)]
pub struct BudgetArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[derive(Debug, Args)]
pub struct SheetArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    /// Effect to vary: pixel, lens, time, light, glossy, refract or diffuse
    #[arg(long, value_name = "EFFECT", value_parser = values::effect)]
    pub vary: Effect,
    /// Sample counts, one column each, such as 1,9,36,100
    #[arg(long, value_name = "LIST", value_delimiter = ',', required = true, value_parser = values::point_count)]
    pub counts: Vec<u32>,
    /// Sampling patterns, one row each: grid, random, stratified, sobol
    #[arg(long, value_parser = aliases::named::<Pattern>(aliases::PATTERNS), value_name = "LIST", value_delimiter = ',', default_value = "grid,random,stratified")]
    pub estimators: Vec<Pattern>,
    /// Reference image, taken as exact [default: two halves by the path tracer, with 16 times the samples of the
    /// largest cell]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// A second, independent render of the reference; the errors then exclude the noise of the reference
    #[arg(long, value_name = "FILE", requires = "reference")]
    pub reference_half: Option<PathBuf>,
    #[command(flatten)]
    pub options: RenderOptions,
}
