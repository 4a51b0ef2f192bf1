//! The random number generator of the tests, which deliberately differs from the one under test.

use glam::{DVec3, Vec2};

/// SplitMix64 [Steele, Lea & Flood 2014]: a counter and a finaliser, for which all seeds are equally good.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// Creates a generator. Equal seeds give equal sequences on every machine.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns 64 random bits.
    pub const fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = self.0;
        let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    }

    /// Returns a uniform number in [0,1), a multiple of 2^-53.
    pub fn f64(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Returns a uniform number in [0,1), a multiple of 2^-24. It is never 1.
    pub fn f32(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// Returns a uniform point in [0,1)².
    pub fn vec2(&mut self) -> Vec2 {
        Vec2::new(self.f32(), self.f32())
    }

    /// Returns a uniform integer in 0..n (n ≥ 1), with a bias below n·2^-32.
    pub fn below(&mut self, n: u32) -> u32 {
        (((self.bits() >> 32) * u64::from(n)) >> 32) as u32
    }

    /// Returns a uniform direction on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.f64() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.f64()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    /// Returns a standard normal number (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let r = (-2.0 * (1.0 - self.f64()).ln()).sqrt();
        r * (std::f64::consts::TAU * self.f64()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_right() {
        let mut rng = Rng::new(1);
        let n = 100_000;
        let (mut mean, mut square, mut normal) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            let x = f64::from(rng.f32());
            assert!((0.0..1.0).contains(&x));
            mean += x / f64::from(n);
            square += rng.direction().z.powi(2) / f64::from(n);
            normal += rng.normal().powi(2) / f64::from(n);
        }
        // Four standard errors: the standard deviation of x is 1/√12, of z² it is √(4/45), of a squared normal √2.
        assert!((mean - 0.5).abs() < 4.0 * (1.0f64 / 12.0 / f64::from(n)).sqrt());
        assert!((square - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0 / f64::from(n)).sqrt());
        assert!((normal - 1.0).abs() < 4.0 * (2.0 / f64::from(n)).sqrt());
    }
}
