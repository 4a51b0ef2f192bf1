//! Which option serves which command: what a command does not use it does not show, and does not take.
//!
//! A render's options are one struct ([`crate::options::RenderOptions`]) that several commands share. An option stands here
//! once, with the commands whose results can depend on it; typed for another command it is refused, in a settings file it
//! is passed over with a note, and neither help nor completions name it there.

use crate::error::Failure;
use crate::options;
use clap::ArgMatches;
use clap::parser::ValueSource;

/// The commands that take options of a render.
pub const COMMANDS: [&str; 8] = ["render", "info", "plan", "replay", "rays", "budget", "sheet", "converge"];

/// Options of everything that loads a scene: what is seen, by which light, and what is said.
#[cfg(test)]
const OF_ALL: &[&str] = &[
    "size",
    "camera",
    "scene",
    "variant",
    "animation",
    "at",
    "shutter",
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

/// The others, each with the commands that it serves.
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
    ("log", &["render"]),
    ("quiet", &["render", "budget", "sheet", "converge"]),
];

/// Why an option is refused, where more can be said than that it changes nothing.
const WHY: &[(&str, &str, &str)] = &[
    ("converge", "spp", "the counts grow while the budget lasts"),
    ("converge", "time-limit", "see --budget"),
    ("converge", "error-limit", "errors are what is measured; see --budget"),
    ("converge", "aov", "only the picture itself is compared"),
    ("converge", "crop", "whole pictures are compared; see --size"),
    ("sheet", "pattern", "the rows are --estimators"),
    ("sheet", "method", "a sheet is rendered by the distribution tracer"),
    ("sheet", "error-limit", "see --time-limit"),
    ("budget", "spp", "the samples are what is predicted"),
];

/// Whether the result of `command` can depend on the option. What is no option of a render is no matter of this table.
pub fn serves(command: &str, option: &str) -> bool {
    let listed = OF_SOME.iter().find(|(name, _)| *name == option);
    !COMMANDS.contains(&command) || listed.is_none_or(|(_, commands)| commands.contains(&command))
}

/// Refuses typed options that do nothing for the command.
pub fn refuse(command: &str, typed: &ArgMatches) -> Result<(), Failure> {
    if !COMMANDS.contains(&command) {
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
        return format!("--{option}: not with {command}: {why}");
    }
    let served = COMMANDS.into_iter().filter(|other| serves(other, option)).collect::<Vec<_>>();
    format!(
        "--{option}: not with {command}, where it would change nothing; leave it out (it serves {})",
        served.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A new option has to be put on one of the lists.
    #[test]
    fn every_option_serves_some_command() {
        let listed = || OF_ALL.iter().chain(OF_SOME.iter().map(|(name, _)| name));
        for name in options::names() {
            let count = listed().filter(|listed| **listed == name).count();
            assert_eq!(count, 1, "--{name} has to be on one of the two lists of uses.rs");
        }
        assert_eq!(listed().count(), options::names().len());
    }

    #[test]
    fn lists_name_commands_and_options() {
        for (name, commands) in OF_SOME {
            assert!(commands.contains(&"render"), "--{name} serves no render");
            assert!(commands.len() < COMMANDS.len(), "--{name} serves all");
            assert!(commands.iter().all(|command| COMMANDS.contains(command)), "--{name}: {commands:?}");
        }
        for (command, option, _) in WHY {
            assert!(!serves(command, option), "{command} takes --{option}");
        }
    }
}
