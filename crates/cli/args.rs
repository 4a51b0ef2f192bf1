//! What can be typed: the commands and their arguments. The options of a render are in [`crate::options`].

use crate::options::RenderOptions;
use crate::values::Pixel;
use clap::{Args, Parser, Subcommand};

/// Renders glTF 2.0 scenes on the CPU. Without a command: the built-in Cornell box.
#[derive(Debug, Parser)]
#[command(name = "dapple", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to pictures
    Render(RenderArgs),
    /// Say what is in a scene file
    Info(InfoArgs),
    /// Trace one sample again and print the vertices of its path
    Replay(ReplayArgs),
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
    /// Let the scene name files outside its own folder
    #[arg(long)]
    pub allow_path: bool,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// A .gltf or .glb file, or builtin:NAME
    pub scene: String,
    /// The pixel, counted from the top left
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub pixel: Pixel,
    /// Which of the pixel's samples, counted from 0
    #[arg(long, value_name = "I")]
    pub sample: u32,
    #[command(flatten)]
    pub options: RenderOptions,
}
