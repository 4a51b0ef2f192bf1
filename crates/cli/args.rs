//! What can be typed: the commands and their arguments. The options of a render are in [`crate::options`].

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

/// Everything that can be typed. `replay` names a place with `--pixel`, so the render's option of that name is called
/// `--pixel-plan` there.
pub fn command() -> clap::Command {
    let command =
        Cli::command().mut_subcommand("replay", |replay| replay.mut_arg("pixel", |a| a.long(PIXEL_PLAN)));
    #[cfg(feature = "report")]
    let command = study::reworded(command);
    help::shaped(command)
}

/// What `replay` calls the render's `--pixel`.
pub const PIXEL_PLAN: &str = "pixel-plan";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to pictures
    Render(RenderArgs),
    /// Say what is in a scene file and what a render of it with these options would say
    Info(InfoArgs),
    /// Say what a render of a scene needs, what is left out and why
    SampleSet(PlanArgs),
    /// Trace one sample again and print the vertices of its path
    Replay(ReplayArgs),
    /// Say how many rays a pixel takes, by effect and depth, without rendering
    Rays(RaysArgs),
    #[cfg(feature = "report")]
    #[command(flatten)]
    Study(study::Study),
    /// Print the completions of a shell
    #[cfg(feature = "manual")]
    Completions(manual::CompletionsArgs),
    /// Print a manual page, or write all of them into a folder
    #[cfg(feature = "manual")]
    Man(manual::ManArgs),
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A .gltf or .glb file, or builtin:NAME; without it the built-in Cornell box
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
    /// Time the plan against the general one, in interleaved runs
    #[arg(long)]
    pub measure: bool,
    #[command(flatten)]
    pub options: RenderOptions,
}

#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    /// The pixel, counted from the top left
    #[arg(id = "place", long = "pixel", value_name = "X,Y", allow_hyphen_values = true)]
    pub pixel: Pixel,
    /// Which of the pixel's samples, counted from 0
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
