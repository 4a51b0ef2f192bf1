//! Texels of 16 bits per channel, which take twice the memory, for images that require them.

use super::encoding::Encoding;
use crate::color::{srgb_table_16, unit_table_16};
use glam::{DVec4, Vec4};

/// Texels with only some of their channels stored.
#[derive(Clone, Debug)]
pub(super) struct Wide {
    /// `stride` values per texel.
    values: Vec<u16>,
    stride: usize,
    channels: [Channel; 4],
}

/// The position of a channel within its texel and its decoding table; the channel is 1 everywhere if there is no table.
#[derive(Clone, Copy, Debug)]
struct Channel {
    place: usize,
    table: Option<&'static [f32]>,
}

impl Wide {
    /// Creates texels with all channels; there must be at least one texel.
    pub fn new(texels: Vec<[u16; 4]>, encoding: Encoding) -> Self {
        let color = match encoding {
            Encoding::Srgb => srgb_table_16(),
            Encoding::Linear => unit_table_16(),
        };
        let tables = [color, color, color, unit_table_16()];
        let channels = std::array::from_fn(|place| Channel { place, table: Some(tables[place]) });
        Self { values: texels.into_flattened(), stride: 4, channels }
    }

    /// See [`super::Texture::keep`].
    pub fn keep(self, wanted: [bool; 4]) -> Self {
        let mut stored: Vec<usize> = Vec::new();
        let mut channels = self.channels;
        for c in 0..4 {
            let gone = self.channels[c].table.is_none();
            if gone || !wanted[c] || self.column(c).all(|value| value == u16::MAX) {
                channels[c].table = None;
                continue;
            }
            let same = |s: &usize| self.column(*s).eq(self.column(c));
            channels[c].place = stored.iter().position(same).unwrap_or_else(|| {
                stored.push(c);
                stored.len() - 1
            });
        }
        let taken: Vec<usize> = stored.iter().map(|&c| self.channels[c].place).collect();
        let texels = self.values.chunks_exact(self.stride.max(1));
        let values = texels.flat_map(|texel| taken.iter().map(|&place| texel[place])).collect();
        Self { values, stride: taken.len(), channels }
    }

    /// The stored values of a channel, texel by texel.
    fn column(&self, c: usize) -> impl Iterator<Item = u16> {
        self.values.iter().skip(self.channels[c].place).step_by(self.stride.max(1)).copied()
    }

    pub fn channels(&self) -> usize {
        self.stride
    }

    /// The decoded texel at the given index, row by row.
    pub fn texel(&self, index: usize) -> Vec4 {
        let at = index * self.stride;
        Vec4::from_array(self.channels.map(|channel| match channel.table {
            Some(table) => table[usize::from(self.values[at + channel.place])],
            None => 1.0,
        }))
    }

    /// Mean over all `count` texels.
    pub fn mean(&self, count: usize) -> Vec4 {
        let sum: DVec4 = (0..count).map(|i| self.texel(i).as_dvec4()).sum();
        (sum / count as f64).as_vec4()
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.values)
    }
}
