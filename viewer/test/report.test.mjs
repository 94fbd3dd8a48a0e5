// Opens a report in headless Chromium and uses it like a reader would.
//
// The report is that of the Rust example `report`; its closed forms say what must be seen. Set
// CHROMIUM to the browser's path where it is not /usr/bin/chromium.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { drawnShare as share, openBrowser, pixelsOfColor as pixels, program } from "./support.mjs";

const LAST_FRAME = 750;
const BAD_STEP = 214;
let browser;
let page;
let address;
let inlineAddress;
const problems = [];
const requests = [];

before(async () => {
  const folder = mkdtempSync(join(tmpdir(), "signorini-viewer-"));
  const [report, recording, inline] = ["report.html", "run.rec", "inline.html"].map((name) => join(folder, name));
  inlineAddress = pathToFileURL(inline).href;
  execFileSync(program("examples/report"), [report, recording, inline], { stdio: "inherit" });
  address = pathToFileURL(report).href;
  browser = await openBrowser();
  page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "light" });
  page.on("pageerror", (error) => problems.push(error.message));
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  page.on("request", (request) => requests.push(request.url()));
  await page.goto(address);
  await page.waitForSelector("body[data-frame]");
});

after(() => browser?.close());

const frame = () => page.evaluate(() => Number(document.body.dataset.frame));

const drawnShare = (selector) => share(page, selector);
const pixelsOfColor = async (variable) => (await pixels(page, variable)).count;

test("the scene draws, and bodies can be hidden", async () => {
  assert.ok((await drawnShare("#scene")) > 0.2);
  const shown = await page.locator("#scene").screenshot();
  await page.keyboard.press("1");
  await page.waitForTimeout(200);
  assert.notDeepEqual(await page.locator("#scene").screenshot(), shown);
  await page.keyboard.press("1");
});

test("forces and friction polygons are drawn, each with its switch", async () => {
  for (const [key, color] of [["3", "--force"], ["4", "--mode-1"]]) {
    await page.keyboard.press("2");
    const shown = await pixelsOfColor(color);
    await page.keyboard.press(key);
    const hidden = await pixelsOfColor(color);
    await page.keyboard.press(key);
    await page.keyboard.press("2");
    assert.ok(shown > 40, `${color}: ${shown} pixels`);
    assert.ok(hidden < shown / 4, `${color}: ${hidden} pixels remain of ${shown}`);
  }
});

test("contact modes are counted: the block slides between two directions, then rests", async () => {
  const counts = () => page.locator("#show .mode b").allTextContents();
  assert.deepEqual(await counts(), ["0", "16", "0", "4"]);
  await page.keyboard.press("End");
  assert.deepEqual(await counts(), ["0", "21", "0", "0"]);
  await page.keyboard.press("Home");
});

test("playing advances in time with the clock, and stops", async () => {
  await page.selectOption("#transport select", "0.25");
  await page.locator("#scene").click();
  await page.keyboard.press("Space");
  // The clock of the pictures, read where a picture is made: however long one takes, its frame is that of its time.
  const now = () => page.evaluate(() => new Promise((resolve) => {
    requestAnimationFrame((clock) => resolve([clock / 1000, 0.002 * Number(document.body.dataset.frame)]));
  }));
  await page.waitForFunction(() => Number(document.body.dataset.frame) > 10);
  const [clock0, time0] = await now();
  await page.waitForTimeout(1500);
  const [clock1, time1] = await now();
  await page.keyboard.press("Space");
  const ahead = time1 - time0 - 0.25 * (clock1 - clock0);
  assert.ok(Math.abs(ahead) < 2 * 0.002, `${ahead} s ahead of the clock`);
  const stopped = await frame();
  await page.waitForTimeout(300);
  assert.equal(await frame(), stopped);
});

test("slider, keys and plots seek", async () => {
  await page.locator("#slider").fill("300");
  assert.equal(await frame(), 300);
  assert.match(await page.locator("#clock").textContent(), /^0\.600 \/ 1\.500 s$/);
  await page.keyboard.press("ArrowRight");
  assert.equal(await frame(), 301);
  await page.keyboard.press("Shift+ArrowLeft");
  assert.equal(await frame(), 291);
  await page.keyboard.press("End");
  assert.equal(await frame(), LAST_FRAME);
  const plot = await page.locator("#plot-energy canvas").boundingBox();
  const clickAt = async (x) => {
    await page.mouse.click(plot.x + x, plot.y + 40);
    return frame();
  };
  assert.equal(await clickAt(2), 0, "left of the axis is the start");
  assert.equal(await clickAt(plot.width - 2), LAST_FRAME, "right of the axis is the end");
  const [third, half] = [await clickAt(plot.width / 3), await clickAt(plot.width / 2)];
  assert.ok(0 < third && third < half && half < LAST_FRAME);
});

test("the missed step is announced, and leads there", async () => {
  const chip = page.locator("#chips button");
  assert.match(await chip.textContent(), /1 step missed 10⁻⁹, the first is 214/);
  await chip.click();
  assert.equal(await frame(), BAD_STEP);
  assert.equal(await page.locator("#now dd.bad").textContent(), "3×10⁻⁷");
});

test("every plot draws, with the values at the cursor", async () => {
  for (const name of ["energy", "contacts", "residuals", "iterations"]) {
    assert.ok((await drawnShare(`#plot-${name} canvas`)) > 0.01, name);
  }
  await page.keyboard.press("Home");
  const energy = await page.locator("#plot-energy .reading b").allTextContents();
  // Kinetic: block 2.4² / 2. Potential: heights of block, ball and tower times 9.81.
  const potential = 9.81 * (0.06 + 0.9 + 0.1 + 0.3 + 0.5 + 0.7);
  assert.deepEqual(energy.map(Number), [2.88, Number(potential.toPrecision(3)), Number((potential + 2.88).toPrecision(3))]);
});

test("the solver's stages are summed over all steps", async () => {
  const cells = await page.locator("#stages td").allTextContents();
  // 751 frames of three islands, a microsecond for each: the first is solved, the others are held.
  assert.deepEqual(cells, [
    "hold", "2,250", "2,250", "99.7 %",
    "sweeps", "3", "0", "0.133 %",
    "proximal", "3", "3", "0.133 %",
  ]);
});

test("light and dark", async () => {
  const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await background();
  await page.keyboard.press("t");
  assert.notEqual(await background(), light);
  assert.ok((await drawnShare("#scene")) > 0.2);
  await page.keyboard.press("t");
  assert.equal(await background(), light);
});

test("in a page of somebody else's, as in a notebook, the report works in its frame", async () => {
  const around = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "light" });
  around.on("pageerror", (error) => problems.push(error.message));
  await around.goto(inlineAddress);
  const inside = around.frameLocator("iframe");
  await inside.locator("body[data-frame]").waitFor();
  await inside.locator("#scene").click();
  await around.keyboard.press("End");
  assert.equal(await inside.locator("body").getAttribute("data-frame"), String(LAST_FRAME));
  assert.ok((await pixels(around, "--force", 24, inside)).count > 40);
  // It cannot reach what is around it.
  const frame = around.frames().find((candidate) => candidate !== around.mainFrame());
  assert.equal(await frame.evaluate(() => self.origin), "null");
  await around.close();
});

test("nothing failed and nothing was fetched", () => {
  assert.deepEqual(problems, []);
  const outside = requests.filter((url) => url !== address && !/^(data|blob):/.test(url));
  assert.deepEqual(outside, []);
});
