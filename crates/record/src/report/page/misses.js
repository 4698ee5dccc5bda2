// @ts-check
// Contacts missed, and how tight the volumes are.

/** Rates of missed contacts. */
function drawMisses() {
  const all = rows("summary.csv").filter(
    (row) => row.cells.stratum === data.words.all && row.cells.variant !== data.words.null && row.cells.contacts > 0,
  );
  const place = card(
    "misses-rates",
    "Contacts missed",
    "Share of the colliding poses above grazing that a variant reports as free, asked directly, with 95 % intervals by line; none on m lines is at most 3/m. A safe volume must miss none.",
  );
  watch(() => {
    const found = all.filter(isChosen);
    const panels = panelsOf(
      found,
      (row) => -row.cells.missed - 1e-9,
      (row) => {
        const { missed, contacts, workload, miss_rate_low, miss_rate_high, scene, variant } = row.cells;
        const said = missed === 0 ? `none of ${number(contacts)}` : `${number(missed)} of ${number(contacts)}`;
        return {
          name: `${caseName(row)}, ${workload}`,
          said,
          dots: [
            {
              value: (100 * missed) / contacts,
              low: 100 * miss_rate_low,
              high: 100 * miss_rate_high,
              look: variant,
              title: `${caseName(row)}, ${scene}`,
              facts: [
                ["missed", said],
                ["rate", percent(missed / contacts)],
                ["interval", `${percent(miss_rate_low)} to ${percent(miss_rate_high)}`],
              ],
              sources: [row],
            },
          ],
        };
      },
    );
    panels.forEach((panel) => panel.lines.sort((a, b) => b.dots[0].value - a.dots[0].value));
    drawDots(place, { panels, log: false, unit: "contacts missed, % of colliding poses", from: 0 });
  });
}

/** Misses by depth: a table whose cells are shaded by the rate. */
function drawBands() {
  const all = rows("verification.csv");
  const place = card(
    "misses-bands",
    "At which depth",
    "The travel past first contact, mm. A shallow contact is easily hidden; one that is missed deeper is a collision that the operator hears. Only cases that miss something are shown.",
  );
  watch(() => {
    /** @type {Map<string, Map<string, Row[]>>} */
    const cases = new Map();
    for (const row of all.filter((row) => isChosen(row) && data.words.bands.includes(row.cells.band))) {
      const bands = cases.get(caseName(row)) ?? new Map();
      bands.set(row.cells.band, [...(bands.get(row.cells.band) ?? []), row]);
      cases.set(caseName(row), bands);
    }
    const sum = (/** @type {Row[]} */ some, /** @type {string} */ column) =>
      some.reduce((total, row) => total + row.cells[column], 0);
    const missing = [...cases].filter(([, bands]) => [...bands.values()].some((some) => sum(some, "missed") > 0));
    const head = el(
      "tr",
      {},
      el("th", { scope: "col" }, "variant"),
      ...data.words.bands.map((band) => el("th", { scope: "col", class: "right" }, band)),
    );
    const lines = missing.map(([name, bands]) =>
      el(
        "tr",
        {},
        el("th", { scope: "row" }, name),
        ...data.words.bands.map((band) => {
          const some = bands.get(band) ?? [];
          const [missed, exact] = [sum(some, "missed"), sum(some, "exact")];
          const cell = el(
            "td",
            { class: "heat", style: `--heat:${exact > 0 ? (100 * missed) / exact : 0}%` },
            exact > 0 ? percent(missed / exact) : "–",
          );
          const parted = some.filter((row) => row.cells.exact > 0);
          return tells(
            cell,
            `${name}, ${band} mm`,
            [
              ["missed", number(missed)],
              ["of", number(exact)],
            ],
            parted,
          );
        }),
      ),
    );
    const quiet = cases.size - missing.length;
    place.replaceChildren(
      el("div", { class: "scroll" }, el("table", { class: "bands" }, el("thead", {}, head), el("tbody", {}, ...lines))),
      el("p", { class: "note" }, `${quiet} of the ${cases.size} chosen cases miss nothing at any depth.`),
    );
  });
}

/** What `tightness.csv` tells of a level: id, words, value. @type {[string, string, (row: Row) => number, boolean][]} */
const LEVELS = [
  ["looseness", "looseness", (row) => row.cells.hulled_volume_mm3 / row.cells.hull_mm3, true],
  ["corners", "corners outside", (row) => row.cells.outside_corners_pct, false],
  ["overhang", "overhang", (row) => row.cells.overhang_mm, false],
];

/** Tightness by level. */
function drawTightness() {
  const all = rows("tightness.csv");
  const frames = [...new Set(all.map((row) => row.cells.frame))].sort((a, b) => a - b);
  const chart = { measure: LEVELS[0], frame: frames[0] };
  const units = ["volume / hull volume", "% of corners", "mm"];
  const place = card(
    "tightness-levels",
    "Tightness by level",
    "Looseness is the volume of a level's nodes over that of the convex hulls of what they hold; 1 is a perfect fit. Overhang is geometry outside the volume that should hold it.",
    [
      choice(
        "Measure",
        LEVELS.map(([id, words]) => [id, words]),
        chart.measure[0],
        (id) => {
          chart.measure = LEVELS.find((level) => level[0] === id) ?? LEVELS[0];
          update();
        },
      ),
      choice(
        "Frame",
        frames.map((frame) => [String(frame), frame === 0 ? "the part's own" : `turned at random, ${frame}`]),
        String(chart.frame),
        (id) => {
          chart.frame = Number(id);
          update();
        },
      ),
    ],
  );
  function update() {
    const [, words, valueOf, log] = chart.measure;
    const found = all.filter((row) => row.cells.frame === chart.frame && isChosen(row) && Number.isFinite(valueOf(row)));
    const parts = [...new Set(found.map((row) => `${row.cells.scene}, ${row.cells.part}`))];
    const panels = parts.map((title) => ({
      title,
      curves: curvesOf(
        found.filter((row) => `${row.cells.scene}, ${row.cells.part}` === title),
        (row) => ({
          x: row.cells.level,
          y: valueOf(row),
          title: `${caseName(row)}, ${row.cells.part}`,
          sources: [row],
          facts: [
            ["level", String(row.cells.level)],
            ["nodes", number(row.cells.nodes)],
            [words, number(valueOf(row))],
            ["corners outside", `${number(row.cells.outside_corners_pct)} %`],
            ["overhang", `${number(row.cells.overhang_mm)} mm`],
          ],
        }),
      ),
    }));
    drawCurves(place, {
      frames: panels,
      x: "level of the tree",
      y: units[LEVELS.indexOf(chart.measure)],
      logX: false,
      logY: log,
      joined: true,
    });
  }
  watch(update);
}
