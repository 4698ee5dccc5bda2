// What the browser tests share: bvbench, a browser without a network, and pictures that are looked at pixel by pixel.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

export const root = path.resolve(import.meta.dirname, "../..");
const work = path.join(root, "target/browser");
const { chromium } = createRequire(path.join(work, "x.js"))("playwright-core");

/** Flags for a machine without a screen or a graphics card. */
const FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/** Runs bvbench in the repository; gives what it prints. */
export function bvbench(...args) {
  return execFileSync(path.resolve(root, process.env.BVBENCH ?? "target/release/bvbench"), args, { cwd: root, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
}

/** Where a page goes. */
export function pagePath(name) {
  return path.join(work, "pages", name);
}

/** Writes a page with `bvbench view`, one file for each set of options; gives its path and its size in bytes. */
export function viewPage(scene, ...options) {
  const out = pagePath(`${[path.basename(scene), ...options].join("")}.html`);
  bvbench("view", scene, "--quiet", "--out", out, ...options);
  return { path: out, bytes: statSync(out).size };
}

export { existsSync };

export function launch() {
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
}

/**
 * Opens a file as a reader would who has no network. `faults` collects errors, warnings of the page's own making, and requests for
 * anything but the file.
 */
export async function open(browser, file, { width = 1400, height = 860, dark = false, phone = false } = {}) {
  const context = await browser.newContext({
    viewport: { width, height }, colorScheme: dark ? "dark" : "light", offline: true, hasTouch: phone, isMobile: phone, deviceScaleFactor: phone ? 2 : 1,
  });
  const page = await context.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(`error: ${error.message}`));
  page.on("console", (message) => {
    // Reading pixels back for a picture is slow, and Chromium says so.
    if (["error", "warning"].includes(message.type()) && !message.text().includes("GPU stall")) faults.push(message.text());
  });
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) faults.push(`asks for ${request.url()}`);
  });
  await page.goto(`file://${file}`);
  return { page, faults };
}

/** Takes a picture of (a part of) a page, keeps it in target/browser/shots, and decodes it: `at(x, y)` is [r, g, b]. */
export async function shot(page, name, clip) {
  const png = await page.screenshot({ clip });
  writeFileSync(path.join(work, "shots", `${name}.png`), png);
  const { width, height, rgba } = await page.evaluate(async (text) => {
    const image = new Image();
    image.src = `data:image/png;base64,${text}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const ctx = canvas.getContext("2d");
    ctx.drawImage(image, 0, 0);
    const { data } = ctx.getImageData(0, 0, image.width, image.height);
    let binary = "";
    for (let from = 0; from < data.length; from += 32768) binary += String.fromCharCode(...data.subarray(from, from + 32768));
    return { width: image.width, height: image.height, rgba: btoa(binary) };
  }, png.toString("base64"));
  const data = Buffer.from(rgba, "base64");
  const at = (x, y) => [...data.subarray(4 * (y * width + x), 4 * (y * width + x) + 3)];
  /** How many pixels are so. */
  const count = (is) => {
    let found = 0;
    for (let i = 0; i < data.length; i += 4) if (is(data[i], data[i + 1], data[i + 2])) found++;
    return found;
  };
  return { width, height, data, at, count };
}

/** How many pixels differ. */
export function difference(p, q) {
  assert.equal(p.data.length, q.data.length);
  let found = 0;
  for (let i = 0; i < p.data.length; i += 4) {
    if (Math.abs(p.data[i] - q.data[i]) + Math.abs(p.data[i + 1] - q.data[i + 1]) + Math.abs(p.data[i + 2] - q.data[i + 2]) > 12) found++;
  }
  return found;
}

/** A picture in which there is something to see: many colours, none nearly everywhere. */
export function assertNotBlank(picture, what) {
  const seen = new Map();
  for (let i = 0; i < picture.data.length; i += 4) {
    const colour = (picture.data[i] >> 4 << 8) | (picture.data[i + 1] >> 4 << 4) | (picture.data[i + 2] >> 4);
    seen.set(colour, (seen.get(colour) ?? 0) + 1);
  }
  const most = Math.max(...seen.values()) / (picture.data.length / 4);
  assert.ok(seen.size > 30 && most < 0.9, `${what}: ${seen.size} colours, the commonest on ${(100 * most).toFixed(0)} %`);
}
