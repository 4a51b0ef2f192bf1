//! Detection of JPEG files whose data end before their image is complete.

use super::bytes::texels_within;
use super::texels::Texels;
use crate::{ImageError, MemoryLimit};

/// What decoders substitute for missing JPEG data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gap {
    /// Missing blocks are grey.
    Grey,
    /// In a progressive file, blocks that are missing in some scans lack detail or are grey.
    Coarse,
}

/// Bytes that are substituted for potentially missing data; their codes never represent a block of one colour.
const FILLERS: [u8; 3] = [0xaa, 0x55, 0x00];
/// The number of substituted bytes.
const FILLED: usize = 64;

/// Whether and how the image of a JPEG, decoded to `own`, is incomplete; None for complete images and for other
/// formats. The image is decoded with other data in place of the end marker, and if that changes no texel, nothing is
/// missing: files without an end marker often contain the whole image, and a marker may follow truncated data.
pub fn gap(bytes: &[u8], own: &Texels, name: &str, limit: MemoryLimit) -> Option<Gap> {
    if !bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        return None;
    }
    let end = end(bytes);
    let data = &bytes[..end.unwrap_or(bytes.len())];
    // Removes an incomplete marker at the end.
    let data = &data[..data.iter().rposition(|b| *b != 0xff).map_or(0, |last| last + 1)];
    let with = |filler: u8| texels_within(&[data, &[filler; FILLED], &END].concat(), name, limit);
    // After an end marker, decoders substitute zeros, so that one other filler suffices.
    let fillers = if end.is_some() { &FILLERS[..1] } else { &FILLERS };
    let is_same = |filler: &u8| match with(*filler) {
        Ok(other) => other == *own,
        // Not enough memory for the comparison.
        Err(error) => matches!(error, ImageError::Memory { .. }),
    };
    let is_whole = fillers.iter().all(is_same);
    let frame = bytes.windows(2).rev().find(|pair| pair[0] == 0xff && (0xc0..=0xc2).contains(&pair[1]));
    let gap = if frame.is_some_and(|pair| pair[1] == 0xc2) { Gap::Coarse } else { Gap::Grey };
    (!is_whole).then_some(gap)
}

const END: [u8; 2] = [0xff, 0xd9];

/// Position of the end marker of the image. Segments, which may contain another image, and the data of scans are
/// skipped. None without a marker, and if something other than a segment follows one.
fn end(bytes: &[u8]) -> Option<usize> {
    let mut at = 2;
    loop {
        let (&mark, &code) = (bytes.get(at)?, bytes.get(at + 1)?);
        match code {
            _ if mark != 0xff => return None,
            0xd9 => return Some(at),
            // A fill byte before a marker.
            0xff => at += 1,
            // Markers without a segment.
            0x01 | 0xd0..=0xd8 => at += 2,
            _ => {
                at += 2 + usize::from(u16::from_be_bytes([*bytes.get(at + 2)?, *bytes.get(at + 3)?]));
                if code == 0xda {
                    let is_marker =
                        |pair: &[u8]| pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7 | 0xff);
                    at += bytes.get(at..)?.windows(2).position(is_marker)?;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jpeg_ends_with_its_end_marker() {
        let start = [0xff, 0xd8, 0xff, 0xe0, 0, 2];
        let thumbnail = [0xff, 0xe1, 0, 8, 0xff, 0xda, 1, 2, 0xff, 0xd9];
        let scan = [0xff, 0xff, 0xda, 0, 3, 9, 1, 0xff, 0, 0xff, 0xd3, 7, 0xff];
        let of = |parts: &[&[u8]]| end(&parts.concat());
        assert_eq!(of(&[&start, &scan]), None);
        assert_eq!(of(&[&start, &thumbnail, &scan]), None);
        assert_eq!(of(&[&start, &thumbnail, &scan, &END[1..]]), Some(28));
        assert_eq!(of(&[&start, &scan, &[0xc4, 0, 2], &scan, &END, &thumbnail, &END]), Some(35));
        assert_eq!(of(&[&start, &[3], &END]), None);
        assert_eq!(of(&[&start, &[0xff, 0xe1, 9, 9], &END]), None);
    }
}
