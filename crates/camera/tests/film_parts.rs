//! Films of parts of the samples merge to the bits of one film with all of them.
use dapple_camera::{Film, FilmMismatch, SampleSums};
use dapple_math::PixelRect;
use dapple_testkit::Rng;
use glam::Vec3;
use std::ops::Range;

const RECT: PixelRect = PixelRect { x0: 3, y0: 5, x1: 7, y1: 8 };

fn sample(x: u32, y: u32, i: u64) -> Vec3 {
    let mut rng = Rng::new(i * 1000 + u64::from(31 * x + y));
    Vec3::new(rng.f32(), 1e6 + rng.f32(), if rng.f32() < 0.02 { 1e5 } else { 0.0 })
}

/// A film of the samples of a range, which may differ from pixel to pixel.
fn part(samples: impl Fn(u32, u32) -> Range<u64>) -> Film {
    let mut film = Film::starting_at(RECT, |x, y| samples(x, y).start);
    for y in RECT.y0..RECT.y1 {
        for x in RECT.x0..RECT.x1 {
            samples(x, y).for_each(|i| assert!(film.add(x, y, sample(x, y, i), 1.0)));
        }
    }
    film
}

#[test]
fn parts_have_the_bits_of_the_whole() {
    let mut rng = Rng::new(1);
    let mut below = |n: u64| (rng.f64() * n as f64) as u64;
    for _ in 0..60 {
        let (first, n) = (below(2) * below(100), 1 + below(300));
        let mut cuts: Vec<u64> = (0..below(5)).map(|_| first + below(n)).collect();
        cuts.extend([first, first + n]);
        cuts.sort_unstable();
        // With a sample allocation, pixels have more or fewer samples.
        let adaptive = below(2) * 3;
        let shift = |x, y, s: u64| s + s / 7 * u64::from(x + y) * adaptive / 3;
        let of = |from, to| part(|x, y| shift(x, y, from)..shift(x, y, to));
        let whole = of(first, first + n);
        let mut parts: Vec<Film> = cuts.windows(2).map(|cut| of(cut[0], cut[1])).collect();
        while parts.len() > 1 {
            let i = below(parts.len() as u64 - 1) as usize;
            let (later, is_behind) = (parts.remove(i + 1), below(2) == 0);
            let (mut a, b) = if is_behind { (parts[i].clone(), later) } else { (later, parts[i].clone()) };
            a.merge(&b).unwrap();
            parts[i] = a;
        }
        assert_eq!(parts[0], whole, "{cuts:?}");
        assert_eq!(parts[0].mean(), whole.mean());
        for (x, y) in [(3, 5), (6, 7)] {
            let mut sums = SampleSums::default();
            let at = |i| sums.add(i, sample(x, y, i).as_dvec3()).unwrap();
            (shift(x, y, first)..shift(x, y, first + n)).for_each(at);
            assert_eq!((whole.sums_at(x, y), whole.mean_at(x, y)), (sums.clone(), sums.finish().1.mean));
        }
    }
}

/// The differences of pairs of samples are found once, whether the samples are in one film or not, and every other
/// sample is unpaired.
#[test]
fn pairs_are_measured_once() {
    let measured = |range: Range<u64>, squares: &mut Vec<f64>| {
        let mut film = Film::starting_at(RECT, |_, _| range.start);
        for i in range {
            squares.push(film.add_measured(3, 5, sample(3, 5, i), 1.0).1);
        }
        film
    };
    let (mut of_whole, mut of_parts) = (Vec::new(), Vec::new());
    let whole = measured(1..40, &mut of_whole);
    let mut parts = measured(1..7, &mut of_parts);
    assert_eq!(parts.unpaired().count(), 2);
    for range in [7..8, 8..15, 15..40] {
        let more = measured(range, &mut of_parts);
        parts.merge_measured(&more, |squared| of_parts.push(squared)).unwrap();
    }
    for squares in [&mut of_whole, &mut of_parts] {
        squares.retain(|squared| *squared > 0.0);
        squares.sort_by(f64::total_cmp);
    }
    assert_eq!(of_whole.len(), 19);
    assert_eq!(of_whole, of_parts);
    let alone: Vec<f64> = whole.unpaired().collect();
    let deviation = sample(3, 5, 1).as_dvec3() - whole.mean_at(3, 5);
    assert_eq!(alone, [deviation.length_squared()]);
}

#[test]
fn only_adjoining_samples_merge() {
    let mut film = part(|_, _| 3..7);
    let before = film.clone();
    for range in [0..2, 0..4, 4..9, 8..9, 3..7] {
        let found = film.merge(&part(|_, _| range.clone())).unwrap_err();
        assert_eq!(found, FilmMismatch::Samples { ours: 3..7, theirs: range });
    }
    let other = PixelRect { x0: 0, ..RECT };
    let found = film.merge(&Film::new(other)).unwrap_err();
    assert_eq!(found, FilmMismatch::Rect { ours: RECT, theirs: other });
    film.merge(&Film::new(RECT)).unwrap();
    assert_eq!(film, before);
    let mut empty = Film::new(RECT);
    empty.merge(&film).unwrap();
    assert_eq!(empty, film);
}

/// A power of two of samples takes 56 bytes per pixel.
#[test]
fn memory_of_a_pixel() {
    for (n, nodes) in [(64, 1), (63, 6), (65, 2), (96, 2)] {
        let mut film = part(|_, _| 0..n);
        film.trim();
        assert_eq!(film.bytes(), RECT.area() * (8 + 48 * nodes), "{n}");
    }
}
