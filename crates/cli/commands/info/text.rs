//! The facts as text: one subject per line, and one line for each item that has more than a name.

use crate::error;
use crate::verbose::counted_always;
use serde_json::Value;

/// Maximum number of items of a kind that are listed; JSON lists all.
const LISTED: usize = 50;
/// Maximum length of a name, in characters.
const NAME: usize = 80;

/// Formats all subjects.
pub fn lines(scene: &str, facts: &Value) -> Vec<String> {
    let mut lines = vec![format!("{scene}: {}", size(facts))];
    lines.extend(facts["error"].as_str().map(|e| format!("error: a render would reject this: {e}")));
    lines.extend(facts["generator"].as_str().map(|g| format!("generator: {}", name_of(g))));
    lines.extend(facts["settings_file"].as_str().map(|path| format!("settings file: {path}")));
    lines.extend(bounds(&facts["bounds"]));
    lines.extend(memory(facts));
    block(&mut lines, facts, "scenes", scene_line);
    block(&mut lines, facts, "variants", variant);
    block(&mut lines, facts, "animations", animation);
    lines.push(list(facts, "objects", object));
    lines.push(list(facts, "materials", plain));
    if count(facts, "shapes") > 0 {
        lines.push(format!("exact spheres and disks: {}", count(facts, "shapes")));
    }
    lines.push(list(facts, "textures", texture));
    block(&mut lines, facts, "lights", light);
    lines.extend(light_unit(&facts["light_unit"]));
    if !is_empty(facts, "emissive") {
        lines.push(list(facts, "emissive", emissive).replacen("emissive", "emissive materials", 1));
    }
    block(&mut lines, facts, "cameras", camera);
    if !is_empty(facts, "skins") {
        block(&mut lines, facts, "skins", skin);
    }
    if !is_empty(facts, "morphs") {
        lines.push(list(facts, "morphs", morph).replacen("morphs", "meshes with morph targets", 1));
    }
    lines.push(list(facts, "extensions", extension));
    for (key, word) in [("warnings", "warning"), ("notes", "note")] {
        let all = facts[key].as_array().into_iter().flatten();
        lines.extend(all.map(|said| format!("{word}: {}", error::one_line(text(said)))));
    }
    lines
}

/// Formats the counts of placed and of stored objects.
fn size(facts: &Value) -> String {
    let [nodes, meshes, triangles, stored] =
        ["nodes", "meshes", "triangles", "stored_triangles"].map(|key| count(facts, key));
    let placed = if triangles == stored {
        format!("{triangles} triangles")
    } else {
        let places = count(facts, "instances");
        format!(
            "{triangles} triangles as placed ({stored} stored in meshes, with {places} instances; each instance that \
             does not move is copied in memory)"
        )
    };
    format!("{nodes} nodes, {meshes} meshes, {placed}")
}

fn bounds(bounds: &Value) -> Option<String> {
    let (min, max) = (bounds.get("min")?, bounds.get("max")?);
    Some(format!("bounds: {} to {}", vector(min), vector(max)))
}

fn memory(facts: &Value) -> Option<String> {
    let megabytes = |key: &str| facts[key].as_f64().map(|bytes| short(bytes / 1e6, 4));
    let scene = megabytes("memory_bytes")?;
    Some(match megabytes("peak_memory_bytes") {
        Some(peak) => {
            let (w, h) = (&facts["width"], &facts["height"]);
            format!("memory: {scene} MB for the scene; a render of {w}x{h} needs about {peak} MB at peak")
        }
        None => format!("memory: about {scene} MB for the scene"),
    })
}

fn scene_line(s: &Value) -> String {
    let roots = s["roots"].as_u64().unwrap_or(0);
    let marks = [(s["default"] == true, "the default"), (s["shown"] == true, "shown")];
    format!("{}: {}{}", called(s), counted_always(roots as usize, "root node"), marked(&marks))
}

fn variant(v: &Value) -> String {
    format!("{}: {} primitives{}", called(v), v["primitives"], marked(&[(v["shown"] == true, "shown")]))
}

fn animation(a: &Value) -> String {
    let seconds = |key: &str| a[key].as_f64().unwrap_or(0.0);
    let mark = marked(&[(a["played"] == true, "selected")]);
    match a["error"].as_str() {
        Some(error) => format!("{}: cannot be read: {error}", called(a)),
        None => {
            let (start, end, length) = (seconds("start"), seconds("end"), seconds("length"));
            let channels = &a["channels"];
            format!(
                "{}: {start:.3} s to {end:.3} s, {length:.3} s long, {channels} channels{mark}",
                called(a)
            )
        }
    }
}

fn object(o: &Value) -> String {
    match o["instances"].as_u64().unwrap_or(1) {
        1 => plain(&o["name"]),
        n => format!("{} x{n}", plain(&o["name"])),
    }
}

fn texture(t: &Value) -> String {
    match t["error"].as_str() {
        Some(error) => format!("{} (cannot be read: {error})", plain(&t["name"])),
        None => format!("{} {}x{}", plain(&t["name"]), t["width"], t["height"]),
    }
}

fn light_unit(taken: &Value) -> Option<String> {
    let unit = taken["unit"].as_str()?;
    let divided = if unit == "photometric" { ", divided by 683 lm/W" } else { "" };
    Some(format!("light unit: {unit}{divided}: {} (--light-unit)", error::one_line(text(&taken["why"]))))
}

fn light(l: &Value) -> String {
    let mut line = text(&l["kind"]).to_string();
    if l.get("index").is_some() {
        line = format!("{}: {line}", called(l));
    }
    if let Some(intensity) = l["intensity"].as_f64() {
        line +=
            &format!(", {} {} times colour {}", short(intensity, 6), text(&l["unit"]), vector(&l["color"]));
    }
    if let Some(range) = l["range"].as_f64() {
        line += &format!(", up to a distance of {}", short(range, 6));
    }
    if let [inner, outer] = &l["cone_degrees"].as_array().map_or(&[][..], Vec::as_slice) {
        let [inner, outer] = [inner, outer].map(|angle| short(angle.as_f64().unwrap_or(0.0), 4));
        line += &format!(", cone from {inner} to {outer} degrees from its axis");
    }
    match l["placed"].as_u64() {
        Some(0) => line + " (not in this scene)",
        Some(n) if n > 1 => format!("{line} x{n}"),
        _ => line,
    }
}

fn emissive(e: &Value) -> String {
    let texture = if e["textured"] == true { " times its texture" } else { "" };
    format!("{} {} W/(m² sr){texture}", plain(&e["name"]), vector(&e["radiance"]))
}

fn camera(c: &Value) -> String {
    let mut line = format!("'{}': {}", plain(&c["name"]), text(&c["kind"]));
    line += &format!(" at {}", vector(&c["position"]));
    if c["direction"].is_array() {
        line += &format!(" towards {}", vector(&c["direction"]));
    }
    if let Some(angle) = c["yfov_degrees"].as_f64() {
        line += &format!(", {} degrees high", short(angle, 6));
    }
    if c["size"].is_array() {
        line += &format!(", {} wide and high", vector(&c["size"]));
    }
    if let Some(aspect) = c["aspect"].as_f64() {
        line += &format!(", aspect ratio {}", short(aspect, 5));
    }
    if let Some(near) = c["znear"].as_f64() {
        let far = c["zfar"].as_f64().map_or("infinite".to_string(), |far| short(far, 6));
        line += &format!(", znear {}, zfar {far}", short(near, 6));
    }
    line + if c["moves"] == true { ", moves" } else { "" }
}

fn skin(s: &Value) -> String {
    format!("{}: {} joints, used by {} nodes (not applied)", called(s), s["joints"], s["placed"])
}

fn morph(m: &Value) -> String {
    let name = m["name"].as_str().map_or_else(|| format!("mesh {}", m["mesh"]), name_of);
    format!("{name} {} targets (not applied)", m["targets"])
}

fn extension(e: &Value) -> String {
    let required = if e["required"] == true { "required" } else { "optional" };
    let supported = if e["supported"] == true { "" } else { ", not supported" };
    format!("{} ({required}{supported})", plain(&e["name"]))
}

/// Formats all items of a kind on one line.
fn list(facts: &Value, key: &str, item: fn(&Value) -> String) -> String {
    let all = facts[key].as_array().map_or(&[][..], Vec::as_slice);
    let mut items: Vec<String> = all.iter().take(LISTED).map(item).collect();
    if all.is_empty() {
        return format!("{key}: none");
    }
    items.extend((all.len() > LISTED).then(|| more(all.len())));
    format!("{key} ({}): {}", all.len(), items.join(", "))
}

/// Formats each item of a kind on a line of its own.
fn block(lines: &mut Vec<String>, facts: &Value, key: &str, item: fn(&Value) -> String) {
    let all = facts[key].as_array().map_or(&[][..], Vec::as_slice);
    if all.is_empty() {
        lines.push(format!("{key}: none"));
        return;
    }
    lines.push(format!("{key} ({}):", all.len()));
    lines.extend(all.iter().take(LISTED).map(|one| format!("  {}", item(one))));
    lines.extend((all.len() > LISTED).then(|| format!("  {}", more(all.len()))));
}

fn more(count: usize) -> String {
    format!("and {} more (--json lists all)", count - LISTED)
}

/// Formats the index and name of an item that can be selected by either.
fn called(one: &Value) -> String {
    match one["name"].as_str() {
        Some(name) => format!("{} '{}'", one["index"], name_of(name)),
        None => one["index"].to_string(),
    }
}

/// Formats the applicable marks, in parentheses.
fn marked(marks: &[(bool, &str)]) -> String {
    let words: Vec<&str> = marks.iter().filter(|(is, _)| *is).map(|(_, word)| *word).collect();
    if words.is_empty() { String::new() } else { format!(" ({})", words.join(", ")) }
}

fn is_empty(facts: &Value, key: &str) -> bool {
    facts[key].as_array().is_none_or(Vec::is_empty)
}

fn count(facts: &Value, key: &str) -> u64 {
    facts[key].as_u64().unwrap_or(0)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn plain(value: &Value) -> String {
    name_of(text(value))
}

/// Shortens a name and joins its lines.
fn name_of(name: &str) -> String {
    let mut name = error::one_line(name);
    if let Some((end, _)) = name.char_indices().nth(NAME) {
        name.truncate(end);
        name.push('…');
    }
    name
}

fn vector(all: &Value) -> String {
    let numbers = all.as_array().into_iter().flatten();
    let numbers: Vec<String> = numbers.map(|x| short(x.as_f64().unwrap_or(0.0), 6)).collect();
    format!("({})", numbers.join(", "))
}

/// Formats a number with `digits` significant digits, without trailing zeros.
fn short(x: f64, digits: usize) -> String {
    let rounded: f64 = format!("{x:.*e}", digits - 1).parse().unwrap_or(x);
    let plain = rounded == 0.0 || (1e-4..1e9).contains(&rounded.abs());
    if plain { format!("{}", rounded + 0.0) } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, text) in
            [(0.7_f32 as f64, "0.7"), (-0.0, "0"), (54_351.413_5, "54351.4"), (1e-9, "1e-9"), (2e12, "2e12")]
        {
            assert_eq!(short(x, 6), text);
        }
    }

    #[test]
    fn long_lists_and_names_end() {
        let facts = serde_json::json!({ "materials": vec!["x".repeat(1000); 1000] });
        let line = list(&facts, "materials", plain);
        assert!(line.ends_with("…, and 950 more (--json lists all)") && line.len() < 10_000, "{line}");
    }
}
