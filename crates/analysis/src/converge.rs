//! How much error is left after how many seconds, with which method, and how sure is that?
//!
//! A [`Run`] is a method with its settings; [`Reference`] what its pictures should be; [`measure`] one seed of one run:
//! errors at growing sample counts. [`Clock`] shares the seconds out: reference first, then seed after seed of every
//! run, so that whatever is finished when time is up is a fair comparison.
//!
//! Seeds are independent. The counts of a run are found with its first seed and kept for the others. A curve ends
//! before the counts whose squared error would be below the reference's own.

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
