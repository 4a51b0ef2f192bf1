//! The command that traces one sample of a render again.

use crate::options;
use clap::ArgMatches;
use clap::parser::ValueSource;

/// Options that change no path, and need not be repeated.
const IRRELEVANT: [&str; 9] =
    ["plan", "output", "half", "aov", "exposure", "tone", "threads", "json", "quiet"];

/// `dapple replay SCENE --pixel X,Y --sample I` with what was typed for the render and matters to the path; settings
/// files are read again by themselves.
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
    for option in options::names().iter().filter(|o| !IRRELEVANT.contains(&o.as_str())) {
        let id = option.replace('-', "_");
        let told = typed.value_source(&id) == Some(ValueSource::CommandLine);
        for value in typed.get_raw(&id).into_iter().flatten().filter(|_| told) {
            words.push(quoted(&format!("--{option}={}", value.to_string_lossy())));
        }
    }
    words.join(" ")
}

/// As a shell would need it.
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
    use clap::CommandFactory;

    #[test]
    fn what_shapes_the_path_is_repeated() {
        let matches = crate::args::Cli::command()
            .try_get_matches_from([
                "dapple",
                "render",
                "a b.glb",
                "-o",
                "x.png",
                "--spp",
                "9",
                "--no-roulette",
                "--json",
                "--env-color",
                "1,1,1",
            ])
            .unwrap();
        let typed = matches.subcommand().unwrap().1;
        let said = command(Some("a b.glb"), (3, 4), 5, typed);
        assert_eq!(
            said,
            "dapple replay 'a b.glb' --pixel 3,4 --sample 5 --spp=9 --no-roulette=true --env-color=1,1,1"
        );
    }
}
