// @ts-check
// The way of the tool's tip over the workpiece: feed moves and rapids as lines in the frame of the link that carries the work.

/** Most keys that the path is drawn from; of longer programs every second, third, ... one. */
const MOST_PATH_KEYS = 200_000;
/** What it is painted with. @type {{ feed: Vec3, rapid: Vec3 }} */
const PATH_PAINT = { feed: [0.0, 0.48, 0.7], rapid: [0.85, 0.6, 0.1] };

/** Two points for each stretch between keys, six numbers. @param {ViewData} data @param {Motion} motion @returns {{ feed: Float32Array, rapid: Float32Array }} */
function toolPath(data, motion) {
  /** @type {{ feed: number[], rapid: number[] }} */
  const found = { feed: [], rapid: [] };
  const stride = Math.ceil(motion.keys / MOST_PATH_KEYS);
  /** @type {{ tip: Tip, at: Vec3 } | null} */
  let last = null;
  for (let key = 0; key < motion.keys; key += stride) {
    const tool = motion.toolAt(key);
    const tip = data.path?.tips.find((tip) => tip.tool === tool) ?? data.path?.tips.find((tip) => tip.tool === null);
    if (!tip) {
      last = null;
      continue;
    }
    const at = tipAt(data, motion.posesAt(motion.positionAt(key)), tip);
    // A change of tools is no way.
    if (last && last.tip === tip) (motion.kinds[motion.moveAt(key)] === 0 ? found.rapid : found.feed).push(...last.at, ...at);
    last = { tip, at };
  }
  return { feed: Float32Array.from(found.feed), rapid: Float32Array.from(found.rapid) };
}

/** The tip in the frame of the work. @param {ViewData} data @param {Mat4[]} poses @param {Tip} tip @returns {Vec3} */
function tipAt(data, poses, tip) {
  const world = tip.link === null ? tip.at : apply(poses[tip.link], tip.at);
  const work = data.path?.work ?? null;
  return work === null ? world : apply(inverse(poses[work]), world);
}
