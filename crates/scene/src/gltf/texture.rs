//! Decoding of images and textures, once all materials are known. An image that is used both as colour and as data
//! gives two textures; of each only the channels that some material reads are kept.
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

/// Textures that materials reference, by their index in the builder.
#[derive(Default)]
pub(super) struct Textures {
    wanted: Vec<Wanted>,
    /// Index of each key in `wanted`.
    known: HashMap<(usize, [u8; 4]), u32>,
    /// The first image of each file or buffer view; further images of the same source have the same pixels.
    sources: HashMap<Source, usize>,
}

/// Location of the encoded bytes of an image.
#[derive(PartialEq, Eq, Hash)]
enum Source {
    File(String),
    View(usize),
}

impl Source {
    /// The source of an image; None for data URIs, and if neither a URI nor a buffer view is given.
    fn of(image: &json::Image) -> Option<Self> {
        match (file_name(image), image.buffer_view) {
            (Some(uri), _) => Some(Self::File(uri.into())),
            (None, view) => view.map(|view| Self::View(view.value())),
        }
    }
}

struct Wanted {
    key: Key,
    /// Name in messages.
    name: String,
}

#[derive(Clone, Copy)]
struct Key {
    image: usize,
    encoding: Encoding,
    sampler: Sampler,
}

impl Key {
    /// A hashable value that is unique to the key.
    fn hashed(&self) -> (usize, [u8; 4]) {
        let Sampler { wrap_s, wrap_t, interpolation } = self.sampler;
        (self.image, [self.encoding as u8, wrap_s as u8, wrap_t as u8, interpolation as u8])
    }
}

/// Reference of a material to a texture: index, set of texture coordinates, transform.
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
    /// Number of images that are decoded.
    pub fn images(&self) -> usize {
        let mut all: Vec<usize> = self.wanted.iter().map(|wanted| wanted.key.image).collect();
        all.sort_unstable();
        all.dedup();
        all.len()
    }

    /// Decodes the textures and adds them to the builder.
    pub fn decode(&self, doc: &Document<'_>, builder: &mut SceneBuilder) -> Result<(), SceneError> {
        let reads = &doc.options.reads;
        self.check(doc)?;
        let channels = channels::looked_at(builder.materials(), self.wanted.len(), reads);
        for (Wanted { key, name }, channels) in self.wanted.iter().zip(channels) {
            let decode = || pixels(doc, key.image, name);
            let texels = match &doc.options.images {
                Some(images) => images.get(key.image, decode)?,
                None => decode()?,
            };
            let texture = Texture::new(texels, key.encoding, key.sampler);
            builder.texture(if reads.everything { texture } else { texture.keep(channels) });
        }
        Ok(())
    }

    /// Checks, from the headers of the images, whether all textures fit into memory before any is decoded.
    fn check(&self, doc: &Document<'_>) -> Result<(), SceneError> {
        let mut bytes = 0_u64;
        for Wanted { key, name } in &self.wanted {
            // Image files are not read twice: their size is checked when they are decoded.
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

    /// The texture that a material references; None, with a warning, if it cannot be used.
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
                "{place} uses TEXCOORD_{set}: only sets 0 and 1 are supported, the texture is left out"
            ));
            return Ok(None);
        }
        let texture = doc.get(&doc.root.textures, pointer.texture, "texture", place)?;
        let name = label("texture", pointer.texture.value(), texture.name.as_deref());
        let Some(image) = image_of(texture) else {
            doc.warn(format!("{name} is left out: it has no PNG, JPEG or WebP image"));
            return Ok(None);
        };
        let file = doc.get(&doc.root.images, image, "image", &name)?.uri.as_deref();
        if let Some(uri) = file.filter(|uri| !doc.options.strict && source::is_missing(&doc.file, uri)) {
            let uri = quoted(uri);
            doc.warn(format!("{name} is left out: there is no file '{uri}' (--strict makes this an error)"));
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

/// The image of a texture: that of EXT_texture_webp, or else the ordinary one.
fn image_of(texture: &json::Texture) -> Option<Index<json::Image>> {
    let webp = texture.extensions.as_ref().and_then(|e| e.others.get("EXT_texture_webp"));
    let webp = webp.and_then(|w| w.get("source")).and_then(serde_json::Value::as_u64);
    match webp.and_then(|i| u32::try_from(i).ok()) {
        Some(index) => Some(Index::new(index)),
        // This value marks a texture without source in the crate `gltf`.
        None => Some(texture.source).filter(|s| s.value() != u32::MAX as usize),
    }
}

/// The encoded bytes of an image, and its name in messages.
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

/// Width and height of an image. An image whose size is small relative to its bytes is also decoded, to detect errors.
pub(super) fn size(doc: &Document<'_>, index: usize, place: &str) -> Result<[usize; 2], SceneError> {
    const SMALL: u64 = 1 << 22;
    let image = |source| SceneError::Image { file: doc.file.clone(), source };
    let (bytes, place) = encoded(doc, index, place)?;
    let [width, height] = read::size(&bytes, &place).map_err(image)?;
    let texels = width.saturating_mul(height);
    if texels < SMALL.max(32 * bytes.len() as u64) {
        let pixels = texels_within(&bytes, &place, doc.options.memory).map_err(image)?;
        warn_if_truncated(doc, (&bytes, &pixels), &place, doc.options.memory);
    }
    Ok([width as usize, height as usize])
}

/// Warns if a JPEG of which `bytes` are the data and `pixels` the texels is incomplete.
fn warn_if_truncated(doc: &Document<'_>, (bytes, pixels): (&[u8], &Texels), place: &str, limit: MemoryLimit) {
    let rest = match read::gap(bytes, pixels, place, limit) {
        None => return,
        Some(read::Gap::Grey) => "the rest is grey",
        Some(read::Gap::Coarse) => "the rest lacks detail",
    };
    doc.warn(format!("{place} is truncated: the JPEG data end early, and {rest}; export the image again"));
}

/// The decoded pixels of an image.
pub(super) fn pixels(doc: &Document<'_>, index: usize, place: &str) -> Result<Texels, SceneError> {
    let (bytes, place) = encoded(doc, index, place)?;
    let pixels = texels_within(&bytes, &place, doc.left())
        .map_err(|source| SceneError::Image { file: doc.file.clone(), source })?;
    // Once more if the decoded image is kept.
    let times = if doc.options.images.is_some() { 2 } else { 1 };
    doc.keep(times * pixels.bytes() as u64, &place)?;
    warn_if_truncated(doc, (&bytes, &pixels), &place, doc.left());
    Ok(pixels)
}

fn file_name(image: &json::Image) -> Option<&str> {
    image.uri.as_deref().filter(|uri| !uri.starts_with("data:"))
}

/// Converts a sampler. *Approximation*: minification filters are ignored; averaging over the pixel's samples replaces
/// mipmaps.
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

/// The matrix of KHR_texture_transform: translation · rotation · scale. Positive angles rotate uv counter-clockwise as
/// seen in the image, where v points down: u' = u cos + v sin, v' = v cos − u sin. (The GLSL code in the extension's
/// text rotates the other way; its prose, its test model and other viewers agree with this, see
/// KhronosGroup/glTF#1563.)
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
        // The end of the u axis moves up, towards −v.
        let p = t.matrix2 * Vec2::new(0.5, 0.0) + t.translation;
        assert!((p - Vec2::new(0.25, -0.5)).length() < 1e-6, "{p}");
    }
}
