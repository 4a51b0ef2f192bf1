//! `dapple converge`: renders scenes by several methods and measures their errors against time. Results are written
//! after every seed, so that an interrupt loses at most the current seed and a second call continues.

mod external;
mod folder;
mod plan;
mod schedule;
mod session;

use crate::args::study::ConvergeArgs;
use crate::error::Failure;
use crate::inputs::Inputs;
use crate::options::RenderOptions;
use crate::progress::Bar;
use crate::say::say;
use crate::{events, interrupt, machine, saving, standard_output};
use clap::ArgMatches;
use dapple_analysis::converge::Clock;
use dapple_analysis::report::summary;
use dapple_analysis::results::{Machine, Results, SCHEMA};
use external::External;
use folder::{Folder, plain};
use serde_json::json;
use session::{Given, Session};
use std::process::ExitCode;
use std::time::Duration;

/// Rejects a folder in which an input file would be overwritten, before anything is written.
fn spare(
    arguments: &ConvergeArgs,
    scenes: &[Given<'_>],
    folder: &Folder,
    externals: &[External],
) -> Result<(), Failure> {
    let mut inputs = Inputs::default();
    for scene in scenes {
        inputs.add_render(&scene.source, &scene.options);
        inputs.add_scene_files(&scene.source.files(&scene.options)?);
    }
    if let Some(reference) = &arguments.reference {
        inputs.add("the reference", reference);
    }
    let names: Vec<String> = externals.iter().map(|external| external.name.clone()).collect();
    folder.spare(&inputs, &arguments.scenes, &names)
}

/// Largest first seed: seeds of references lie above it, and other renderers take 32 bits.
const LARGEST_SEED: u64 = 2_000_000_000;

/// Measures, writes the results, and prints a summary.
pub fn run(arguments: &ConvergeArgs, typed: &ArgMatches) -> Result<ExitCode, Failure> {
    let clock = Clock::new(arguments.budget, Duration::ZERO);
    let given = &arguments.options;
    events::start(given);
    check(arguments)?;
    let externals =
        arguments.external.iter().map(|e| External::parse(e)).collect::<Result<Vec<_>, Failure>>()?;
    let folder = Folder::open(given.output.as_deref().unwrap_or_default())?;
    let scenes =
        arguments.scenes.iter().map(|name| Given::new(name, typed)).collect::<Result<Vec<_>, _>>()?;
    spare(arguments, &scenes, &folder, &externals)?;
    let old = folder.read()?;
    let spent = old.spent_seconds;
    let bar = Bar::new(RenderOptions::is(given.quiet));
    let results = Results { spent_seconds: spent, ..describe(arguments) };
    let mut session = Session { arguments, clock, folder, results, bar, memory_limit: given.memory_limit };
    interrupt::listen();
    for (i, scene) in scenes.into_iter().enumerate() {
        let rest = arguments.scenes.len() - i;
        schedule::scene(&mut session, (scene, &externals), &old, rest)?;
    }
    session.bar.finish();
    session.results.spent_seconds = spent + session.clock.elapsed();
    session.folder.write_page(&mut session.results)?;
    if !session.folder.is_whole() {
        saving::lose();
    }
    tell(&session);
    Ok(ExitCode::from(if interrupt::asked() { 3 } else { 0 }))
}

/// Checks the restrictions on options of this command.
fn check(arguments: &ConvergeArgs) -> Result<(), Failure> {
    let o = &arguments.options;
    if o.seed.is_some_and(|seed| seed > LARGEST_SEED) {
        let said = "--seed: the first seed of converge is at most 2000000000";
        return Err(Failure::Arguments(said.into()));
    }
    // Files in the folder are named after the scenes.
    for (i, scene) in arguments.scenes.iter().enumerate() {
        if let Some(same) = arguments.scenes[..i].iter().find(|s| plain(s) == plain(scene)) {
            return Err(Failure::Arguments(format!(
                "{same}, {scene}: would write files of the same names; compare them in separate folders"
            )));
        }
    }
    Ok(())
}

/// Returns results that describe the session and contain no runs.
fn describe(arguments: &ConvergeArgs) -> Results {
    let words = std::env::args().skip(1).map(|word| match word.contains(char::is_whitespace) {
        true => format!("'{word}'"),
        false => word,
    });
    Results {
        schema: SCHEMA,
        version: env!("CARGO_PKG_VERSION").into(),
        machine: Machine {
            cpu: machine::cpu(),
            threads: machine::threads(arguments.options.threads),
            memory_bytes: machine::memory_bytes(),
            system: format!("{}, {}", std::env::consts::OS, std::env::consts::ARCH),
        },
        command: format!("dapple {}", words.collect::<Vec<_>>().join(" ")),
        budget_seconds: arguments.budget.as_secs_f64(),
        ..Results::default()
    }
}

/// Prints the summary and the path of the report.
fn tell(session: &Session<'_>) {
    let page = session.folder.place("report.html").display().to_string();
    let options = &session.arguments.options;
    if !RenderOptions::is(options.quiet) {
        for scene in session.results.scenes() {
            say(&format!("{scene}:"));
            summary(&session.results, scene).iter().for_each(|line| say(&format!("  {line}")));
        }
        session.results.left_out.iter().for_each(|line| say(&format!("incomplete: {line}")));
    }
    if RenderOptions::is(options.json) {
        standard_output::json(&json!({ "report": page, "results": session.results }));
    } else {
        standard_output::results(&page);
    }
}
