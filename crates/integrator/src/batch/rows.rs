//! Rows of a batch: paths between vertices, their vertices, shadow rays, and the results by place.

use super::columns::{Numbers, ROWS, Vectors, Words};
use super::tilts::Tilts;
use crate::bias_report::{BiasReport, Truncation};
use crate::emission::{CompetingStrategy, MisContext};
use crate::first_hit_sums::FirstHit;
use crate::medium::MediumStack;
use crate::observer::PathObserver;
use crate::path::PathState;
use crate::sample::Sample;
use crate::vertex::Vertex;
use dapple_geometry::{Hit, Surface};
use dapple_materials::lanes::Columns;
use dapple_math::Ray;
use dapple_math::lanes::{Framex, Real, Word};
use dapple_sampling::Key;
use glam::Vec3;

/// The ray was scattered by a lobe with a density, which competes with light sampling.
pub(super) const COMPETES: u32 = 1;
/// See [`MisContext::is_seen`].
pub(super) const IS_SEEN: u32 = 2;
/// The path is within bodies or has passed surfaces straight: more of its state is [`Held`].
pub(super) const HOLDS: u32 = 4;

/// Paths between two vertices, each with the ray to the next one. The columns from `p` on are those of [`MisContext`].
pub(super) struct Paths {
    pub len: usize,
    /// Place of the sample in the batch.
    pub place: Words,
    pub key: [Words; 2],
    /// Index of the sample in its set of points.
    pub s: Words,
    pub o: Vectors,
    pub d: Vectors,
    pub beta: Vectors,
    pub eta: Numbers,
    pub p: Vectors,
    pub n: Vectors,
    pub pdf: Numbers,
    pub flags: Words,
    /// End of the ray.
    pub t_max: Numbers,
}

impl Paths {
    pub fn new() -> Self {
        let (words, vectors) = (Words::new, Vectors::new);
        Self {
            len: 0,
            place: words(),
            key: [words(), words()],
            s: words(),
            o: vectors(),
            d: vectors(),
            beta: vectors(),
            eta: Numbers::new(),
            p: vectors(),
            n: vectors(),
            pdf: Numbers::new(),
            flags: words(),
            t_max: Numbers::new(),
        }
    }

    /// The key of the sample of a row.
    pub fn key(&self, i: usize) -> Key {
        Key::from_words([self.key[0].get(i), self.key[1].get(i)])
    }

    /// State of what the MIS weight of emission depends on.
    #[inline(always)]
    pub fn arrival(&self, i: usize, (time, depth): (f32, u32)) -> MisContext {
        let flags = self.flags.get(i);
        let competing = match flags & COMPETES {
            0 => CompetingStrategy::Nothing,
            _ => CompetingStrategy::Choice,
        };
        MisContext {
            p: self.p.get(i),
            n: self.n.get(i),
            pdf: self.pdf.get(i),
            competing,
            lights_are_points: false,
            time,
            is_seen: flags & IS_SEEN != 0,
            gone: 0.0,
            bent: false,
            view: if depth == 0 { f32::INFINITY } else { 0.0 },
        }
    }

    /// State of the path of a row, with the radiance found so far.
    pub fn state(&self, i: usize, at: (f32, u32), (radiance, held): (Vec3, &[Held])) -> PathState {
        let (beta, eta, arrival) = (self.beta.get(i), self.eta.get(i), self.arrival(i, at));
        let mut state = PathState { radiance, beta, eta, arrival, ..PathState::default() };
        if let (true, Some(held)) = (self.holds(i), held.get(self.place.get(i) as usize)) {
            held.give(&mut state);
        }
        state
    }

    /// Whether more of the state of a path is [`Held`].
    pub fn holds(&self, i: usize) -> bool {
        self.flags.get(i) & HOLDS != 0
    }

    /// The ray of a row.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        Ray { o: self.o.get(i), d: self.d.get(i), t_max: self.t_max.get(i) }
    }

    /// Sets the numbers of the sample at `place`, before its camera ray is known.
    pub fn start(&mut self, place: usize, sample: &Sample) {
        self.place.set(place, place as u32);
        let [a, b] = sample.key.words();
        self.key[0].set(place, a);
        self.key[1].set(place, b);
        self.s.set(place, sample.s);
    }

    /// Adds a path in `state`, which continues along `ray`.
    pub fn push(
        &mut self,
        place: usize,
        sample: &Sample,
        (state, ray): (&PathState, &Ray),
        held: &mut [Held],
    ) {
        let i = self.len;
        self.len += 1;
        self.place.set(i, place as u32);
        let [a, b] = sample.key.words();
        self.key[0].set(i, a);
        self.key[1].set(i, b);
        self.s.set(i, sample.s);
        self.o.set(i, ray.o);
        self.d.set(i, ray.d);
        self.beta.set(i, state.beta);
        self.eta.set(i, state.eta);
        let arrival = &state.arrival;
        self.p.set(i, arrival.p);
        self.n.set(i, arrival.n);
        self.pdf.set(i, arrival.pdf);
        let competes = match arrival.competing {
            CompetingStrategy::Choice => COMPETES,
            _ => 0,
        };
        let mut flags = competes | if arrival.is_seen { IS_SEEN } else { 0 };
        if let (true, Some(held)) = (Held::is_needed(state), held.get_mut(place)) {
            *held = Held::of(state);
            flags |= HOLDS;
        }
        self.flags.set(i, flags);
        self.t_max.set(i, ray.t_max);
    }
}

/// The rest of the state of a path, by place: the bodies around it, and what it has passed straight.
#[derive(Clone, Copy)]
pub(super) struct Held {
    stack: MediumStack,
    gone: f32,
    bent: bool,
    view: f32,
}

impl Held {
    pub const NOTHING: Self = Self { stack: MediumStack::EMPTY, gone: 0.0, bent: false, view: 0.0 };

    fn of(state: &PathState) -> Self {
        let MisContext { gone, bent, view, .. } = state.arrival;
        Self { stack: state.stack, gone, bent, view }
    }

    fn is_needed(state: &PathState) -> bool {
        let MisContext { gone, bent, view, .. } = state.arrival;
        !state.stack.is_empty() || gone != 0.0 || bent || view > 0.0
    }

    fn give(&self, state: &mut PathState) {
        state.stack = self.stack;
        state.arrival = MisContext { gone: self.gone, bent: self.bent, view: self.view, ..state.arrival };
    }
}

/// Nearest hits of rays.
pub(super) struct Hits {
    pub t: Numbers,
    pub u: Numbers,
    pub v: Numbers,
    pub primitive: Words,
    /// `u32::MAX` where nothing is hit.
    pub object: Words,
}

impl Hits {
    pub fn new() -> Self {
        let (words, numbers) = (Words::new, Numbers::new);
        Self { t: numbers(), u: numbers(), v: numbers(), primitive: words(), object: words() }
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, hit: Option<Hit>) {
        let Some(hit) = hit else { return self.object.set(i, u32::MAX) };
        self.t.set(i, hit.t);
        self.u.set(i, hit.u);
        self.v.set(i, hit.v);
        self.primitive.set(i, hit.primitive);
        self.object.set(i, hit.object);
    }

    pub fn get(&self, i: usize) -> Option<Hit> {
        let object = self.object.get(i);
        let (primitive, t) = (self.primitive.get(i), self.t.get(i));
        (object != u32::MAX).then(|| Hit { t, u: self.u.get(i), v: self.v.get(i), primitive, object })
    }
}

/// A list of rows.
pub(super) struct Rows {
    pub len: usize,
    pub row: Words,
}

impl Rows {
    pub fn new() -> Self {
        Self { len: 0, row: Words::new() }
    }

    /// Adds the rows of the lanes of `mask` from row `i` on.
    #[inline(always)]
    pub fn pack<W: Word>(&mut self, i: usize, mask: W::Mask) {
        let rows = W::splat(i as u32).wrapping_add(W::lane_index());
        self.len += self.row.pack(self.len, mask, rows);
    }
}

/// Vertices, by the rows of the paths that arrive there.
pub(super) struct Vertices {
    /// 1 where lanes scatter the path, else 0.
    pub live: Words,
    /// 1 where lanes have computed the surface, else 0.
    pub known: Words,
    /// The rows that are computed one by one.
    pub odd: Rows,
    /// The rows of plain paths that leave the scene, if it has an environment.
    pub escaped: Rows,
    pub p: Vectors,
    pub start: Vectors,
    pub p_error: Vectors,
    pub ng: Vectors,
    /// Shading frame.
    pub frame: [Vectors; 3],
    pub tilts: Tilts,
    pub materials: Columns,
}

impl Vertices {
    pub fn new() -> Self {
        let vectors = Vectors::new;
        Self {
            live: Words::new(),
            known: Words::new(),
            odd: Rows::new(),
            escaped: Rows::new(),
            p: vectors(),
            start: vectors(),
            p_error: vectors(),
            ng: vectors(),
            frame: [vectors(), vectors(), vectors()],
            tilts: Tilts::new(),
            materials: Columns::new(ROWS),
        }
    }

    /// Lists all of `n` rows to be computed one by one.
    pub fn all_odd(&mut self, n: usize) {
        (self.odd.len, self.escaped.len) = (0, 0);
        for i in 0..n {
            self.live.set(i, 0);
            self.known.set(i, 0);
            self.odd.pack::<u32>(i, true);
        }
    }

    /// The surface of a row, if lanes have computed it.
    #[inline(always)]
    pub fn surface(&self, i: usize) -> Option<Surface> {
        (self.known.get(i) == 1).then(|| Surface {
            p: self.p.get(i),
            start: self.start.get(i),
            p_error: self.p_error.get(i),
            ng: self.ng.get(i),
            ns: self.frame[2].get(i),
        })
    }

    #[inline(always)]
    pub fn store_frame<R: Real>(&mut self, i: usize, frame: &Framex<R>) {
        let [x, y, z] = &mut self.frame;
        x.store(i, frame.x);
        y.store(i, frame.y);
        z.store(i, frame.z);
    }
}

/// Shadow rays, each with the light that arrives if nothing occludes it.
pub(super) struct Shadows {
    pub len: usize,
    pub place: Words,
    /// Row of the path.
    pub row: Words,
    pub o: Vectors,
    pub d: Vectors,
    /// End of the ray; negative where the light is not a number, so that no ray is needed.
    pub t_max: Numbers,
    pub light: Vectors,
}

impl Shadows {
    pub fn new() -> Self {
        let vectors = Vectors::new;
        Self {
            len: 0,
            place: Words::new(),
            row: Words::new(),
            o: vectors(),
            d: vectors(),
            t_max: Numbers::new(),
            light: vectors(),
        }
    }
}

/// Result of one sample.
#[derive(Clone, Copy, Default)]
pub(super) struct Result {
    pub radiance: Vec3,
    pub rays: u32,
}

/// Truncated paths, by place.
#[derive(Default)]
pub(super) struct Cuts(Vec<(u32, Truncation, Vec3)>);

impl Cuts {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    pub fn add(&mut self, place: usize, why: Truncation, beta: Vec3) {
        self.0.push((place as u32, why, beta));
    }

    /// Sorts by place. The truncations of a path keep their order.
    pub fn sort(&mut self) {
        self.0.sort_by_key(|cut| cut.0);
    }

    /// The report of a sample; places must be asked for in order, with `from` starting at 0.
    pub fn report(&self, place: usize, from: &mut usize) -> BiasReport {
        let mut report = BiasReport::default();
        while let Some(&(at, why, beta)) = self.0.get(*from).filter(|cut| cut.0 as usize == place) {
            debug_assert_eq!(at as usize, place);
            report.cut(why, beta);
            *from += 1;
        }
        report
    }
}

/// Observes one path.
pub(super) struct Watch<'a> {
    pub cuts: &'a mut Cuts,
    pub place: usize,
    /// Its first hit, if that is asked for.
    pub first: Option<&'a mut FirstHit>,
}

impl PathObserver for Watch<'_> {
    fn vertex(&mut self, depth: u32, vertex: &Vertex, beta: Vec3, emitted: Vec3) {
        if let Some(first) = &mut self.first {
            first.vertex(depth, vertex, beta, emitted);
        }
    }

    fn escaped(&mut self, depth: u32, beta: Vec3, radiance: Vec3, d: Vec3) {
        if let Some(first) = &mut self.first {
            first.escaped(depth, beta, radiance, d);
        }
    }

    fn hides_backdrop(&self) -> bool {
        self.first.as_ref().is_some_and(|first| first.hides_backdrop())
    }

    fn cut(&mut self, why: Truncation, beta: Vec3) {
        self.cuts.add(self.place, why, beta);
    }
}
