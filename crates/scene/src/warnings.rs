//! Collection of warnings: equal ones are kept once, and of many that differ only in names and numbers the first few
//! stand for the others.
use crate::Warning;
use std::{
    collections::{HashMap, HashSet},
    hash::{DefaultHasher, Hash, Hasher},
};

/// Number of warnings of one kind that are kept.
const FIRST: usize = 5;
/// Number of kinds of which warnings are kept.
const KINDS: usize = 100;

/// Warnings in the order of their first occurrence.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    kept: Vec<Kept>,
    /// Position in `kept` of the last warning of each kind, and the number of warnings of that kind.
    kinds: HashMap<String, (usize, usize)>,
    /// Hashes of all warnings.
    known: HashSet<u64>,
}

#[derive(Debug)]
struct Kept {
    warning: Warning,
    /// Number of warnings of its kind that follow and are not kept.
    more: usize,
}

impl Warnings {
    /// The warnings of a list.
    pub fn of(all: Vec<Warning>) -> Self {
        let mut warnings = Self::default();
        all.into_iter().for_each(|warning| warnings.add(warning));
        warnings
    }

    /// Adds a warning unless the same one exists.
    pub fn add(&mut self, warning: Warning) {
        let mut hasher = DefaultHasher::new();
        warning.0.hash(&mut hasher);
        if !self.known.insert(hasher.finish()) {
            return;
        }
        let kind = kind(&warning.0);
        if self.kinds.len() >= KINDS && !self.kinds.contains_key(&kind) {
            return;
        }
        let (last, count) = self.kinds.entry(kind).or_default();
        *count += 1;
        if *count > FIRST {
            self.kept[*last].more += 1;
        } else {
            *last = self.kept.len();
            self.kept.push(Kept { warning, more: 0 });
        }
    }

    /// The warnings; the last one of a kind says how many others there were.
    pub fn summed(self) -> Vec<Warning> {
        let said = |Kept { warning, more }| match more {
            0 => warning,
            _ => Warning(format!("{warning} (and {more} more like this)")),
        };
        self.kept.into_iter().map(said).collect()
    }
}

/// A warning without the values it quotes and without digits.
fn kind(warning: &str) -> String {
    let (mut kind, mut is_quoted, mut before) = (String::new(), false, ' ');
    let mut rest = warning.chars().peekable();
    while let Some(c) = rest.next() {
        // An apostrophe within a word is no mark.
        let in_word = before.is_alphanumeric() && rest.peek().is_some_and(|next| next.is_alphanumeric());
        if c == '\'' && !in_word {
            is_quoted = !is_quoted;
        } else if !is_quoted && !c.is_ascii_digit() {
            kind.push(c);
        }
        before = c;
    }
    kind
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_like_warnings_are_summed_and_others_kept() {
        let mut all = Warnings::default();
        for i in 0..99 {
            all.add(Warning(format!("node {i} 'name {}' isn't even", "x".repeat(i))));
            all.add(Warning("the same every time".into()));
            all.add(Warning(format!("image {} is missing", i % 5)));
        }
        let said: Vec<String> = all.summed().into_iter().map(|w| w.0).collect();
        assert_eq!(said.len(), 5 + 1 + 5);
        assert_eq!(said[0], "node 0 'name ' isn't even");
        assert_eq!(said.iter().filter(|w| w.contains("more like this")).count(), 1);
        assert!(said.contains(&"node 4 'name xxxx' isn't even (and 94 more like this)".into()), "{said:?}");
        assert!(Warnings::of(Vec::new()).summed().is_empty());
    }
}
