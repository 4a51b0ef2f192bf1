//! All closed-form scenes, in order.

use super::form::Form;
use super::{effects, rooms, surfaces};
use dapple_integrator::scene::SceneError;

/// All closed-form scenes in order of their ids.
///
/// # Errors
/// A scene cannot be built.
pub fn all() -> Result<Vec<Form>, SceneError> {
    let mut all = surfaces::forms()?;
    all.extend(effects::forms()?);
    all.extend(rooms::forms()?);
    all.sort_by_key(|form| form.id.trim_start_matches('E').parse::<u32>().unwrap_or(0));
    Ok(all)
}
