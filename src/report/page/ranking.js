// @ts-check
// The ranking, and the figures of the page's head.

/** The row of `ratios.csv` that a place in the ranking has in a scene. @param {string} id @param {string} scene */
function placeIn(id, scene) {
  const { all } = data.words;
  const metric = rows("ratios.csv").some(({ cells }) => cells.metric === "program-time") ? "program-time" : "time";
  return rows("ratios.csv").find(
    ({ cells }) =>
      cells.scene === scene &&
      cells.stratum === all &&
      cells.metric === metric &&
      cells.variant === id &&
      cells.baseline === data.baselines[0] &&
      isDefault(id, cells.policy) &&
      isDefault(cells.baseline, cells.baseline_policy),
  );
}

/** The rows of `summary.csv` over all strata of a variant's default trees. @param {string} id */
function verifiedOf(id) {
  return rows("summary.csv").filter(
    (row) => row.cells.variant === id && row.cells.stratum === data.words.all && isDefault(id, policyOf(row)),
  );
}

/** The ranking as dots: the mean large, each scene small. */
function drawRanking() {
  const base = variantOf.get(data.baselines[0])?.label ?? data.baselines[0];
  const place = card(
    "ranking",
    `Time relative to ${base}`,
    "Safe volumes under their default tree policies by the time of whole programs, or without programs the query time of a workload: the large dot is the geometric mean over the scenes, the small ones are the scenes with their 95 % intervals. Unsafe volumes are left out whatever their speed, for a method can look fast by missing collisions. Below the ranking, with square marks, what is more or less than a volume on the common tree: engines of ours with trees and vector arithmetic of their own, other libraries' whole systems, controls.",
  );
  let position = 0;
  const lines = data.ranking.map((entry) => {
    const sources = scenes.flatMap((scene) => placeIn(entry.variant, scene) ?? []);
    const each = sources.map((row) => ({
      value: row.cells.ratio,
      low: row.cells.low,
      high: row.cells.high,
      tone: "plain",
      small: true,
      title: `${entry.label}, ${row.cells.scene}`,
      facts: /** @type {[string, string][]} */ ([
        ["time ratio", interval(row.cells.ratio, row.cells.low, row.cells.high)],
        ["clusters", number(row.cells.clusters)],
      ]),
      sources: [row],
    }));
    const verified = verifiedOf(entry.variant);
    const missed = verified.reduce((sum, row) => sum + row.cells.missed, 0);
    const colliding = verified.reduce((sum, row) => sum + row.cells.contacts, 0);
    const mean = {
      value: entry.ratio,
      tone: toneOf(entry.ratio, entry.ratio),
      title: entry.label,
      facts: /** @type {[string, string][]} */ ([
        ["geometric mean", number(entry.ratio)],
        ["scenes", String(entry.scenes)],
        ["contacts missed", `${number(missed)} of ${number(colliding)}`],
      ]),
      sources: sources.length > 0 ? sources : verified,
    };
    const rank = entry.kind === "volume" ? `${++position}.  ` : "";
    return {
      name: `${rank}${entry.label}${entry.kind === "volume" ? "" : ` (${entry.kind})`}`,
      square: entry.kind !== "volume",
      said: `${number(entry.ratio)} ×`,
      dots: [...each, mean],
    };
  });
  watch(() =>
    drawDots(place, {
      panels: [{ title: "", lines }],
      log: true,
      unit: `query time / query time of ${base}, 95 %`,
      reference: 1,
    }),
  );
}

/** Better than the line, worse, or undecided. @param {number} low @param {number} high */
function toneOf(low, high) {
  if (high < 1) return "less";
  return low > 1 ? "more" : "even";
}

/** What a reader wants to know first. */
function drawFacts() {
  const { request } = data.manifest;
  const safe = rows("summary.csv").filter(
    (row) =>
      row.cells.stratum === data.words.all && ["volume", "engine"].includes(variantOf.get(row.cells.variant)?.kind ?? ""),
  );
  const missedBy = (/** @type {boolean} */ promise) =>
    safe.filter((row) => isUnsafe(row.cells.variant) !== promise).reduce((sum, row) => sum + row.cells.missed, 0);
  const first = data.ranking.find((entry) => entry.kind === "volume");
  const base = variantOf.get(data.baselines[0])?.label ?? data.baselines[0];
  /** @type {[string, string, string][]} */
  const facts = [
    [number(request.verify_poses * scenes.length), "posed pairs verified", `against exact truth in ${scenes.length} scenes`],
    [number(missedBy(true)), "contacts missed by safe volumes", "above grazing, in all cases"],
    [number(missedBy(false)), "contacts missed by unsafe ones", "they look fast, and report collisions as free"],
    [
      first ? `${number(first.ratio)} ×` : "–",
      first ? `${first.label}: the fastest safe volume` : "no volume was timed",
      `time relative to ${base}`,
    ],
  ];
  part("facts").append(
    ...facts.map(([figure, what, how]) =>
      el("div", { class: "fact" }, el("b", {}, figure), el("span", {}, what), el("small", {}, how)),
    ),
  );
  if (data.noise.length > 0) {
    part("noise").hidden = false;
    part("noise").append(
      el("strong", {}, "Noisy run. "),
      "Something disturbed the timings: read verdicts on speed with caution; counts and misses are not affected.",
      el("ul", {}, ...data.noise.map((note) => el("li", {}, note))),
    );
  }
}
