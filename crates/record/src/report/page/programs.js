// @ts-check
// The head of the page: the answer, the paper's figure with the paired ratios under it, and the ranking.

/** The statements that answer the run's questions. */
function drawAnswer() {
  part("answer").append(
    ...data.answer.map(({ question, answer }) => el("div", { class: "statement" }, el("h3", {}, question), el("p", {}, ...prose(answer)))),
  );
  if (data.noise.length === 0) return;
  part("noise").hidden = false;
  part("noise").append(
    el("summary", {}, data.noise_in_short ?? ""),
    el("ul", {}, ...data.noise.map((note) => el("li", {}, note))),
  );
}

/** The row of a record with these cells. @param {string} file @param {Record<string, any>} cells */
function rowWith(file, cells) {
  return rows(file).filter((row) => Object.entries(cells).every(([name, value]) => row.cells[name] === value));
}

/** The time of whole programs by what is proposed and by its baseline, and their paired ratio. */
function drawPrograms() {
  const head = part("programs");
  if (data.programs.length === 0) {
    head.hidden = true;
    return;
  }
  const { subject, baseline } = data.programs[0];
  const [of, against] = [subject, baseline].map((id) => variantOf.get(id)?.label ?? id);
  const place = el("div", { class: "place" });
  head.append(
    el("h2", {}, "Time of whole programs"),
    el("p", { class: "about" }, "Each program runs to its first collision, or to its end. Bars at the marks are 95 % intervals over binaries, or over the launches of a single one."),
    place,
  );
  const legend = el(
    "p",
    { class: "legend" },
    ...[baseline, subject].map((id) => el("span", { class: "key" }, sample(id), variantOf.get(id)?.label ?? id)),
  );
  watch(() => {
    const totals = data.programs.map((row) => {
      const sources = rowWith("program_times.csv", { scene: row.scene, program: data.words.all });
      const dot = (/** @type {string} */ id, /** @type {number[] | null} */ ns) =>
        ns === null
          ? []
          : [
              {
                value: ns[0] / 1e6,
                low: ns[1] / 1e6,
                high: ns[2] / 1e6,
                look: id,
                title: `${variantOf.get(id)?.label ?? id}, ${row.scene}`,
                facts: /** @type {[string, string][]} */ ([["programs", row.programs], ["time", time(ns[0])]]),
                sources: sources.filter((source) => source.cells.variant === id && isDefault(id, policyOf(source))),
              },
            ];
      const ms = (/** @type {number[] | null} */ ns) => (ns === null ? "–" : number(ns[0] / 1e6));
      return {
        name: row.scene,
        said: `${ms(row.baseline_ns)} and ${ms(row.subject_ns)} ms`,
        dots: [...dot(baseline, row.baseline_ns), ...dot(subject, row.subject_ns)],
      };
    });
    const ratios = data.programs.map((row) => ({
      name: row.scene,
      said: `${interval(row.ratio, row.low, row.high)}  ${row.effect}`,
      dots: [
        {
          value: row.ratio,
          low: row.low,
          high: row.high,
          look: subject,
          title: `${of} / ${against}, ${row.scene}`,
          facts: /** @type {[string, string][]} */ ([["ratio", interval(row.ratio, row.low, row.high)], ["verdict", row.effect]]),
          sources: rowWith("ratios.csv", {
            scene: row.scene,
            metric: "program-time",
            stratum: data.words.all,
            variant: subject,
            baseline,
          }),
        },
      ],
    }));
    const values = totals.flatMap((line) => line.dots.map((dot) => dot.value));
    const log = Math.max(...values) > 20 * Math.min(...values);
    const [first, second] = [el("div"), el("div")];
    place.replaceChildren(legend, first, second);
    drawDots(first, { panels: [{ title: "", lines: totals }], log, unit: "time of the scene's programs, ms", from: log ? undefined : 0 });
    drawDots(second, {
      panels: [{ title: "", lines: ratios }],
      log: true,
      unit: `paired ratio; left of 1 ${innerWidth > NARROW ? `the ${of}` : "it"} is faster`,
      reference: 1,
    });
    oneStop(place);
  });
}

/** The row of `ratios.csv` that a place in the ranking has in a scene. @param {string} id @param {string} scene */
function placeIn(id, scene) {
  const { all } = data.words;
  const workload = data.ranked_by[scene];
  const metric = workload === "program-time" ? workload : "time";
  return rows("ratios.csv").find(
    ({ cells }) =>
      cells.scene === scene &&
      cells.stratum === all &&
      cells.metric === metric &&
      cells.workload === workload &&
      cells.variant === id &&
      cells.baseline === data.baselines[0] &&
      isDefault(id, cells.policy) &&
      isDefault(cells.baseline, cells.baseline_policy),
  );
}

/** The ranking as a table: the time ratio in each scene. */
function drawRanking() {
  const base = variantOf.get(data.baselines[0])?.label ?? data.baselines[0];
  const head = part("ranking");
  if (data.ranking.length === 0) {
    head.append(el("p", { class: "note" }, `This run has no times of ${base}, by which all others are ranked.`));
    return;
  }
  const lines = data.ranking.map((entry, i) => {
    const others = entry.kind !== "volume" && (i === 0 || data.ranking[i - 1].kind === "volume");
    const cells = scenes.map((scene) => {
      const row = placeIn(entry.variant, scene);
      if (!row) return el("td", { class: "right" }, entry.variant === data.baselines[0] ? "1" : "–");
      const { ratio } = row.cells;
      const [low, high] = endsOf(row);
      const ends = low === undefined ? "" : ` [${number(low)}, ${number(high)}]`;
      const cell = el("td", { class: "right" }, el("b", {}, number(ratio)), el("small", {}, ends));
      const facts = /** @type {[string, string][]} */ ([["time ratio", interval(ratio, low, high)], ["effect", row.cells.effect]]);
      return tells(cell, `${entry.label}, ${scene}`, facts, [row]);
    });
    return el(
      "tr",
      { class: others ? "others" : "" },
      el("td", { class: "right" }, entry.kind === "volume" ? data.places[i] : "–"),
      el("th", { scope: "row" }, sample(entry.variant), entry.label, entry.kind === "volume" ? null : el("small", {}, ` ${entry.kind}`)),
      ...cells,
    );
  });
  const table = el(
    "table",
    { class: "ranking" },
    el(
      "thead",
      {},
      el(
        "tr",
        {},
        el("th", { scope: "col" }, ""),
        el("th", { scope: "col" }, "safe variant"),
        ...scenes.map((scene) => el("th", { scope: "col", class: "right" }, scene)),
      ),
    ),
    el("tbody", {}, ...lines),
  );
  head.append(
    el("p", { class: "about" }, ...prose(`By ${data.quantity} relative to ${base}, with 95 % intervals; ordered by geometric mean. Below the rule: no volumes on the common tree.`)),
    oneStop(el("div", { class: "scroll" }, table)),
  );
}
