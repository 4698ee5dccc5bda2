// @ts-check
// What a variant looks like: colour and marker as in the figures for print. A hollow marker is that of an unsafe variant.

/** What has no look of its own, such as another library's engine by name. @type {Look} */
const PLAIN = { light: "#5c6068", dark: "#a3a8b2", path: "M-7 0a7 7 0 1 0 14 0a7 7 0 1 0-14 0", hollow: false };

/** @param {string} id @returns {Look} */
function lookOf(id) {
  return data.looks[id] ?? PLAIN;
}

/** The colour of a variant, as a style. @param {string} id */
function colourOf(id) {
  const { light, dark } = lookOf(id);
  return `--look: light-dark(${light}, ${dark})`;
}

/** The marker of a variant. @param {string} id @param {number} x @param {number} y */
function markerOf(id, x, y) {
  const { path, hollow } = lookOf(id);
  return draw("path", { class: hollow ? "dot hollow" : "dot", style: colourOf(id), d: path, transform: `translate(${x.toFixed(1)} ${y}) scale(.72)` });
}

/** The marker of a variant beside its name. @param {string} id */
function sample(id) {
  return draw("svg", { class: "sample", width: 16, height: 14, viewBox: "0 0 16 14", "aria-hidden": "true" }, markerOf(id, 8, 7));
}
