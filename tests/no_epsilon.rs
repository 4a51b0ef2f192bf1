//! The sources contain no tolerance in scene units: lengths are compared exactly, or with a bound on their own rounding
//! error. Angles, solid angles and differences of cosines have no constant lower bounds either: every small number in
//! the affected crates is listed here with its meaning.

use std::fs;
use std::path::{Path, PathBuf};

/// Small dimensionless numbers: file, literal, meaning.
const DIMENSIONLESS: [(&str, &str, &str); 33] = [
    ("camera/src/camera.rs", "1e-6", "sine of an angle"),
    ("camera/src/view.rs", "1e-4", "slope at which f64 takes over"),
    ("math/src/lanes/frame.rs", "1e-12", "squared sine"),
    ("math/src/motion/chain.rs", "1e-6", "ratio of scales"),
    ("math/src/motion/pose.rs", "1e-12", "volume over the product of the edges"),
    ("math/src/motion/pose.rs", "1e-14", "normal over the square of the size"),
    ("math/src/motion/pose.rs", "1e-15", "length over the product of lengths"),
    ("math/src/motion/track.rs", "1e-8", "angle"),
    ("scene/src/builtin.rs", "1e-3", "metres in a millimetre"),
    ("scene/src/emission.rs", "1e-3", "gap over the edge"),
    ("scene/src/gltf/material.rs", "1e-30", "transmitted share"),
    ("scene/src/gltf/node.rs", "1e-12", "volume of three unit vectors"),
    ("scene/src/gltf/read.rs", "1e-6", "ratio of scales"),
    ("scene/src/view.rs", "1e-24", "squared sine"),
    ("geometry/src/surface.rs", "1e-6", "relative rounding of a barycentric coordinate"),
    ("geometry/src/bvh/triangle.rs", "1e-27", "where f32 products underflow and f64 takes over"),
    ("integrator/src/bias_report.rs", "1e-30", "throughput"),
    ("integrator/src/vertex.rs", "1e-3", "cosine"),
    ("lights/src/aimed.rs", "1e-3", "solid angle at which two exact sampling methods switch"),
    ("lights/src/octet.rs", "1e-36", "squared length that keeps the weights of a choice finite"),
    ("lights/src/octet.rs", "1e-6", "rounding of an f32 cosine; weights of a choice, and only towards more"),
    ("lights/src/lanes/rectangle.rs", "1e-30", "product of sines, of a place that the edges bound"),
    ("lights/src/rectangle.rs", "1e-5", "cosine between edges"),
    ("lights/src/solid_angle.rs", "1e-5", "tangent at which a series takes over, to 3e-11 of its value"),
    ("materials/src/bounds.rs", "2e-4", "ratio of indices of refraction"),
    ("materials/src/lanes/diffuse.rs", "1e-4", "transmitted fraction of light"),
    ("materials/src/lanes/fresnel.rs", "1e-4", "difference of indices"),
    ("materials/src/lanes/layers.rs", "1e-6", "least index of refraction"),
    ("materials/src/lanes/microfacet.rs", "1e-3", "roughness"),
    ("materials/src/lanes/mirror.rs", "1e-4", "blur over the distance"),
    ("materials/src/lanes/mirror.rs", "1e-7", "rounding of unit vectors"),
    ("materials/src/lanes/kind.rs", "1e-18", "cosine whose square f32 still holds"),
    ("materials/src/lanes/transmission.rs", "1e-3", "probability"),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Literals with a negative exponent outside comments and tests, and constants named like a tolerance.
fn suspects(text: &str) -> Vec<String> {
    let code = text.split("[cfg(test)]").next().unwrap_or_default();
    let mut all = Vec::new();
    for line in code.lines() {
        let line = line.split("//").next().unwrap_or_default();
        for word in line.split(|c: char| !(c.is_ascii_alphanumeric() || "._-".contains(c))) {
            let number = word.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
            if number && word.contains("e-") {
                all.push(word.trim_end_matches("_f32").trim_end_matches("_f64").to_string());
            }
        }
        let machine = line.contains("f32::EPSILON") || line.contains("f64::EPSILON");
        let named =
            ["EPSILON", " EPS:", "TOLERANCE", "RAY_OFFSET", "T_MIN"].iter().any(|name| line.contains(name));
        if named && !machine {
            all.push(line.trim().to_string());
        }
    }
    all
}

#[test]
fn lengths_are_not_compared_with_constants() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let mut files = Vec::new();
    for part in ["math", "geometry", "integrator", "scene", "camera", "lights", "materials", "sampling"] {
        sources(&crates.join(part).join("src"), &mut files);
    }
    assert!(files.len() > 50);
    for file in files {
        let name = file.strip_prefix(&crates).unwrap().to_string_lossy().replace('\\', "/");
        for suspect in suspects(&fs::read_to_string(&file).unwrap()) {
            let known = DIMENSIONLESS.iter().any(|(f, literal, _)| *f == name && *literal == suspect);
            assert!(
                known,
                "{name}: '{suspect}' looks like a tolerance; if it is not a length, list it here with its meaning"
            );
        }
    }
}

/// The search above misses decimal fractions: none may bound a difference from below, as `max(0.001)` did for two
/// cosines.
#[test]
fn differences_are_not_held_above_constants() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let mut files = Vec::new();
    for part in ["math", "geometry", "integrator", "scene", "camera", "lights", "materials", "sampling"] {
        sources(&crates.join(part).join("src"), &mut files);
    }
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let code = text.split("[cfg(test)]").next().unwrap_or_default();
        for line in code.lines().map(|line| line.split("//").next().unwrap_or_default()) {
            assert!(!holds_up(line), "{}: {line}", file.display());
        }
    }
    assert!(holds_up("1.0 / (cos_inner - cos_outer).max(0.001)") && holds_up("x.max(1e-4)"));
    assert!(!holds_up("x.max(0.0)") && !holds_up("count.max(1)") && !holds_up("a.max(b)"));
}

/// Whether a line contains `.max(` with a literal between 0 and 1.
fn holds_up(line: &str) -> bool {
    line.split(".max(").skip(1).any(|rest| {
        let literal: String =
            rest.chars().take_while(|c| c.is_ascii_digit() || ".e-_".contains(*c)).collect();
        let value: f64 = literal.replace('_', "").parse().unwrap_or(0.0);
        rest[literal.len()..].starts_with(')')
            && value > 0.0
            && value < 1.0
            && !line.contains("per_sample")
            && !line.contains("elapsed")
    })
}

#[test]
fn a_tolerance_is_seen() {
    assert_eq!(suspects("const RAY_EPSILON: f32 = 1e-4;").len(), 2);
    assert_eq!(suspects("if t > 0.5e-6 { }"), ["0.5e-6"]);
    assert!(
        suspects("// 1e-4\nlet x = f32::EPSILON * t - 1.0; // EPSILON\n#[cfg(test)]\nlet y = 1e-9;")
            .is_empty()
    );
}
