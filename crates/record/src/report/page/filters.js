// @ts-check
// What the reader has chosen to see, and the controls for it.

const chosen = {
  scenes: new Set(scenes),
  // Controls test every pair of triangles; beside them all else is one dot at the left edge.
  variants: new Set(variants.filter((variant) => variant.kind !== "control").map((variant) => variant.id)),
  stratum: data.words.all,
  everyPolicy: false,
};

/** What is drawn again when a choice changes. @type {(() => void)[]} */
const watching = [];

/** Draws now and whenever a choice changes. @param {() => void} drawing */
function watch(drawing) {
  watching.push(drawing);
  drawing();
}

/** Draws everything again. */
function changed() {
  hideTip();
  for (const drawing of watching) drawing();
}

/** Whether a row is of a chosen scene, variant and policy. @param {Row} row */
function isChosen(row) {
  const { scene, variant } = row.cells;
  return chosen.scenes.has(scene) && chosen.variants.has(variant) && (chosen.everyPolicy || isDefault(variant, policyOf(row)));
}

/**
 * A button that is pressed or not.
 * @param {string} value
 * @param {string} words
 * @param {string} kind its class
 * @param {boolean} pressed
 * @param {(button: HTMLElement) => void} press
 * @returns {HTMLElement}
 */
function toggle(value, words, kind, pressed, press) {
  const button = el(
    "button",
    { type: "button", class: kind, "aria-pressed": String(pressed), "data-value": value, onclick: () => press(button) },
    words,
  );
  return button;
}

/**
 * Buttons under one label.
 * @param {string} label
 * @param {string} kind class of the row
 * @param {HTMLElement[]} buttons
 */
function group(label, kind, buttons) {
  return el(
    "div",
    { class: "choice", role: "group", "aria-label": label },
    el("span", { class: "label" }, label),
    el("div", { class: kind }, ...buttons),
  );
}

/**
 * Buttons of which one is pressed.
 * @param {string} label
 * @param {[string, string][]} options value and text
 * @param {string} value
 * @param {(value: string) => void} take
 */
function choice(label, options, value, take) {
  const buttons = options.map(([option, words]) =>
    toggle(option, words, "", option === value, (button) => {
      for (const other of buttons) other.setAttribute("aria-pressed", String(other === button));
      take(option);
    }),
  );
  return group(label, "segments", buttons);
}

/**
 * Buttons of which any are pressed.
 * @param {string} label
 * @param {[string, string, string?][]} options value, text, class
 * @param {Set<string>} set
 * @param {() => void} after
 */
function chips(label, options, set, after) {
  const buttons = options.map(([option, words, kind]) =>
    toggle(option, words, `chip ${kind ?? ""}`, set.has(option), (button) => {
      if (!set.delete(option)) set.add(option);
      button.setAttribute("aria-pressed", String(set.has(option)));
      after();
    }),
  );
  return group(label, "chips", buttons);
}

/** The choices that all charts share. */
function drawFilters() {
  const { all, strata } = data.words;
  const ofStratum = /** @type {[string, string][]} */ ([all, ...strata].map((stratum) => [stratum, stratum.replace("-", " ")]));
  const ofPolicy = /** @type {[string, string][]} */ ([
    ["default", "default trees"],
    ["every", "every tree policy"],
  ]);
  part("filters-body").append(
    chips(
      "Scenes",
      scenes.map((scene) => [scene, scene]),
      chosen.scenes,
      changed,
    ),
    choice("Poses", ofStratum, chosen.stratum, (stratum) => {
      chosen.stratum = stratum;
      changed();
    }),
    chips(
      "Variants",
      variants.map((v) => [v.id, isUnsafe(v.id) ? `${v.label} (unsafe)` : v.label, isUnsafe(v.id) ? "unsafe" : ""]),
      chosen.variants,
      changed,
    ),
    choice("Trees", ofPolicy, "default", (which) => {
      chosen.everyPolicy = which === "every";
      changed();
    }),
  );
  watch(() => {
    const count = (/** @type {Set<string>} */ set, /** @type {number} */ all, /** @type {string} */ what) =>
      `${set.size === all ? "all" : `${set.size} of ${all}`} ${what}`;
    const poses = chosen.stratum === all ? "all poses" : `${chosen.stratum} poses`;
    part("filters-now").textContent = [
      count(chosen.scenes, scenes.length, "scenes"),
      poses,
      count(chosen.variants, variants.length, "variants"),
      chosen.everyPolicy ? "every tree policy" : "default trees",
    ].join(" · ");
  });
}

/** A page no wider than this is a phone's, px. */
const NARROW = 640;

/** Cards that are closed at first everywhere: long tables. */
const FOLDED = ["Every verdict", "The records behind it"];

/**
 * A card with a heading, its own controls, and a place to draw in; it opens and closes.
 * @param {string} parent id of the section
 * @param {string} title
 * @param {string} about how to read it
 * @param {(Node | null)[]} controls
 */
function card(parent, title, about, controls = []) {
  const place = el("div", { class: "place" });
  const body = [el("p", { class: "about" }, about), el("div", { class: "controls" }, ...controls), place];
  const frame = el("details", { class: "card", "data-card": title }, el("summary", {}, el("h3", {}, title)), ...body);
  // A phone shows what there is, and opens what is asked for.
  frame.toggleAttribute("open", innerWidth > NARROW && !FOLDED.includes(title));
  frame.addEventListener("toggle", () => {
    if (frame.hasAttribute("open") && !place.querySelector("svg, table, .note")) changed();
  });
  part(parent).append(frame);
  return place;
}
