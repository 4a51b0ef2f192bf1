//! Repair of enumerations that exporters spell differently from glTF: names in another case, numbers for names, and
//! names for numbers.
use crate::{Warning, error::quoted};
use serde_json::{Map, Value};

/// Allowed values of a field.
enum Allowed {
    /// Names, each with the numbers that are accepted for it.
    Names(&'static [(&'static str, &'static [u64])]),
    /// Numbers, each with its OpenGL name.
    Codes(&'static [(u64, &'static str)]),
}
use Allowed::{Codes, Names};

/// Location of an enumeration: the keys that lead to the objects that contain it (through lists as well), and its
/// fields.
struct Place {
    what: &'static str,
    path: &'static [&'static str],
    fields: &'static [&'static str],
    allowed: Allowed,
}

/// OpenGL magnification and minification filters.
const FILTERS: &[(u64, &str)] = &[
    (9728, "NEAREST"),
    (9729, "LINEAR"),
    (9984, "NEAREST_MIPMAP_NEAREST"),
    (9985, "LINEAR_MIPMAP_NEAREST"),
    (9986, "NEAREST_MIPMAP_LINEAR"),
    (9987, "LINEAR_MIPMAP_LINEAR"),
];
const WRAPPING: &[(u64, &str)] = &[(10497, "REPEAT"), (33071, "CLAMP_TO_EDGE"), (33648, "MIRRORED_REPEAT")];
const COMPONENTS: &[(u64, &str)] = &[
    (5120, "BYTE"),
    (5121, "UNSIGNED_BYTE"),
    (5122, "SHORT"),
    (5123, "UNSIGNED_SHORT"),
    (5125, "UNSIGNED_INT"),
    (5126, "FLOAT"),
];
const MODES: &[(u64, &str)] = &[
    (0, "POINTS"),
    (1, "LINES"),
    (2, "LINE_LOOP"),
    (3, "LINE_STRIP"),
    (4, "TRIANGLES"),
    (5, "TRIANGLE_STRIP"),
    (6, "TRIANGLE_FAN"),
];
/// Numbers: the order in the glTF specification, or OpenGL filters.
const INTERPOLATIONS: &[(&str, &[u64])] =
    &[("LINEAR", &[0, 9729]), ("STEP", &[1, 9728]), ("CUBICSPLINE", &[2, 3])];
const PATHS: &[(&str, &[u64])] = &[("translation", &[]), ("rotation", &[]), ("scale", &[]), ("weights", &[])];
const TYPES: &[(&str, &[u64])] = &[
    ("SCALAR", &[]),
    ("VEC2", &[]),
    ("VEC3", &[]),
    ("VEC4", &[]),
    ("MAT2", &[]),
    ("MAT3", &[]),
    ("MAT4", &[]),
];
const LIGHTS: &[(&str, &[u64])] = &[("directional", &[]), ("point", &[]), ("spot", &[])];

const PLACES: &[Place] = &[
    Place {
        what: "interpolations of animation samplers",
        path: &["animations", "samplers"],
        fields: &["interpolation"],
        allowed: Names(INTERPOLATIONS),
    },
    Place {
        what: "paths of animation channels",
        path: &["animations", "channels", "target"],
        fields: &["path"],
        allowed: Names(PATHS),
    },
    Place {
        what: "alpha modes of materials",
        path: &["materials"],
        fields: &["alphaMode"],
        allowed: Names(&[("OPAQUE", &[0]), ("MASK", &[1]), ("BLEND", &[2])]),
    },
    Place {
        what: "wrapping modes of samplers",
        path: &["samplers"],
        fields: &["wrapS", "wrapT"],
        allowed: Codes(WRAPPING),
    },
    Place {
        what: "filters of samplers",
        path: &["samplers"],
        fields: &["magFilter", "minFilter"],
        allowed: Codes(FILTERS),
    },
    Place {
        what: "types of cameras",
        path: &["cameras"],
        fields: &["type"],
        allowed: Names(&[("perspective", &[]), ("orthographic", &[])]),
    },
    Place {
        what: "types of lights",
        path: &["extensions", "KHR_lights_punctual", "lights"],
        fields: &["type"],
        allowed: Names(LIGHTS),
    },
    Place { what: "types of accessors", path: &["accessors"], fields: &["type"], allowed: Names(TYPES) },
    Place {
        what: "component types of accessors",
        path: &["accessors"],
        fields: &["componentType"],
        allowed: Codes(COMPONENTS),
    },
    Place {
        what: "modes of primitives",
        path: &["meshes", "primitives"],
        fields: &["mode"],
        allowed: Codes(MODES),
    },
];

/// Replaces such values by the ones of glTF, with a warning for each kind; returns whether there were any.
pub(super) fn sanitize(value: &mut Value, warnings: &mut Vec<Warning>) -> bool {
    let before = warnings.len();
    for place in PLACES {
        let (mut count, mut first) = (0, None);
        each(value, place.path, &mut |object| {
            for &field in place.fields {
                let Some(meant) = object.get(field).and_then(|given| place.allowed.meant(given)) else {
                    continue;
                };
                count += 1;
                let given = object.insert(field.into(), meant.clone());
                first.get_or_insert((given, meant));
            }
        });
        if let Some((Some(given), meant)) = first {
            let (given, meant) = (quoted(&given.to_string()), meant.to_string());
            warnings.push(Warning(format!(
                "{count} {} are not valid glTF and are interpreted: {given} as {meant}",
                place.what
            )));
        }
    }
    warnings.len() > before
}

impl Allowed {
    /// The intended value of an invalid one; None for values that are valid or cannot be interpreted.
    fn meant(&self, given: &Value) -> Option<Value> {
        match self {
            Names(names) => {
                let text = given.as_str();
                if names.iter().any(|(name, _)| text == Some(name)) {
                    return None;
                }
                let is = |(name, numbers): &&(&str, &[u64])| {
                    text.is_some_and(|text| is_like(text, name))
                        || given.as_u64().is_some_and(|number| numbers.contains(&number))
                };
                names.iter().find(is).map(|(name, _)| Value::from(*name))
            }
            Codes(codes) => {
                if given.is_u64() {
                    return None;
                }
                let is = |(code, name): &&(u64, &str)| match given {
                    Value::String(text) => is_like(text, name) || text.trim().parse() == Ok(*code),
                    number => number.as_f64() == Some(*code as f64),
                };
                codes.iter().find(is).map(|(code, _)| Value::from(*code))
            }
        }
    }
}

/// Whether both have the same letters and digits, ignoring case, separators and a leading `GL_`.
fn is_like(text: &str, name: &str) -> bool {
    let plain = |s: &str| -> String {
        s.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_uppercase()).collect()
    };
    let (text, name) = (plain(text), plain(name));
    text == name || text.strip_prefix("GL").is_some_and(|rest| rest == name)
}

/// Calls `of` with the objects at the end of a path.
fn each(value: &mut Value, path: &[&str], of: &mut dyn FnMut(&mut Map<String, Value>)) {
    match (value, path) {
        (Value::Array(items), _) => items.iter_mut().for_each(|item| each(item, path, of)),
        (Value::Object(map), []) => of(map),
        (Value::Object(map), [key, rest @ ..]) => {
            if let Some(inner) = map.get_mut(*key) {
                each(inner, rest, of);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn other_spellings_are_read() {
        let mut value = json!({
            "animations": [{
                "samplers": [{"interpolation": 9729}, {"interpolation": "step"}, {"interpolation": "Cubic_Spline"}, {"interpolation": 1}],
                "channels": [{"target": {"path": "Rotation"}}],
            }],
            "materials": [{"alphaMode": "blend"}, {"alphaMode": 1}],
            "samplers": [{"wrapS": "CLAMP_TO_EDGE", "wrapT": "33648", "magFilter": "gl_nearest", "minFilter": 9987.0}],
            "cameras": [{"type": "Perspective"}],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "SPOT"}]}},
            "accessors": [{"type": "vec3", "componentType": "FLOAT"}],
            "meshes": [{"primitives": [{"mode": "triangles"}]}],
        });
        let right = json!({
            "animations": [{
                "samplers": [{"interpolation": "LINEAR"}, {"interpolation": "STEP"}, {"interpolation": "CUBICSPLINE"}, {"interpolation": "STEP"}],
                "channels": [{"target": {"path": "rotation"}}],
            }],
            "materials": [{"alphaMode": "BLEND"}, {"alphaMode": "MASK"}],
            "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987}],
            "cameras": [{"type": "perspective"}],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot"}]}},
            "accessors": [{"type": "VEC3", "componentType": 5126}],
            "meshes": [{"primitives": [{"mode": 4}]}],
        });
        let mut warnings = Vec::new();
        assert!(sanitize(&mut value, &mut warnings));
        assert_eq!(value, right);
        assert_eq!(warnings.len(), PLACES.len(), "one for each kind");
        assert!(
            warnings[0].0.starts_with("4 interpolations") && warnings[0].0.ends_with("9729 as \"LINEAR\"")
        );
        assert!(!sanitize(&mut value, &mut warnings) && value == right, "valid values are unchanged");
    }

    #[test]
    fn what_means_nothing_stays() {
        for odd in [
            json!({"materials": [{"alphaMode": "GLASS"}, {"alphaMode": 7}, {"alphaMode": null}]}),
            json!({"samplers": [{"wrapS": 5, "wrapT": "SIDEWAYS", "magFilter": []}]}),
            json!({"animations": {"samplers": 3}, "cameras": [[{}], null, 1]}),
            json!([1]),
        ] {
            let (mut value, mut warnings) = (odd.clone(), Vec::new());
            assert!(!sanitize(&mut value, &mut warnings) && value == odd && warnings.is_empty());
        }
    }
}
