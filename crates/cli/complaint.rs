//! One-line error messages for clap's errors: what is wrong, and what to type instead.

use crate::error::Failure;
use crate::{args, error, standard_output, suggest};
use clap::Command;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

/// Handles an error of clap. Help and version are not errors: they are printed, and the command is finished.
pub fn arguments(error: Error) -> Result<(), Failure> {
    use ErrorKind::{DisplayHelp, DisplayVersion};
    if matches!(error.kind(), DisplayHelp | DisplayVersion) {
        standard_output::print(|| error.print());
        return Ok(());
    }
    Err(Failure::Arguments(line(&error)))
}

/// Builds the error message for the arguments of a command line.
pub fn line(error: &Error) -> String {
    let all = args::command();
    let sub = subcommand(error, &all);
    let said = match error.kind() {
        ErrorKind::UnknownArgument => unknown(error, &all, &sub),
        ErrorKind::InvalidSubcommand => {
            let word = text(error, ContextKind::InvalidSubcommand);
            let names: Vec<&str> = all.get_subcommands().map(Command::get_name).collect();
            let remedy = suggest::command(&all, &word)
                .unwrap_or_else(|| format!("the commands are {}", names.join(", ")));
            Some(format!("unknown command '{}'; {remedy}", error::short(&word)))
        }
        ErrorKind::MissingRequiredArgument => Some(missing(error, &all, &sub)),
        ErrorKind::ArgumentConflict => conflict(error),
        ErrorKind::InvalidValue => Some(invalid(error, &all, &sub)),
        ErrorKind::ValueValidation => Some(validation(error)),
        _ => None,
    };
    said.unwrap_or_else(|| error::clap_line(error))
}

/// Returns the command that was typed, from the usage text or, if the error has none, from the command line; empty if
/// there is none. Options without a command belong to `render`.
fn subcommand(error: &Error, all: &Command) -> String {
    let usage = text(error, ContextKind::Usage);
    if usage.is_empty() {
        let typed = std::env::args().nth(1).filter(|word| all.find_subcommand(word).is_some());
        return typed.unwrap_or_else(|| "render".into());
    }
    let mut words = usage.split_whitespace().skip_while(|word| *word != "dapple");
    match (words.next(), words.next()) {
        (None, _) => "render".into(),
        (_, Some(word)) if word.chars().all(|c| c.is_ascii_lowercase()) => word.into(),
        _ => String::new(),
    }
}

fn unknown(error: &Error, all: &Command, sub: &str) -> Option<String> {
    let word = text(error, ContextKind::InvalidArg);
    let quoted = error::short(&word);
    let help = ["dapple", sub, "--help"].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>();
    let see = format!("see {}", help.join(" "));
    if let Some(said) = negative(&word, &std::env::args().collect::<Vec<_>>()) {
        return Some(said);
    }
    if word.starts_with('-') {
        let render = || suggest::option(all, "render", &word).map(|meant| format!("dapple render: {meant}"));
        let meant = suggest::option(all, sub, &word).or_else(|| render().filter(|_| sub.is_empty()));
        let remedy = meant.unwrap_or(see);
        return Some(format!("unknown option '{quoted}'; {remedy}"));
    }
    let remedy = match word.as_str() {
        "true" | "false" | "yes" | "no" => {
            "the value of a flag is given with '=', as in --half=false".to_string()
        }
        _ => see,
    };
    Some(format!("unexpected argument '{quoted}'; {remedy}"))
}

/// Options whose values are above 0.
const POSITIVE: [&str; 7] =
    ["--spp", "--threads", "--secondary", "--error-limit", "--confidence", "--memory-limit", "--size"];

/// Builds the message for a negative number after an option that takes none, which clap takes for an option; `typed`
/// is the command line.
fn negative(word: &str, typed: &[String]) -> Option<String> {
    word.parse::<f64>().ok().filter(|_| word.starts_with('-'))?;
    let option = typed.windows(2).find(|pair| pair[0].starts_with("--") && pair[1] == word)?[0].as_str();
    let wanted =
        if POSITIVE.contains(&option) { "a positive number" } else { "a number that is not negative" };
    Some(format!("invalid value '{}' for '{option}': expected {wanted}", error::short(word)))
}

/// Names the missing arguments, each with its description.
fn missing(error: &Error, all: &Command, sub: &str) -> String {
    let names = texts(error, ContextKind::InvalidArg);
    let all = names.iter().map(|name| format!("{name}{}", described(all, sub, name)));
    format!("dapple {sub} needs {}", all.collect::<Vec<_>>().join(" and "))
}

/// Returns the description of an argument, in parentheses.
fn described(all: &Command, sub: &str, name: &str) -> String {
    let mut built = all.find_subcommand(sub).cloned().unwrap_or_default();
    built.build();
    let arg = built.get_arguments().find(|arg| arg.to_string() == name);
    let help = arg.and_then(|arg| arg.get_help()).map(|help| format!(" ({help})"));
    help.unwrap_or_default()
}

fn conflict(error: &Error) -> Option<String> {
    let (one, others) = (text(error, ContextKind::InvalidArg), texts(error, ContextKind::PriorArg));
    if one.is_empty() || others.is_empty() {
        return None;
    }
    Some(match others.iter().all(|other| *other == one) {
        true => format!("{one} is given more than once; give it only once"),
        false => format!("{one} cannot be combined with {}; remove one of them", others.join(", ")),
    })
}

/// Builds the message for a value that is missing or not one of a fixed list.
fn invalid(error: &Error, all: &Command, sub: &str) -> String {
    let (name, value) = (text(error, ContextKind::InvalidArg), text(error, ContextKind::InvalidValue));
    let valid = texts(error, ContextKind::ValidValue);
    if value.is_empty() {
        return format!("{name} needs a value{}", described(all, sub, &name));
    }
    let quoted = error::short(&value);
    let meant = suggest::nearest(&value, valid.iter().map(String::as_str));
    let meant = meant.map(|name| format!("; did you mean {name}?")).unwrap_or_default();
    format!("invalid value '{quoted}' for '{name}': choose from {}{meant}", valid.join(", "))
}

/// Error messages of the standard library's number parsers, each with its replacement.
const NUMBERS: [(&str, &str); 4] = [
    ("invalid digit found in string", "expected a whole number"),
    ("cannot parse integer from empty string", "expected a whole number"),
    ("number too large to fit in target type", "the number is too large"),
    ("number too small to fit in target type", "the number is too small"),
];

/// Builds the message for a value that its parser rejected, with the option that takes such values if there is one.
fn validation(error: &Error) -> String {
    let (name, value) = (text(error, ContextKind::InvalidArg), text(error, ContextKind::InvalidValue));
    let mut line = error::clap_line(error);
    line = line.replace(&value, &error::short(&value));
    for (said, plain) in NUMBERS {
        line = line.replace(said, plain);
    }
    if name.starts_with("--time ") && crate::values::duration(&value).is_ok() {
        line += "; to stop after a time, use --time-limit";
    }
    line
}

fn text(error: &Error, kind: ContextKind) -> String {
    texts(error, kind).into_iter().next().unwrap_or_default()
}

fn texts(error: &Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(one)) => vec![one.clone()],
        Some(ContextValue::Strings(many)) => many.clone(),
        Some(ContextValue::StyledStr(styled)) => vec![styled.to_string()],
        Some(ContextValue::StyledStrs(many)) => many.iter().map(ToString::to_string).collect(),
        _ => Vec::new(),
    }
}
