//! Conversion of glTF materials and their supported extensions.
use super::{
    document::{Document, label},
    texture::{Pointer, Textures},
};
use crate::slots::{Name, SLOTS};
use crate::{AlphaMode, SceneBuilder, SceneError, TexturedMaterial};
use dapple_materials::{Material, Mirror};
use glam::{DVec3, Vec3};
use gltf::json::{
    self, Index, extensions::material as extension, extensions::texture::TextureTransform,
    validation::Checked,
};
use serde_json::Value;

/// Finite substitute for an infinite index of refraction, which KHR_materials_ior encodes as 0: reflects 99.96 %.
const MIRROR_LIKE: f32 = 1e4;
/// Lower bound of attenuation colours. *Approximation*: the absorption of black would be infinite; this value is black
/// within f32 precision.
const DARKEST: f64 = 1e-30;

/// Materials converted so far.
#[derive(Default)]
pub(super) struct Materials {
    textures: Textures,
    made: Vec<Option<u32>>,
    default: Option<u32>,
}

impl Materials {
    /// Number of the file's materials that were converted.
    pub fn count(&self) -> usize {
        self.made.iter().flatten().count()
    }

    /// Number of images that are decoded.
    pub fn images(&self) -> usize {
        self.textures.images()
    }

    /// Decodes the images that the materials reference.
    pub fn decode(&self, doc: &Document<'_>, builder: &mut SceneBuilder) -> Result<(), SceneError> {
        self.textures.decode(doc, builder)
    }

    /// The index in the builder of a glTF material; None is glTF's default material.
    pub fn resolve(
        &mut self,
        doc: &Document<'_>,
        builder: &mut SceneBuilder,
        index: Option<Index<json::Material>>,
        place: &str,
    ) -> Result<u32, SceneError> {
        let Some(index) = index else {
            return Ok(*self.default.get_or_insert_with(|| {
                builder.material(TexturedMaterial { name: "default".into(), ..Default::default() })
            }));
        };
        let material = doc.get(&doc.root.materials, index, "material", place)?;
        self.made.resize(doc.root.materials.len(), None);
        if let Some(made) = self.made[index.value()] {
            return Ok(made);
        }
        let place = label("material", index.value(), material.name.as_deref());
        let mut reader = Reader { doc, textures: &mut self.textures, place: &place };
        let mut converted = core(material);
        if let Some(extensions) = &material.extensions {
            reader.extensions(extensions, &mut converted);
        }
        reader.textures(material, &mut converted)?;
        if let Some(dapple) = doc.dapple(&material.extras, &place)? {
            converted.base.mirror = mirror(&dapple).map_err(|what| doc.invalid(&*place, what))?;
        }
        converted.priority = priority(doc, &material.extras, &place)?;
        converted.name = match &material.name {
            Some(name) if !name.is_empty() => name.clone(),
            _ => place.clone(),
        };
        if let Some(factor) = converted.bad_factor() {
            return Err(doc.invalid(place, format!("{factor} must be finite and not negative")));
        }
        let made = builder.material(converted);
        self.made[index.value()] = Some(made);
        Ok(made)
    }
}

struct Reader<'a, 'o> {
    doc: &'a Document<'o>,
    textures: &'a mut Textures,
    place: &'a str,
}

impl Reader<'_, '_> {
    /// Resolves the textures that affect the result, given the factors of `out`.
    fn textures(&mut self, m: &json::Material, out: &mut TexturedMaterial) -> Result<(), SceneError> {
        let reads = self.doc.options.reads;
        let transform = normal_transform(m);
        for slot in &SLOTS {
            if (reads.everything || (slot.shows)(out, &reads))
                && let Some(pointer) = pointer(m, slot.name, transform.as_ref())
            {
                let of = self.textures.resolve(self.doc, &pointer, slot.encoding, self.place)?;
                *(slot.of_mut)(out) = of;
            }
        }
        // Without the missing texture the factor would make the whole surface emit.
        if reads.light && m.emissive_texture.is_some() && out.emissive_texture.is_none() {
            out.emission *= 0.0;
        }
        Ok(())
    }

    fn extensions(&self, e: &extension::Material, out: &mut TexturedMaterial) {
        if let Some(strength) = &e.emissive_strength {
            out.emission *= strength.emissive_strength.0;
        }
        if let Some(ior) = &e.ior {
            out.base.ior = self.ior(ior.ior.0);
        }
        if let Some(specular) = &e.specular {
            out.base.specular = unit(specular.specular_factor.0);
            out.base.specular_color = Vec3::from_array(specular.specular_color_factor.0);
        }
        if let Some(transmission) = &e.transmission {
            out.base.transmission = unit(transmission.transmission_factor.0);
        }
        if let Some(volume) = e.volume.as_ref().filter(|v| v.thickness_factor.0 > 0.0) {
            // The geometry defines the thickness; the factor only distinguishes a volume from a thin wall.
            out.base.thin = false;
            let color = Vec3::from_array(volume.attenuation_color.0);
            out.sigma_a = absorption(color, volume.attenuation_distance.0);
        }
        out.unlit = e.unlit.is_some();
    }

    fn ior(&self, ior: f32) -> f32 {
        if ior == 0.0 {
            MIRROR_LIKE
        } else if ior < 1.0 {
            self.doc.warn(format!("{}: ior {ior} is below 1; 1 is used", self.place));
            1.0
        } else {
            ior
        }
    }
}

/// The material of the core specification, without textures.
fn core(m: &json::Material) -> TexturedMaterial {
    let pbr = &m.pbr_metallic_roughness;
    let [r, g, b, alpha] = pbr.base_color_factor.0.map(unit);
    TexturedMaterial {
        base: Material {
            base_color: Vec3::new(r, g, b),
            metallic: unit(pbr.metallic_factor.0),
            roughness: unit(pbr.roughness_factor.0),
            ..Material::default()
        },
        alpha,
        alpha_mode: alpha_mode(m),
        emission: Vec3::from_array(m.emissive_factor.0),
        double_sided: m.double_sided,
        normal_scale: m.normal_texture.as_ref().map_or(1.0, |n| n.scale),
        ..TexturedMaterial::default()
    }
}

/// The texture reference of a material for one of its slots.
fn pointer<'a>(
    m: &'a json::Material,
    name: Name,
    normal_transform: Option<&'a TextureTransform>,
) -> Option<Pointer<'a>> {
    let (pbr, extensions) = (&m.pbr_metallic_roughness, m.extensions.as_ref());
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let info = match name {
        Name::BaseColor => pbr.base_color_texture.as_ref(),
        Name::MetallicRoughness => pbr.metallic_roughness_texture.as_ref(),
        Name::Emission => m.emissive_texture.as_ref(),
        Name::Specular => specular.and_then(|s| s.specular_texture.as_ref()),
        Name::SpecularColor => specular.and_then(|s| s.specular_color_texture.as_ref()),
        Name::Transmission => extensions?.transmission.as_ref()?.transmission_texture.as_ref(),
        Name::Normal => {
            let n = m.normal_texture.as_ref()?;
            return Some(Pointer { texture: n.index, set: n.tex_coord, transform: normal_transform });
        }
    };
    info.map(Pointer::from)
}

/// The transform of a normal map, which the crate `gltf` provides as plain JSON.
fn normal_transform(m: &json::Material) -> Option<TextureTransform> {
    let extensions = m.normal_texture.as_ref()?.extensions.as_ref()?;
    serde_json::from_value(extensions.others.get("KHR_texture_transform")?.clone()).ok()
}

/// Absorption coefficient σ_a = −ln(colour) / distance: white light has the colour after the distance
/// (KHR_materials_volume).
fn absorption(color: Vec3, distance: f32) -> Vec3 {
    let per = |c: f64| -libm::log(c.clamp(DARKEST, 1.0)) / f64::from(distance);
    let color = color.as_dvec3();
    DVec3::new(per(color.x), per(color.y), per(color.z)).as_vec3()
}

fn alpha_mode(m: &json::Material) -> AlphaMode {
    match m.alpha_mode {
        Checked::Valid(json::material::AlphaMode::Mask) => {
            AlphaMode::Mask { cutoff: m.alpha_cutoff.unwrap_or_default().0 }
        }
        Checked::Valid(json::material::AlphaMode::Blend) => AlphaMode::Blend,
        _ => AlphaMode::Opaque,
    }
}

/// The mirror of `extras: {"dapple": {"mirror": {"kr": [r, g, b], "blur": l}}}`: a square-blur mirror of reflectance kr
/// and blur size l (default 0).
fn mirror(dapple: &Value) -> Result<Option<Mirror>, &'static str> {
    let Some(mirror) = dapple.get("mirror") else { return Ok(None) };
    let number = |v: &Value| v.as_f64().map(|v| v as f32);
    let kr: Option<Vec<f32>> =
        mirror.get("kr").and_then(Value::as_array).map(|a| a.iter().filter_map(number).collect());
    let blur = mirror.get("blur").map_or(Some(0.0), number);
    match (kr.as_deref(), blur) {
        (Some(&[r, g, b]), Some(blur)) => Ok(Some(Mirror { kr: Vec3::new(r, g, b), blur })),
        _ => Err("extras.dapple.mirror needs \"kr\": [r, g, b] and a number \"blur\""),
    }
}

/// The priority of `extras: {"dapple": {"priority": n}}`, or `extras: {"priority": n}` (default 0): where volumes
/// overlap, the one with the highest priority fills the overlap.
fn priority(doc: &Document<'_>, extras: &json::Extras, place: &str) -> Result<f64, SceneError> {
    let finite = |v: &Value| v.as_f64().filter(|v| v.is_finite());
    if let Some(own) = doc.dapple(extras, place)?.as_ref().and_then(|dapple| dapple.get("priority")) {
        return finite(own)
            .ok_or_else(|| doc.invalid(place, "extras.dapple.priority must be a finite number"));
    }
    let plain = extras.as_ref().and_then(|e| serde_json::from_str::<Value>(e.get()).ok());
    let Some(plain) = plain.as_ref().and_then(|e| e.get("priority")) else { return Ok(0.0) };
    Ok(finite(plain).unwrap_or_else(|| {
        doc.warn(format!("{place}: extras.priority is not a finite number and is ignored"));
        0.0
    }))
}

/// Clamps a factor to [0, 1], the range that glTF allows.
fn unit(v: f32) -> f32 {
    v.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absorption_gives_the_colour_back() {
        let sigma = absorption(Vec3::new(0.5, 1.0, 0.0), 2.0);
        assert!((libm::expf(-sigma.x * 2.0) - 0.5).abs() < 1e-6);
        assert_eq!(sigma.y, 0.0);
        assert!(sigma.z.is_finite() && libm::expf(-sigma.z * 2.0) < 1e-20);
        assert_eq!(absorption(Vec3::splat(0.5), f32::INFINITY), Vec3::ZERO);
    }

    #[test]
    fn mirrors() {
        let read = |json: &str| mirror(&serde_json::from_str(json).unwrap());
        let got = read(r#"{"mirror": {"kr": [1, 0.5, 0.25], "blur": 0.1}}"#).unwrap().unwrap();
        assert_eq!((got.kr, got.blur), (Vec3::new(1.0, 0.5, 0.25), 0.1));
        assert_eq!(read(r#"{"mirror": {"kr": [1, 1, 1]}}"#).unwrap().unwrap().blur, 0.0);
        assert!(read("{}").unwrap().is_none());
        assert!(read(r#"{"mirror": {"kr": [1, 1]}}"#).is_err());
        assert!(read(r#"{"mirror": {"kr": [1, 1, 1], "blur": "x"}}"#).is_err());
    }
}
