//! Rendered cells of a sheet: their labels, and their rows in the JSON output.

use super::reference::Error;
use dapple_integrator::Effect;
use dapple_integrator::imaging::sheet::Frame;
use dapple_integrator::sampling::Pattern;
use serde_json::{Value, json};

/// Code value of a cell that was not rendered.
const EMPTY: u8 = 40;

/// One cell of the sheet.
pub struct Rendered {
    pub count: u32,
    pub pattern: Pattern,
    pub frame: Frame,
    /// `None` if there was no time for it.
    pub found: Option<Found>,
}

/// Cost and error of a cell.
pub struct Found {
    pub rays: u64,
    pub seconds: f64,
    pub error: Error,
}

impl Rendered {
    /// Returns a cell for which there was no time.
    pub fn empty(count: u32, pattern: Pattern, width: usize, height: usize) -> Self {
        let frame = Frame { width, height, data: vec![EMPTY; 3 * width * height] };
        Self { count, pattern, frame, found: None }
    }

    /// Returns the label below the cell.
    pub fn label(&self, vary: Effect) -> String {
        let what = format!("{vary} {}, {}", self.count, self.pattern);
        let Some(found) = &self.found else { return format!("{what}\nnot rendered:\nno time left") };
        let error = match found.error {
            Error::Measured(x) => format!("relative RMSE {x:.4}"),
            Error::Below(x) => format!("relative RMSE below {x:.4}"),
            Error::Unknown => "error unknown".into(),
        };
        format!("{what}\n{} rays, {:.2} s\n{error}", short(found.rays), found.seconds)
    }

    /// Returns the row of the cell in the JSON output.
    pub fn json(&self) -> Value {
        let found = self.found.as_ref();
        let (told, below) = match found.map(|f| f.error) {
            Some(Error::Measured(x)) => (Some(x), None),
            Some(Error::Below(x)) => (None, Some(x)),
            _ => (None, None),
        };
        json!({
            "estimator": self.pattern.to_string(), "count": self.count, "rendered": found.is_some(),
            "rays": found.map(|f| f.rays), "render_seconds": found.map(|f| f.seconds),
            "relative_rmse": told, "relative_rmse_below": below,
        })
    }
}

/// Formats a count with about three digits.
pub fn short(count: u64) -> String {
    match count {
        0..1000 => count.to_string(),
        1000..1_000_000 => format!("{:.1} k", count as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} M", count as f64 / 1e6),
        _ => format!("{:.1} G", count as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_short() {
        assert_eq!(
            [0, 999, 1000, 15_500_000, 2_000_000_000].map(short),
            ["0", "999", "1.0 k", "15.5 M", "2.0 G"]
        );
    }
}
