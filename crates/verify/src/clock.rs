//! Ratio of the run times of two functions.

use std::hint::black_box;
use std::time::Instant;

/// Time of `a` divided by that of `b`: the shortest of seven runs each, taken in turn, so that other load on the
/// machine affects both.
pub(crate) fn ratio<T>(a: impl Fn() -> T, b: impl Fn() -> T) -> f64 {
    let mut least = [f64::INFINITY; 2];
    for _ in 0..7 {
        let start = Instant::now();
        black_box(a());
        let between = Instant::now();
        black_box(b());
        least[0] = least[0].min((between - start).as_secs_f64());
        least[1] = least[1].min(between.elapsed().as_secs_f64());
    }
    least[0] / least[1].max(1e-9)
}

#[cfg(test)]
mod tests {
    #[test]
    fn ten_times_the_work_takes_longer() {
        let work = |n: u64| {
            move || (0..n).fold(0u64, |a, i| a.wrapping_mul(31).wrapping_add(std::hint::black_box(i)))
        };
        let ratio = super::ratio(work(4_000_000), work(400_000));
        assert!(ratio > 3.0, "{ratio}");
    }
}
