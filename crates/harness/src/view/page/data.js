// @ts-check
// What the page was given (docs/view.md), and how its arrays are unpacked.

/**
 * @typedef {{ axis: number, turns: boolean, direction: Vec3, point: Vec3, gain: number, min: number | null, max: number | null }} Joint
 * @typedef {{ name: string, parent: number | null, at: number[], joint: Joint | null }} Link
 * @typedef {{ name: string, role: string, tool: number | null, link: number | null, at: number[], examined: boolean, low: Vec3,
 *   step: Vec3, vertices: string, faces: string, wide: boolean }} PartData
 * @typedef {{ line: string, kind: string, feed: string, tool: string, rpm: string, last_key: string }} Moves
 * @typedef {{ file: string, lines: string[], duration_s: number, first_tool: number, axes: number[], keys: number,
 *   durations: string, values: string, moves: Moves }} Program
 * @typedef {{ tool: number | null, link: number | null, at: Vec3 }} Tip
 * @typedef {{ key: number, pairs: number, a: string, b: string, at: Vec3 | null, lines: string }} Contact
 * @typedef {{ kind: string, zone_mm: number | null, pair: [number, number], first: number, last: number, nearest: number, line: number,
 *   last_line: number, time_s: number, least_mm: number, inside: boolean, to_the_end: boolean, contacts: Contact[] }} ViewEvent
 * @typedef {{ kind: string, line: number, first: number, last: number, text: string }} Fault
 * @typedef {{ pairs: [number, number][], farthest_mm: number, keys: string, mm: string, nearest: string }} Distances
 * @typedef {{ nodes: number, volume_mm3: number, leaking: number, outside: number }} Level
 * @typedef {{ kind: "images", weights: string, edges: string, faces: string, frames: string } |
 *   { kind: "own", counts: string, points: string, edges: string, faces: string }} Shapes
 * @typedef {{ part: number, levels: Level[], low: Vec3, step: Vec3, level_of: string, flags: string, shapes: Shapes }} Tree
 * @typedef {{ id: string, label: string, safe: boolean, trees: Tree[] }} VariantData
 * @typedef {{ format: string, name: string, title: string, description: string, provenance: string, up: "y" | "z", links: Link[],
 *   parts: PartData[], program: Program | null, path: { work: number | null, tips: Tip[] } | null, events: ViewEvent[], faults: Fault[], notes: string[], distances: Distances, variants: VariantData[] }} ViewData
 */

const AXIS_LETTERS = "XYZABCUVW";

/** Whether an axis turns. @param {number} axis */
function isRotary(axis) {
  return axis >= 3 && axis < 6;
}

/** @param {string} text base64 */
function bytes(text) {
  const binary = atob(text);
  const found = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) found[i] = binary.charCodeAt(i);
  return found;
}

/** @param {string} text */
function u16(text) {
  return new Uint16Array(bytes(text).buffer);
}

/** @param {string} text */
function u32(text) {
  return new Uint32Array(bytes(text).buffer);
}

/** @param {string} text */
function f32(text) {
  return new Float32Array(bytes(text).buffer);
}

/** Whether an event is more than nearness. @param {ViewEvent} event */
function isCollision(event) {
  return event.kind !== "near";
}

/** Minutes and seconds. @param {number} seconds */
function clock(seconds) {
  const minutes = Math.floor(seconds / 60);
  return `${minutes}:${(seconds - 60 * minutes).toFixed(1).padStart(4, "0")}`;
}
