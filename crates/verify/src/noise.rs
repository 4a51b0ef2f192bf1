//! Random numbers for checks without a render: SplitMix64 [Steele, Lea & Flood 2014], independent of the points of the
//! integrators.

use glam::{Vec2, Vec3};

/// A random number generator with a seed.
#[derive(Clone, Debug)]
pub(crate) struct Noise(pub u64);

impl Noise {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// A point in [0, 1)².
    pub fn point(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }

    /// A point in [−1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// A direction uniform over the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            if v.length() <= 1.0 && v.length() > 0.1 {
                return v.normalize();
            }
        }
    }

    /// An integer below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A unit direction with n·d = `cosine` at a random azimuth about n.
    pub fn about(&mut self, n: Vec3, cosine: f64) -> Vec3 {
        let n = n.as_dvec3();
        loop {
            let v = self.direction().as_dvec3();
            let across = v - n * v.dot(n);
            if across.length() > 0.1 {
                return (n * cosine + across.normalize() * (1.0 - cosine * cosine).sqrt()).as_vec3();
            }
        }
    }
}
