//! Views of a run's machines for its report page.

use super::check;
use super::view::by_default;
use crate::check::Settings;
use crate::measure::{Progress, Silent};
use crate::record::Manifest;
use crate::registry::Registry;
use crate::report::Inset;
use crate::scene::Scene;
use crate::view::{self, Choice};
use rayon::prelude::*;

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
    progress.begin("viewing the machines", names.len() as u64);
    let view_of = |name: &String| {
        let view = inset(name, manifest, registry);
        progress.advance(1);
        Some((name.clone(), view?))
    };
    let views: Vec<(String, Inset)> = names.into_par_iter().filter_map(view_of).collect();
    let mut room = MOST_BYTES;
    let fitting = |(name, view): (String, Inset)| {
        if view.html.len() <= room {
            room -= view.html.len();
            return view;
        }
        let command = escaped(&format!("bvbench view {name}"));
        Inset { html: format!("<p class=\"about\">Too large for this page: <code>{command}</code></p>"), ..view }
    };
    views.into_iter().map(fitting).collect()
}

/// Nothing, when the scene is not there, is another one by now, or cannot be shown: the report is no place to complain of that.
fn inset(name: &str, manifest: &Manifest, registry: &Registry) -> Option<Inset> {
    let scene = Scene::find(name).ok()?;
    if scene.inputs.iter().any(|(path, hash)| manifest.inputs.get(path) != Some(hash)) {
        return None;
    }
    let choice = Choice {
        method: check::method(None, registry).ok()?,
        registry,
        variants: by_default(registry),
        levels: LEVELS,
        up: view::upright(&scene),
        settings: Settings::standard(),
        notes: check::not_examined,
    };
    let data = view::gather(&scene, scene.program.as_ref(), &choice, &Silent).ok()?;
    Some(Inset { title: scene.name.clone(), html: framed(&view::page(&data)) })
}

/// A page within a page, with a scope of its own, that begins to draw when it is scrolled to.
fn framed(page: &str) -> String {
    format!("<iframe class=\"view\" loading=\"lazy\" srcdoc=\"{}\"></iframe>\n", escaped(page))
}

/// Text for an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}
