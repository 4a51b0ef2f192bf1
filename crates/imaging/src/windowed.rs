//! Images with their window in the full image.

use crate::window::{Partial, Window};
use crate::{Image, ImageError};

/// An image and its position in the full image.
#[derive(Clone, Debug, PartialEq)]
pub struct Windowed {
    /// The pixels of the window.
    pub picture: Image,
    /// The window within the full image.
    pub window: Window,
    /// Width and height of the full image.
    pub full_size: (usize, usize),
}

impl From<Image> for Windowed {
    fn from(picture: Image) -> Self {
        let full_size = (picture.width, picture.height);
        Self { picture, window: Window::full(full_size), full_size }
    }
}

impl Windowed {
    /// The pixels of `wanted`; None unless all of them are present.
    pub fn part(&self, wanted: Window) -> Option<Image> {
        if self.window.intersection(&wanted) != Some(wanted) {
            return None;
        }
        let (x, y) = (wanted.x - self.window.x, wanted.y - self.window.y);
        let row = |y: usize| &self.picture.pixels[y * self.picture.width + x..][..wanted.width];
        let pixels = (y..y + wanted.height).flat_map(row).copied().collect();
        Some(Image { width: wanted.width, height: wanted.height, pixels })
    }

    /// As [`covering`](Self::covering), without a copy if `wanted` is the whole window.
    pub fn into_covering(self, wanted: Window, name: &str) -> Result<Image, ImageError> {
        if wanted == self.window { Ok(self.picture) } else { self.covering(wanted, name) }
    }

    /// The pixels of `wanted`, or an error about the file `name` if some are missing.
    pub fn covering(&self, wanted: Window, name: &str) -> Result<Image, ImageError> {
        let (has, full_size) = (self.window, self.full_size);
        let partial = || Partial { name: name.into(), has, wanted, full_size };
        self.part(wanted).ok_or_else(|| ImageError::Partial(Box::new(partial())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn parts_are_where_they_belong() {
        let pixels = (0..12).map(|i| Vec3::splat(i as f32)).collect();
        let picture = Image { width: 4, height: 3, pixels };
        let window = Window { x: 10, y: 20, width: 4, height: 3 };
        let windowed = Windowed { picture: picture.clone(), window, full_size: (64, 48) };
        assert_eq!(windowed.part(window), Some(picture));
        let part = windowed.part(Window { x: 12, y: 21, width: 2, height: 2 }).unwrap();
        assert_eq!(part.pixels.iter().map(|p| p.x).collect::<Vec<_>>(), [6.0, 7.0, 10.0, 11.0]);
        for outside in [
            Window { x: 9, y: 20, width: 2, height: 2 },
            Window { x: 13, y: 20, width: 2, height: 1 },
            Window { x: 0, y: 0, width: 4, height: 3 },
        ] {
            assert_eq!(windowed.part(outside), None);
            let said = windowed.covering(outside, "a.exr").unwrap_err().to_string();
            assert!(said.contains("a.exr") && said.contains("10,20 to 14,23"), "{said}");
        }
        assert_eq!(window.intersection(&Window::full((10, 48))), None);
        assert_eq!(window.intersection(&Window::full((11, 21))).unwrap().to_string(), "10,20 to 11,21");
    }
}
