//! `dapple rays`: the number of rays per pixel, by effect and depth, without rendering.

use crate::commands::render;
use crate::error::Failure;
use crate::load::{self, Source};
use crate::options::RenderOptions;
use crate::{effects, events, settings_file, standard_output, values};
use clap::ArgMatches;
use dapple_integrator::forecast::{DepthRow, Forecast, present_in};
use dapple_integrator::{Effect, MethodKind, Settings, forecast};
use serde_json::{Value, json};

/// Columns of the table, with the names of their effects.
const COLUMNS: [&str; 5] = ["light", "glossy", "refract", "diffuse", "path"];

/// Prints the forecast for `scene` with the sidecar's, the settings file's and the typed options.
pub fn run(scene: &str, typed: &ArgMatches) -> Result<(), Failure> {
    let source = Source::new(Some(scene));
    let options = settings_file::layered(source.path(), typed, "rays")?;
    events::start(&options);
    let loaded = load::load(&source, &options)?;
    let view = &load::camera(&loaded.scene, &options)?;
    let settings = render::settings(&options, view)?;
    render::warn(&loaded);
    effects::note_idle(&options, &settings, &loaded.scene, &view.camera);
    let told = RayTable {
        settings: &settings,
        present: present_in(&loaded.scene, &view.camera, &settings),
        forecast: forecast(&loaded.scene, &view.camera, &settings),
    };
    if RenderOptions::is(options.json) {
        standard_output::json(&told.json());
    } else {
        told.text(scene).iter().for_each(|line| standard_output::result(line));
    }
    Ok(())
}

/// The forecast and its context.
struct RayTable<'a> {
    settings: &'a Settings,
    present: Vec<Effect>,
    forecast: Forecast,
}

impl RayTable<'_> {
    fn text(&self, scene: &str) -> Vec<String> {
        let mut lines = vec![format!("{scene}: {}", self.method()), self.outer()];
        let columns = self.columns();
        let names = columns.iter().map(|name| format!("{name:>12}")).collect::<String>();
        lines.push(format!("{:>5}{:>12}{names}", "depth", "arriving"));
        for (depth, row) in self.forecast.rows.iter().enumerate() {
            let cells = columns.iter().map(|name| count(cell(row, name))).collect::<String>();
            lines.push(format!("{depth:>5}{}{cells}", count(row.arriving)));
        }
        if self.forecast.deeper > 0.0 {
            lines.push(format!("{:>5}{}", "more", count(self.forecast.deeper)));
        }
        let (total, [w, h]) = (self.forecast.total(), self.pixels());
        let picture = total * f64::from(w) * f64::from(h);
        lines.push(format!("at most {total} rays per pixel, {picture:.3e} for {w}x{h} pixels"));
        lines
            .push("an upper bound: every ray is assumed to hit the surface that spawns the most rays".into());
        lines
    }

    fn method(&self) -> String {
        let name = values::method_name(self.settings.kind());
        match self.settings.kind() {
            MethodKind::Path if self.settings.spp().is_none() => format!("{name}, for one sample per pixel"),
            MethodKind::Path => name.into(),
            MethodKind::Distribution => format!("{name}, {}", self.settings.combine()),
        }
    }

    /// Describes the camera rays, and the effects that the scene does not have.
    fn outer(&self) -> String {
        let [pixel, lens, time] = self.forecast.outer;
        let points = match self.settings.kind() {
            MethodKind::Path => format!("{pixel} samples"),
            MethodKind::Distribution => format!("{pixel} pixel x {lens} lens x {time} time"),
        };
        let rays = self.forecast.rows.first().map_or(0.0, |row| row.arriving);
        let absent = Effect::ALL.into_iter().filter(|(effect, _)| !self.present.contains(effect));
        let absent = absent.map(|(_, name)| name).collect::<Vec<_>>().join(", ");
        match absent.as_str() {
            "" => format!("{points} = {rays} camera rays per pixel"),
            _ => format!("{points} = {rays} camera rays per pixel; not in the scene: {absent}"),
        }
    }

    /// Returns the columns of the method.
    fn columns(&self) -> Vec<&'static str> {
        let path = |name: &&str| matches!(*name, "light" | "path");
        match self.settings.kind() {
            MethodKind::Path => COLUMNS.into_iter().filter(path).collect(),
            MethodKind::Distribution => COLUMNS.into_iter().filter(|name| *name != "path").collect(),
        }
    }

    fn pixels(&self) -> [u32; 2] {
        let rect = self.settings.rect();
        [rect.width(), rect.height()]
    }

    fn json(&self) -> Value {
        let [pixel, lens, time] = self.forecast.outer;
        let [w, h] = self.pixels();
        let depths = self.forecast.rows.iter().enumerate().map(|(depth, row)| {
            let mut line = json!({ "depth": depth, "arriving": row.arriving });
            self.columns().into_iter().for_each(|name| line[name] = json!(cell(row, name)));
            line
        });
        let combine = match self.settings.kind() {
            MethodKind::Path => Value::Null,
            MethodKind::Distribution => self.settings.combine().to_string().into(),
        };
        json!({
            "method": values::method_name(self.settings.kind()), "combine": combine,
            "outer": { "pixel": pixel, "lens": lens, "time": time },
            "depths": depths.collect::<Vec<_>>(), "deeper": self.forecast.deeper,
            "rays_per_pixel": self.forecast.total(), "is_upper_bound": true, "width": w, "height": h,
            "effects": self.present.iter().map(Effect::to_string).collect::<Vec<_>>(),
        })
    }
}

fn cell(row: &DepthRow, column: &str) -> f64 {
    match column {
        "light" => row.light,
        "glossy" => row.glossy,
        "refract" => row.refract,
        "diffuse" => row.diffuse,
        _ => row.path,
    }
}

/// Formats a count for its column.
fn count(rays: f64) -> String {
    if rays < 1e10 { format!("{rays:>12}") } else { format!("{rays:>12.4e}") }
}
