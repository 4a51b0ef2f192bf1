//! Command line that traces one sample of a render again.

use crate::{args, options, uses};
use clap::ArgMatches;
use clap::parser::ValueSource;

/// Options that change no path and need not be repeated.
const IRRELEVANT: [&str; 14] = [
    "plan",
    "clamp",
    "adaptive",
    "output",
    "half",
    "png-depth",
    "aov",
    "exposure",
    "tone",
    "threads",
    "json",
    "quiet",
    "log",
    "confidence",
];

/// Returns `dapple replay SCENE --pixel X,Y --sample I` with the typed options that affect the path; settings files are
/// read again by the command itself.
pub fn command(scene: Option<&str>, pixel: (u32, u32), sample: u32, typed: &ArgMatches) -> String {
    let mut words = vec![
        "dapple".to_string(),
        "replay".into(),
        quoted(scene.unwrap_or("builtin:cornell")),
        "--pixel".into(),
        format!("{},{}", pixel.0, pixel.1),
        "--sample".into(),
        sample.to_string(),
    ];
    let matters = |o: &str| !IRRELEVANT.contains(&o) && uses::serves("replay", o);
    for (option, id) in options::ids().iter().filter(|(o, _)| matters(o)) {
        let told = typed.value_source(id) == Some(ValueSource::CommandLine);
        for value in typed.get_raw(id).into_iter().flatten().filter(|_| told) {
            let name = if option == "pixel" { args::PIXEL_PLAN } else { option };
            words.push(quoted(&format!("--{name}={}", value.to_string_lossy())));
        }
    }
    words.join(" ")
}

/// Quotes a word for the shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=./:,+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::Pixel;
    use dapple_integrator::sampling::SampleSet;

    fn matches(words: &[&str]) -> ArgMatches {
        args::command().try_get_matches_from(words).unwrap().subcommand().unwrap().1.clone()
    }

    #[test]
    fn what_shapes_the_path_is_repeated() {
        let typed = ["--spp", "9", "--no-roulette", "--json", "--scene", "2", "--env-color", "1,1,1"];
        let typed = matches(&[&["dapple", "render", "a b.glb", "-o", "x.png"], &typed[..]].concat());
        assert_eq!(
            command(Some("a b.glb"), (3, 4), 5, &typed),
            "dapple replay 'a b.glb' --pixel 3,4 --sample 5 --spp=9 --no-roulette=true --scene=2 --env-color=1,1,1"
        );
    }

    #[test]
    fn replay_takes_what_shapes_the_path() {
        for option in IRRELEVANT.iter().filter(|option| **option != "json") {
            assert!(!uses::serves("replay", option), "--{option}");
        }
    }

    #[test]
    fn what_is_printed_can_be_typed() {
        let typed =
            matches(&["dapple", "render", "a.glb", "--pixel", "3x3:grid", "--at=-1.5", "--crop=0,0,9,9"]);
        let said = command(Some("a.glb"), (3, 4), 5, &typed);
        let again = matches(&said.split(' ').collect::<Vec<_>>());
        assert_eq!(again.get_one::<Pixel>("place"), Some(&Pixel(3, 4)));
        assert_eq!(again.get_one::<SampleSet>("pixel"), typed.get_one::<SampleSet>("pixel"));
        assert_eq!(again.get_one::<f64>("at"), Some(&-1.5));
    }
}
