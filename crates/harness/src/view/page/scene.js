// @ts-check
// The machine on the screen: parts, what lights up on them, trees, floor and axes.

/** What parts are painted with, by role; other machine parts in greys. @type {Record<string, Vec3>} */
const PAINT = {
  cutter: [0.9, 0.33, 0.16],
  shank: [0.9, 0.45, 0.28],
  holder: [0.62, 0.42, 0.66],
  workpiece: [0.27, 0.53, 0.78],
  fixture: [0.42, 0.64, 0.42],
  examined: [0.93, 0.68, 0.25],
};
/** Of the first and the second part of a collision. @type {[Vec3, Vec3]} */
const REDS = [[0.93, 0.07, 0.16], [1.0, 0.36, 0.16]];
/** @type {Vec3} */
const AMBER = [1.0, 0.8, 0.0];
/** Of the first and the second variant shown, and of volumes that do not hold their contents. @type {[Vec3, Vec3, Vec3]} */
const TREE_PAINT = [[0.0, 0.55, 0.75], [0.35, 0.6, 0.15], [0.9, 0.05, 0.55]];

/**
 * What one picture shows.
 * @typedef {{ place: number, colliding: ViewEvent[], near: ViewEvent[], xray: boolean, trees: boolean, level: number, volumes: "pair" | "all" | number, pair: number[],
 *   hidden: Set<number>, faded: Set<number>, path: boolean, axes: boolean, dark: boolean }} Showing
 * @typedef {{ left: number, bottom: number, width: number, height: number }} Box
 */

class Stage {
  /** @param {Gpu} gpu @param {ViewData} data @param {Motion} motion @param {Camera} camera */
  constructor(gpu, data, motion, camera) {
    this.gpu = gpu;
    this.data = data;
    this.motion = motion;
    this.camera = camera;
    const gl = gpu.gl;
    this.surfaces = data.parts.map(surfaceOf);
    this.solids = this.surfaces.map(({ corners, normals }) => gpu.drawable(gl.TRIANGLES, corners, 4, normals));
    this.creases = this.surfaces.map(({ edges }) => gpu.drawable(gl.LINES, edges, 4));
    this.paint = data.parts.map((part, index) => paintOf(part, index));
    this.places = data.parts.map((part) => rigid(part.at));
    this.trees = data.variants.map((variant) => variant.trees.map((tree) => new TreeShapes(tree)));
    /** @type {Map<string, Drawable>} */
    this.made = new Map();
    /** The way of the tool, once it was drawn. @type {{ feed: Float32Array, rapid: Float32Array } | undefined} */
    this.path = undefined;
    this.#frame();
  }

  /** Frames the machine as it stands at first. */
  #frame() {
    const poses = this.motion.posesAt(this.motion.positionAt(0));
    /** @type {Vec3} */
    let low = [Infinity, Infinity, Infinity];
    /** @type {Vec3} */
    let high = [-Infinity, -Infinity, -Infinity];
    this.data.parts.forEach((part, index) => {
      for (const corner of boxCorners(part)) {
        const at = apply(this.worldFromPart(index, poses), corner);
        low = [Math.min(low[0], at[0]), Math.min(low[1], at[1]), Math.min(low[2], at[2])];
        high = [Math.max(high[0], at[0]), Math.max(high[1], at[1]), Math.max(high[2], at[2])];
      }
    });
    const middle = times(plus(low, high), 0.5);
    this.camera.size = Math.max(Math.hypot(...minus(high, low)), 1e-3);
    this.middle = middle;
    const up = this.camera.up;
    this.floor = minus(middle, times(up, dot(minus(middle, low), up) + 0.002 * this.camera.size));
  }

  /** @param {number} index @param {Mat4[]} poses @returns {Mat4} */
  worldFromPart(index, poses) {
    const link = this.data.parts[index].link;
    return link === null ? this.places[index] : multiply(poses[link], this.places[index]);
  }

  /** A ball around some parts. @param {number[]} parts @param {number} place @returns {[Vec3, number]} */
  ballAround(parts, place) {
    const poses = this.motion.posesAt(this.motion.positionAt(place));
    const points = parts.flatMap((part) => boxCorners(this.data.parts[part]).map((corner) => apply(this.worldFromPart(part, poses), corner)));
    const middle = times(points.reduce(plus, [0, 0, 0]), 1 / points.length);
    return [middle, Math.max(...points.map((point) => Math.hypot(...minus(point, middle))))];
  }

  /**
   * Parts that stand between the eye and a point, and are none of those that matter.
   * @param {Vec3} point @param {number[]} matter @param {Showing} showing @param {number} [most] triangles of a part that are looked at
   */
  hiding(point, matter, showing, most = Infinity) {
    const poses = this.motion.posesAt(this.motion.positionAt(showing.place));
    const hides = (/** @type {number} */ part) => {
      if (!this.isShown(part, showing) || matter.includes(part)) return false;
      const partFromWorld = inverse(this.worldFromPart(part, poses));
      return meets(this.surfaces[part], this.data.parts[part], apply(partFromWorld, this.camera.eye()), apply(partFromWorld, point), most);
    };
    return [...this.data.parts.keys()].filter(hides);
  }

  /** @param {number} part @param {Showing} showing */
  isShown(part, showing) {
    const tool = this.data.parts[part].tool;
    return !showing.hidden.has(part) && (tool === null || tool === this.motion.toolAt(showing.place));
  }

  /**
   * Draws into each box of the canvas, with a variant's trees.
   * @param {Showing} showing @param {Box[]} boxes @param {number[]} variants
   */
  draw(showing, boxes, variants) {
    const gl = this.gpu.gl;
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const poses = this.motion.posesAt(this.motion.positionAt(showing.place));
    const eye = this.camera.eyeFromWorld();
    const eyeFromPart = this.data.parts.map((_, part) => multiply(eye, this.worldFromPart(part, poses)));
    boxes.forEach((box, number) => {
      gl.viewport(box.left, box.bottom, box.width, box.height);
      const clip = this.camera.clipFromEye(box.width / box.height);
      this.#drawParts(showing, eyeFromPart, clip, eye);
      this.#drawFloor(showing, eye, clip);
      if (showing.path && this.data.path) this.#drawPath(poses, eye, clip);
      this.#drawContacts(showing, eyeFromPart, clip);
      if (showing.trees) this.#drawTrees(showing, variants[number], eyeFromPart, clip);
    });
  }

  /** @param {Showing} showing @param {Mat4[]} eyeFromPart @param {Mat4} clipFromEye @param {Mat4} eye */
  #drawParts(showing, eyeFromPart, clipFromEye, eye) {
    const [gpu, gl] = [this.gpu, this.gpu.gl];
    /** Parts that collide, and as which of the two. @type {Map<number, number>} */
    const colliding = new Map(showing.colliding.flatMap((event) => event.pair.map((part, side) => [part, side])));
    const near = new Set(showing.near.flatMap((event) => event.pair));
    const parts = this.data.parts.map((_, part) => part).filter((part) => this.isShown(part, showing));
    const isGhost = (/** @type {number} */ part) =>
      !colliding.has(part) && (showing.faded.has(part) || (showing.xray && !showing.pair.includes(part)));
    const skyward = applyToDirection(eye, this.camera.up);
    for (const ghosts of [false, true]) {
      for (const part of parts.filter((part) => isGhost(part) === ghosts)) {
        const data = this.data.parts[part];
        const side = colliding.get(part);
        const lit = side !== undefined ? REDS[side] : near.has(part) && colliding.size === 0 ? AMBER : null;
        const paint = lit ? mixed(this.paint[part], lit, side !== undefined ? 0.78 : 0.62) : this.paint[part];
        const common = { eyeFromPart: eyeFromPart[part], clipFromEye, low: data.low, lattice: data.step, pull: 0 };
        gl.depthMask(!ghosts);
        gl.useProgram(gpu.part.program);
        gl.enable(gl.POLYGON_OFFSET_FILL);
        gl.polygonOffset(1, 1);
        gpu.set(gpu.part, { ...common, colour: paint, skyward, opacity: ghosts ? 0.22 : 1, glow: lit ? 0.25 : 0 });
        gpu.draw(this.solids[part]);
        gl.disable(gl.POLYGON_OFFSET_FILL);
        gl.useProgram(gpu.plain.program);
        gpu.set(gpu.plain, { ...common, colour: times(paint, showing.dark ? 0.3 : 0.38), opacity: ghosts ? 0.3 : 0.85 });
        gpu.draw(this.creases[part]);
      }
    }
    gl.depthMask(true);
  }

  /** @param {Showing} showing @param {Mat4} eye @param {Mat4} clipFromEye */
  #drawFloor(showing, eye, clipFromEye) {
    const [gpu, gl] = [this.gpu, this.gpu.gl];
    const worldFromFloor = multiply(translation(/** @type {Vec3} */ (this.floor)), this.camera.upright);
    const reach = 1.6 * this.camera.size;
    gl.depthMask(false);
    gl.useProgram(gpu.floor.program);
    gpu.set(gpu.floor, {
      eyeFromPart: multiply(eye, worldFromFloor),
      clipFromEye,
      reach,
      cell: 10 ** Math.floor(Math.log10(reach / 12)),
      colour: showing.dark ? [0.62, 0.7, 0.8] : [0.25, 0.32, 0.4],
    });
    gpu.draw(gpu.plane);
    gl.depthMask(true);
  }

  /** The way of the tool over the work, faint where parts hide it. @param {Mat4[]} poses @param {Mat4} eye @param {Mat4} clipFromEye */
  #drawPath(poses, eye, clipFromEye) {
    const [gpu, gl] = [this.gpu, this.gpu.gl];
    const work = this.data.path?.work ?? null;
    this.path ??= toolPath(this.data, this.motion);
    gl.useProgram(gpu.plain.program);
    gpu.set(gpu.plain, { eyeFromPart: work === null ? eye : multiply(eye, poses[work]), clipFromEye, low: [0, 0, 0], lattice: [1, 1, 1] });
    gl.depthMask(false);
    for (const [kind, points] of Object.entries(this.path)) {
      if (points.length === 0) continue;
      const drawable = this.#made(`path ${kind}`, () => gpu.drawable(gl.LINES, points, 3));
      for (const [test, opacity] of /** @type {[number, number][]} */ ([[gl.GREATER, 0.18], [gl.LEQUAL, 0.9]])) {
        gl.depthFunc(test);
        gpu.set(gpu.plain, { colour: kind === "rapid" ? PATH_PAINT.rapid : PATH_PAINT.feed, opacity, pull: test === gl.LEQUAL ? 1e-5 : 0 });
        gpu.draw(drawable);
      }
    }
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(true);
  }

  /** The triangles that touch. @param {Showing} showing @param {Mat4[]} eyeFromPart @param {Mat4} clipFromEye */
  #drawContacts(showing, eyeFromPart, clipFromEye) {
    const [gpu, gl] = [this.gpu, this.gpu.gl];
    gl.useProgram(gpu.plain.program);
    for (const event of showing.colliding) {
      const contact = contactAt(event, showing.place);
      if (!contact) continue;
      event.pair.forEach((part, side) => {
        const data = this.data.parts[part];
        const key = `contact ${this.data.events.indexOf(event)} ${event.contacts.indexOf(contact)} ${side}`;
        const drawable = this.#made(key, () => {
          const corners = cornersOf(this.surfaces[part], u32(side === 0 ? contact.a : contact.b));
          return gpu.drawable(gl.TRIANGLES, corners, 4);
        });
        const colour = side === 0 ? [1, 0.86, 0.1] : [1, 0.98, 0.75];
        gpu.set(gpu.plain, { eyeFromPart: eyeFromPart[part], clipFromEye, low: data.low, lattice: data.step, colour });
        for (const [test, opacity] of /** @type {[number, number][]} */ ([[gl.GREATER, 0.35], [gl.LEQUAL, 0.95]])) {
          gl.depthFunc(test);
          gpu.set(gpu.plain, { opacity, pull: test === gl.LEQUAL ? 2e-5 : 0 });
          gpu.draw(drawable);
        }
        gl.depthFunc(gl.LEQUAL);
      });
    }
  }

  /** @param {Showing} showing @param {number} variant @param {Mat4[]} eyeFromPart @param {Mat4} clipFromEye */
  #drawTrees(showing, variant, eyeFromPart, clipFromEye) {
    const [gpu, gl] = [this.gpu, this.gpu.gl];
    const trees = this.trees[variant] ?? [];
    const parts = trees.map((_, part) => part).filter((part) => this.isShown(part, showing) && hasTree(part, showing));
    gl.useProgram(gpu.plain.program);
    gl.depthMask(false);
    for (const part of parts) {
      const { low, step } = trees[part].tree;
      for (const leaking of [false, true]) {
        const common = { eyeFromPart: eyeFromPart[part], clipFromEye, low, lattice: step, colour: TREE_PAINT[leaking ? 2 : variant] };
        const key = (/** @type {string} */ what) => `${what} ${variant} ${part} ${showing.level} ${leaking}`;
        const faces = this.#made(key("faces"), () => gpu.drawable(gl.TRIANGLES, trees[part].faces(showing.level, leaking), 3));
        const edges = this.#made(key("edges"), () => gpu.drawable(gl.LINES, trees[part].edges(showing.level, leaking), 3));
        gpu.set(gpu.plain, { ...common, opacity: 0.07, pull: 0 });
        gpu.draw(faces);
        gpu.set(gpu.plain, { ...common, opacity: 0.9, pull: 1e-5 });
        gpu.draw(edges);
      }
    }
    gl.depthMask(true);
  }

  /** @param {string} key @param {() => Drawable} make */
  #made(key, make) {
    const known = this.made.get(key);
    if (known) return known;
    const drawable = make();
    this.made.set(key, drawable);
    return drawable;
  }
}

/** Whether a part's tree is drawn. @param {number} part @param {Showing} showing */
function hasTree(part, { volumes, pair }) {
  return volumes === "pair" ? pair.includes(part) : volumes === "all" || volumes === part;
}

/** @param {PartData} part @param {number} index @returns {Vec3} */
function paintOf(part, index) {
  if (part.role !== "machine") return PAINT[part.role] ?? PAINT.examined;
  if (part.examined) return PAINT.examined;
  const grey = 0.06 * (index % 3);
  return [0.74 - grey, 0.77 - grey, 0.8 - grey];
}

/** @param {Vec3} from @param {Vec3} to @param {number} part @returns {Vec3} */
function mixed(from, to, part) {
  return plus(times(from, 1 - part), times(to, part));
}

/** @param {PartData} part @returns {Vec3[]} */
function boxCorners({ low, step }) {
  const at = (/** @type {number} */ axis, /** @type {number} */ side) => low[axis] + (side ? 65535 * step[axis] : 0);
  return [0, 1, 2, 3, 4, 5, 6, 7].map((n) => [at(0, n & 1), at(1, n & 2), at(2, n & 4)]);
}

/** The corners of some faces, four numbers each. @param {Surface} surface @param {Uint32Array} faces */
function cornersOf({ faces: all, places }, faces) {
  const corners = new Uint16Array(faces.length * 12);
  faces.forEach((face, i) => {
    for (let corner = 0; corner < 3; corner++) {
      const vertex = all[3 * face + corner];
      for (let axis = 0; axis < 3; axis++) corners[12 * i + 4 * corner + axis] = places[3 * vertex + axis];
    }
  });
  return corners;
}

/** The triangles of a collision at the pose nearest to a place. @param {ViewEvent} event @param {number} place */
function contactAt(event, place) {
  /** @type {Contact | undefined} */
  let nearest;
  for (const contact of event.contacts) {
    if (!nearest || Math.abs(contact.key - place) < Math.abs(nearest.key - place)) nearest = contact;
  }
  return nearest;
}

/** A tree's volumes as lines and triangles, on the tree's lattice. */
class TreeShapes {
  /** @param {Tree} tree */
  constructor(tree) {
    this.tree = tree;
    this.levels = bytes(tree.level_of);
    this.flags = bytes(tree.flags);
  }

  /** @param {number} level @param {boolean} leaking whether volumes that do not hold their contents are wanted, or the others */
  edges(level, leaking) {
    return this.#take(level, leaking, 2);
  }

  /** @param {number} level @param {boolean} leaking */
  faces(level, leaking) {
    return this.#take(level, leaking, 3);
  }

  /** Points of the nodes that stand for the mesh on a level, in groups of `size`. @param {number} level @param {boolean} leaking @param {2 | 3} size */
  #take(level, leaking, size) {
    const deepest = Math.min(level, this.tree.levels.length - 1);
    /** @type {number[]} */
    const found = [];
    this.#each((node, point, edges, faces) => {
      const there = this.levels[node] === deepest || (this.flags[node] & 1 && this.levels[node] < deepest);
      if (!there || Boolean(this.flags[node] & 2) !== leaking) return;
      for (const number of size === 2 ? edges : faces) found.push(...point(number));
    });
    return Float32Array.from(found);
  }

  /** @param {(node: number, point: (number: number) => number[], edges: Uint16Array, faces: Uint16Array) => void} visit */
  #each(visit) {
    const shapes = this.tree.shapes;
    const [edges, faces] = [u16(shapes.edges), u16(shapes.faces)];
    if (shapes.kind === "images") {
      const [weights, frames] = [f32(shapes.weights), u16(shapes.frames)];
      for (let node = 0; node < this.levels.length; node++) {
        const f = frames.subarray(12 * node, 12 * node + 12);
        const point = (/** @type {number} */ n) =>
          [0, 1, 2].map((axis) => {
            const along = (/** @type {number} */ i) => weights[3 * n + i] * (f[3 * i + 3 + axis] - f[axis]);
            return f[axis] + along(0) + along(1) + along(2);
          });
        visit(node, point, edges, faces);
      }
      return;
    }
    const [counts, points] = [u16(shapes.counts), u16(shapes.points)];
    let [p, e, f] = [0, 0, 0];
    for (let node = 0; node < this.levels.length; node++) {
      const [pointCount, edgeCount, faceCount] = counts.subarray(3 * node, 3 * node + 3);
      const first = p;
      visit(
        node,
        (n) => [...points.subarray(first + 3 * n, first + 3 * n + 3)],
        edges.subarray(e, e + 2 * edgeCount),
        faces.subarray(f, f + 3 * faceCount),
      );
      p += 3 * pointCount;
      e += 2 * edgeCount;
      f += 3 * faceCount;
    }
  }
}
