// The report page in a real browser: it opens without a complaint, filters change the charts, pointing shows numbers, a click
// shows the row of the record, and it looks like something in light, dark, on paper and on a phone.
//
//   node --test tests/browser/report.test.mjs
//
// The page is that of results/reference, written anew by `BVBENCH` (default target/release/bvbench), or the one that `REPORT` names.
// playwright-core and typescript are in target/browser, `CHROMIUM` is the browser.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, mkdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { launch } from "./harness.mjs";

const root = path.resolve(import.meta.dirname, "../..");
const work = path.join(root, "target/browser");
const shots = path.join(work, "shots");

/** Milliseconds from opening the page to all charts being there, and bytes of the page. */
const MOST_MS = 2000;
const MOST_BYTES = 8e6;

/** Pages on paper, and screens of a phone. */
const MOST_PAGES = 8;
const MOST_SCREENS = 12;

/** @type {import("playwright-core").Browser} */
let browser;
/** @type {string} */
let file;

before(async () => {
  mkdirSync(shots, { recursive: true });
  file = process.env.REPORT ?? writtenAnew();
  browser = await launch();
});
after(() => browser?.close());

/** The report of the committed run, made by bvbench; of `metric` there are no ratios. */
function writtenAnew(name = "reference", metric = "") {
  const folder = path.join(work, "pages", name);
  rmSync(folder, { recursive: true, force: true }); // what an older bvbench left there would be shown too
  cpSync(path.join(root, "results/reference"), folder, { recursive: true });
  const ratios = path.join(folder, "ratios.csv");
  const kept = readFileSync(ratios, "utf8").split("\n").filter((line) => metric === "" || !line.includes(`,${metric}`));
  writeFileSync(ratios, kept.join("\n"));
  execFileSync(path.resolve(root, process.env.BVBENCH ?? "target/release/bvbench"), ["stage", "report", "--out", folder]);
  return path.join(folder, "report.html");
}

/** Opens the page as a reader would who has no network, and closes it again; what it complains of fails the test. */
async function opened(use, options = {}, page = file) {
  const context = await browser.newContext({ viewport: { width: 1360, height: 900 }, offline: true, ...options });
  const tab = await context.newPage();
  const complaints = [];
  tab.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !message.text().includes("GPU stall")) complaints.push(message.text());
  });
  tab.on("pageerror", (error) => complaints.push(String(error.stack)));
  tab.on("request", (request) => {
    if (!/^(file|data):/.test(request.url())) complaints.push(`asks for ${request.url()}`);
  });
  await tab.goto(pathToFileURL(path.resolve(page)).href);
  await tab.waitForFunction(() => document.documentElement.dataset.ready !== undefined);
  await use(tab);
  assert.deepEqual(complaints, []);
  await context.close();
}

/** The page's scripts in the order in which it reads them. */
function scripts() {
  const folder = path.join(root, "crates/record/src/report/page");
  const names = [...readFileSync(path.join(folder, "mod.rs"), "utf8").matchAll(/include_str!\("(\w+\.js)"\)/g)];
  return names.map((name) => path.join(folder, name[1]));
}

test("the scripts have the types that they say", () => {
  const options = "--allowJs --checkJs --noEmit --strict --target es2022 --lib es2023,dom,dom.iterable".split(" ");
  execFileSync("node", [path.join(work, "node_modules/typescript/bin/tsc"), ...options, ...scripts()], { stdio: "inherit" });
});

test("the page is small and soon there", async (t) => {
  assert.ok(statSync(file).size < MOST_BYTES);
  await opened(async (tab) => {
    const ready = Number(await tab.evaluate(() => document.documentElement.dataset.ready));
    t.diagnostic(`${(statSync(file).size / 1e6).toFixed(2)} MB, interactive after ${ready} ms`);
    assert.ok(ready < MOST_MS, `interactive after ${ready} ms`);
    await shot(tab, "light");
  });
});

test("verdicts filter by kind and sort by value", () => opened(claims));
test("every filter changes what is drawn", () => opened(filters));
test("pointing tells numbers, a click tells file and line", () => opened(pointing));
test("any record can be searched", () => opened(records));

test("light and dark follow the system, and the button", () =>
  opened(
    async (tab) => {
      const paper = () => tab.evaluate(() => getComputedStyle(document.body).backgroundColor);
      const dark = await paper();
      await tab.evaluate(() => document.getElementById("speed")?.scrollIntoView());
      await shot(tab, "dark");
      await tab.click("#theme");
      assert.notEqual(await paper(), dark);
      await tab.click("#theme");
      assert.equal(await paper(), dark);
    },
    { colorScheme: "dark" },
  ));

test("the answer, the figure and the ranking are on the first screen", () =>
  opened(
    async (tab) => {
      await shot(tab, "first-screen");
      for (const part of ["#answer", "#programs .place", "#ranking table"]) {
        const box = await tab.locator(part).boundingBox();
        assert.ok(box && box.y + box.height <= 900, `${part} ends at ${box && box.y + box.height} px`);
      }
      const [table, room] = [await tab.locator("#ranking table").boundingBox(), await tab.locator("#ranks").boundingBox()];
      assert.ok(table && room && table.x + table.width <= room.x + room.width + 1, "the ranking is cut off on the right");
      const questions = await tab.locator("#answer h3").allTextContents();
      assert.ok(!(await tab.locator("#answer").textContent())?.includes("`"), "code stands between backticks");
      assert.ok(questions.length >= 2 && questions.every((question) => question.endsWith("?")), questions.join(" "));
    },
    { viewport: { width: 1400, height: 900 } },
  ));

test("without programs the ranking has the numbers of its own workload", () =>
  opened(
    async (tab) => {
      const data = JSON.parse((await tab.textContent("#data-of-the-run")) ?? "");
      const { columns, rows } = data.tables["ratios.csv"];
      const cells = rows.map(([, ...values]) => Object.fromEntries(columns.map((column, i) => [column, values[i]])));
      const policy = (id) => data.manifest.variants.find((one) => one.id === id).policies[0];
      const [below] = data.baselines;
      const ratios = cells.filter(
        (row) =>
          row.metric === "time" && row.workload === "program" && row.stratum === "all" && row.baseline === below && row.baseline_policy === policy(below),
      );
      const lines = await tab.locator("#ranking tbody tr").all();
      assert.equal(lines.length, data.ranking.length);
      let compared = 0;
      for (const [i, { variant }] of data.ranking.entries()) {
        const shown = await lines[i].locator("td.right").evaluateAll((found) => found.map((cell) => parseFloat(cell.querySelector("b")?.textContent ?? "")));
        data.manifest.scenes.forEach(({ name }, scene) => {
          const row = ratios.find((one) => one.scene === name && one.variant === variant && one.policy === (policy(variant) ?? one.policy));
          if (!row) return;
          assert.ok(Math.abs(shown[scene + 1] / row.ratio - 1) < 0.006, `${variant} on ${name}: ${shown[scene + 1]}, not ${row.ratio}`);
          compared += 1;
        });
      }
      assert.ok(compared > 5, `${compared} ratios`);
      assert.match((await tab.textContent("#ranking .about")) ?? "", /query time in program/);
      // Charts begin with what the run has, in that workload.
      const pressed = (label) => tab.locator(`#speed [aria-label="${label}"] button[aria-pressed="true"]`).allTextContents();
      assert.deepEqual(await pressed("Workload"), ["program", "program"]);
      for (const button of await tab.locator('#charts-ratios [aria-label="Measure"] button').all()) {
        await button.click();
        assert.ok((await tab.locator("#charts-ratios svg.drawing").count()) > 0, `${await button.textContent()} shows nothing`);
      }
    },
    {},
    writtenAnew("no-programs", "program-time"),
  ));

test("every joined curve goes from left to right", () =>
  opened(async (tab) => {
    let curves = 0;
    for (const frame of await tab.locator('#tightness-levels [aria-label="Frame"] button').all()) {
      await frame.click();
      const paths = await tab.locator("g.curve path.stroke").evaluateAll((found) => found.map((path) => path.getAttribute("d") ?? ""));
      for (const path of paths) {
        const xs = [...path.matchAll(/[ML](-?[\d.]+) /g)].map((match) => Number(match[1]));
        assert.ok(xs.every((x, i) => i === 0 || x > xs[i - 1]), `x goes back in ${path}`);
      }
      curves += paths.filter((path) => path.includes("L")).length;
    }
    assert.ok(curves > 10, `${curves} curves`);
  }));

test("variants look as in the figures, and hollow means unsafe", () =>
  opened(async (tab) => {
    const data = JSON.parse((await tab.textContent("#data-of-the-run")) ?? "");
    const figure = readFileSync(path.join(root, "results/reference/plots/time-ratios.svg"), "utf8").toLowerCase();
    for (const variant of data.manifest.variants.filter((one) => data.looks[one.id] && one.kind === "volume")) {
      assert.equal(data.looks[variant.id].hollow, !variant.safe, variant.id);
      assert.ok(figure.includes(data.looks[variant.id].light), `${variant.id} is ${data.looks[variant.id].light}`);
    }
    const safe = data.manifest.variants.filter((one) => one.safe).map((one) => one.label);
    const hollow = await tab.locator("#charts-ratios g:has(> g .hollow) > text.name > title").allTextContents();
    assert.ok(hollow.length > 0 && hollow.every((name) => !safe.includes(name)), hollow.join(", "));
  }));

test("the tab key stops once in each chart", async (t) => {
  await opened(async (tab) => {
    const stops = await tab.evaluate(() => {
      const all = [...document.querySelectorAll('a[href], button, input, select, summary, [tabindex="0"]')];
      return all.filter((one) => one.getAttribute("tabindex") !== "-1" && one.getClientRects().length > 0).length;
    });
    t.diagnostic(`${stops} tab stops`);
    assert.ok(stops <= 150, `${stops} tab stops`);
    const first = tab.locator("#charts-ratios .tells").first();
    await first.focus();
    await tab.keyboard.press("ArrowRight");
    const label = await tab.evaluate(() => document.activeElement?.getAttribute("aria-label"));
    assert.equal(label, await tab.locator("#charts-ratios .tells").nth(1).getAttribute("aria-label"));
  });
});

test("paper has the answer, the figure, the ranking and the sentences on few pages", async (t) => {
  await opened(
    async (tab) => {
      await tab.emulateMedia({ media: "print" });
      await tab.evaluate(() => dispatchEvent(new Event("beforeprint")));
      assert.ok(!(await tab.isVisible("nav")) && !(await tab.isVisible("#filters")));
      for (const part of ["#answer", "#programs svg", "#ranking table", "#claims table"]) assert.ok(await tab.locator(part).first().isVisible(), part);
      await shot(tab, "print");
      const pdf = await tab.pdf({ path: path.join(shots, "report.pdf"), format: "A4" });
      const pages = (pdf.toString("latin1").match(/\/Type\s*\/Page\b/g) ?? []).length;
      t.diagnostic(`${pages} pages`);
      assert.ok(pages > 0 && pages <= MOST_PAGES, `${pages} pages`);
    },
    { viewport: { width: 794, height: 1123 } },
  );
});

test("a machine of the run can be looked at", () =>
  opened(async (tab) => {
    const views = tab.locator("#machines iframe");
    if ((await views.count()) === 0) return;
    await views.first().scrollIntoViewIfNeeded();
    const view = await (await views.first().elementHandle()).contentFrame();
    await view.waitForFunction(() => window.bvbench?.[0]?.state().frames > 0);
    await tab.evaluate(() => document.getElementById("machines")?.scrollIntoView());
    await shot(tab, "machines");
  }));

test("a phone shows the page's whole width, on few screens", async (t) => {
  await opened(
    async (tab) => {
      for (const section of ["answer", "ranks", "verdicts", "truth"]) {
        await tab.evaluate((id) => document.getElementById(id)?.scrollIntoView(), section);
        await tab.waitForTimeout(100);
        await shot(tab, `phone-${section}`);
      }
      assert.equal(await tab.evaluate(() => document.documentElement.scrollWidth - innerWidth), 0);
      const screens = await tab.evaluate(() => document.documentElement.scrollHeight / innerHeight);
      t.diagnostic(`${screens.toFixed(1)} screens`);
      assert.ok(screens <= MOST_SCREENS, `${screens} screens`);
      // A closed chart is drawn when it is opened.
      const card = tab.locator("#charts-ratios details");
      assert.equal(await card.locator("svg.drawing").count(), 0);
      await card.locator("summary").click();
      await card.locator("svg.drawing").first().waitFor();
    },
    { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 },
  );
});

/** Verdicts filter by kind and sort by value. @param {import("playwright-core").Page} tab */
async function claims(tab) {
  await tab.click("#verdict-table summary");
  const rows = () => tab.locator("#verdict-table tbody tr").count();
  const all = await rows();
  const kinds = await tab
    .locator("#verdict-table .chip")
    .evaluateAll((chips) => chips.map((chip) => chip.getAttribute("data-value")));
  let left = all;
  for (const kind of kinds.slice(1)) {
    const badges = await tab.locator(`#verdict-table tbody .badge.${kind}`).count();
    await tab.click(`#verdict-table .chip[data-value="${kind}"]`);
    left -= badges;
    assert.equal(await rows(), Math.max(left, 1), `without ${kind}`);
  }
  for (const kind of kinds.slice(1)) await tab.click(`#verdict-table .chip[data-value="${kind}"]`);
  assert.equal(await rows(), all);
  const values = () =>
    tab
      .locator("#verdict-table tbody td[data-label^=value]")
      .evaluateAll((cells) =>
        cells.map((cell) => parseFloat((cell.textContent ?? "").replace(/\u202f/g, ""))).filter(Number.isFinite),
      );
  await tab.click("#verdict-table th:has-text('value') button");
  const sorted = await values();
  assert.ok(sorted.length > 10 && sorted.every((value, i) => i === 0 || sorted[i - 1] <= value), "the table sorts");
}

/** Every filter changes what is drawn. @param {import("playwright-core").Page} tab */
async function filters(tab) {
  const chart = tab.locator("#charts-ratios .place");
  const drawn = () => chart.innerHTML();
  await tab.click('#charts-ratios button[data-value="program-time-cold"]');
  assert.ok((await chart.locator("svg").count()) > 0, "cold programs show nothing");
  const panels = () => chart.locator("figure").count();
  await tab.click("#filters summary");
  await tab.click('#charts-ratios button[data-value="time"]');
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
  for (const card of ["#programs", "#charts-ratios", "#misses-rates", "#tightness-levels"]) {
    const mark = tab.locator(`${card} .mark`).nth(2);
    await mark.scrollIntoViewIfNeeded();
    await scrolled(tab);
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

/** Waits until the page has told that it was scrolled, which hides tips: that comes with a later frame. @param {import("playwright-core").Page} tab */
function scrolled(tab) {
  return tab.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** Any record can be searched. @param {import("playwright-core").Page} tab */
async function records(tab) {
  await tab.click("#records summary");
  await tab.selectOption("#records select", "trees.csv");
  const rows = tab.locator("#records tbody tr");
  const all = await rows.count();
  await tab.fill("#records input", "aabb median");
  const found = await rows.allTextContents();
  assert.ok(found.length > 0 && found.length < all && found.every((row) => row.includes("aabb")), "the search finds");
  await tab.fill("#records input", "");
}

/** A screenshot, left in target/browser/shots, that must show something: more than a few colours. @param {import("playwright-core").Page} tab @param {string} name */
async function shot(tab, name) {
  const image = await tab.screenshot({ path: path.join(shots, `report-${name}.png`) });
  const colours = await tab.evaluate(async (base64) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    canvas?.drawImage(bitmap, 0, 0);
    const pixels = canvas?.getImageData(0, 0, bitmap.width, bitmap.height).data ?? new Uint8ClampedArray();
    const seen = new Set();
    for (let i = 0; i < pixels.length; i += 28) seen.add((pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2]);
    return seen.size;
  }, image.toString("base64"));
  assert.ok(colours > 40, `${name} has ${colours} colours`);
}
