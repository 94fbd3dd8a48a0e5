// Opens the page of `signorini stability --report` in headless Chromium: what closed forms say must be seen there.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";

import { openBrowser, program } from "./support.mjs";

const FRICTION = 0.5;
let browser;
let folder;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), "signorini-stability-"));
  browser = await openBrowser();
});

after(() => browser?.close());

/** Two boxes on a floor under gravity that is turned by an angle, judged; the page. */
async function judged(name, angle, options) {
  const [model, report] = [join(folder, `${name}.xml`), join(folder, `${name}.html`)];
  const box = (x, z) => `<body name="box${x}" pos="${x} 0 ${z}"><freejoint/><geom type="box" size="0.1 0.1 0.1" friction="${FRICTION}"/></body>`;
  writeFileSync(model, `<mujoco model="${name}"><option gravity="${9.81 * Math.sin(angle)} 0 ${-9.81 * Math.cos(angle)}"/>
    <worldbody><geom type="plane" size="5 5 1" friction="${FRICTION}"/>${box(0, 0.1)}${box(1, 0.1)}</worldbody></mujoco>`);
  execFileSync(program("signorini"), ["stability", model, ...options, "--report", report], { stdio: "ignore" });
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  page.problems = [];
  page.on("pageerror", (error) => page.problems.push(error.message));
  page.on("console", (message) => message.type() === "error" && page.problems.push(message.text()));
  page.on("request", (request) => request.url().startsWith("http") && page.problems.push(request.url()));
  await page.goto(pathToFileURL(report).href);
  await page.waitForTimeout(300);
  return page;
}

/** Pixels of the picture near a colour. */
const pixels = (page, colour) => page.evaluate(([r, g, b]) => {
  const canvas = document.getElementById("view");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    count += data[k + 3] > 200 && Math.abs(data[k] - r) + Math.abs(data[k + 1] - g) + Math.abs(data[k + 2] - b) < 30;
  }
  return count;
}, colour);

const picture = (page) => page.evaluate(() => document.getElementById("view").toDataURL());
const table = async (page, title) => {
  const rows = page.locator("table", { hasText: title }).locator("tr");
  return Promise.all((await rows.all()).map((row) => row.locator("td").allTextContents()));
};
const NO_FRICTION_USED = [43, 123, 186];
const ALL_FRICTION_USED = [209, 52, 31];

test("a page of what stays: forces in the colour of the friction they use, margins, nothing that moves", async () => {
  const page = await judged("level", 0, ["--safety", "tilt", "--towards", "1,0,0", "--bodies"]);
  assert.match(await page.locator("#verdict").textContent(), /^stays/);
  assert.ok((await pixels(page, NO_FRICTION_USED)) > 100, "forces are drawn, and use no friction");
  assert.equal(await pixels(page, ALL_FRICTION_USED), 0);
  await page.locator("#forces").uncheck();
  await page.waitForTimeout(200);
  assert.equal(await pixels(page, NO_FRICTION_USED), 0, "forces have a switch");
  const [balance, none] = await table(page, "Margin: tilt");
  const limit = Math.atan(FRICTION) * 180 / Math.PI;
  for (const cell of [balance[1], none[1]]) {
    assert.ok(Math.abs(parseFloat(cell) - limit) < 1e-5 && cell.endsWith(" °"), cell);
  }
  const bodies = await table(page, "What bodies bear");
  // The polygon of friction is narrowest between its corners.
  assert.equal(bodies.length, 2);
  bodies.forEach(([, part]) => assert.ok(Math.abs(Number(part) - FRICTION * Math.cos(Math.PI / 8)) < 1e-6, part));
  assert.equal(await page.locator("#moving").count(), 0);
  assert.deepEqual(page.problems, []);
});

test("near the limit the forces have the colour of friction that is used up, and follow their length", async () => {
  const page = await judged("steep", Math.atan(0.4999), ["--safety", "friction"]);
  assert.ok((await pixels(page, ALL_FRICTION_USED)) > 100);
  const used = await table(page, "Most friction used");
  assert.ok(Number(used[0][1]) > 0.99, `${used[0]}`);
  const drawn = await pixels(page, ALL_FRICTION_USED);
  await page.locator("#length").fill("0.5");
  await page.waitForTimeout(200);
  assert.ok((await pixels(page, ALL_FRICTION_USED)) > 1.5 * drawn);
  const seen = await picture(page);
  await page.mouse.move(400, 400);
  await page.mouse.down();
  await page.mouse.move(520, 420);
  await page.mouse.up();
  await page.waitForTimeout(200);
  assert.notEqual(await picture(page), seen, "the picture turns");
  assert.deepEqual(page.problems, []);
});

test("what must move has its mechanism as an animation", async () => {
  const page = await judged("slides", Math.atan(0.6), []);
  assert.match(await page.locator("#verdict").textContent(), /^must move/);
  const first = await picture(page);
  await page.waitForTimeout(400);
  assert.notEqual(await picture(page), first, "it plays");
  await page.locator("#play").uncheck();
  const at = async (amount) => {
    await page.locator("#slide").fill(amount);
    await page.waitForTimeout(200);
    return picture(page);
  };
  const [still, moved, again] = [await at("0"), await at("1"), await at("0")];
  assert.notEqual(still, moved);
  assert.equal(still, again);
  assert.deepEqual(page.problems, []);
});
