//! Bodies: volumes that light passes through, ranked by their precedence where they overlap.
//!
//! A body consists of all volume primitives of one mesh node (of one instance); an object added in code is a separate
//! body. Where bodies overlap, the one with the highest priority (material `extras`) takes precedence; at equal
//! priority the one with the smaller bounding volume, then the one with the lower node index. Bodies are stored in that
//! order, highest precedence first, so that the medium at a point is that of the lowest index among the bodies that
//! contain the point, regardless of the path by which it was reached.
use crate::{
    Object, Space, TexturedMaterial, Warning, WorldPoint, builder::Placed, error::quoted, exposure::Exposure,
};
use glam::{DVec3, Vec3};

/// Maximum number of warnings about bodies.
const MAX_WARNINGS: usize = 40;

/// Medium of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Index of refraction; 0 if only Schlick's law is known.
    pub ior: f32,
    /// Absorption coefficient per render unit.
    pub sigma_a: Vec3,
}

/// All bodies of a scene.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// Bodies in order of decreasing precedence.
    pub all: Vec<Body>,
    /// Render-space bounding box of all bodies over the whole exposure; None without bodies.
    pub bounds: Option<(Vec3, Vec3)>,
}

/// Quantum, in units in the last place of f32, within which bounding volumes count as equal: about 3e-5 relative, so
/// that the rounding of vertices does not decide between two equal bodies.
const EQUAL_BITS: u32 = 1 << 9;

/// Margin around the bounding box of bodies, relative to its largest coordinate: covers the rounding of placed
/// vertices.
const ROOM: f32 = 1.0 / (1 << 16) as f32;

/// A body before ranking.
struct Volume {
    first: usize,
    node: u32,
    priority: f64,
    /// Bounding box in the space of the mesh, and the factor from its volume to world units.
    own: (DVec3, DVec3),
    factor: f64,
}

/// An object that bounds a volume.
struct BoundingObject {
    object: usize,
    /// Index of the volume.
    volume: usize,
    /// World-space bounding box when the shutter opens.
    world: Option<(DVec3, DVec3)>,
}

/// Finds the bodies among the objects, ranks them, and assigns to each object the body that it bounds. Absorption in
/// the materials is per render unit.
pub(crate) struct Finder {
    parts: Vec<BoundingObject>,
    volumes: Vec<Volume>,
}

impl Finder {
    /// Collects the volumes of the objects before these are converted to render space.
    pub fn new(placed: &[Placed], materials: &[TexturedMaterial], exposure: &Exposure) -> Self {
        let mut finder = Self { parts: Vec::new(), volumes: Vec::new() };
        let mut group_of_last = None;
        for (i, part) in placed.iter().enumerate() {
            let Some(material) = materials.get(part.material as usize).filter(|m| m.is_volume()) else {
                continue;
            };
            let (own, factor) = part.own_box(exposure).unwrap_or_default();
            // The parts of a body are consecutive.
            if group_of_last == Some(part.group)
                && let Some(volume) = finder.volumes.last_mut()
            {
                volume.own = (volume.own.0.min(own.0), volume.own.1.max(own.1));
            } else {
                // Adding zero turns −0 into 0.
                let (node, priority) = (part.node, material.priority + 0.0);
                finder.volumes.push(Volume { first: i, node, priority, own, factor });
                group_of_last = Some(part.group);
            }
            let volume = finder.volumes.len() - 1;
            finder.parts.push(BoundingObject { object: i, volume, world: part.bounds(exposure) });
        }
        finder
    }

    /// Ranks the bodies. `whole` returns the render-space bounding box of a moving object over the whole exposure.
    pub fn rank(
        self,
        objects: &mut [Object],
        materials: &[TexturedMaterial],
        space: &Space,
        whole: impl Fn(usize) -> Option<(DVec3, DVec3)>,
    ) -> (Bodies, Vec<Warning>) {
        let mut order: Vec<usize> = (0..self.volumes.len()).collect();
        order.sort_by(|&a, &b| {
            let (x, y) = (&self.volumes[a], &self.volumes[b]);
            let by_volume = x.size().total_cmp(&y.size());
            y.priority.total_cmp(&x.priority).then(by_volume).then(x.node.cmp(&y.node)).then(a.cmp(&b))
        });
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(r, &volume)| rank[volume] = r as u32);
        let material = |object: &Object| &materials[object.material as usize];
        let mut bodies = Bodies::default();
        let mut warnings = Vec::new();
        for &volume in &order {
            let of = material(&objects[self.volumes[volume].first]);
            bodies.all.push(Body { ior: of.base.ior, sigma_a: of.sigma_a });
        }
        for &BoundingObject { object: i, volume, world } in &self.parts {
            objects[i].body = rank[volume];
            let (mine, first) = (material(&objects[i]), material(&objects[self.volumes[volume].first]));
            let same = |m: &TexturedMaterial| (m.base.ior, m.sigma_a, m.priority);
            if same(mine) != same(first) && warnings.len() < MAX_WARNINGS {
                let name = quoted(&objects[i].name);
                warnings.push(Warning(format!(
                    "the primitives of '{name}' bound one volume, but differ in ior, attenuation or priority: the first one is used; give each volume a mesh node of its own"
                )));
            }
            let render =
                world.map(|(lo, hi)| (space.to_render(WorldPoint(lo)), space.to_render(WorldPoint(hi))));
            let moving = whole(i).map(|(lo, hi)| (lo.as_vec3(), hi.as_vec3()));
            bodies.bounds = bodies.bounds.into_iter().chain(moving.or(render)).reduce(union);
        }
        bodies.bounds = bodies.bounds.map(roomier);
        warnings.dedup();
        (bodies, warnings)
    }
}

impl Volume {
    /// World-space volume of the placed bounding box; infinite if it is flat and bounds no volume.
    fn size(&self) -> f32 {
        let extent = self.own.1 - self.own.0;
        let volume = (extent.x * extent.y * extent.z * self.factor).abs() as f32;
        if !(volume > 0.0 && extent.min_element() > 0.0) {
            return f32::INFINITY;
        }
        let bits = volume.to_bits().saturating_add(EQUAL_BITS / 2) / EQUAL_BITS * EQUAL_BITS;
        f32::from_bits(bits)
    }
}

fn union(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.0.min(b.0), a.1.max(b.1))
}

fn roomier((lo, hi): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let room = Vec3::splat(lo.abs().max(hi.abs()).max_element() * ROOM);
    (lo - room, hi + room)
}
