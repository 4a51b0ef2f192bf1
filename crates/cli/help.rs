//! Help texts: each command lists only the options it uses, `-h` is short, and built-in scenes are listed by name.

use crate::{options, uses};
use clap::{Arg, Command};
use dapple_integrator::scene::builtin;

/// Render options that the short help shows; `--help` shows all.
const NEWCOMERS: [&str; 15] = [
    "output",
    "size",
    "camera",
    "orbit",
    "look-from",
    "animation",
    "env",
    "exposure",
    "tone",
    "transparent",
    "method",
    "spp",
    "time-limit",
    "error-limit",
    "quiet",
];

/// Older names of options, which stay accepted but are hidden.
const OLDER: [&str; 2] = ["cull-backfaces", "env-smooth"];

/// Text below the full help of commands that render.
const MORE: &str = "\
A flag is reset by =false, as in --half=false. Every option is also a key of settings files: SCENE.toml beside the \
scene (for appearance and sampling) and --settings FILE.

Exit codes: 0 done, 1 a check failed, 2 bad input or arguments, 3 stopped early or a limit not reached, 4 rendered but \
not every output written.";

/// Adapts the help of every command to the options that it uses.
pub fn shaped(mut command: Command) -> Command {
    let names: Vec<String> = command.get_subcommands().map(|sub| sub.get_name().to_string()).collect();
    for name in names {
        command = command.mut_subcommand(&name, |sub| subcommand(sub, &name));
    }
    command
}

fn subcommand(sub: Command, name: &str) -> Command {
    let sub = sub.mut_args(with_builtins);
    if !uses::COMMANDS.contains(&name) {
        return sub;
    }
    let of_render = options::ids();
    sub.mut_args(|arg| {
        let Some((option, _)) = of_render.iter().find(|(_, id)| arg.get_id() == id.as_str()) else {
            return arg;
        };
        let is_seldom = !NEWCOMERS.contains(&option.as_str()) && !arg.is_required_set();
        let is_older = OLDER.contains(&option.as_str());
        let is_hidden = arg.is_hide_set() || is_older || !uses::serves(name, option);
        arg.hide(is_hidden).hide_short_help(is_seldom)
    })
    .after_help(format!("All options: dapple {name} --help"))
    .after_long_help(MORE)
}

/// Adds the names of the built-in scenes to an argument that takes a scene.
fn with_builtins(arg: Arg) -> Arg {
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    if !help.contains("builtin:NAME") {
        return arg;
    }
    let names = builtin::NAMES.iter().map(|(name, _)| format!("builtin:{name}"));
    let names = names.collect::<Vec<_>>().join(", ");
    let lines = builtin::NAMES.iter().map(|(name, line)| format!("- builtin:{name}: {line}"));
    let lines = lines.collect::<Vec<_>>().join("\n");
    let short = help.replacen("builtin:NAME", &format!("a built-in scene ({names})"), 1);
    arg.help(short).long_help(format!("{help}:\n{lines}"))
}

/// Returns the commands without hidden arguments, for generators that would otherwise list them.
#[cfg(feature = "manual")]
pub fn visible(command: &Command) -> Command {
    let mut seen = Command::new(command.get_name().to_string());
    if let Some(about) = command.get_about() {
        seen = seen.about(about.clone());
    }
    if let Some(about) = command.get_long_about() {
        seen = seen.long_about(about.clone());
    }
    if let Some(after) = command.get_after_long_help() {
        seen = seen.after_long_help(after.clone());
    }
    if let Some(version) = command.get_version() {
        seen = seen.version(version.to_string());
    }
    let shown = command.get_arguments().filter(|arg| !arg.is_hide_set());
    seen.args(shown.cloned().map(|arg| arg.hide_short_help(false)))
        .subcommands(command.get_subcommands().filter(|sub| !sub.is_hide_set()).map(visible))
}
