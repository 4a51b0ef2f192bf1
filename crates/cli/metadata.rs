//! EXR metadata: everything needed to reproduce the image, and nothing about where, when or how fast it was made.
//!
//! Matrices are OpenEXR's standard attributes, for row vectors (`v · M`, translation in the last row). Camera space is
//! glTF's: the camera looks along −z, +y is up. NDC runs from (0,0) at the top left of the full image to (1,1).

use crate::options::RenderOptions;
use crate::values;
use dapple_integrator::camera::{Camera, Projection, Shutter};
use dapple_integrator::imaging::picture::MetaValue;
use dapple_integrator::sampling::SampleSet;
use dapple_integrator::scene::{NamedCamera, Scene, Space, WorldPoint};
use dapple_integrator::{BITS, Combine, Effect, MethodKind, Settings, Stats};
use glam::{DMat4, DVec3, DVec4, Vec3};

/// Returns all attributes of a render.
pub fn attributes(
    options: &RenderOptions,
    settings: &Settings,
    stats: &Stats,
    view: &NamedCamera,
    scene: &Scene,
) -> Vec<(String, MetaValue)> {
    let (camera, space) = (view.camera.clone().fitted(settings.size), &scene.space);
    let to_camera = world_to_camera(&camera, space);
    let to_ndc = camera_to_ndc(&camera, space, settings.size) * to_camera;
    let text = |s: String| MetaValue::Text(s);
    vec![
        ("worldToCamera".into(), matrix(to_camera)),
        ("worldToNDC".into(), matrix(to_ndc)),
        ("software".into(), text(format!("dapple {}", env!("CARGO_PKG_VERSION")))),
        ("bits".into(), MetaValue::Int(BITS)),
        ("spp".into(), MetaValue::Int(i32::try_from(stats.spp).unwrap_or(i32::MAX))),
        ("seed".into(), text(settings.seed.to_string())),
        ("settings".into(), text(settings_text(options, settings, stats, view, scene))),
    ]
}

/// Returns the lines of a settings file that reproduces the image; an environment map has to lie beside it.
pub fn settings_text(
    options: &RenderOptions,
    settings: &Settings,
    stats: &Stats,
    view: &NamedCamera,
    scene: &Scene,
) -> String {
    let (w, h) = settings.size;
    let mut lines = vec![
        format!("method = \"{}\"", values::method_name(settings.kind())),
        format!("seed = {}", settings.seed),
        format!("max-bounces = {}", settings.max_bounces),
        format!("no-roulette = {}", !settings.roulette()),
        format!("filter = \"{}\"", settings.filter),
        format!("backfaces = \"{}\"", settings.backfaces),
        format!("size = \"{w}x{h}\""),
    ];
    lines.extend(options.choice.given().map(|(key, value)| format!("{key} = {}", quoted(value))));
    if !options.view.places_camera() {
        // As it was requested: several cameras may share a name.
        lines.push(format!("camera = {}", quoted(options.camera.as_deref().unwrap_or(&view.name))));
    }
    lines.extend(options.view.lines());
    match settings.kind() {
        MethodKind::Path => {
            // If the first round was not finished: the samples that some pixels have.
            let part = settings.path_tracer().and_then(|path| Some((path.of?, path.samples.clone())));
            lines.push(format!("spp = {}", part.as_ref().map_or(stats.spp, |(of, _)| *of).max(1)));
            let samples = part.map(|(_, samples)| format!("samples = \"{}:{}\"", samples.start, samples.end));
            lines.extend(samples);
            lines.push(format!("pattern = \"{}\"", settings.pattern));
            lines.push(format!("adaptive = {}", settings.adaptive()));
        }
        MethodKind::Distribution => {
            let secondary = settings.distribution_tracer().map_or(1, |d| d.secondary);
            let samples = settings.distribution_tracer().and_then(|d| d.samples.clone());
            lines.extend(samples.map(|samples| format!("samples = \"{}:{}\"", samples.start, samples.end)));
            lines.push(format!("combine = \"{}\"", settings.combine()));
            lines.push(format!("secondary = {secondary}"));
        }
    }
    for (effect, name) in Effect::ALL {
        let plan = plan_of(settings, effect);
        if settings.kind() == MethodKind::Distribution || plan.count() == 0 {
            lines.push(format!("{name} = \"{plan}\""));
        }
    }
    lines.extend(estimator_lines(settings));
    lines.extend(environment_lines(options));
    lines.extend(light_unit_line(options, scene));
    lines.extend(exposure_lines(settings, view, scene));
    lines.join("\n")
}

/// Returns the settings of the estimator that differ from the defaults.
fn estimator_lines(settings: &Settings) -> Vec<String> {
    let mut lines = Vec::new();
    if !settings.soft_terminator {
        lines.push("no-soft-terminator = true".into());
    }
    if settings.transparent_shadows {
        lines.push("transparent-shadows = true".into());
    }
    if settings.transparent {
        lines.push("transparent = true".into());
    }
    if let Some(clamp) = settings.clamp {
        lines.push(format!("clamp = {clamp}"));
    }
    if settings.ambient != Vec3::ZERO {
        let a = settings.ambient;
        lines.push(format!("ambient = [{}, {}, {}]", a.x, a.y, a.z));
    }
    lines
}

/// Returns the lens, the shutter and the crop.
fn exposure_lines(settings: &Settings, view: &NamedCamera, scene: &Scene) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(view.camera.lens.iter().flat_map(|lens| {
        let length = |render: f32| scene.space.length_to_world(f64::from(render));
        [
            format!("aperture-radius = {}", length(lens.radius) as f32),
            format!("focus-distance = {}", length(lens.focus_distance) as f32),
            format!("aperture-shape = \"{}\"", lens.aperture),
        ]
    }));
    if scene.at != 0.0 {
        lines.push(format!("at = {:?}", scene.at));
    }
    if scene.shutter != Shutter::default() {
        let Shutter { open, close } = scene.shutter;
        lines.push(format!("shutter = \"{open}:{close}\""));
    }
    if let Some(c) = settings.crop {
        lines.push(crop_line([c.x0, c.y0, c.x1, c.y1]));
    }
    lines
}

/// Returns the line of a crop: its columns from and to, and its rows.
pub fn crop_line([x0, y0, x1, y1]: [u32; 4]) -> String {
    format!("crop = [{x0}, {y0}, {x1}, {y1}]")
}

/// Returns the requested environment; the scene's own is part of the scene.
fn environment_lines(options: &RenderOptions) -> Vec<String> {
    let mut lines = Vec::new();
    // Without its folder, which says where the file is and not how the image was made.
    if let Some(name) = options.env.as_ref().and_then(|path| path.file_name()) {
        lines.push(format!("env = {}", quoted(&name.to_string_lossy())));
        lines.extend(options.env_rotation.map(|degrees| format!("env-rotation = {degrees}")));
        lines.push(format!("env-nearest = {}", !options.is_env_smooth()));
    }
    if let Some(c) = options.env_color {
        lines.push(format!("env-color = [{}, {}, {}]", c.0.x, c.0.y, c.0.z));
    }
    if !lines.is_empty() {
        lines.extend(options.env_intensity.map(|factor| format!("env-intensity = {factor}")));
    }
    lines
}

/// Returns the interpretation of the intensities of punctual lights, where it differs from the default.
fn light_unit_line(options: &RenderOptions, scene: &Scene) -> Option<String> {
    let taken = scene.light_unit.as_ref()?;
    let is_said = taken.is_photometric || options.light_unit.is_some();
    is_said.then(|| format!("light-unit = \"{}\"", taken.unit()))
}

/// Quotes text as TOML does.
fn quoted(text: &str) -> String {
    toml::Value::String(text.into()).to_string()
}

/// Returns the sample set that the render used: paired, every integral has as many samples as the pixel.
fn plan_of(settings: &Settings, effect: Effect) -> SampleSet {
    let (plan, n) = (settings.plans.of(effect), settings.plans.pixel.count().max(1));
    let paired = settings.kind() == MethodKind::Distribution && settings.combine() == Combine::Paired;
    if paired && plan.count() > 0 && plan.count() != n { SampleSet::new(n, plan.pattern) } else { plan }
}

/// Returns the matrix from world to camera space, both in scene units; column vectors.
fn world_to_camera(camera: &Camera, space: &Space) -> DMat4 {
    let WorldPoint(origin) = space.to_world(camera.origin);
    let row = |axis: glam::Vec3| {
        let axis: DVec3 = axis.as_dvec3();
        DVec4::from((axis, -axis.dot(origin)))
    };
    DMat4::from_cols(row(camera.right), row(camera.up), row(camera.backward), DVec4::W).transpose()
}

/// Returns the matrix from camera space to NDC, y down; depth is kept so that the matrix is invertible; column vectors.
fn camera_to_ndc(camera: &Camera, space: &Space, size: (u32, u32)) -> DMat4 {
    let aspect = f64::from(size.0) / f64::from(size.1);
    let rows = match camera.projection {
        // Divided by w = −z.
        Projection::Perspective { tan_half } => {
            let half = f64::from(tan_half);
            [
                DVec4::new(0.5 / (half * aspect), 0.0, -0.5, 0.0),
                DVec4::new(0.0, -0.5 / half, -0.5, 0.0),
                DVec4::new(0.0, 0.0, 0.0, 1.0),
                DVec4::new(0.0, 0.0, -1.0, 0.0),
            ]
        }
        Projection::Orthographic { half_height } => {
            let half = space.length_to_world(f64::from(half_height));
            [
                DVec4::new(0.5 / (half * aspect), 0.0, 0.0, 0.5),
                DVec4::new(0.0, -0.5 / half, 0.0, 0.5),
                DVec4::new(0.0, 0.0, -1.0, 0.0),
                DVec4::W,
            ]
        }
    };
    DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

/// Converts to row-vector order: the columns of the column-vector matrix, one after another.
fn matrix(m: DMat4) -> MetaValue {
    MetaValue::Matrix(m.as_mat4().to_cols_array())
}
#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera {
            origin: Vec3::new(1.0, 2.0, 3.0),
            right: Vec3::Z,
            up: Vec3::Y,
            backward: Vec3::NEG_X,
            projection,
            lens: None,
            motion: None,
            aspect: None,
            clip: None,
        }
    }

    #[test]
    fn corners_of_the_view_are_corners_of_ndc() {
        let space = Space { centre: DVec3::new(10.0, 0.0, 0.0), scale: 2.0 };
        for projection in
            [Projection::Perspective { tan_half: 0.5 }, Projection::Orthographic { half_height: 2.0 }]
        {
            let camera = camera(projection);
            let m = camera_to_ndc(&camera, &space, (20, 10)) * world_to_camera(&camera, &space);
            // One scene unit (two render units) high and two wide, two scene units in front of the camera.
            let half = 1.0;
            let centre = space.to_world(camera.origin).0 - camera.backward.as_dvec3() * 2.0;
            for (x, y, ndc) in [(-1.0, 1.0, (0.0, 0.0)), (1.0, -1.0, (1.0, 1.0)), (0.0, 0.0, (0.5, 0.5))] {
                let p = centre + camera.right.as_dvec3() * x * 2.0 * half + camera.up.as_dvec3() * y * half;
                let q = m * p.extend(1.0);
                assert!((q.x / q.w - ndc.0).abs() < 1e-6 && (q.y / q.w - ndc.1).abs() < 1e-6, "{q}");
            }
        }
    }
}
