//! Which stiff and extreme cases does this build get right? The catalogue: every case with the one thing that goes wrong in
//! naive renderers, its source, and a check that runs on the user's machine.
//!
//! A case that waits for a feature is pending, with the reason; it neither passes nor fails.

mod bounds;
mod bsdf;
mod camera;
mod deep;
mod fresnel;
mod gloss;
mod hits;
mod leaving;
mod lights;
mod many;
mod media;
mod motion;
mod paths;
mod places;
mod samples;
mod scale;
mod shading;
mod sky;
mod spheres;
mod system;
mod transforms;
mod triangles;

pub use crate::tally::Outcome;
use std::panic::catch_unwind;

/// How long checks may take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// For tests: seconds in all.
    Quick,
    /// Under three minutes on two cores.
    #[default]
    Normal,
    /// As long as it needs.
    Thorough,
}

impl Effort {
    /// One of three numbers.
    pub(crate) fn of<T>(self, quick: T, normal: T, thorough: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Normal => normal,
            Self::Thorough => thorough,
        }
    }
}

/// What a case does.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// Runs.
    Run(fn(Effort) -> Outcome),
    /// Waits for a feature; the reason.
    Pending(&'static str),
}

/// One entry of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// A01 to D20.
    pub id: &'static str,
    /// What it is about.
    pub title: &'static str,
    /// What goes wrong in naive renderers.
    pub naive: &'static str,
    /// Where the fix or the exact value comes from.
    pub source: &'static str,
    /// What is done.
    pub check: Check,
}

impl Case {
    /// What the first letter of the id means.
    pub fn family(&self) -> &'static str {
        match self.id.as_bytes()[0] {
            b'A' => "geometry and scale",
            b'B' => "lights",
            b'C' => "BSDF",
            _ => "estimator and system",
        }
    }

    /// Whether it takes much longer than most: better begun early.
    pub fn is_long(&self) -> bool {
        matches!(self.id, "D01" | "D03" | "A12" | "B13")
    }

    /// Whether it compares times, and so wants the machine to itself.
    pub fn is_timed(&self) -> bool {
        matches!(self.id, "A15" | "B08" | "D11")
    }

    /// Runs the check; None when it is pending. A check that panics fails.
    pub fn run(&self, effort: Effort) -> Option<Outcome> {
        let Check::Run(check) = self.check else { return None };
        Some(catch_unwind(|| check(effort)).unwrap_or_else(|_| Outcome {
            expected: 1.0,
            measured: 0.0,
            error: 0.0,
            tolerance: 0.0,
            passed: false,
            note: "the check itself broke off".into(),
        }))
    }
}

/// All cases, by id.
pub fn catalogue() -> Vec<Case> {
    let families: [&[Case]; 22] = [
        scale::CASES,
        hits::CASES,
        triangles::CASES,
        spheres::CASES,
        leaving::CASES,
        motion::CASES,
        transforms::CASES,
        camera::CASES,
        lights::CASES,
        many::CASES,
        places::CASES,
        media::CASES,
        sky::CASES,
        gloss::CASES,
        bsdf::CASES,
        fresnel::CASES,
        shading::CASES,
        paths::CASES,
        deep::CASES,
        samples::CASES,
        system::CASES,
        bounds::CASES,
    ];
    let mut all: Vec<Case> = families.concat();
    all.sort_by_key(|case| case.id);
    all
}

/// Cases whose id matches one of the comma-separated patterns, `*` for any ending. The first pattern without a case is
/// the error.
pub fn select(patterns: &str) -> Result<Vec<Case>, String> {
    let all = catalogue();
    let mut chosen = vec![false; all.len()];
    for pattern in patterns.split(',').map(str::trim) {
        let upper = pattern.to_ascii_uppercase();
        let matches = |id: &str| match upper.strip_suffix('*') {
            Some(start) => id.starts_with(start),
            None => id == upper,
        };
        let mut known = false;
        for (chosen, case) in chosen.iter_mut().zip(&all) {
            if matches(case.id) {
                (known, *chosen) = (true, true);
            }
        }
        if pattern.is_empty() || !known {
            return Err(pattern.to_owned());
        }
    }
    Ok(all.into_iter().zip(chosen).filter(|(_, chosen)| *chosen).map(|(case, _)| case).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_id_is_there_once() {
        let families = [('A', 24), ('B', 20), ('C', 18), ('D', 20)];
        let expected: Vec<String> =
            families.iter().flat_map(|(f, n)| (1..=*n).map(move |i| format!("{f}{i:02}"))).collect();
        let ids: Vec<&str> = catalogue().iter().map(|case| case.id).collect();
        assert_eq!(ids, expected);
        for case in catalogue() {
            assert!(
                !case.title.is_empty() && !case.naive.is_empty() && !case.source.is_empty(),
                "{}",
                case.id
            );
        }
    }

    #[test]
    fn patterns_choose() {
        let ids = |p: &str| select(p).map(|all| all.iter().map(|c| c.id).collect::<Vec<_>>());
        assert_eq!(ids("a03, D01"), Ok(vec!["A03", "D01"]));
        assert_eq!(ids("B*").unwrap().len(), 20);
        assert_eq!(ids("*").unwrap().len(), 82);
        for bad in ["", "A99", "A03,", "Z*", "A3"] {
            assert!(ids(bad).is_err(), "{bad}");
        }
    }
}
