//! References of a sheet: a file, two files, or two independent renders by the path tracer.

use crate::error::Failure;
use dapple_analysis::converge::Reference as Pictures;
use dapple_analysis::metrics::SizeMismatch;
use dapple_integrator::Settings;
use dapple_integrator::imaging::{Image, MemoryLimit, Window, Windowed, read};
use dapple_integrator::math::PixelRect;
use std::path::Path;

/// Errors are reported only above this many standard deviations of the reference noise in a squared error.
const LOST: f64 = 4.0;

/// A reference that errors are measured against.
pub struct Reference {
    pictures: Pictures,
    /// Description of its origin.
    pub said: String,
}

/// The error of a cell as relative RMSE.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error {
    /// Measured error, free of the reference's noise if that has two halves.
    Measured(f64),
    /// Upper bound: smaller errors are lost in the noise of the reference.
    Below(f64),
    /// No reference exists.
    Unknown,
}

impl Reference {
    /// Creates a reference of two independent halves.
    pub fn of(halves: [Image; 2], said: String) -> Self {
        Self { pictures: Pictures::Halves(halves), said }
    }

    /// Creates a reference from the pixels of the given files that `settings` renders.
    pub fn given(files: &Given, settings: &Settings) -> Result<Self, Failure> {
        let (rect, size) = (settings.rect(), settings.size);
        let picture = |(path, file): &(&Path, Windowed)| fitting(path, file, rect, size);
        let first = picture(&files.first)?;
        let path = files.first.0.display();
        Ok(match &files.half {
            None => Self { pictures: Pictures::Exact(first), said: path.to_string() },
            Some(half) => {
                let said = format!("{path} and {}", half.0.display());
                Self::of([first, picture(half)?], said)
            }
        })
    }

    /// Whether the reference's noise counts as error of the cells.
    pub fn is_exact(&self) -> bool {
        matches!(self.pictures, Pictures::Exact(_))
    }

    /// Returns the relative RMSE of the reference itself; 0 if it is taken as exact.
    pub fn relative_rmse(&self) -> f64 {
        self.pictures.relative_rmse()
    }

    /// Measures the error of a cell.
    pub fn error(&self, picture: &Image) -> Result<Error, SizeMismatch> {
        let found = self.pictures.compare(picture)?.overall;
        // A product of two independent noises of variance 2v has the standard deviation 2v; this is the mean of many.
        let numbers = (3 * picture.pixels.len()) as f64;
        let least = LOST * 2.0 * self.pictures.mse() / numbers.sqrt();
        if found.mse >= least {
            return Ok(Error::Measured(found.relative_rmse));
        }
        let mean = self.pictures.picture().mean();
        let level = f64::from(mean.x + mean.y + mean.z) / 3.0;
        Ok(Error::Below((found.mse.max(0.0) + least).sqrt() / level))
    }
}

/// Files of a reference.
pub struct Given<'a> {
    first: (&'a Path, Windowed),
    half: Option<(&'a Path, Windowed)>,
}

impl<'a> Given<'a> {
    /// Reads the named files.
    pub fn read(
        first: Option<&'a Path>,
        half: Option<&'a Path>,
        limit: MemoryLimit,
    ) -> Result<Option<Self>, Failure> {
        let one = |path: &'a Path| Ok::<_, Failure>((path, read::windowed_within(path, limit)?));
        let Some(path) = first else { return Ok(None) };
        Ok(Some(Self { first: one(path)?, half: half.map(one).transpose()? }))
    }

    /// Returns width and height of the full image.
    pub fn size(&self) -> (u32, u32) {
        let (w, h) = self.first.1.full_size;
        (w as u32, h as u32)
    }
}

/// Returns the pixels `rect` of a file of the full image, which has the size `size`, or a file of exactly these pixels.
fn fitting(path: &Path, file: &Windowed, rect: PixelRect, size: (u32, u32)) -> Result<Image, Failure> {
    let (width, height) = (rect.width() as usize, rect.height() as usize);
    let wanted = match file.full_size {
        full if full == (size.0 as usize, size.1 as usize) => {
            Window { x: rect.x0 as usize, y: rect.y0 as usize, width, height }
        }
        full if full == (width, height) => Window::full(full),
        (w, h) => {
            let said = format!("the reference has {w}x{h} pixels and the cells have {width}x{height}");
            return Err(Failure::Arguments(format!("{}: {said}", path.display())));
        }
    };
    Ok(file.covering(wanted, &path.display().to_string())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn noisy(level: f32, noise: f32, seed: u32) -> Image {
        // ±1 by a hash of the pixel.
        let sign = |i: u32| {
            if (i.wrapping_mul(0x9E37_79B9) ^ seed).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 }
        };
        let pixels = (0..4096).map(|i| Vec3::splat(level + noise * sign(i ^ (seed << 16)))).collect();
        Image { width: 64, height: 64, pixels }
    }

    #[test]
    fn crops_are_taken_where_they_belong() {
        let rect = PixelRect { x0: 8, y0: 4, x1: 24, y1: 12 };
        let of = |full: (usize, usize), window: Window| {
            let picture = Image::filled(window.width, window.height, Vec3::ONE);
            let file = Windowed { picture, window, full_size: full };
            fitting(Path::new("r.exr"), &file, rect, (64, 64)).map(|p| (p.width, p.height))
        };
        let crop = Window { x: 8, y: 4, width: 16, height: 8 };
        for (full, window) in
            [((64, 64), Window::full((64, 64))), ((64, 64), crop), ((16, 8), Window::full((16, 8)))]
        {
            assert_eq!(of(full, window).unwrap(), (16, 8));
        }
        // Half of the needed pixels; another size.
        let half = Window { width: 8, ..crop };
        assert!(of((64, 64), half).unwrap_err().to_string().contains("8,4 to 16,12"));
        assert!(of((32, 32), Window::full((32, 32))).unwrap_err().to_string().contains("32x32"));
    }

    /// The noise of the reference is excluded from the errors; errors that it hides are reported as bounds.
    #[test]
    fn errors_are_free_of_the_reference() {
        let reference = Reference::of([noisy(1.0, 0.1, 1), noisy(1.0, 0.1, 2)], String::new());
        let Error::Measured(found) = reference.error(&noisy(1.0, 0.2, 3)).unwrap() else { panic!("lost") };
        assert!((found - 0.2).abs() < 0.02, "{found}");
        let Error::Below(limit) = reference.error(&noisy(1.0, 1e-3, 3)).unwrap() else { panic!("told") };
        assert!(limit > 1e-3 && limit < 0.05, "{limit}");
        assert!((reference.relative_rmse() - 0.07).abs() < 0.02 && !reference.is_exact());
    }
}
