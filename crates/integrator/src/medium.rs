//! What a ray travels through, where that absorbs: glass with a colour of its own.

use crate::vertex::{Scattered, Vertex};
use glam::Vec3;

/// Absorbs evenly. Outside of all such there is none, and nothing is multiplied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Medium {
    /// Absorption per render unit.
    sigma_a: Vec3,
}

impl Medium {
    /// None for what absorbs nothing.
    fn of(sigma_a: Vec3) -> Option<Self> {
        (cfg!(not(without = "medium")) && sigma_a != Vec3::ZERO).then_some(Self { sigma_a })
    }

    /// What a ray that leaves `vertex` is in, having come there in `around`.
    pub fn after(around: Option<Self>, vertex: &Vertex, left: &Scattered) -> Option<Self> {
        if cfg!(without = "medium") || !left.sample.lobe.is_transmission() || vertex.shading.material.thin {
            around
        } else if left.ray.d.dot(vertex.surface.ng) < 0.0 {
            Self::of(vertex.shading.sigma_a)
        } else {
            None
        }
    }

    /// exp(−σ_a·s) per channel (Beer–Lambert); 1 where a channel is not absorbed, whatever the distance.
    pub fn transmittance(self, distance: f32) -> Vec3 {
        let along = |s: f32| if s > 0.0 { libm::expf(-s * distance) } else { 1.0 };
        Vec3::new(along(self.sigma_a.x), along(self.sigma_a.y), along(self.sigma_a.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_falls_off_by_beer_and_lambert() {
        assert_eq!(Medium::of(Vec3::ZERO), None);
        let Some(medium) = Medium::of(Vec3::new(0.0, 0.5, 2.0)) else { unreachable!("it absorbs") };
        let expected = Vec3::new(1.0, (-1.5f32).exp(), (-6.0f32).exp());
        assert!((medium.transmittance(3.0) - expected).abs().max_element() < 1e-6);
        assert_eq!(medium.transmittance(f32::INFINITY), Vec3::X);
    }
}
