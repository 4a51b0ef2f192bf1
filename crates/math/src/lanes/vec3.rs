//! Vectors of three components.

use super::real::Real;
use glam::Vec3;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// One vector of three components per lane. Every operation rounds as that of [`glam::Vec3`] does.
#[derive(Clone, Copy, Debug)]
pub struct Vec3x<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

impl<R: Real> Vec3x<R> {
    /// Builds vectors from their components.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    /// Gives every lane the same vector.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self::new(R::splat(v.x), R::splat(v.y), R::splat(v.z))
    }

    /// Reads one column per component, as [`Real::load`] does.
    #[inline(always)]
    pub fn load([x, y, z]: [&[f32]; 3]) -> Self {
        Self::new(R::load(x), R::load(y), R::load(z))
    }

    /// Writes one column per component, as [`Real::store`] does.
    #[inline(always)]
    pub fn store(self, [x, y, z]: [&mut [f32]; 3]) {
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    /// Packs the lanes of `mask` to the front of one column per component, as [`Real::compress_store`] does.
    #[inline(always)]
    pub fn compress_store(self, mask: R::Mask, [x, y, z]: [&mut [f32]; 3]) -> usize {
        let count = self.x.compress_store(mask, x);
        self.y.compress_store(mask, y);
        self.z.compress_store(mask, z);
        count
    }

    /// Reads one table per component, as [`Real::gather`] does.
    #[inline(always)]
    pub fn gather([x, y, z]: [&[f32]; 3], index: R::Word) -> Self {
        Self::new(R::gather(x, index), R::gather(y, index), R::gather(z, index))
    }

    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self::new(R::select(mask, yes.x, no.x), R::select(mask, yes.y, no.y), R::select(mask, yes.z, no.z))
    }

    /// Returns the scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Returns the vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - other.y * self.z,
            self.z * other.x - other.z * self.x,
            self.x * other.y - other.x * self.y,
        )
    }

    /// Returns the squared length.
    #[inline(always)]
    pub fn length_squared(self) -> R {
        self.dot(self)
    }

    /// Returns the length.
    #[inline(always)]
    pub fn length(self) -> R {
        self.dot(self).sqrt()
    }

    /// Returns the vector divided by its length. It is not finite if the length is 0, infinite or NaN.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * (R::splat(1.0) / self.length())
    }

    /// Returns the vector mirrored at the plane with unit normal `n`: v − 2·(v·n)·n. A direction `wo` that points away
    /// from the surface is reflected to `-wo.reflect(n)`.
    #[inline(always)]
    pub fn reflect(self, n: Self) -> Self {
        self - n * (R::splat(2.0) * self.dot(n))
    }

    /// Returns the absolute values of the components.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// Returns the smaller of each pair of components, as [`Real::min`] does.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self::new(self.x.min(other.x), self.y.min(other.y), self.z.min(other.z))
    }

    /// Returns the larger of each pair of components, as [`Real::max`] does.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self::new(self.x.max(other.x), self.y.max(other.y), self.z.max(other.z))
    }

    /// Returns the smallest component.
    #[inline(always)]
    pub fn min_element(self) -> R {
        self.x.min(self.y.min(self.z))
    }

    /// Returns the largest component.
    #[inline(always)]
    pub fn max_element(self) -> R {
        self.x.max(self.y.max(self.z))
    }

    /// Whether all components are neither infinite nor NaN.
    #[inline(always)]
    pub fn is_finite(self) -> R::Mask {
        self.x.is_finite() & self.y.is_finite() & self.z.is_finite()
    }
}

impl<R: Real> Add for Vec3x<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Real> Sub for Vec3x<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Real> Mul for Vec3x<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }
}

impl<R: Real> Mul<R> for Vec3x<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<R: Real> Div<R> for Vec3x<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: R) -> Self {
        Self::new(self.x / divisor, self.y / divisor, self.z / divisor)
    }
}

impl<R: Real> AddAssign for Vec3x<R> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<R: Real> Neg for Vec3x<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl From<Vec3> for Vec3x<f32> {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl From<Vec3x<f32>> for Vec3 {
    #[inline(always)]
    fn from(v: Vec3x<f32>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}
