//! `dapple completions` and `dapple man`: generated from the same command description that parses and prints help.

use crate::args::manual::{CompletionsArgs, ManArgs};
use crate::error::Failure;
use crate::{args, help, saving, standard_output, suggest};
use clap::Command;
use clap_mangen::Man;
use dapple_integrator::imaging::write;
use std::path::Path;

/// Prints the completion script of a shell.
pub fn completions(arguments: &CompletionsArgs) -> Result<(), Failure> {
    let mut command = help::visible(&args::command());
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "dapple", &mut script);
    standard_output::write(&script);
    Ok(())
}

/// Prints one page, or writes all.
pub fn man(arguments: &ManArgs) -> Result<(), Failure> {
    let pages = pages();
    if let Some(folder) = &arguments.output {
        return write_all(&pages, folder);
    }
    let asked = arguments.command.as_ref().map_or("dapple".into(), |command| format!("dapple-{command}"));
    match pages.iter().find(|(name, _)| *name == asked) {
        Some((_, page)) => {
            standard_output::write(page);
            Ok(())
        }
        None => {
            let asked = arguments.command.as_deref().unwrap_or_default();
            let remedy = suggest::command(&args::command(), asked);
            let remedy = remedy.unwrap_or_else(|| "see dapple --help".into());
            Err(Failure::Arguments(format!("unknown command '{}'; {remedy}", crate::error::short(asked))))
        }
    }
}

/// Writes the pages into a folder, which is created if needed; if one fails, the others are still written.
fn write_all(pages: &[(String, Vec<u8>)], folder: &Path) -> Result<(), Failure> {
    let wrong = |e| Failure::Arguments(format!("-o {}: cannot be created: {e}", folder.display()));
    std::fs::create_dir_all(folder).map_err(wrong)?;
    let at = |name: &str| folder.join(format!("{name}.1"));
    pages.iter().try_for_each(|(name, _)| write::probe(&at(name)))?;
    for (name, page) in pages {
        saving::save(&at(name), |path| write::replace(path, page));
    }
    Ok(())
}

/// Returns the pages of the program and of each command, by name.
fn pages() -> Vec<(String, Vec<u8>)> {
    let all = help::visible(&args::command());
    let mut commands = vec![all.clone()];
    commands.extend(all.get_subcommands().map(|sub| {
        let name = format!("dapple-{}", sub.get_name());
        let called = format!("dapple {}", sub.get_name());
        sub.clone().name(name).bin_name(called)
    }));
    commands.into_iter().map(|command| (command.get_name().to_string(), page(command))).collect()
}

fn page(command: Command) -> Vec<u8> {
    let mut page = Vec::new();
    let man = Man::new(command).source(concat!("dapple ", env!("CARGO_PKG_VERSION")));
    // Writing to memory does not fail.
    let _ = man.render(&mut page);
    page
}
