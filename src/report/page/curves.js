// @ts-check
// Curves and clouds of points in a frame with two axes, a colour and a dash for each variant, the names below.

/** @typedef {{x: number, y: number, title: string, facts: [string, string][], sources: Row[]}} Point */
/** @typedef {{look: number, name: string, points: Point[]}} Curve */
/** @typedef {{title: string, curves: Curve[]}} Frame */
/** @typedef {{frames: Frame[], x: string, y: string, logX: boolean, logY: boolean, joined: boolean, diagonal?: boolean}} Curves */

const HEIGHT_PX = 260;
const LEFT_PX = 46;
const DASHES = ["", "7 3", "2 3", "9 3 2 3"];
const COLOURS = 8;

/** Draws the frames into a place, and the legend below them. @param {HTMLElement} place @param {Curves} chart */
function drawCurves(place, chart) {
  drawPanels(place, chart.frames, (frame, width) => curvesPanel(frame, chart, width));
  const names = new Map(chart.frames.flatMap((frame) => frame.curves.map((curve) => [curve.name, curve.look])));
  const entries = [...names].map(([name, look]) => {
    const sample = draw(
      "svg",
      { width: 30, height: 12, viewBox: "0 0 30 12", "aria-hidden": "true" },
      ...pathsOf(look, "M1 6H29", chart.joined),
      shapeOf(look, 15, 6),
    );
    const over = (/** @type {boolean} */ on) => () => highlight(place, on ? name : null);
    return el(
      "button",
      {
        type: "button",
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

/** @param {number} look @param {string} path @param {boolean} joined */
function pathsOf(look, path, joined) {
  const dash = DASHES[Math.floor(look / COLOURS) % DASHES.length];
  return joined ? [draw("path", { class: `stroke look-${look % COLOURS}`, d: path, "stroke-dasharray": dash })] : [];
}

/** The marker of a look: nothing must rest on colour alone. @param {number} look @param {number} x @param {number} y */
function shapeOf(look, x, y) {
  const paths = [
    "M-3.6 0a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0-7.2 0",
    "M-3.2-3.2h6.4v6.4h-6.4z",
    "M0-4.4L4 3H-4z",
    "M0-4.6L4.6 0L0 4.6L-4.6 0z",
    "M0 4.4L4-3H-4z",
  ];
  return draw("path", {
    class: `shape look-${look % COLOURS}`,
    d: paths[look % paths.length],
    transform: `translate(${x} ${y})`,
  });
}

/** @param {Frame} frame @param {Curves} chart @param {number} width */
function curvesPanel(frame, chart, width) {
  const points = frame.curves.flatMap((curve) => curve.points);
  const [xs, ys] = [points.map((point) => point.x), points.map((point) => point.y)];
  const both = chart.diagonal ? [...xs, ...ys] : null;
  const bottom = HEIGHT_PX - FOOT_PX;
  const x = scaleOf(both ?? xs, chart.logX, [LEFT_PX + 8, width - 12], Math.max(3, Math.floor(width / 64)));
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
      draw("line", { class: "grid", x1: LEFT_PX, x2: width - 6, y1: y.at(tick), y2: y.at(tick) }),
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
  for (const curve of frame.curves) {
    const steps = curve.points.map((point, i) => `${i ? "L" : "M"}${x.at(point.x).toFixed(1)} ${y.at(point.y).toFixed(1)}`);
    const group = draw("g", { class: "curve", "data-name": curve.name }, ...pathsOf(curve.look, steps.join(""), chart.joined));
    for (const point of curve.points) {
      const [px, py] = [x.at(point.x), y.at(point.y)];
      const mark = draw(
        "g",
        { class: "mark" },
        shapeOf(curve.look, px, py),
        draw("circle", { class: "touch", cx: px, cy: py, r: 8 }),
      );
      group.append(tells(mark, point.title, point.facts, point.sources));
    }
    drawing.append(group);
  }
  return drawing;
}
