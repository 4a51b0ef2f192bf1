//! What the cells of a sheet are held against: a file, two, or two independent renders by the other tracer.

use crate::error::Failure;
use dapple_analysis::converge::Reference as Pictures;
use dapple_analysis::metrics::SizeMismatch;
use dapple_integrator::Settings;
use dapple_integrator::imaging::{Image, MemoryLimit, Window, Windowed, read};
use dapple_integrator::math::PixelRect;
use std::path::Path;

/// So many standard deviations of what the reference's noise does to a squared error, errors are not told.
const LOST: f64 = 4.0;

/// Where errors are measured from.
pub struct Reference {
    pictures: Pictures,
    /// How it came to be.
    pub said: String,
}

/// The error of a cell as relative RMSE.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error {
    /// Without the reference's noise, where it has two halves.
    Told(f64),
    /// At most this: less is lost in the noise of the reference.
    Below(f64),
    /// There is no reference.
    Unknown,
}

impl Reference {
    /// Two independent halves.
    pub fn of(halves: [Image; 2], said: String) -> Self {
        Self { pictures: Pictures::Halves(halves), said }
    }

    /// The pixels that `settings` renders, of the files that were given.
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

    /// Whether its own noise counts as error of the cells.
    pub fn is_exact(&self) -> bool {
        matches!(self.pictures, Pictures::Exact(_))
    }

    /// Its own relative RMSE; 0 where it is taken as exact.
    pub fn relative_rmse(&self) -> f64 {
        self.pictures.relative_rmse()
    }

    /// The error of a cell.
    pub fn error(&self, picture: &Image) -> Result<Error, SizeMismatch> {
        let found = self.pictures.compare(picture)?.overall;
        // A product of two independent noises of variance 2v has the standard deviation 2v; this is the mean of many.
        let numbers = (3 * picture.pixels.len()) as f64;
        let least = LOST * 2.0 * self.pictures.mse() / numbers.sqrt();
        if found.mse >= least {
            return Ok(Error::Told(found.relative_rmse));
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
    /// Reads what was named.
    pub fn read(
        first: Option<&'a Path>,
        half: Option<&'a Path>,
        limit: MemoryLimit,
    ) -> Result<Option<Self>, Failure> {
        let one = |path: &'a Path| Ok::<_, Failure>((path, read::windowed_within(path, limit)?));
        let Some(path) = first else { return Ok(None) };
        Ok(Some(Self { first: one(path)?, half: half.map(one).transpose()? }))
    }

    /// Width and height of the full picture.
    pub fn size(&self) -> (u32, u32) {
        let (w, h) = self.first.1.full_size;
        (w as u32, h as u32)
    }
}

/// The pixels `rect` of a file of the full picture, which is `size` large, or a file that is just as large as they are.
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
        // Half of what is needed; another size.
        let half = Window { width: 8, ..crop };
        assert!(of((64, 64), half).unwrap_err().to_string().contains("8,4 to 16,12"));
        assert!(of((32, 32), Window::full((32, 32))).unwrap_err().to_string().contains("32x32"));
    }

    /// The reference's own noise is not in the errors; what it hides is called so.
    #[test]
    fn errors_are_free_of_the_reference() {
        let reference = Reference::of([noisy(1.0, 0.1, 1), noisy(1.0, 0.1, 2)], String::new());
        let Error::Told(found) = reference.error(&noisy(1.0, 0.2, 3)).unwrap() else { panic!("lost") };
        assert!((found - 0.2).abs() < 0.02, "{found}");
        let Error::Below(limit) = reference.error(&noisy(1.0, 1e-3, 3)).unwrap() else { panic!("told") };
        assert!(limit > 1e-3 && limit < 0.05, "{limit}");
        assert!((reference.relative_rmse() - 0.07).abs() < 0.02 && !reference.is_exact());
    }
}
