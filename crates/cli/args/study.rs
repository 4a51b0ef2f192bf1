//! Commands that study pictures and renderers: there with the feature `report`.

use crate::aliases;
use crate::options::RenderOptions;
use crate::values::{self, Seconds, Threshold};
use clap::{Args, Subcommand, ValueEnum};
use dapple_integrator::Effect;
use dapple_integrator::sampling::Pattern;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub enum Study {
    /// Check stiff and extreme cases on this build and machine
    Stress(StressArgs),
    /// Hold both tracers and every estimator against closed forms
    Verify(VerifyArgs),
    /// Measure how far a picture is from a reference
    ///
    /// Measures are means over pixels and channels of linear radiance, I the picture, R the reference: mse of (I - R)^2, relmse
    /// of (I - R)^2 / (R^2 + epsilon) with R of the same channel of the same pixel, mape of |I - R| / (|R| + epsilon), smape of
    /// |I - R| / (|I| + |R| + epsilon); relative_rmse is the root of mse over the mean of R. With --reference-half the square is
    /// (I - R1)(I - R2), which is free of the noise of both, and any other R is their mean. These are the measures of
    /// `dapple converge` and `dapple sheet` too. Of crops (.exr) the pixels that all files hold are compared.
    Diff(DiffArgs),
    /// Measure how much error is left after how many seconds, method against method
    Converge(Box<ConvergeArgs>),
    /// Say what makes the error of a picture, and what a picture of --error-limit will cost
    ///
    /// From a pilot of the picture, which goes on while intervals are wider than a factor of 4: up to a fixed number of rays, or
    /// to --time-limit if that is given. An interval whose ends are more than a factor of 100 apart is not known.
    Budget(Box<BudgetArgs>),
    /// Render one effect with several counts and estimators side by side
    ///
    /// By the distribution tracer. Every other effect that no option mentions is off, so that what is seen and measured is
    /// the varied one; only where reflections or refractions are varied do lights keep their points. Cells are 256 pixels
    /// high unless --size or a --reference says otherwise. What it will cost is said beforehand; at the end of --time-limit,
    /// which covers the reference too, the sheet is written with the cells that are done, the cheapest first (exit code 3).
    Sheet(Box<SheetArgs>),
}

/// What `converge` and `sheet` write is no picture of the scene.
pub fn reworded(command: clap::Command) -> clap::Command {
    let said = "The folder to write into; what is there already is continued";
    command
        .mut_subcommand("sheet", |sheet| {
            sheet
                .mut_arg("output", |a| a.help("Where to write the sheet, a .png [default: sheet.png]"))
                .mut_arg("spp", |a| a.help("Points over the pixel's area [default: one, its centre]"))
        })
        .mut_subcommand("converge", |converge| {
            let seed =
                "The first seed of the runs; further ones follow it, and references have theirs [default: 1]";
            let output = |a: clap::Arg| a.value_name("DIR").help(said).required(true);
            converge.mut_arg("output", output).mut_arg("seed", |a| a.help(seed))
        })
}

#[derive(Debug, Args)]
pub struct StressArgs {
    /// Only these: ids such as A03, or B* for all that begin with B, comma-separated
    #[arg(long, value_name = "ID,...")]
    pub case: Option<String>,
    /// Take as long as it needs: up to 1e8 rays per case
    #[arg(long)]
    pub thorough: bool,
    /// Write a page, stress.html, into this folder
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
    /// The picture: .exr, .hdr or .png
    pub image: PathBuf,
    /// What it should be
    pub reference: PathBuf,
    /// A second, independent render of the reference: then the errors do not contain the reference's own noise
    #[arg(long, value_name = "FILE")]
    pub reference_half: Option<PathBuf>,
    /// Write where the errors are: false colours as .png, the signed difference as .exr
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// What the false colours show
    #[arg(long, value_name = "NAME", default_value = "relative")]
    pub map: ErrorMap,
    /// Exit with code 1 if the measure exceeds X; may be repeated
    #[arg(long, value_name = "MEASURE=X")]
    pub fail_above: Vec<Threshold>,
    /// Added to R^2 in relmse, to R in mape and smape
    #[arg(long, value_name = "X", default_value_t = 0.01, value_parser = values::positive64)]
    pub epsilon: f64,
    /// Signal peak of psnr
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = values::positive64)]
    pub peak: f64,
    /// How much memory it may take, such as 800M or 12G [default: what the machine or its container has free, and no more for a file than suits its size]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub memory_limit: Option<u64>,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// What an error map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ErrorMap {
    /// Root of each pixel's relmse, logarithmic from 0.001 to 1
    Relative,
    /// Too bright red, too dark blue, by relative difference of luminance up to 1
    Signed,
    /// FLIP from 0 to 1
    Flip,
}

#[derive(Debug, Args)]
pub struct ConvergeArgs {
    /// .gltf or .glb files, or builtin:NAME
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// A method: a name and options of dapple render; may be repeated [default: path and distribution, each with three patterns]
    #[arg(long = "run", value_name = "NAME: OPTIONS", allow_hyphen_values = true)]
    pub runs: Vec<String>,
    /// Wall time of the whole command
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = values::duration)]
    pub budget: Seconds,
    /// Independent renders of every run, at least
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub seeds: u32,
    /// What the pictures should be, taken as exact [default: rendered here, as two independent halves]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Another renderer: a name and a command with {scene}, {spp}, {out} and, if it can, {seed}, {threads} and {time}; may be
    /// repeated
    ///
    /// The command writes a picture of {spp} samples per pixel to {out}. Its seconds are of rendering: if it has {time}, it
    /// writes into that file the seconds that it rendered and, if it likes, its processor seconds, as two numbers; else its
    /// start-up is measured by runs at one sample per pixel and subtracted. It is held against a reference of its own, rendered
    /// by the same command, unless there is --shared-reference.
    #[arg(long, value_name = "NAME=COMMAND", allow_hyphen_values = true)]
    pub external: Vec<String>,
    /// Hold everything against one reference, that of the first run or of --reference: what two renderers, or two options, show
    /// differently is then an error too
    #[arg(long)]
    pub shared_reference: bool,
    /// The integral whose count grows in runs of the distribution tracer
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
    /// What is varied: pixel, lens, time, light, glossy, refract or diffuse
    #[arg(long, value_name = "EFFECT", value_parser = values::effect)]
    pub vary: Effect,
    /// Numbers of points, one column each, such as 1,9,36,100
    #[arg(long, value_name = "LIST", value_delimiter = ',', required = true, value_parser = values::point_count)]
    pub counts: Vec<u32>,
    /// One row each: grid, random, stratified, sobol
    #[arg(long, value_parser = aliases::named::<Pattern>(aliases::PATTERNS), value_name = "LIST", value_delimiter = ',', default_value = "grid,random,stratified")]
    pub estimators: Vec<Pattern>,
    /// Measure errors against this picture, taken as exact [default: two halves by the path tracer, with 16 times the samples of
    /// the largest cell]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// A second, independent render of the reference: then the errors do not contain the reference's own noise
    #[arg(long, value_name = "FILE", requires = "reference")]
    pub reference_half: Option<PathBuf>,
    #[command(flatten)]
    pub options: RenderOptions,
}
