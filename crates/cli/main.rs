//! `dapple`: renders glTF 2.0 scenes on the CPU from the command line.
//!
//! This file answers one question: which command runs, and with which code the process ends
//! (0 done · 1 a check failed · 2 bad input or arguments · 3 stopped early, with pictures of what was done · 4 computed, but
//! not all of it written where it was asked for).
//! Results go to standard output, everything said to a person to standard error.
//!
//! The files stand in layers, and each uses lower ones alone: what is said and what goes wrong (`say`, `saving`,
//! `standard_output`, `error`); values and their names (`values`, `aliases`); `options`; what can be typed (`args`, `help`,
//! `complaint`, `layer`, `settings_file`); loading (`load`, `view`, `effects`); `commands`.
#![deny(unsafe_code)]
#![cfg_attr(not(feature = "report"), allow(dead_code, reason = "some parts serve studies alone"))]

mod aliases;
mod args;
mod bias_report;
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
        Some(Command::SampleSet(a)) => commands::plan::run(&a, subcommand(&matches)).map(done),
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

/// The matches of the chosen subcommand, which say what was given on the command line and what was not.
fn subcommand(matches: &clap::ArgMatches) -> &clap::ArgMatches {
    matches.subcommand().map_or(matches, |(_, sub)| sub)
}
