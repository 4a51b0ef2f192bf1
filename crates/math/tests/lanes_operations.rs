//! Every operation on numbers and words: against the operations of Rust, and the same bits with every instruction set.

use dapple_math::lanes::{Double, Isa, Kernel, Mask, Real, Word, dispatch};
use dapple_testkit::Rng;

/// The instruction sets of this machine; the others are named, so that a test that saw none of them can be recognised.
fn isas() -> Vec<Isa> {
    for isa in Isa::ALL.into_iter().filter(|isa| !isa.runs()) {
        println!("skipped: {} does not run here", isa.name());
    }
    Isa::available()
}

const NUMBERS: [&str; 23] = [
    "+",
    "-",
    "*",
    "/",
    "neg",
    "+=",
    "-=",
    "*=",
    "min",
    "max",
    "abs",
    "copysign",
    "sqrt",
    "floor",
    "round",
    "lt",
    "le",
    "eq",
    "gt",
    "ge",
    "ne",
    "is_finite",
    "to_int",
];

#[inline(always)]
fn word<W: Word>(mask: W::Mask) -> W {
    W::select(mask, W::splat(1), W::splat(0))
}

#[inline(always)]
fn number<R: Real>(operation: usize, x: R, y: R) -> R::Word {
    let mut sum = x;
    let result = match NUMBERS[operation] {
        "+" => x + y,
        "-" => x - y,
        "*" => x * y,
        "/" => x / y,
        "neg" => -x,
        "+=" => {
            sum += y;
            sum
        }
        "-=" => {
            sum -= y;
            sum
        }
        "*=" => {
            sum *= y;
            sum
        }
        "min" => x.min(y),
        "max" => x.max(y),
        "abs" => x.abs(),
        "copysign" => x.copysign(y),
        "sqrt" => x.sqrt(),
        "floor" => x.floor(),
        "round" => x.round_ties_even(),
        "lt" => return word(x.lt(y)),
        "le" => return word(x.le(y)),
        "eq" => return word(x.eq(y)),
        "gt" => return word(x.gt(y)),
        "ge" => return word(x.ge(y)),
        "ne" => return word(x.ne(y)),
        "is_finite" => return word(x.is_finite()),
        _ => return x.to_int(),
    };
    // The bits of NaN are unspecified.
    R::select(result.eq(result), result, R::splat(f32::NAN)).to_bits()
}

fn number_in_rust(operation: usize, x: f32, y: f32) -> u32 {
    let result = match NUMBERS[operation] {
        "+" | "+=" => x + y,
        "-" | "-=" => x - y,
        "*" | "*=" => x * y,
        "/" => x / y,
        "neg" => -x,
        "min" => [y, x][usize::from(x < y)],
        "max" => [y, x][usize::from(x > y)],
        "abs" => f32::abs(x),
        "copysign" => f32::copysign(x, y),
        "sqrt" => f32::sqrt(x),
        "floor" => f32::floor(x),
        "round" => f32::round_ties_even(x),
        "lt" => return u32::from(x < y),
        "le" => return u32::from(x <= y),
        "eq" => return u32::from(x == y),
        "gt" => return u32::from(x > y),
        "ge" => return u32::from(x >= y),
        "ne" => return u32::from(x != y),
        "is_finite" => return u32::from(f32::is_finite(x)),
        _ => return if (-2_147_483_648.0..2_147_483_648.0).contains(&x) { x as i32 as u32 } else { 1 << 31 },
    };
    if result.is_nan() { f32::NAN.to_bits() } else { result.to_bits() }
}

const WORDS: [&str; 21] = [
    "+",
    "-",
    "*",
    "&",
    "|",
    "^",
    "!",
    "<<1",
    "<<31",
    ">>1",
    ">>31",
    "rotate",
    "rotate 0",
    "reverse",
    "eq",
    "ne",
    "lt",
    "le",
    "lt_signed",
    "unit",
    "to_real",
];

#[inline(always)]
fn integer<W: Word>(operation: usize, x: W, y: W) -> W {
    match WORDS[operation] {
        "+" => x.wrapping_add(y),
        "-" => x.wrapping_sub(y),
        "*" => x.wrapping_mul(y),
        "&" => x & y,
        "|" => x | y,
        "^" => x ^ y,
        "!" => !x,
        "<<1" => x << 1,
        "<<31" => x << 31,
        ">>1" => x >> 1,
        ">>31" => x >> 31,
        "rotate" => x.rotate_left(13) ^ x.rotate_left(45).rotate_left(31),
        "rotate 0" => x.rotate_left(0),
        "reverse" => x.reverse_bits(),
        "eq" => word(x.eq(y)),
        "ne" => word(x.ne(y)),
        "lt" => word(x.lt(y)),
        "le" => word(x.le(y)),
        "lt_signed" => word(x.lt_signed(y)),
        "unit" => x.unit().to_bits(),
        _ => x.to_real().to_bits().wrapping_add(x.int_to_real().to_bits()),
    }
}

fn integer_in_rust(operation: usize, x: u32, y: u32) -> u32 {
    match WORDS[operation] {
        "+" => u32::wrapping_add(x, y),
        "-" => u32::wrapping_sub(x, y),
        "*" => u32::wrapping_mul(x, y),
        "&" => x & y,
        "|" => x | y,
        "^" => x ^ y,
        "!" => !x,
        "<<1" => x << 1,
        "<<31" => x << 31,
        ">>1" => x >> 1,
        ">>31" => x >> 31,
        "rotate" => u32::rotate_left(x, 13) ^ u32::rotate_left(x, 44),
        "rotate 0" => x,
        "reverse" => u32::reverse_bits(x),
        "eq" => u32::from(x == y),
        "ne" => u32::from(x != y),
        "lt" => u32::from(x < y),
        "le" => u32::from(x <= y),
        "lt_signed" => u32::from((x as i32) < y as i32),
        "unit" => ((f64::from(x >> 8) / 16_777_216.0) as f32).to_bits(),
        _ => u32::wrapping_add((x as f32).to_bits(), (x as i32 as f32).to_bits()),
    }
}

/// Applies one operation to all pairs of arguments.
struct Apply<'a> {
    numbers: bool,
    operation: usize,
    x: &'a [u32],
    y: &'a [u32],
    out: &'a mut [u32],
}

impl Kernel for Apply<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        for (i, out) in self.out.chunks_mut(R::LANES).enumerate() {
            let at = i * R::LANES;
            let (x, y) = (R::Word::load(&self.x[at..]), R::Word::load(&self.y[at..]));
            let result = match self.numbers {
                true => number(self.operation, R::from_bits(x), R::from_bits(y)),
                false => integer(self.operation, x, y),
            };
            result.store(out);
        }
    }
}

/// Special numbers and words with each other, and random ones.
fn arguments() -> (Vec<u32>, Vec<u32>) {
    let numbers = [
        0.0,
        1.0,
        0.5,
        1.5,
        2.5,
        0.49999997,
        8_388_607.5,
        8_388_608.0,
        16_777_217.0,
        2_147_483_648.0,
        4_294_967_040.0,
        1e-45,
        1.1754942e-38,
        1.1754944e-38,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
        3.7,
    ];
    let numbers = numbers.iter().flat_map(|x| [x.to_bits(), (-x).to_bits()]);
    let words = [1, 2, 0x7fff_ffff, 0x8000_0001, u32::MAX, 0x0123_4567, 0xff, 0xffff_ff00];
    let special: Vec<u32> = numbers.chain(words).collect();
    let mut pairs: Vec<(u32, u32)> =
        special.iter().flat_map(|&x| special.iter().map(move |&y| (x, y))).collect();
    let mut rng = Rng::new(5);
    pairs.extend((0..20_003).map(|_| (rng.bits() as u32, rng.bits() as u32)));
    // Numbers of ordinary size, whose results are neither infinite nor zero.
    pairs.extend((0..20_000).map(|_| ((rng.f32() * 9.0 - 4.0).to_bits(), (rng.f32() * 9.0 - 4.0).to_bits())));
    pairs.into_iter().unzip()
}

#[test]
fn operations_are_those_of_rust_with_every_instruction_set() {
    let (x, y) = arguments();
    for isa in isas() {
        for (numbers, names) in [(true, &NUMBERS[..]), (false, &WORDS[..])] {
            for (operation, name) in names.iter().enumerate() {
                let mut out = vec![0; x.len()];
                dispatch(isa, Apply { numbers, operation, x: &x, y: &y, out: &mut out });
                for (i, &got) in out.iter().enumerate() {
                    let expected = match numbers {
                        true => number_in_rust(operation, f32::from_bits(x[i]), f32::from_bits(y[i])),
                        false => integer_in_rust(operation, x[i], y[i]),
                    };
                    let (a, b) = (x[i], y[i]);
                    assert_eq!(got, expected, "{name} of {a:#x}, {b:#x} with {}", isa.name());
                }
            }
        }
    }
}

const DOUBLES: [&str; 9] = ["+", "-", "*", "/", "max", "abs", "sqrt", "select", "lt"];

/// The result of an operation in f64, rounded to f32, and what was rounded off.
#[inline(always)]
fn double<D: Double>(operation: usize, x: D, y: D) -> (D::Real, D::Real) {
    let third = D::splat(1.0 / 3.0);
    let (x, y) = (x * third, y * third);
    let result = match DOUBLES[operation] {
        "+" => x + y,
        "-" => x - y,
        "*" => x * y,
        "/" => x / y,
        "max" => x.max(y),
        "abs" => x.abs(),
        "sqrt" => x.sqrt(),
        "select" => D::select(x.lt(y), x, y * third),
        _ => {
            let (zero, one) = (D::Real::splat(0.0), D::Real::splat(1.0));
            return (D::Real::select(x.lt(y), one, zero), zero);
        }
    };
    let rounded = result.to_real();
    (rounded, (result - D::from_real(rounded)).to_real())
}

fn double_in_rust(operation: usize, x: f32, y: f32) -> (f32, f32) {
    let third = 1.0 / 3.0;
    let (x, y) = (f64::from(x) * third, f64::from(y) * third);
    let result = match DOUBLES[operation] {
        "+" => x + y,
        "-" => x - y,
        "*" => x * y,
        "/" => x / y,
        "max" => [y, x][usize::from(x > y)],
        "abs" => f64::abs(x),
        "sqrt" => f64::sqrt(x),
        "select" => [y * third, x][usize::from(x < y)],
        _ => return (f32::from(u8::from(x < y)), 0.0),
    };
    (result as f32, (result - f64::from(result as f32)) as f32)
}

/// Applies one operation in f64 to all pairs of arguments; the results go into two columns.
struct ApplyDouble<'a>(usize, [&'a [f32]; 2], [&'a mut [f32]; 2]);

impl Kernel for ApplyDouble<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let Self(operation, [x, y], [high, low]) = self;
        for i in (0..x.len()).step_by(R::LANES) {
            let (x, y) = (R::load(&x[i..]), R::load(&y[i..]));
            let (rounded, rest) = double(operation, R::Double::from_real(x), R::Double::from_real(y));
            rounded.store(&mut high[i..]);
            rest.store(&mut low[i..]);
        }
    }
}

#[test]
fn operations_in_f64_are_those_of_rust_with_every_instruction_set() {
    let (x, y) = arguments();
    let numbers = |bits: &[u32]| bits.iter().map(|bits| f32::from_bits(*bits)).collect::<Vec<_>>();
    let (x, y) = (numbers(&x), numbers(&y));
    let bits = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { f32::to_bits(x) };
    for isa in isas() {
        for (operation, name) in DOUBLES.iter().enumerate() {
            let (mut high, mut low) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            dispatch(isa, ApplyDouble(operation, [&x, &y], [&mut high, &mut low]));
            for i in 0..x.len() {
                let (rounded, rest) = double_in_rust(operation, x[i], y[i]);
                let (got, expected) = ([high[i], low[i]].map(bits), [rounded, rest].map(bits));
                assert_eq!(got, expected, "{name} of {:e}, {:e} with {}", x[i], y[i], isa.name());
            }
        }
    }
}

/// Runs checks that know the number of lanes.
struct Lanes;

impl Kernel for Lanes {
    type Output = usize;
    fn run<R: Real>(self) -> usize {
        masks::<R>();
        for len in 0..=R::LANES + 2 {
            for bits in [0, 1, 0b1010_0110_1101_0110, 0xffff, 0x8000, 0x0180] {
                slices::<R>(len, bits);
            }
        }
        tables::<R>();
        R::LANES
    }
}

fn masks<R: Real>() {
    let all = u32::MAX >> (32 - R::LANES);
    for bits in (0..=0xffff).step_by(7).chain([0xffff, 0xffff_0000, u32::MAX]) {
        let mask = R::Mask::from_bitmask(bits);
        let bits = bits & all;
        assert_eq!(mask.bitmask(), bits);
        assert_eq!((!mask).bitmask(), !bits & all);
        assert_eq!((mask.any(), mask.all()), (bits != 0, bits == all));
        assert_eq!(mask.count(), bits.count_ones() as usize);
        let other = R::Mask::from_bitmask(0x5a5a);
        let both = [mask & other, mask | other, mask ^ other].map(Mask::bitmask);
        assert_eq!(both, [bits & 0x5a5a, bits | 0x5a5a, bits ^ 0x5a5a].map(|b| b & all));
    }
    assert_eq!((R::Mask::splat(true).bitmask(), R::Mask::splat(false).bitmask()), (all, 0));
    assert_eq!(R::Mask::LANES, R::LANES);
    for n in 0..20 {
        assert_eq!(R::Mask::first(n).bitmask(), ((1u64 << n) - 1) as u32 & all);
    }
    let mut lanes = [9; 16];
    R::Word::lane_index().store(&mut lanes);
    assert!((0..R::LANES).all(|i| lanes[i] == i as u32));
}

/// Reads and writes slices of `len` places under a mask.
fn slices<R: Real>(len: usize, bits: u32) {
    let from: Vec<f32> = (0..len).map(|i| i as f32 + 0.5).collect();
    let words: Vec<u32> = from.iter().map(|x| f32::to_bits(*x)).collect();
    let mask = R::Mask::from_bitmask(bits);
    let kept: Vec<usize> = (0..R::LANES.min(len)).filter(|i| bits >> i & 1 == 1).collect();
    let (mut all, mut some) = ([7.0f32; 20], [7.0f32; 20]);
    R::load(&from).store(&mut all);
    R::load_where(mask, &from).store(&mut some);
    for i in 0..20 {
        let at = |inside: bool| {
            if i >= R::LANES {
                7.0
            } else if inside {
                i as f32 + 0.5
            } else {
                0.0
            }
        };
        assert_eq!((all[i], some[i]), (at(i < len), at(kept.contains(&i))));
    }
    assert_eq!(
        R::Word::select(mask, R::Word::load(&words), R::Word::splat(3)).eq(R::Word::splat(3)).bitmask(),
        {
            let outside: u32 = (0..R::LANES as u32).filter(|i| bits >> i & 1 == 0).map(|i| 1 << i).sum();
            outside
        }
    );

    let lane: Vec<f32> = (0..16).map(|i| 100.0 + i as f32).collect();
    let (x, w) = (R::load(&lane), R::load(&lane).to_bits());
    let (mut to, mut where_to, mut packed) = (vec![7.0; len], vec![7.0; len], vec![7.0; len]);
    x.store(&mut to);
    x.store_where(mask, &mut where_to);
    let count = x.compress_store(mask, &mut packed);
    for i in 0..len {
        assert_eq!(to[i], if i < R::LANES { lane[i] } else { 7.0 });
        assert_eq!(where_to[i], if kept.contains(&i) { lane[i] } else { 7.0 });
        assert!(i < R::LANES || packed[i] == 7.0);
    }
    let expected: Vec<f32> =
        (0..R::LANES).filter(|i| bits >> i & 1 == 1).map(|i| lane[i]).take(len).collect();
    assert_eq!((count, &packed[..count]), (expected.len(), &expected[..]));

    let (mut to_w, mut where_w, mut packed_w) = (vec![7; len], vec![7.0f32.to_bits(); len], vec![7; len]);
    w.store(&mut to_w);
    w.store_where(mask, &mut where_w);
    assert_eq!(w.compress_store(mask, &mut packed_w), count);
    for i in 0..len {
        assert_eq!(to_w[i], if i < R::LANES { lane[i].to_bits() } else { 7 });
        assert_eq!(where_w[i], where_to[i].to_bits());
        assert!(i >= count || packed_w[i] == packed[i].to_bits());
    }
    assert_eq!(
        R::Word::load_where(mask, &words).eq(R::load_where(mask, &from).to_bits()).bitmask().count_ones(),
        { R::LANES as u32 }
    );
}

/// Gathers with indices inside and outside of tables of several sizes.
fn tables<R: Real>() {
    for len in [0, 1, 2, 3, 17, 1000] {
        let table: Vec<f32> = (0..len).map(|i| i as f32 * 0.25 - 1.0).collect();
        let words: Vec<u32> = (0..len as u32).map(|i| i * 3).collect();
        let rows: Vec<[f32; 4]> =
            (0..len).map(|i| [0.0, 1.0, 2.0, 3.0].map(|c| (4 * i) as f32 + c)).collect();
        let mut rng = Rng::new(1);
        for round in 0..50 {
            let index: Vec<u32> = (0..R::LANES)
                .map(|i| match (round + i) % 5 {
                    0 => u32::MAX - i as u32,
                    1 => 0x8000_0000 + i as u32,
                    2 => len as u32,
                    _ => rng.below(len.max(1) as u32),
                })
                .collect();
            let at = R::Word::load(&index);
            let (mut x, mut w, mut columns) = ([0.0; 16], [0; 16], [[0.0; 16]; 4]);
            R::gather(&table, at).store(&mut x);
            R::Word::gather(&words, at).store(&mut w);
            for (values, column) in R::gather_rows(&rows, at).into_iter().zip(&mut columns) {
                values.store(column);
            }
            for (i, &index) in index.iter().enumerate() {
                let place = (index as usize).min(len.max(1) - 1);
                assert_eq!(x[i], table.get(place).copied().unwrap_or_default());
                assert_eq!(w[i], words.get(place).copied().unwrap_or_default());
                assert_eq!(columns.map(|c| c[i]), rows.get(place).copied().unwrap_or_default());
            }
        }
    }
}

#[test]
fn masks_slices_and_tables() {
    for isa in isas() {
        assert_eq!(dispatch(isa, Lanes), isa.lanes());
    }
}

/// An instruction set that the machine lacks gives one lane instead.
#[test]
fn every_instruction_set_can_be_asked_for() {
    for isa in Isa::ALL {
        let lanes = dispatch(isa, Lanes);
        assert_eq!(lanes, if isa.runs() { isa.lanes() } else { 1 });
    }
    assert_eq!(Isa::available().first(), Some(&Isa::fastest()));
    assert_eq!(Isa::available().last(), Some(&Isa::Portable));
    assert_eq!(Isa::ALL.map(Isa::name), ["avx512", "avx2", "portable"]);
    if cfg!(dapple_portable) {
        assert_eq!(Isa::available(), [Isa::Portable]);
    }
}
