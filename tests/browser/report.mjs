// The report page in a real browser: it opens without a complaint, filters change the charts, pointing shows numbers, a click
// shows the row of the record, and it looks like something in light, dark, on paper and on a phone.
//
//   node tests/browser/report.mjs PAGE.html SHOTS_DIR
//
// `PLAYWRIGHT` names the folder in whose node_modules playwright-core is (default target/browser), `CHROMIUM` the browser.

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

/** How the browser is started: without a screen, and without anything that asks the network. */
export const FLAGS = [
  "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
];

/** Milliseconds from opening the page to all charts being there. */
const MOST_MS = 2000;

/**
 * Tests the page in a browser that is running.
 * @param {import("playwright-core").Browser} browser
 * @param {string} page path of the report
 * @param {string} shots folder for the screenshots
 */
export async function testReport(browser, page, shots) {
  mkdirSync(shots, { recursive: true });
  const context = await browser.newContext({ viewport: { width: 1360, height: 900 }, offline: true });
  const tab = await context.newPage();
  /** @type {string[]} */
  const complaints = [];
  tab.on("console", (message) => { if (["error", "warning"].includes(message.type())) complaints.push(message.text()); });
  tab.on("pageerror", (error) => complaints.push(String(error.stack)));
  tab.on("request", (request) => { if (!/^(file|data):/.test(request.url())) complaints.push(`asks for ${request.url()}`); });
  const shoot = (/** @type {string} */ name) => shot(tab, join(shots, `report-${name}.png`));

  await tab.goto(pathToFileURL(resolve(page)).href);
  await tab.waitForFunction(() => document.documentElement.dataset.ready !== undefined);
  const ready = Number(await tab.evaluate(() => document.documentElement.dataset.ready));
  assert.ok(ready < MOST_MS, `interactive after ${ready} ms`);
  await shoot("light");

  await claims(tab);
  await filters(tab);
  await pointing(tab);
  await records(tab);

  await tab.evaluate(() => document.getElementById("speed")?.scrollIntoView());
  await tab.emulateMedia({ colorScheme: "dark" });
  const paper = () => tab.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await paper();
  await shoot("dark");
  await tab.click("#theme");
  assert.notEqual(await paper(), dark, "the button changes light and dark");
  await tab.click("#theme");
  assert.equal(await paper(), dark);

  await tab.emulateMedia({ colorScheme: "light", media: "print" });
  assert.ok(!(await tab.isVisible("nav")) && (await tab.isVisible("#verdict-table table")), "what cannot be printed is left out");
  await tab.pdf({ path: join(shots, "report.pdf"), format: "A4" });
  await shoot("print");
  await tab.emulateMedia({ media: "screen" });

  await tab.setViewportSize({ width: 390, height: 844 });
  for (const [section, name] of [["verdicts", "phone"], ["ranks", "phone-ranking"], ["truth", "phone-misses"]]) {
    await tab.evaluate((id) => document.getElementById(id)?.scrollIntoView(), section);
    await tab.waitForTimeout(100);
    await shoot(name);
  }
  const overflow = await tab.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.equal(overflow, 0, "a phone shows the page's whole width");
  assert.deepEqual(complaints, []);
  await context.close();
  return ready;
}

/** Verdicts filter by kind and sort by value. @param {import("playwright-core").Page} tab */
async function claims(tab) {
  const rows = () => tab.locator("#verdict-table tbody tr").count();
  const all = await rows();
  const kinds = await tab.locator('#verdict-table .chip').evaluateAll((chips) => chips.map((chip) => chip.getAttribute("data-value")));
  let left = all;
  for (const kind of kinds.slice(1)) {
    const badges = await tab.locator(`#verdict-table tbody .badge.${kind}`).count();
    await tab.click(`#verdict-table .chip[data-value="${kind}"]`);
    left -= badges;
    assert.equal(await rows(), Math.max(left, 1), `without ${kind}`);
  }
  for (const kind of kinds.slice(1)) await tab.click(`#verdict-table .chip[data-value="${kind}"]`);
  assert.equal(await rows(), all);
  const values = () => tab.locator("#verdict-table tbody td[data-label^=value]").evaluateAll((cells) => cells.map((cell) => parseFloat((cell.textContent ?? "").replace(/\u202f/g, ""))).filter(Number.isFinite));
  await tab.click("#verdict-table th:has-text('value') button");
  const sorted = await values();
  assert.ok(sorted.length > 10 && sorted.every((value, i) => i === 0 || sorted[i - 1] <= value), "the table sorts");
}

/** Every filter changes what is drawn. @param {import("playwright-core").Page} tab */
async function filters(tab) {
  const chart = tab.locator("#charts-ratios .place");
  const drawn = () => chart.innerHTML();
  const panels = () => chart.locator("figure").count();
  await tab.click("#filters summary");
  const [before, scenes] = [await drawn(), await panels()];
  const scene = tab.locator('#filters [aria-label="Scenes"] .chip').first();
  await scene.click();
  assert.equal(await panels(), scenes - 1, "a scene less is a panel less");
  await scene.click();
  assert.equal(await drawn(), before);
  const variant = tab.locator('#filters [aria-label="Variants"] .chip').first();
  const name = await variant.textContent();
  await variant.click();
  assert.ok(!(await chart.locator("text.name").allTextContents()).some((text) => text === name), `${name} is gone`);
  await variant.click();
  await tab.click('#filters [aria-label="Poses"] button[data-value="colliding"]');
  assert.notEqual(await drawn(), before, "another stratum has other ratios");
  await tab.click('#filters [aria-label="Poses"] button[data-value="all"]');
  const lines = await chart.locator("g.mark").count();
  await tab.click('#filters [aria-label="Trees"] button[data-value="every"]');
  assert.ok((await chart.locator("g.mark").count()) > lines, "every policy is more cases");
  await tab.click('#filters [aria-label="Trees"] button[data-value="default"]');
  await tab.click('#charts-ratios button[data-value="volume-tests"]');
  assert.notEqual(await drawn(), before, "another measure");
  await tab.click('#charts-ratios button[data-value="time"]');
  assert.equal(await drawn(), before, "and back");
  await tab.click("#filters summary");
}

/** Pointing tells numbers, a click tells file and line. @param {import("playwright-core").Page} tab */
async function pointing(tab) {
  for (const card of ["#ranking", "#charts-ratios", "#misses-rates", "#tightness-levels"]) {
    const mark = tab.locator(`${card} .mark`).nth(2);
    await mark.scrollIntoViewIfNeeded();
    await mark.locator(".touch").hover({ force: true });
    assert.ok(await tab.isVisible("#tip"), `${card}: a tip`);
    assert.match((await tab.textContent("#tip")) ?? "", /\d/, `${card}: with numbers`);
    await mark.locator(".touch").click({ force: true });
    assert.match((await tab.textContent("#rows-body h4")) ?? "", /^\w+\.csv, line \d+$/, `${card}: the row behind it`);
    await tab.keyboard.press("Escape");
    assert.ok(!(await tab.isVisible("#rows")));
  }
  const mark = tab.locator("#charts-ratios .mark").first();
  const label = (await mark.getAttribute("aria-label")) ?? "";
  await mark.focus();
  await tab.keyboard.press("Enter");
  const ratio = (await tab.locator("#rows-body dl dt:text-is('ratio') + dd").textContent()) ?? "";
  assert.ok(label.includes(Number(ratio).toPrecision(3)), `${label} shows ${ratio}`);
  await tab.click("#rows-close");
}

/** Any record can be searched. @param {import("playwright-core").Page} tab */
async function records(tab) {
  await tab.selectOption("#records select", "trees.csv");
  const rows = tab.locator("#records tbody tr");
  const all = await rows.count();
  await tab.fill("#records input", "aabb median");
  const found = await rows.allTextContents();
  assert.ok(found.length > 0 && found.length < all && found.every((row) => row.includes("aabb")), "the search finds");
  await tab.fill("#records input", "");
}

/** A screenshot that must show something: more than a few colours. @param {import("playwright-core").Page} tab @param {string} path */
async function shot(tab, path) {
  const image = await tab.screenshot({ path });
  const colours = await tab.evaluate(async (base64) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    canvas?.drawImage(bitmap, 0, 0);
    const pixels = canvas?.getImageData(0, 0, bitmap.width, bitmap.height).data ?? new Uint8ClampedArray();
    const seen = new Set();
    for (let i = 0; i < pixels.length; i += 28) seen.add((pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2]);
    return seen.size;
  }, image.toString("base64"));
  assert.ok(colours > 40, `${path} has ${colours} colours`);
}

/** A browser of this machine. */
export async function launch() {
  const require = createRequire(`${resolve(process.env.PLAYWRIGHT ?? "target/browser")}/`);
  const { chromium } = require("playwright-core");
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const [page, shots] = process.argv.slice(2);
  if (!page || !shots) throw new Error("usage: node tests/browser/report.mjs PAGE.html SHOTS_DIR");
  const browser = await launch();
  try {
    console.log(`report: all well, interactive after ${await testReport(browser, page, shots)} ms`);
  } finally {
    await browser.close();
  }
}
