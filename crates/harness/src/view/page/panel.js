// @ts-check
// What stands beside the picture: the operator's panel, trees, events, and the program.

/**
 * An element. Properties that are functions are listeners.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag @param {Record<string, unknown>} [properties] @param {(Node | string)[]} children @returns {HTMLElementTagNameMap[T]}
 */
function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (typeof value === "function") element.addEventListener(name, /** @type {EventListener} */ (value));
    else if (value !== false) element.setAttribute(name, String(value));
  }
  // A button that was clicked does not keep the keys to itself.
  if (tag === "button") element.addEventListener("mousedown", (event) => event.preventDefault());
  element.append(...children);
  return element;
}

/** The names of a pair. @param {ViewData} data @param {[number, number]} pair */
function pairName(data, pair) {
  return pair.map((part) => data.parts[part].name).join(" and ");
}

/** Whether an axis is told in degrees: one that turns, or one whose joints turn by a degree per mm. @param {ViewData} data @param {number} axis */
function isAngle(data, axis) {
  const joints = data.links.flatMap((link) => (link.joint?.axis === axis ? [link.joint] : []));
  return isRotary(axis) || (joints.length > 0 && joints.every((joint) => joint.turns));
}

/** Axis positions in machine axes, tool, block, and how near it is. */
class OperatorPanel {
  /** @param {ViewData} data @param {Motion} motion */
  constructor(data, motion) {
    this.data = data;
    this.motion = motion;
    this.state = make("div", { class: "bv-state", role: "status" });
    this.pair = make("div", { class: "bv-pair" });
    this.axes = motion.axes.map((axis) => ({ axis, value: make("output") }));
    const rows = this.axes.map(({ axis, value }) =>
      make("div", { class: "bv-axis" }, make("b", {}, AXIS_LETTERS[axis]), value, make("small", {}, isAngle(data, axis) ? "°" : "mm")),
    );
    this.facts = make("dl", { class: "bv-facts" });
    this.fact = Object.fromEntries(
      ["line", "tool", "move", "spindle", "time"].map((name) => {
        const value = make("dd");
        this.facts.append(make("div", {}, make("dt", {}, name), value));
        return [name, value];
      }),
    );
    this.block = make("code", { class: "bv-block" });
    this.element = make("section", { class: "bv-operator", "aria-label": "Operator's panel" },
      this.state, this.pair, make("div", { class: "bv-axes" }, ...rows), this.block, this.facts);
  }

  /** @param {number} place @param {Status} status */
  show(place, status) {
    const { motion, data } = this;
    const position = motion.positionAt(place);
    for (const { axis, value } of this.axes) {
      value.textContent = (isRotary(axis) ? (position[axis] * 180) / Math.PI : position[axis]).toFixed(3);
    }
    this.state.dataset.state = status.state;
    this.state.textContent = `${status.state} here`;
    this.pair.textContent = status.text;
    const [move, line] = [motion.moveAt(place), motion.lineAt(place)];
    this.block.textContent = data.program?.lines[line - 1]?.trim() || (line === 0 ? "at the start" : " ");
    this.fact.line.textContent = line === 0 ? "start" : `${line} of ${data.program?.lines.length}`;
    this.fact.tool.textContent = motion.toolAt(place) ? `T${motion.toolAt(place)}` : "none";
    this.fact.move.textContent = moveName(motion, move);
    this.fact.spindle.textContent = move < 0 || motion.rpms[move] === 0 ? "stopped" : spindle(motion.rpms[move]);
    this.fact.time.textContent = `${clock(motion.timeAt(place))} of ${clock(motion.duration)}`;
  }
}

/** @param {Motion} motion @param {number} move */
function moveName(motion, move) {
  if (move < 0) return "none";
  const name = ["rapid", "feed", "arc", "dwell", "tool change"][motion.kinds[move]];
  const feed = motion.feeds[move];
  return feed > 0 && motion.kinds[move] > 0 ? `${name}, F${Number(feed.toFixed(1))}` : name;
}

/** @param {number} rpm */
function spindle(rpm) {
  return `${rpm > 0 ? "M3" : "M4"} ${Number.isFinite(rpm) ? Math.abs(Math.round(rpm)) : "?"} rpm`;
}

/** Which trees are drawn, and what they are like there. */
class TreePanel {
  /** @param {ViewData} data @param {Showing} showing @param {{ beside: boolean, first: number }} layout @param {() => void} changed */
  constructor(data, showing, layout, changed) {
    this.data = data;
    this.showing = showing;
    this.layout = layout;
    const deepest = Math.max(0, ...data.variants.flatMap((variant) => variant.trees.map((tree) => tree.levels.length - 1)));
    this.on = make("input", { type: "checkbox", change: () => this.#set(() => (showing.trees = this.on.checked), changed) });
    this.level = make("input", {
      type: "range", min: 0, max: deepest, step: 1, value: showing.level, "aria-label": "level",
      input: () => this.#set(() => ((showing.level = Number(this.level.value)), (showing.trees = true)), changed),
    });
    this.number = make("output");
    const names = ["pair", "all", ...data.parts.keys()].map((value) =>
      make("option", { value }, typeof value === "number" ? data.parts[value].name : value === "all" ? "all parts" : "nearest pair"),
    );
    this.part = make("select", {
      "aria-label": "parts with trees",
      change: () => this.#set(() => {
        const { value } = this.part;
        showing.volumes = value === "all" || value === "pair" ? value : Number(value);
      }, changed),
    }, ...names);
    const choices = data.variants.map((variant, i) => make("option", { value: i }, variant.label));
    if (data.variants.length > 1) choices.push(make("option", { value: "beside" }, "both, side by side"));
    this.variant = make("select", {
      "aria-label": "variant",
      change: () => this.#set(() => {
        layout.beside = this.variant.value === "beside";
        layout.first = layout.beside ? 0 : Number(this.variant.value);
        showing.trees = true;
      }, changed),
    }, ...choices);
    this.figures = make("div", { class: "bv-figures" });
    this.element = make("details", { class: "bv-trees", open: true }, make("summary", {}, "Bounding volumes"),
      make("div", { class: "bv-row" }, make("label", {}, this.on, " show "), this.variant, this.part),
      make("div", { class: "bv-row" }, make("span", {}, "level"), this.level, this.number), this.figures);
    this.element.hidden = data.variants.length === 0;
    this.show();
  }

  /** @param {() => void} change @param {() => void} changed */
  #set(change, changed) {
    change();
    this.show();
    changed();
  }

  show() {
    const { showing, layout, data } = this;
    this.on.checked = showing.trees;
    this.level.value = String(showing.level);
    this.number.textContent = String(showing.level);
    this.part.value = String(showing.volumes);
    this.variant.value = layout.beside ? "beside" : String(layout.first);
    const shown = layout.beside ? data.variants.map((_, i) => i) : [layout.first];
    this.figures.replaceChildren(...shown.flatMap((i) => (data.variants[i] ? [this.#figures(data.variants[i], i)] : [])));
  }

  /** @param {VariantData} variant @param {number} number */
  #figures(variant, number) {
    const { showing } = this;
    const trees = variant.trees.filter((tree) => hasTree(tree.part, showing));
    const levels = trees.map((tree) => tree.levels[Math.min(showing.level, tree.levels.length - 1)]);
    const sum = (/** @type {keyof Level} */ of) => levels.reduce((total, level) => total + level[of], 0);
    const outside = sum("leaking");
    const text = `${sum("nodes")} volumes, ${(sum("volume_mm3") / 1000).toLocaleString("en", { maximumFractionDigits: 0 })} cm³`;
    return make("div", {}, make("i", { class: `bv-swatch bv-tree-${number}` }), make("b", {}, variant.label), ` ${text}`,
      outside > 0 ? make("em", {}, `; ${outside} do not hold their triangles`) : "");
  }
}

/** Parts, to hide and show. @param {ViewData} data @param {Showing} showing @param {() => void} changed */
function partsPanel(data, showing, changed) {
  const rows = data.parts.map((part, index) => {
    const box = make("input", {
      type: "checkbox", checked: true,
      change: () => {
        if (box.checked) showing.hidden.delete(index);
        else showing.hidden.add(index);
        changed();
      },
    });
    const swatch = make("i", { class: "bv-swatch" });
    swatch.style.background = `rgb(${paintOf(part, index).map((x) => Math.round(255 * x)).join(" ")})`;
    const what = part.tool === null ? part.role : `${part.role}, T${part.tool}`;
    return make("label", {}, box, swatch, part.name, make("small", {}, what));
  });
  return make("details", { class: "bv-parts" }, make("summary", {}, `Parts (${rows.length})`), ...rows);
}

/** What else makes the check fail, collisions, near misses, then what is not examined.
 * @param {ViewData} data @param {(event: ViewEvent) => void} go @param {(fault: Fault) => void} goToFault */
function eventsPanel(data, go, goToFault) {
  const faults = data.faults.map((fault) =>
    make("button", { class: "bv-event", "data-kind": "collision", click: () => goToFault(fault) },
      make("b", {}, `line ${fault.line}`), make("span", {}, `${fault.kind.replaceAll("-", " ")}: ${fault.text}`)),
  );
  const rank = (/** @type {ViewEvent} */ event) => (isCollision(event) ? 0 : 1);
  const sorted = [...data.events].sort((p, q) => rank(p) - rank(q) || p.first - q.first);
  const rows = sorted.map((event) => {
    const what = isCollision(event) ? event.kind.replaceAll("-", " ") : `nearer than ${event.zone_mm} mm`;
    const least = isCollision(event) ? (event.inside ? "inside" : "") : event.least_mm > 0 ? `${event.least_mm.toFixed(2)} mm` : "to contact";
    return make("button", { class: "bv-event", "data-kind": isCollision(event) ? "collision" : "near", click: () => go(event) },
      make("b", {}, `line ${event.line}`), make("span", {}, `${what}: ${pairName(data, event.pair)}`), make("small", {}, least));
  });
  const collisions = data.events.filter(isCollision).length;
  const others = faults.length > 0 ? `, ${faults.length} other fault${faults.length === 1 ? "" : "s"}` : "";
  const title = `Events: ${collisions} collision${collisions === 1 ? "" : "s"}${others}, ${data.events.length - collisions} near`;
  const notes = data.notes.map((note) => make("p", { class: "bv-note" }, note));
  const count = faults.length + rows.length;
  return make("details", { class: "bv-events", open: count > 0 && count < 12 }, make("summary", {}, title), ...faults, ...rows, ...notes);
}

/** Height of a line of the program, pixels; the style says the same. */
const LINE_HEIGHT = 21;

/** The program, of which only the lines in sight are in the document. */
class ProgramList {
  /** @param {ViewData} data @param {Motion} motion @param {(line: number) => void} go */
  constructor(data, motion, go) {
    this.lines = data.program?.lines ?? [];
    this.moving = new Set(motion.runs.map((run) => run.line));
    /** What happens on a line. @type {Map<number, "near" | "collision">} */
    this.marks = new Map();
    for (const event of data.events) {
      for (const run of motion.runs) {
        const meets = run.last >= event.first && run.first < event.last + 1e-6 && (run.last > event.first || event.first === event.last);
        if (!meets || (this.marks.get(run.line) === "collision")) continue;
        if (!isCollision(event)) this.marks.set(run.line, "near");
        else if (run.line === event.line || !event.to_the_end) this.marks.set(run.line, "collision");
      }
    }
    for (const fault of data.faults) this.marks.set(fault.line, "collision");
    this.current = 0;
    this.rows = make("div", { class: "bv-rows" });
    this.rows.style.height = `${this.lines.length * LINE_HEIGHT}px`;
    this.element = make("section", {
      class: "bv-code", tabindex: 0, "aria-label": "Program", scroll: () => this.draw(),
      click: (/** @type {MouseEvent} */ event) => {
        const row = /** @type {HTMLElement} */ (event.target).closest("[data-line]");
        if (row instanceof HTMLElement) go(Number(row.dataset.line));
      },
    }, this.rows);
    this.element.hidden = this.lines.length === 0;
  }

  /** Marks a line, and brings it into sight. @param {number} line */
  show(line) {
    if (line === this.current && this.rows.childElementCount > 0) return;
    this.current = line;
    const [top, height] = [(line - 1) * LINE_HEIGHT, this.element.clientHeight];
    const { scrollTop } = this.element;
    if (top < scrollTop + 2 * LINE_HEIGHT || top > scrollTop + height - 3 * LINE_HEIGHT) this.element.scrollTop = top - 0.4 * height;
    this.draw();
  }

  draw() {
    const first = Math.max(0, Math.floor(this.element.scrollTop / LINE_HEIGHT) - 2);
    const count = Math.ceil(this.element.clientHeight / LINE_HEIGHT) + 4;
    const rows = this.lines.slice(first, first + count).map((text, i) => {
      const line = first + i + 1;
      const row = make("div", { "data-line": line, class: line === this.current ? "bv-current" : "" },
        make("span", { class: "bv-number", "data-mark": this.marks.get(line) ?? false }, String(line)), make("code", {}, text));
      if (!this.moving.has(line)) row.classList.add("bv-still");
      row.style.top = `${(line - 1) * LINE_HEIGHT}px`;
      return row;
    });
    this.rows.replaceChildren(...rows);
  }
}
