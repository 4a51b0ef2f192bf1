//! Convergence rates of the distribution tracer: slopes of log MSE over log N for each effect and estimator
//! (docs/science.md, "Convergence rates"), measured with the complete tracer, on scenes with closed forms.
//!
//! Every replica has its own seed and its own random placement of the scene, with its own exact value: the midpoint
//! grid, which is the same everywhere, has a mean error only over placements. The regular tests cover four octaves of
//! N; eight octaves and twice the replicas (`docs/convergence.md` is their table) are
//! `cargo test --release -p dapple-integrator --test convergence -- --ignored --nocapture --test-threads 1`.

#[path = "../common/mod.rs"]
mod common;

mod edges;
mod fit;
mod joint;
mod smooth;
mod study;
