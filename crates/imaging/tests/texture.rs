//! Tests texture lookups against a plain f64 evaluation of the definition.

use dapple_imaging::{Channels, Encoding, Interpolation, Rgba8, Rgba16, Sampler, Texels, Texture, Wrap};
use glam::{DVec4, Vec2, Vec4};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

fn image(width: usize, height: usize) -> Rgba8 {
    let byte = |i: usize, k: usize| ((i * 73 + k * 151 + i * i * 29) % 256) as u8;
    let texels = (0..width * height).map(|i| [byte(i, 0), byte(i, 1), byte(i, 2), byte(i, 3)]).collect();
    Rgba8 { width, height, texels }
}

fn sampler(wrap_s: Wrap, wrap_t: Wrap, interpolation: Interpolation) -> Sampler {
    Sampler { wrap_s, wrap_t, interpolation }
}

/// Texel index by the definition of the wrap mode, for any integer.
fn wrapped(wrap: Wrap, i: i64, n: i64) -> usize {
    (match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let m = i.rem_euclid(2 * n);
            m.min(2 * n - 1 - m)
        }
        Wrap::Clamp => i.clamp(0, n - 1),
    }) as usize
}

fn decoded(image: &Rgba8, encoding: Encoding, x: usize, y: usize) -> DVec4 {
    let curve = |b: u8| {
        let c = f64::from(b) / 255.0;
        match encoding {
            Encoding::Linear => c,
            Encoding::Srgb if c <= 0.04045 => c / 12.92,
            Encoding::Srgb => ((c + 0.055) / 1.055).powf(2.4),
        }
    };
    let [r, g, b, a] = image.texels[y * image.width + x];
    DVec4::new(curve(r), curve(g), curve(b), f64::from(a) / 255.0)
}

fn reference(image: &Rgba8, encoding: Encoding, s: Sampler, u: f64, v: f64) -> DVec4 {
    let (w, h) = (image.width as i64, image.height as i64);
    let texel = |i: i64, j: i64| decoded(image, encoding, wrapped(s.wrap_s, i, w), wrapped(s.wrap_t, j, h));
    let (x, y) = (u * w as f64, v * h as f64);
    if s.interpolation == Interpolation::Nearest {
        return texel(x.floor() as i64, y.floor() as i64);
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    texel(i, j) * (1.0 - fx) * (1.0 - fy)
        + texel(i + 1, j) * fx * (1.0 - fy)
        + texel(i, j + 1) * (1.0 - fx) * fy
        + texel(i + 1, j + 1) * fx * fy
}

fn assert_close(a: Vec4, b: DVec4, tolerance: f64, what: impl std::fmt::Display) {
    let error = (a.as_dvec4() - b).abs().max_element();
    assert!(error <= tolerance, "{what}: {a} is not {b}");
}

#[test]
fn bilinear_agrees_with_the_definition() {
    for (width, height) in [(1, 1), (2, 1), (3, 5), (8, 4), (17, 16)] {
        let image = image(width, height);
        for (wrap_s, wrap_t) in WRAPS.into_iter().flat_map(|s| WRAPS.map(|t| (s, t))) {
            for encoding in [Encoding::Srgb, Encoding::Linear] {
                let s = sampler(wrap_s, wrap_t, Interpolation::Linear);
                let texture = Texture::new(image.clone(), encoding, s);
                for k in 0..400 {
                    let uv = Vec2::new(k as f32 * 0.0173 - 3.1, 2.9 - k as f32 * 0.0131);
                    let expected = reference(&image, encoding, s, f64::from(uv.x), f64::from(uv.y));
                    // u has an error of half an ulp of 4 after wrapping, multiplied by the size and by a slope of 1 per
                    // texel.
                    let tolerance = 1e-6 + 3e-7 * (width.max(height) as f64) * 2.0;
                    assert_close(texture.lookup(uv), expected, tolerance, format_args!("{s:?} at {uv}"));
                }
            }
        }
    }
}

/// Points that are exact in f32 have no rounding error: every texel, in five periods.
#[test]
fn nearest_finds_every_texel_exactly() {
    let (width, height) = (8, 16);
    let image = image(width, height);
    for wrap in WRAPS {
        let s = sampler(wrap, wrap, Interpolation::Nearest);
        let texture = Texture::new(image.clone(), Encoding::Linear, s);
        for (i, j) in (-16..24).flat_map(|i| (-32..48).map(move |j| (i, j))) {
            for f in [0.0, 0.5, 0.9375] {
                let uv = Vec2::new((i as f32 + f) / width as f32, (j as f32 + f) / height as f32);
                let (x, y) = (wrapped(wrap, i, width as i64), wrapped(wrap, j, height as i64));
                // On the edge of a mirrored texel, either neighbour is correct.
                let mirrored_edge = wrap == Wrap::Mirror && f == 0.0;
                let expected = decoded(&image, Encoding::Linear, x, y);
                if !mirrored_edge {
                    assert_close(texture.lookup(uv), expected, 1e-7, format_args!("{wrap:?} ({i}, {j})"));
                }
            }
        }
    }
}

#[test]
fn centres_return_texels_and_borders_their_means() {
    let image = image(4, 4);
    let texture = Texture::new(image.clone(), Encoding::Srgb, Sampler::default());
    for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (x, y))) {
        let at = |dx: f32| texture.lookup(Vec2::new((x as f32 + 0.5 + dx) / 4.0, (y as f32 + 0.5) / 4.0));
        let texel = decoded(&image, Encoding::Srgb, x, y);
        assert_close(at(0.0), texel, 1e-7, (x, y).0);
        let next = decoded(&image, Encoding::Srgb, (x + 1) % 4, y);
        assert_close(at(0.5), (texel + next) * 0.5, 1e-7, x);
    }
}

#[test]
fn any_uv_gives_a_colour_of_the_texture() {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        1e30,
        -1e-30,
        -1e-10,
        -f32::EPSILON,
        1.0 - f32::EPSILON / 2.0,
        1.0,
        2.0,
        8_388_607.5,
        -8_388_607.5,
        16_777_216.0,
        2_147_483_648.0,
        -0.0,
    ];
    // With one colour throughout, every lookup must return exactly that, so that weights sum to 1 and indices are in
    // range.
    for (width, height) in [(1, 1), (3, 2), (64, 1), (5, 1000)] {
        let texels = vec![[10, 200, 77, 128]; width * height];
        for (wrap, encoding) in WRAPS.into_iter().flat_map(|w| [(w, Encoding::Srgb), (w, Encoding::Linear)]) {
            for interpolation in [Interpolation::Nearest, Interpolation::Linear] {
                let image = Rgba8 { width, height, texels: texels.clone() };
                let expected = decoded(&image, encoding, 0, 0).as_vec4();
                let texture = Texture::new(image, encoding, sampler(wrap, wrap, interpolation));
                for (u, v) in odd.into_iter().flat_map(|u| odd.map(|v| (u, v))) {
                    assert!((texture.lookup(Vec2::new(u, v)) - expected).abs().max_element() < 1e-7);
                }
            }
        }
    }
}

/// Clamped infinities are at the edges, as their limit is.
#[test]
fn infinity_clamps_to_the_edge() {
    let image = image(4, 1);
    let s = sampler(Wrap::Clamp, Wrap::Clamp, Interpolation::Linear);
    let texture = Texture::new(image.clone(), Encoding::Linear, s);
    let at = |u: f32| texture.lookup(Vec2::new(u, 0.5));
    assert_close(at(f32::INFINITY), decoded(&image, Encoding::Linear, 3, 0), 1e-7, "right");
    assert_close(at(f32::NEG_INFINITY), decoded(&image, Encoding::Linear, 0, 0), 1e-7, "left");
}

/// Repeated: the mean over a grid of points commensurate with the texels is the mean of the texels, bilinear or not.
#[test]
fn mean_is_the_integral() {
    let image = image(8, 4);
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        let texture = Texture::new(image.clone(), encoding, Sampler::default());
        let grid = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        let points = grid.map(|(x, y)| Vec2::new((x as f32 + 0.5) / 64.0, (y as f32 + 0.5) / 64.0));
        let sum: DVec4 = points.map(|uv| texture.lookup(uv).as_dvec4()).sum();
        assert_close(texture.mean(), sum / 4096.0, 2e-6, "mean");
        let texels = (0..32).map(|i| decoded(&image, encoding, i % 8, i / 8)).sum::<DVec4>() / 32.0;
        assert_close(texture.mean(), texels, 1e-7, "texels");
    }
    let opaque = Rgba8 { width: 3, height: 1, texels: vec![[255; 4]; 3] };
    assert_eq!(Texture::new(opaque, Encoding::Srgb, Sampler::default()).mean(), Vec4::ONE);
}

#[test]
fn unsound_images_are_white() {
    for (width, height, count) in [(0, 0, 0), (2, 2, 3), (0, 5, 1), (usize::MAX, 2, 2), (usize::MAX, 0, 0)] {
        let image = Rgba8 { width, height, texels: vec![[7; 4]; count] };
        let texture = Texture::new(image, Encoding::Srgb, Sampler::default());
        assert_eq!((texture.lookup(Vec2::splat(0.3)), texture.size()), (Vec4::ONE, (1, 1)));
        assert_eq!((texture.mean(), texture.memory_bytes()), (Vec4::ONE, 4));
    }
}

/// Channels that are kept give the same bits as before, the others 1; redundant channels are not stored.
#[test]
fn channels_that_are_not_looked_at_are_dropped() {
    let image = image(5, 3);
    let all: Vec<Vec2> = (0..40).map(|i| Vec2::new(i as f32 * 0.173, i as f32 * 0.311)).collect();
    let cases = [
        (Channels::NONE, [false; 4], 0),
        (Channels::R, [true, false, false, false], 1),
        (Channels::GB, [false, true, true, false], 2),
        (Channels::RGB, [true, true, true, false], 3),
        (Channels::RGB.or(Channels::A), [true; 4], 4),
    ];
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        let whole = Texture::new(image.clone(), encoding, Sampler::default());
        for (channels, kept, count) in cases {
            let some = whole.clone().keep(channels);
            assert_eq!((some.channels(), some.memory_bytes()), (count, 15 * count + 4 - count));
            for (&uv, c) in all.iter().flat_map(|uv| (0..4).map(move |c| (uv, c))) {
                let expected = if kept[c] { whole.lookup(uv)[c] } else { 1.0 };
                assert_eq!(some.lookup(uv)[c].to_bits(), expected.to_bits(), "{channels:?} {c} at {uv}");
            }
            let again = some.clone().keep(channels);
            assert_eq!((again.channels(), again.mean()), (count, some.mean()));
        }
    }
}

/// 16 bits: each texel is its value in 65535ths, decoded and filtered like 8-bit texels, for any selection of channels.
#[test]
fn sixteen_bits_are_looked_up_exactly() {
    let value = |i: usize, c: usize| [(i * 4999 + 7) % 65_536, (i * 31) % 65_536, 65_535, 300 * i][c] as u16;
    let texels: Vec<[u16; 4]> = (0..15).map(|i| std::array::from_fn(|c| value(i, c))).collect();
    let decode = |v: u16, c: usize, encoding| match f64::from(v) / 65_535.0 {
        x if c == 3 || encoding == Encoding::Linear => x,
        x if x <= 0.04045 => x / 12.92,
        x => ((x + 0.055) / 1.055).powf(2.4),
    };
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        let image = Rgba16 { width: 5, height: 3, texels: texels.clone() };
        let whole = Texture::new(image, encoding, Sampler::default());
        assert_eq!((whole.memory_bytes(), whole.channels(), whole.constant()), (15 * 8, 4, None));
        let mut mean = [0.0; 4];
        for (i, texel) in texels.iter().enumerate() {
            for c in 0..4 {
                let expected = decode(texel[c], c, encoding);
                mean[c] += expected / 15.0;
                assert!((f64::from(whole.texel(i % 5, i / 5)[c]) - expected).abs() < 1e-7, "{i} {c}");
            }
        }
        assert!((whole.mean().as_dvec4() - DVec4::from(mean)).abs().max_element() < 1e-7);
        let between = 0.5 * (whole.texel(1, 1) + whole.texel(2, 1));
        assert!((whole.lookup(Vec2::new(0.4, 0.5)) - between).abs().max_element() < 1e-6);
        // Blue is 1 everywhere and is not stored.
        for (channels, kept, count) in [
            (Channels::RGB, [true, true, true, false], 2),
            (Channels::A, [false, false, false, true], 1),
            (Channels::NONE, [false; 4], 0),
        ] {
            let some = whole.clone().keep(channels);
            assert_eq!((some.channels(), some.memory_bytes()), (count, 15 * 2 * count));
            for (i, c) in (0..40).flat_map(|i| (0..4).map(move |c| (i, c))) {
                let uv = Vec2::new(i as f32 * 0.173, i as f32 * 0.311);
                assert_eq!(some.lookup(uv)[c], if kept[c] { whole.lookup(uv)[c] } else { 1.0 });
            }
            assert_eq!(some.clone().keep(channels).mean(), some.mean());
        }
    }
    let empty = Rgba16 { width: 2, height: 2, texels: vec![[1; 4]] };
    assert_eq!(Texture::new(Texels::Sixteen(empty), Encoding::Linear, Sampler::default()).mean(), Vec4::ONE);
}

#[test]
fn white_and_grey_are_stored_once_or_not_at_all() {
    let texels = (0..12).map(|i| [20 * i, 20 * i, 20 * i, 255]).collect();
    let whole = Texture::new(Rgba8 { width: 4, height: 3, texels }, Encoding::Srgb, Sampler::default());
    let grey = whole.clone().keep(Channels::RGB.or(Channels::A));
    assert_eq!(grey.channels(), 1);
    for i in 0..50 {
        let uv = Vec2::new(i as f32 * 0.077, i as f32 * 0.139);
        assert_eq!(grey.lookup(uv), whole.lookup(uv));
    }
    assert_eq!(grey.mean(), whole.mean());
}
