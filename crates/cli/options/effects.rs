//! Options of the effects that are integrated over, and of the lens.

use crate::aliases;
use crate::values::{self, Color};
use clap::Args;
use dapple_integrator::Combine;
use dapple_integrator::camera::Aperture;
use dapple_integrator::sampling::SampleSet;

/// The integrals of the distribution tracer, and the lens. In the path tracer a count of 0 also switches the effect
/// off; other counts are ignored.
#[derive(Args, Clone, Debug, Default)]
pub struct EffectOptions {
    /// Samples over the pixel area: 4x4:stratified, 16:random, 6x6:grid, 9:sobol, 1; 0 = the pixel centre [default:
    /// 4x4]
    #[arg(long, value_name = "SAMPLES", value_parser = aliases::plan, help_heading = "Effects")]
    pub pixel: Option<SampleSet>,
    /// Samples over the lens; 0 = a pinhole [default: 4x4]
    #[arg(long, value_name = "SAMPLES", value_parser = aliases::plan, help_heading = "Effects")]
    pub lens: Option<SampleSet>,
    /// Times within the shutter interval; 0 = the time at which it opens [default: 16]
    #[arg(long, value_name = "SAMPLES", value_parser = aliases::plan, help_heading = "Effects")]
    pub time: Option<SampleSet>,
    /// Samples over each area light; 0 = all of its power from its centroid [default: 4x4]
    #[arg(long, value_name = "SAMPLES", value_parser = aliases::plan, help_heading = "Effects")]
    pub light: Option<SampleSet>,
    /// Directions of a rough reflection; 0 = a perfect mirror [default: 4x4]
    #[arg(long, value_name = "SAMPLES", value_parser = aliases::plan, help_heading = "Effects")]
    pub glossy: Option<SampleSet>,
    /// Directions of a rough refraction; 0 = a smooth surface [default: 1]
    #[arg(long, value_name = "SAMPLES", value_parser = aliases::plan, help_heading = "Effects")]
    pub refract: Option<SampleSet>,
    /// Directions over the hemisphere; 0 = no interreflection [default: 1]
    #[arg(long, value_name = "SAMPLES", value_parser = aliases::plan, help_heading = "Effects")]
    pub diffuse: Option<SampleSet>,
    /// nested: evaluate every integral in full at every sample of the outer ones; paired: one stratum of each per pixel
    /// sample [default: nested]
    #[arg(long, value_parser = aliases::named::<Combine>(aliases::NONE), value_name = "NAME", help_heading = "Effects")]
    pub combine: Option<Combine>,
    /// Samples of each integral after the first hit, for nested [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24), help_heading = "Effects")]
    pub secondary: Option<u32>,
    /// Constant ambient light on diffuse surfaces in place of interreflection (--diffuse 0), an approximation
    #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, help_heading = "Effects")]
    pub ambient: Option<Color>,
    /// Render even if a pixel takes more than 100 000 rays, or a settings file beside the scene asks for hours of
    /// rendering
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Effects")]
    pub yes: Option<bool>,

    /// Radius of the lens (half the side of a square aperture) in scene units; 0 = a pinhole [default: 0]
    #[arg(long, value_name = "R", allow_hyphen_values = true, value_parser = values::non_negative, help_heading = "Lens")]
    pub aperture_radius: Option<f32>,
    /// Focus distance along the view axis, in scene units [default: the surface at the image centre]
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = values::focus, help_heading = "Lens")]
    pub focus_distance: Option<f32>,
    /// Aperture shape: disk, square, blades:N or blades:N:DEGREES [default: disk]
    #[arg(long, value_parser = aliases::named::<Aperture>(aliases::APERTURES), value_name = "SHAPE", help_heading = "Lens")]
    pub aperture_shape: Option<Aperture>,
}
