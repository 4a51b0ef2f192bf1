//! Error estimates of a render without a reference.
//!
//! The error is the relative RMSE of the whole image: the root of the expected squared error, averaged over pixels and
//! channels, divided by the mean radiance. This single number over all pixels can be estimated well although the
//! variance of each pixel cannot.
//!
//! - [`within`]: the variance of independent samples within each pixel is the squared error, at no extra cost. The
//!   error of evenly distributed points is far below it.
//! - [`replicate`]: for any points, half the squared difference of two independent renders estimates the variance. A
//!   few pixels of the finished image are therefore rendered again with another seed.
//! - [`Doublings`]: a prediction during rendering, at no extra cost, for patterns whose first half is a complete point
//!   set itself (independent points, Sobol points from 16 on, sets that are repeated while time remains). With D_k the
//!   change of the image from n_{k−1} = n_k/2 to n_k samples, both halves being equivalent: E D_k² = V_{k−1} − V_k, so
//!   that the remaining error is the sum of all future changes, V_k = D²_{k+1} + D²_{k+2} + … Independent points have V
//!   ∝ 1/n, hence V_k = D_k². For Sobol points the ratio of changes is measured. *Approximation*: the changes continue
//!   to fall at the measured ratio.
//!
//! An estimate cannot contain light that no sample has found. [`unseen`] bounds this light by the radiance that the
//! scene can produce, and [`Verdict`] states whether the bound is reliable.

pub(crate) mod blocks;
mod doublings;
mod replicate;
mod unseen;
mod verdict;
mod within;

pub use doublings::Doublings;
pub use replicate::{Replicates, replicate, replicate_until, replicated, replicated_share, variances};
pub use unseen::{Hidden, Unseen, unseen};
pub use verdict::{SHARE, Verdict};
pub use within::{Estimate, Way, within};
