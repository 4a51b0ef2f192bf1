//! Images and textures, decoded once all materials are known: once as colour, once as data if it is both, and of each
//! only the channels that some material looks at.
use super::{
    document::{Document, label},
    source,
};
use crate::{SceneBuilder, SceneError, TextureUse, channels, error::quoted};
use dapple_imaging::{
    Interpolation, MemoryLimit, Sampler, Texture, Wrap,
    read::{self, Texels, texels_within},
    texture::Encoding,
};
use glam::{Affine2, Mat2, Vec2};
use gltf::json::{self, Index, texture::MagFilter, texture::WrappingMode, validation::Checked};
use std::{borrow::Cow, collections::HashMap};

/// Textures that materials point to, by their index in the builder.
#[derive(Default)]
pub(super) struct Textures {
    wanted: Vec<Wanted>,
    /// Where each key is among them.
    known: HashMap<(usize, [u8; 4]), u32>,
    /// The first image of each file or buffer view: the others are the same pixels.
    sources: HashMap<Source, usize>,
}

/// Where the encoded bytes of an image are.
#[derive(PartialEq, Eq, Hash)]
enum Source {
    File(String),
    View(usize),
}

impl Source {
    /// None for data within the JSON, and where nothing is said.
    fn of(image: &json::Image) -> Option<Self> {
        match (file_name(image), image.buffer_view) {
            (Some(uri), _) => Some(Self::File(uri.into())),
            (None, view) => view.map(|view| Self::View(view.value())),
        }
    }
}

struct Wanted {
    key: Key,
    /// For messages.
    name: String,
}

#[derive(Clone, Copy)]
struct Key {
    image: usize,
    encoding: Encoding,
    sampler: Sampler,
}

impl Key {
    /// The same for equal keys alone.
    fn hashed(&self) -> (usize, [u8; 4]) {
        let Sampler { wrap_s, wrap_t, interpolation } = self.sampler;
        (self.image, [self.encoding as u8, wrap_s as u8, wrap_t as u8, interpolation as u8])
    }
}

/// Where a material points: texture, set of coordinates, transform.
pub(super) struct Pointer<'a> {
    pub texture: Index<json::Texture>,
    pub set: u32,
    pub transform: Option<&'a json::extensions::texture::TextureTransform>,
}

impl<'a> From<&'a json::texture::Info> for Pointer<'a> {
    fn from(info: &'a json::texture::Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        Self { texture: info.index, set: info.tex_coord, transform }
    }
}

impl Textures {
    /// How many images are decoded.
    pub fn images(&self) -> usize {
        let mut all: Vec<usize> = self.wanted.iter().map(|wanted| wanted.key.image).collect();
        all.sort_unstable();
        all.dedup();
        all.len()
    }

    /// Moves the textures into the builder.
    pub fn decode(&self, doc: &Document<'_>, builder: &mut SceneBuilder) -> Result<(), SceneError> {
        let reads = &doc.options.reads;
        self.check(doc)?;
        let channels = channels::looked_at(builder.materials(), self.wanted.len(), reads);
        for (Wanted { key, name }, channels) in self.wanted.iter().zip(channels) {
            let texture = Texture::new(pixels(doc, key.image, name)?, key.encoding, key.sampler);
            builder.texture(if reads.everything { texture } else { texture.keep(channels) });
        }
        Ok(())
    }

    /// Whether all of them can be kept, as far as their headers say: the first need not be decoded if the last is too much.
    fn check(&self, doc: &Document<'_>) -> Result<(), SceneError> {
        let mut bytes = 0_u64;
        for Wanted { key, name } in &self.wanted {
            // What lies in files of its own is as large as it is, and not read twice.
            let image = &doc.root.images[key.image];
            if file_name(image).is_none()
                && let Ok((encoded, place)) = encoded(doc, key.image, name)
                && let Ok([width, height]) = read::size(&encoded, &place)
            {
                bytes = bytes.saturating_add(width.saturating_mul(height).saturating_mul(4));
                doc.would_keep(bytes, &place)?;
            }
        }
        Ok(())
    }

    /// The texture a material points to. None, with a warning, for what cannot be shown.
    pub fn resolve(
        &mut self,
        doc: &Document<'_>,
        pointer: &Pointer<'_>,
        encoding: Encoding,
        place: &str,
    ) -> Result<Option<TextureUse>, SceneError> {
        let set = pointer.transform.and_then(|t| t.tex_coord).unwrap_or(pointer.set);
        if set > 1 {
            doc.warn(format!(
                "{place} uses TEXCOORD_{set}: only sets 0 and 1 are read, the texture is left out"
            ));
            return Ok(None);
        }
        let texture = doc.get(&doc.root.textures, pointer.texture, "texture", place)?;
        let name = label("texture", pointer.texture.value(), texture.name.as_deref());
        let Some(image) = image_of(texture) else {
            doc.warn(format!("{name} has no image that can be read and is left out"));
            return Ok(None);
        };
        let file = doc.get(&doc.root.images, image, "image", &name)?.uri.as_deref();
        if let Some(uri) = file.filter(|uri| !doc.options.strict && source::is_missing(&doc.file, uri)) {
            let uri = quoted(uri);
            doc.warn(format!("{name}: there is no file '{uri}': the texture is left out (--strict refuses)"));
            return Ok(None);
        }
        let sampler = match texture.sampler {
            Some(index) => sampler(doc.get(&doc.root.samplers, index, "sampler", &name)?),
            None => Sampler::default(),
        };
        let source = Source::of(&doc.root.images[image.value()]);
        let image = source.map_or(image.value(), |s| *self.sources.entry(s).or_insert(image.value()));
        let key = Key { image, encoding, sampler };
        let index = *self.known.entry(key.hashed()).or_insert_with(|| {
            self.wanted.push(Wanted { key, name });
            self.wanted.len() as u32 - 1
        });
        let transform = pointer.transform.map(affine).filter(|t| *t != Affine2::IDENTITY);
        if transform.is_some_and(|t| !t.is_finite()) {
            return Err(doc.invalid(place, "has a texture transform that is not finite"));
        }
        Ok(Some(TextureUse { texture: index, uv_set: set, transform }))
    }
}

/// The image of a texture: EXT_texture_webp's before the ordinary one.
fn image_of(texture: &json::Texture) -> Option<Index<json::Image>> {
    let webp = texture.extensions.as_ref().and_then(|e| e.others.get("EXT_texture_webp"));
    let webp = webp.and_then(|w| w.get("source")).and_then(serde_json::Value::as_u64);
    match webp.and_then(|i| u32::try_from(i).ok()) {
        Some(index) => Some(Index::new(index)),
        // The crate `gltf` marks a texture without source so.
        None => Some(texture.source).filter(|s| s.value() != u32::MAX as usize),
    }
}

/// The bytes of an image as it is encoded, and how to call it.
fn encoded<'a>(
    doc: &'a Document<'_>,
    index: usize,
    place: &str,
) -> Result<(Cow<'a, [u8]>, String), SceneError> {
    let image = doc.get(&doc.root.images, Index::new(index as u32), "image", place)?;
    let place = label("image", index, image.name.as_deref().or(file_name(image)));
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => doc.outside(uri, source::MAX_FILE, &place)?.into(),
        (None, Some(view)) => doc.view(view, &place)?.into(),
        (None, None) => return Err(doc.invalid(place, "has neither a URI nor a buffer view")),
    };
    Ok((bytes, place))
}

/// An image's width and height. One that is small for what it holds is decoded too, so that faults are found.
pub(super) fn size(doc: &Document<'_>, index: usize, place: &str) -> Result<[usize; 2], SceneError> {
    const SMALL: u64 = 1 << 22;
    let image = |source| SceneError::Image { file: doc.file.clone(), source };
    let (bytes, place) = encoded(doc, index, place)?;
    let [width, height] = read::size(&bytes, &place).map_err(image)?;
    let texels = width.saturating_mul(height);
    if texels < SMALL.max(32 * bytes.len() as u64) {
        texels_within(&bytes, &place, doc.options.memory).map_err(image)?;
    }
    say_cut_short(doc, &bytes, &place, doc.options.memory);
    Ok([width as usize, height as usize])
}

fn say_cut_short(doc: &Document<'_>, bytes: &[u8], place: &str, limit: MemoryLimit) {
    let rest = match read::gap(bytes, place, limit) {
        None => return,
        Some(read::Gap::Grey) => "the rest is grey",
        Some(read::Gap::Coarse) => "the rest lacks detail",
    };
    doc.warn(format!("{place} is cut short: the JPEG data end before the picture does, and {rest}"));
}

/// An image's pixels.
pub(super) fn pixels(doc: &Document<'_>, index: usize, place: &str) -> Result<Texels, SceneError> {
    let (bytes, place) = encoded(doc, index, place)?;
    say_cut_short(doc, &bytes, &place, doc.left());
    let pixels = texels_within(&bytes, &place, doc.left())
        .map_err(|source| SceneError::Image { file: doc.file.clone(), source })?;
    doc.keep(pixels.bytes() as u64, &place)?;
    Ok(pixels)
}

fn file_name(image: &json::Image) -> Option<&str> {
    image.uri.as_deref().filter(|uri| !uri.starts_with("data:"))
}

/// *Approximation*: minification filters are not looked at; samples over the pixel average what mipmaps would.
fn sampler(s: &json::texture::Sampler) -> Sampler {
    let wrap = |w: Checked<WrappingMode>| match w {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let interpolation = match s.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => Interpolation::Nearest,
        _ => Interpolation::Linear,
    };
    Sampler { wrap_s: wrap(s.wrap_s), wrap_t: wrap(s.wrap_t), interpolation }
}

/// KHR_texture_transform: translation · rotation · scale. Positive angles turn uv counter-clockwise as seen in the
/// image, where v points down: u' = u cos + v sin, v' = v cos − u sin. (The GLSL lines of the extension's text turn
/// the other way; its words, its test model and the viewers do this, see KhronosGroup/glTF#1563.)
fn affine(t: &json::extensions::texture::TextureTransform) -> Affine2 {
    let angle = f64::from(t.rotation.0);
    let (sin, cos) = (libm::sin(angle) as f32, libm::cos(angle) as f32);
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let scale = Mat2::from_diagonal(Vec2::from_array(t.scale.0));
    Affine2 { matrix2: rotation * scale, translation: Vec2::from_array(t.offset.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_is_counter_clockwise_where_v_points_down() {
        let json = serde_json::json!({"rotation": std::f32::consts::FRAC_PI_2, "offset": [0.25, 0.5], "scale": [2.0, 1.0]});
        let t = affine(&serde_json::from_value(json).unwrap());
        // The end of the u axis goes up, that is to −v.
        let p = t.matrix2 * Vec2::new(0.5, 0.0) + t.translation;
        assert!((p - Vec2::new(0.25, -0.5)).length() < 1e-6, "{p}");
    }
}
