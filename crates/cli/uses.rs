//! Table of the options that each command uses; other options are hidden and rejected.
//!
//! The render options are one struct ([`crate::options::RenderOptions`]) that several commands share. Each option is
//! listed once, with the commands whose results can depend on it. For other commands it is an error on the command
//! line, is skipped with a note in a settings file, and appears neither in help nor in completions.

use crate::error::Failure;
use crate::options;
use clap::ArgMatches;
use clap::parser::ValueSource;

/// The commands that take render options.
pub const COMMANDS: [&str; 8] = ["render", "info", "plan", "replay", "rays", "budget", "sheet", "converge"];

/// Options of every command that loads a scene: view, lighting and messages.
#[cfg(test)]
const OF_ALL: &[&str] = &[
    "size",
    "camera",
    "scene",
    "variant",
    "animation",
    "at",
    "shutter",
    "fps",
    "shutter-angle",
    "look-from",
    "look-at",
    "orbit",
    "up",
    "fov",
    "backfaces",
    "cull-backfaces",
    "light-unit",
    "env",
    "env-color",
    "env-rotation",
    "env-intensity",
    "env-nearest",
    "env-smooth",
    "aperture-radius",
    "focus-distance",
    "aperture-shape",
    "pixel",
    "lens",
    "time",
    "light",
    "glossy",
    "refract",
    "diffuse",
    "combine",
    "secondary",
    "max-bounces",
    "settings",
    "allow-path",
    "memory-limit",
    "strict",
    "json",
    "verbose",
];

/// The other options, each with the commands that use it.
const OF_SOME: &[(&str, &[&str])] = &[
    ("output", &["render", "plan", "rays", "sheet", "converge"]),
    ("half", &["render"]),
    ("transparent", &["render", "plan"]),
    ("png-depth", &["render"]),
    ("aov", &["render", "info", "plan", "rays"]),
    ("exposure", &["render", "sheet", "converge"]),
    ("tone", &["render", "sheet", "converge"]),
    ("method", &["render", "plan", "replay", "rays", "budget", "converge"]),
    ("spp", &["render", "plan", "replay", "rays", "sheet"]),
    ("time-limit", &["render", "replay", "rays", "budget", "sheet"]),
    ("error-limit", &["render", "plan", "replay", "rays", "budget"]),
    ("confidence", &["render", "budget"]),
    ("pattern", &["render", "plan", "replay", "budget", "converge"]),
    ("adaptive", &["render", "plan", "converge"]),
    ("seed", &["render", "plan", "replay", "budget", "sheet", "converge"]),
    ("no-roulette", &["render", "plan", "replay", "budget", "sheet", "converge"]),
    ("clamp", &["render", "plan", "budget", "sheet", "converge"]),
    ("no-soft-terminator", &["render", "plan", "replay", "budget", "sheet", "converge"]),
    ("transparent-shadows", &["render", "plan", "replay", "budget", "sheet", "converge"]),
    ("filter", &["render", "plan", "replay", "budget", "sheet", "converge"]),
    ("threads", &["render", "plan", "budget", "sheet", "converge"]),
    ("ambient", &["render", "plan", "replay", "budget", "sheet", "converge"]),
    ("yes", &["render", "sheet"]),
    ("crop", &["render", "info", "plan", "replay", "rays", "budget", "sheet"]),
    ("plan", &["render", "plan", "budget", "sheet", "converge"]),
    ("frames", &["render", "plan"]),
    ("skip-existing", &["render"]),
    ("fixed-seed", &["render"]),
    ("samples", &["render"]),
    ("progress", &["render"]),
    ("dry-run", &["render"]),
    ("save-every", &["render"]),
    ("checkpoint", &["render"]),
    ("checkpoint-every", &["render"]),
    ("resume", &["render"]),
    ("log", &["render"]),
    ("quiet", &["render", "budget", "sheet", "converge"]),
];

/// Specific reasons for rejecting an option, beyond that it has no effect.
const WHY: &[(&str, &str, &str)] = &[
    ("converge", "spp", "the sample counts grow until --budget is used up"),
    ("converge", "time-limit", "see --budget"),
    ("converge", "error-limit", "the errors are measured; see --budget"),
    ("converge", "aov", "only the image itself is compared"),
    ("converge", "crop", "whole images are compared; see --size"),
    ("sheet", "pattern", "the rows are --estimators"),
    ("sheet", "method", "a sheet is rendered by the distribution tracer"),
    ("sheet", "error-limit", "see --time-limit"),
    ("budget", "spp", "the sample count is predicted"),
];

/// Whether the result of `command` can depend on the option. Returns true for names that are not render options.
pub fn serves(command: &str, option: &str) -> bool {
    let listed = OF_SOME.iter().find(|(name, _)| *name == option);
    !COMMANDS.contains(&command) || listed.is_none_or(|(_, commands)| commands.contains(&command))
}

/// Whether the command is `plan --slices`, which takes all options of the render that it divides.
fn divides(command: &str, typed: &ArgMatches) -> bool {
    command == "plan" && typed.value_source("slices") == Some(ValueSource::CommandLine)
}

/// Rejects typed options that have no effect on the command.
pub fn refuse(command: &str, typed: &ArgMatches) -> Result<(), Failure> {
    if !COMMANDS.contains(&command) || divides(command, typed) {
        return Ok(());
    }
    for (option, id) in options::ids().iter().filter(|(option, _)| !serves(command, option)) {
        let is_typed = || typed.value_source(id) == Some(ValueSource::CommandLine);
        if typed.try_contains_id(id).is_ok() && is_typed() {
            return Err(Failure::Arguments(refusal(command, option)));
        }
    }
    Ok(())
}

fn refusal(command: &str, option: &str) -> String {
    if let Some((_, _, why)) = WHY.iter().find(|(of, name, _)| (*of, *name) == (command, option)) {
        return format!("--{option}: not available for {command}: {why}");
    }
    let served = COMMANDS.into_iter().filter(|other| serves(other, option)).collect::<Vec<_>>();
    format!(
        "--{option}: not available for {command}, where it has no effect; remove it (it applies to {})",
        served.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A new option has to be added to one of the lists.
    #[test]
    fn every_option_serves_some_command() {
        let listed = || OF_ALL.iter().chain(OF_SOME.iter().map(|(name, _)| name));
        for name in options::names() {
            let count = listed().filter(|listed| **listed == name).count();
            assert_eq!(count, 1, "--{name} must be on exactly one of the two lists of uses.rs");
        }
        assert_eq!(listed().count(), options::names().len());
    }

    #[test]
    fn lists_name_commands_and_options() {
        for (name, commands) in OF_SOME {
            assert!(commands.contains(&"render"), "--{name} does not serve render");
            assert!(commands.len() < COMMANDS.len(), "--{name} serves all");
            assert!(commands.iter().all(|command| COMMANDS.contains(command)), "--{name}: {commands:?}");
        }
        for (command, option, _) in WHY {
            assert!(!serves(command, option), "{command} takes --{option}");
        }
    }
}
