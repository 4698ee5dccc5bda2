// @ts-check
// WebGL 2: the programs, and what they draw from.

const PART_VERTEX = `#version 300 es
in vec3 place; in vec3 normal;
uniform mat4 eyeFromPart, clipFromEye; uniform vec3 low, lattice; uniform float pull;
out vec3 n; out vec3 at;
void main() {
  vec4 eye = eyeFromPart * vec4(low + lattice * place, 1.0);
  n = mat3(eyeFromPart) * normal; at = eye.xyz;
  gl_Position = clipFromEye * eye; gl_Position.z -= pull * gl_Position.w;
}`;

// A key light over the left shoulder, a fill light from the right, the sky above and the floor below, and a sheen.
const PART_FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; in vec3 at; out vec4 pixel;
uniform vec3 colour, skyward; uniform float opacity, glow;
void main() {
  vec3 normal = normalize(n), toEye = normalize(-at);
  if (dot(normal, toEye) < 0.0) normal = -normal;
  const vec3 key = normalize(vec3(-0.42, 0.72, 0.55)), fill = normalize(vec3(0.8, 0.1, 0.5));
  float sky = 0.5 + 0.5 * dot(normal, skyward);
  float light = mix(0.42, 0.60, sky) + 0.42 * max(dot(normal, key), 0.0) + 0.20 * max(dot(normal, fill), 0.0);
  float sheen = pow(max(dot(normal, normalize(key + toEye)), 0.0), 40.0) * 0.16;
  float rim = pow(1.0 - max(dot(normal, toEye), 0.0), 3.0) * 0.10;
  vec3 lit = mix(colour * light + sheen + rim * skyward.y, colour, glow);
  pixel = vec4(lit * opacity, opacity);
}`;

const PLAIN_VERTEX = `#version 300 es
in vec3 place;
uniform mat4 eyeFromPart, clipFromEye; uniform vec3 low, lattice; uniform float pull;
void main() {
  gl_Position = clipFromEye * (eyeFromPart * vec4(low + lattice * place, 1.0));
  gl_Position.z -= pull * gl_Position.w;
}`;

const PLAIN_FRAGMENT = `#version 300 es
precision highp float;
out vec4 pixel; uniform vec3 colour; uniform float opacity;
void main() { pixel = vec4(colour * opacity, opacity); }`;

const FLOOR_VERTEX = `#version 300 es
in vec3 place;
uniform mat4 eyeFromPart, clipFromEye; uniform float reach;
out vec2 at;
void main() { at = place.xy * reach; gl_Position = clipFromEye * (eyeFromPart * vec4(at, 0.0, 1.0)); }`;

// Lines every \`cell\` mm, stronger every ten, that fade with the distance from the middle.
const FLOOR_FRAGMENT = `#version 300 es
precision highp float;
in vec2 at; out vec4 pixel; uniform vec3 colour; uniform float reach, cell;
float lines(float size) {
  vec2 part = abs(fract(at / size - 0.5) - 0.5) / fwidth(at / size);
  return 1.0 - min(min(part.x, part.y), 1.0);
}
void main() {
  float fade = 1.0 - smoothstep(0.25 * reach, reach, length(at));
  float opacity = max(0.16 * lines(cell), 0.4 * lines(10.0 * cell)) * fade + 0.05 * fade;
  pixel = vec4(colour * opacity, opacity);
}`;

/**
 * @typedef {{ program: WebGLProgram, at: Record<string, WebGLUniformLocation | null> }} Program3d
 * @typedef {{ array: WebGLVertexArrayObject, count: number, mode: number }} Drawable
 */

/** The GPU. */
class Gpu {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { alpha: true, antialias: true, premultipliedAlpha: true });
    if (!gl) throw new Error("This browser offers no WebGL 2, which the machine is drawn with.");
    this.gl = gl;
    this.part = this.program(PART_VERTEX, PART_FRAGMENT);
    this.plain = this.program(PLAIN_VERTEX, PLAIN_FRAGMENT);
    this.floor = this.program(FLOOR_VERTEX, FLOOR_FRAGMENT);
    this.plane = this.drawable(gl.TRIANGLES, new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0]), 3);
  }

  /** @param {string} vertex @param {string} fragment @returns {Program3d} */
  program(vertex, fragment) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
      const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "place");
    gl.bindAttribLocation(program, 1, "normal");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(String(gl.getProgramInfoLog(program)));
    /** @type {Record<string, WebGLUniformLocation | null>} */
    const at = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const name = gl.getActiveUniform(program, i)?.name ?? "";
      at[name] = gl.getUniformLocation(program, name);
    }
    return { program, at };
  }

  /**
   * Vertices on the GPU: `places` in groups of `stride` numbers of which three count, `normals` in groups of four.
   * @param {number} mode @param {Uint16Array | Float32Array} places @param {number} stride @param {Int8Array} [normals]
   * @returns {Drawable}
   */
  drawable(mode, places, stride, normals) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, places, gl.STATIC_DRAW);
    const type = places instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.FLOAT;
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, type, false, stride * places.BYTES_PER_ELEMENT, 0);
    if (normals) {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, normals, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 3, gl.BYTE, true, 4, 0);
    }
    gl.bindVertexArray(null);
    return { array, count: places.length / stride, mode };
  }

  /** @param {Drawable} drawable */
  draw(drawable) {
    this.gl.bindVertexArray(drawable.array);
    this.gl.drawArrays(drawable.mode, 0, drawable.count);
  }

  /**
   * Sets uniforms: numbers, three numbers or sixteen.
   * @param {Program3d} program @param {Record<string, number | number[]>} values
   */
  set(program, values) {
    const gl = this.gl;
    for (const [name, value] of Object.entries(values)) {
      const at = program.at[name] ?? null;
      if (typeof value === "number") gl.uniform1f(at, value);
      else if (value.length === 3) gl.uniform3fv(at, value);
      else gl.uniformMatrix4fv(at, false, value);
    }
  }
}
