//! Convergence studies: the error of several methods against time, each with confidence intervals over seeds.
//!
//! A [`Run`] is a method with its settings, a [`Reference`] the image that errors are measured against. [`measure`]
//! renders one seed of one run and returns its errors at increasing sample counts. [`Clock`] divides the time: the
//! reference comes first, then one seed after the other of every run, so that the finished part is a fair comparison
//! whenever time runs out.
//!
//! Seeds are independent. The sample counts of a run are determined by its first seed and reused for the others. A
//! curve ends before the sample counts whose squared error would be below that of the reference.

mod clock;
mod difference;
mod measure;
mod reference;
mod run;

pub use clock::{Clock, allowance};
pub use difference::{Apart, apart};
pub use measure::{Allowance, Measurement, measure};
pub use reference::Reference;
pub use run::Run;
