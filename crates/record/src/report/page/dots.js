// @ts-check
// Dots with intervals: a line per case under its name, panels beside each other on one scale. What a mark says stands at the
// right of its line, so that the drawing can be read on paper too.

/** @typedef {{value: number, low?: number, high?: number, look: string, title: string, facts: [string, string][], sources: Row[]}} Dot */
/** @typedef {{name: string, said: string, dots: Dot[]}} Line */
/** @typedef {{title: string, lines: Line[]}} Panel */
/** @typedef {{panels: Panel[], log: boolean, unit: string, reference?: number, from?: number}} Dots */

const LINE_PX = 38;
const HEAD_PX = 6;
const FOOT_PX = 40;

/** Draws the panels into a place. @param {HTMLElement} place @param {Dots} chart */
function drawDots(place, chart) {
  const values = chart.panels.flatMap((panel) =>
    panel.lines.flatMap((line) => line.dots.flatMap((dot) => [dot.value, dot.low ?? dot.value, dot.high ?? dot.value])),
  );
  for (const end of [chart.reference, chart.from]) if (end !== undefined) values.push(end);
  drawPanels(place, chart.panels, (panel, width) => dotsPanel(panel, chart, values, width));
}

/**
 * Panels as wide as there is room, drawn again when there is more or less of it.
 * @template {{title: string}} P
 * @param {HTMLElement} place
 * @param {P[]} panels
 * @param {(panel: P, width: number) => SVGElement} drawing
 */
function drawPanels(place, panels, drawing) {
  if (panels.length === 0) {
    place.replaceChildren(el("p", { class: "note" }, "Nothing is left of this by the filters."));
    return;
  }
  const frames = panels.map((panel) => ({ panel, frame: el("figure", { class: "panel" }, el("figcaption", {}, panel.title)) }));
  place.replaceChildren(el("div", { class: "panels" }, ...frames.map(({ frame }) => frame)));
  // Nothing is drawn in a card that is closed; it is drawn when it opens.
  if (place.closest("details:not([open])")) return;
  for (const { panel, frame } of frames) {
    const width = Math.max(220, Math.round(frame.clientWidth - 2) || 340);
    frame.append(drawing(panel, width));
  }
  oneStop(place);
}

/** @param {Panel} panel @param {Dots} chart @param {number[]} values @param {number} width */
function dotsPanel(panel, chart, values, width) {
  const height = HEAD_PX + panel.lines.length * LINE_PX + FOOT_PX;
  const scale = scaleOf(values, chart.log, [8, width - 8], Math.max(3, Math.floor(width / 62)));
  const drawing = draw("svg", { viewBox: `0 0 ${width} ${height}`, width, height, class: "drawing" });
  const bottom = height - FOOT_PX;
  for (const tick of scale.ticks) {
    const x = scale.at(tick);
    drawing.append(
      draw("line", { class: "grid", x1: x, x2: x, y1: HEAD_PX, y2: bottom }),
      draw("text", { class: "tick", x, y: bottom + 15, "text-anchor": "middle" }, tickText(tick)),
    );
  }
  if (chart.reference !== undefined) {
    const x = scale.at(chart.reference);
    drawing.append(draw("line", { class: "reference", x1: x, x2: x, y1: HEAD_PX, y2: bottom }));
  }
  drawing.append(draw("text", { class: "unit", x: width / 2, y: height - 6, "text-anchor": "middle" }, chart.unit));
  panel.lines.forEach((line, i) => drawing.append(dotLine(line, scale, width, HEAD_PX + i * LINE_PX)));
  return drawing;
}

/** @param {Line} line @param {Scale} scale @param {number} width @param {number} top */
function dotLine(line, scale, width, top) {
  const y = top + 27;
  const room = Math.max(8, Math.floor((width - 16 - 7 * line.said.length) / 7.4));
  const name = line.name.length > room ? `${line.name.slice(0, room - 1)}…` : line.name;
  const group = draw("g", {});
  group.append(
    draw("rect", { class: "band", x: 0, y: top + 1, width, height: LINE_PX - 2, rx: 4 }),
    draw("text", { class: "name", x: 8, y: top + 15 }, draw("title", {}, line.name), name),
    draw("text", { class: "said", x: width - 8, y: top + 15, "text-anchor": "end" }, line.said),
    draw("line", { class: "track", x1: 8, x2: width - 8, y1: y, y2: y }),
  );
  for (const dot of line.dots) {
    const x = scale.at(dot.value);
    const mark = draw("g", { class: "mark", style: colourOf(dot.look) });
    if (typeof dot.low === "number" && typeof dot.high === "number") {
      mark.append(draw("line", { class: "interval", x1: scale.at(dot.low), x2: scale.at(dot.high), y1: y, y2: y }));
    }
    // The finger needs more than the eye.
    mark.append(markerOf(dot.look, x, y), draw("circle", { class: "touch", cx: x, cy: y, r: 11 }));
    group.append(tells(mark, dot.title, dot.facts, dot.sources));
  }
  return group;
}
