//! How large is the error of a picture, by its own account?
//!
//! The error is the relative RMSE of the whole picture: the root of the expected squared error, mean over pixels and
//! channels, divided by the mean radiance. One number over all pixels can be known well although each pixel's own
//! variance cannot.
//!
//! - [`within`]: for independent samples their variance within each pixel is the answer, at no cost. Points that are
//!   spread evenly have errors far below it.
//! - [`replicate`]: whatever the points, half the squared difference of two independent renders is their variance. So a
//!   few pixels of the finished picture are rendered once more with another seed.
//! - [`Doublings`]: a guess while the render runs, at no cost, where the first half of its points is such a set itself
//!   (independent points, Sobol points from 16 on, sets that are repeated while there is time). With D_k the change of
//!   the picture from n_{k−1} = n_k/2 to n_k samples, both halves alike: E D_k² = V_{k−1} − V_k, so that the error left
//!   is the sum of all changes to come, V_k = D²_{k+1} + D²_{k+2} + … Independent points have V ∝ 1/n, hence V_k = D_k².
//!   For Sobol points the ratio of changes is measured. *Approximation*: that they go on falling as they did.
//!
//! What no sample has seen cannot be in an estimate. [`unseen`] bounds it by what the scene can hold, and [`Verdict`]
//! says whether the bound can be relied on.

pub(crate) mod blocks;
mod doublings;
mod replicate;
mod unseen;
mod verdict;
mod within;

pub use doublings::Doublings;
pub use replicate::{replicate, replicate_until, replicated_share};
pub use unseen::{Hidden, Unseen, unseen};
pub use verdict::{SHARE, Verdict};
pub use within::{Estimate, Way, within};
