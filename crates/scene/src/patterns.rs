//! Emission of textured triangles: mean, centroid, and sampling patterns.
//!
//! The mean over a triangle is exact to the texel: the triangle is subdivided by the grid of the finer of its textures,
//! and every piece contributes its area times the value at its centroid. If a scene has more than [`MOST_PIECES`]
//! pieces, or a texture is repeated that often, the remaining means are taken over low-discrepancy points
//! (*approximation*: such a light is selected more or less often than in proportion to its power; its radiance is exact
//! in any case). Triangles whose emission varies are then sampled by a pattern ([`Pattern`]) built from bounds of the
//! textures; all patterns share [`MOST_PARTS`] in proportion to power.
use crate::emitter::Emitter;
use crate::extremes::{Extremes, Value, in_texels};
use crate::{AlphaMode, TextureUse, TexturedMaterial, pieces};
use dapple_geometry::{Accel, Hit};
use dapple_imaging::{Texture, texture::Interpolation};
use dapple_lights::pattern::{Emitted, Part, Pattern, Patterned, WORTH};
use dapple_lights::{Light, Moving};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Limit of the pieces of triangles in a scene: 1.25 textures of 4096² texels.
const MOST_PIECES: f64 = 1.25 * (1u64 << 24) as f64;

/// Total number of triangle parts in the patterns of a scene, and minimum and maximum per triangle.
const MOST_PARTS: usize = 1 << 17;
const LEAST_OF_ONE: usize = 64;
const MOST_OF_ONE: usize = 1 << 16;

/// Number of points on a triangle with too many pieces, and approximate total over all such triangles.
const POINTS: f64 = 4096.0;
const ALL_POINTS: f64 = 4e6;

/// Size of a part, in texels, at or below which it is not divided.
const FINE: f64 = 0.125;
/// Size of a part, in texels, up to which its mean is estimated from four points.
const FEW_TEXELS: f64 = 16.0;

/// State for the textured emitters of a scene while its lights are created.
pub(crate) struct Patterns<'a> {
    accel: &'a Accel,
    textures: &'a [Texture],
    materials: &'a [TexturedMaterial],
    /// Bounds by material, created on demand.
    bounds: Vec<Option<Bounds<'a>>>,
    pieces_left: f64,
    /// Lights whose emission varies, with its centroid in barycentric coordinates.
    varying: Vec<(u32, Vec2)>,
}

/// Emission of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mean {
    /// Mean of radiance × opacity.
    pub radiance: Vec3,
    /// Barycentric coordinates of the centroid of the emission.
    pub middle: Vec2,
    /// Whether it varies enough for a pattern.
    pub varies: bool,
}

impl<'a> Patterns<'a> {
    pub fn new(accel: &'a Accel, textures: &'a [Texture], materials: &'a [TexturedMaterial]) -> Self {
        let bounds = materials.iter().map(|_| None).collect();
        Self { accel, textures, materials, bounds, pieces_left: MOST_PIECES, varying: Vec::new() }
    }

    pub fn emitter(&self, material: u32) -> Emitter<'a> {
        let material = &self.materials[material as usize];
        Emitter { accel: self.accel, textures: self.textures, material }
    }

    /// Emission of a triangle of an object with `count` triangles. It is not zero if the triangle emits anywhere.
    pub fn mean(&mut self, material: u32, (object, primitive): (u32, u32), count: usize) -> Mean {
        if self.triangle(material, (object, primitive)).emitted(&Part::WHOLE).high == 0.0 {
            return Mean { radiance: Vec3::ZERO, middle: Vec2::splat(1.0 / 3.0), varies: false };
        }
        let emitter = self.emitter(material);
        let at = |p: DVec2| Hit { t: 0.0, u: p.x as f32, v: p.y as f32, primitive, object };
        let mut sum = Sum::default();
        let cut = self.cut(&emitter, &at, &mut sum);
        if cut.is_none() {
            let n = (ALL_POINTS / count.max(1) as f64).clamp(4.0, POINTS) as u32;
            spread(n).for_each(|p| sum.add(p, 1.0, emitter.radiance(&at(p))));
        }
        let mean = sum.mean();
        if mean.radiance != Vec3::ZERO || cut == Some(true) {
            return mean;
        }
        // All points were black: decide from the bounds whether the triangle emits at all.
        let (_, left) = self.pattern(material, (object, primitive), 4096, Vec2::ZERO);
        let factor = emitter.material.emission;
        let share = left / scalar(factor);
        let radiance = (factor.as_dvec3() * share).as_vec3();
        let least = if left > 0.0 { f32::MIN_POSITIVE } else { 0.0 };
        Mean { radiance: radiance.max(Vec3::splat(least)), varies: true, ..mean }
    }

    /// Sums over the pieces of a triangle; None if the sum is not evaluated. The result tells whether a sum of 0 proves
    /// that nothing emits; it does not if alpha may vary within a piece.
    fn cut(&mut self, emitter: &Emitter<'_>, at: &dyn Fn(DVec2) -> Hit, sum: &mut Sum) -> Option<bool> {
        let layers = [emitter.material.emission_map(), emitter.material.opacity_map()];
        let uvs = |of: &TextureUse| corners().map(|p| self.accel.uv(&at(p), of.uv_set as usize));
        let grids = layers.into_iter().flatten().map(|of| {
            let texture = &self.textures[of.texture as usize];
            (of, texture, in_texels(of, texture, uvs(of)))
        });
        let finest = grids.max_by(|a, b| pieces::count(a.2).total_cmp(&pieces::count(b.2)));
        let (of, texture, grid) = finest?;
        let [a, e1, e2] = [grid[0], grid[1] - grid[0], grid[2] - grid[0]];
        let (det, count) = (e1.perp_dot(e2), pieces::count(grid));
        if det == 0.0 || !det.is_finite() || count > self.pieces_left {
            return None;
        }
        self.pieces_left -= count;
        // The cells of a linearly interpolated texture lie between texel centres.
        let linear = texture.sampler().interpolation == Interpolation::Linear;
        let shift = if linear { DVec2::splat(0.5) } else { DVec2::ZERO };
        let alone = emitter.material.alpha_mode == AlphaMode::Opaque
            && emitter.material.emission_map().is_some_and(|map| map == of);
        let (w, h) = texture.size();
        let per_texel = DVec2::new(1.0 / w as f64, 1.0 / h as f64);
        let factor = emitter.material.emission;
        pieces::visit(grid.map(|p| p - shift), |middle, area, is_whole| {
            let place = middle + shift;
            let q = place - a;
            let p = DVec2::new(q.perp_dot(e2), e1.perp_dot(q)) / det;
            let radiance = if is_whole && alone {
                factor * texture.lookup((place * per_texel).as_vec2()).truncate()
            } else {
                emitter.radiance(&at(clamped(p)))
            };
            sum.add(p, area, radiance);
        });
        let plain = !linear && layers.iter().flatten().count() == 1;
        let certain = plain || emitter.material.alpha_mode == AlphaMode::Opaque;
        (sum.weight > 0.0).then_some(certain)
    }

    /// Records a light whose emission varies.
    pub fn note(&mut self, light: u32, middle: Vec2) {
        self.varying.push((light, middle));
    }

    /// Assigns patterns to the lights that benefit from one. `sources` holds the object and primitive of each light;
    /// `material` returns the material of an object.
    pub fn refine(mut self, lights: &mut [Light], sources: &[(u32, u32)], material: impl Fn(u32) -> u32) {
        let power = |light: &Light| scalar(light.power(1.0));
        let total: f64 = self.varying.iter().map(|(i, _)| power(&lights[*i as usize])).sum();
        let least = if self.varying.len() <= MOST_PARTS / LEAST_OF_ONE { LEAST_OF_ONE } else { 0 };
        for (light, middle) in std::mem::take(&mut self.varying) {
            let (object, primitive) = sources[light as usize];
            let light = &mut lights[light as usize];
            let share = power(light) / total;
            let budget = ((MOST_PARTS as f64 * share) as usize).clamp(least, MOST_OF_ONE);
            if budget >= 5 {
                let made = self.pattern(material(object), (object, primitive), budget, middle).0;
                made.into_iter().for_each(|pattern| give(light, pattern));
            }
        }
    }

    /// The pattern of a triangle, if worthwhile, and the mean of the bounds' midpoints over it.
    fn pattern(
        &mut self,
        material: u32,
        (object, primitive): (u32, u32),
        budget: usize,
        middle: Vec2,
    ) -> (Option<Pattern>, f64) {
        let triangle = self.triangle(material, (object, primitive));
        Pattern::new(budget, middle, |part| triangle.emitted(part))
    }

    /// A triangle with the bounds of its material.
    fn triangle(&mut self, material: u32, (object, primitive): (u32, u32)) -> Triangle<'_> {
        let emitter = self.emitter(material);
        let textures = self.textures;
        let bounds =
            self.bounds[material as usize].get_or_insert_with(|| Bounds::new(emitter.material, textures));
        Triangle::new(emitter, bounds, object, primitive)
    }
}

fn give(light: &mut Light, pattern: Pattern) {
    let pattern = Arc::new(pattern);
    let patterned = match &*light {
        Light::Area(area) => Light::Patterned(Box::new(Patterned { area: area.clone(), pattern })),
        Light::Moving(moving) => Light::Moving(Box::new(Moving::clone(moving).patterned(pattern))),
        _ => return,
    };
    *light = patterned;
}

/// Weighted sums of emission and its positions.
#[derive(Default)]
struct Sum {
    radiance: DVec3,
    weight: f64,
    moment: DVec2,
    scalar: f64,
    squares: f64,
}

impl Sum {
    fn add(&mut self, p: DVec2, weight: f64, radiance: Vec3) {
        self.radiance += radiance.as_dvec3() * weight;
        self.weight += weight;
        let value = scalar(radiance) * weight;
        self.moment += p * value;
        self.scalar += value;
        self.squares += value * scalar(radiance);
    }

    /// The mean. Values that underflow f32 become its smallest normal number rather than zero.
    fn mean(&self) -> Mean {
        let radiance = (self.radiance / self.weight).as_vec3();
        let least = if self.scalar > 0.0 { f32::MIN_POSITIVE } else { 0.0 };
        let radiance = if radiance == Vec3::ZERO { Vec3::splat(least) } else { radiance };
        let middle =
            if self.scalar > 0.0 { clamped(self.moment / self.scalar) } else { DVec2::splat(1.0 / 3.0) };
        // Relative variance: E[f²]/E[f]² − 1.
        let varies = self.squares * self.weight > (1.0 + WORTH) * self.scalar * self.scalar;
        Mean { radiance, middle: middle.as_vec2(), varies }
    }
}

/// Mean of the channels.
fn scalar(rgb: Vec3) -> f64 {
    rgb.as_dvec3().element_sum() / 3.0
}

fn corners() -> [DVec2; 3] {
    [DVec2::ZERO, DVec2::X, DVec2::Y]
}

/// Clamps barycentric coordinates to the triangle, against rounding.
fn clamped(p: DVec2) -> DVec2 {
    let p = p.max(DVec2::ZERO);
    let over = p.x + p.y;
    if over > 1.0 { p / over } else { p }
}

/// `n` low-discrepancy points in barycentric coordinates: multiples of the inverse powers of the plastic number, folded
/// into the triangle.
fn spread(n: u32) -> impl Iterator<Item = DVec2> {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_2);
    (0..n).map(|i| {
        let p = (DVec2::splat(0.5) + STEP * f64::from(i)).fract();
        if p.x + p.y > 1.0 { DVec2::ONE - p } else { p }
    })
}

impl TexturedMaterial {
    fn emission_map(&self) -> Option<&TextureUse> {
        self.emissive_texture.as_ref()
    }

    /// The texture whose alpha channel defines the opacity.
    fn opacity_map(&self) -> Option<&TextureUse> {
        self.base_color_texture.as_ref().filter(|_| self.alpha_mode != AlphaMode::Opaque)
    }
}

/// Bounds of the emission of a material.
struct Bounds<'a> {
    emissive: Option<(TextureUse, Extremes<'a>)>,
    alpha: Option<(TextureUse, Extremes<'a>)>,
}

impl<'a> Bounds<'a> {
    fn new(material: &TexturedMaterial, textures: &'a [Texture]) -> Self {
        let of = |map: Option<&TextureUse>, value: Vec4| {
            map.map(|map| (*map, Extremes::new(&textures[map.texture as usize], Value(value))))
        };
        Self {
            emissive: of(material.emission_map(), (material.emission / 3.0).extend(0.0)),
            alpha: of(material.opacity_map(), Vec4::W),
        }
    }
}

/// A texture on a triangle, with the corners in texels.
struct Layer<'a> {
    extremes: &'a Extremes<'a>,
    grid: [DVec2; 3],
}

impl<'a> Layer<'a> {
    fn new(
        of: &'a Option<(TextureUse, Extremes<'a>)>,
        emitter: &Emitter<'_>,
        at: &dyn Fn(DVec2) -> Hit,
    ) -> Option<Self> {
        let (map, extremes) = of.as_ref()?;
        let uvs = corners().map(|p| emitter.accel.uv(&at(p), map.uv_set as usize));
        Some(Self { extremes, grid: in_texels(map, &emitter.textures[map.texture as usize], uvs) })
    }

    /// Minimum and maximum in a part, and its size in texels.
    fn within(&self, part: &Part) -> (f64, f64, f64) {
        let [a, b, c] = self.grid;
        let [x, y, z] = part.corners().map(|p| a + (b - a) * p.x + (c - a) * p.y);
        let (low, high) = (x.min(y).min(z), x.max(y).max(z));
        let (least, most) = self.extremes.within(low, high);
        (least.into(), most.into(), (high - low).max_element())
    }
}

/// An emitting triangle.
struct Triangle<'a> {
    emitter: Emitter<'a>,
    object: u32,
    primitive: u32,
    emissive: Option<Layer<'a>>,
    alpha: Option<Layer<'a>>,
    /// Alpha factor times vertex alpha at the corners.
    alphas: [f64; 3],
}

impl<'a> Triangle<'a> {
    fn new(emitter: Emitter<'a>, bounds: &'a Bounds<'a>, object: u32, primitive: u32) -> Self {
        let at = |p: DVec2| Hit { t: 0.0, u: p.x as f32, v: p.y as f32, primitive, object };
        Self {
            emitter,
            object,
            primitive,
            emissive: Layer::new(&bounds.emissive, &emitter, &at),
            alpha: Layer::new(&bounds.alpha, &emitter, &at),
            alphas: corners().map(|p| f64::from(emitter.material.alpha * emitter.accel.color(&at(p)).w)),
        }
    }

    /// Bounds and mean of the emission in a part.
    fn emitted(&self, part: &Part) -> Emitted {
        let factor = scalar(self.emitter.material.emission);
        let none = |value: f64| (value, value, 0.0);
        let emissive = self.emissive.as_ref().map_or(none(factor), |layer| layer.within(part));
        let (least, most, texels) = self.opacity(part);
        let (low, high, texels) = (emissive.0 * least, emissive.1 * most, emissive.2.max(texels));
        let even = 0.5 * (low + high);
        let mean = if texels <= FEW_TEXELS && low < high { self.points(part) } else { even };
        let layers = self.emissive.is_some() || self.alpha.is_some();
        Emitted { low, high, mean, is_fine: layers && texels <= FINE }
    }

    fn opacity(&self, part: &Part) -> (f64, f64, f64) {
        // Bound of the f32 rounding error.
        const ROUNDING: f64 = 8.0 * f32::EPSILON as f64;
        let mode = self.emitter.material.alpha_mode;
        if mode == AlphaMode::Opaque {
            return (1.0, 1.0, 0.0);
        }
        let [a, b, c] = self.alphas;
        let [x, y, z] = part.corners().map(|p| a + (b - a) * p.x + (c - a) * p.y);
        let (least, most, texels) = self.alpha.as_ref().map_or((1.0, 1.0, 0.0), |layer| layer.within(part));
        let low = x.min(y).min(z) * least * (1.0 - ROUNDING);
        let high = x.max(y).max(z) * most * (1.0 + ROUNDING);
        match mode {
            AlphaMode::Mask { cutoff } => {
                let shown = |alpha: f64| f64::from(u8::from(alpha >= f64::from(cutoff)));
                (shown(low), shown(high), texels)
            }
            _ => (low.clamp(0.0, 1.0), high.clamp(0.0, 1.0), texels),
        }
    }

    /// Mean of the values at the centroids of the four quarters.
    fn points(&self, part: &Part) -> f64 {
        let value = |which: usize| {
            let [a, b, c] = part.quarter(which).corners();
            let p = (a + b + c) / 3.0;
            let (object, primitive) = (self.object, self.primitive);
            scalar(self.emitter.radiance(&Hit { t: 0.0, u: p.x as f32, v: p.y as f32, primitive, object }))
        };
        (0..4).map(value).sum::<f64>() / 4.0
    }
}
