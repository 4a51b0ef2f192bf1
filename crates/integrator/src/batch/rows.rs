//! Rows of a batch: paths between vertices, their vertices, shadow rays, and the results by place.

use super::columns::{Numbers, ROWS, Vectors, Words};
use crate::bias_report::{BiasReport, Truncation};
use crate::emission::{CompetingStrategy, MisContext};
use crate::observer::PathObserver;
use crate::path::PathState;
use crate::sample::Sample;
use dapple_materials::lanes::Columns;
use dapple_math::Ray;
use dapple_sampling::Key;
use glam::Vec3;

/// The ray was scattered by a lobe with a density, which competes with light sampling.
pub(super) const COMPETES: u32 = 1;
/// See [`MisContext::is_seen`].
pub(super) const IS_SEEN: u32 = 2;

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
    pub fn state(&self, i: usize, at: (f32, u32), radiance: Vec3) -> PathState {
        let (beta, eta, arrival) = (self.beta.get(i), self.eta.get(i), self.arrival(i, at));
        PathState { radiance, beta, eta, arrival, ..PathState::default() }
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
    pub fn push(&mut self, place: usize, sample: &Sample, state: &PathState, ray: &Ray) {
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
        self.flags.set(i, competes | if arrival.is_seen { IS_SEEN } else { 0 });
    }
}

/// Vertices, by the rows of the paths that arrive there.
pub(super) struct Vertices {
    /// 1 where lanes scatter the path, else 0.
    pub live: Words,
    pub p: Vectors,
    pub start: Vectors,
    pub p_error: Vectors,
    pub ng: Vectors,
    /// Shading frame.
    pub frame: [Vectors; 3],
    pub materials: Columns,
}

impl Vertices {
    pub fn new() -> Self {
        let vectors = Vectors::new;
        Self {
            live: Words::new(),
            p: vectors(),
            start: vectors(),
            p_error: vectors(),
            ng: vectors(),
            frame: [vectors(), vectors(), vectors()],
            materials: Columns::new(ROWS),
        }
    }
}

/// Shadow rays, each with the light that arrives if nothing occludes it.
pub(super) struct Shadows {
    pub len: usize,
    pub place: Words,
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

    /// Sorts by place; every path is truncated at most once.
    pub fn sort(&mut self) {
        self.0.sort_unstable_by_key(|cut| cut.0);
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

/// Adds the truncation of one path.
pub(super) struct CutsOf<'a> {
    pub cuts: &'a mut Cuts,
    pub place: usize,
}

impl PathObserver for CutsOf<'_> {
    fn cut(&mut self, why: Truncation, beta: Vec3) {
        self.cuts.add(self.place, why, beta);
    }
}
