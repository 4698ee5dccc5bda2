//! What is measured: which variants with which tree policies on which scenes.

use super::binaries::{self, Binary};
use super::folder;
use super::profile::{Budget, Profile};
use super::shard::Shard;
use crate::method::Kind;
use crate::record::manifest::{BinaryEntry, Request, SceneEntry, VariantEntry};
use crate::record::rows::CaseKey;
use crate::record::{ALL_VARIANTS, CaseRow, Manifest, NULL_VARIANT, PROGRAM_TIME};
use crate::registry::{Registry, Variant};
use crate::scene::{Scene, SceneError};
use crate::tree::{Policy, SplitRule};
use crate::workload;
use std::collections::BTreeMap;
use thiserror::Error;

/// The policy that every volume is also measured with, so that fits can be compared on one and the same topology.
pub const CONTROL_POLICY: Policy = Policy::shared(SplitRule::Median);

/// What the user asked for.
#[derive(Clone, Debug)]
pub struct Selection {
    /// How much.
    pub profile: Profile,
    /// Scene names or paths; empty for those of [`Scene::BY_DEFAULT`].
    pub scenes: Vec<String>,
    /// Variant ids, or [`ALL_VARIANTS`]; empty for the standard ones.
    pub variants: Vec<String>,
    /// Workload names; empty for all.
    pub workloads: Vec<String>,
    /// Tree policies for every volume; empty for each one's own default and [`CONTROL_POLICY`].
    pub policies: Vec<Policy>,
    /// Seed of all randomness.
    pub seed: u64,
}

/// A variant with a tree policy: one column of the comparison.
#[derive(Clone, Debug)]
pub struct Case {
    /// The variant.
    pub variant: Variant,
    /// How its trees are built; `None` for methods without a tree of ours.
    pub policy: Option<Policy>,
    /// Its name in the records: the variant's id, or [`crate::record::NULL_VARIANT`].
    pub id: String,
}

/// A plan that can be carried out: everything named exists and is loaded.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What was asked for.
    pub selection: Selection,
    /// The variants chosen.
    pub variants: Vec<Variant>,
    /// Every variant with each of its policies.
    pub cases: Vec<Case>,
    /// The scenes, loaded.
    pub scenes: Vec<Scene>,
    /// Amounts.
    pub budget: Budget,
    /// Binaries that carry out the launches in turn; none for the one that is running.
    pub binaries: Vec<Binary>,
    /// Whether raw rows are compressed.
    pub gzip: bool,
    /// The part of it that is carried out; `None` for all.
    pub shard: Option<Shard>,
}

/// Why a plan cannot be made.
#[derive(Debug, Error)]
pub enum PlanError {
    /// A variant is not registered.
    #[error("there is no variant `{id}`; `bvbench list` shows them: {known}")]
    NoSuchVariant {
        /// What was asked for.
        id: String,
        /// What there is.
        known: String,
    },
    /// A scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No two parts of a scene can move against each other, and it names no pair.
    #[error("scene `{name}` has no pair of parts to measure")]
    NoPairs {
        /// The scene.
        name: String,
    },
    /// Two scenes have one name, so that their rows could not be told apart.
    #[error("two of the scenes are called `{name}`")]
    SameName {
        /// The name.
        name: String,
    },
    /// No workload of a scene has the name asked for.
    #[error("scene `{scene}` has no workload `{asked}`; it has {known}")]
    NoSuchWorkload {
        /// The scene.
        scene: String,
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// A request that this version cannot carry out.
    #[error("the request of the manifest: {0}")]
    Request(String),
}

impl Case {
    /// A variant with its own policy.
    pub fn of(variant: &Variant) -> Self {
        Self { variant: *variant, policy: variant.policy, id: variant.info.id.to_owned() }
    }

    /// The case as the manifest of a study with one policy for each variant holds it.
    pub fn entry(&self) -> VariantEntry {
        entry(&self.variant, self.policy.into_iter())
    }

    /// The case as `cases.csv` holds it, under the only policy of its variant.
    pub fn row(&self) -> CaseRow {
        let Variant { info, kind, .. } = &self.variant;
        let asked_everywhere = u8::from(self.is_asked_everywhere());
        CaseRow { asked_everywhere, ..CaseRow::new(self.key(), info.label, *kind, info.safe) }
    }

    /// Variant and policy as records hold them.
    pub fn key(&self) -> CaseKey {
        let without_tree = CaseKey::without_tree(&self.id);
        self.policy.map_or(without_tree.clone(), |Policy { split, axes, leaf }| CaseKey {
            split: split.to_string(),
            split_axes: axes.to_string(),
            leaf,
            ..without_tree
        })
    }

    /// Name in `cases.csv`.
    pub fn name(&self) -> String {
        self.key().name()
    }

    /// Whether a verification asks the case's own query at every pose. A safe volume is asked at a sample of them, and answers the others by the
    /// witness argument; a variant that promises nothing is asked, since its misses are what the verification is about.
    pub fn is_asked_everywhere(&self) -> bool {
        let Variant { kind, info, .. } = &self.variant;
        kind.is_ours() && !(*kind == Kind::Volume && info.safe)
    }
}

impl Plan {
    /// Resolves a selection against a registry and loads its scenes.
    ///
    /// # Errors
    /// An unknown variant, a scene that cannot be loaded, or one without a workload that was asked for.
    pub fn new(selection: Selection, registry: &Registry) -> Result<Self, PlanError> {
        let names: Vec<String> = match selection.scenes.as_slice() {
            [] => Scene::BY_DEFAULT.iter().map(|&name| name.to_owned()).collect(),
            names => names.to_vec(),
        };
        Self::of_scenes(selection, names.iter().map(|name| Scene::find(name)), registry)
    }

    /// As [`Self::new`], with what loading the scenes of the selection gives.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_scenes(
        selection: Selection,
        loaded: impl IntoIterator<Item = Result<Scene, SceneError>>,
        registry: &Registry,
    ) -> Result<Self, PlanError> {
        let variants = choose(&selection.variants, registry)?;
        let cases = variants.iter().flat_map(|variant| cases_of(variant, &selection.policies)).collect();
        let mut scenes: Vec<Scene> = Vec::new();
        for scene in loaded {
            let scene = scene?;
            if scene.pairs.is_empty() {
                return Err(PlanError::NoPairs { name: scene.name });
            }
            if scenes.iter().any(|other| other.name == scene.name) {
                return Err(PlanError::SameName { name: scene.name });
            }
            let known = workload::names(&scene);
            let is_known = |name: &str| name == PROGRAM_TIME || known.contains(&name);
            if let Some(asked) = selection.workloads.iter().find(|name| !is_known(name)) {
                let (asked, known) = (asked.clone(), known.join(", "));
                return Err(PlanError::NoSuchWorkload { scene: scene.name, asked, known });
            }
            scenes.push(scene);
        }
        let (budget, gzip) = (selection.profile.budget(), selection.profile == Profile::Full);
        Ok(Self { budget, selection, variants, cases, scenes, binaries: Vec::new(), gzip, shard: None })
    }

    /// The plan that a manifest's request was made from; its binaries are not known.
    ///
    /// # Errors
    /// A profile or policy of another version, an unknown variant, or a scene that cannot be loaded.
    pub fn of_request(request: Request, registry: &Registry) -> Result<Self, PlanError> {
        let policy = |text: &String| text.parse::<Policy>().map_err(|error| PlanError::Request(error.to_string()));
        let policies = request.policies.iter().map(policy).collect::<Result<_, _>>()?;
        let selection = Selection {
            profile: request.profile.parse().map_err(PlanError::Request)?,
            scenes: request.scenes,
            variants: request.variants,
            workloads: request.workloads,
            policies,
            seed: request.seed,
        };
        let mut plan = Self::new(selection, registry)?;
        let launches = request.launches / request.binaries.max(1);
        let cold_poses = request.cold_poses as usize;
        plan.budget = Budget { launches, cold_poses, blocks: request.blocks, ..plan.budget }.over(request.binaries);
        Ok(plan)
    }

    /// Whether unit `place` of `places` of a kind is to be carried out.
    pub fn has_unit(&self, place: usize, places: usize) -> bool {
        self.shard.is_none_or(|shard| shard.has(place, places))
    }

    /// The case that the null method duplicates: the reference variant's default, or the first volume's.
    pub fn null_reference(&self) -> Option<&Case> {
        let volumes = || self.cases.iter().filter(|case| case.variant.kind.has_volumes() && case.variant.info.safe);
        volumes().find(|case| case.variant.is_reference).or_else(|| volumes().next())
    }

    /// The request as the manifest holds it.
    pub fn request(&self) -> Request {
        Request {
            profile: self.selection.profile.to_string(),
            seed: self.selection.seed,
            scenes: self.selection.scenes.clone(),
            variants: self.variants.iter().map(|variant| variant.info.id.to_owned()).collect(),
            policies: self.selection.policies.iter().map(ToString::to_string).collect(),
            workloads: self.selection.workloads.clone(),
            verify_poses: self.budget.verify_poses as u64,
            measure_poses: self.budget.measure_poses as u64,
            program_steps: self.budget.program_steps as u64,
            blocks: self.budget.blocks,
            launches: self.budget.launches,
            binaries: self.budget.binaries,
            cold_poses: self.budget.cold_poses as u64,
        }
    }

    /// The manifest of a study of this plan that begins now.
    pub fn manifest(&self) -> Manifest {
        let whole = Manifest {
            inputs: self.inputs(),
            scenes: self.scene_entries(),
            null_of: self.null_reference().map_or_else(String::new, |case| case.id.clone()),
            binaries: self.binary_entries(),
            ..folder::begun(self.request(), self.variant_entries())
        };
        Shard::manifest(self.shard, whole)
    }

    /// The binaries of the plan, or the one that is running.
    pub fn binary_entries(&self) -> Vec<BinaryEntry> {
        let given: Vec<BinaryEntry> = self.binaries.iter().map(|binary| binary.entry.clone()).collect();
        if given.is_empty() { binaries::running().into_iter().collect() } else { given }
    }

    /// The cases as `cases.csv` holds them, the null duplicate last.
    pub fn case_rows(&self) -> Vec<CaseRow> {
        let row = |case: &Case| CaseRow { default: u8::from(self.is_default(case)), ..case.row() };
        let null = self.null_reference().map(|case| CaseRow {
            label: format!("{}, second copy", case.variant.info.label),
            duplicate_of: case.name(),
            ..row(&Case { id: NULL_VARIANT.to_owned(), ..case.clone() })
        });
        self.cases.iter().map(row).chain(null).collect()
    }

    /// Whether a case has the first of its variant's policies.
    pub fn is_default(&self, case: &Case) -> bool {
        let first = self.cases.iter().find(|other| other.variant.info.id == case.variant.info.id);
        first.is_some_and(|first| first.policy == case.policy)
    }

    /// The variants as the manifest holds them.
    pub fn variant_entries(&self) -> Vec<VariantEntry> {
        let policies = |variant| cases_of(variant, &self.selection.policies).into_iter().filter_map(|case| case.policy);
        self.variants.iter().map(|variant| entry(variant, policies(variant))).collect()
    }

    /// The scenes as the manifest holds them.
    pub fn scene_entries(&self) -> Vec<SceneEntry> {
        let entry = |scene: &Scene| SceneEntry {
            name: scene.name.clone(),
            title: scene.title.clone(),
            triangles: scene.parts.iter().map(|part| (part.name.clone(), part.mesh.faces().len() as u64)).collect(),
            pairs: scene.pairs.iter().map(|&pair| scene.pair_name(pair)).collect(),
        };
        self.scenes.iter().map(entry).collect()
    }

    /// Content hashes of everything the scenes were made from.
    pub fn inputs(&self) -> BTreeMap<String, String> {
        self.scenes.iter().flat_map(|scene| scene.inputs.clone()).collect()
    }
}

pub(super) fn choose(ids: &[String], registry: &Registry) -> Result<Vec<Variant>, PlanError> {
    if ids.is_empty() {
        return Ok(registry.variants().iter().filter(|variant| variant.is_standard).copied().collect());
    }
    if ids.iter().any(|id| id == ALL_VARIANTS) {
        return Ok(registry.variants().to_vec());
    }
    if let Some(id) = ids.iter().find(|id| registry.find(id).is_none()) {
        let known = registry.variants().iter().map(|variant| variant.info.id).collect::<Vec<_>>().join(", ");
        return Err(PlanError::NoSuchVariant { id: id.clone(), known });
    }
    // Registry order, each once, whatever the order and repetition on the command line: one request, one result.
    let chosen = |variant: &&Variant| ids.iter().any(|id| id == variant.info.id);
    Ok(registry.variants().iter().filter(chosen).copied().collect())
}

fn entry(variant: &Variant, policies: impl Iterator<Item = Policy>) -> VariantEntry {
    VariantEntry {
        id: variant.info.id.to_owned(),
        label: variant.info.label.to_owned(),
        reference: variant.info.reference.to_owned(),
        safe: variant.info.safe,
        kind: variant.kind,
        policies: policies.map(|policy| policy.to_string()).collect(),
    }
}

fn cases_of(variant: &Variant, asked: &[Policy]) -> Vec<Case> {
    let policies = match (variant.policy, asked) {
        (None, _) => vec![None],
        (Some(own), []) => vec![Some(own), Some(CONTROL_POLICY)],
        // One that is asked for twice counts once.
        (Some(_), asked) => asked
            .iter()
            .enumerate()
            .filter(|(at, policy)| !asked[..*at].contains(policy))
            .map(|(_, policy)| Some(*policy))
            .collect(),
    };
    let case = |policy| Case { variant: *variant, policy, id: variant.info.id.to_owned() };
    policies.into_iter().map(case).collect()
}
