// @ts-check
// Matrices of four columns, one after another, as WebGL wants them; vectors and points of three numbers.

/** @typedef {number[]} Mat4 */
/** @typedef {[number, number, number]} Vec3 */

/** @returns {Mat4} */
function identity() {
  return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
}

/** The product `a b`. @param {Mat4} a @param {Mat4} b @returns {Mat4} */
function multiply(a, b) {
  const c = new Array(16);
  for (let column = 0; column < 16; column += 4) {
    for (let row = 0; row < 4; row++) {
      c[column + row] =
        a[row] * b[column] + a[row + 4] * b[column + 1] + a[row + 8] * b[column + 2] + a[row + 12] * b[column + 3];
    }
  }
  return c;
}

/** @param {Vec3} v @returns {Mat4} */
function translation(v) {
  return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, v[0], v[1], v[2], 1];
}

/** A rotation by a unit quaternion i, j, k, w, then a shift. @param {number[]} seven x, y, z, i, j, k, w @returns {Mat4} */
function rigid([x, y, z, i, j, k, w]) {
  return [
    1 - 2 * (j * j + k * k), 2 * (i * j + k * w), 2 * (i * k - j * w), 0,
    2 * (i * j - k * w), 1 - 2 * (i * i + k * k), 2 * (j * k + i * w), 0,
    2 * (i * k + j * w), 2 * (j * k - i * w), 1 - 2 * (i * i + j * j), 0,
    x, y, z, 1,
  ];
}

/** A turn about the line through a point, radians. @param {Vec3} direction unit @param {Vec3} point @param {number} angle */
function turn(direction, point, angle) {
  const [s, c] = [Math.sin(angle / 2), Math.cos(angle / 2)];
  const rotation = rigid([0, 0, 0, s * direction[0], s * direction[1], s * direction[2], c]);
  const moved = apply(rotation, point);
  rotation[12] = point[0] - moved[0];
  rotation[13] = point[1] - moved[1];
  rotation[14] = point[2] - moved[2];
  return rotation;
}

/** The image of a point. @param {Mat4} m @param {ArrayLike<number>} p @returns {Vec3} */
function apply(m, p) {
  return [
    m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12],
    m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13],
    m[2] * p[0] + m[6] * p[1] + m[10] * p[2] + m[14],
  ];
}

/** The image of a direction. @param {Mat4} m @param {Vec3} v @returns {Vec3} */
function applyToDirection(m, v) {
  return minus(apply(m, v), [m[12], m[13], m[14]]);
}

/** The inverse of a rotation with a shift. @param {Mat4} m @returns {Mat4} */
function inverse(m) {
  /** @type {Mat4} */
  const back = [m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, 0, 0, 0, 1];
  [back[12], back[13], back[14]] = times(apply(back, [m[12], m[13], m[14]]), -1);
  return back;
}

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
function plus(a, b) {
  return [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
}

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
function minus(a, b) {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** @param {Vec3} v @param {number} s @returns {Vec3} */
function times(v, s) {
  return [v[0] * s, v[1] * s, v[2] * s];
}

/** @param {Vec3} a @param {Vec3} b */
function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** The direction of a vector; of none, itself. @param {Vec3} v @returns {Vec3} */
function direction(v) {
  const length = Math.hypot(v[0], v[1], v[2]);
  return length > 0 ? times(v, 1 / length) : v;
}

/** Seen from `eye` toward `target`. @param {Vec3} eye @param {Vec3} target @param {Vec3} up @returns {Mat4} */
function lookAt(eye, target, up) {
  const back = direction(minus(eye, target));
  const right = direction(cross(up, back));
  const above = cross(back, right);
  return [
    right[0], above[0], back[0], 0, right[1], above[1], back[1], 0, right[2], above[2], back[2], 0,
    -dot(right, eye), -dot(above, eye), -dot(back, eye), 1,
  ];
}

/** @param {number} angle height of the field of view, radians @param {number} aspect @param {number} near @param {number} far @returns {Mat4} */
function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
}

/** Number of values in a sorted list that are at most `value`. @param {ArrayLike<number>} sorted @param {number} value */
function countUpTo(sorted, value) {
  let [low, high] = [0, sorted.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** @param {number} value @param {number} low @param {number} high */
function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}
