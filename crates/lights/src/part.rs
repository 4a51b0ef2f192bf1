//! Congruent parts of a subdivided triangle.
use glam::DVec2;

/// One of the congruent parts of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Barycentric coordinates (of corners 1 and 2) of its first corner.
    pub corner: DVec2,
    /// Side length relative to the whole triangle; negative if the part is rotated by half a turn.
    pub step: f64,
}

impl Part {
    /// The whole triangle.
    pub const WHOLE: Self = Self { corner: DVec2::ZERO, step: 1.0 };

    /// Barycentric coordinates of its corners.
    pub fn corners(&self) -> [DVec2; 3] {
        let Self { corner, step } = *self;
        [corner, corner + DVec2::new(step, 0.0), corner + DVec2::new(0.0, step)]
    }

    /// Area relative to the whole triangle.
    pub fn area(&self) -> f64 {
        self.step * self.step
    }

    /// One of the four quarters: 0 to 2 lie at the corners, in their order, and 3 is the rotated one between them.
    pub fn quarter(&self, which: usize) -> Self {
        let half = 0.5 * self.step;
        let (towards, step) = match which {
            0 => (DVec2::ZERO, half),
            1 => (DVec2::X, half),
            2 => (DVec2::Y, half),
            _ => (DVec2::ONE, -half),
        };
        Self { corner: self.corner + towards * half, step }
    }

    /// Index of the quarter that contains the point `at`.
    pub(crate) fn quarter_of(&self, at: DVec2) -> usize {
        let at = (at - self.corner) / self.step;
        match at {
            _ if at.x >= 0.5 => 1,
            _ if at.y >= 0.5 => 2,
            _ if at.x + at.y <= 0.5 => 0,
            _ => 3,
        }
    }
}
