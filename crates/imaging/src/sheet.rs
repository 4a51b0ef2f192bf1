//! Contact sheets: grids of labelled images.
//!
//! The cells are 8-bit RGB images in a grid, row by row, each with its label underneath. Columns are as wide as the
//! widest cell and rows as high as the highest one. Labels are light grey on a nearly black background, so that neither
//! highlights nor shadows of the images are judged against white.

pub use crate::frame::Frame;
use crate::text;

/// An image with a label.
#[derive(Clone, Debug)]
pub struct Cell {
    /// The image.
    pub frame: Frame,
    /// Lines of text under the image; text wider than the cell is truncated.
    pub label: String,
}

const BACKGROUND: u8 = 24;
const INK: [u8; 3] = [208; 3];
const GAP: usize = 8;

/// Font size of labels in pixels, below and from a cell width of 256 pixels.
const SIZES: [f32; 2] = [11.0, 18.0];

/// Arranges the cells in rows of `columns`. Labels are larger if cells are at least 256 pixels wide.
pub fn grid(cells: &[Cell], columns: usize) -> Frame {
    let columns = columns.clamp(1, cells.len().max(1));
    let width = cells.iter().map(|c| c.frame.width).max().unwrap_or(0);
    let size = SIZES[usize::from(width >= 256)];
    let lines = cells.iter().map(|c| c.label.lines().count()).max().unwrap_or(0);
    let label = lines * text::line_height(size) + if lines > 0 { GAP / 2 } else { 0 };
    let height = cells.iter().map(|c| c.frame.height).max().unwrap_or(0);
    let rows = cells.len().div_ceil(columns);
    let mut sheet = plain(GAP + columns * (width + GAP), GAP + rows * (height + label + GAP));
    for (i, cell) in cells.iter().enumerate() {
        let x = GAP + i % columns * (width + GAP);
        let y = GAP + i / columns * (height + label + GAP);
        paste(&mut sheet, &cell.frame, x, y);
        let label = fitting(&cell.label, size, width as f32);
        text::draw(&mut sheet, (x as f32, (y + height + GAP / 2) as f32), size, INK, &label);
    }
    sheet
}

fn plain(width: usize, height: usize) -> Frame {
    Frame { width, height, data: vec![BACKGROUND; width * height * 3] }
}

/// Copies `cell` into `sheet` with its top-left corner at (x, y); it must fit.
fn paste(sheet: &mut Frame, cell: &Frame, x: usize, y: usize) {
    for (i, row) in cell.data.chunks_exact(cell.width.max(1) * 3).take(cell.height).enumerate() {
        let at = ((y + i) * sheet.width + x) * 3;
        sheet.data[at..at + row.len()].copy_from_slice(row);
    }
}

/// The lines of a label, each truncated to a width in pixels.
fn fitting(label: &str, size: f32, width: f32) -> String {
    label.lines().map(|line| text::fitting(line, size, width)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(width: usize, height: usize, value: u8, label: &str) -> Cell {
        Cell { frame: Frame { width, height, data: vec![value; width * height * 3] }, label: label.into() }
    }

    #[test]
    fn every_pixel_of_every_cell_is_there_once() {
        let cells = [cell(20, 10, 101, "a"), cell(8, 12, 102, "two\nlines"), cell(20, 12, 103, "")];
        let sheet = grid(&cells, 2);
        assert_eq!(
            (sheet.width, sheet.height),
            (8 + 2 * 28, 8 + 2 * (12 + 2 * text::line_height(SIZES[0]) + 4 + 8))
        );
        assert_eq!(sheet.data.len(), sheet.width * sheet.height * 3);
        let row = 8 + 12 + 2 * text::line_height(SIZES[0]) + 4;
        for (c, (x0, y0)) in cells.iter().zip([(8, 8), (36, 8), (8, 8 + row)]) {
            for (x, y) in (0..c.frame.height).flat_map(|y| (0..c.frame.width).map(move |x| (x, y))) {
                assert_eq!(sheet.data[((y0 + y) * sheet.width + x0 + x) * 3], c.frame.data[0], "{x} {y}");
            }
            // The gap to the left and above is background.
            assert_eq!(sheet.data[(y0 * sheet.width + x0 - 1) * 3], BACKGROUND);
            assert_eq!(sheet.data[((y0 - 1) * sheet.width + x0) * 3], BACKGROUND);
        }
        assert!(sheet.data.contains(&INK[0]));
    }

    #[test]
    fn odd_sheets_are_no_reason_to_stop() {
        assert_eq!((grid(&[], 3).width, grid(&[], 3).height), (16, 8));
        let sheet = grid(&[cell(1, 1, 200, "a label much wider than its cell")], 0);
        assert!(!sheet.data.contains(&INK[0]));
        grid(&[cell(0, 0, 0, "x")], 9);
    }
}
