// @ts-check
// The page's elements.

const KEYS = [
  ["Space", "play or pause"], ["← →", "a line back or on"], ["N, Shift N", "next or last collision"], ["E, Shift E", "next or last event"], ["Home, End", "start, end"],
  ["+ −", "faster, slower"], ["S", "stop before first contact"], ["T", "trees"], ["[ ]", "level up or down"], ["B", "side by side"],
  ["X", "see through parts"], ["A", "axes of the machine"], ["P", "path of the tool"], ["W", "frame work and tool"], ["F", "frame what is nearest"], ["R", "frame the machine"], ["D", "dark or light"],
];

/** Puts everything into the view's element. @param {View} view */
function layOut(view) {
  const { data, motion } = view;
  const button = (/** @type {string} */ text, /** @type {string} */ title, /** @type {() => void} */ click, name = "") =>
    make("button", { type: "button", title, "aria-label": title, click, name }, text);
  const canvas = make("canvas", { class: "bv-gl" });
  const over = make("canvas", { class: "bv-marks", "aria-label": "The machine; drag to turn it" });
  const banner = make("div", { class: "bv-banner", role: "alert", hidden: true });
  const help = make("div", { class: "bv-help", hidden: true }, make("dl", {}, ...KEYS.flatMap(([key, what]) => [make("dt", {}, key), make("dd", {}, what)])));
  const subtitle = data.program ? `${data.name}, ${data.program.file}` : data.name;
  const toggles = {
    xray: button("See through", "See through parts that are not of the nearest pair (X)", () => view.toggle("xray")),
    axes: button("Axes", "Axes of the machine (A)", () => view.toggle("axes")),
    path: button("Path", "Path of the tool: feed moves blue, rapids amber (P)", () => view.toggle("path")),
  };
  toggles.path.hidden = !data.path;
  const crashes = data.events.filter(isCollision).length;
  const leap = [button("◂ Collision", "Last collision (shift N)", () => view.collision(-1)), button("Collision ▸", "Next collision (N)", () => view.collision(1))];
  leap.forEach((element) => (element.hidden = crashes === 0));
  const tools = make("div", { class: "bv-tools" }, toggles.xray, toggles.axes, toggles.path,
    button("Work", "Frame work and tool (W)", () => view.frameWork()), button("Nearest", "Frame the nearest pair (F)", () => view.focus()), button("All", "Frame the machine (R)", () => view.reset()),
    button("◐", "Dark or light (D)", () => view.theme()), button("?", "Keys", () => (help.hidden = !help.hidden)));
  const stage = make("section", { class: "bv-stage" }, canvas, over,
    make("header", { class: "bv-title" }, make("b", {}, data.title), make("span", {}, subtitle)), tools, banner, help);

  const play = button("▶", "Play (space)", () => view.toggle("playing"), "play");
  const rate = make("select", { "aria-label": "speed", change: () => (view.speed = Number(rate.value)) },
    ...SPEEDS.map((speed) => make("option", { value: speed }, `${speed}×`)));
  const stop = make("input", { type: "checkbox", name: "stop", change: () => view.setStopBefore(stop.checked) });
  const strip = make("canvas", { class: "bv-strip", "aria-label": "Program time; drag to go there" });
  const timeline = new Timeline(strip, motion, view.nearness, (place) => view.go(place));
  const transport = make("section", { class: "bv-transport" },
    make("div", { class: "bv-row" },
      button("|◂", "Last event (shift E)", () => view.event(-1)), button("◂", "A line back (←)", () => view.step(-1)), play,
      button("▸", "A line on (→)", () => view.step(1)), button("▸|", "Next event (E)", () => view.event(1)), ...leap, rate,
      make("label", { title: "Play stops at the block before a collision (S)" }, stop, " stop before first contact")), strip);
  transport.hidden = !data.program;

  const operator = new OperatorPanel(data, motion);
  const treePanel = new TreePanel(data, view.showing, view.layout, () => view.refresh());
  const program = new ProgramList(data, motion, (line) => view.goToLine(line));
  const side = make("aside", { class: "bv-side" });
  if (data.program) side.append(operator.element);
  side.append(treePanel.element, partsPanel(data, view.showing, () => view.refresh()));
  if (data.program) side.append(eventsPanel(data, (event) => view.visit(event), (fault) => view.goToFault(fault)), program.element);
  view.root.append(stage, transport, side);
  return { canvas, over, banner, help, toggles, play, rate, stop, timeline, operator, treePanel, program };
}
