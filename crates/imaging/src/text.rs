//! Text in 8-bit RGB images, in a subset of the font Inter (SIL Open Font License 1.1, `fonts/OFL.txt`).
//!
//! Sizes are font sizes in pixels. The font has Latin, Greek and common mathematical characters; other characters
//! are drawn as its replacement glyph. Text outside the image is clipped.

use crate::frame::Frame;
use ab_glyph::{Font, FontRef, Glyph, GlyphId, PxScale, PxScaleFont, ScaleFont, point};
use std::sync::LazyLock;

static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    let bytes = include_bytes!("../fonts/Inter-Regular.otf");
    FontRef::try_from_slice(bytes).expect("the embedded font is valid")
});

/// Distance between the baselines of consecutive lines, in whole pixels.
pub fn line_height(size: f32) -> usize {
    (1.25 * size).ceil() as usize
}

/// Width of one line of text in pixels.
pub fn width(text: &str, size: f32) -> f32 {
    glyphs(text, size).last().map_or(0.0, |g| g.glyph.position.x + g.advance)
}

/// The longest beginning of one line of text that is at most `most` pixels wide, with an ellipsis if it is truncated.
pub fn fitting(text: &str, size: f32, most: f32) -> String {
    if width(text, size) <= most {
        return text.into();
    }
    let mut short: String = text.into();
    while short.pop().is_some() {
        let cut = format!("{}…", short.trim_end());
        if width(&cut, size) <= most {
            return cut;
        }
    }
    short
}

/// Draws text with the top-left corner of its first line at (x, y); a line feed starts a new line.
pub fn draw(frame: &mut Frame, (x, y): (f32, f32), size: f32, color: [u8; 3], text: &str) {
    let font = scaled(size);
    // The baseline that centres ascenders and descenders in the line.
    let ascent = 0.5 * (line_height(size) as f32 + font.ascent() + font.descent());
    for (row, line) in text.split('\n').enumerate() {
        let baseline = (y + (row * line_height(size)) as f32 + ascent).round();
        for placed in glyphs(line, size) {
            let mut glyph = placed.glyph;
            glyph.position += point(x, baseline);
            draw_glyph(frame, glyph, color);
        }
    }
}

fn draw_glyph(frame: &mut Frame, glyph: Glyph, color: [u8; 3]) {
    let Some(outline) = FONT.outline_glyph(glyph) else { return };
    let corner = outline.px_bounds().min;
    outline.draw(|i, j, coverage| {
        let at = (corner.x + i as f32, corner.y + j as f32);
        if at.0 < 0.0 || at.1 < 0.0 || at.0 >= frame.width as f32 || at.1 >= frame.height as f32 {
            return;
        }
        let start = (at.1 as usize * frame.width + at.0 as usize) * 3;
        if let Some(pixel) = frame.data.get_mut(start..start + 3) {
            for (old, new) in pixel.iter_mut().zip(color) {
                let mixed = f32::from(*old) + coverage.clamp(0.0, 1.0) * (f32::from(new) - f32::from(*old));
                *old = (mixed + 0.5) as u8;
            }
        }
    });
}

struct Placed {
    glyph: Glyph,
    advance: f32,
}

fn scaled(size: f32) -> PxScaleFont<&'static FontRef<'static>> {
    // `ab_glyph` measures the height from descender to ascender; a font size is the size of the em square.
    let height = FONT.height_unscaled() / FONT.units_per_em().unwrap_or(1000.0);
    FONT.as_scaled(PxScale::from(size * height))
}

/// The glyphs of one line with their positions, from x = 0 on the baseline y = 0.
fn glyphs(line: &str, size: f32) -> impl Iterator<Item = Placed> {
    let font = scaled(size);
    let mut pen = 0.0;
    let mut previous: Option<GlyphId> = None;
    line.chars().map(move |c| {
        let id = FONT.glyph_id(if c.is_control() { '\u{fffd}' } else { c });
        pen += previous.map_or(0.0, |p| font.kern(p, id));
        let advance = font.h_advance(id);
        let glyph = id.with_scale_and_position(font.scale(), point(pen, 0.0));
        pen += advance;
        previous = Some(id);
        Placed { glyph, advance }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: f32 = 16.0;

    fn page(text: &str, at: (f32, f32)) -> Frame {
        let mut frame = Frame { width: 64, height: 48, data: vec![255; 64 * 48 * 3] };
        draw(&mut frame, at, SIZE, [0; 3], text);
        frame
    }

    /// Rows and columns that contain ink.
    fn ink(frame: &Frame) -> Option<[usize; 4]> {
        let dark = |i: &usize| frame.data[3 * i] < 128;
        let dark: Vec<usize> = (0..frame.width * frame.height).filter(dark).collect();
        let xs = || dark.iter().map(|i| i % frame.width);
        let ys = || dark.iter().map(|i| i / frame.width);
        Some([xs().min()?, ys().min()?, xs().max()?, ys().max()?])
    }

    #[test]
    fn letters_lie_within_their_line_and_their_width() {
        for text in ["H", "gjpqy", "ÄÅ", "0.123", "−½σ²≤×…"] {
            let [left, top, right, bottom] = ink(&page(text, (4.0, 4.0))).unwrap();
            assert!(left >= 3 && top >= 4 && bottom < 4 + line_height(SIZE), "{text}: {left} {top} {bottom}");
            assert!((right as f32) < 5.0 + width(text, SIZE), "{text}: {right}");
        }
        // The cap height of Inter is 0.727 em.
        let [_, top, _, bottom] = ink(&page("H", (4.0, 4.0))).unwrap();
        assert!((11..=13).contains(&(bottom + 1 - top)), "{top} to {bottom}");
    }

    #[test]
    fn lines_follow_each_other() {
        let (one, two) = (page("H", (4.0, 2.0)), page("\nH", (4.0, 2.0)));
        let shift = line_height(SIZE) * 64 * 3;
        assert_eq!(one.data[..one.data.len() - shift], two.data[shift..]);
    }

    #[test]
    fn every_character_used_has_a_glyph() {
        let missing = FONT.glyph_id('\u{10ffff}');
        let used = (' '..='~').chain("äöüéÅß×·±²³½µ−–…≤≥≈√∞→αβγδεηθλμπρσΩ".chars());
        assert!(used.clone().all(|c| FONT.glyph_id(c) != missing), "{:?}", used.collect::<String>());
    }

    #[test]
    fn text_is_clipped_and_truncated() {
        for at in [(-20.0, -8.0), (60.0, 40.0), (1e9, 1e9), (f32::NAN, 0.0)] {
            page("clipped\nat every side", at);
        }
        assert_eq!(fitting("short", SIZE, 100.0), "short");
        let cut = fitting("a label much wider than its cell", SIZE, 80.0);
        assert!(cut.ends_with('…') && width(&cut, SIZE) <= 80.0 && cut.len() > 8, "{cut}");
        assert_eq!(fitting("none", SIZE, 1.0), "");
    }
}
