// @ts-check
// What the page shows: the run's tables, each row with the CSV file and the line it comes from.

/** @typedef {{file: string, line: number, cells: Record<string, any>}} Row a row of a record */
/** @typedef {{file: string, columns: string[], rows: any[][]}} Packed a record as the page carries it: line number, then cells */
/** @typedef {{id: string, label: string, reference: string, safe: boolean, kind: string, policies: string[]}} Variant */
/** @typedef {{id: string, sentence: string, source: string, group: string, primary: number | null, cells: [string, number[]][], reason: string | null}} Claim */
/** @typedef {{id: string, name: string, words: string, subject: string, baseline: string}} Reading */
/** @typedef {{light: string, dark: string, path: string, hollow: boolean}} Look colour and marker of a variant, as in the figures */
/** @typedef {{scene: string, programs: string, subject: string, baseline: string, subject_ns: number[] | null, baseline_ns: number[] | null, ratio: number, low: number, high: number, effect: string}} ProgramTotals */
/** @typedef {{variant: string, label: string, kind: string, ratio: number, scenes: number}} Ranked */
/**
 * @typedef {object} Data
 * @property {any} manifest
 * @property {{all: string, null: string, whole: string[], strata: string[], bands: string[]}} words names that the records use
 * @property {string} source where the claims come from
 * @property {string[]} baselines
 * @property {{question: string, answer: string}[]} answer
 * @property {ProgramTotals[]} programs
 * @property {Claim[]} claims
 * @property {[string[], string[]][]} blocks readings, and the sentences that share them
 * @property {Record<string, Look>} looks
 * @property {Reading[]} readings
 * @property {Ranked[]} ranking
 * @property {string[]} places the places of the ranking, in brackets when speed is decided in no scene
 * @property {Record<string, string>} ranked_by the workload by which each scene is ranked
 * @property {string} quantity what the ranking compares, in words
 * @property {string[]} noise
 * @property {string | null} noise_in_short
 * @property {number[]} standing lines of `claims.csv` that stand for a claim as a whole
 * @property {{title: string, svg: string}[]} figures
 * @property {Record<string, Packed>} tables
 * @property {string[]} left_out records that are too large for the page
 */

/** @type {Data} */
const data = JSON.parse(text("data-of-the-run"));

/** The text of an element of the document. @param {string} id */
function text(id) {
  return document.getElementById(id)?.textContent ?? "{}";
}

/** @type {Record<string, Row[]>} */
const unpacked = {};

/** The rows of a record by its file's name; none when the run has no such file. @param {string} file @returns {Row[]} */
function rows(file) {
  const packed = data.tables[file];
  if (!packed) return [];
  unpacked[file] ??= packed.rows.map(([line, ...cells]) => ({
    file,
    line,
    cells: Object.fromEntries(packed.columns.map((column, i) => [column, cells[i]])),
  }));
  return unpacked[file];
}

/** @type {Variant[]} */
const variants = data.manifest.variants.filter((/** @type {Variant} */ v) => v.id !== data.words.null);
/** @type {string[]} */
const scenes = data.manifest.scenes.map((/** @type {any} */ scene) => scene.name);
const variantOf = new Map(variants.map((variant) => [variant.id, variant]));

/** The ends of a row's interval; none without one, and of a single cluster, whose spread is unknown. @param {Row} row @returns {number[]} */
function endsOf({ cells }) {
  const { clusters, low = cells.mean_low_ns, high = cells.mean_high_ns } = cells;
  return clusters !== 1 && typeof low === "number" && typeof high === "number" ? [low, high] : [];
}

/** The policy of a row, which has it in one cell or in three. @param {Row} row @returns {string} */
function policyOf(row) {
  const { policy, split, split_axes, leaf } = row.cells;
  return policy ?? `${split}/${split_axes}/${leaf}`;
}

/** Whether a policy is its variant's default. @param {string} id @param {string} policy */
function isDefault(id, policy) {
  const policies = variantOf.get(id)?.policies ?? [];
  return policies.length === 0 || policies[0] === policy;
}

/** Whether a variant's speed must not be praised, since it may miss contacts. @param {string} id */
function isUnsafe(id) {
  const variant = variantOf.get(id);
  return variant !== undefined && ["volume", "engine", "sampling"].includes(variant.kind) && !variant.safe;
}

/** The name of a case: the variant's label, with its policy where that is not the default. @param {Row} row */
function caseName(row) {
  const id = row.cells.variant;
  const label = variantOf.get(id)?.label ?? id;
  const policy = policyOf(row);
  return isDefault(id, policy) ? label : `${label}, ${policy}`;
}
