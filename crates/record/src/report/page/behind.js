// @ts-check
// What stands behind a mark: a tip while it is pointed at, and the rows of the records when it is clicked.

/** Shows the tip of a mark. @param {Element} mark @param {string} title @param {[string, string][]} facts */
function showTip(mark, title, facts) {
  const tip = part("tip");
  const lines = facts.map(([name, value]) => el("div", {}, el("span", {}, name), el("b", {}, value)));
  tip.replaceChildren(el("strong", {}, title), ...lines);
  tip.hidden = false;
  const at = mark.getBoundingClientRect();
  const size = tip.getBoundingClientRect();
  const left = Math.min(Math.max(8, at.left + at.width / 2 - size.width / 2), innerWidth - size.width - 8);
  const above = at.top - size.height - 10;
  tip.style.left = `${left}px`;
  tip.style.top = `${above > 8 ? above : at.bottom + 10}px`;
}

/** Hides it. */
function hideTip() {
  part("tip").hidden = true;
}

/** Shows the rows of the records that a mark is made of. @param {string} title @param {Row[]} sources */
function showRows(title, sources) {
  hideTip();
  const shown = sources.slice(0, 40);
  const cards = shown.map((row) => {
    const cells = Object.entries(row.cells).filter(([, value]) => value !== null && value !== "");
    return el(
      "article",
      {},
      el("h4", {}, el("a", { href: row.file }, row.file), `, line ${row.line}`),
      el("dl", {}, ...cells.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, String(value))])),
    );
  });
  const more = sources.length - shown.length;
  const note = el("p", { class: "note" }, `and ${more} more rows`);
  part("rows-title").textContent = title;
  part("rows-body").replaceChildren(...cards, ...(more > 0 ? [note] : []));
  part("rows").hidden = false;
  part("rows-body").scrollTop = 0;
}

/** Hides them. */
function hideRows() {
  part("rows").hidden = true;
}

/**
 * Makes the marks of a place one stop of the tab key; arrow keys go from mark to mark, Home and End to the first and the last.
 * @template {Element} E
 * @param {E} place
 * @returns {E}
 */
function oneStop(place) {
  const marks = () => /** @type {(HTMLElement | SVGElement)[]} */ ([...place.querySelectorAll(".tells, tbody tr[tabindex]")]);
  const first = marks()[0];
  first?.setAttribute("tabindex", "0");
  if (place.hasAttribute("data-one-stop")) return place;
  place.setAttribute("data-one-stop", "");
  place.addEventListener("keydown", (event) => {
    const { key, target } = /** @type {KeyboardEvent} */ (event);
    const all = marks();
    const at = all.findIndex((mark) => mark === target);
    const steps = { ArrowRight: at + 1, ArrowDown: at + 1, ArrowLeft: at - 1, ArrowUp: at - 1, Home: 0, End: all.length - 1 };
    if (at < 0 || !(key in steps)) return;
    event.preventDefault();
    const to = all[Math.min(Math.max(steps[/** @type {keyof typeof steps} */ (key)], 0), all.length - 1)];
    for (const mark of all) mark.setAttribute("tabindex", mark === to ? "0" : "-1");
    to.focus();
  });
  return place;
}

/**
 * Makes a mark tell what stands behind it, to the mouse, to a finger and to the keyboard.
 * @template {Element} E
 * @param {E} mark
 * @param {string} title
 * @param {[string, string][]} facts
 * @param {Row[]} sources
 * @returns {E}
 */
function tells(mark, title, facts, sources) {
  const show = () => showTip(mark, title, facts);
  mark.classList.add("tells");
  mark.setAttribute("tabindex", "-1");
  mark.setAttribute("role", "button");
  mark.setAttribute("aria-label", [title, ...facts.map((fact) => fact.join(" "))].join(", "));
  for (const event of ["pointerenter", "focus"]) mark.addEventListener(event, show);
  for (const event of ["pointerleave", "blur"]) mark.addEventListener(event, hideTip);
  mark.addEventListener("click", () => showRows(title, sources));
  mark.addEventListener("keydown", (event) => {
    if (/** @type {KeyboardEvent} */ (event).key === "Enter") showRows(title, sources);
  });
  return mark;
}
