// @ts-check
// Where the machine is: keys, the moves and lines they belong to, and the links' poses.

/** @typedef {{ line: number, first: number, last: number, move: number }} Run The keys of one way through a line. */

class Motion {
  /** @param {ViewData} data */
  constructor(data) {
    this.links = data.links;
    const program = data.program;
    /** @type {number[]} */
    this.axes = program ? program.axes : [];
    this.keys = program ? program.keys : 1;
    this.values = program ? f32(program.values) : new Float32Array();
    /** When each key is reached, s. */
    this.times = new Float64Array(this.keys);
    if (program) f32(program.durations).forEach((s, key) => (this.times[key] = s + (key > 0 ? this.times[key - 1] : 0)));
    this.duration = this.times[this.keys - 1];
    this.firstTool = program ? program.first_tool : 0;
    const moves = program?.moves;
    this.lines = moves ? u32(moves.line) : new Uint32Array();
    this.kinds = moves ? bytes(moves.kind) : new Uint8Array();
    this.feeds = moves ? f32(moves.feed) : new Float32Array();
    this.rpms = moves ? f32(moves.rpm) : new Float32Array();
    this.tools = moves ? u32(moves.tool) : new Uint32Array();
    this.lastKeys = moves ? u32(moves.last_key) : new Uint32Array();
    this.runs = this.#runs();
    this.runEnds = this.runs.map((run) => run.last);
  }

  /** @returns {Run[]} */
  #runs() {
    /** @type {Run[]} */
    const runs = [];
    let key = 0;
    this.lines.forEach((line, move) => {
      const last = this.lastKeys[move];
      if (last === key) return;
      const open = runs[runs.length - 1];
      if (open && open.line === line) [open.last, open.move] = [last, move];
      else runs.push({ line, first: key, last, move });
      key = last;
    });
    return runs;
  }

  /** The move that leads to a place; -1 where the machine stands at first. @param {number} place */
  moveAt(place) {
    return place <= 0 ? -1 : Math.min(countUpTo(this.lastKeys, Math.ceil(place) - 1), this.lines.length - 1);
  }

  /** The way through a line that leads to a place. @param {number} place @returns {Run | undefined} */
  runAt(place) {
    return place <= 0 ? undefined : this.runs[Math.min(countUpTo(this.runEnds, Math.ceil(place) - 1), this.runs.length - 1)];
  }

  /** @param {number} place */
  lineAt(place) {
    return this.runAt(place)?.line ?? 0;
  }

  /** The tool in the spindle. @param {number} place */
  toolAt(place) {
    const move = this.moveAt(place);
    return move < 0 ? this.firstTool : this.tools[move];
  }

  /** @param {number} place */
  timeAt(place) {
    const key = Math.floor(place);
    const next = Math.min(key + 1, this.keys - 1);
    return this.times[key] + (place - key) * (this.times[next] - this.times[key]);
  }

  /** The last place of a time. @param {number} time */
  placeAt(time) {
    const next = countUpTo(this.times, time);
    if (next >= this.keys) return this.keys - 1;
    if (next === 0) return 0;
    return next - 1 + (time - this.times[next - 1]) / (this.times[next] - this.times[next - 1]);
  }

  /** All nine axes, mm and radians. @param {number} place */
  positionAt(place) {
    const position = new Array(9).fill(0);
    const key = Math.min(Math.floor(place), this.keys - 1);
    const next = Math.min(key + 1, this.keys - 1);
    this.axes.forEach((axis, i) => {
      const from = this.values[key * this.axes.length + i];
      position[axis] = from + (place - key) * (this.values[next * this.axes.length + i] - from);
    });
    return position;
  }

  /** World from each link. @param {number[]} position @returns {Mat4[]} */
  posesAt(position) {
    /** @type {Mat4[]} */
    const poses = new Array(this.links.length);
    /** @param {number} index @returns {Mat4} */
    const pose = (index) => {
      if (poses[index]) return poses[index];
      const link = this.links[index];
      let found = rigid(link.at);
      if (link.parent !== null) found = multiply(pose(link.parent), found);
      if (link.joint) found = multiply(found, displacement(link.joint, position));
      return (poses[index] = found);
    };
    this.links.forEach((_, index) => pose(index));
    return poses;
  }
}

/** Where a joint has taken its link. @param {Joint} joint @param {number[]} position */
function displacement(joint, position) {
  const value = position[joint.axis] * joint.gain;
  return joint.turns ? turn(joint.direction, joint.point, value) : translation(times(joint.direction, value));
}
