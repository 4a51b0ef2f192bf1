//! Sample points of an integral at a position in the ray tree.
//!
//! In nested mode, every integral is evaluated with all of its points at every point of the enclosing integrals, with a
//! separate key, so that no two places share points (except for a `grid`, which is the same everywhere by definition).
//! In paired mode, each place takes the point of the pixel sample, with the strata in an order that the key of the
//! integral permutes.

use crate::Dimension;
use crate::effects::{Combine, Effect, SampleSets};
use crate::settings::Settings;
use dapple_camera::Camera;
use dapple_sampling::{Key, Pattern, SampleSet};
use dapple_scene::Scene;
use glam::Vec2;

/// The sample sets at the first hit and below it, as used by the render.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Integrals {
    pub first: SampleSets,
    pub below: SampleSets,
    pub combine: Combine,
    /// Sample sets over the environment, at the first hit and below it.
    sky: [SampleSet; 2],
    /// Diffuse lobes are not sampled.
    unfollowed: bool,
}

/// Key branch of points that are drawn anew; no integral has this many points.
const AGAIN: u32 = u32::MAX;

/// One midpoint, for an integral that the scene does not have.
const ABSENT: SampleSet = SampleSet { nx: 1, ny: 1, pattern: Pattern::Grid };

impl Integrals {
    /// The sample sets of the settings without the integrals that the scene lacks. In paired mode, every count becomes
    /// that of the pixel; in nested mode, counts below the first hit are `secondary`, and a grid of one point becomes a
    /// random point there, because nested grids would otherwise not converge to the correct result.
    pub fn new(scene: &Scene, camera: &Camera, settings: &Settings) -> Self {
        let n = settings.plans.pixel.count().max(1);
        let own = settings.distribution_tracer().cloned().unwrap_or_default();
        let paired = own.combine == Combine::Paired;
        let present = |effect| match effect {
            Effect::Lens => camera.lens.is_some_and(|lens| lens.radius > 0.0),
            Effect::Time => moves(scene),
            _ => true,
        };
        let matched = |plan: SampleSet| match plan {
            plan if paired && plan.count() != n => SampleSet::new(n, plan.pattern),
            plan => plan,
        };
        let first = settings.plans.map(|effect, plan| match plan {
            _ if !present(effect) => ABSENT,
            plan => matched(plan),
        });
        let lower = |plan: SampleSet| match plan.pattern {
            _ if paired => plan,
            Pattern::Grid if own.secondary == 1 => SampleSet::new(1, Pattern::Random),
            pattern => SampleSet::new(own.secondary, pattern),
        };
        let below = first.map(|_, plan| lower(plan));
        let sky = matched(if first.is_off(Effect::Light) { own.sky } else { first.light });
        Self {
            first,
            below,
            combine: own.combine,
            sky: [sky, lower(sky)],
            unfollowed: first.is_off(Effect::Diffuse),
        }
    }

    /// Samples over the environment at a place, both of light sampling and of directions on a diffuse lobe that is not
    /// sampled: the light's sample set, or the environment's own if lights are off. If diffuse lobes are not sampled,
    /// points seen in smooth surfaces have as many as points seen directly, because only one ray leads to each, and no
    /// other sample count adds to them.
    pub fn sky(&self, place: &Place) -> SampleSet {
        let below = if self.unfollowed { !place.smooth } else { place.depth > 0 };
        self.sky[usize::from(below)]
    }

    /// As [`Integrals::sky`], for paths of only smooth surfaces, and for other paths.
    pub fn skies_at(&self, depth: u32) -> [SampleSet; 2] {
        let seen = self.sky[usize::from(depth > 0 && !self.unfollowed)];
        [seen, self.sky[usize::from(depth > 0)]]
    }

    /// Sample sets at a vertex.
    pub fn at(&self, depth: u32) -> &SampleSets {
        if depth == 0 { &self.first } else { &self.below }
    }
}

/// Whether anything moves while the shutter is open.
pub(crate) fn moves(scene: &Scene) -> bool {
    scene.survey.has_motion
}

/// A position in the ray tree.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    key: Key,
    /// Number of preceding scattering events.
    pub depth: u32,
    /// The pixel sample if the integrals are paired.
    paired: Option<u32>,
    /// The path to here consists only of smooth reflection and refraction.
    smooth: bool,
}

impl Place {
    /// Sample `s` of a pixel; `key` is that of the pixel.
    pub fn new(combine: Combine, key: Key, s: u32) -> Self {
        match combine {
            Combine::Nested => Self { key: key.branch(s), depth: 0, paired: None, smooth: true },
            Combine::Paired => Self { key, depth: 0, paired: Some(s), smooth: true },
        }
    }

    /// Number of points of an integral at this place.
    pub fn count(&self, plan: SampleSet) -> u32 {
        if self.paired.is_some() { plan.count().min(1) } else { plan.count() }
    }

    /// Point `i` of `count` of an integral over the unit square; `which` distinguishes integrals of the same name.
    pub fn point_2d(&self, plan: SampleSet, dimension: Dimension, which: u32, i: u32) -> Vec2 {
        let key = self.key.at(self.depth, dimension).branch(which);
        match self.paired {
            None => plan.point_2d(i, key),
            Some(s) => plan.padded_2d(s, key),
        }
    }

    /// Point `i` of `count` of an integral over the unit interval.
    pub fn point_1d(&self, plan: SampleSet, dimension: Dimension, i: u32) -> f32 {
        let key = self.key.at(self.depth, dimension);
        match self.paired {
            None => plan.point_1d(i, key),
            Some(s) => plan.padded_1d(s, key),
        }
    }

    /// The place inside point `i` of an integral, which has the number `which` here.
    pub fn within(&self, which: u32, i: u32) -> Self {
        let key = self.key.branch(which);
        Self { key: if self.paired.is_some() { key } else { key.branch(i) }, ..*self }
    }

    /// The same place with a different key, if the points of `effect` are to be drawn anew.
    pub fn again(&self, effect: Effect, again: Option<Effect>) -> Self {
        if again == Some(effect) { Self { key: self.key.branch(AGAIN), ..*self } } else { *self }
    }

    /// The place where ray `i` from here arrives; `smooth`: the ray belongs to a smooth lobe, which has only one.
    pub fn next(&self, which: u32, i: u32, smooth: bool) -> Self {
        Self { depth: self.depth + 1, smooth: self.smooth && smooth, ..self.within(which, i) }
    }

    /// Key for the alpha test of a ray, distinct for every ray.
    pub fn ray_key(&self, dimension: Dimension, which: u32, i: u32) -> Key {
        let key = self.key.at(self.depth, dimension).branch(which);
        key.branch(self.paired.unwrap_or(i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: SampleSet = SampleSet { nx: 2, ny: 2, pattern: Pattern::Stratified };

    fn top(combine: Combine, s: u32) -> Place {
        Place::new(combine, Key::pixel(3, 5, 7), s)
    }

    /// The first points at this place of two integrals of one name, and of one of another name.
    fn first_points(place: Place) -> [Vec2; 3] {
        [(Dimension::LightPoint, 0), (Dimension::LightPoint, 1), (Dimension::Direction, 0)]
            .map(|(dimension, which)| place.point_2d(PLAN, dimension, which, 0))
    }

    #[test]
    fn nested_no_two_integrals_share_points() {
        let place = top(Combine::Nested, 0);
        let places = [
            place,
            top(Combine::Nested, 1),
            place.within(0, 0),
            place.within(0, 1),
            place.within(1, 0),
            place.next(0, 0, false),
            place.next(0, 1, false),
            place.next(1, 0, false),
            place.next(0, 0, false).next(0, 0, false),
            place.next(0, 1, false).next(0, 0, false),
        ];
        let points: Vec<Vec2> = places.into_iter().flat_map(first_points).collect();
        for (i, a) in points.iter().enumerate() {
            assert!(points[..i].iter().all(|b| a != b), "{i}");
        }
    }

    /// Over the pixel samples an integral visits each stratum once, and no two integrals in the same order.
    #[test]
    fn paired_every_integral_visits_its_strata_in_an_order_of_its_own() {
        let plan = SampleSet::new(64, Pattern::Stratified);
        let cell = |p: Vec2| (p.x * 8.0) as u32 + 8 * (p.y * 8.0) as u32;
        let order = |dimension, which, deeper: bool| -> Vec<u32> {
            let place =
                |s| if deeper { top(Combine::Paired, s).next(0, 0, false) } else { top(Combine::Paired, s) };
            (0..64).map(|s| cell(place(s).point_2d(plan, dimension, which, 0))).collect()
        };
        let line = |s| (top(Combine::Paired, s).point_1d(plan, Dimension::Time, 0) * 64.0) as u32;
        let orders = [
            order(Dimension::Pixel, 0, false),
            order(Dimension::Lens, 0, false),
            order(Dimension::LightPoint, 0, false),
            order(Dimension::LightPoint, 1, false),
            order(Dimension::LightPoint, 0, true),
            (0..64).map(line).collect(),
        ];
        for (i, a) in orders.iter().enumerate() {
            let mut sorted = a.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..64).collect::<Vec<_>>(), "{i}");
            assert_ne!(*a, sorted, "{i} goes straight through");
            // Two random orders agree in one position on average.
            let met = |b: &[u32]| a.iter().zip(b).filter(|(x, y)| x == y).count();
            assert!(orders[..i].iter().all(|b| met(b) < 9), "{i}");
        }
    }

    /// Otherwise all trees under a grid would sample the same direction, and the image would not converge to the
    /// correct result.
    #[test]
    fn a_lone_grid_point_below_the_first_hit_is_a_random_one() {
        let scene = dapple_scene::builtin::builtin("cornell").unwrap().build().unwrap();
        let mut settings = Settings::distribution();
        settings.plans.light = SampleSet::new(9, Pattern::Grid);
        settings.plans.diffuse = SampleSet::new(4, Pattern::Sobol);
        let integrals = |secondary, combine| {
            let settings = settings
                .clone()
                .with_distribution(|d| d.combine = combine)
                .with_distribution(|d| d.secondary = secondary);
            Integrals::new(&scene, &scene.cameras[0].camera, &settings)
        };
        let nested = integrals(1, Combine::Nested);
        assert_eq!(nested.at(0).light, SampleSet::new(9, Pattern::Grid));
        assert_eq!(nested.at(1).light, SampleSet::new(1, Pattern::Random));
        assert_eq!(nested.at(2).diffuse, SampleSet::new(1, Pattern::Sobol));
        assert_eq!(integrals(4, Combine::Nested).at(1).light, SampleSet::new(4, Pattern::Grid));
        assert_eq!(integrals(1, Combine::Paired).at(1).light, SampleSet::new(16, Pattern::Grid));
    }
}
