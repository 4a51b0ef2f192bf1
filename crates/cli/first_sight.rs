//! Checks against black images: adds a default light if the file's own lights are too dim, and warns if the image stays
//! dark.

use crate::default_light::Look;
use crate::error;
use crate::options::RenderOptions;
use dapple_integrator::Backfaces;
use dapple_integrator::lights::Light;
use dapple_integrator::scene::studio::{self, STUDIO};
use dapple_integrator::scene::{NamedCamera, Object, Scene, Warning};
use glam::Vec3;

/// Advice about views that show more.
const ELSEWHERE: &str = "--orbit 30,20 looks at the whole scene, --camera and --look-at choose another view";

/// Advice about culled back faces.
const SHOWN: &str = "--backfaces shown renders the back faces that the camera sees through";

/// What may be done about a dark image.
pub struct Bounds {
    /// Size of the image in pixels.
    pub size: (u32, u32),
    pub backfaces: Backfaces,
    /// Whether the scene has only its own lights, so that a default light may be added.
    pub may_light: bool,
    /// Whether the render computes lighting, so that the image can be dark.
    pub follows_light: bool,
    /// What replaces the default light, if the environment is not lit.
    pub instead: &'static str,
}

/// Adds a default light to a scene that would be nearly black, and warns if its image stays dark.
pub fn settle(scene: &mut Scene, view: &NamedCamera, bounds: &Bounds) {
    let Bounds { size, backfaces, may_light, follows_light, instead } = *bounds;
    if !look(scene, view, backfaces).shows_a_surface(size) {
        let is_culled =
            backfaces != Backfaces::Shown && look(scene, view, Backfaces::Shown).shows_a_surface(size);
        return say_nothing_is_seen(scene, view, may_light, is_culled);
    }
    if !follows_light {
        return;
    }
    if may_light
        && scene.environment.is_none()
        && !scene.lights.is_empty()
        && look(scene, view, backfaces).is_nearly_black()
    {
        scene.surround(studio::studio());
        scene.warnings.push(Warning(format!("the lights of the scene leave it nearly black: {STUDIO}")));
    }
    let shows = look(scene, view, backfaces);
    if !may_light && scene.environment.is_none() {
        if let Some(why) = why_unlit(&shows, instead) {
            scene.warnings.push(Warning(why));
        }
    } else if is_surrounded_by_light(scene) && shows.is_nearly_black() && shows.appears_black() {
        let why = why_dark(&shows, view);
        scene.warnings.push(Warning(why));
    }
}

/// Returns why the lights of the scene alone leave it dark, if they do; `instead` says what replaces the default light.
fn why_unlit(look: &Look<'_>, instead: &str) -> Option<String> {
    let material = |object: &Object| &look.scene.materials[object.material as usize];
    if look.scene.lights.is_empty() {
        let is_dark = !look.scene.objects.iter().any(|object| material(object).unlit);
        return is_dark
            .then(|| format!("nothing in the scene emits light, and {instead}: the image is black"));
    }
    let is_dark = look.is_nearly_black() && look.appears_black();
    is_dark.then(|| format!("the lights of the scene leave it nearly black, and {instead}"))
}

fn look<'a>(scene: &'a Scene, view: &'a NamedCamera, backfaces: Backfaces) -> Look<'a> {
    Look { scene, camera: &view.camera, backfaces }
}

fn is_surrounded_by_light(scene: &Scene) -> bool {
    let shines = |light: &Light| matches!(light, Light::Environment(e) if e.mean() != Vec3::ZERO);
    scene.environment.is_some_and(|i| scene.lights.get(i as usize).is_some_and(shines))
}

fn say_nothing_is_seen(scene: &mut Scene, view: &NamedCamera, may_light: bool, is_culled: bool) {
    if may_light {
        scene.surround(studio::studio());
    }
    let is_studio = may_light || scene.warnings.iter().any(|w| w.0.contains(STUDIO));
    scene.warnings.retain(|w| !w.0.contains(STUDIO));
    let shown = match (is_studio, scene.environment.is_some()) {
        (true, _) => "the image shows only a soft studio environment (--env none removes it)",
        (false, true) => "the image shows only the environment",
        (false, false) => "the image is black",
    };
    let said = match scene.objects.is_empty() {
        true => format!("the scene has no surfaces: {shown}"),
        false if is_culled => {
            format!("{} sees only back faces, which are culled: {shown}; {SHOWN}", called(view))
        }
        false => format!("{} sees no surface: {shown}; {ELSEWHERE}", called(view)),
    };
    scene.warnings.push(Warning(said));
}

/// Returns why the surrounding light does not reach the visible surfaces, and a remedy.
fn why_dark(look: &Look<'_>, view: &NamedCamera) -> String {
    let camera = called(view);
    if look.is_of_black_surfaces() {
        return format!("the surfaces that {camera} sees reflect almost no light: they are nearly black");
    }
    if !look.is_enclosed() {
        let shown = Look { backfaces: Backfaces::Shown, ..*look };
        let helps =
            if look.backfaces == Backfaces::Shown || shown.is_nearly_black() { ELSEWHERE } else { SHOWN };
        return format!(
            "almost no light reaches the surfaces that {camera} sees: they are nearly black; {helps}"
        );
    }
    let culled = Look { backfaces: Backfaces::Culled, ..*look };
    let opens = match culled.is_nearly_black() || !culled.shows_a_surface((1, 1)) {
        true => "",
        false => ", --backfaces culled opens single-sided walls",
    };
    format!(
        "{camera} is in a closed space that no light enters: the image is nearly black; --orbit 30,20 looks at it from \
         outside{opens}"
    )
}

fn called(view: &NamedCamera) -> String {
    format!("camera '{}'", error::short(&view.name))
}

/// Determines what these options permit.
pub fn bounds(options: &RenderOptions, size: (u32, u32), may_light: bool) -> Bounds {
    let follows_light = options.reads().light;
    let instead = match options.has_no_environment() {
        true => "--env none prevents the default light",
        false => "the environment that is given is black",
    };
    let may_light = may_light && follows_light;
    Bounds { size, backfaces: options.backfaces(), may_light, follows_light, instead }
}
