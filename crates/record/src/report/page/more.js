// @ts-check
// What some runs have beside the rest, every record as a table, and where it all comes from.

/** Whole engines compared, when the folder holds such a comparison. */
function drawPeers() {
  const all = rows("peer-ratios.csv");
  part("peers").hidden = all.length === 0;
  if (all.length === 0) return;
  const modes = [...new Set(all.map((row) => row.cells.mode))];
  const chart = { mode: modes[0] };
  const reference = all[0].cells.reference;
  const place = card(
    "peers",
    `How many times as fast as ${reference}`,
    "Whole engines on the same poses, each in a process of its own; right of the line an engine is faster. Intervals are 95 %.",
    [
      choice(
        "Mode",
        modes.map((mode) => [mode, mode]),
        chart.mode,
        (mode) => {
          chart.mode = mode;
          update();
        },
      ),
    ],
  );
  function update() {
    const found = all.filter(
      (row) =>
        row.cells.mode === chart.mode &&
        row.cells.stratum === chosen.stratum &&
        (chosen.scenes.has(row.cells.scene) || !scenes.includes(row.cells.scene)),
    );
    const names = [...new Set(found.map((row) => row.cells.scene))];
    const panels = names.map((scene) => ({
      title: scene,
      lines: found
        .filter((row) => row.cells.scene === scene)
        .sort((a, b) => b.cells.ratio - a.cells.ratio)
        .map((row) => {
          const { engine, ratio, low, high, p99_ratio } = row.cells;
          const said = interval(ratio, low, high);
          return {
            name: engine,
            said,
            dots: [
              {
                value: ratio,
                low,
                high,
                look: engine,
                title: `${engine}, ${scene}`,
                facts: /** @type {[string, string][]} */ ([
                  ["times as fast", said],
                  ["at the 99 % quantile", number(p99_ratio)],
                ]),
                sources: [row],
              },
            ],
          };
        }),
    }));
    drawDots(place, { panels, log: true, unit: `time of ${reference} / time of the engine`, reference: 1 });
  }
  watch(update);
}

/** A sweep, when the folder holds one. */
function drawSweep() {
  const all = rows("sweep_summary.csv");
  part("sweep").hidden = all.length === 0;
  if (all.length === 0) return;
  const metrics = [...new Set(all.map((row) => row.cells.metric))];
  const chart = { metric: metrics[0] };
  const place = card("sweep", `Sweep: ${all[0].cells.sweep}`, "One quantity varied and everything else held.", [
    choice(
      "Measure",
      metrics.map((metric) => [metric, metric]),
      chart.metric,
      (metric) => {
        chart.metric = metric;
        update();
      },
    ),
  ]);
  function update() {
    const found = all.filter(
      (row) =>
        row.cells.metric === chart.metric &&
        chosen.variants.has(row.cells.variant) &&
        (chosen.stratum === data.words.all || row.cells.stratum === chosen.stratum),
    );
    const frames = [...new Set(found.map((row) => row.cells.stratum))].map((stratum) => ({
      title: stratum,
      curves: curvesOf(
        found.filter((row) => row.cells.stratum === stratum),
        (row) => ({
          x: row.cells.x,
          y: row.cells.value,
          title: caseName(row),
          sources: [row],
          facts: [
            ["x", number(row.cells.x)],
            [chart.metric, interval(row.cells.value, row.cells.low, row.cells.high)],
          ],
        }),
      ),
    }));
    drawCurves(place, { frames, x: all[0].cells.sweep, y: chart.metric, logX: false, logY: false, joined: true });
  }
  watch(update);
}

/** Any record as a table with a search. */
function drawRecords() {
  const files = Object.keys(data.tables);
  const chart = { file: files[0], words: "" };
  const select = el(
    "select",
    {
      "aria-label": "File",
      onchange: (/** @type {Event} */ event) => {
        chart.file = /** @type {HTMLSelectElement} */ (event.target).value;
        update();
      },
    },
    ...files.map((file) => el("option", { value: file }, `${file} (${data.tables[file].rows.length})`)),
  );
  const search = el("input", {
    type: "search",
    placeholder: "words that a row must have",
    "aria-label": "Search",
    oninput: (/** @type {Event} */ event) => {
      chart.words = /** @type {HTMLInputElement} */ (event.target).value.toLowerCase();
      update();
    },
  });
  const left =
    data.left_out.length > 0 ? ` Too large for the page, and beside it in the folder: ${data.left_out.join(", ")}.` : "";
  const place = card("records", "The records behind it", `Every number of this page comes from these files.${left}`, [
    select,
    search,
  ]);
  function update() {
    const wanted = chart.words.split(/\s+/).filter(Boolean);
    const found = rows(chart.file).filter((row) => {
      const line = Object.values(row.cells).join(" ").toLowerCase();
      return wanted.every((word) => line.includes(word));
    });
    /** @type {Column<Row>[]} */
    const columns = [
      { name: "line", show: (row) => String(row.line), key: (row) => row.line, right: true },
      ...data.tables[chart.file].columns.map((name) => ({
        name,
        show: (/** @type {Row} */ row) =>
          typeof row.cells[name] === "number" ? number(row.cells[name]) : String(row.cells[name] ?? ""),
        key: (/** @type {Row} */ row) => row.cells[name],
        right: rows(chart.file).some((row) => typeof row.cells[name] === "number"),
      })),
    ];
    drawTable(place, columns, found, (row) => [`${row.file}, line ${row.line}`, [row]]);
  }
  update();
}

/** Names and values, a line each. @param {[string, Node | string][]} facts */
function list(facts) {
  return el("dl", { class: "facts" }, ...facts.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]));
}

/** The scenes, the machine, the program, the inputs. */
function drawProvenance() {
  const { program, machine, request, inputs, cross_check, scenes: entries } = data.manifest;
  const known = (/** @type {any} */ value) => (value === null || value === undefined || value === "" ? "unknown" : String(value));
  const state = program.git_dirty === true ? ", with local changes" : "";
  part("run").append(
    el(
      "div",
      { class: "card" },
      el("h3", {}, "How to make it again"),
      el("pre", {}, program.command),
      list([
        ["profile", request.profile],
        ["seed", String(request.seed)],
        ["posed pairs verified per scene", number(request.verify_poses)],
        ["poses timed per scene", number(request.measure_poses)],
        ["blocks, launches", `${request.blocks}, ${request.launches}`],
        ...(cross_check
          ? [
              /** @type {[string, string]} */ ([
                "exact test against its integer twin",
                `${number(cross_check.disagreements)} disagreements in ${number(cross_check.pairs)} pairs of triangles`,
              ]),
            ]
          : []),
      ]),
    ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Machine and program"),
      list([
        ["processor", known(machine.cpu)],
        ["logical cores", known(machine.cores)],
        ["memory", `${number(machine.memory_bytes / 2 ** 30)} GiB`],
        ["system", known(machine.os)],
        ["load at the start", known(machine.load)],
        ["bvbench", known(program.version)],
        ["git revision", known(program.git_revision) + state],
        ["compiler", known(program.rustc)],
        ["flags", known(program.flags)],
      ]),
    ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Scenes"),
      ...entries.map((/** @type {any} */ scene) =>
        el(
          "details",
          {},
          el("summary", {}, `${scene.name}: ${scene.title}`),
          el("p", { class: "about" }, `Pairs examined: ${scene.pairs.join(", ")}.`),
          list(Object.entries(scene.triangles).map(([name, count]) => [name, `${number(count)} triangles`])),
        ),
      ),
    ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Variants"),
      list(
        variants.map((v) => [
          v.label,
          `${v.id} · ${v.kind}${v.safe ? ", safe" : ""} · ${v.policies.join(", ") || "no tree of ours"} · ${v.reference}`,
        ]),
      ),
    ),
    el(
      "div",
      { class: "card" },
      el("h3", {}, "Inputs"),
      el(
        "details",
        {},
        el("summary", {}, `${Object.keys(inputs).length} files with their hashes`),
        list(Object.entries(inputs).map(([name, hash]) => [name, el("code", {}, String(hash))])),
      ),
    ),
  );
  if (data.figures.length > 0) {
    part("run").append(
      el(
        "div",
        { class: "card" },
        el("h3", {}, "Figures for print"),
        el("ul", {}, ...data.figures.map((figure) => el("li", {}, el("a", { href: figure.svg }, figure.title)))),
      ),
    );
  }
}
