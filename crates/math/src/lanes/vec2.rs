//! Vectors of two components.

use super::real::Real;
use glam::Vec2;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One vector of two components per lane. Every operation rounds as that of [`glam::Vec2`] does.
#[derive(Clone, Copy, Debug)]
pub struct Vec2x<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
}

impl<R: Real> Vec2x<R> {
    /// Builds vectors from their components.
    #[inline(always)]
    pub fn new(x: R, y: R) -> Self {
        Self { x, y }
    }

    /// Gives every lane the same vector.
    #[inline(always)]
    pub fn splat(v: Vec2) -> Self {
        Self::new(R::splat(v.x), R::splat(v.y))
    }

    /// Reads one column per component, as [`Real::load`] does.
    #[inline(always)]
    pub fn load([x, y]: [&[f32]; 2]) -> Self {
        Self::new(R::load(x), R::load(y))
    }

    /// Writes one column per component, as [`Real::store`] does.
    #[inline(always)]
    pub fn store(self, [x, y]: [&mut [f32]; 2]) {
        self.x.store(x);
        self.y.store(y);
    }

    /// Returns `yes` in the lanes of `mask` and `no` in the others.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self::new(R::select(mask, yes.x, no.x), R::select(mask, yes.y, no.y))
    }

    /// Returns the scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y
    }

    /// Returns the z component of the cross product: the area of the parallelogram, positive anticlockwise.
    #[inline(always)]
    pub fn perp_dot(self, other: Self) -> R {
        self.x * other.y - self.y * other.x
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
}

impl<R: Real> Add for Vec2x<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl<R: Real> Sub for Vec2x<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

impl<R: Real> Mul for Vec2x<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y)
    }
}

impl<R: Real> Mul<R> for Vec2x<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Self::new(self.x * factor, self.y * factor)
    }
}

impl<R: Real> Div<R> for Vec2x<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: R) -> Self {
        Self::new(self.x / divisor, self.y / divisor)
    }
}

impl<R: Real> Neg for Vec2x<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y)
    }
}

impl From<Vec2> for Vec2x<f32> {
    #[inline(always)]
    fn from(v: Vec2) -> Self {
        Self::new(v.x, v.y)
    }
}

impl From<Vec2x<f32>> for Vec2 {
    #[inline(always)]
    fn from(v: Vec2x<f32>) -> Self {
        Self::new(v.x, v.y)
    }
}
