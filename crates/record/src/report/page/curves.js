// @ts-check
// Curves and clouds of points in a frame with two axes, each variant with its colour and marker, the names at the ends of few lines and below many.

/** @typedef {{x: number, y: number, title: string, facts: [string, string][], sources: Row[]}} Point */
/** @typedef {{look: string, dashed: boolean, name: string, points: Point[]}} Curve */
/** @typedef {{title: string, curves: Curve[]}} Frame */
/** @typedef {{frames: Frame[], x: string, y: string, logX: boolean, logY: boolean, joined: boolean, diagonal?: boolean}} Curves */

const HEIGHT_PX = 260;
const LEFT_PX = 46;
const DASH = "7 3";
/** A frame of no more curves has their names at their ends. */
const MOST_LABELS = 6;
const LABEL_PX = 150;

/** Draws the frames into a place, and the legend below them. @param {HTMLElement} place @param {Curves} chart */
function drawCurves(place, chart) {
  drawPanels(place, chart.frames, (frame, width) => curvesPanel(frame, chart, width));
  if (chart.frames.every((frame) => hasLabels(frame, chart))) return;
  const names = new Map(chart.frames.flatMap((frame) => frame.curves.map((curve) => [curve.name, curve])));
  const entries = [...names].map(([name, curve]) => {
    const sample = draw(
      "svg",
      { width: 30, height: 14, viewBox: "0 0 30 14", "aria-hidden": "true" },
      ...pathsOf(curve, "M1 7H29", chart.joined),
      markerOf(curve.look, 15, 7),
    );
    const over = (/** @type {boolean} */ on) => () => highlight(place, on ? name : null);
    return el(
      "button",
      {
        type: "button",
        tabindex: -1,
        class: "key",
        onpointerenter: over(true),
        onpointerleave: over(false),
        onfocus: over(true),
        onblur: over(false),
      },
      sample,
      name,
    );
  });
  if (entries.length > 0) place.append(el("div", { class: "legend" }, ...entries));
}

/** Lets one curve stand out. @param {HTMLElement} place @param {string | null} name */
function highlight(place, name) {
  for (const curve of place.querySelectorAll("g.curve")) {
    curve.classList.toggle("faint", name !== null && curve.getAttribute("data-name") !== name);
  }
}

/** Whether the curves of a frame are named at their ends. @param {Frame} frame @param {Curves} chart */
function hasLabels(frame, chart) {
  return chart.joined && frame.curves.length <= MOST_LABELS;
}

/** @param {Curve} curve @param {string} path @param {boolean} joined */
function pathsOf(curve, path, joined) {
  const style = colourOf(curve.look);
  return joined ? [draw("path", { class: "stroke", style, d: path, "stroke-dasharray": curve.dashed ? DASH : "" })] : [];
}

/** Heights that stay apart by a line of text, in the order of the wanted ones. @param {number[]} wanted */
function apart(wanted) {
  const order = wanted.map((_, i) => i).sort((a, b) => wanted[a] - wanted[b]);
  const at = [...wanted];
  order.forEach((i, place) => {
    if (place > 0) at[i] = Math.max(at[i], at[order[place - 1]] + 14);
  });
  return at;
}

/** @param {Frame} frame @param {Curves} chart @param {number} width */
function curvesPanel(frame, chart, width) {
  const points = frame.curves.flatMap((curve) => curve.points);
  const [xs, ys] = [points.map((point) => point.x), points.map((point) => point.y)];
  const both = chart.diagonal ? [...xs, ...ys] : null;
  const bottom = HEIGHT_PX - FOOT_PX;
  const right = hasLabels(frame, chart) ? LABEL_PX : 0;
  const x = scaleOf(both ?? xs, chart.logX, [LEFT_PX + 8, width - 12 - right], Math.max(3, Math.floor(width / 64)));
  const y = scaleOf(both ?? ys, chart.logY, [bottom - 4, 18], 6);
  const drawing = draw("svg", { viewBox: `0 0 ${width} ${HEIGHT_PX}`, width, height: HEIGHT_PX, class: "drawing" });
  for (const tick of x.ticks) {
    drawing.append(
      draw("line", { class: "grid", x1: x.at(tick), x2: x.at(tick), y1: 14, y2: bottom }),
      draw("text", { class: "tick", x: x.at(tick), y: bottom + 15, "text-anchor": "middle" }, tickText(tick)),
    );
  }
  for (const tick of y.ticks) {
    drawing.append(
      draw("line", { class: "grid", x1: LEFT_PX, x2: width - 6 - right, y1: y.at(tick), y2: y.at(tick) }),
      draw("text", { class: "tick", x: LEFT_PX - 6, y: y.at(tick) + 4, "text-anchor": "end" }, tickText(tick)),
    );
  }
  if (both) {
    const [low, high] = [Math.min(...both), Math.max(...both)];
    drawing.append(draw("line", { class: "reference", x1: x.at(low), x2: x.at(high), y1: y.at(low), y2: y.at(high) }));
  }
  drawing.append(
    draw("text", { class: "unit", x: (LEFT_PX + width) / 2, y: HEIGHT_PX - 6, "text-anchor": "middle" }, chart.x),
    draw("text", { class: "unit", x: 2, y: 9 }, chart.y),
  );
  const ends = frame.curves.map((curve) => [...curve.points].sort((a, b) => a.x - b.x).at(-1));
  const heights = apart(ends.map((end) => (end ? y.at(end.y) : 0)));
  for (const [i, curve] of frame.curves.entries()) {
    const points = chart.joined ? [...curve.points].sort((a, b) => a.x - b.x) : curve.points;
    const end = ends[i];
    if (right > 0 && end) {
      drawing.append(draw("text", { class: "end", x: width - right, y: heights[i] + 4, style: colourOf(curve.look) }, curve.name));
    }
    const steps = points.map((point, i) => `${i ? "L" : "M"}${x.at(point.x).toFixed(1)} ${y.at(point.y).toFixed(1)}`);
    const group = draw("g", { class: "curve", "data-name": curve.name }, ...pathsOf(curve, steps.join(""), chart.joined));
    for (const point of points) {
      const [px, py] = [x.at(point.x), y.at(point.y)];
      const mark = draw(
        "g",
        { class: "mark" },
        markerOf(curve.look, px, py),
        draw("circle", { class: "touch", cx: px, cy: py, r: 8 }),
      );
      group.append(tells(mark, point.title, point.facts, point.sources));
    }
    drawing.append(group);
  }
  return drawing;
}
