// @ts-check
// Tables that sort by a click on a heading; a row opens what stands behind it.

/**
 * @template T
 * @typedef {object} Column
 * @property {string} name
 * @property {(item: T) => Node | string} show
 * @property {(item: T) => string | number | null} key what it is sorted by
 * @property {boolean} [right] numbers are aligned right
 * @property {boolean} [wide] has room for a sentence, and a whole line on a phone
 * @property {boolean} [keep] does not break
 */

/** Rows drawn at once: more are asked for by a button. */
const FIRST_ROWS = 500;

/**
 * @template T
 * @param {HTMLElement} place
 * @param {Column<T>[]} columns
 * @param {T[]} items
 * @param {(item: T) => [string, Row[]]} behind title and rows of the records
 */
function drawTable(place, columns, items, behind) {
  let sorted = items;
  let by = -1;
  let falling = false;
  let most = FIRST_ROWS;
  const heads = columns.map((column, i) =>
    el(
      "th",
      { scope: "col", class: column.right ? "right" : "" },
      el("button", { type: "button", onclick: () => sort(i) }, column.name),
    ),
  );
  const body = el("tbody");
  const more = el("button", {
    type: "button",
    class: "show-all",
    onclick: () => {
      most = Infinity;
      fillIn();
    },
  });
  place.replaceChildren(el("div", { class: "scroll" }, el("table", {}, el("thead", {}, el("tr", {}, ...heads)), body)), more);
  fillIn();

  /** @param {number} column */
  function sort(column) {
    falling = by === column && !falling;
    by = column;
    const { key } = columns[column];
    sorted = [...items].sort((a, b) => (falling ? -1 : 1) * compare(key(a), key(b)));
    heads.forEach((head, i) =>
      i === by ? head.setAttribute("aria-sort", falling ? "descending" : "ascending") : head.removeAttribute("aria-sort"),
    );
    fillIn();
  }

  function fillIn() {
    body.replaceChildren(...sorted.slice(0, most).map(line));
    oneStop(body.parentElement ?? body);
    more.hidden = sorted.length <= most;
    more.textContent = `Show all ${sorted.length} rows`;
    if (sorted.length === 0)
      body.append(el("tr", {}, el("td", { colspan: columns.length, class: "note" }, "Nothing is left by the filters.")));
  }

  /** @param {T} item */
  function line(item) {
    const [title, sources] = behind(item);
    const open = () => showRows(title, sources);
    const cells = columns.map((column) =>
      el(
        "td",
        {
          class: [column.right ? "right" : "", column.wide ? "wide" : "", column.keep ? "keep" : ""].join(" "),
          "data-label": column.name,
        },
        column.show(item),
      ),
    );
    const onkeydown = (/** @type {KeyboardEvent} */ event) => {
      if (event.key === "Enter") open();
    };
    return el("tr", { tabindex: -1, onclick: open, onkeydown }, ...cells);
  }
}

/** Numbers by size, texts by letters, nothing last. @param {string | number | null} a @param {string | number | null} b */
function compare(a, b) {
  if (a === null || b === null) return Number(a === null) - Number(b === null);
  return typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b), "en", { numeric: true });
}
