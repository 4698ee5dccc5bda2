// `bvbench view` in a real browser: the machine moves, what collides lights up, trees come and go, and nothing is asked of a network.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { Glb } from "./glb.mjs";
import { assertNotBlank, bvbench, difference, existsSync, launch, open, pagePath, root, shot, viewPage } from "./harness.mjs";

/** What `bench-scenes/mill-vise` is known to do: on line 93 the holder's nut runs onto the vice. */
const CRASH = { line: 93, pair: ["vise", "holder"] };
/** The largest program there is, where scripts/real-scenes has fetched it. */
const LARGE = process.env.LARGE_SCENE ?? `${root}/target/real-scenes/xyzac-trt`;

let browser, mill;
before(async () => {
  browser = await launch();
  mill = viewPage("mill-vise");
});
after(() => browser?.close());

/** Opens a view and waits until it has drawn. */
async function openView(file, options) {
  const opened = await open(browser, file, options);
  await opened.page.waitForFunction(() => window.bvbench?.[0]?.state().frames > 0);
  return opened;
}

/** Calls the view, waits for the next frames (at rest, for fine ones), and gives its state. */
async function ask(page, call) {
  await page.evaluate(call);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  await page.waitForFunction(() => {
    const { fine, playing, flying } = window.bvbench[0].state();
    return (fine || playing) && !flying;
  });
  return page.evaluate(() => window.bvbench[0].state());
}

/** The picture of the machine alone. */
async function stage(page, name) {
  await ask(page, () => {});
  const box = await page.locator(".bv-stage").boundingBox();
  return shot(page, name, box);
}

/** The red of parts that collide: of the first, and of the second, which is nearer to orange. */
const isRed = (r, g, b) => r > 130 && g < 0.5 * r && b < 0.5 * r;

test("the page opens from disk, quietly and small", async () => {
  const { page, faults } = await openView(mill.path);
  assertNotBlank(await shot(page, "view-start"), "the page");
  assert.deepEqual(faults, []);
  assert.ok(mill.bytes < 4e6, `${mill.bytes} bytes`);
  assert.equal(await page.title(), "End mill in a taper holder against a machine vice, three axes - bvbench");
  await page.context().close();
});

test("play moves the tool, pause holds it, and time goes on as fast as it says", async () => {
  const { page, faults } = await openView(mill.path);
  const pose = () => page.evaluate(() => window.bvbench[0].pose("end-mill"));
  const start = await pose();
  await page.getByRole("button", { name: "Play (space)" }).click();
  await page.waitForFunction(() => window.bvbench[0].state().time_s > 5);
  assert.equal((await page.evaluate(() => window.bvbench[0].state())).playing, true);
  await page.keyboard.press("Space");
  const held = await ask(page, () => {});
  const moved = await pose();
  // The spindle comes down from Z500.
  assert.ok(held.axes.Z < 500 && Math.abs(moved[14] - start[14] - (held.axes.Z - 500)) < 1e-3, `${moved[14]} ${start[14]}`);
  await page.waitForTimeout(200);
  assert.deepEqual(await pose(), moved);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("a planted collision lights up the right two parts, and only these", async () => {
  const { page, faults } = await openView(mill.path);
  const clear = await ask(page, () => window.bvbench[0].goToLine(8));
  assert.deepEqual([clear.state, clear.colliding], ["clear", []]);
  const before = await stage(page, "view-clear");
  await page.evaluate(() => document.querySelector(".bv-events").setAttribute("open", ""));
  await page.getByRole("button", { name: /^line 93/ }).filter({ hasText: "collision" }).click();
  const crash = await ask(page, () => window.bvbench[0].focus());
  assert.equal(crash.line, CRASH.line);
  assert.deepEqual(crash.colliding, [CRASH.pair]);
  assert.deepEqual([crash.state, crash.nearest.mm], ["collision", 0]);
  const after = await stage(page, "view-collision");
  assertNotBlank(after, "the collision");
  assert.ok(before.count(isRed) < 2_000, `${before.count(isRed)} red pixels before`); // the cutter is red, and small
  assert.ok(after.count(isRed) > 20_000, `${after.count(isRed)} red pixels in collision`);
  // Each of the two is red, and with both hidden no red is left but the mark of the first contact. The cutter is red by nature.
  const parts = await page.evaluate(() => window.bvbench[0].data.parts.map((part) => part.name));
  for (const name of CRASH.pair) {
    const others = parts.map((_, index) => index).filter((index) => parts[index] !== name);
    await page.evaluate((hidden) => (window.bvbench[0].showing.hidden = new Set(hidden)), others);
    await ask(page, () => window.bvbench[0].draw());
    assert.ok((await stage(page, `view-only-${name}`)).count(isRed) > 5_000, `${name} is not red`);
  }
  const pair = parts.map((_, index) => index).filter((index) => [...CRASH.pair, "end-mill"].includes(parts[index]));
  await page.evaluate((hidden) => (window.bvbench[0].showing.hidden = new Set(hidden)), pair);
  await ask(page, () => window.bvbench[0].draw());
  const rest = (await stage(page, "view-without-the-pair")).count(isRed);
  assert.ok(rest < 1_000, `${rest} red pixels`);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("the page opens on workpiece and tool, not on the back of a block", async () => {
  for (const [scene, work, tool] of [["mill-vise", "workpiece", "end-mill"], ["turn-mill", "workpiece", "tool"]]) {
    for (const width of [1400, 700]) {
      const { page, faults } = await openView(viewPage(scene, "--levels", "1").path, { width, height: 860 });
      const state = await ask(page, () => {});
      assertNotBlank(await shot(page, `view-opens-${scene}-${width}`), scene);
      const seen = await page.evaluate(() => {
        const view = window.bvbench[0];
        const roles = ["workpiece", "cutter", "shank", "holder"];
        const matter = [...view.data.parts.keys()].filter((part) => roles.includes(view.data.parts[part].role) && view.stage.isShown(part, view.showing));
        const [middle, radius] = view.stage.ballAround(matter, 0);
        const off = Math.hypot(...middle.map((x, i) => x - view.camera.target[i]));
        const points = matter.map((part) => view.stage.ballAround([part], 0)[0]);
        const hiding = new Set(points.flatMap((point) => view.stage.hiding(point, matter, view.showing)).map((part) => view.data.parts[part].name));
        return { count: matter.length, off, radius, size: view.camera.size, hiding: [...hiding] };
      });
      assert.ok(seen.count >= 2 && seen.off < 1e-6, `${scene}: ${work} and ${tool} are in the middle: ${JSON.stringify(seen)}`);
      assert.deepEqual(faults, []);
      // The middle of what matters is seen, or what hides it is faded.
      const middle = await page.evaluate(() => {
        const view = window.bvbench[0];
        view.showing.faded = new Set();
        view.frameWork();
        return view.state().faded;
      });
      assert.deepEqual(middle, state.faded);
      await page.context().close();
    }
  }
});

test("a key and a button fly to the next collision, and what hides it is faded", async () => {
  const { page, faults } = await openView(mill.path);
  assert.deepEqual((await ask(page, () => {})).colliding, []);
  await page.keyboard.press("n");
  const crash = await ask(page, () => {});
  assert.deepEqual([crash.line, crash.colliding], [CRASH.line, [CRASH.pair]]);
  assertNotBlank(await shot(page, "view-next-collision"), "the collision");
  await page.keyboard.press("Home");
  await page.getByRole("button", { name: "Next collision (N)" }).click();
  assert.equal((await ask(page, () => {})).line, CRASH.line);
  await page.keyboard.press("n"); // there is one
  assert.equal((await ask(page, () => {})).place, crash.place);
  await page.keyboard.press("End");
  await page.keyboard.press("Shift+N");
  assert.equal((await ask(page, () => {})).place, crash.place);
  // From behind the column the pair is hidden, and the column fades once the eye rests.
  await ask(page, () => {
    const view = window.bvbench[0];
    view.camera.azimuth = Math.PI;
    view.camera.elevation = 0.1;
    view.focus();
  });
  const behind = await ask(page, () => {});
  assert.ok(behind.faded.includes("column"), `faded: ${behind.faded}`);
  assert.ok(!CRASH.pair.some((part) => behind.faded.includes(part)));
  assertNotBlank(await shot(page, "view-faded"), "from behind");
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("the path of the tool is drawn over the workpiece, and goes on request", async () => {
  const { page, faults } = await openView(mill.path);
  await ask(page, () => window.bvbench[0].goToLine(40));
  const withPath = await stage(page, "view-path");
  await page.keyboard.press("p");
  const without = await stage(page, "view-no-path");
  assert.ok(difference(withPath, without) > 1_000, "lines are drawn");
  // At the end of each line of straight cutting the tip is on the path: the end mill is 125 mm long, its zero the middle of the stock's top.
  const worst = await page.evaluate(() => {
    const view = window.bvbench[0];
    const { feed, rapid } = view.stage.path;
    const points = [...feed, ...rapid];
    let least = Infinity;
    const pose = view.pose("end-mill");
    const work = view.pose("table");
    // World of the tip less that of the table: neither is turned.
    const tip = [0, 1, 2].map((axis) => pose[12 + axis] - (axis === 2 ? 125 : 0));
    const table = view.motion.posesAt(view.motion.positionAt(view.showing.place))[view.data.links.findIndex((link) => link.name === "table")];
    for (let at = 0; at < points.length; at += 3) {
      least = Math.min(least, Math.hypot(...[0, 1, 2].map((axis) => points[at + axis] + table[12 + axis] - tip[axis])));
    }
    return work ? least : NaN;
  });
  assert.ok(worst < 0.1, `the path is ${worst} mm from the tip`);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("the picture of the documentation", async () => {
  const { page } = await openView(mill.path, { width: 1200, height: 760 });
  await ask(page, () => {
    const view = window.bvbench[0];
    view.goToEvent(view.data.events.find((event) => event.kind === "collision"));
    view.go(view.showing.place + 2);
    view.focus();
    view.camera.distance *= 1.5;
    view.draw();
  });
  assertNotBlank(await shot(page, "view-docs"), "the picture");
  await page.context().close();
});

test("the program stops at the block before first contact", async () => {
  const { page } = await openView(mill.path);
  await page.getByLabel("stop before first contact").check();
  await ask(page, () => {
    const view = window.bvbench[0];
    view.goToLine(91);
    view.speed = 50;
  });
  await page.getByRole("button", { name: "Play (space)" }).click();
  await page.waitForFunction(() => window.bvbench[0].state().held !== null);
  const held = await ask(page, () => {});
  assert.deepEqual([held.held, held.playing, held.colliding], [CRASH.line, false, []]);
  assert.ok(held.line < CRASH.line, `line ${held.line}`);
  assert.match(await page.locator(".bv-banner").innerText(), /line 93: vise and holder/);
  // Playing on holds again; without the response it goes through.
  await page.getByRole("button", { name: "Play (space)" }).click();
  await page.waitForFunction(() => !window.bvbench[0].state().playing);
  assert.equal((await ask(page, () => {})).place, held.place);
  await page.getByLabel("stop before first contact").uncheck();
  await ask(page, () => (window.bvbench[0].speed = 1)); // slow enough to be seen in contact
  await page.getByRole("button", { name: "Play (space)" }).click();
  await page.waitForFunction(() => window.bvbench[0].state().colliding.length > 0);
  await page.context().close();
});

test("lines, the strip and the keys lead through the program", async () => {
  const { page, faults } = await openView(mill.path);
  await page.locator(".bv-rows [data-line='8']").click();
  assert.equal((await ask(page, () => {})).line, 8);
  assert.equal(await page.locator(".bv-current").getAttribute("data-line"), "8");
  await page.locator(".bv-marks").click({ position: { x: 300, y: 300 } });
  await page.keyboard.press("ArrowRight");
  const next = await ask(page, () => {});
  assert.ok(next.line !== 8 && next.place > 0);
  await page.keyboard.press("ArrowLeft");
  assert.equal((await ask(page, () => {})).line, 8);
  const strip = page.locator(".bv-strip");
  const { width, height } = await strip.boundingBox();
  await strip.click({ position: { x: width / 2, y: height / 2 } });
  const half = await ask(page, () => {});
  const duration = await page.evaluate(() => window.bvbench[0].motion.duration);
  assert.ok(Math.abs(half.time_s / duration - 0.5) < 0.01, `${half.time_s} of ${duration}`);
  await page.keyboard.press("End");
  assert.equal((await ask(page, () => {})).place, next.places - 1);
  await page.keyboard.press("e"); // there is no event behind the end
  await page.keyboard.press("Shift+E");
  assert.ok((await ask(page, () => {})).place < next.places - 1);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("on paper, where the strip is hidden, nothing fails", async () => {
  const { page, faults } = await openView(mill.path);
  await page.emulateMedia({ media: "print" });
  assert.equal((await ask(page, () => window.bvbench[0].goToLine(8))).line, 8);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("what fails the check without a collision is a fault", async () => {
  const [program, out] = ["far.ngc", "far.html"].map(pagePath);
  writeFileSync(program, "G0 G53 Z490\nG0 G53 X5000\nM2\n");
  bvbench("view", "mill-vise", program, "--quiet", "--out", out);
  const { page, faults } = await openView(out);
  const end = await ask(page, () => window.bvbench[0].go(1e9));
  assert.deepEqual([end.state, end.text], ["fault", "axis X at 5000 mm is outside its limits -250 to 250 mm"]);
  assert.match(await page.locator(".bv-events summary").textContent(), /1 other fault/);
  assert.ok((await page.locator(".bv-note").allTextContents()).some((note) => note.includes("not examined")));
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("trees come and go, level by level, and side by side", async () => {
  const { page, faults } = await openView(mill.path);
  await ask(page, () => {
    const view = window.bvbench[0];
    view.goToLine(91);
    view.focus();
  });
  const without = await stage(page, "view-no-trees");
  await page.keyboard.press("t");
  const root_ = await stage(page, "view-level-0");
  assert.ok(difference(without, root_) > 2_000, "the root shows");
  for (let level = 1; level <= 4; level++) await page.keyboard.press("]");
  assert.equal((await ask(page, () => {})).level, 4);
  const fourth = await stage(page, "view-level-4");
  assert.ok(difference(root_, fourth) > 2_000, "level 4 is not the root");
  const isLeak = (r, g, b) => r > 180 && g < 90 && b > 110;
  assert.equal(fourth.count(isLeak), 0, "a safe box holds its triangles");
  await page.keyboard.press("b");
  const both = await stage(page, "view-side-by-side");
  assert.ok(both.count(isLeak) > 300, "the paper-literal box does not");
  await page.keyboard.press("b");
  await page.keyboard.press("t");
  assert.ok(difference(without, await stage(page, "view-trees-gone")) < 50);
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("dragging turns the machine, the wheel comes nearer", async () => {
  const { page } = await openView(mill.path);
  const eye = () => page.evaluate(() => window.bvbench[0].camera.eye());
  const start = await eye();
  await page.mouse.move(400, 400);
  await page.mouse.down();
  await page.mouse.move(500, 380, { steps: 4 });
  await page.mouse.up();
  const turned = await eye();
  assert.ok(Math.hypot(...turned.map((x, i) => x - start[i])) > 100);
  const distance = await page.evaluate(() => window.bvbench[0].camera.distance);
  await page.mouse.wheel(0, -400);
  await page.waitForFunction((before) => window.bvbench[0].camera.distance < 0.8 * before, distance);
  await page.context().close();
});

test("two viewers live in one page, and each starts when it comes into sight", async () => {
  // What `view::fragment` gives is the body of a whole page but for the class `bv-whole`.
  const body = readFileSync(mill.path, "utf8").match(/<body>([\s\S]*)<\/body>/)[1].replace("bv-view bv-whole", "bv-view");
  const file = pagePath("two.html");
  writeFileSync(file, `<!doctype html><html lang="en"><meta charset="utf-8"><title>two</title><body>${body}<p style="height: 2000px"></p>${body}</body></html>`);
  const { page, faults } = await openView(file);
  assert.equal(await page.evaluate(() => window.bvbench.length), 1);
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  await page.waitForFunction(() => window.bvbench.length === 2 && window.bvbench[1].state().frames > 0);
  assert.equal((await page.locator(".bv-view").nth(1).boundingBox()).height, 680);
  // Keys go to the viewer that has the focus, and to no other.
  await page.locator(".bv-view").nth(1).focus();
  await page.keyboard.press("ArrowRight");
  await ask(page, () => {});
  assert.deepEqual(await page.evaluate(() => window.bvbench.map((view) => view.state().place > 0)), [false, true]);
  assertNotBlank(await shot(page, "view-two"), "the second viewer");
  assert.deepEqual(faults, []);
  await page.context().close();
});

test("dark, and on a phone", async () => {
  const dark = await openView(mill.path, { dark: true });
  const picture = await shot(dark.page, "view-dark");
  assertNotBlank(picture, "dark");
  const dim = (shown) => shown.count((r, g, b) => r + g + b < 200) / (shown.data.length / 4);
  await dark.page.context().close();
  // The machine near the eye is as light in both: the rest tells them apart.
  const light = await openView(mill.path);
  const shares = [dim(picture), dim(await shot(light.page, "view-light"))];
  assert.ok(shares[0] > 0.5 && shares[1] < 0.25, `parts of the page that are dark, dark and light: ${shares}`);
  await light.page.context().close();
  const phone = await openView(mill.path, { width: 390, height: 844, phone: true });
  await ask(phone.page, () => window.bvbench[0].goToLine(93));
  assertNotBlank(await shot(phone.page, "view-phone"), "phone");
  await ask(phone.page, () => window.bvbench[0].go(0));
  const [wide, there] = await phone.page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(wide <= there, `${wide} pixels wide on ${there}`);
  await phone.page.getByRole("button", { name: "Play (space)" }).tap();
  assert.equal((await ask(phone.page, () => {})).playing, true);
  assert.deepEqual(phone.faults, []);
  await phone.page.context().close();
});

test("a lathe, five axes and a robot show too", async () => {
  for (const scene of ["lathe-toolpost", "trunnion-impeller", "robot-cell"]) {
    const { page, faults } = await openView(viewPage(scene, "--levels", "4").path);
    assertNotBlank(await shot(page, `view-${scene}`), scene);
    const crash = await ask(page, () => {
      const view = window.bvbench[0];
      view.goToEvent(view.data.events.find((event) => event.kind !== "near"));
      view.focus();
    });
    assert.equal(crash.state, "collision", scene);
    assertNotBlank(await shot(page, `view-${scene}-collision`), scene);
    assert.deepEqual(faults, []);
    await page.context().close();
  }
});

test("the page poses five axes and a robot as the GLB file does", async () => {
  for (const scene of ["trunnion-impeller", "robot-cell"]) {
    const file = pagePath(`${scene}.glb`);
    bvbench("scene", "export", scene, "--format", "glb", "--out", file);
    const glb = new Glb(file);
    const { page } = await openView(viewPage(scene, "--levels", "1").path);
    const parts = await page.evaluate(() => window.bvbench[0].data.parts.filter((part) => part.tool === null).map((part) => part.name));
    let worst = 0;
    for (let key = 0; key < glb.times.length; key += Math.ceil(glb.times.length / 9)) {
      const poses = await page.evaluate(([time, parts]) => {
        const view = window.bvbench[0];
        view.go(view.motion.placeAt(time));
        return parts.map((part) => view.pose(part));
      }, [glb.times[key], parts]);
      parts.forEach((part, i) => {
        for (const [x, y, z] of [[0, 0, 0], [100, 0, 0], [0, 100, 0]]) {
          const m = poses[i];
          const here = [0, 1, 2].map((row) => m[row] * x + m[row + 4] * y + m[row + 8] * z + m[row + 12]);
          const [right, up, back] = glb.place(part, key, [x, y, z]).map((metres) => 1000 * metres);
          worst = Math.max(worst, Math.hypot(here[0] - right, here[1] + back, here[2] - up));
        }
      });
    }
    // Both round axis values to single precision, and keys may differ by what is allowed off the path.
    assert.ok(worst < 0.05, `${scene}: ${worst} mm apart`);
    assert.ok(glb.times.length > 100 && parts.length > 5);
    await page.context().close();
  }
});

test("a program of thousands of lines scrubs smoothly", { skip: !existsSync(LARGE) && "scripts/real-scenes has not been run" }, async (t) => {
  const made = viewPage(LARGE);
  const { page, faults } = await openView(made.path);
  const found = await page.evaluate(async () => {
    const view = window.bvbench[0];
    const frames = 120;
    const start = performance.now();
    let scripts = 0;
    const paint = view.paint.bind(view);
    view.paint = () => {
      const before = performance.now();
      paint();
      scripts += performance.now() - before;
    };
    for (let i = 0; i < frames; i++) {
      view.go((((i * 37) % frames) / frames) * (view.motion.keys - 1));
      await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    }
    const seconds = (performance.now() - start) / 1000;
    return { lines: view.data.program.lines.length, keys: view.motion.keys, fps: frames / seconds, script_ms: scripts / frames };
  });
  t.diagnostic(`${found.lines} lines, ${found.keys} keys, ${(made.bytes / 1e6).toFixed(1)} MB: ${found.fps.toFixed(0)} frames per second ` +
    `without a graphics card, ${found.script_ms.toFixed(1)} ms of script a frame`);
  assertNotBlank(await shot(page, "view-large"), "the large program");
  assert.ok(found.lines > 4000);
  assert.deepEqual(faults, []);
  await page.context().close();
});
