//! The share of each effect in the variance, with confidence intervals.

use crate::statistics;
use dapple_integrator::{Effect, Variances};

/// The share of an effect in the variance of one sample.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Share {
    /// Name of the effect, or `holes` for the choice of the surface that a ray hits where surfaces are partly cut out.
    pub effect: String,
    /// The share, 0 to 1.
    pub share: f64,
    /// Ends of the confidence interval of the share.
    pub share_ci: [f64; 2],
}

/// The sum of all variances.
pub(super) fn sum(all: &[Variances]) -> Variances {
    let mut sum = Variances { parts: [0.0; 7], rest: 0.0, mean: 0.0, rays: 0.0, more_rays: [0.0; 7] };
    for one in all {
        sum.parts.iter_mut().zip(one.parts).for_each(|(a, b)| *a += b);
        sum.more_rays.iter_mut().zip(one.more_rays).for_each(|(a, b)| *a += b);
        sum.rest += one.rest;
        sum.rays += one.rays;
    }
    sum
}

pub(super) fn shares(all: &[Variances], present: &[Effect], confidence: f64) -> Vec<Share> {
    let z = reach(all.len(), confidence);
    let share = |name: &str, part: &dyn Fn(&Variances) -> f64| {
        let ratio = |all: &[Variances]| {
            let (part, total): (f64, f64) =
                (all.iter().map(part).sum(), all.iter().map(Variances::total).sum());
            if total > 0.0 { part / total } else { 0.0 }
        };
        let (share, error) = (ratio(all), jackknife(all, &ratio));
        let share_ci = [(share - z * error).max(0.0), (share + z * error).min(1.0)];
        Share { effect: name.into(), share, share_ci }
    };
    let mut shares: Vec<Share> = Effect::ALL
        .iter()
        .enumerate()
        .filter(|(_, (effect, _))| present.contains(effect))
        .map(|(i, (_, name))| share(name, &|v: &Variances| v.parts[i]))
        .collect();
    let rest = share("holes", &|v: &Variances| v.rest);
    shares.extend((rest.share > 0.0).then_some(rest));
    shares
}

/// Number of standard errors from a value to the ends of its interval, if the standard error is estimated from `groups`
/// groups.
pub(super) fn reach(groups: usize, confidence: f64) -> f64 {
    statistics::student(0.5 + 0.5 * confidence, groups.saturating_sub(1).max(1) as f64)
}

/// The standard error of a statistic of independent parts by the jackknife, leaving out one part at a time [Efron
/// 1982].
pub(super) fn jackknife<T: Clone>(all: &[T], statistic: &dyn Fn(&[T]) -> f64) -> f64 {
    let n = all.len() as f64;
    let without = |i: usize| {
        let mut rest = all.to_vec();
        rest.remove(i);
        statistic(&rest)
    };
    let values: Vec<f64> = (0..all.len()).map(without).filter(|v| v.is_finite()).collect();
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    if values.len() < 2 { f64::INFINITY } else { ((n - 1.0) / n * squares).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard error of a mean is s/√n.
    #[test]
    fn leaving_one_out() {
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let found = jackknife(&[1.0, 2.0, 3.0, 6.0], &mean);
        assert!((found - (14.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12, "{found}");
    }
}
