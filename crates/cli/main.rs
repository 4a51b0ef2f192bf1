//! `dapple`: renders glTF 2.0 scenes on the CPU from the command line.
//!
//! This file dispatches to the commands and maps their results to exit codes: 0 done · 1 a check failed · 2 bad input
//! or arguments · 3 stopped early, with the images rendered so far written · 4 rendered, but not every output was
//! written where it was requested. Results go to standard output; messages for people go to standard error.
//!
//! The modules form layers, and each uses only lower ones: messages and errors (`say`, `saving`, `standard_output`,
//! `error`); values and their names (`values`, `aliases`); `options`; the command line (`args`, `help`, `complaint`,
//! `layer`, `settings_file`); loading (`load`, `view`, `effects`); `commands`.
#![deny(unsafe_code)]
#![cfg_attr(fuzzing, no_main)]
#![cfg_attr(fuzzing, allow(dead_code, reason = "a fuzz target uses the readers alone"))]
#![cfg_attr(not(feature = "report"), allow(dead_code, reason = "some parts serve only the study commands"))]

mod aliases;
mod args;
mod bias_report;
mod checkpoint;
mod commands;
mod complaint;
mod consent;
mod default_light;
mod effects;
mod ending;
mod error;
#[cfg(feature = "report")]
mod error_watch;
#[cfg(not(feature = "report"))]
#[path = "error_watch/disabled.rs"]
mod error_watch;
mod events;
mod first_sight;
mod first_word;
#[cfg(fuzzing)]
mod fuzzing;
mod help;
mod idle;
mod inputs;
mod interrupt;
mod known;
mod layer;
mod load;
mod log;
mod machine;
mod measure;
mod memory;
mod metadata;
mod metering;
mod options;
mod output;
mod part;
mod partial;
mod preflight;
mod progress;
mod report;
mod retrace;
mod saving;
mod say;
mod settings_file;
mod standard_output;
mod suggest;
mod uses;
mod values;
mod verbose;
mod view;

use args::{Cli, Command};
use clap::FromArgMatches;
use error::Failure;
use say::say;
use std::process::ExitCode;

fn main() -> ExitCode {
    interrupt::survive_file_limit();
    match run() {
        Ok(code) => saving::code(code),
        Err(failure) => {
            say(&format!("error: {}", error::one_line(&failure.to_string())));
            failure.exit_code()
        }
    }
}

fn run() -> Result<ExitCode, Failure> {
    let command = args::command();
    let words = first_word::completed(&command, std::env::args_os());
    let matches = match command.try_get_matches_from(words) {
        Ok(matches) => matches,
        Err(e) => return complaint::arguments(e).map(done),
    };
    if let Some((name, typed)) = matches.subcommand() {
        uses::refuse(name, typed)?;
    }
    let cli = Cli::from_arg_matches(&matches).map_err(|e| Failure::Arguments(error::clap_line(&e)))?;
    match cli.command {
        None => {
            first_word::greet();
            Ok(ExitCode::SUCCESS)
        }
        Some(Command::Render(a)) => commands::render::run(a.scene.as_deref(), subcommand(&matches)),
        Some(Command::Info(a)) => commands::info::run(&a, subcommand(&matches)).map(done),
        Some(Command::Plan(a)) => commands::plan::run(&a, subcommand(&matches)).map(done),
        Some(Command::Merge(a)) => commands::merge::run(&a),
        Some(Command::Replay(a)) => commands::replay::run(&a, subcommand(&matches)).map(done),
        Some(Command::Rays(a)) => commands::rays::run(&a.scene, subcommand(&matches)).map(done),
        #[cfg(feature = "manual")]
        Some(Command::Completions(a)) => commands::manual::completions(&a).map(done),
        #[cfg(feature = "manual")]
        Some(Command::Man(a)) => commands::manual::man(&a).map(done),
        #[cfg(feature = "report")]
        Some(Command::Study(a)) => commands::study::run(a, subcommand(&matches)),
    }
}

fn done((): ()) -> ExitCode {
    ExitCode::SUCCESS
}

/// Returns the matches of the chosen subcommand, which record the options that were given on the command line.
fn subcommand(matches: &clap::ArgMatches) -> &clap::ArgMatches {
    matches.subcommand().map_or(matches, |(_, sub)| sub)
}
