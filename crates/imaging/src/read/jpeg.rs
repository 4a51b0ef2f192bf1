//! Detection of JPEG files whose data end before their image is complete.

use super::bytes::texels_within;
use crate::MemoryLimit;

/// What decoders substitute for missing JPEG data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gap {
    /// Missing blocks are grey.
    Grey,
    /// In a progressive file, blocks that are missing in some scans lack detail or are grey.
    Coarse,
}

/// Bytes that are substituted for potentially missing data; their codes never represent a block of one colour.
const FILLERS: [u8; 3] = [0x00, 0x55, 0xaa];
/// The number of substituted bytes.
const FILLED: usize = 64;

/// Whether and how the image of a JPEG is incomplete; None for complete images and for other formats. Files without an
/// end marker often contain the whole image. They are decoded with various data appended, and if that changes no texel,
/// nothing is missing.
pub fn gap(bytes: &[u8], name: &str, limit: MemoryLimit) -> Option<Gap> {
    if !bytes.starts_with(&[0xff, 0xd8, 0xff]) || ends(bytes) {
        return None;
    }
    // Removes an incomplete marker at the end.
    let data = &bytes[..bytes.iter().rposition(|b| *b != 0xff).map_or(0, |last| last + 1)];
    let with = |filler: &[u8]| texels_within(&[data, filler, &END].concat(), name, limit).ok();
    let own = with(&[]);
    let is_whole = own.is_some() && FILLERS.iter().all(|byte| with(&[*byte; FILLED]) == own);
    let frame = bytes.windows(2).rev().find(|pair| pair[0] == 0xff && (0xc0..=0xc2).contains(&pair[1]));
    let gap = if frame.is_some_and(|pair| pair[1] == 0xc2) { Gap::Coarse } else { Gap::Grey };
    (!is_whole).then_some(gap)
}

const END: [u8; 2] = [0xff, 0xd9];

/// Whether an end marker follows the last start-of-scan marker.
fn ends(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|pair| pair == marker);
    last(END) >= last([0xff, 0xda])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jpeg_ends_with_its_end_marker() {
        let start = [0xff, 0xd8, 0xff, 0xe0, 0, 2];
        let (thumbnail, scan) = ([0xff, 0xda, 1, 0xff, 0xd9], [0xff, 0xda, 1, 2]);
        assert!(!ends(&[&start[..], &scan].concat()));
        assert!(!ends(&[&start[..], &thumbnail, &scan].concat()));
        assert!(ends(&[&start[..], &thumbnail, &scan, &END].concat()));
        assert!(ends(&[&start[..], &scan, &END, &[0; 9]].concat()), "what follows is not looked at");
        assert_eq!(gap(&scan, "no JPEG", MemoryLimit::NONE), None);
    }
}
