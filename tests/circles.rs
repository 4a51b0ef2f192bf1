//! Checks for circular dependencies between files: within a crate, a file may use another one only if that one does not
//! use it, directly or indirectly. A file that re-exports its children's items (`pub use`) counts as the file that
//! defines them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};
use syn::{Item, ItemUse, UseTree, Visibility};

/// Path of a module within its crate; empty for the root.
type Module = Vec<String>;
/// Path in the code, by segments.
type Segments = Vec<String>;

/// The modules of one crate, with the paths that each mentions and re-exports.
#[derive(Default)]
struct Crate {
    mentions: BTreeMap<Module, Vec<Segments>>,
    /// The re-exported path, by module and exported name.
    exports: BTreeMap<(Module, String), Segments>,
}

/// Collects the paths that a file mentions outside its tests.
struct Mentions<'a> {
    module: &'a Module,
    found: Vec<Segments>,
    exports: &'a mut BTreeMap<(Module, String), Segments>,
}

impl<'ast> Visit<'ast> for Mentions<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        let is_test = item.attrs.iter().any(|a| a.path().is_ident("cfg") && mentions_test(&a.meta));
        if !is_test {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let passes_on = !matches!(item.vis, Visibility::Inherited);
        for (path, name) in leaves(&item.tree) {
            if passes_on {
                self.exports.insert((self.module.clone(), name), path);
            } else {
                self.found.push(path);
            }
        }
    }

    /// `pub(super)` restricts the visibility of an item; it is not a use.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.found.push(path.segments.iter().map(|s| s.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, node: &'ast syn::Macro) {
        let text = node.tokens.to_string().replace(" :: ", "::");
        let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
        let paths = words.filter(|word| word.contains("::"));
        self.found.extend(paths.map(|p| p.split("::").map(str::to_string).collect::<Segments>()));
    }
}

fn mentions_test(meta: &syn::Meta) -> bool {
    meta.require_list().is_ok_and(|list| list.tokens.to_string() == "test")
}

/// Returns the paths of a tree of imports, each with its local name.
fn leaves(tree: &UseTree) -> Vec<(Segments, String)> {
    match tree {
        UseTree::Path(path) => leaves(&path.tree)
            .into_iter()
            .map(|(rest, name)| ([vec![path.ident.to_string()], rest].concat(), name))
            .collect(),
        UseTree::Name(name) => vec![(vec![name.ident.to_string()], name.ident.to_string())],
        UseTree::Rename(name) => vec![(vec![name.ident.to_string()], name.rename.to_string())],
        UseTree::Glob(_) => vec![(Vec::new(), "*".to_string())],
        UseTree::Group(group) => group.items.iter().flat_map(leaves).collect(),
    }
}

impl Crate {
    fn add(&mut self, module: Module, source: &str) -> syn::Result<()> {
        let file = syn::parse_file(source)?;
        let mut mentions = Mentions { module: &module, found: Vec::new(), exports: &mut self.exports };
        for item in file.items.iter().filter(|item| !matches!(item, Item::Verbatim(_))) {
            mentions.visit_item(item);
        }
        let found = mentions.found;
        self.mentions.insert(module, found);
        Ok(())
    }

    fn read(root: &Path) -> Self {
        let mut this = Self::default();
        for file in files(root) {
            let source = fs::read_to_string(&file).unwrap();
            let relative = file.strip_prefix(root).unwrap().with_extension("");
            let mut module: Module =
                relative.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
            if matches!(module.last().map(String::as_str), Some("mod" | "lib" | "main")) {
                module.pop();
            }
            this.add(module, &source).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        }
        this
    }

    /// Returns the module that defines the item at `path`, mentioned in module `from`; none for other crates and local
    /// names.
    fn definer(&self, from: &Module, path: &[String], depth: usize) -> Option<Module> {
        let mut rest = path;
        let mut at = match rest.first()?.as_str() {
            "crate" => {
                rest = &rest[1..];
                Module::new()
            }
            _ => from.clone(),
        };
        while let Some(step @ ("self" | "super")) = rest.first().map(String::as_str) {
            if step == "super" {
                at.pop()?;
            }
            rest = &rest[1..];
        }
        let is_relative = rest.len() == path.len();
        let child = |at: &Module, name: &String| [at.clone(), vec![name.clone()]].concat();
        if is_relative && !self.mentions.contains_key(&child(&at, &rest[0])) {
            return None;
        }
        while let Some(name) = rest.first()
            && self.mentions.contains_key(&child(&at, name))
        {
            at.push(name.clone());
            rest = &rest[1..];
        }
        let exported = rest.first().and_then(|name| self.exports.get(&(at.clone(), name.clone())));
        match exported {
            Some(path) if depth < 8 => {
                let whole = [path.clone(), rest[1..].to_vec()].concat();
                Some(self.definer(&at, &whole, depth + 1).unwrap_or(at))
            }
            _ => Some(at),
        }
    }

    fn arrows(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let to = |from: &Module, paths: &[Segments]| {
            let all = paths.iter().filter_map(|path| self.definer(from, path, 0));
            all.filter(|to| to != from).collect()
        };
        self.mentions.iter().map(|(from, paths)| (from.clone(), to(from, paths))).collect()
    }

    /// Returns files that depend on themselves, in groups of mutual dependencies.
    fn circles(&self) -> Vec<String> {
        let arrows = self.arrows();
        let reach: BTreeMap<&Module, BTreeSet<&Module>> =
            arrows.keys().map(|from| (from, reached(&arrows, from))).collect();
        let mut groups = BTreeSet::new();
        for (from, all) in &reach {
            let group: Vec<String> =
                all.iter().filter(|to| reach[**to].contains(from)).map(|to| shown(to)).collect();
            if !group.is_empty() {
                groups.insert(group.join(", "));
            }
        }
        groups.into_iter().collect()
    }
}

fn reached<'a>(arrows: &'a BTreeMap<Module, BTreeSet<Module>>, from: &'a Module) -> BTreeSet<&'a Module> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&Module> = arrows[from].iter().collect();
    while let Some(next) = open.pop() {
        if found.insert(next) {
            open.extend(arrows.get(next).into_iter().flatten());
        }
    }
    found
}

fn shown(module: &Module) -> String {
    if module.is_empty() { "the root".to_string() } else { module.join("/") }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Returns the source folders of the crates.
fn sources() -> Vec<PathBuf> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let folders = fs::read_dir(crates).unwrap().map(|entry| entry.unwrap().path());
    let mut sources: Vec<_> =
        folders.map(|f| if f.join("src").is_dir() { f.join("src") } else { f }).collect();
    sources.sort();
    sources
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    let mut wrong = Vec::new();
    for folder in sources() {
        let circles = Crate::read(&folder).circles();
        wrong.extend(circles.into_iter().map(|circle| format!("{}: {circle}", folder.display())));
    }
    assert!(wrong.is_empty(), "files that use each other in a circle:\n{}", wrong.join("\n"));
}

#[test]
fn a_circle_is_seen() {
    let circles = |files: &[(&str, &str)]| {
        let mut of = Crate::default();
        for (module, source) in files {
            let module = module.split('/').filter(|s| !s.is_empty()).map(str::to_string).collect();
            of.add(module, source).unwrap();
        }
        of.circles()
    };
    let root = ("", "mod a; mod b; pub use a::A; pub use b::B;");
    let a = ("a", "use crate::B; pub struct A(B);");
    assert!(circles(&[root, a, ("b", "pub struct B;")]).is_empty());
    assert_eq!(circles(&[root, a, ("b", "pub struct B; fn f(_: crate::a::A) {}")]), ["a, b"]);
    assert_eq!(circles(&[root, a, ("b", "pub struct B; fn f() { assert!(crate::a::x()); }")]), ["a, b"]);
    assert!(circles(&[root, a, ("b", "pub struct B; #[cfg(test)] mod tests { use crate::A; }")]).is_empty());
    let kept =
        ("p/c", "pub(super) struct C; impl C { pub(super) fn f(&self) {} pub(in super::super) fn g() {} }");
    assert!(circles(&[("p", "mod c; use c::C; fn f(_: C) {}"), kept]).is_empty());
    // A parent that only re-exports its children's items is in no circle; one whose items they use is.
    let child = ("p/c", "use super::D; pub struct C(D);");
    assert!(
        circles(&[("p", "mod c; mod d; pub use c::C; pub use d::D;"), child, ("p/d", "pub struct D;")])
            .is_empty()
    );
    assert_eq!(circles(&[("p", "mod c; use c::C; pub struct D; fn f(_: C) {}"), child]), ["p, p/c"]);
}
