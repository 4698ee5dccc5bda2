// @ts-check
// The paper, sentence by sentence: a row for each, its verdict, and a column for each reading.

/** The rows of `claims.csv` on some lines. @param {number[]} lines */
function claimRows(lines) {
  return lines.flatMap((line) => rows("claims.csv")[line - 2] ?? []);
}

/** A verdict as a badge that tells its numbers; of several scenes one badge when they agree. @param {Row[]} found @param {string} title @param {boolean} short */
function verdictBadges(found, title, short) {
  const kinds = [...new Set(found.map((row) => row.cells.verdict))];
  return kinds.map((kind) => {
    const of = found.filter((row) => row.cells.verdict === kind);
    const words = kinds.length > 1 || (short && found.length === 1 && scenes.length > 1) ? of.map((row) => row.cells.scene).join(", ") : kind;
    const facts = of.length === 1 ? verdictFacts(of[0]) : of.map((row) => /** @type {[string, string]} */ ([row.cells.scene, interval(row.cells.value, row.cells.low, row.cells.high) || row.cells.verdict]));
    return tells(badge(kind, words), title, facts, of);
  });
}

/** The judged sentences, a table for each family of readings. */
function drawSentences() {
  const claimOf = new Map(data.claims.map((claim) => [claim.id, claim]));
  const readingOf = new Map(data.readings.map((reading) => [reading.id, reading]));
  for (const [readings, ids] of data.blocks) {
    const heads = readings.map((id) => {
      const reading = readingOf.get(id);
      return el("th", { scope: "col" }, reading?.name ?? id, el("small", {}, reading?.words ?? ""));
    });
    const lines = ids.map((id) => sentenceLine(/** @type {Claim} */ (claimOf.get(id)), readings));
    const head = el("tr", {}, el("th", { scope: "col" }, "the paper says"), el("th", { scope: "col" }, "verdict"), ...heads);
    part("claims").append(
      oneStop(el("div", { class: "scroll" }, el("table", { class: "sentences" }, el("thead", {}, head), el("tbody", {}, ...lines)))),
    );
  }
  drawOthers("literature", "Sentences of other literature");
  drawOthers("not-judged", "Sentences that this run does not judge, and why");
}

/** @param {Claim} claim @param {string[]} readings */
function sentenceLine(claim, readings) {
  const primary = claim.primary === null ? [] : claimRows([claim.primary]);
  const measured = primary.map((row) => interval(row.cells.value, row.cells.low, row.cells.high)).join("");
  const cells = readings.map((reading) => {
    const own = claim.cells.find(([id]) => id === reading);
    const name = data.readings.find((other) => other.id === reading)?.name ?? reading;
    return el("td", { class: "badges", "data-label": name }, ...(own ? verdictBadges(claimRows(own[1]), `${claim.id}, ${name}`, false) : []));
  });
  return el(
    "tr",
    { id: `claim-${claim.id}` },
    el("th", { scope: "row" }, claim.sentence, el("small", {}, `${claim.id} · ${claim.source}`)),
    el("td", { class: "primary" }, ...primary.map((row) => tells(badge(row.cells.verdict), claim.id, verdictFacts(row), [row])), el("small", {}, measured)),
    ...cells,
  );
}

/** Sentences that are folded. @param {string} group @param {string} title */
function drawOthers(group, title) {
  const of = data.claims.filter((claim) => claim.group === group);
  if (of.length === 0) return;
  const lines = of.map((claim) =>
    el(
      "li",
      {},
      claim.sentence,
      " ",
      ...claim.cells.flatMap(([id, lines]) => verdictBadges(claimRows(lines).filter((row) => row.cells.verdict !== "not-judged"), `${claim.id}, ${id}`, false)),
      el("small", {}, `${claim.id} · ${claim.source}${claim.reason ? ` · ${claim.reason}` : ""}`),
    ),
  );
  part("claims").append(oneStop(el("details", { class: "card" }, el("summary", {}, `${title} (${of.length})`), el("ul", { class: "plain" }, ...lines))));
}
