//! Rays in columns, for queries of many rays.

use dapple_math::Ray;
use glam::Vec3;

/// Many rays: one column per number.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    len: usize,
    o: [&'a [f32]; 3],
    d: [&'a [f32]; 3],
    t_max: Option<&'a [f32]>,
}

impl<'a> Rays<'a> {
    /// The first `len` rays of the columns of origins, directions and ends, or fewer where a column is shorter. Without
    /// ends, all rays are infinite.
    pub fn new(len: usize, o: [&'a [f32]; 3], d: [&'a [f32]; 3], t_max: Option<&'a [f32]>) -> Self {
        let columns = o.into_iter().chain(d).chain(t_max);
        let len = columns.map(<[f32]>::len).min().unwrap_or(0).min(len);
        let cut = |column: [&'a [f32]; 3]| column.map(|x| &x[..len]);
        Self { len, o: cut(o), d: cut(d), t_max: t_max.map(|x| &x[..len]) }
    }

    /// The number of rays.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no rays.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// One ray; `i` has to be less than the number of rays.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        let ([x, y, z], [dx, dy, dz]) = (self.o, self.d);
        let t_max = match self.t_max {
            None => f32::INFINITY,
            Some(t_max) => t_max[i],
        };
        Ray { o: Vec3::new(x[i], y[i], z[i]), d: Vec3::new(dx[i], dy[i], dz[i]), t_max }
    }

    /// The columns of the origins.
    #[inline(always)]
    pub fn o(&self) -> [&'a [f32]; 3] {
        self.o
    }

    /// The columns of the directions.
    #[inline(always)]
    pub fn d(&self) -> [&'a [f32]; 3] {
        self.d
    }

    /// The column of the ends; None where all rays are infinite.
    #[inline(always)]
    pub fn t_max(&self) -> Option<&'a [f32]> {
        self.t_max
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_column_is_read_beyond_its_end() {
        let (long, short) = ([1.0, 2.0, 3.0], [4.0, 5.0]);
        let rays = Rays::new(7, [&long; 3], [&long, &short, &long], Some(&long));
        assert_eq!((rays.len(), rays.is_empty()), (2, false));
        assert_eq!(rays.ray(1).d, Vec3::new(2.0, 5.0, 2.0));
        assert_eq!(rays.ray(1).t_max, 2.0);
        let rays = Rays::new(1, [&long; 3], [&short; 3], None);
        assert_eq!((rays.len(), rays.ray(0).t_max), (1, f32::INFINITY));
        assert!(Rays::new(3, [&[]; 3], [&short; 3], None).is_empty());
    }
}
