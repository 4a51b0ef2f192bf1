//! The command line: the commands and their arguments. The options of a render are in [`crate::options`].

#[cfg(feature = "manual")]
pub mod manual;
#[cfg(feature = "report")]
pub mod study;

use crate::help;
use crate::options::RenderOptions;
use crate::values::Pixel;
use clap::{Args, CommandFactory, Parser, Subcommand};

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
    #[command(flatten)]
    pub options: RenderOptions,
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
