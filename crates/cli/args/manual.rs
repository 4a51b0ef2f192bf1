//! Commands that print what the program can do in other programs' formats: there with the feature `manual`.

use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

/// Where completions go is the shell's own choice, so they go to standard output.
#[derive(Debug, Args)]
#[command(
    after_help = "For bash: dapple completions bash > ~/.local/share/bash-completion/completions/dapple"
)]
pub struct CompletionsArgs {
    /// Which shell
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
}

/// Of one command, or of all.
#[derive(Debug, Args)]
#[command(after_help = "To read one at once: dapple man render | man -l -")]
pub struct ManArgs {
    /// The command whose page is printed [default: dapple itself]
    #[arg(value_name = "COMMAND", conflicts_with = "output")]
    pub command: Option<String>,
    /// Write the pages of all commands into this folder, as dapple.1, dapple-render.1 and so on
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
