//! Every cited source, such as `[Walter 2007, eq. 33]`, is in the bibliography of ARCHITECTURE.md, every named section
//! is on the page of formulas, and neither contains unused entries.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Path of the page of formulas.
const FORMULAS: &str = "docs/science.md";

/// Paths below the root and contents of all text files.
fn texts() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let name = |p: &PathBuf| p.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
    files(root).into_iter().filter_map(|p| Some((name(&p), fs::read_to_string(&p).ok()?))).collect()
}

/// All files under `folder` except build products, in order.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    let skipped = |p: &PathBuf| p.ends_with("target") || p.ends_with("out") || p.ends_with(".git");
    entries
        .into_iter()
        .filter(|p| !skipped(p))
        .flat_map(|p| if p.is_dir() { files(&p) } else { vec![p] })
        .collect()
}

/// Source files and pages, except this file, whose examples are not citations.
fn prose() -> Vec<(String, String)> {
    let mut all = texts();
    all.retain(|(name, _)| {
        (name.ends_with(".rs") || name.ends_with(".md")) && name != "tests/bibliography.rs"
    });
    all
}

/// Joins lines and comments to one line.
fn joined(text: &str) -> String {
    let words = text.lines().flat_map(|l| l.trim_start().trim_start_matches(['/', '!']).split_whitespace());
    words.collect::<Vec<_>>().join(" ")
}

/// First name of the authors, and the year.
type Citation = (String, String);

/// Citations in brackets, and the sources of checks.
fn citations(text: &str) -> Vec<Citation> {
    let text = joined(text);
    let bracketed = text.split('[').skip(1).filter_map(|rest| rest.split_once(']'));
    let sources = text.split("source: \"").skip(1).filter_map(|rest| rest.split_once('"'));
    bracketed.chain(sources).flat_map(|(c, _)| c.split(';')).filter_map(citation).collect()
}

/// Parses `Name`, more names, a year.
fn citation(part: &str) -> Option<Citation> {
    let part = part.trim();
    let is_year =
        |w: &&str| w.len() == 4 && ("1700".."2100").contains(w) && w.bytes().all(|b| b.is_ascii_digit());
    let mut words =
        part.split(|c: char| c.is_whitespace() || c == ',' || c == '\\').filter(|w| !w.is_empty());
    let first = words.clone().next()?;
    let year = words.find(is_year)?;
    let before = &part[..part.find(year)?];
    let plain = |c: char| c.is_alphabetic() || " ,.&'’-".contains(c);
    let named = first.starts_with(char::is_uppercase) && before.chars().all(plain) && before.len() < 120;
    named.then(|| (first.trim_end_matches('.').to_string(), year.to_string()))
}

/// Entries without their titles, which may contain other names and years.
fn bibliography(page: &str) -> Vec<String> {
    let (_, list) = page.split_once("## Bibliography").expect("ARCHITECTURE.md has a bibliography");
    list.split("\n- ").skip(1).map(|entry| joined(entry.split('*').next().unwrap())).collect()
}

/// Whether a citation refers to the entry.
fn means((name, year): &Citation, entry: &str) -> bool {
    entry.contains(name.as_str()) && entry.contains(year.as_str())
}

/// Citations by file, except those in the bibliography itself.
fn all_citations() -> Vec<(String, Citation)> {
    let before = |text: String| text.split("## Bibliography").next().unwrap().to_string();
    let cited = |(file, text)| citations(&before(text)).into_iter().map(move |c| (String::clone(&file), c));
    prose().into_iter().flat_map(cited).collect()
}

fn entries() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    bibliography(&fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap())
}

#[test]
fn every_source_is_in_the_bibliography() {
    let (cited, entries) = (all_citations(), entries());
    let is_missing = |c: &Citation| !entries.iter().any(|e| means(c, e));
    let missing: Vec<_> = cited.iter().filter(|(_, c)| is_missing(c)).collect();
    assert!(cited.len() > 200, "only {} citations: has the notation changed?", cited.len());
    assert!(missing.is_empty(), "add to the bibliography of ARCHITECTURE.md: {missing:#?}");
}

#[test]
fn every_entry_is_cited() {
    let (cited, entries) = (all_citations(), entries());
    let idle: Vec<_> = entries.iter().filter(|e| !cited.iter().any(|(_, c)| means(c, e))).collect();
    assert!(entries.len() > 70, "only {} entries: has the notation changed?", entries.len());
    assert!(idle.is_empty(), "cite or remove from the bibliography of ARCHITECTURE.md: {idle:#?}");
}

#[test]
fn citations_are_recognised() {
    let found = |text: &str| citations(text).into_iter().map(|(n, y)| format!("{n} {y}")).collect::<Vec<_>>();
    assert_eq!(found("/// as in [Walter 2007, eq. 33]"), ["Walter 2007"]);
    assert_eq!(found("/// [Conty Estevez and\n/// Kulla 2018, §4.1]"), ["Conty 2018"]);
    assert_eq!(found("//! [Welford 1962; Chan, Golub, LeVeque 1983]"), ["Welford 1962", "Chan 1983"]);
    assert_eq!(found("source: \"Woop 2013; Lambert 1760; of its own\","), ["Woop 2013", "Lambert 1760"]);
    assert!(found("let a = [x; 2000]; // [Key] and [0, 2048]").is_empty());
}

#[test]
fn entries_are_known_by_their_heads() {
    let entries =
        bibliography("[A 1990]\n\n## Bibliography\n\n- Woop 2013. S. Woop. *After Ize 2012.* X 7.\n");
    let is_there = |name: &str, year: &str| means(&(name.into(), year.into()), &entries[0]);
    assert_eq!(entries.len(), 1);
    assert!(is_there("Woop", "2013"));
    assert!(!is_there("Ize", "2012") && !is_there("Woop", "2012"));
}

/// Titles on the page of formulas.
fn titles(page: &str) -> BTreeSet<String> {
    page.lines().filter_map(|l| l.strip_prefix("### ")).map(str::to_string).collect()
}

/// Titles that a text refers to, `docs/science.md, "One" and "Another"`; `None` for a reference without any.
fn named(text: &str) -> Vec<Option<String>> {
    let text = joined(text).replace("\\\"", "\"");
    let mut found = Vec::new();
    for mut rest in text.split(FORMULAS).skip(1) {
        let before = found.len();
        while let Some((title, after)) =
            [", \"", " and \""].iter().find_map(|s| rest.strip_prefix(s)).and_then(|r| r.split_once('"'))
        {
            found.push(Some(title.to_string()));
            rest = after;
        }
        if found.len() == before {
            found.push(None);
        }
    }
    found
}

#[test]
fn every_section_named_is_there_and_every_section_is_named() {
    let files = prose();
    let page = titles(&files.iter().find(|(name, _)| name == FORMULAS).expect("the page").1);
    let mut wanted = BTreeSet::new();
    let mut faults = Vec::new();
    for (file, text) in files.iter().filter(|(name, _)| name != FORMULAS) {
        for title in named(text) {
            match title {
                Some(title) if page.contains(&title) => {
                    wanted.insert(title);
                }
                // A page may refer to the whole page of formulas.
                None if file.ends_with(".md") => {}
                fault => faults.push((file, fault)),
            }
        }
    }
    assert!(page.len() > 40, "only {} sections: has the notation changed?", page.len());
    assert!(faults.is_empty(), "not sections of {FORMULAS}: {faults:#?}");
    let idle: Vec<_> = page.difference(&wanted).collect();
    assert!(idle.is_empty(), "refer to or remove from {FORMULAS}: {idle:#?}");
}

#[test]
fn sections_are_recognised() {
    let found =
        |text: &str| named(text).into_iter().map(|title| title.unwrap_or("none".into())).collect::<Vec<_>>();
    assert_eq!(found("/// L (docs/science.md, \"Closed room\"), \"quoted\""), ["Closed room"]);
    assert_eq!(found("//! docs/science.md,\n//! \"A\", \"B b\" and\n//! \"C\""), ["A", "B b", "C"]);
    assert_eq!(found(r#"source: "Woop 2013; docs/science.md, \"Boxes\"","#), ["Boxes"]);
    assert_eq!(found("see docs/science.md"), ["none"]);
    assert_eq!(titles("# Page\n## Part\n### One\ntext\n### Two words\n").len(), 2);
}

/// No text refers to a page that readers do not have.
#[test]
fn no_page_outside_of_the_project_is_cited() {
    let word = ["SCI", "ENCE"].concat();
    let faults: Vec<_> =
        texts().into_iter().filter(|(_, text)| text.contains(&word)).map(|(n, _)| n).collect();
    assert!(faults.is_empty(), "refer to a section of {FORMULAS} or the published source: {faults:#?}");
}
