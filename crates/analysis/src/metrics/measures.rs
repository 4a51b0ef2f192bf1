//! The error metrics and their constants.

/// The constants of the metrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// ε of relMSE (added to R²), and of MAPE and SMAPE (added to |R|). Default 0.01, which suits images whose mean is
    /// near 1.
    pub epsilon: f64,
    /// Fraction of the terms that trimmed relMSE excludes, the largest first. Default 0.001.
    pub trim: f64,
    /// Signal peak of PSNR. Default 1.
    pub peak: f64,
}

impl Default for Scale {
    fn default() -> Self {
        Self { epsilon: 0.01, trim: 0.001, peak: 1.0 }
    }
}

/// The metrics of one channel, or of all channels; NaN if no pixel could be compared.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Measures {
    /// Mean squared error; with halves an unbiased estimate of it, which may be negative.
    pub mse: f64,
    /// Root of `mse`; NaN if `mse` is negative.
    pub rmse: f64,
    /// RMSE divided by the mean of the reference.
    pub relative_rmse: f64,
    /// Mean of squared errors relative to R² + ε.
    pub relmse: f64,
    /// The same without the largest terms.
    pub relmse_trimmed: f64,
    /// Signed mean error: positive if the image is too bright.
    pub bias: f64,
    /// Mean absolute relative error.
    pub mape: f64,
    /// Mean symmetric absolute relative error, 0 to 1.
    pub smape: f64,
    /// Peak signal-to-noise ratio, decibels.
    pub psnr: f64,
    /// The largest absolute error of a channel of a pixel.
    pub max_error: f64,
    /// Column and row of the largest error from the top left; the first one if there are several.
    pub max_error_pixel: Option<[usize; 2]>,
}
