//! Command lines without a command: a file name is rendered, and an empty command line prints a greeting.

use crate::args;
use crate::standard_output;
use clap::{Arg, Command};
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// The command that a file name stands for.
const RENDER: &str = "render";

/// Returns the words of a command line, with `render` inserted before a file that is in the place of the command, or
/// before an option of `render` that is followed by a file. A word that names a command stays a command, whatever files exist.
pub fn completed(command: &Command, words: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut words: Vec<OsString> = words.into_iter().collect();
    let names_scene = words.iter().skip(2).any(|word| is_scene(word));
    let stands_for = |first: &OsString| is_scene(first) || (names_scene && is_render_option(command, first));
    if words.get(1).is_some_and(|first| !is_command(command, first) && stands_for(first)) {
        words.insert(1, RENDER.into());
    }
    words
}

fn is_command(command: &Command, word: &OsStr) -> bool {
    let is = |c: &Command| word == c.get_name() || c.get_all_aliases().any(|alias| word == alias);
    word == "help" || command.get_subcommands().any(is)
}

/// Whether a word is an option of `render`, such as `-q`, `--spp` or `--spp=4`.
fn is_render_option(command: &Command, word: &OsStr) -> bool {
    let text = word.to_string_lossy();
    let name = text.split('=').next().unwrap_or_default();
    let is = |arg: &Arg| {
        arg.get_long().is_some_and(|long| name.strip_prefix("--") == Some(long))
            || arg.get_short().is_some_and(|short| *name == *format!("-{short}"))
    };
    let is_help = ["-h", "--help", "-V", "--version"].contains(&name);
    !is_help && command.find_subcommand(RENDER).is_some_and(|render| render.get_arguments().any(is))
}

/// Whether a word is a path, a built-in scene or an existing file; any other word may be a misspelt command.
fn is_scene(word: &OsStr) -> bool {
    let text = word.to_string_lossy();
    let reads_like_one = text.contains(['.', '/', '\\']) || text.starts_with("builtin:");
    !text.starts_with('-') && !text.is_empty() && (reads_like_one || Path::new(word).exists())
}

/// Prints the help and an example command.
pub fn greet() {
    standard_output::print(|| args::command().print_help());
    standard_output::results(
        "\nTry it: dapple render    renders the built-in Cornell box to cornell.exr and cornell.png",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(words: &[&str]) -> String {
        let words = completed(&args::command(), words.iter().map(OsString::from));
        words.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn files_are_rendered_and_commands_are_commands() {
        for scene in ["a.glb", "a/b", "./render", "builtin:cornell", "../x", "C:\\a.gltf", "Cargo.toml"] {
            assert_eq!(said(&["dapple", scene, "--spp", "4"]), format!("dapple render {scene} --spp 4"));
        }
        for first in ["render", "info", "help", "--help", "-V", "--spp.x", "rendr", ""] {
            assert_eq!(said(&["dapple", first, "a.glb"]), format!("dapple {first} a.glb"));
        }
        for option in ["-q", "--spp=4", "--quiet", "-o"] {
            assert_eq!(said(&["dapple", option, "a.glb"]), format!("dapple render {option} a.glb"));
        }
        assert_eq!(said(&["dapple", "--spp", "3"]), "dapple --spp 3");
        assert_eq!(said(&["dapple"]), "dapple");
    }
}
