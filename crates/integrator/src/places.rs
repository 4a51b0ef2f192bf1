//! Which points an integral gets at a place in the tree of rays.
//!
//! Nested, every integral runs over all of its points at every point of the ones around it, with a key of its own there,
//! so that no two places share points (a `grid` has the same everywhere: that is what it is). Paired, each place takes
//! the point of the pixel's sample, its strata visited in an order that the integral's key permutes.

use crate::effects::{Combine, Effect, Plans};
use crate::settings::Settings;
use dapple_camera::Camera;
use dapple_sampling::{Dimension, Key, Pattern, Plan};
use dapple_scene::Scene;
use glam::Vec2;

/// The plans at the first hit and below it, as the render runs them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Integrals {
    pub first: Plans,
    pub below: Plans,
    pub combine: Combine,
}

/// One midpoint: an integral that the scene does not have.
const ABSENT: Plan = Plan { nx: 1, ny: 1, pattern: Pattern::Grid };

impl Integrals {
    /// The settings' plans without what the scene lacks. Paired, every count becomes the pixel's; nested, counts below
    /// the first hit are `secondary`, and a grid of one point becomes a random one there: else nested grids would not
    /// tend to the truth.
    pub fn new(scene: &Scene, camera: &Camera, settings: &Settings) -> Self {
        let n = settings.plans.pixel.count().max(1);
        let paired = settings.combine == Combine::Paired;
        let present = |effect| match effect {
            Effect::Lens => camera.lens.is_some_and(|lens| lens.radius > 0.0),
            Effect::Time => moves(scene),
            _ => true,
        };
        let first = settings.plans.map(|effect, plan| match plan {
            _ if !present(effect) => ABSENT,
            plan if paired && plan.count() != n => Plan::new(n, plan.pattern),
            plan => plan,
        });
        let below = first.map(|_, plan| match plan.pattern {
            _ if paired => plan,
            Pattern::Grid if settings.secondary == 1 => Plan::new(1, Pattern::Random),
            pattern => Plan::new(settings.secondary, pattern),
        });
        Self { first, below, combine: settings.combine }
    }

    /// Plans at a vertex.
    pub fn at(&self, depth: u32) -> &Plans {
        if depth == 0 { &self.first } else { &self.below }
    }
}

/// Whether anything moves while the shutter is open.
pub(crate) fn moves(scene: &Scene) -> bool {
    scene.survey.has_motion
}

/// A place in the tree of rays.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    key: Key,
    /// Scattering events so far.
    pub depth: u32,
    /// The pixel's sample when the integrals are paired.
    paired: Option<u32>,
}

impl Place {
    /// Sample `s` of a pixel; `key` is the pixel's.
    pub fn new(combine: Combine, key: Key, s: u32) -> Self {
        match combine {
            Combine::Nested => Self { key: key.branch(s), depth: 0, paired: None },
            Combine::Paired => Self { key, depth: 0, paired: Some(s) },
        }
    }

    /// How many points an integral has here.
    pub fn count(&self, plan: Plan) -> u32 {
        if self.paired.is_some() { plan.count().min(1) } else { plan.count() }
    }

    /// Point `i` of `count` of an integral over the unit square; `which` of the integrals of that name.
    pub fn point_2d(&self, plan: Plan, dimension: Dimension, which: u32, i: u32) -> Vec2 {
        let key = self.key.at(self.depth, dimension).branch(which);
        match self.paired {
            None => plan.point_2d(i, key),
            Some(s) => plan.padded_2d(s, key),
        }
    }

    /// Point `i` of `count` of an integral over the unit interval.
    pub fn point_1d(&self, plan: Plan, dimension: Dimension, i: u32) -> f32 {
        let key = self.key.at(self.depth, dimension);
        match self.paired {
            None => plan.point_1d(i, key),
            Some(s) => plan.padded_1d(s, key),
        }
    }

    /// The place inside point `i` of an integral, which is number `which` here.
    pub fn within(&self, which: u32, i: u32) -> Self {
        let key = self.key.branch(which);
        Self { key: if self.paired.is_some() { key } else { key.branch(i) }, ..*self }
    }

    /// The place where a ray from here arrives.
    pub fn next(&self, which: u32, i: u32) -> Self {
        Self { depth: self.depth + 1, ..self.within(which, i) }
    }

    /// For the alpha that a ray meets: another one for every ray.
    pub fn ray_key(&self, dimension: Dimension, which: u32, i: u32) -> Key {
        let key = self.key.at(self.depth, dimension).branch(which);
        key.branch(self.paired.unwrap_or(i))
    }
}
