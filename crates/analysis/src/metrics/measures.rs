//! The measures of an error, and the constants that they depend on.

/// The constants that measures depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// ε of relMSE (added to R²), and of MAPE and SMAPE (added to |R|): 0.01 suits pictures whose mean is near 1.
    pub epsilon: f64,
    /// Share of the terms that trimmed relMSE leaves out, the largest first: 0.001.
    pub trim: f64,
    /// Signal peak of PSNR: 1.
    pub peak: f64,
}

impl Default for Scale {
    fn default() -> Self {
        Self { epsilon: 0.01, trim: 0.001, peak: 1.0 }
    }
}

/// The measures of one channel, or of all; NaN where no pixel could be compared.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Measures {
    /// Mean squared error; with halves an unbiased estimate of it, possibly below zero.
    pub mse: f64,
    /// Its root; NaN below zero.
    pub rmse: f64,
    /// RMSE divided by the mean of the reference.
    pub relative_rmse: f64,
    /// Mean of squared errors relative to R² + ε.
    pub relmse: f64,
    /// The same without its largest terms.
    pub relmse_trimmed: f64,
    /// Signed mean error: positive where the picture is too bright.
    pub bias: f64,
    /// Mean absolute relative error.
    pub mape: f64,
    /// Mean symmetric absolute relative error, 0 to 1.
    pub smape: f64,
    /// Peak signal-to-noise ratio, decibels.
    pub psnr: f64,
    /// The largest absolute error of a channel of a pixel.
    pub max_error: f64,
    /// Where it is, column and row from the top left; the first if there are several.
    pub max_error_pixel: Option<[usize; 2]>,
}
