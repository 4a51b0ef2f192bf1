//! How much memory will a scene take? Worked out from counts alone, before anything is decoded or copied.
//!
//! *Approximation*: figures per piece are measured on grids of 10⁵ to 10⁷ triangles (peak of the whole process, within
//! 15 %); they are for 64-bit machines. Every instance of a mesh is a copy in render space, so all are counted.
use dapple_imaging::{MemoryLimit, memory::Overrun};

/// Bytes of a triangle while its tree is built, the largest share of a scene's peak.
const TRIANGLE: u64 = 480;
/// Bytes of a vertex: where it is, as read and in render space.
const VERTEX: u64 = 44;
/// And of each further number of it that is read (normals, tangents, texture coordinates, colours), likewise.
const ATTRIBUTE: u64 = 8;
/// Bytes of an object beside its triangles, whatever node or list of instances it comes from.
const OBJECT: u64 = 1000;
/// Bytes of a link between a moving object and the root that moves for itself.
const LINK: u64 = 16;

/// What a scene consists of. All counts are of what is placed: twice for a mesh that is shown twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Triangles.
    pub triangles: u64,
    /// Vertices that triangles use.
    pub vertices: u64,
    /// Numbers of vertices beside their position.
    pub attributes: u64,
    /// Meshes' primitives, spheres and disks.
    pub objects: u64,
    /// Moving nodes above objects, lights and cameras, counted for each of these.
    pub links: u64,
    /// Bytes of textures and of anything else that is decoded.
    pub bytes: u64,
}

impl Load {
    /// Both together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let add = u64::saturating_add;
        Self {
            triangles: add(self.triangles, other.triangles),
            vertices: add(self.vertices, other.vertices),
            attributes: add(self.attributes, other.attributes),
            objects: add(self.objects, other.objects),
            links: add(self.links, other.links),
            bytes: add(self.bytes, other.bytes),
        }
    }

    /// So many times the same.
    #[must_use]
    pub fn times(self, n: u64) -> Self {
        let times = |count: u64| count.saturating_mul(n);
        Self {
            triangles: times(self.triangles),
            vertices: times(self.vertices),
            attributes: times(self.attributes),
            objects: times(self.objects),
            links: times(self.links),
            bytes: times(self.bytes),
        }
    }

    /// Bytes at the peak, while the scene is built.
    pub fn peak_bytes(&self) -> u64 {
        let parts = [
            self.triangles.saturating_mul(TRIANGLE),
            self.vertices.saturating_mul(VERTEX),
            self.attributes.saturating_mul(ATTRIBUTE),
            self.objects.saturating_mul(OBJECT),
            self.links.saturating_mul(LINK),
            self.bytes,
        ];
        parts.into_iter().fold(0, u64::saturating_add)
    }

    /// Whether it fits.
    ///
    /// # Errors
    /// What is needed and what there is, in words.
    pub fn admit(&self, limit: MemoryLimit) -> Result<(), Overrun> {
        limit.admit(self.peak_bytes(), None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_end_at_the_largest_number() {
        let one =
            Load { triangles: 12_288 / 3, vertices: 2145, attributes: 0, objects: 1, links: 0, bytes: 0 };
        assert_eq!(one.times(2000).peak_bytes(), 2000 * (4096 * 480 + 2145 * 44 + 1000));
        assert_eq!(one.plus(one), one.times(2));
        let endless = one.times(u64::MAX);
        assert_eq!(endless.plus(one).peak_bytes(), u64::MAX);
        assert!(
            endless.admit(MemoryLimit::free(1 << 40)).is_err()
                && one.admit(MemoryLimit::free(1 << 22)).is_ok()
        );
    }
}
