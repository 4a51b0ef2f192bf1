//! The command line: the commands and their arguments. The options of a render are in [`crate::options`].

#[cfg(feature = "manual")]
pub mod manual;
#[cfg(feature = "report")]
pub mod study;

use crate::help;
use crate::options::RenderOptions;
use crate::values::{self, Pixel};
use clap::{Args, CommandFactory, Parser, Subcommand};
use dapple_integrator::imaging::Tone;
use dapple_integrator::imaging::write::PngDepth;
use std::path::PathBuf;

/// Renders glTF 2.0 scenes on the CPU. `dapple FILE` is short for `dapple render FILE`.
#[derive(Debug, Parser)]
#[command(name = "dapple", bin_name = "dapple", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// Builds the complete command line. `replay` selects a pixel with `--pixel`, so the render option of that name is
/// called `--pixel-plan` there.
pub fn command() -> clap::Command {
    let command =
        Cli::command().mut_subcommand("replay", |replay| replay.mut_arg("pixel", |a| a.long(PIXEL_PLAN)));
    #[cfg(feature = "report")]
    let command = study::reworded(command);
    help::shaped(command)
}

/// Name that `replay` gives to the render option `--pixel`.
pub const PIXEL_PLAN: &str = "pixel-plan";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to image files
    Render(RenderArgs),
    /// Print the contents of a scene file and the warnings about it
    ///
    /// A file that can be summarised but that a render would reject is reported with an error line and exit code 0.
    Info(InfoArgs),
    /// Print which features a render of a scene uses and omits, with reasons
    Plan(PlanArgs),
    /// Merge the parts of a render to its image
    ///
    /// Parts are written by `render --samples BEGIN:END -o NAME.part`, and may also be crops. The image has the same
    /// bytes as one render of all samples. The scene is not needed.
    Merge(MergeArgs),
    /// Trace one sample again and print the vertices of its path
    Replay(ReplayArgs),
    /// Print the number of rays per pixel, by effect and depth, without rendering
    Rays(RaysArgs),
    #[cfg(feature = "report")]
    #[command(flatten)]
    Study(study::Study),
    /// Print a completion script for a shell
    #[cfg(feature = "manual")]
    Completions(manual::CompletionsArgs),
    /// Print a manual page, or write all manual pages into a folder
    #[cfg(feature = "manual")]
    Man(manual::ManArgs),
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A .gltf or .glb file, or builtin:NAME; default: the built-in Cornell box
    pub scene: Option<String>,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[derive(Debug, Args)]
pub struct PlanArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    /// Compare the time of this plan with that of the general plan, in interleaved runs
    #[arg(long)]
    pub measure: bool,
    /// Divide the samples, and those of every frame of --frames, into N ranges of equal expected cost, and print the
    /// options that render each: for the tasks of a farm, whose parts `dapple merge` joins. All options of render are
    /// accepted then
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub slices: Option<u32>,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Parts of one render, in any order
    #[arg(required = true, value_name = "PART")]
    pub parts: Vec<PathBuf>,
    /// Output file: .exr, .png or .hdr, or .part for a larger part; can be repeated
    #[arg(short, long, required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Merge although samples are missing; the image is then that of the others
    #[arg(long)]
    pub allow_gaps: bool,
    /// Write EXR with 16-bit floats instead of 32-bit floats
    #[arg(long)]
    pub half: bool,
    /// Exposure of PNG output, in stops [default: that of the whole image, which the parts have]
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = values::finite)]
    pub exposure: Option<f32>,
    /// Tone curve of PNG output: srgb, agx, aces or neutral [default: srgb]
    #[arg(long, value_parser = values::tone, value_name = "NAME")]
    pub tone: Option<Tone>,
    /// Bits per channel of PNG output: 8 or 16 [default: 8]
    #[arg(long, value_name = "BITS", value_parser = values::png_depth)]
    pub png_depth: Option<PngDepth>,
    /// Confidence level of the reported error bound [default: 0.95]
    #[arg(long, value_name = "P", value_parser = values::confidence)]
    pub confidence: Option<f64>,
    /// Print one JSON object as the last line of standard output
    #[arg(long)]
    pub json: bool,
    /// Print no summary
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    /// Pixel coordinates, counted from the top left
    #[arg(id = "place", long = "pixel", value_name = "X,Y", allow_hyphen_values = true)]
    pub pixel: Pixel,
    /// Index of the sample within the pixel, counted from 0
    #[arg(long, value_name = "I")]
    pub sample: u32,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[derive(Debug, Args)]
pub struct RaysArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[cfg(test)]
mod tests {
    #[test]
    fn no_two_arguments_clash() {
        super::command().debug_assert();
    }
}
