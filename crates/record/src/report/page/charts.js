// @ts-check
// The charts of the run: ratios, times and counts, building, costs.

/** The metrics of `ratios.csv`. @type {[string, string][]} */
const METRICS = [
  ["program-time", "time of whole programs"],
  ["program-time-cold", "time of whole programs, cold"],
  ["time", "query time"],
  ["volume-tests", "volume tests"],
  ["triangle-tests", "triangle tests"],
  ["build", "build time"],
];

/** What `summary.csv` tells of a query: column, words, whether it is a time. @type {[string, string, boolean][]} */
const MEASURES = [
  ["mean_ns", "mean time", true],
  ["query_p50_ns", "median of single queries", true],
  ["query_p95_ns", "95 % of single queries", true],
  ["query_p99_ns", "99 % of single queries", true],
  ["query_max_ns", "slowest single query", true],
  ["volume_tests", "volume tests", false],
  ["triangle_tests", "triangle tests", false],
];

/**
 * Panels by scene, the cases in one order in all of them: by the geometric mean of their values.
 * @param {Row[]} found
 * @param {(row: Row) => number} valueOf
 * @param {(row: Row) => Line} lineOf
 * @returns {Panel[]}
 */
function panelsOf(found, valueOf, lineOf) {
  /** @type {Map<string, number[]>} */
  const logs = new Map();
  for (const row of found) {
    const name = caseName(row);
    logs.set(name, [...(logs.get(name) ?? []), Math.log(Math.max(valueOf(row), 1e-12))]);
  }
  const mean = (/** @type {Row} */ row) => {
    const own = logs.get(caseName(row)) ?? [0];
    return own.reduce((sum, log) => sum + log, 0) / own.length;
  };
  const sorted = [...found].sort((a, b) => mean(a) - mean(b) || compare(caseName(a), caseName(b)));
  return scenes
    .map((scene) => ({ title: scene, lines: sorted.filter((row) => row.cells.scene === scene).map(lineOf) }))
    .filter((panel) => panel.lines.length > 0);
}

/** The workloads of some rows, but the control's. @param {Row[]} all */
function workloadsOf(all) {
  return [...new Set(all.map((row) => String(row.cells.workload)))].filter((workload) => workload !== "control").sort();
}

/** The workload that is shown first: one by which a scene is ranked. @param {string[]} workloads */
function firstOf(workloads) {
  return Object.values(data.ranked_by).find((workload) => workloads.includes(workload)) ?? workloads[0];
}

/** Ratios to a baseline. */
function drawRatios() {
  const all = rows("ratios.csv");
  const metrics = METRICS.filter(([metric]) => all.some(({ cells }) => cells.metric === metric && cells.variant !== data.words.null));
  if (metrics.length === 0) return;
  const workloads = workloadsOf(all.filter((row) => row.cells.metric === "time"));
  const chart = { metric: metrics[0][0], baseline: data.baselines[0], workload: firstOf(workloads) };
  const labels = data.baselines.map((id) => /** @type {[string, string]} */ ([id, variantOf.get(id)?.label ?? id]));
  const place = card(
    "charts-ratios",
    "Compared with a baseline",
    "Paired ratios with their 95 % intervals; left of the line a variant needs less than the baseline. Hollow marks are unsafe variants: they may miss contacts.",
    [
      choice("Measure", metrics, chart.metric, (metric) => {
        chart.metric = metric;
        update();
      }),
      choice("Workload", workloads.map((id) => [id, id]), chart.workload, (workload) => {
        chart.workload = workload;
        update();
      }),
      choice("Baseline", labels, chart.baseline, (baseline) => {
        chart.baseline = baseline;
        update();
      }),
    ],
  );
  function update() {
    const [, words] = METRICS.find(([metric]) => metric === chart.metric) ?? METRICS[0];
    const whole = chart.metric.startsWith("program-time") ? chart.metric : chart.metric === "build" ? "-" : undefined;
    const stratum = whole === undefined ? chosen.stratum : whole === "-" ? "-" : data.words.all;
    const found = all.filter(
      (row) =>
        isChosen(row) &&
        row.cells.metric === chart.metric &&
        row.cells.workload === (whole ?? chart.workload) &&
        row.cells.stratum === stratum &&
        row.cells.baseline === chart.baseline &&
        isDefault(chart.baseline, row.cells.baseline_policy),
    );
    const panels = panelsOf(
      found,
      (row) => row.cells.ratio,
      (row) => {
        const { ratio, clusters, scene, variant } = row.cells;
        const [low, high] = endsOf(row);
        const said = interval(ratio, low, high);
        return {
          name: caseName(row),
          said,
          dots: [
            {
              value: ratio,
              low,
              high,
              look: variant,
              title: `${caseName(row)}, ${scene}`,
              facts: [
                [`${words} ratio`, said],
                ["poses", row.cells.stratum],
                ["clusters", number(clusters)],
              ],
              sources: [row],
            },
          ],
        };
      },
    );
    const base = variantOf.get(chart.baseline)?.label ?? chart.baseline;
    drawDots(place, { panels, log: true, unit: `${words} / ${words} of ${base}`, reference: 1 });
  }
  watch(update);
}

/** Times and counts of a query. */
function drawQueries() {
  const all = rows("summary.csv").filter((row) => row.cells.variant !== data.words.null);
  const workloads = workloadsOf(all);
  const chart = { measure: MEASURES[0], workload: firstOf(workloads) };
  const place = card(
    "charts-queries",
    "A query",
    "Means have 95 % intervals over poses, quantiles are over chunks of poses. Two methods are to be compared by their paired ratios above, not by these intervals.",
    [
      choice(
        "Measure",
        MEASURES.map(([id, words]) => [id, words]),
        chart.measure[0],
        (id) => {
          chart.measure = MEASURES.find((measure) => measure[0] === id) ?? MEASURES[0];
          update();
        },
      ),
      choice("Workload", workloads.map((id) => [id, id]), chart.workload, (workload) => {
        chart.workload = workload;
        update();
      }),
    ],
  );
  function update() {
    const [column, words, isTime] = chart.measure;
    // A count of none has no place on a logarithmic scale, and no time was taken of what was only counted.
    const { workload } = chart;
    const isThere = (/** @type {Row} */ { cells }) =>
      cells.workload === workload && cells.stratum === chosen.stratum && cells[column] > 0;
    const found = all.filter((row) => isChosen(row) && isThere(row));
    const panels = panelsOf(
      found,
      (row) => row.cells[column],
      (row) => {
        const { cells } = row;
        const ends = endsOf(row);
        const [low, high] = column === "mean_ns" ? ends : [undefined, undefined];
        const said = isTime ? time(cells[column]) : number(cells[column]);
        /** @type {[string, string][]} */
        const facts = [
          ["poses", `${cells.stratum}, ${number(cells.poses)}`],
          ["mean", time(cells.mean_ns)],
          ["interval", ends.map(time).join(" to ") || "–"],
          ["median", time(cells.query_p50_ns)],
          ["99 %", time(cells.query_p99_ns)],
          ["volume tests", number(cells.volume_tests)],
          ["triangle tests", number(cells.triangle_tests)],
        ];
        return {
          name: caseName(row),
          said,
          dots: [
            { value: cells[column], low, high, look: cells.variant, title: `${caseName(row)}, ${cells.scene}`, facts, sources: [row] },
          ],
        };
      },
    );
    drawDots(place, { panels, log: true, unit: isTime ? `${words} of a query, ns` : `${words} of a query, mean` });
  }
  watch(update);
}

/**
 * Points of one curve per case.
 * @param {Row[]} found
 * @param {(row: Row) => Point} pointOf
 * @returns {Curve[]}
 */
function curvesOf(found, pointOf) {
  /** @type {Map<string, Curve>} */
  const curves = new Map();
  for (const row of found) {
    const name = caseName(row);
    // Another policy of the same variant has its colour and marker, and a dash.
    const dashed = !isDefault(row.cells.variant, policyOf(row));
    if (!curves.has(name)) curves.set(name, { look: row.cells.variant, dashed, name, points: [] });
    curves.get(name)?.points.push(pointOf(row));
  }
  return [...curves.values()];
}

/** Frames by scene. @param {Row[]} found @param {(row: Row) => Point} pointOf @returns {Frame[]} */
function framesOf(found, pointOf) {
  return scenes
    .map((scene) => ({
      title: scene,
      curves: curvesOf(
        found.filter((row) => row.cells.scene === scene),
        pointOf,
      ),
    }))
    .filter((frame) => frame.curves.length > 0);
}

/** What building costs and what it buys. */
function drawBuilding() {
  const all = rows("repay.csv");
  if (all.length === 0) return;
  const place = card(
    "charts-building",
    "What building costs, and what it buys",
    "Each mark is a case: the time to build the trees of all parts, and the mean time of a query. Lower left is better.",
  );
  watch(() =>
    drawCurves(place, {
      x: "build, ms",
      y: "query, µs",
      logX: true,
      logY: true,
      joined: false,
      frames: framesOf(
        all.filter((row) => isChosen(row) && row.cells.query_ns > 0),
        (row) => ({
          x: row.cells.build_ns / 1e6,
          y: row.cells.query_ns / 1e3,
          title: `${caseName(row)}, ${row.cells.scene}`,
          sources: [row],
          facts: [
            ["build", time(row.cells.build_ns)],
            ["query", time(row.cells.query_ns)],
            ["repaid after queries", row.cells.queries === null ? "never" : number(row.cells.queries)],
          ],
        }),
      ),
    }),
  );
}

/** Measured and predicted times. */
function drawCosts() {
  const all = rows("cost_chunks.csv");
  if (all.length === 0) return;
  const place = card(
    "charts-costs",
    "Do counts explain times?",
    "Each mark is a chunk of poses: its measured time, and the time predicted from its counts by costs fitted to the other scenes. On the line the prediction is right.",
  );
  watch(() =>
    drawCurves(place, {
      x: "measured, µs per query",
      y: "predicted, µs per query",
      logX: true,
      logY: true,
      joined: false,
      diagonal: true,
      frames: framesOf(
        all.filter((row) => isChosen(row) && (chosen.stratum === data.words.all || row.cells.stratum === chosen.stratum)),
        (row) => ({
          x: row.cells.measured_ns / 1e3,
          y: row.cells.predicted_ns / 1e3,
          title: `${caseName(row)}, ${row.cells.scene}`,
          sources: [row],
          facts: [
            ["chunk", `${row.cells.chunk}, ${row.cells.stratum}`],
            ["measured", time(row.cells.measured_ns)],
            ["predicted", time(row.cells.predicted_ns)],
            ["volume tests", number(row.cells.volume_tests)],
            ["triangle tests", number(row.cells.triangle_tests)],
          ],
        }),
      ),
    }),
  );
}
