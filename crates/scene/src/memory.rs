//! Estimate of the memory that a scene takes, from counts alone, before any data are decoded or copied.
//!
//! *Approximation*: the sizes per element are measured on grids of 10⁵ to 10⁷ triangles (peak of the whole process,
//! within 15 %) on 64-bit machines. Every instance of a mesh is a copy in render space, so all instances count.
use dapple_imaging::MemoryLimit;
use dapple_imaging::memory::{Overrun, PER_BYTE};

/// Bytes per triangle while the acceleration structure is built, the largest part of a scene's peak.
const TRIANGLE: u64 = 480;
/// Bytes per vertex: its position as read and in render space.
const VERTEX: u64 = 44;
/// Bytes per number of a vertex attribute (normals, tangents, texture coordinates, colours), as read and in render
/// space.
const ATTRIBUTE: u64 = 8;
/// Bytes per object in addition to its triangles, including those of its node or instance.
const OBJECT: u64 = 1000;
/// Bytes per animated link between a moving object and its root.
const LINK: u64 = 16;

/// Bytes of memory allowed by default for any scene, however small its file: every instance is a copy, so that few bytes
/// may place a forest.
const ANY_SCENE: u64 = 6 << 30;

/// Counts of the parts of a scene. Every instance counts: a mesh that is placed twice is counted twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices that triangles use.
    pub vertices: u64,
    /// Number of floats in vertex attributes other than position.
    pub attributes: u64,
    /// Number of mesh primitives, spheres and disks.
    pub objects: u64,
    /// Number of links in the chains of moving objects, lights and cameras, summed over these.
    pub links: u64,
    /// Bytes of textures and other decoded data.
    pub bytes: u64,
}

impl Load {
    /// The sum of both.
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

    /// The load multiplied by `n`.
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

    /// Peak memory in bytes, while the scene is built.
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

    /// Checks the peak against a limit for a scene whose files have `file` bytes.
    ///
    /// # Errors
    /// The required and the available memory if the limit is exceeded.
    pub fn admit(&self, limit: MemoryLimit, file: u64) -> Result<(), Overrun> {
        limit.admit_from(self.peak_bytes(), Some(file), (PER_BYTE, ANY_SCENE))
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
            endless.admit(MemoryLimit::free(1 << 40), 1 << 40).is_err()
                && one.admit(MemoryLimit::free(1 << 22), 1).is_ok()
        );
        // 2000 instances of a mesh of a small file are plausible; as many copies as fill 8 GB are not.
        let forest = one.times(2000);
        assert!(
            forest.peak_bytes() > 4_000_000_000 && forest.admit(MemoryLimit::free(1 << 34), 100_000).is_ok()
        );
        assert!(one.times(4000).admit(MemoryLimit::free(1 << 34), 100_000).is_err());
    }
}
