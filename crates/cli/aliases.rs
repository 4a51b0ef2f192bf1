//! Alternative names of option values, from other renderers and papers. Upper and lower case are equivalent.

use std::fmt::Display;
use std::str::FromStr;

/// Pairs of an alias and the canonical name, which messages use.
pub type Aliases = &'static [(&'static str, &'static str)];

pub const PATTERNS: Aliases = &[
    ("jittered", "stratified"),
    ("jitter", "stratified"),
    ("owen", "sobol"),
    ("owen-sobol", "sobol"),
    ("sobol-owen", "sobol"),
    ("independent", "random"),
    ("regular", "grid"),
];

pub const METHODS: Aliases = &[
    ("path-tracer", "path"),
    ("path-tracing", "path"),
    ("pathtracer", "path"),
    ("pathtracing", "path"),
    ("pt", "path"),
    ("distributed", "distribution"),
    ("distributed-ray-tracing", "distribution"),
    ("distribution-ray-tracing", "distribution"),
    ("drt", "distribution"),
];

/// Alternative names of tone curves; `standard` is Blender's.
pub const TONES: Aliases = &[
    ("standard", "srgb"),
    ("khronos", "neutral"),
    ("pbr-neutral", "neutral"),
    ("khronos-pbr-neutral", "neutral"),
];

pub const FILTERS: Aliases = &[
    ("gauss", "gaussian"),
    ("triangle", "tent"),
    ("mitchell-netravali", "mitchell"),
    ("blackmanharris", "blackman-harris"),
];

pub const APERTURES: Aliases =
    &[("disc", "disk"), ("circle", "disk"), ("round", "disk"), ("hexagon", "blades:6")];

pub const LAYERS: Aliases = &[
    ("image", "beauty"),
    ("normals", "normal"),
    ("positions", "position"),
    ("z", "depth"),
    ("crypto", "cryptomatte"),
    ("sample-count", "samples"),
    ("object-id", "object"),
    ("objects", "object"),
    ("material-id", "material"),
    ("materials", "material"),
];

pub const BACKFACES: Aliases =
    &[("cull", "culled"), ("hide", "culled"), ("show", "shown"), ("visible", "shown")];

pub const EFFECTS: Aliases = &[
    ("antialiasing", "pixel"),
    ("dof", "lens"),
    ("depth-of-field", "lens"),
    ("shutter", "time"),
    ("motion-blur", "time"),
    ("lights", "light"),
    ("reflection", "glossy"),
    ("reflections", "glossy"),
    ("refraction", "refract"),
    ("refractions", "refract"),
    ("interreflection", "diffuse"),
];

pub const NONE: Aliases = &[];

/// Returns the canonical name of a value: lower case, with hyphens, and aliases resolved.
pub fn canonical(said: &str, aliases: Aliases) -> String {
    let plain = said.trim().to_ascii_lowercase().replace(['_', ' '], "-");
    aliases.iter().find(|(alias, _)| *alias == plain).map_or(plain, |(_, name)| (*name).into())
}

/// Builds a parser that accepts any name of a value; error messages quote the value as it was written.
pub fn named<T>(aliases: Aliases) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + Send + Sync + Clone + 'static,
    T::Err: Display,
{
    move |said| {
        let meant = canonical(said, aliases).parse::<T>();
        meant.or_else(|_| said.parse::<T>()).map_err(|e| e.to_string())
    }
}

/// Parses a sample set, whose pattern may be given by any of its names: `4X4:jittered`.
pub fn plan(said: &str) -> Result<dapple_integrator::sampling::SampleSet, String> {
    let plain = said.trim().to_ascii_lowercase().replace('×', "x");
    let meant = match plain.split_once(':') {
        Some((counts, pattern)) => format!("{counts}:{}", canonical(pattern, PATTERNS)),
        None => plain,
    };
    meant
        .parse()
        .or_else(|_| said.parse())
        .map_err(|e: dapple_integrator::sampling::SampleSetError| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_integrator::sampling::Pattern;
    use dapple_integrator::{Aov, Backfaces, Effect};

    #[test]
    fn names_have_other_names() {
        let pattern = named::<Pattern>(PATTERNS);
        for (said, meant) in [
            ("jittered", Pattern::Stratified),
            ("Sobol", Pattern::Sobol),
            ("OWEN", Pattern::Sobol),
            ("independent", Pattern::Random),
            ("grid", Pattern::Grid),
        ] {
            assert_eq!(pattern(said), Ok(meant), "{said}");
        }
        // A different sequence, which is not available.
        assert!(pattern("Halton").unwrap_err().contains("'Halton'"));
        assert_eq!(plan("4X4:Jittered"), "4x4:stratified".parse().map_err(|_| String::new()));
        assert!(plan("4x:jittered").unwrap_err().contains("4x:jittered"));
    }

    /// Every alias stands for a canonical name and is not one itself.
    #[test]
    fn aliases_mean_names() {
        fn check<T>(aliases: Aliases, read: impl Fn(&str) -> Option<T>) {
            for (alias, name) in aliases {
                assert!(read(name).is_some(), "{alias}: {name} is not a canonical name");
                assert!(read(alias).is_none(), "{alias} is a canonical name");
            }
        }
        check(PATTERNS, |s| s.parse::<Pattern>().ok());
        check(TONES, |s| s.parse::<dapple_integrator::imaging::Tone>().ok());
        check(FILTERS, |s| s.parse::<dapple_integrator::camera::Filter>().ok());
        check(APERTURES, |s| s.parse::<dapple_integrator::camera::Aperture>().ok());
        check(BACKFACES, |s| s.parse::<Backfaces>().ok());
        check(LAYERS, |s| s.parse::<Aov>().ok());
        check(EFFECTS, |s| Effect::ALL.iter().find(|(_, name)| *name == s));
        check(METHODS, |s| ["path", "distribution"].contains(&s).then_some(()));
    }
}
