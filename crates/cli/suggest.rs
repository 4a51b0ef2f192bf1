//! Suggestions for unknown options and commands: names that other renderers use, and misspellings.

use clap::Command;

/// Names that other programs use for an option, each with the option's name here.
const OPTIONS: &[(&str, &str)] = &[
    ("sample", "spp"),
    ("sample-count", "spp"),
    ("num-samples", "spp"),
    ("samples-per-pixel", "spp"),
    ("max-samples", "spp"),
    ("width", "size"),
    ("height", "size"),
    ("resolution", "size"),
    ("res", "size"),
    ("dimensions", "size"),
    ("image-size", "size"),
    ("bounces", "max-bounces"),
    ("depth", "max-bounces"),
    ("max-depth", "max-bounces"),
    ("ray-depth", "max-bounces"),
    ("path-length", "max-bounces"),
    ("max-path-length", "max-bounces"),
    ("out", "output"),
    ("outfile", "output"),
    ("out-file", "output"),
    ("output-file", "output"),
    ("file", "output"),
    ("timeout", "time-limit"),
    ("max-time", "time-limit"),
    ("time-budget", "time-limit"),
    ("limit", "time-limit"),
    ("noise", "error-limit"),
    ("noise-threshold", "error-limit"),
    ("max-error", "error-limit"),
    ("target-error", "error-limit"),
    ("threshold", "error-limit"),
    ("sampler", "pattern"),
    ("sampling", "pattern"),
    ("sequence", "pattern"),
    ("integrator", "method"),
    ("tracer", "method"),
    ("renderer", "method"),
    ("engine", "method"),
    ("algorithm", "method"),
    ("mode", "method"),
    ("jobs", "threads"),
    ("cores", "threads"),
    ("nthreads", "threads"),
    ("num-threads", "threads"),
    ("workers", "threads"),
    ("random-seed", "seed"),
    ("adaptive-sampling", "adaptive"),
    ("roulette", "no-roulette"),
    ("russian-roulette", "no-roulette"),
    ("rr", "no-roulette"),
    ("firefly-clamp", "clamp"),
    ("clamp-indirect", "clamp"),
    ("max-radiance", "clamp"),
    ("pixel-filter", "filter"),
    ("reconstruction-filter", "filter"),
    ("environment", "env"),
    ("env-map", "env"),
    ("envmap", "env"),
    ("hdri", "env"),
    ("ibl", "env"),
    ("sky", "env"),
    ("skybox", "env"),
    ("background", "env-color"),
    ("background-color", "env-color"),
    ("sky-color", "env-color"),
    ("env-strength", "env-intensity"),
    ("env-scale", "env-intensity"),
    ("env-rotate", "env-rotation"),
    ("ev", "exposure"),
    ("brightness", "exposure"),
    ("tonemap", "tone"),
    ("tone-map", "tone"),
    ("tonemapping", "tone"),
    ("tone-mapping", "tone"),
    ("tonemapper", "tone"),
    ("view-transform", "tone"),
    ("layers", "aov"),
    ("aovs", "aov"),
    ("passes", "aov"),
    ("channels", "aov"),
    ("region", "crop"),
    ("window", "crop"),
    ("roi", "crop"),
    ("cam", "camera"),
    ("position", "look-from"),
    ("camera-position", "look-from"),
    ("no-env", "env"),
    ("no-environment", "env"),
    ("no-background", "transparent"),
    ("frame", "at"),
    ("animation-time", "at"),
    ("exposure-time", "shutter"),
    ("shutter-time", "shutter"),
    ("shutter-speed", "shutter"),
    ("motion-blur", "shutter"),
    ("aperture", "aperture-radius"),
    ("lens-radius", "aperture-radius"),
    ("dof", "aperture-radius"),
    ("f-stop", "aperture-radius"),
    ("fstop", "aperture-radius"),
    ("focus", "focus-distance"),
    ("focal-distance", "focus-distance"),
    ("bokeh", "aperture-shape"),
    ("blades", "aperture-shape"),
    ("config", "settings"),
    ("half-float", "half"),
    ("fp16", "half"),
    ("silent", "quiet"),
    ("debug", "verbose"),
    ("log-file", "log"),
    ("force", "yes"),
    ("cull", "backfaces"),
    ("backface-culling", "backfaces"),
    ("alpha", "transparent"),
    ("transparent-background", "transparent"),
    ("bit-depth", "png-depth"),
    ("max-memory", "memory-limit"),
    ("memory", "memory-limit"),
    ("eye", "look-from"),
    ("target", "look-at"),
    ("field-of-view", "fov"),
    ("yfov", "fov"),
    ("turntable", "orbit"),
    ("material-variant", "variant"),
    ("fail-if", "fail-above"),
    ("effect", "vary"),
    ("light-samples", "light"),
    ("shadow-samples", "light"),
    ("runs", "run"),
];

/// Text that follows the suggested option where its value is written differently, such as one size for two options.
const WRITTEN: &[(&str, &str)] = &[
    ("width", ", as WIDTHxHEIGHT such as 640x480"),
    ("height", ", as WIDTHxHEIGHT such as 640x480"),
    ("f-stop", ", the lens radius in scene units"),
    ("fstop", ", the lens radius in scene units"),
    ("frame", ", in seconds"),
    ("no-env", " none"),
    ("no-environment", " none"),
    ("position", ", the camera position as X,Y,Z"),
    ("camera-position", ", the camera position as X,Y,Z"),
];

/// Options of other programs that have no counterpart here, each with the alternative.
const ABSENT: &[(&str, &str)] = &[
    ("denoise", NO_DENOISER),
    ("denoiser", NO_DENOISER),
    ("oidn", NO_DENOISER),
    ("gpu", "dapple renders on the CPU; see --threads"),
    ("device", "dapple renders on the CPU; see --threads"),
    ("list", LISTS),
    ("list-cameras", LISTS),
    ("list-scenes", LISTS),
];

const NO_DENOISER: &str =
    "there is no denoiser; --spp N takes more samples, --error-limit X as many as the image needs";
const LISTS: &str =
    "dapple info SCENE lists the contents of a scene, dapple render --help the built-in scenes";

/// Names that other programs use for a command.
const COMMANDS: &[(&str, &str)] = &[
    ("trace", "render"),
    ("raytrace", "render"),
    ("draw", "render"),
    ("image", "render"),
    ("compare", "diff"),
    ("cmp", "diff"),
    ("inspect", "info"),
    ("stats", "info"),
    ("list", "info"),
    ("show", "info"),
    ("bench", "converge"),
    ("benchmark", "converge"),
    ("test", "verify"),
    ("check", "verify"),
    ("selftest", "verify"),
    ("cost", "rays"),
    ("forecast", "rays"),
    ("debug", "replay"),
    ("completion", "completions"),
    ("manual", "man"),
];

/// Lowest similarity (1 = equal) at which a word counts as a misspelling of another.
const LIKE: f64 = 0.6;

/// Returns the name that `word` most likely means: the only one that it is a prefix of, the only one that it is a part
/// of, or the most similar one.
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_ascii_lowercase();
    let names: Vec<&str> = names.into_iter().collect();
    let only = |least: usize, is: &dyn Fn(&str) -> bool| {
        let mut found = names.iter().filter(|name| word.len() >= least && is(name));
        found.next().filter(|_| found.next().is_none()).copied()
    };
    let part = only(3, &|name| name.starts_with(&word)).or_else(|| only(4, &|name| name.contains(&word)));
    if part.is_some() {
        return part;
    }
    let likeness = |name: &str| strsim::normalized_damerau_levenshtein(&word, name);
    let best = names.into_iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    best.filter(|name| likeness(name) >= LIKE)
}

/// Returns a suggestion for an unknown option of `sub`, one of `all`'s commands: `did you mean --spp?`
pub fn option(all: &Command, sub: &str, word: &str) -> Option<String> {
    let plain = word.trim_start_matches('-').to_ascii_lowercase().replace('_', "-");
    let own = all.find_subcommand(sub).map(longs).unwrap_or_default();
    let meant = alias(OPTIONS, &plain).filter(|name| own.iter().any(|own| own == name));
    if let Some(name) = meant {
        let how = alias(WRITTEN, &plain).unwrap_or_default();
        return Some(format!("did you mean --{name}{how}?"));
    }
    if let Some(instead) = alias(ABSENT, &plain) {
        return Some(instead.into());
    }
    if own.contains(&plain) {
        return Some(format!("did you mean --{plain}?"));
    }
    if let Some(flag) = plain.strip_prefix("no-").filter(|flag| own.iter().any(|own| own == flag)) {
        return Some(format!("a flag is reset by --{flag}=false"));
    }
    let others = all.get_subcommands().filter(|other| longs(other).contains(&plain));
    let others: Vec<&str> = others.map(Command::get_name).collect();
    match others[..] {
        [] => slip(&plain, &own).map(|name| match name {
            "samples" => "did you mean --spp, the number of samples, or --samples BEGIN:END, a range?".into(),
            name => format!("did you mean --{name}?"),
        }),
        _ if sub.is_empty() => Some(format!("it is an option of dapple {}", others.join(", "))),
        _ => Some(format!("not available for {sub}; it is an option of {}", others.join(", "))),
    }
}

/// Returns a suggestion for an unknown command.
pub fn command(all: &Command, word: &str) -> Option<String> {
    let plain = word.to_ascii_lowercase();
    let names: Vec<&str> =
        all.get_subcommands().filter(|s| !s.is_hide_set()).map(Command::get_name).collect();
    let meant = alias(COMMANDS, &plain).filter(|name| names.contains(name));
    meant.or_else(|| nearest(&plain, names)).map(|name| format!("did you mean dapple {name}?"))
}

/// Returns a suggestion for an unknown key of a settings file.
pub fn key(word: &str, keys: &[String]) -> Option<String> {
    let plain = word.trim_start_matches('-').to_ascii_lowercase().replace('_', "-");
    if let Some(instead) = alias(ABSENT, &plain) {
        return Some(instead.into());
    }
    let is_key = |name: &&str| keys.iter().any(|key| key == name);
    let meant = alias(OPTIONS, &plain).filter(is_key);
    let meant = meant.or_else(|| slip(&plain, keys));
    meant.map(|name| format!("did you mean {name}?"))
}

/// Returns the name that a word misspells, either directly or through another program's name for it.
fn slip<'a>(word: &str, names: &'a [String]) -> Option<&'a str> {
    let named = |meant: &str| names.iter().map(String::as_str).find(|name| *name == meant);
    let ours = nearest(word, names.iter().map(String::as_str));
    let theirs = || OPTIONS.iter().filter(|(_, name)| named(name).is_some()).map(|(other, _)| *other);
    ours.or_else(|| nearest(word, theirs()).and_then(|other| named(alias(OPTIONS, other)?)))
}

fn alias(table: &[(&str, &'static str)], word: &str) -> Option<&'static str> {
    table.iter().find(|(other, _)| *other == word).map(|(_, name)| *name)
}

/// Returns the long names of the options that a command uses.
fn longs(command: &Command) -> Vec<String> {
    let shown = command.get_arguments().filter(|arg| !arg.is_hide_set());
    shown.filter_map(|arg| arg.get_long().map(String::from)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args;

    #[test]
    fn slips_are_near() {
        let names = ["spp", "size", "output", "exposure", "max-bounces", "env", "env-rotation"];
        for (word, meant) in [
            ("sppp", "spp"),
            ("szie", "size"),
            ("ouput", "output"),
            ("Exposure", "exposure"),
            ("expose", "exposure"),
            ("max", "max-bounces"),
            ("env-rot", "env-rotation"),
            ("bounce", "max-bounces"),
        ] {
            assert_eq!(nearest(word, names), Some(meant), "{word}");
        }
        for word in ["zzz", "", "hexagons", "q"] {
            assert_eq!(nearest(word, names), None, "{word}");
        }
    }

    /// An alias that is itself an option of the render would never be reached.
    #[test]
    fn aliases_are_no_options() {
        let render = longs(args::command().find_subcommand("render").unwrap());
        for (alias, _) in OPTIONS {
            assert!(!render.iter().any(|name| name == alias), "--{alias}");
        }
        // And what is meant is an option of some command.
        let all = args::command();
        for (alias, name) in OPTIONS {
            let is_there = all.get_subcommands().any(|sub| longs(sub).iter().any(|long| long == name));
            assert!(is_there || !cfg!(feature = "report"), "--{alias}: there is no --{name}");
        }
        for (absent, _) in ABSENT {
            assert!(!render.iter().any(|name| name == absent), "{absent}");
            assert!(super::alias(OPTIONS, absent).is_none(), "{absent}");
        }
        for (alias, _) in WRITTEN {
            assert!(super::alias(OPTIONS, alias).is_some(), "{alias}");
        }
    }
}
