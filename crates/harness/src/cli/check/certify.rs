//! `--certify`: writes the certificate, and what it says for a reader.

use super::super::{note, say};
use crate::certify::{Certificate, Doubt, Verdict, certify};
use crate::measure::{Progress, timer};
use crate::record::file::write_text;
use crate::registry::Variant;
use crate::scene::{ProgramRun, Scene};
use anyhow::Result;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Doubts that are told one by one.
const TOLD: usize = 40;

/// A certificate that was written.
pub(super) struct Written {
    certificate: Certificate,
    /// The variant that the search uses.
    variant: Option<&'static str>,
    search_s: f64,
}

impl Written {
    pub(super) fn new(
        file: &Path,
        scene: &Scene,
        run: &ProgramRun,
        variant: Option<&Variant>,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let (ns, certificate) = timer::time(|| certify(scene, run, variant, progress));
        let certificate = certificate?;
        write_text(file, &certificate.text)?;
        Ok(Self { certificate, variant: variant.map(|variant| variant.info.id), search_s: super::seconds(ns) })
    }

    /// Lines of the blocks that are not proved free, each with what is in doubt. Rapids near a workpiece that the check cuts, one of `cut`, are left out: the check
    /// has decided on them.
    pub(super) fn unproved(&self, scene: &Scene, cut: &[usize]) -> Vec<(u32, String)> {
        let mut pairs: BTreeMap<(u32, Verdict), BTreeSet<String>> = BTreeMap::new();
        for Doubt { line, pair, verdict, .. } in &self.certificate.doubts {
            if *verdict != Verdict::Stock || ![pair.a, pair.b].iter().any(|part| cut.contains(part)) {
                pairs.entry((*line, *verdict)).or_default().insert(scene.pair_name(*pair));
            }
        }
        let told = |(&line, &verdict): (&u32, &Verdict)| {
            let what = if verdict == Verdict::Collision { "proved to touch" } else { "not proved free of contact" };
            let names: Vec<String> = pairs.remove(&(line, verdict))?.into_iter().collect();
            Some((line, format!("{what}: {}", names.join(", "))))
        };
        self.certificate.blocks.iter().filter_map(told).collect()
    }

    /// What a terminal shows.
    pub(super) fn print(&self, scene: &Scene, file: &Path) {
        let Self { certificate, search_s, .. } = self;
        let doubts: Vec<&Doubt> = certificate.doubts.iter().filter(|doubt| doubt.verdict != Verdict::Stock).collect();
        for doubt in doubts.iter().take(TOLD) {
            say(line(scene, doubt));
        }
        if doubts.len() > TOLD {
            note(format!("and {} more; --json has them all", doubts.len() - TOLD));
        }
        for (pair, why) in &certificate.skipped {
            if matches!(*why, "ignored" | "allowed") {
                say(format!("not certified: {}, {why}", scene.pair_name(*pair)));
            }
        }
        let neighbours = certificate.skipped.iter().filter(|(_, why)| *why == "neighbours").count();
        if neighbours > 0 {
            say(format!("not certified: {neighbours} pairs of the machine's structure with one joint between them"));
        }
        let [free, stock, collision, unresolved] =
            [Verdict::Free, Verdict::Stock, Verdict::Collision, Verdict::Unresolved]
                .map(|verdict| certificate.count(verdict));
        for (count, what, which) in [
            (certificate.cutting.len(), "the workpiece", "in which it feeds"),
            (stock, "what is left of the workpiece", "with a rapid near or in it"),
        ] {
            let blocks = if count == 1 { "block" } else { "blocks" };
            if count > 0 {
                say(format!("not certified: the cutter against {what}, in {count} {blocks} {which}"));
            }
        }
        say(format!(
            "{}: of {} blocks {free} are free (proved), {stock} of all but the workpiece, {collision} collide (proved), {unresolved} are unresolved, for {} pairs; {search_s:.2} s, {} bytes",
            file.display(),
            certificate.blocks.len(),
            certificate.examined,
            certificate.text.len()
        ));
    }

    pub(super) fn as_json(&self, scene: &Scene) -> Value {
        let Self { certificate, variant, search_s } = self;
        let names = |pair: crate::scene::Pair| [pair.a, pair.b].map(|part| scene.parts[part].name.clone());
        let doubt = |doubt: &Doubt| {
            json!({
                "line": doubt.line, "move": doubt.nth, "pair": names(doubt.pair), "verdict": doubt.verdict.name(), "within": doubt.within, "size_mm": doubt.size_mm,
            })
        };
        json!({
            "method": variant, "blocks": certificate.blocks.len(), "free": certificate.count(Verdict::Free), "stock": certificate.count(Verdict::Stock), "collision": certificate.count(Verdict::Collision),
            "unresolved": certificate.count(Verdict::Unresolved), "pairs": certificate.examined, "intervals": certificate.intervals,
            "planes": certificate.planes, "bytes": certificate.text.len(), "search_s": search_s,
            "doubts": certificate.doubts.iter().map(doubt).collect::<Vec<_>>(),
            "not_certified": certificate.skipped.iter().map(|(pair, why)| json!({ "pair": names(*pair), "why": why })).collect::<Vec<_>>(),
        })
    }
}

/// A doubt for a reader.
fn line(scene: &Scene, doubt: &Doubt) -> String {
    let Doubt { line, nth, pair, within: [from, to], size_mm, verdict } = doubt;
    let (place, pair) = (format!("line {line}, move {nth}"), scene.pair_name(*pair));
    match (verdict, size_mm) {
        (Verdict::Collision, Some(_)) if to <= from => {
            let begin = if *from > 0.0 { format!("{from:.9}") } else { "the beginning".to_owned() };
            format!("proved: {place}: {pair} are in contact from {begin} of the move on")
        }
        (Verdict::Collision, Some(size_mm)) => format!(
            "proved: {place}: {pair} first touch between {from:.9} and {to:.9} of the move, within {size_mm:.6} mm of travel"
        ),
        (_, Some(size_mm)) => format!(
            "unresolved: {place}: {pair} from {from:.9} to {to:.9} of the move, the search stopped {size_mm:.6} mm apart"
        ),
        (_, None) => format!(
            "unresolved: {place}: {pair} from {from:.9} to {to:.9} of the move, nothing bounds the way of the axes where the search stopped"
        ),
    }
}
