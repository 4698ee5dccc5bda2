// @ts-check
// Elements and numbers.

const SVG = "http://www.w3.org/2000/svg";

/**
 * An element with attributes and children; a function as attribute is a listener.
 * @param {string} tag
 * @param {Record<string, any>} attributes
 * @param {...(Node | string | null | undefined)} children
 * @returns {HTMLElement}
 */
function el(tag, attributes = {}, ...children) {
  return /** @type {HTMLElement} */ (fill(document.createElement(tag), attributes, children));
}

/**
 * The same for the elements of a drawing.
 * @param {string} tag
 * @param {Record<string, any>} attributes
 * @param {...(Node | string | null | undefined)} children
 * @returns {SVGElement}
 */
function draw(tag, attributes = {}, ...children) {
  return /** @type {SVGElement} */ (fill(document.createElementNS(SVG, tag), attributes, children));
}

/**
 * @param {Element} element
 * @param {Record<string, any>} attributes
 * @param {(Node | string | null | undefined)[]} children
 */
function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  for (const child of children) if (child !== null && child !== undefined) element.append(child);
  return element;
}

/** A text, with what is between backticks as code. @param {string} text @returns {(Node | string)[]} */
function prose(text) {
  return text.split("`").map((words, i) => (i % 2 === 1 ? el("code", {}, words) : words));
}

/** An element of the document that must be there. @param {string} id @returns {HTMLElement} */
function part(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found;
}

/** Three significant digits, or more where the whole part has them; a dash for what is no number. @param {any} value */
function number(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e15) return grouped(String(value));
  if (size >= 100) return grouped(value.toFixed(0));
  if (size >= 10) return value.toFixed(1);
  if (size >= 0.1) return value.toFixed(3);
  return size >= 1e-3 ? value.toFixed(4) : value.toExponential(1);
}

/** Thousands apart, by spaces that do not break. @param {string} digits */
function grouped(digits) {
  return digits.length > 4 ? digits.replace(/\B(?=(\d{3})+$)/g, "\u202f") : digits;
}

/** A value with its interval, as far as there are any. @param {any} value @param {any} low @param {any} high */
function interval(value, low, high) {
  if (typeof value !== "number") return "";
  return typeof low === "number" && typeof high === "number" && low !== high
    ? `${number(value)} [${number(low)}, ${number(high)}]`
    : number(value);
}

/** The units of time: how many nanoseconds each has. @type {[string, number][]} */
const TIMES = [
  ["s", 1e9],
  ["ms", 1e6],
  ["µs", 1e3],
  ["ns", 1],
];

/** A time in the unit that suits it. @param {any} ns */
function time(ns) {
  if (typeof ns !== "number") return "–";
  const [unit, size] = TIMES.find(([, size]) => ns >= size) ?? TIMES[3];
  return `${number(ns / size)} ${unit}`;
}

/** A share in percent. @param {any} share */
function percent(share) {
  return typeof share === "number" ? `${number(share * 100)} %` : "–";
}
