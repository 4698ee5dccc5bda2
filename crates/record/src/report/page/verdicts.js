// @ts-check
// All verdicts as a table with filters.

/** Verdicts with their signs, in the order of tables. @type {Record<string, string>} */
const SIGNS = { supported: "✓", refuted: "✕", undecided: "?", "not-applicable": "=", "not-judged": "–" };

const standing = new Set(data.standing);

/** A verdict as a badge. @param {string} verdict @param {string} [words] */
function badge(verdict, words = verdict) {
  return el(
    "span",
    { class: `badge ${verdict}` },
    el("span", { class: "sign", "aria-hidden": "true" }, SIGNS[verdict] ?? "·"),
    words,
  );
}

/** What to tell of a verdict. @param {Row} row @returns {[string, string][]} */
function verdictFacts(row) {
  const { verdict, measure, value, low, high, missed, baseline_missed, note } = row.cells;
  /** @type {[string, string][]} */
  const facts = [
    ["verdict", verdict],
    [measure, interval(value, low, high)],
  ];
  if (missed !== null) facts.push(["missed, and by the baseline", `${number(missed)} / ${number(baseline_missed)}`]);
  if (note) facts.push(["note", note]);
  return facts;
}

/** A ratio's interval on a small scale from a quarter to four, with [0.95, 1.05] shaded. @param {Row} row */
function glyph(row) {
  const { measure, value, low, high, verdict } = row.cells;
  if (typeof low !== "number" || typeof high !== "number" || !measure.includes(" / ") || value <= 0) return "";
  const x = (/** @type {number} */ ratio) => 60 + 58 * Math.max(-1, Math.min(1, Math.log(ratio) / Math.log(4)));
  return draw(
    "svg",
    { class: `glyph ${verdict}`, viewBox: "0 0 120 14", width: 120, height: 14, "aria-hidden": "true" },
    draw("rect", { class: "equal", x: x(0.95), width: x(1.05) - x(0.95), y: 0, height: 14 }),
    draw("line", { class: "interval", x1: x(low), x2: x(high), y1: 7, y2: 7 }),
    draw("circle", { class: "dot", cx: x(value), cy: 7, r: 3.5 }),
  );
}

/** All verdicts. */
function drawVerdicts() {
  const all = rows("claims.csv").filter((row) => row.cells.reading !== "-");
  const kinds = Object.keys(SIGNS).filter((verdict) => all.some((row) => row.cells.verdict === verdict));
  const shown = { verdicts: new Set(kinds), claim: "", every: false };
  const ids = data.claims.filter((claim) => claim.cells.length > 0).map((claim) => claim.id);
  const select = el(
    "select",
    {
      "aria-label": "Claim",
      onchange: (/** @type {Event} */ event) => {
        shown.claim = /** @type {HTMLSelectElement} */ (event.target).value;
        update();
      },
    },
    el("option", { value: "" }, "every claim"),
    ...ids.map((id) => el("option", { value: id }, id)),
  );
  const place = card(
    "verdict-table",
    "Every verdict",
    "A line for each claim, reading and scene, with the 95 % interval; the small scale runs from a quarter to four times, its grey band is [0.95, 1.05]. A click on a heading sorts, a click on a line shows the row of claims.csv.",
    [
      chips(
        "Verdict",
        kinds.map((kind) => [kind, `${SIGNS[kind]} ${kind}`, kind]),
        shown.verdicts,
        () => update(),
      ),
      choice(
        "Poses",
        [
          ["whole", "claim as a whole"],
          ["every", "each stratum too"],
        ],
        "whole",
        (value) => {
          shown.every = value === "every";
          update();
        },
      ),
      el("div", { class: "choice" }, el("span", { class: "label" }, "Claim"), select),
    ],
  );
  const cell = (/** @type {string} */ name) => (/** @type {Row} */ row) => row.cells[name];
  const missed = (/** @type {Row} */ row) =>
    row.cells.missed === null ? "–" : `${number(row.cells.missed)} / ${number(row.cells.baseline_missed)}`;
  /** @type {Column<Row>[]} */
  const columns = [
    { name: "claim", show: cell("claim"), key: cell("claim") },
    { name: "reading", show: cell("reading"), key: cell("reading") },
    { name: "scene", show: cell("scene"), key: cell("scene"), keep: true },
    { name: "poses", show: cell("stratum"), key: cell("stratum") },
    { name: "verdict", show: (row) => badge(row.cells.verdict), key: cell("verdict") },
    {
      name: "measure",
      show: (row) => el("span", {}, row.cells.measure, row.cells.note ? el("small", {}, row.cells.note) : null),
      key: cell("measure"),
      wide: true,
    },
    {
      name: "value [95 %]",
      show: (row) => el("span", {}, interval(row.cells.value, row.cells.low, row.cells.high), glyph(row)),
      key: cell("value"),
      right: true,
    },
    { name: "missed", show: missed, key: cell("missed"), right: true },
  ];
  function update() {
    const left = all.filter(
      (row) =>
        shown.verdicts.has(row.cells.verdict) &&
        (shown.every || standing.has(row.line)) &&
        (shown.claim === "" || row.cells.claim === shown.claim),
    );
    drawTable(place, columns, left, (row) => [`${row.cells.claim}, ${row.cells.reading}, ${row.cells.scene}`, [row]]);
  }
  update();
}
