// @ts-check
// The viewer: what is shown, what plays, and who may ask (`window.bvbench`, docs/view.md).

/** @typedef {{ state: "clear" | "near" | "fault" | "collision", text: string }} Status */

/** Speeds, times that of the machine. */
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
/** How long a program takes on the screen unless somebody says otherwise, s. */
const SHOW_S = 40;
/** Time between frames above which a moving picture gets coarser, and below which it gets finer again, ms. */
const [SLOW_MS, FAST_MS] = [40, 22];
/** The coarsest, pixels of the picture per pixel of the screen; and how long it stays so when nothing moves any more, ms. */
const [COARSEST, REST_MS] = [0.5, 200];
/** How long the eye takes to fly somewhere, and how long after its last move it is taken to rest, ms. */
const [FLIGHT_MS, SETTLE_MS] = [350, 120];
/** Directions from which the work is looked at when the page opens, radians about the upright axis; the first with the freest sight is taken. */
const AZIMUTHS = [0.61, -0.61, 0, 1.4, -1.4, 2.2, -2.2, Math.PI];
/** Triangles of a part that are looked at for each of these directions: enough to choose, and no wait with a million. */
const MOST_LOOKED_AT = 5000;
/** Where no time passes: keys in a second. */
const KEYS_PER_S = 4;

class View {
  /** @param {HTMLElement} root @param {ViewData} data @param {boolean} whole whether the page is nothing else */
  constructor(root, data, whole) {
    this.root = root;
    this.data = data;
    this.whole = whole;
    this.motion = new Motion(data);
    this.nearness = new Nearness(data);
    this.camera = new Camera(data.up);
    this.layout = { beside: false, first: 0 };
    /** @type {Showing} */
    this.showing = { place: 0, colliding: [], near: [], xray: false, trees: false, level: 0, volumes: "pair", pair: [], hidden: new Set(), faded: new Set(), path: true, axes: false, dark: false };
    this.playing = false;
    this.stopBefore = false;
    /** @type {ViewEvent | null} The collision before which the program is held. */
    this.held = null;
    this.speed = SPEEDS.find((speed) => this.motion.duration / speed <= SHOW_S) ?? 1000;
    this.frames = 0;
    /** When the last frame was painted, how fine it is, and what makes it fine again. */
    this.pace = { last: 0, fineness: 1, rest: 0 };
    this.pending = false;
    /** What should not be hidden: parts that matter, and a point among them. @type {"none" | "work" | "pair"} */
    this.watched = "none";
    this.settling = 0;
    this.flying = false;
    this.ui = layOut(this);
    this.stage = new Stage(new Gpu(this.ui.canvas), data, this.motion, this.camera);
    this.marks = new Marks(this.ui.over, this.stage);
    handle(this.ui.over, this.camera, () => {
      this.flying = false;
      this.#settle();
      this.draw();
    });
    this.#listen();
    this.frameWork();
    const wanted = whole ? new URLSearchParams(location.hash.slice(1)).get("t") : null;
    if (wanted !== null && Number.isFinite(Number(wanted))) this.go(this.motion.placeAt(Number(wanted)));
    this.refresh();
  }

  #listen() {
    const dark = matchMedia("(prefers-color-scheme: dark)");
    this.showing.dark = dark.matches;
    dark.addEventListener("change", () => this.theme(dark.matches));
    new ResizeObserver(() => this.draw()).observe(this.root);
    if (!this.whole) this.root.tabIndex = 0;
    const target = this.whole ? document : this.root;
    target.addEventListener("keydown", (event) => this.#key(/** @type {KeyboardEvent} */ (event)));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const on = event.target;
    const typing = on instanceof HTMLSelectElement || (on instanceof HTMLInputElement && on.type === "range");
    // The space bar works what has the focus, if that can be worked.
    const worked = event.key === " " && on instanceof HTMLElement && on.matches("button, input, summary");
    if (event.ctrlKey || event.metaKey || event.altKey || typing || worked) return;
    /** @type {Record<string, () => void>} */
    const does = {
      " ": () => this.toggle("playing"), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1), e: () => this.event(event.shiftKey ? -1 : 1),
      Home: () => this.go(0), End: () => this.go(this.motion.keys - 1), "+": () => this.faster(1), "=": () => this.faster(1), "-": () => this.faster(-1),
      s: () => this.setStopBefore(!this.stopBefore), t: () => this.setTrees(!this.showing.trees), "[": () => this.setLevel(this.showing.level - 1),
      "]": () => this.setLevel(this.showing.level + 1), b: () => this.setBeside(!this.layout.beside), x: () => this.toggle("xray"),
      n: () => this.collision(event.shiftKey ? -1 : 1), w: () => this.frameWork(), p: () => this.toggle("path"),
      a: () => this.toggle("axes"), f: () => this.focus(), r: () => this.reset(), d: () => this.theme(), "?": () => (this.ui.help.hidden = !this.ui.help.hidden),
    };
    const act = does[event.key] ?? does[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  }

  // What is shown.

  /** Goes to a place and stays. @param {number} place */
  go(place) {
    this.held = null;
    this.showing.place = clamp(place, 0, this.motion.keys - 1);
    this.#settle();
    this.refresh();
  }

  /** To the first collision that begins on a line; else to the end of the first way through it, or through the next that moves anything. @param {number} line */
  goToLine(line) {
    const runs = this.motion.runs;
    const crash = this.data.events.find((event) => isCollision(event) && event.line === line);
    const run = runs.find((run) => run.line === line) ?? runs.find((run) => run.line > line) ?? runs[runs.length - 1];
    if (crash) this.goToEvent(crash);
    else if (run) this.go(run.last);
  }

  /** @param {ViewEvent} event */
  goToEvent(event) {
    this.pause();
    this.go(isCollision(event) ? event.first : event.nearest);
  }

  /** @param {Fault} fault */
  goToFault(fault) {
    this.pause();
    this.go(fault.first);
  }

  /** To the end of the next line, or of the last one. @param {number} by 1 or -1 */
  step(by) {
    this.pause();
    const { runs, runEnds } = this.motion;
    const done = countUpTo(runEnds, this.showing.place);
    const run = by > 0 ? runs[Math.min(done, runs.length - 1)] : runs[done - (done > 0 && runEnds[done - 1] === this.showing.place ? 2 : 1)];
    this.go(run ? run.last : 0);
  }

  /** To the next event that is not over, or the last one. @param {number} by */
  event(by) {
    const at = (/** @type {ViewEvent} */ event) => (isCollision(event) ? event.first : event.nearest);
    const sorted = [...this.data.events].sort((p, q) => at(p) - at(q));
    const there = this.showing.place;
    const found = by > 0 ? sorted.find((event) => at(event) > there + 1e-6) : sorted.reverse().find((event) => at(event) < there - 1e-6);
    if (found) this.goToEvent(found);
  }

  /** Flies to the collision that begins next, or to the last one. @param {number} by 1 or -1 */
  collision(by) {
    const sorted = this.data.events.filter(isCollision).sort((p, q) => p.first - q.first);
    const there = this.showing.place;
    const found = by > 0 ? sorted.find((event) => event.first > there + 1e-6) : sorted.reverse().find((event) => event.first < there - 1e-6);
    if (found) this.visit(found);
  }

  /** Goes to an event and flies to where it happens. @param {ViewEvent} event */
  visit(event) {
    this.goToEvent(event);
    if (isCollision(event)) this.#fly(() => this.focus());
  }

  /** @param {"playing" | "xray" | "axes" | "path"} what */
  toggle(what) {
    if (what === "playing") {
      if (this.playing) this.pause();
      else this.start();
      return;
    }
    this.showing[what] = !this.showing[what];
    this.refresh();
  }

  /** @param {boolean} trees */
  setTrees(trees) {
    this.showing.trees = trees && this.data.variants.length > 0;
    this.ui.treePanel.show();
    this.refresh();
  }

  /** @param {number} level */
  setLevel(level) {
    this.showing.level = clamp(level, 0, Number(this.ui.treePanel.level.max));
    this.setTrees(true);
  }

  /** @param {boolean} beside */
  setBeside(beside) {
    this.layout.beside = beside && this.data.variants.length > 1;
    this.setTrees(this.showing.trees || beside);
  }

  /** @param {boolean} stop */
  setStopBefore(stop) {
    this.stopBefore = this.ui.stop.checked = stop;
    this.held = null;
    this.refresh();
  }

  /** @param {number} by */
  faster(by) {
    this.speed = SPEEDS[clamp(SPEEDS.indexOf(this.speed) + by, 0, SPEEDS.length - 1)];
    this.refresh();
  }

  /** @param {boolean} [dark] */
  theme(dark = !this.showing.dark) {
    this.showing.dark = dark;
    this.refresh();
  }

  /** Frames what is nearest, or collides; fades what hides it. */
  focus() {
    const { showing, stage, camera } = this;
    if (showing.pair.length === 0) return;
    const balls = showing.pair.map((part) => stage.ballAround([part], showing.place));
    const radius = Math.min(...balls.map((ball) => ball[1]));
    this.watched = "pair";
    camera.frame(this.#watchedPoint(), clamp(1.3 * radius, 0.05 * camera.size, 0.2 * camera.size), this.aspect());
    this.#fade();
    this.refresh();
  }

  /** Frames workpiece and tool, from where the least stands before them, and fades what still does. A machine without them is framed whole. */
  frameWork() {
    const { stage, camera, showing } = this;
    const matter = this.#work();
    if (matter.length === 0) {
      this.reset();
      return;
    }
    const [middle, radius] = stage.ballAround(matter, showing.place);
    this.watched = "work";
    camera.elevation = 0.46;
    camera.frame(middle, clamp(radius, 0.02 * camera.size, 0.46 * camera.size), this.aspect());
    const points = matter.map((part) => stage.ballAround([part], showing.place)[0]);
    const inTheWay = AZIMUTHS.map((azimuth) => {
      camera.azimuth = azimuth;
      return points.reduce((sum, point) => sum + stage.hiding(point, matter, showing, MOST_LOOKED_AT).length, 0);
    });
    camera.azimuth = AZIMUTHS[inTheWay.indexOf(Math.min(...inTheWay))];
    this.#fade();
    this.draw();
  }

  /** Frames the machine. */
  reset() {
    this.watched = "none";
    this.showing.faded = new Set();
    this.camera.azimuth = 0.61;
    this.camera.elevation = 0.46;
    this.camera.frame(/** @type {Vec3} */ (this.stage.middle), 0.46 * this.camera.size, this.aspect());
    this.draw();
  }

  /** Workpiece and mounted tool; without a workpiece, what is examined. */
  #work() {
    const { data, stage, showing } = this;
    const there = (/** @type {(part: PartData) => boolean} */ is) => [...data.parts.keys()].filter((part) => is(data.parts[part]) && stage.isShown(part, showing));
    const work = there((part) => part.role === "workpiece");
    const tool = there((part) => ["cutter", "shank", "holder"].includes(part.role));
    return work.length > 0 && tool.length > 0 ? [...work, ...tool] : there((part) => part.examined || part.role === "workpiece");
  }

  /** The point that should not be hidden. @returns {Vec3} */
  #watchedPoint() {
    const { showing, stage } = this;
    const balls = (this.watched === "pair" ? showing.pair : this.#work()).map((part) => stage.ballAround([part], showing.place));
    const [middle] = balls.reduce((least, ball) => (ball[1] < least[1] ? ball : least), balls[0]);
    const crash = this.watched === "pair" ? showing.colliding[0] : undefined;
    const first = crash?.contacts[0]?.at;
    const poses = this.motion.posesAt(this.motion.positionAt(showing.place));
    return crash && first ? apply(stage.worldFromPart(crash.pair[0], poses), first) : middle;
  }

  /** Fades what hides the watched point. */
  #fade() {
    const matter = this.watched === "pair" ? this.showing.pair : this.#work();
    const watches = this.watched !== "none" && matter.length > 0;
    this.showing.faded = new Set(watches ? this.stage.hiding(this.#watchedPoint(), matter, this.showing) : []);
  }

  /** Fades anew once the eye or the machine rests. */
  #settle() {
    clearTimeout(this.settling);
    if (this.watched === "none") return;
    this.settling = setTimeout(() => {
      if (this.playing || this.flying) return;
      this.#fade();
      this.draw();
    }, SETTLE_MS);
  }

  /** Lets the eye fly to where `aim` puts it; where nobody wants things to move, it is there at once. @param {() => void} aim */
  #fly(aim) {
    const { camera } = this;
    const from = { target: camera.target, distance: camera.distance };
    aim();
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    const to = { target: camera.target, distance: camera.distance };
    const begin = performance.now();
    this.flying = true;
    const tick = () => {
      if (!this.flying) return;
      const t = Math.min((performance.now() - begin) / FLIGHT_MS, 1);
      const part = t * t * (3 - 2 * t);
      camera.target = plus(times(from.target, 1 - part), times(to.target, part));
      camera.distance = from.distance ** (1 - part) * to.distance ** part;
      this.flying = t < 1;
      this.draw();
      if (this.flying) requestAnimationFrame(tick);
    };
    tick();
  }

  aspect() {
    return Math.max(this.ui.canvas.clientWidth, 1) / Math.max(this.ui.canvas.clientHeight, 1) / (this.layout.beside ? 2 : 1);
  }

  // What plays.

  start() {
    if (this.showing.place >= this.motion.keys - 1) this.showing.place = 0;
    this.playing = this.motion.keys > 1;
    /** @type {number | null} */
    let last = null;
    const tick = (/** @type {number} */ now) => {
      if (!this.playing) return;
      this.#advance(last === null ? 0 : Math.min((now - last) / 1000, 0.25));
      last = now;
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    this.refresh();
  }

  pause() {
    this.playing = false;
    this.refresh();
    this.#settle();
    if (this.whole) history.replaceState(null, "", `#t=${this.motion.timeAt(this.showing.place).toFixed(2)}`);
  }

  /** @param {number} seconds on the screen */
  #advance(seconds) {
    const { motion } = this;
    const from = this.showing.place;
    let to = motion.duration > 0 ? motion.placeAt(motion.timeAt(from) + seconds * this.speed) : from + seconds * KEYS_PER_S;
    // No frame leaps over the beginning of a collision, however fast.
    const ahead = this.data.events.filter((event) => isCollision(event) && event.first >= from);
    for (const { first } of ahead) if (first > from) to = Math.min(to, first);
    // Where no time passes the place of a time is the last of its places.
    to = Math.max(to, from);
    const next = this.stopBefore ? ahead[0] : undefined;
    const hold = next ? motion.runAt(next.first)?.first ?? 0 : Infinity;
    this.held = next && to >= hold ? next : null;
    if (this.held) to = Math.max(Math.min(to, hold), Math.min(from, hold));
    this.showing.place = Math.min(to, motion.keys - 1);
    if (this.held || to >= motion.keys - 1) this.playing = false;
    this.refresh();
  }

  // What is drawn.

  /** @returns {Status} */
  status() {
    const { colliding, near } = this.showing;
    const nearest = this.nearness.at(this.showing.place);
    if (colliding.length > 0) {
      return { state: "collision", text: colliding.map((event) => pairName(this.data, event.pair)).join("; ") };
    }
    const faults = this.nearness.faultsAt(this.showing.place);
    if (faults.length > 0) return { state: "fault", text: faults.map((fault) => fault.text).join("; ") };
    const text = nearest ? `${nearest.mm.toFixed(2)} mm: ${pairName(this.data, nearest.pair)}` : this.nearness.keys.length > 0 ? `more than ${this.nearness.farthest} mm to anything` : "";
    return { state: near.length > 0 ? "near" : "clear", text };
  }

  /** Shows what has changed, with the next frame. */
  refresh() {
    const { colliding, near } = this.nearness.eventsAt(this.showing.place);
    Object.assign(this.showing, { colliding, near });
    const pair = this.nearness.at(this.showing.place)?.pair ?? this.data.events.find(isCollision)?.pair;
    const before = this.showing.pair;
    this.showing.pair = pair ? [...pair] : this.data.parts.flatMap((part, index) => (part.examined ? [index] : []));
    if (before.join() !== this.showing.pair.join()) this.ui.treePanel.show();
    this.root.dataset.theme = this.showing.dark ? "dark" : "light";
    this.ui.play.textContent = this.playing ? "❚❚" : "▶";
    this.ui.rate.value = String(this.speed);
    for (const what of /** @type {const} */ (["xray", "axes", "path"])) this.ui.toggles[what].setAttribute("aria-pressed", String(this.showing[what]));
    this.ui.banner.hidden = !this.held;
    if (this.held) this.ui.banner.textContent = `Held before line ${this.held.line}: ${pairName(this.data, this.held.pair)} would collide`;
    this.draw();
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.paint();
    });
  }

  paint() {
    const { showing, layout } = this;
    const { canvas } = this.ui;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0 || height === 0) return;
    const scale = Math.min(devicePixelRatio, 2) * this.#fineness();
    const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const beside = layout.beside && showing.trees;
    const columns = beside ? 2 : 1;
    const boxes = [...Array(columns).keys()].map((i) => ({ left: (i * width) / columns, bottom: 0, width: width / columns, height }));
    const scaled = boxes.map((box) => ({ left: box.left * scale, bottom: 0, width: box.width * scale, height: h }));
    this.stage.draw(showing, scaled, beside ? [0, 1] : [layout.first]);
    const names = showing.trees ? (beside ? [0, 1] : [layout.first]).map((i) => this.data.variants[i]?.label ?? "") : [];
    this.marks.draw(showing, boxes, names);
    if (this.data.program) {
      this.ui.operator.show(showing.place, this.status());
      this.ui.timeline.draw(showing.place);
      this.ui.program.show(this.motion.lineAt(showing.place));
    }
    this.frames++;
  }

  /** How fine the next picture is: while frames come one after another, as fine as the machine can; else as fine as the screen. */
  #fineness() {
    const { pace } = this;
    const now = performance.now();
    const between = now - pace.last;
    pace.last = now;
    clearTimeout(pace.rest);
    if (between > 2 * REST_MS) pace.fineness = 1;
    else if (between > SLOW_MS) pace.fineness = Math.max(COARSEST, pace.fineness * 0.8);
    else if (between < FAST_MS) pace.fineness = Math.min(1, pace.fineness * 1.05);
    if (pace.fineness < 1) {
      pace.rest = setTimeout(() => {
        pace.last = 0;
        this.paint();
      }, REST_MS);
    }
    return pace.fineness;
  }

  // Who may ask: docs/view.md.

  state() {
    const { showing, motion, data } = this;
    const position = motion.positionAt(showing.place);
    const name = (/** @type {number} */ part) => data.parts[part].name;
    const nearest = this.nearness.at(showing.place);
    return {
      place: showing.place,
      places: motion.keys,
      time_s: motion.timeAt(showing.place),
      line: motion.lineAt(showing.place),
      tool: motion.toolAt(showing.place),
      ...this.status(),
      colliding: showing.colliding.map((event) => event.pair.map(name)),
      nearest: nearest && { mm: nearest.mm, pair: nearest.pair.map(name) },
      axes: Object.fromEntries(motion.axes.map((axis) => [AXIS_LETTERS[axis], isRotary(axis) ? (position[axis] * 180) / Math.PI : position[axis]])),
      playing: this.playing,
      held: this.held?.line ?? null,
      trees: showing.trees,
      level: showing.level,
      beside: this.layout.beside,
      dark: showing.dark,
      frames: this.frames,
      fine: this.pace.fineness === 1,
      faded: [...showing.faded].map(name),
      flying: this.flying,
    };
  }

  /** World from a part, sixteen numbers. @param {string} name */
  pose(name) {
    const part = this.data.parts.findIndex((part) => part.name === name);
    return part < 0 ? null : this.stage.worldFromPart(part, this.motion.posesAt(this.motion.positionAt(this.showing.place)));
  }
}

/** Starts the viewer that a script element belongs to, when it first comes into sight. @param {HTMLOrSVGScriptElement | null} script */
function start(script) {
  const root = script?.parentElement;
  const json = root?.querySelector("script[type='application/json']");
  if (!root || !json) return;
  const page = /** @type {{ bvbench?: View[] }} */ (/** @type {unknown} */ (window));
  const views = (page.bvbench ??= []);
  new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    try {
      views.push(new View(root, JSON.parse(json.textContent ?? ""), root.classList.contains("bv-whole")));
    } catch (error) {
      root.append(make("p", { class: "bv-error" }, error instanceof Error ? error.message : String(error)));
    }
  }).observe(root);
}
