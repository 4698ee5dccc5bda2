// @ts-check
// The program as a strip: distance of the nearest pair, near-miss zones, collisions; drag it to go there. And the marks over the
// picture: axes, first contact, names.

/** The nearest pair along the path. */
class Nearness {
  /** @param {ViewData} data */
  constructor({ distances, events, faults }) {
    this.pairs = distances.pairs;
    this.farthest = distances.farthest_mm;
    this.keys = f32(distances.keys);
    this.mm = f32(distances.mm);
    this.nearest = u32(distances.nearest);
    this.events = events;
    this.faults = faults;
  }

  /** What makes the check fail there and is of no pair. @param {number} place */
  faultsAt(place) {
    return this.faults.filter((fault) => place >= fault.first - 1e-4 && place <= fault.last + 1e-4);
  }

  /** Collisions, and nearness in its narrowest zone, at a place. @param {number} place */
  eventsAt(place) {
    const there = this.events.filter((event) => place >= event.first - 1e-4 && (event.to_the_end || place <= event.last + 1e-4));
    const colliding = there.filter(isCollision);
    return { colliding, near: there.filter((event) => !isCollision(event)) };
  }

  /** @param {number} place @returns {{ mm: number, pair: [number, number] } | null} */
  at(place) {
    const { colliding } = this.eventsAt(place);
    if (colliding.length > 0) return { mm: 0, pair: colliding[0].pair };
    if (this.keys.length === 0) return null;
    const next = Math.min(countUpTo(this.keys, place), this.keys.length - 1);
    const before = Math.max(next - 1, 0);
    const part = this.keys[next] > this.keys[before] ? clamp((place - this.keys[before]) / (this.keys[next] - this.keys[before]), 0, 1) : 1;
    const mm = this.mm[before] + part * (this.mm[next] - this.mm[before]);
    const pair = this.nearest[part < 0.5 ? before : next];
    return pair === 0xffffffff || mm >= this.farthest ? null : { mm, pair: this.pairs[pair] };
  }
}

class Timeline {
  /** @param {HTMLCanvasElement} canvas @param {Motion} motion @param {Nearness} nearness @param {(place: number) => void} go */
  constructor(canvas, motion, nearness, go) {
    this.canvas = canvas;
    this.motion = motion;
    this.nearness = nearness;
    /** What `strip` was drawn for. */
    this.drawn = "";
    /** @type {HTMLCanvasElement | null} */
    this.strip = null;
    const seek = (/** @type {PointerEvent} */ event) => {
      const box = canvas.getBoundingClientRect();
      go(this.placeAt(clamp((event.clientX - box.left) / box.width, 0, 1)));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener("pointermove", (event) => event.buttons && seek(event));
  }

  /** A part of the strip's width; by time, or by keys where no time passes. @param {number} place */
  at(place) {
    const { duration, keys } = this.motion;
    return duration > 0 ? this.motion.timeAt(place) / duration : place / Math.max(keys - 1, 1);
  }

  /** @param {number} part */
  placeAt(part) {
    const { duration, keys } = this.motion;
    return duration > 0 ? this.motion.placeAt(part * duration) : part * (keys - 1);
  }

  /** @param {number} place */
  draw(place) {
    const style = getComputedStyle(this.canvas);
    const { ctx, width, height } = sharp(this.canvas);
    // Where the strip is hidden, as on paper, it has no size, and nothing can be drawn from a canvas without one.
    if (width === 0 || height === 0) return;
    const strip = this.#background(width, height, style);
    ctx.clearRect(0, 0, width, height);
    ctx.drawImage(strip, 0, 0, width, height);
    const x = this.at(place) * width;
    ctx.fillStyle = style.getPropertyValue("--ink");
    ctx.fillRect(clamp(x - 1, 0, width - 2), 0, 2, height);
    ctx.beginPath();
    ctx.arc(clamp(x, 5, width - 5), 5, 5, 0, 2 * Math.PI);
    ctx.fill();
  }

  /** All but the playhead, drawn once for a size and a theme. @param {number} width @param {number} height @param {CSSStyleDeclaration} style */
  #background(width, height, style) {
    const key = [width, height, style.getPropertyValue("--ink"), devicePixelRatio].join(" ");
    if (this.strip && this.drawn === key) return this.strip;
    this.drawn = key;
    const strip = (this.strip = document.createElement("canvas"));
    strip.width = width * devicePixelRatio;
    strip.height = height * devicePixelRatio;
    const ctx = /** @type {CanvasRenderingContext2D} */ (strip.getContext("2d"));
    ctx.scale(devicePixelRatio, devicePixelRatio);
    const colour = (/** @type {string} */ name) => style.getPropertyValue(name);
    const band = (/** @type {{ first: number, last: number, to_the_end: boolean }} */ event, /** @type {number} */ least) => {
      const from = this.at(event.first) * width;
      const to = (event.to_the_end ? 1 : this.at(event.last)) * width;
      ctx.fillRect(from, 0, Math.max(to - from, least), height);
    };
    const { events, faults, keys, mm } = this.nearness;
    ctx.fillStyle = colour("--near-band");
    for (const event of events) if (!isCollision(event)) band(event, 1);
    // The square root of the distance, so that the last millimetres show.
    const ceiling = Math.sqrt(40);
    const y = (/** @type {number} */ distance) => 8 + (height - 10) * (1 - Math.min(Math.sqrt(distance) / ceiling, 1));
    ctx.beginPath();
    ctx.moveTo(0, height);
    keys.forEach((key, i) => ctx.lineTo(this.at(key) * width, y(mm[i])));
    ctx.lineTo(width, height);
    ctx.globalAlpha = 0.2;
    ctx.fillStyle = colour("--accent");
    if (keys.length > 0) ctx.fill();
    ctx.globalAlpha = 1;
    ctx.strokeStyle = colour("--accent");
    ctx.lineWidth = 1.2;
    if (keys.length > 0) ctx.stroke();
    ctx.fillStyle = colour("--collision");
    for (const event of events) if (isCollision(event)) band(event, 3);
    for (const fault of faults) band({ ...fault, to_the_end: false }, 3);
    return strip;
  }
}

/** A canvas as large as it is shown, in the screen's pixels. @param {HTMLCanvasElement} canvas */
function sharp(canvas) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const scale = devicePixelRatio;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const ctx = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  ctx.setTransform(scale, 0, 0, scale, 0, 0);
  return { ctx, width, height };
}

/** Marks over the picture. */
class Marks {
  /** @param {HTMLCanvasElement} canvas @param {Stage} stage */
  constructor(canvas, stage) {
    this.canvas = canvas;
    this.stage = stage;
  }

  /** @param {Showing} showing @param {Box[]} boxes in CSS pixels @param {string[]} names */
  draw(showing, boxes, names) {
    const { ctx, width, height } = sharp(this.canvas);
    const style = getComputedStyle(this.canvas);
    ctx.clearRect(0, 0, width, height);
    ctx.font = "600 12px system-ui, sans-serif";
    ctx.textBaseline = "middle";
    const { camera, motion } = this.stage;
    const eye = camera.eyeFromWorld();
    const poses = motion.posesAt(motion.positionAt(showing.place));
    boxes.forEach((box, number) => {
      const top = height - box.bottom - box.height;
      const clip = multiply(camera.clipFromEye(box.width / box.height), eye);
      /** @param {Vec3} p @returns {[number, number]} */
      const project = (p) => {
        const w = clip[3] * p[0] + clip[7] * p[1] + clip[11] * p[2] + clip[15];
        const [x, y] = apply(clip, p);
        return [box.left + (0.5 + (0.5 * x) / w) * box.width, top + (0.5 - (0.5 * y) / w) * box.height];
      };
      ctx.save();
      ctx.beginPath();
      ctx.rect(box.left, top, box.width, box.height);
      ctx.clip();
      if (showing.axes) this.#joints(ctx, project, poses, style);
      for (const event of showing.colliding) this.#contact(ctx, project, poses, event, showing.place, style);
      ctx.restore();
      if (names[number]) label(ctx, names[number], box.left + 18, top + 84, style);
    });
    if (boxes.length > 1) {
      ctx.fillStyle = style.getPropertyValue("--line");
      ctx.fillRect(boxes[1].left - 0.5, 0, 1, height);
    }
    this.#triad(ctx, eye, width, style);
  }

  /** The world's axes. @param {CanvasRenderingContext2D} ctx @param {Mat4} eye @param {number} width @param {CSSStyleDeclaration} style */
  #triad(ctx, eye, width, style) {
    const [x, y, length] = [width - 48, 50, 28];
    /** @type {[string, Vec3, string][]} */
    const axes = [["X", [1, 0, 0], "#e0483e"], ["Y", [0, 1, 0], "#3f9d4e"], ["Z", [0, 0, 1], "#3c78d8"]];
    const seen = axes.map(([name, along, colour]) => ({ name, colour, at: applyToDirection(eye, along) }));
    seen.sort((a, b) => a.at[2] - b.at[2]);
    for (const { name, colour, at } of seen) {
      arrow(ctx, [x, y], [x + length * at[0], y - length * at[1]], colour);
      ctx.fillStyle = style.getPropertyValue("--ink");
      ctx.textAlign = "center";
      ctx.fillText(name, x + (length + 11) * at[0], y - (length + 11) * at[1]);
    }
    ctx.textAlign = "start";
  }

  /** The machine's axes, each where its link is. @param {CanvasRenderingContext2D} ctx @param {(p: Vec3) => [number, number]} project @param {Mat4[]} poses @param {CSSStyleDeclaration} style */
  #joints(ctx, project, poses, style) {
    const { data, camera } = this.stage;
    data.links.forEach((link, index) => {
      if (!link.joint) return;
      const own = data.parts.findIndex((part) => part.link === index);
      const anchor = link.joint.turns || own < 0
        ? apply(poses[index], link.joint.point)
        : apply(this.stage.worldFromPart(own, poses), times(boxCorners(data.parts[own]).reduce(plus, [0, 0, 0]), 1 / 8));
      const along = times(direction(applyToDirection(poses[index], link.joint.direction)), 0.14 * camera.size);
      const from = project(link.joint.turns ? minus(anchor, along) : anchor);
      const to = project(plus(anchor, along));
      ctx.setLineDash(link.joint.turns ? [6, 4] : []);
      arrow(ctx, from, to, style.getPropertyValue("--accent"));
      ctx.setLineDash([]);
      label(ctx, AXIS_LETTERS[link.joint.axis], to[0] + 6, to[1], style);
    });
  }

  /** Where two parts cut each other, and where they met first. @param {CanvasRenderingContext2D} ctx @param {(p: Vec3) => [number, number]} project @param {Mat4[]} poses @param {ViewEvent} event @param {number} place @param {CSSStyleDeclaration} style */
  #contact(ctx, project, poses, event, place, style) {
    const contact = contactAt(event, place);
    if (!contact) return;
    const world = this.stage.worldFromPart(event.pair[0], poses);
    const lines = f32(contact.lines);
    ctx.strokeStyle = "#fff6d0";
    ctx.lineWidth = 2;
    ctx.beginPath();
    for (let at = 0; at < lines.length; at += 6) {
      ctx.moveTo(...project(apply(world, lines.subarray(at, at + 3))));
      ctx.lineTo(...project(apply(world, lines.subarray(at + 3, at + 6))));
    }
    ctx.stroke();
    const first = event.contacts[0].at;
    if (!first) return;
    const [x, y] = project(apply(world, first));
    ctx.strokeStyle = style.getPropertyValue("--collision");
    ctx.lineWidth = 2.5;
    ctx.beginPath();
    ctx.arc(x, y, 15, 0, 2 * Math.PI);
    ctx.stroke();
    label(ctx, `first contact, line ${event.line}`, x + 22, y - 16, style);
  }
}

/** @param {CanvasRenderingContext2D} ctx @param {[number, number]} from @param {[number, number]} to @param {string} colour */
function arrow(ctx, from, to, colour) {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(dx, dy);
  [ctx.strokeStyle, ctx.fillStyle, ctx.lineWidth] = [colour, colour, 2.5];
  ctx.beginPath();
  ctx.moveTo(...from);
  ctx.lineTo(...to);
  ctx.stroke();
  if (length < 8) return;
  const [ux, uy] = [(dx / length) * 8, (dy / length) * 8];
  ctx.beginPath();
  ctx.moveTo(to[0] + ux * 0.5, to[1] + uy * 0.5);
  ctx.lineTo(to[0] - ux - uy * 0.5, to[1] - uy + ux * 0.5);
  ctx.lineTo(to[0] - ux + uy * 0.5, to[1] - uy - ux * 0.5);
  ctx.fill();
}

/** Text on a small plate. @param {CanvasRenderingContext2D} ctx @param {string} text @param {number} x @param {number} y @param {CSSStyleDeclaration} style */
function label(ctx, text, x, y, style) {
  const width = ctx.measureText(text).width + 12;
  ctx.fillStyle = style.getPropertyValue("--plate");
  ctx.beginPath();
  ctx.roundRect(x - 6, y - 10, width, 20, 5);
  ctx.fill();
  ctx.fillStyle = style.getPropertyValue("--ink");
  ctx.fillText(text, x, y + 0.5);
}
