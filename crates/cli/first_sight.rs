//! A picture is never black without a word: a default light where the file's own is too little, and one line where even that
//! shows nothing.

use crate::default_light::Look;
use crate::error;
use crate::options::RenderOptions;
use dapple_integrator::Backfaces;
use dapple_integrator::lights::Light;
use dapple_integrator::scene::studio::{self, STUDIO};
use dapple_integrator::scene::{NamedCamera, Scene, Warning};
use glam::Vec3;

/// Where else to look.
const ELSEWHERE: &str = "--orbit 30,20 looks at the whole scene, --camera and --look-at choose another view";

/// What may be done about a dark picture.
pub struct Bounds {
    /// In pixels.
    pub size: (u32, u32),
    pub backfaces: Backfaces,
    /// The scene has no other light than its own, and may get some.
    pub may_light: bool,
    /// Light is followed, so that there is something to be dark.
    pub follows_light: bool,
}

/// Lights a scene that would be nearly black, and says what keeps its picture dark all the same.
pub fn settle(scene: &mut Scene, view: &NamedCamera, bounds: &Bounds) {
    let Bounds { size, backfaces, may_light, follows_light } = *bounds;
    if !look(scene, view, backfaces).shows_a_surface(size) {
        return say_nothing_is_seen(scene, view, may_light);
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
        scene.warnings.push(Warning(format!("the scene's own light leaves it nearly black: {STUDIO}")));
    }
    if is_surrounded_by_light(scene) && look(scene, view, backfaces).is_nearly_black() {
        let why = why_dark(&look(scene, view, backfaces), view);
        // It does not light what is seen.
        scene.warnings.retain(|w| !w.0.contains(STUDIO));
        scene.warnings.push(Warning(why));
    }
}

fn look<'a>(scene: &'a Scene, view: &'a NamedCamera, backfaces: Backfaces) -> Look<'a> {
    Look { scene, camera: &view.camera, backfaces }
}

fn is_surrounded_by_light(scene: &Scene) -> bool {
    let shines = |light: &Light| matches!(light, Light::Environment(e) if e.mean() != Vec3::ZERO);
    scene.environment.is_some_and(|i| scene.lights.get(i as usize).is_some_and(shines))
}

fn say_nothing_is_seen(scene: &mut Scene, view: &NamedCamera, may_light: bool) {
    if may_light {
        scene.surround(studio::studio());
    }
    let is_studio = may_light || scene.warnings.iter().any(|w| w.0.contains(STUDIO));
    scene.warnings.retain(|w| !w.0.contains(STUDIO));
    let shown = match (is_studio, scene.environment.is_some()) {
        (true, _) => "the picture shows a soft studio environment alone (--env none leaves it out)",
        (false, true) => "the picture shows the environment alone",
        (false, false) => "the picture is black",
    };
    let said = match scene.objects.is_empty() {
        true => format!("there is no surface in the scene: {shown}"),
        false => format!("{} sees no surface: {shown}; {ELSEWHERE}", called(view)),
    };
    scene.warnings.push(Warning(said));
}

/// Why the light that is all around does not light what is seen, and what helps.
fn why_dark(look: &Look<'_>, view: &NamedCamera) -> String {
    let camera = called(view);
    if look.is_of_black_surfaces() {
        return format!("what {camera} sees reflects next to no light: the picture is nearly black");
    }
    if !look.is_enclosed() {
        let shown = Look { backfaces: Backfaces::Shown, ..*look };
        let helps = if look.backfaces == Backfaces::Shown || shown.is_nearly_black() {
            ELSEWHERE
        } else {
            "--backfaces shown shows the backs of walls that it looks through"
        };
        return format!("next to no light reaches what {camera} sees: the picture is nearly black; {helps}");
    }
    let culled = Look { backfaces: Backfaces::Culled, ..*look };
    let opens = match culled.is_nearly_black() || !culled.shows_a_surface((1, 1)) {
        true => "",
        false => ", --backfaces culled opens single-sided walls",
    };
    format!(
        "{camera} stands in a closed space that no light gets into: the picture is nearly black; --orbit 30,20 looks at it from \
         outside{opens}"
    )
}

fn called(view: &NamedCamera) -> String {
    format!("camera '{}'", error::short(&view.name))
}

/// What may be done by these options.
pub fn bounds(options: &RenderOptions, size: (u32, u32), may_light: bool) -> Bounds {
    let follows_light = options.reads().light;
    Bounds { size, backfaces: options.backfaces(), may_light: may_light && follows_light, follows_light }
}
