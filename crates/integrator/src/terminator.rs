//! Where does the shadow of a surface on itself begin, when its normals are smooth and its facets are flat?
//!
//! Interpolated and mapped normals light a facet as if it were curved, up to directions in which the flat facet shadows
//! itself: light would end at a hard edge along the facets. [Chiang 2019] takes light away before that edge is reached, by
//! a factor that falls from 1, where the normals agree, smoothly to 0 at the facet's own horizon. It never exceeds 1, so no
//! energy is gained. It depends on `wi` alone: as with shading normals themselves, reciprocity does not hold exactly.

use glam::Vec3;

/// What is left of light from `wi` (unit) reflected about the shading normal `ns` of a facet with normal `ng`, 0 to 1:
/// G + G² − G³ with G = min(1, (wi·ng)/((wi·ns)(ns·ng))) [Chiang 2019]. 1 where G is not a number, for then nothing is lit.
pub(crate) fn left(wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    let g = (wi.dot(ng) / (wi.dot(ns) * ns.dot(ng))).abs();
    if g < 1.0 { g * (1.0 + g * (1.0 - g)) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Facet up, shading normal tilted by `tilt` towards +x, light at `angle` from the facet's normal towards +x.
    fn at(tilt: f32, angle: f32) -> f32 {
        let of = |a: f32| Vec3::new(a.sin(), 0.0, a.cos());
        left(of(angle), of(tilt), Vec3::Z)
    }

    #[test]
    fn nothing_is_gained_and_nothing_is_lost_where_the_normals_agree() {
        for tilt in [0.0, 0.1, 0.5, 1.2] {
            for k in 0..1000 {
                let angle = (k as f32 / 1000.0 - 0.5) * std::f32::consts::PI;
                let f = at(tilt, angle);
                assert!((0.0..=1.0).contains(&f), "{tilt} {angle} {f}");
                if tilt == 0.0 {
                    assert!(f > 1.0 - 1e-6);
                }
            }
        }
        assert_eq!(left(Vec3::X, Vec3::Z, Vec3::Z), 1.0, "in the surface: 0/0");
    }

    #[test]
    fn light_fades_out_before_the_facets_own_horizon() {
        let half = std::f32::consts::FRAC_PI_2;
        let steps: Vec<f32> = (0..100).map(|k| at(0.3, half - 0.005 * k as f32)).collect();
        assert!(steps[0] < 1e-6 && steps.windows(2).all(|w| w[0] <= w[1]) && steps[99] > 0.8, "{steps:?}");
        // Smooth at its full end: the slope of G + G² − G³ is 0 at G = 1.
        assert!(1.0 - at(0.3, 0.05) < 1e-3);
    }
}
