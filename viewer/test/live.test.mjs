// Opens `signorini view` in headless Chromium and uses it with mouse and keys.
//
// What the page shows is compared with the frames that come over its websocket, read here from the layout alone.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";
import { drawnShare, openBrowser, pixelsOfColor, program } from "./support.mjs";

const TIMESTEP = 0.005;
// Nothing else on the page is of this colour; shading leaves the hue.
const BOX_RED = "rgb(200, 20, 20)";
const MODEL = `<mujoco model="box and wall">
  <option timestep="${TIMESTEP}" gravity="0 0 -10"/>
  <worldbody>
    <geom name="floor" type="plane" friction="0.6"/>
    <body name="box" pos="0 0 0.2">
      <freejoint/>
      <geom type="box" size="0.2 0.2 0.2" mass="2" friction="0.6" rgba="0.85 0.04 0.04 1"/>
    </body>
    <body name="ball" pos="0.8 0.9 0.15"><freejoint/><geom size="0.15" mass="1" rgba="0.4 0.5 0.6 1"/></body>
  </worldbody>
</mujoco>`;

let server;
let browser;
let page;
let address;
const problems = [];
const requests = [];
/** the frames that came, latest last: step and poses */
const frames = [];

function readFrame(message) {
  const length = message.readUInt32LE(0);
  const { arrays } = JSON.parse(message.subarray(4, 4 + length).toString());
  const at = (name) => {
    const { type, offset, length: count } = arrays.find((array) => array.name === name);
    const read = type === "f64" ? (k) => message.readDoubleLE(k) : (k) => message.readFloatLE(k);
    return Array.from({ length: count }, (_, k) => read(4 + length + offset + k * (type === "f64" ? 8 : 4)));
  };
  return { step: at("step")[0], time: at("time")[0], poses: at("poses"), residuals: at("residuals") };
}

/** Serves a model, at rest: the process and the address of its page. */
async function view(text) {
  const model = join(mkdtempSync(join(tmpdir(), "signorini-live-")), "model.xml");
  writeFileSync(model, text);
  const process = spawn(program("signorini"), ["view", model, "--paused", "--no-open", "--json"], { stdio: ["ignore", "pipe", "inherit"] });
  const line = await new Promise((resolve) => createInterface(process.stdout).once("line", resolve));
  return [process, JSON.parse(line).address];
}

before(async () => {
  [server, address] = await view(MODEL);
  browser = await openBrowser();
  page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "light" });
  page.on("pageerror", (error) => problems.push(error.message));
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  page.on("request", (request) => requests.push(request.url()));
  page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => {
    if (typeof payload !== "string") frames.push(readFrame(payload));
  }));
  await page.goto(address);
  await page.waitForSelector("body[data-frame]");
});

after(async () => {
  await browser?.close();
  server?.kill();
});

const latest = () => frames.at(-1);
const boxPosition = () => latest().poses.slice(7, 10);
const reading = (k) => page.locator("#now dd").nth(k).textContent();
const state = () => page.locator("#state").textContent();

/** Presses play or pause where that is needed. */
async function setRunning(running) {
  const word = running ? "live" : "paused";
  if (!(await state()).startsWith(word)) await page.locator("#play").click();
  await until(word, async () => (await state()).startsWith(word));
}

/** The last frame's step, when no frame is under way any more. */
async function settled() {
  for (;;) {
    const { step } = latest();
    await page.waitForTimeout(300);
    if (latest().step === step) return step;
  }
}

/** Waits until something holds. */
async function until(what, holds, patience = 60000) {
  const end = Date.now() + patience;
  while (!(await holds())) {
    assert.ok(Date.now() < end, `never: ${what}`);
    await page.waitForTimeout(30);
  }
}

test("nothing is served without the token", async () => {
  const { origin } = new URL(address);
  for (const path of ["/", "/report.html", `/${"0".repeat(32)}/`, `/${"0".repeat(32)}/socket`]) {
    assert.equal((await fetch(origin + path)).status, 403, path);
  }
  assert.equal((await fetch(address)).status, 200);
});

test("the page shows the start and waits", async () => {
  assert.ok((await drawnShare(page, "#scene")) > 0.2);
  assert.ok((await pixelsOfColor(page, BOX_RED, 90)).count > 1500);
  assert.equal(await state(), "paused");
  assert.deepEqual([latest().step, latest().time], [0, 0]);
  await page.waitForTimeout(300);
  assert.equal(frames.length, 1);
});

test("a step is one step, with its contacts", async () => {
  await page.keyboard.press("ArrowRight");
  await until("contacts of the first step", async () => (await reading(1)) === "5");
  assert.deepEqual([await reading(0), await page.locator("#slider").getAttribute("max")], ["0", "0"]);
  await page.locator("#forward").click();
  await until("the second step", async () => (await reading(0)) === "1");
  assert.equal(latest().time, TIMESTEP);
  await page.keyboard.press("Shift+ArrowRight");
  await until("ten steps at once", async () => (await reading(0)) === "11");
  assert.ok(Math.max(...latest().residuals) < 1e-9);
});

test("contact points, forces, polygons and modes are drawn, each with its switch", async () => {
  for (const [keys, key, color] of [["24", "3", "--force"], ["23", "4", "--mode-1"], ["34", "2", "--mode-1"], ["3", "m", "--mode-1"]]) {
    for (const other of keys) await page.keyboard.press(other);
    const shown = (await pixelsOfColor(page, color)).count;
    await page.keyboard.press(key);
    const hidden = (await pixelsOfColor(page, color)).count;
    await page.keyboard.press(key);
    for (const other of keys) await page.keyboard.press(other);
    assert.ok(shown > 30, `${key}: ${shown} pixels of ${color}`);
    assert.ok(hidden < shown / 4, `${key}: ${hidden} pixels of ${color} remain of ${shown}`);
  }
});

test("it runs with the clock, at the speed chosen, and pauses", async () => {
  // The machine may be too slow for the speed asked for, and frames may come late; ahead of the clock they never are.
  for (const speed of [1, 0.05]) {
    await setRunning(false);
    await page.selectOption("#speed", String(speed));
    await settled();
    const [begin, from] = [performance.now(), latest().time];
    await setRunning(true);
    await until(`half a second of the clock at ${speed}×`, () => latest().time - from > 0.5 * speed);
    for (let looks = 0; looks < 10; looks++) {
      const simulated = latest().time - from;
      const elapsed = (performance.now() - begin) / 1000;
      assert.ok(simulated < speed * elapsed + TIMESTEP, `${simulated} s in ${elapsed} s at ${speed}×`);
      await page.waitForTimeout(100);
    }
  }
  await page.selectOption("#speed", "1");
  await setRunning(false);
  const step = await settled();
  await page.waitForTimeout(300);
  assert.equal(latest().step, step);
});

test("plots draw what came, and can be hidden", async () => {
  for (const name of ["energy", "contacts", "residuals", "iterations"]) {
    assert.ok((await drawnShare(page, `#plot-${name} canvas`)) > 0.01, name);
  }
  for (const name of ["energy", "residuals"]) {
    await page.locator(`#toggle-${name}`).uncheck();
    assert.ok(!(await page.locator(`#plot-${name}`).isVisible()));
    await page.locator(`#toggle-${name}`).check();
    assert.ok(await page.locator(`#plot-${name}`).isVisible());
  }
});

test("the frames that were can be looked at while it stands", async () => {
  await setRunning(false);
  await settled();
  const end = Number(await page.evaluate(() => document.body.dataset.frame));
  await page.locator("#slider").focus();
  await page.keyboard.press("Home");
  assert.equal(await page.evaluate(() => document.body.dataset.frame), "0");
  await page.keyboard.press("End");
  assert.equal(Number(await page.evaluate(() => document.body.dataset.frame)), end);
});

test("a body follows the mouse, and is free when let go", async () => {
  await page.selectOption("#camera", "view front");
  const [x0, y0, z0] = boxPosition();
  const seen = await pixelsOfColor(page, BOX_RED, 90);
  await setRunning(true);
  await page.mouse.move(seen.x, seen.y);
  await page.mouse.down();
  await page.mouse.move(seen.x + 60, seen.y - 100, { steps: 2 });
  await page.mouse.move(seen.x + 120, seen.y - 220, { steps: 3 });
  // From the front x is to the right and z up.
  await until("the box follows", () => boxPosition()[0] > x0 + 0.1 && boxPosition()[2] > z0 + 0.2);
// It was taken at its front, 0.2 m before its middle, and hangs from there.
  assert.ok(Math.abs(boxPosition()[1] - y0) < 0.25, `${boxPosition()}`);
  const red = await pixelsOfColor(page, BOX_RED, 90);
  assert.ok(red.x > seen.x + 30 && red.y < seen.y - 20, `the box is drawn at ${red.x}, ${red.y}`);
  if (process.env.SCREENSHOTS) await page.screenshot({ path: join(process.env.SCREENSHOTS, "drag.png") });
  await page.mouse.up();
  await until("the box falls", () => Math.abs(boxPosition()[2] - 0.2) < 0.05);
  await setRunning(false);
});

test("the camera turns beside bodies, and with Shift", async () => {
  await setRunning(true);
  await page.keyboard.press("r");
  await until("a box at rest", () => latest().time > 0.2 && boxPosition().every((x, i) => Math.abs(x - [0, 0, 0.2][i]) < 1e-6));
  const { poses } = latest();
  const before = await page.locator("#scene").screenshot();
  const seen = await pixelsOfColor(page, BOX_RED, 90);
  await page.keyboard.down("Shift");
  await page.mouse.move(seen.x, seen.y);
  await page.mouse.down();
  await page.mouse.move(seen.x + 150, seen.y - 60, { steps: 3 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  await page.waitForTimeout(400);
  assert.notDeepEqual(await page.locator("#scene").screenshot(), before);
  latest().poses.slice(7, 10).forEach((x, i) => assert.ok(Math.abs(x - poses[7 + i]) < 1e-3, "the box stays"));
  await setRunning(false);
});

test("reset goes back to the start, also after steps", async () => {
  await setRunning(false);
  await page.keyboard.press("r");
  await until("the start", () => latest().step === 0 && latest().time === 0);
  assert.deepEqual(boxPosition().map((x) => Math.fround(x)), [0, 0, 0.2].map(Math.fround));
  await until("one frame", async () => (await page.locator("#slider").getAttribute("max")) === "0");
  await page.selectOption("#camera", "view corner");
  await page.keyboard.press("Shift+ArrowRight");
  await until("steps after a reset", async () => (await reading(0)) === "9" && (await reading(1)) === "5");
  if (process.env.SCREENSHOTS) await page.screenshot({ path: join(process.env.SCREENSHOTS, "live.png") });
});

test("a start with shapes inside each other is announced, and that it is no more after a reset", async () => {
  assert.equal(await page.locator("#note").count(), 0);
  const [other, there] = await view(MODEL.replace('pos="0 0 0.2"', 'pos="0 0 0.1"'));
  try {
    const sunk = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    await sunk.goto(there);
    await sunk.waitForSelector("body[data-frame]");
    assert.equal(await sunk.locator("#note").count(), 0);
    await sunk.keyboard.press("ArrowRight");
    const text = await sunk.locator("#note").textContent();
    assert.equal(text, "shapes overlap at the start and are driven apart at no more than 0.25 m/s: 'floor' and 'geom1' by 100.000 mm");
    if (process.env.SCREENSHOTS) await sunk.screenshot({ path: join(process.env.SCREENSHOTS, "note.png") });
    await sunk.keyboard.press("r");
    await sunk.locator("#note").waitFor({ state: "detached" });
    await sunk.close();
  } finally {
    other.kill();
  }
});

test("the end of the simulation is said, and what came stays", async () => {
  assert.deepEqual(problems, []);
  server.kill();
  await until("disconnected", async () => (await state()).startsWith("disconnected"));
  assert.ok((await pixelsOfColor(page, BOX_RED, 90)).count > 1500);
});

test("nothing was fetched from elsewhere", () => {
  const { origin } = new URL(address);
  assert.deepEqual(requests.filter((url) => !url.startsWith(origin) && !/^(data|blob):/.test(url)), []);
});
