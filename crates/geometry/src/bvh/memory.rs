//! Where the lines of a tree lie. Rays jump about in them, and the machine remembers the addresses of only so many pages:
//! of 4 KiB, those of a few MB. Large trees ask for pages of 2 MiB, which the system gives if it has any.

use super::node::Line;

/// Lines that no longer change.
#[derive(Debug)]
pub(super) enum Lines {
    Small(Vec<Line>),
    #[cfg(all(feature = "huge-pages", target_os = "linux"))]
    Large(huge::Pages),
}

impl Lines {
    /// Moves them to where they stay.
    pub fn new(mut lines: Vec<Line>) -> Self {
        #[cfg(all(feature = "huge-pages", target_os = "linux"))]
        if let Some(pages) = huge::Pages::new(&lines) {
            return Self::Large(pages);
        }
        lines.shrink_to_fit();
        Self::Small(lines)
    }

    #[inline(always)]
    pub fn get(&self) -> &[Line] {
        match self {
            Self::Small(lines) => lines,
            #[cfg(all(feature = "huge-pages", target_os = "linux"))]
            Self::Large(pages) => pages.lines(),
        }
    }
}

#[cfg(all(feature = "huge-pages", target_os = "linux"))]
mod huge {
    use super::Line;
    use memmap2::{Advice, MmapMut};

    const PAGE: usize = 2 << 20;

    /// Memory in which the lines begin at a page's begin.
    #[derive(Debug)]
    pub struct Pages {
        map: MmapMut,
        begin: usize,
        bytes: usize,
    }

    impl Pages {
        /// None for less than a page, or where the system has no such memory.
        pub fn new(lines: &[Line]) -> Option<Self> {
            let bytes = size_of_val(lines);
            if bytes < PAGE {
                return None;
            }
            let map = MmapMut::map_anon(bytes + PAGE).ok()?;
            // Before the memory is first written to.
            map.advise(Advice::HugePage).ok()?;
            let begin = map.as_ptr().align_offset(PAGE);
            let mut pages = Self { map, begin, bytes };
            pages.map.get_mut(begin..begin + bytes)?.copy_from_slice(bytemuck::cast_slice(lines));
            Some(pages)
        }

        #[inline(always)]
        pub fn lines(&self) -> &[Line] {
            bytemuck::cast_slice(&self.map[self.begin..self.begin + self.bytes])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::node::Node;
    use glam::Vec3;

    #[test]
    fn nothing_is_lost() {
        for nodes in [0, 1, 10_000, 30_000] {
            let mut lines = Vec::new();
            for i in 0..nodes {
                let mut node = Node::NONE;
                node.set(0, Vec3::ZERO, Vec3::splat(i as f32), i);
                lines.extend(node.lines());
            }
            let kept = Lines::new(lines.clone());
            assert_eq!(bytemuck::cast_slice::<_, u32>(kept.get()), bytemuck::cast_slice::<_, u32>(&lines));
        }
    }
}
