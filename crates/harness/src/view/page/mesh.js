// @ts-check
// From triangles to what is drawn: normals that are smooth but for creases, and the edges at creases and borders.

/** Cosine of the angle between faces from which they meet in an edge: 30 degrees. */
const CREASE = 0.866;
/** Faces around a vertex beyond which its faces are left flat: the middle of a fan. */
const FAN = 200;

/**
 * A part's surface. `corners` are the places of the triangles' corners on the part's lattice, four numbers each; `normals` four
 * signed bytes each; `edges` the places of the edges' ends, four numbers each.
 * @typedef {{ corners: Uint16Array, normals: Int8Array, edges: Uint16Array, faces: Uint16Array | Uint32Array, places: Uint16Array }} Surface
 */

/** @param {PartData} part @returns {Surface} */
function surfaceOf(part) {
  const places = u16(part.vertices);
  const faces = part.wide ? u32(part.faces) : u16(part.faces);
  const flat = faceNormals(places, faces, part.step);
  const around = facesAround(faces, places.length / 3);
  const corners = new Uint16Array((faces.length / 3) * 12);
  const normals = new Int8Array(corners.length);
  for (let at = 0; at < faces.length; at++) {
    const vertex = faces[at];
    for (let axis = 0; axis < 3; axis++) corners[4 * at + axis] = places[3 * vertex + axis];
    const normal = smoothNormal(flat, around, vertex, Math.floor(at / 3));
    for (let axis = 0; axis < 3; axis++) normals[4 * at + axis] = Math.round(127 * normal[axis]);
  }
  return { corners, normals, edges: creases(places, faces, flat, around), faces, places };
}

/** Normals of the faces, as long as twice their areas, and after them their lengths. @param {Uint16Array} places @param {ArrayLike<number>} faces @param {Vec3} step */
function faceNormals(places, faces, step) {
  const count = faces.length / 3;
  const normals = new Float32Array(4 * count);
  for (let face = 0; face < count; face++) {
    /** @param {number} corner @returns {Vec3} */
    const at = (corner) => {
      const vertex = 3 * faces[3 * face + corner];
      return [places[vertex] * step[0], places[vertex + 1] * step[1], places[vertex + 2] * step[2]];
    };
    const p = at(0);
    const normal = cross(minus(at(1), p), minus(at(2), p));
    normals.set(normal, 4 * face);
    normals[4 * face + 3] = Math.hypot(normal[0], normal[1], normal[2]);
  }
  return normals;
}

/** For each vertex the faces around it: from `starts[v]` to `starts[v + 1]` in `list`. @param {ArrayLike<number>} faces @param {number} vertices */
function facesAround(faces, vertices) {
  const starts = new Uint32Array(vertices + 1);
  for (let at = 0; at < faces.length; at++) starts[faces[at] + 1]++;
  for (let vertex = 0; vertex < vertices; vertex++) starts[vertex + 1] += starts[vertex];
  const next = starts.slice();
  const list = new Uint32Array(faces.length);
  for (let at = 0; at < faces.length; at++) list[next[faces[at]]++] = Math.floor(at / 3);
  return { starts, list };
}

/** @param {Float32Array} flat @param {number} f @param {number} g */
function cosine(flat, f, g) {
  const product = flat[4 * f] * flat[4 * g] + flat[4 * f + 1] * flat[4 * g + 1] + flat[4 * f + 2] * flat[4 * g + 2];
  const lengths = flat[4 * f + 3] * flat[4 * g + 3];
  // A face without area bends nothing.
  return lengths > 0 ? product / lengths : 1;
}

/** @param {Float32Array} flat @param {{ starts: Uint32Array, list: Uint32Array }} around @param {number} vertex @param {number} face @returns {Vec3} */
function smoothNormal(flat, around, vertex, face) {
  const [first, last] = [around.starts[vertex], around.starts[vertex + 1]];
  let [x, y, z] = [flat[4 * face], flat[4 * face + 1], flat[4 * face + 2]];
  if (last - first <= FAN) {
    [x, y, z] = [0, 0, 0];
    for (let at = first; at < last; at++) {
      const other = around.list[at];
      if (other !== face && cosine(flat, face, other) < CREASE) continue;
      x += flat[4 * other];
      y += flat[4 * other + 1];
      z += flat[4 * other + 2];
    }
  }
  return direction([x, y, z]);
}

/** Ends of the edges that are drawn. @param {Uint16Array} places @param {ArrayLike<number>} faces @param {Float32Array} flat @param {{ starts: Uint32Array, list: Uint32Array }} around */
function creases(places, faces, flat, around) {
  /** @type {number[]} */
  const found = [];
  for (let at = 0; at < faces.length; at++) {
    const face = Math.floor(at / 3);
    const [from, to] = [faces[at], faces[at % 3 === 2 ? at - 2 : at + 1]];
    const size = (/** @type {number} */ v) => around.starts[v + 1] - around.starts[v];
    const [pivot, end] = size(from) <= size(to) ? [from, to] : [to, from];
    let neighbour = -1;
    for (let i = around.starts[pivot]; i < around.starts[pivot + 1]; i++) {
      const other = around.list[i];
      const has = faces[3 * other] === end || faces[3 * other + 1] === end || faces[3 * other + 2] === end;
      if (other !== face && has) neighbour = other;
    }
    // An edge between two faces is drawn by the first of them.
    if (neighbour < 0 || (neighbour > face && cosine(flat, face, neighbour) < CREASE)) {
      for (const vertex of [from, to]) found.push(places[3 * vertex], places[3 * vertex + 1], places[3 * vertex + 2], 0);
    }
  }
  return Uint16Array.from(found);
}

/**
 * Whether a segment meets a surface before its last hundredth (Moeller and Trumbore 1997).
 * @param {Surface} surface @param {PartData} part @param {Vec3} from @param {Vec3} to part frame
 * @param {number} most triangles that are looked at, evenly chosen
 */
function meets({ faces, places }, { low, step }, from, to, most) {
  const along = minus(to, from);
  if (!crossesBox(low, plus(low, times(step, 65535)), from, along)) return false;
  const at = (/** @type {number} */ corner) => {
    const vertex = 3 * faces[corner];
    return /** @type {Vec3} */ ([0, 1, 2].map((axis) => low[axis] + step[axis] * places[vertex + axis]));
  };
  const stride = 3 * Math.max(1, Math.ceil(faces.length / 3 / most));
  for (let corner = 0; corner < faces.length; corner += stride) {
    const p = at(corner);
    const [u, v] = [minus(at(corner + 1), p), minus(at(corner + 2), p)];
    const normal = cross(along, v);
    const volume = dot(u, normal);
    if (volume === 0) continue;
    const toEye = minus(from, p);
    const a = dot(toEye, normal) / volume;
    const side = cross(toEye, u);
    const b = dot(along, side) / volume;
    const t = dot(v, side) / volume;
    if (a >= 0 && b >= 0 && a + b <= 1 && t > 0 && t < 0.99) return true;
  }
  return false;
}

/** Whether a segment meets a box (Kay and Kajiya 1986). @param {Vec3} low @param {Vec3} high @param {Vec3} from @param {Vec3} along */
function crossesBox(low, high, from, along) {
  let [enters, leaves] = [0, 1];
  for (let axis = 0; axis < 3; axis++) {
    if (along[axis] === 0) {
      if (from[axis] < low[axis] || from[axis] > high[axis]) return false;
      continue;
    }
    const [a, b] = [(low[axis] - from[axis]) / along[axis], (high[axis] - from[axis]) / along[axis]];
    enters = Math.max(enters, Math.min(a, b));
    leaves = Math.min(leaves, Math.max(a, b));
  }
  return enters <= leaves;
}
