//! Views of a run's machines for its report page.

use super::check;
use super::view::by_default;
use crate::check::Settings;
use crate::measure::Progress;
use crate::record::Manifest;
use crate::registry::Registry;
use crate::report::Inset;
use crate::scene::Scene;
use crate::view::{self, Choice};

/// Bytes that all views of a page may have together: with its records it stays below 8 MB.
const MOST_BYTES: usize = 4_500_000;

/// Levels of the trees in these views: the upper ones tell drift and looseness.
const LEVELS: u32 = 5;

/// A view of each scene of a run that is found with the content that was measured. What is too large is named with the
/// command that shows it.
pub fn insets(manifest: &Manifest, registry: &Registry, progress: &dyn Progress) -> Vec<Inset> {
    let asked = &manifest.request.scenes;
    let names: Vec<&String> = if asked.is_empty() {
        manifest.scenes.iter().map(|scene| &scene.name).collect()
    } else {
        asked.iter().collect()
    };
    let mut room = MOST_BYTES;
    names.into_iter().filter_map(|name| inset(name, manifest, registry, &mut room, progress)).collect()
}

/// Nothing, when the scene is not there, is another one by now, or cannot be shown: the report is no place to complain of that.
fn inset(
    name: &str,
    manifest: &Manifest,
    registry: &Registry,
    room: &mut usize,
    progress: &dyn Progress,
) -> Option<Inset> {
    let scene = Scene::find(name).ok()?;
    if scene.inputs.iter().any(|(path, hash)| manifest.inputs.get(path) != Some(hash)) {
        return None;
    }
    let choice = Choice {
        method: check::method(None, registry).ok()?,
        variants: by_default(registry),
        levels: LEVELS,
        up: view::upright(&scene),
        settings: Settings::standard(),
    };
    let data = view::gather(&scene, scene.program.as_ref(), &choice, progress).ok()?;
    let html = framed(&view::page(&data));
    let title = scene.name.clone();
    if html.len() > *room {
        let html =
            format!("<p class=\"about\">Too large for this page: <code>bvbench view {}</code></p>", escaped(name));
        return Some(Inset { title, html });
    }
    *room -= html.len();
    Some(Inset { title, html })
}

/// A page within a page, with a scope of its own, that begins to draw when it is scrolled to.
fn framed(page: &str) -> String {
    format!("<iframe class=\"view\" loading=\"lazy\" srcdoc=\"{}\"></iframe>\n", escaped(page))
}

/// Text for an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}
