//! Arguments of the commands that print shell completions and manual pages; available with the feature `manual`.

use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

/// Arguments of `completions`. Shells keep completions in different folders, so the script goes to standard output.
#[derive(Debug, Args)]
#[command(
    after_help = "For bash: dapple completions bash > ~/.local/share/bash-completion/completions/dapple"
)]
pub struct CompletionsArgs {
    /// The shell to write the script for
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
}

/// Arguments of `man`: prints the page of one command, or writes the pages of all.
#[derive(Debug, Args)]
#[command(after_help = "To read a page directly: dapple man render | man -l -")]
pub struct ManArgs {
    /// The command whose page is printed [default: dapple itself]
    #[arg(value_name = "COMMAND", conflicts_with = "output")]
    pub command: Option<String>,
    /// Write the pages of all commands into this folder, as dapple.1, dapple-render.1 and so on
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
