//! Units of the intensities of punctual lights.
//!
//! KHR_lights_punctual specifies candela and lux. A renderer without wavelengths needs W/sr and W/m², and interprets
//! the numbers as these. Exporters that convert from watts multiply by the luminous efficacy of green light, 683 lm/W;
//! without a correction their lights are 683 times as bright as in the exporting program. Exporters that are known to
//! do so are in [`PHOTOMETRIC`].
use std::{fmt, str::FromStr};

/// Luminous efficacy of monochromatic light of 540 THz, in lm/W: the constant that defines the candela.
pub const LUMENS_PER_WATT: f32 = 683.0;

/// Generators that write photometric intensities: the part of `asset.generator` before the version, and the first
/// version that does.
///
/// Blender's exporter has done so by default (lighting mode *Standard*) since 3.4.39: point and spot lights as
/// W · 683 / 4π, suns as W/m² · 683 [Khronos 2022]. The file does not record which of its three modes was used.
pub const PHOTOMETRIC: [(&str, [u32; 3]); 1] = [("Khronos glTF Blender I/O v", [3, 4, 39])];

/// Interpretation of the intensities of a file's point, spot and directional lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightUnit {
    /// Photometric if the generator is known to write photometric intensities, else radiometric.
    #[default]
    Auto,
    /// Unchanged: 1 cd is 1 W/sr, 1 lx is 1 W/m².
    Radiometric,
    /// Divided by 683 lm/W.
    Photometric,
}

impl LightUnit {
    const NAMES: [(Self, &str); 3] =
        [(Self::Auto, "auto"), (Self::Radiometric, "radiometric"), (Self::Photometric, "photometric")];
}

impl FromStr for LightUnit {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(_, name)| *name == s).map(|(unit, _)| *unit);
        found.ok_or_else(|| "expected auto, radiometric or photometric".into())
    }
}

impl fmt::Display for LightUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES.iter().find(|(unit, _)| unit == self).map_or("", |(_, name)| name))
    }
}

/// The unit in use, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TakenUnit {
    /// Whether intensities are divided by [`LUMENS_PER_WATT`].
    pub is_photometric: bool,
    /// The reason, as a clause.
    pub why: String,
}

impl TakenUnit {
    /// The unit for a file written by `generator`, given the option `asked`.
    pub fn new(asked: LightUnit, generator: Option<&str>) -> Self {
        let known = generator.is_some_and(is_photometric);
        let named = generator.map(|g| format!("the generator '{}'", crate::error::quoted(g)));
        let why = match (asked, named) {
            (LightUnit::Radiometric | LightUnit::Photometric, _) => format!("as --light-unit {asked} says"),
            (LightUnit::Auto, Some(named)) if known => {
                format!("{named} writes 683 lm per watt by default")
            }
            (LightUnit::Auto, Some(named)) => format!("{named} is not known to write lumens"),
            (LightUnit::Auto, None) => "the file names no generator".into(),
        };
        let is_photometric = asked == LightUnit::Photometric || (asked == LightUnit::Auto && known);
        Self { is_photometric, why }
    }

    /// The unit, never [`LightUnit::Auto`].
    pub fn unit(&self) -> LightUnit {
        if self.is_photometric { LightUnit::Photometric } else { LightUnit::Radiometric }
    }
}

/// Whether the table contains the generator with the same version or an earlier one.
fn is_photometric(generator: &str) -> bool {
    let since = |(name, first): &(&str, [u32; 3])| {
        generator.strip_prefix(name).and_then(version).is_some_and(|version| version >= *first)
    };
    PHOTOMETRIC.iter().any(since)
}

/// Parses a version such as `4.2.60`, ignoring trailing text; missing numbers are 0.
fn version(text: &str) -> Option<[u32; 3]> {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let mut version = [0; 3];
    let numbers = text[..end].split('.').filter(|part| !part.is_empty()).collect::<Vec<_>>();
    for (slot, part) in version.iter_mut().zip(&numbers) {
        *slot = part.parse().ok()?;
    }
    (!numbers.is_empty()).then_some(version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_knows_generators_by_name_and_version() {
        let photometric = |generator: &str| TakenUnit::new(LightUnit::Auto, Some(generator)).is_photometric;
        let blender = |version: &str| photometric(&format!("Khronos glTF Blender I/O v{version}"));
        for version in ["3.4.39", "3.4.50", "3.5", "3.6.11", "4.0.44", "5.1.20", "10.0.0", "4.2.60-beta"] {
            assert!(blender(version), "{version}");
        }
        for version in ["1.2.75", "3.3.32", "3.4.38", "3.4", "3", "", ".", "x", "99999999999.1.1"] {
            assert!(!blender(version), "{version}");
        }
        for other in ["", "THREE.GLTFExporter", "Khronos Blender glTF 2.0 exporter", "glTF-Transform v4.0.0"]
        {
            assert!(!photometric(other), "{other}");
        }
    }

    #[test]
    fn what_is_said_wins_and_the_reason_is_told() {
        let blender = Some("Khronos glTF Blender I/O v4.2.0");
        let of = |asked: LightUnit, generator| TakenUnit::new(asked, generator);
        assert_eq!(of(LightUnit::Radiometric, blender).unit(), LightUnit::Radiometric);
        assert_eq!(of(LightUnit::Photometric, None).unit(), LightUnit::Photometric);
        assert!(of(LightUnit::Photometric, None).why.contains("--light-unit photometric"));
        assert!(of(LightUnit::Auto, blender).why.contains("I/O v4.2.0' writes 683 lm"));
        assert!(of(LightUnit::Auto, Some("x")).why.contains("'x' is not known"));
        assert!(of(LightUnit::Auto, None).why.contains("no generator"));
    }

    #[test]
    fn names_round_trip() {
        for (unit, name) in LightUnit::NAMES {
            assert_eq!((name.parse(), unit.to_string()), (Ok(unit), name.to_string()));
        }
        assert!("lumens".parse::<LightUnit>().is_err() && "".parse::<LightUnit>().is_err());
    }
}
