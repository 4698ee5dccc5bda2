// @ts-check
// The eye: it circles a target, with mouse, fingers or keys.

const FIELD_OF_VIEW = 0.5;

class Camera {
  /** @param {"y" | "z"} up */
  constructor(up) {
    /** World from a frame in which z is up. @type {Mat4} */
    this.upright = up === "y" ? [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1] : identity();
    /** @type {Vec3} */
    this.up = up === "y" ? [0, 1, 0] : [0, 0, 1];
    /** @type {Vec3} */
    this.target = [0, 0, 0];
    this.distance = 1000;
    this.azimuth = 0.61;
    this.elevation = 0.46;
    /** The size of what there is to see, mm. */
    this.size = 1000;
  }

  /** Makes a ball fill the picture. @param {Vec3} middle @param {number} radius @param {number} aspect width over height */
  frame(middle, radius, aspect) {
    this.target = middle;
    this.distance = (radius * 1.08) / Math.sin(FIELD_OF_VIEW / 2) / Math.min(1, aspect);
  }

  /** Where the eye is. @returns {Vec3} */
  eye() {
    const [c, s] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const from = applyToDirection(this.upright, [c * Math.sin(this.azimuth), -c * Math.cos(this.azimuth), s]);
    return plus(this.target, times(from, this.distance));
  }

  eyeFromWorld() {
    return lookAt(this.eye(), this.target, this.up);
  }

  /** @param {number} aspect */
  clipFromEye(aspect) {
    const near = Math.max(this.distance - 2.5 * this.size, this.distance * 0.02);
    return perspective(FIELD_OF_VIEW, aspect, near, this.distance + 4 * this.size);
  }

  /** @param {number} right radians @param {number} up radians */
  orbit(right, up) {
    this.azimuth -= right;
    this.elevation = clamp(this.elevation + up, -1.5, 1.5);
  }

  /** Moves with what is under the pointer. @param {number} right pixels @param {number} down pixels @param {number} height of the picture, pixels */
  pan(right, down, height) {
    const scale = (2 * this.distance * Math.tan(FIELD_OF_VIEW / 2)) / height;
    const m = this.eyeFromWorld();
    const shift = plus(times([m[0], m[4], m[8]], -right * scale), times([m[1], m[5], m[9]], down * scale));
    this.target = plus(this.target, shift);
  }

  /** @param {number} factor below 1 is nearer */
  zoom(factor) {
    this.distance = clamp(this.distance * factor, this.size * 0.005, this.size * 8);
  }
}

/**
 * Lets pointers move a camera: one turns it (with shift or another button it pans), two pan and pinch; the wheel zooms.
 * @param {HTMLElement} element @param {Camera} camera @param {() => void} changed
 */
function handle(element, camera, changed) {
  /** @type {Map<number, [number, number]>} */
  const down = new Map();
  const spread = () => {
    const [p, q] = [...down.values()];
    return { x: (p[0] + q[0]) / 2, y: (p[1] + q[1]) / 2, size: Math.hypot(p[0] - q[0], p[1] - q[1]) };
  };
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    down.set(event.pointerId, [event.clientX, event.clientY]);
  });
  element.addEventListener("pointermove", (event) => {
    const last = down.get(event.pointerId);
    if (!last) return;
    if (down.size === 1) {
      const [right, below] = [event.clientX - last[0], event.clientY - last[1]];
      if (event.shiftKey || event.buttons & 6) camera.pan(right, below, element.clientHeight);
      else camera.orbit(right * 0.008, below * 0.008);
      down.set(event.pointerId, [event.clientX, event.clientY]);
    } else if (down.size === 2) {
      const before = spread();
      down.set(event.pointerId, [event.clientX, event.clientY]);
      const after = spread();
      camera.pan(after.x - before.x, after.y - before.y, element.clientHeight);
      if (after.size > 0) camera.zoom(before.size / after.size);
    }
    changed();
  });
  for (const ended of /** @type {const} */ (["pointerup", "pointercancel"])) {
    element.addEventListener(ended, (event) => down.delete(event.pointerId));
  }
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      camera.zoom(Math.exp(clamp(event.deltaY, -200, 200) * (event.deltaMode ? 0.05 : 0.0015)));
      changed();
    },
    { passive: false },
  );
}
