// Just enough of a GLB reader to ask where a part is at a key of the animation: a second opinion on the page's kinematics.

import { readFileSync } from "node:fs";

export class Glb {
  constructor(file) {
    const bytes = readFileSync(file);
    const length = bytes.readUInt32LE(12);
    this.json = JSON.parse(bytes.subarray(20, 20 + length).toString());
    this.binary = bytes.subarray(28 + length);
    const [animation] = this.json.animations ?? [];
    this.channels = (animation?.channels ?? []).map(({ sampler, target }) => ({ ...target, output: this.#floats(animation.samplers[sampler].output) }));
    this.times = animation ? this.#floats(animation.samplers[0].input).map(([time]) => time) : [];
  }

  #floats(number) {
    const { bufferView, count, type } = this.json.accessors[number];
    const width = { SCALAR: 1, VEC3: 3, VEC4: 4 }[type];
    const from = this.json.bufferViews[bufferView].byteOffset;
    return Array.from({ length: count }, (_, i) => Array.from({ length: width }, (_, k) => this.binary.readFloatLE(from + 4 * (i * width + k))));
  }

  /** Where a point of a part (mm, part frame) is at a key: metres, y up. */
  place(part, key, point) {
    const { nodes } = this.json;
    let number = nodes.findIndex((node) => node.name === part && node.mesh !== undefined);
    while (number >= 0) {
      const animated = Object.fromEntries(this.channels.filter((channel) => channel.node === number).map(({ path, output }) => [path, output[key]]));
      const { translation = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1] } = { ...nodes[number], ...animated };
      point = rotated(rotation, point.map((x, i) => x * scale[i])).map((x, i) => x + translation[i]);
      number = nodes.findIndex((node) => node.children?.includes(number));
    }
    return point;
  }
}

/** A vector turned by a unit quaternion i, j, k, w. */
function rotated([i, j, k, w], [x, y, z]) {
  const [a, b, c] = [2 * (j * z - k * y), 2 * (k * x - i * z), 2 * (i * y - j * x)];
  return [x + w * a + j * c - k * b, y + w * b + k * a - i * c, z + w * c + i * b - j * a];
}
