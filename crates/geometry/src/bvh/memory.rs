//! Where the lines of a tree lie. Rays jump about in them, and the machine remembers the addresses of only so many pages:
//! of 4 KiB, those of a few MB. Large trees ask for pages of 2 MiB, which the system gives if it has any.

use super::node::Line;

/// The lines in memory of just their size, in pages of 2 MiB if there is at least one and the system has them.
pub(super) fn settled(lines: Vec<Line>) -> Vec<Line> {
    let mut settled = Vec::with_capacity(lines.len());
    #[cfg(all(feature = "huge-pages", target_os = "linux"))]
    huge::ask(settled.spare_capacity_mut());
    settled.extend_from_slice(&lines);
    settled
}

#[cfg(all(feature = "huge-pages", target_os = "linux"))]
#[allow(unsafe_code)]
mod huge {
    use super::Line;
    use std::mem::MaybeUninit;

    const HUGE: usize = 2 << 20;
    /// No smaller than any page in use, so that a multiple of it begins a page.
    const PAGE: usize = 1 << 16;

    /// Asks for large pages for memory that nothing was written to yet.
    pub fn ask(memory: &mut [MaybeUninit<Line>]) {
        let range = memory.as_mut_ptr_range();
        let (begin, end) = (range.start.addr().next_multiple_of(PAGE), range.end.addr() / PAGE * PAGE);
        if begin + HUGE <= end {
            let begin = range.start.with_addr(begin);
            // SAFETY: whole pages of memory that is ours alone; the request changes no content. Refused, nothing is lost.
            unsafe { libc::madvise(begin.cast(), end - begin.addr(), libc::MADV_HUGEPAGE) };
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
            let kept = settled(lines.clone());
            assert_eq!(bytemuck::cast_slice::<_, u32>(&kept), bytemuck::cast_slice::<_, u32>(&lines));
        }
    }
}
