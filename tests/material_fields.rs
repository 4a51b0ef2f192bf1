//! Only `materials` interprets the fields of a material: the integrator reads none of them, but uses the lobes and
//! methods of the material.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};
use syn::{Expr, ExprField, FieldPat, ItemMod, Member};

/// Reads of fields with the name of a field of `Material`, and of the factors of a textured material.
struct Reads<'a> {
    fields: &'a BTreeSet<String>,
    found: Vec<String>,
}

impl Reads<'_> {
    fn note(&mut self, member: &Member) {
        if let Member::Named(name) = member {
            let name = name.to_string();
            if self.fields.contains(&name) {
                self.found.push(name);
            }
        }
    }
}

/// Whether the field is that of a medium, whose index of refraction is not a field of a material.
fn is_body(of: &Expr) -> bool {
    match of {
        Expr::Path(path) => path.path.is_ident("body") || path.path.is_ident("bodies"),
        Expr::Index(index) => is_body(&index.expr),
        Expr::Field(field) => matches!(&field.member, Member::Named(name) if name == "bodies"),
        _ => false,
    }
}

impl<'ast> Visit<'ast> for Reads<'_> {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        let is_test = item.attrs.iter().any(|attr| {
            attr.meta
                .require_list()
                .is_ok_and(|list| list.path.is_ident("cfg") && list.tokens.to_string() == "test")
        });
        if !is_test {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_expr_field(&mut self, field: &'ast ExprField) {
        if !is_body(&field.base) {
            self.note(&field.member);
        }
        visit::visit_expr_field(self, field);
    }

    fn visit_field_pat(&mut self, field: &'ast FieldPat) {
        self.note(&field.member);
        visit::visit_field_pat(self, field);
    }

    /// Visits arguments of macros, as far as they are expressions.
    fn visit_macro(&mut self, node: &'ast syn::Macro) {
        let parser = syn::punctuated::Punctuated::<Expr, syn::Token![,]>::parse_terminated;
        if let Ok(arguments) = node.parse_body_with(parser) {
            arguments.iter().for_each(|argument| {
                let mut inner = Reads { fields: self.fields, found: Vec::new() };
                inner.visit_expr(argument);
                self.found.append(&mut inner.found);
            });
        }
    }
}

fn reads(source: &str, fields: &BTreeSet<String>) -> Vec<String> {
    let mut reads = Reads { fields, found: Vec::new() };
    reads.visit_file(&syn::parse_file(source).unwrap());
    reads.found
}

/// Returns the fields of `Material`, and `base`, the factors of a textured material.
fn fields() -> BTreeSet<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/materials/src/material.rs");
    let items = syn::parse_file(&fs::read_to_string(file).unwrap()).unwrap().items;
    let material = items.iter().find_map(|item| match item {
        syn::Item::Struct(item) if item.ident == "Material" => Some(item),
        _ => None,
    });
    let names = material
        .expect("the definition of Material has moved")
        .fields
        .iter()
        .filter_map(|f| f.ident.as_ref());
    names.map(ToString::to_string).chain(["base".to_string()]).collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn the_integrator_reads_no_field_of_a_material() {
    let (root, fields) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/integrator/src"), fields());
    let mut wrong = Vec::new();
    for file in files(&root) {
        let found = reads(&fs::read_to_string(&file).unwrap(), &fields);
        wrong.extend(found.into_iter().map(|field| format!("{}: .{field}", file.display())));
    }
    assert!(wrong.is_empty(), "fields of a material; use its methods instead:\n{}", wrong.join("\n"));
}

#[test]
fn a_read_is_seen() {
    let fields = fields();
    assert!(fields.contains("transmission") && fields.contains("roughness"));
    for (body, is_read) in [
        ("shading.material.transmission > 0.0", true),
        ("scene.materials[i].base.ior", true),
        ("m.thin", true),
        ("{ let base = &m.base; 1 }", true),
        ("{ let Material { metallic, .. } = m; metallic }", true),
        ("assert!(m.roughness > 0.0, \"{}\", 1)", true),
        ("{ shading.material.ior = 1.0; }", true),
        ("m.transmission()", false),
        ("bodies[i].ior", false),
        ("material.name", false),
    ] {
        assert_eq!(!reads(&format!("fn f() {{ {body}; }}"), &fields).is_empty(), is_read, "{body}");
    }
    assert!(reads("#[cfg(test)] mod tests { fn f() { m.thin; } }", &fields).is_empty());
}
