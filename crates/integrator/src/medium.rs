//! Media along a ray: the bodies that contain a point, and the interfaces at their boundaries.
//!
//! Bodies can overlap and contain each other (`dapple_scene::Bodies`). A ray carries the bodies that it has entered and
//! not left, highest priority first; the first one is the current medium. A boundary at which the first body stays the
//! same is hidden inside that body: there is no interface, and the ray continues in the same direction. At all other
//! boundaries light is refracted by the ratio of the indices on both sides.
//!
//! A body is entered once for every boundary that is hit from its front: a second shell within the first has to be left
//! again. Leaving a body that was not entered has no effect on the stack; light is refracted there as if the body had
//! been entered.

use dapple_geometry::{Hit, HitFilter};
use dapple_math::Ray;
use dapple_scene::{Body, Scene};
use glam::Vec3;
use std::cell::RefCell;

/// Maximum number of nested bodies on the stack; beyond it, the body of lowest priority is dropped, and the bias report
/// counts the event.
pub(crate) const DEPTH: usize = 16;

/// The bodies that contain a point, highest priority first; once for each time that they were entered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MediumStack {
    len: u32,
    bodies: [u32; DEPTH],
}

impl MediumStack {
    /// The stack outside of all bodies.
    pub const EMPTY: Self = Self { len: 0, bodies: [0; DEPTH] };

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The body that fills the point.
    pub fn current(&self) -> Option<u32> {
        (self.len > 0).then_some(self.bodies[0])
    }

    /// Index of refraction; 1 outside of all bodies, and where it is unknown.
    pub fn ior(&self, bodies: &[Body]) -> f32 {
        self.current().map(|body| bodies[body as usize].ior).filter(|ior| *ior > 0.0).unwrap_or(1.0)
    }

    #[cfg(test)]
    fn contains(&self, body: u32) -> bool {
        self.bodies[..self.len as usize].contains(&body)
    }

    /// Adds a body; returns false if a body was dropped.
    fn enter(&mut self, body: u32) -> bool {
        let len = self.len as usize;
        let at = self.bodies[..len].partition_point(|&b| b <= body);
        if at == DEPTH {
            return false;
        }
        self.bodies.copy_within(at..len.min(DEPTH - 1), at + 1);
        self.bodies[at] = body;
        self.len = (self.len + 1).min(DEPTH as u32);
        len < DEPTH
    }

    /// Removes a body, once; returns false if it is not on the stack.
    fn leave(&mut self, body: u32) -> bool {
        let len = self.len as usize;
        let Some(at) = self.bodies[..len].iter().position(|&b| b == body) else { return false };
        self.bodies.copy_within(at + 1..len, at);
        self.len -= 1;
        true
    }

    /// Transmittance after `distance` in the medium: exp(−σ_a·s) per channel (Beer–Lambert), 1 for channels without
    /// absorption. A body that a ray leaves without hitting its boundary is not closed; its extent is unknown, and an
    /// infinite distance is taken to lead outside.
    pub fn transmittance(&self, bodies: &[Body], distance: f32) -> Vec3 {
        let Some(body) = self.current().map(|body| &bodies[body as usize]) else { return Vec3::ONE };
        if distance == f32::INFINITY {
            return Vec3::ONE;
        }
        let along = |s: f32| if s > 0.0 { libm::expf(-s * distance) } else { 1.0 };
        Vec3::new(along(body.sigma_a.x), along(body.sigma_a.y), along(body.sigma_a.z))
    }
}

/// One boundary of a body, or several coincident ones, hit by a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boundary {
    /// The bodies on the far side.
    pub after: MediumStack,
    /// The bodies on the near side: those that the ray carried, and those that it leaves without having entered them.
    before: MediumStack,
    /// A body was dropped from a full stack.
    pub overflows: bool,
}

impl Boundary {
    pub fn new(around: &MediumStack) -> Self {
        Self { after: *around, before: *around, overflows: false }
    }

    /// Crosses the surface of `body`, from outside or from inside.
    pub fn cross(&mut self, body: u32, from_outside: bool) {
        if from_outside {
            self.overflows |= !self.after.enter(body);
        } else if !self.after.leave(body) {
            self.before.enter(body);
        }
    }

    /// Whether the medium is the same on both sides.
    pub fn is_hidden(&self) -> bool {
        self.before.current() == self.after.current()
    }

    /// Index of refraction of the back of a surface over that of its front; `from_front`: the ray hits the front.
    /// `None` where one of them is unknown.
    pub fn ior(&self, bodies: &[Body], from_front: bool) -> Option<f32> {
        let ior = |stack: &MediumStack| stack.current().map_or(1.0, |body| bodies[body as usize].ior);
        let (near, far) = (ior(&self.before), ior(&self.after));
        (near > 0.0 && far > 0.0).then(|| if from_front { far / near } else { near / far })
    }
}

/// Media at the origins of camera rays.
#[derive(Clone, Copy, Debug)]
enum Start {
    /// The same for all camera rays.
    Known(MediumStack),
    /// Computed for each ray.
    PerRay,
}

/// Media of a scene, as used by a render.
#[derive(Clone, Debug)]
pub(crate) struct Media<'a> {
    /// Highest priority first; empty if media are left out.
    pub bodies: &'a [Body],
    start: Start,
}

/// Directions in which the boundaries around a point are counted. They are not aligned with an axis or a diagonal, and
/// an odd number of them takes a majority vote: a ray through an edge counts both adjacent triangles.
const DIRECTIONS: [Vec3; 3] =
    [Vec3::new(0.356, 0.729, 0.585), Vec3::new(-0.812, 0.223, -0.539), Vec3::new(0.471, -0.618, -0.63)];

impl<'a> Media<'a> {
    /// `still`: the common origin of all camera rays at all times, if there is one.
    pub fn new(scene: &'a Scene, still: Option<Vec3>) -> Self {
        let bodies = if cfg!(without = "medium") { &[] } else { &scene.bodies.all[..] };
        let start = match still {
            _ if bodies.is_empty() => Start::Known(MediumStack::EMPTY),
            Some(p) => Start::Known(around(scene, p, 0.0)),
            None => Start::PerRay,
        };
        Self { bodies, start }
    }

    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Whether all camera rays start outside of all bodies.
    pub fn starts_outside(&self) -> bool {
        matches!(self.start, Start::Known(stack) if stack.is_empty())
    }

    /// The bodies around the origin of a camera ray.
    #[inline]
    pub fn at(&self, scene: &Scene, ray: &Ray, time: f32) -> MediumStack {
        match self.start {
            Start::Known(stack) => stack,
            Start::PerRay => self.around(scene, ray.o, time),
        }
    }

    /// The bodies around a point.
    pub fn around(&self, scene: &Scene, p: Vec3, time: f32) -> MediumStack {
        if self.is_empty() { MediumStack::EMPTY } else { around(scene, p, time) }
    }
}

/// The bodies around a point at a time: those whose boundaries a ray from the point leaves more often than it enters
/// them.
#[cold]
fn around(scene: &Scene, p: Vec3, time: f32) -> MediumStack {
    let mut stack = MediumStack::EMPTY;
    let is_near = |(lo, hi): (Vec3, Vec3)| p.cmpge(lo).all() && p.cmple(hi).all();
    if !scene.bodies.bounds.is_some_and(is_near) {
        return stack;
    }
    let counts = DIRECTIONS.map(|d| crossings(scene, p, d, time));
    let mut all: Vec<u32> = counts.iter().flatten().map(|(body, _)| *body).collect();
    all.sort_unstable();
    all.dedup();
    for body in all {
        let of = |counts: &Vec<(u32, i32)>| counts.iter().find(|(b, _)| *b == body).map_or(0, |(_, n)| *n);
        let mut votes = [of(&counts[0]), of(&counts[1]), of(&counts[2])];
        votes.sort_unstable();
        for _ in 0..votes[1].clamp(0, DEPTH as i32) {
            stack.enter(body);
        }
    }
    stack
}

/// For each body, in no particular order, how many more times the half-line from `p` along `d` leaves it than enters
/// it.
fn crossings(scene: &Scene, p: Vec3, d: Vec3, time: f32) -> Vec<(u32, i32)> {
    struct Count<'a> {
        scene: &'a Scene,
        ray: Ray,
        time: f32,
        counts: RefCell<Vec<(u32, i32)>>,
    }
    impl HitFilter<Hit> for Count<'_> {
        const OPAQUE: bool = false;
        fn accept(&self, hit: &Hit) -> bool {
            let body = self.scene.objects[hit.object as usize].body;
            if body != u32::MAX {
                let leaves = self.scene.accel.surface(&self.ray, self.time, hit).ng.dot(self.ray.d) > 0.0;
                let (mut counts, by) = (self.counts.borrow_mut(), if leaves { 1 } else { -1 });
                match counts.iter_mut().find(|(b, _)| *b == body) {
                    Some((_, count)) => *count += by,
                    None => counts.push((body, by)),
                }
            }
            false
        }
    }
    let ray = Ray::new(p, d);
    let count = Count { scene, ray, time, counts: RefCell::default() };
    scene.accel.occluded(&ray, time, &count);
    count.counts.into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stack(bodies: &[u32]) -> MediumStack {
        let mut stack = MediumStack::EMPTY;
        bodies.iter().for_each(|&b| assert!(stack.enter(b)));
        stack
    }

    fn seen(stack: &MediumStack) -> &[u32] {
        &stack.bodies[..stack.len as usize]
    }

    #[test]
    fn light_falls_off_by_beer_and_lambert() {
        let bodies = [Body { ior: 1.0, sigma_a: Vec3::new(0.0, 0.5, 2.0) }];
        let expected = Vec3::new(1.0, (-1.5f32).exp(), (-6.0f32).exp());
        assert!((stack(&[0]).transmittance(&bodies, 3.0) - expected).abs().max_element() < 1e-6);
        assert_eq!(MediumStack::EMPTY.transmittance(&bodies, 3.0), Vec3::ONE);
        assert_eq!(stack(&[0]).transmittance(&bodies, f32::INFINITY), Vec3::ONE);
    }

    #[test]
    fn the_strongest_body_is_the_medium_in_whatever_order_bodies_are_entered_and_left() {
        for order in [[3, 1, 2], [1, 2, 3], [2, 3, 1]] {
            assert_eq!(seen(&stack(&order)), [1, 2, 3]);
        }
        let mut twice = stack(&[4, 2, 4]);
        assert!(twice.leave(4) && twice.contains(4) && twice.leave(4) && !twice.leave(4));
        assert_eq!(seen(&twice), [2]);
    }

    #[test]
    fn what_does_not_fit_is_the_weakest() {
        let mut full = stack(&(10..10 + DEPTH as u32).collect::<Vec<_>>());
        assert!(!full.enter(50) && !full.contains(50));
        assert!(!full.enter(3) && full.current() == Some(3) && !full.contains(9 + DEPTH as u32));
        assert_eq!(seen(&full).len(), DEPTH);
    }

    #[test]
    fn a_boundary_inside_a_stronger_body_is_none_in_both_directions() {
        let meet = |around: &[u32], body, from_outside| {
            let mut boundary = Boundary::new(&stack(around));
            boundary.cross(body, from_outside);
            boundary
        };
        assert!(meet(&[0], 1, true).is_hidden() && meet(&[0, 1], 1, false).is_hidden());
        assert!(!meet(&[1], 0, true).is_hidden() && !meet(&[0, 1], 0, false).is_hidden());
        // A second shell of the same body.
        assert!(meet(&[1], 1, true).is_hidden() && meet(&[1, 1], 1, false).is_hidden());
        // Not entered: refracted as if it had been, unless it lies in a body of higher priority.
        let bodies = [1.5, 1.2].map(|ior| Body { ior, sigma_a: Vec3::ZERO });
        let unknown = meet(&[], 0, false);
        assert!(!unknown.is_hidden() && unknown.after.is_empty());
        assert_eq!(unknown.ior(&bodies, false), Some(1.5));
        assert!(meet(&[0], 1, false).is_hidden());
        assert_eq!(meet(&[1], 0, true).ior(&bodies, true), Some(1.5 / 1.2));
        assert_eq!(meet(&[0, 1], 0, false).ior(&bodies, false), Some(1.5 / 1.2));
        // Two bodies that touch: the ray leaves one and enters the other at the same point.
        let mut both = meet(&[1], 1, false);
        both.cross(0, true);
        assert_eq!((both.ior(&bodies, true), both.after.current()), (Some(1.5 / 1.2), Some(0)));
    }
}
