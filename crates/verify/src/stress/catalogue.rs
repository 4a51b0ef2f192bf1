//! The list of all cases, and selection of cases by id.

use super::case::Case;
use super::{
    bounds, bsdf, camera, deep, fresnel, gloss, hits, leaving, lights, many, media, motion, paths, places,
    samples, scale, shading, sky, spheres, system, transforms, triangles,
};

/// All cases, sorted by id.
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

/// The cases whose id matches one of the comma-separated patterns; `*` matches any suffix.
///
/// # Errors
/// The first pattern that matches no case.
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
