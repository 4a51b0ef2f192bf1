//! Every source the code cites, such as `[Walter 2007, eq. 33]`, is in the bibliography of ARCHITECTURE.md.

use std::fs;
use std::path::{Path, PathBuf};

/// Rust files and READMEs under `folder`, in order.
fn texts(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    let skipped = |p: &PathBuf| p.ends_with("target") || p.ends_with(".git");
    entries
        .into_iter()
        .filter(|p| !skipped(p))
        .flat_map(|p| if p.is_dir() { texts(&p) } else { vec![p] })
        .filter(|p| p.extension().is_some_and(|e| e == "rs" || e == "md"))
        .collect()
}

/// First name and year of each citation in brackets; comments that run over lines are joined.
fn citations(text: &str) -> Vec<(String, String)> {
    let lines = text.lines().map(|l| l.trim_start().trim_start_matches(['/', '!']));
    let joined = lines.collect::<Vec<_>>().join(" ");
    let mut found = Vec::new();
    for part in
        joined.split('[').skip(1).filter_map(|rest| rest.split_once(']')).flat_map(|(c, _)| c.split(';'))
    {
        found.extend(citation(part));
    }
    found
}

/// `Name`, more names, a year.
fn citation(part: &str) -> Option<(String, String)> {
    let part = part.trim();
    let is_year =
        |w: &&str| w.len() == 4 && ("1900".."2100").contains(w) && w.bytes().all(|b| b.is_ascii_digit());
    let mut words =
        part.split(|c: char| c.is_whitespace() || c == ',' || c == '\\').filter(|w| !w.is_empty());
    let first = words.clone().next()?;
    let year = words.find(is_year)?;
    let before = &part[..part.find(year)?];
    let plain = |c: char| c.is_alphabetic() || " ,.&'’-".contains(c);
    let named = first.starts_with(char::is_uppercase) && before.chars().all(plain) && before.len() < 120;
    named.then(|| (first.trim_end_matches('.').to_string(), year.to_string()))
}

#[test]
fn every_source_is_in_the_bibliography() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let entries: Vec<&str> = page.split_once("## Bibliography").unwrap().1.split("\n- ").collect();
    let mut missing = Vec::new();
    let mut count = 0;
    for file in ["crates", "benches", "examples", "tests"].iter().flat_map(|f| texts(&root.join(f))) {
        for (name, year) in citations(&fs::read_to_string(&file).unwrap()) {
            count += 1;
            if !entries.iter().any(|e| e.contains(&name) && e.contains(&year)) {
                missing.push(format!("{name} {year} in {}", file.strip_prefix(root).unwrap().display()));
            }
        }
    }
    assert!(count > 30, "only {count} citations: are they still written this way?");
    assert!(missing.is_empty(), "add to the bibliography of ARCHITECTURE.md: {missing:#?}");
}

#[test]
fn citations_are_recognised() {
    let found = |text: &str| citations(text).into_iter().map(|(n, y)| format!("{n} {y}")).collect::<Vec<_>>();
    assert_eq!(found("/// as in [Walter 2007, eq. 33]"), ["Walter 2007"]);
    assert_eq!(found("/// [Conty Estevez and\n/// Kulla 2018, §4.1]"), ["Conty 2018"]);
    assert_eq!(found("//! [Welford 1962; Chan, Golub, LeVeque 1983]"), ["Welford 1962", "Chan 1983"]);
    assert!(found("let a = [x; 2000]; // [Key] and [0, 2048]").is_empty());
}
