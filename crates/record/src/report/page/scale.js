// @ts-check
// From values to pixels, and the ticks between.

/**
 * @typedef {object} Scale
 * @property {(value: number) => number} at px of a value, kept within the scale
 * @property {number[]} ticks
 */

/**
 * A scale that holds all values, logarithmic or linear.
 * @param {number[]} values
 * @param {boolean} log
 * @param {[number, number]} pixels
 * @param {number} most ticks
 * @returns {Scale}
 */
function scaleOf(values, log, pixels, most) {
  const held = values.filter((value) => Number.isFinite(value) && (!log || value > 0));
  if (held.length === 0) held.push(log ? 1 : 0);
  let low = Math.min(...held);
  let high = Math.max(...held);
  if (log) {
    // A tenth of a decade at the least, so that equal values have a place.
    const room = Math.max(0.05, 0.04 * Math.log10(high / low));
    low *= 10 ** -room;
    high *= 10 ** room;
  } else if (low === high) {
    high = low + 1;
  } else {
    high += 0.03 * (high - low);
  }
  const forward = log ? Math.log : (/** @type {number} */ value) => value;
  const [start, end] = pixels;
  const span = forward(high) - forward(low);
  return {
    at: (value) => {
      const inside = Math.min(Math.max(value, low), high);
      return start + ((forward(inside) - forward(low)) / span) * (end - start);
    },
    ticks: log ? logTicks(low, high, most) : linearTicks(low, high, most),
  };
}

/** Powers of ten, with 2 and 5 between them where there is room. @param {number} low @param {number} high @param {number} most */
function logTicks(low, high, most) {
  const first = Math.floor(Math.log10(low));
  const last = Math.ceil(Math.log10(high));
  for (const digits of [[1, 1.5, 2, 3, 4, 5, 6, 8], [1, 2, 5], [1, 3], [1]]) {
    const ticks = [];
    for (let power = first; power <= last; power++) for (const digit of digits) ticks.push(digit * 10 ** power);
    const inside = ticks.filter((tick) => low <= tick && tick <= high);
    if (inside.length <= most && inside.length > 0) return inside;
  }
  const step = Math.ceil((last - first) / most);
  const ticks = [];
  for (let power = Math.ceil(Math.log10(low)); 10 ** power <= high; power += step) ticks.push(10 ** power);
  return ticks;
}

/** Round numbers. @param {number} low @param {number} high @param {number} most */
function linearTicks(low, high, most) {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((digit) => digit * power >= rough) ?? 10);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high; i++) ticks.push(i * step);
  return ticks;
}

/** A tick's text: 0.001, 0.8, 12, 5k, 2M; as in the figures for print. @param {number} value */
function tickText(value) {
  const size = Math.abs(value);
  if (size !== 0 && size < 1e-4) return value.toExponential(0).replace("e-0", "e-");
  const [unit, letter] = [[1e9, "G"], [1e6, "M"], [1e3, "k"]].find(([unit]) => size >= Number(unit) * 0.9999) ?? [1, ""];
  return `${Number((value / Number(unit)).toPrecision(3))}${letter}`;
}
