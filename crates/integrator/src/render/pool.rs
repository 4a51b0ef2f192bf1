//! Worker threads of a render.

use crate::settings::Limits;
use crate::tile::Tile;

/// Stack size of a worker thread, in bytes: several times what a ray tree needs even without optimisation; only the
/// used part is committed.
#[cfg(feature = "parallel")]
const STACK: usize = 8 << 20;

/// Worker threads, created once per render.
pub(crate) struct Pool {
    /// `None` for a single thread.
    #[cfg(feature = "parallel")]
    pool: Option<rayon::ThreadPool>,
    threads: usize,
}

impl Pool {
    /// Creates as many threads as the limits allow.
    #[cfg(feature = "parallel")]
    pub fn new(limits: &Limits) -> Self {
        let granted = || std::thread::available_parallelism().map_or(1, Into::into);
        let threads = limits.threads.unwrap_or_else(granted).max(1);
        let build = || rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build().ok();
        Self { pool: if threads > 1 { build() } else { None }, threads }
    }

    /// A single thread, as this build has no thread pool.
    #[cfg(not(feature = "parallel"))]
    pub fn new(_: &Limits) -> Self {
        Self { threads: 1 }
    }

    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Calls `work` for every tile, on all threads.
    #[cfg(feature = "parallel")]
    pub fn each_tile(&self, tiles: &mut [Tile], work: impl Fn(&mut Tile) + Sync + Send) {
        use rayon::prelude::*;
        match &self.pool {
            Some(pool) => pool.install(|| tiles.par_iter_mut().with_max_len(1).for_each(work)),
            None => tiles.iter_mut().for_each(work),
        }
    }

    /// Calls `work` for every tile.
    #[cfg(not(feature = "parallel"))]
    pub fn each_tile(&self, tiles: &mut [Tile], work: impl Fn(&mut Tile)) {
        tiles.iter_mut().for_each(work);
    }
}
