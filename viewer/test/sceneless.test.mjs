// Opens a report in a browser without WebGL, and compares what it shows with a browser that has it.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { NO_WEBGL, drawnShare, openBrowser, program } from "./support.mjs";

const browsers = [];
const problems = [];
let [without, beside] = [null, null];

async function openReport(address, graphics) {
  const browser = await openBrowser(graphics);
  browsers.push(browser);
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "light" });
  page.on("pageerror", (error) => problems.push(error.message));
  await page.goto(address);
  await page.waitForSelector("body[data-frame]");
  return page;
}

before(async () => {
  const report = join(mkdtempSync(join(tmpdir(), "signorini-sceneless-")), "report.html");
  execFileSync(program("examples/report"), [report], { stdio: "inherit" });
  const address = pathToFileURL(report).href;
  [without, beside] = [await openReport(address, NO_WEBGL), await openReport(address)];
});

after(() => Promise.all(browsers.map((browser) => browser.close())));

test("where the scene would be stands why it is missing", async () => {
  assert.match(await without.locator("#no-scene").innerText(), /no WebGL.*graphics acceleration/s);
  assert.ok(await without.locator("#failure").isHidden());
  assert.ok(await without.locator("#scene").isHidden() && await without.locator(".of-scene").isHidden());
  assert.ok(await beside.locator("#no-scene").isHidden() && await beside.locator("#scene").isVisible());
});

test("figures are those of a browser with WebGL, frame by frame", async () => {
  const texts = (page) => Promise.all(["#now", "#summary", "#chips", "#clock", "#plots"].map((part) => page.locator(part).innerText()));
  for (const key of ["Home", "Shift+ArrowRight", "ArrowRight", "End"]) {
    for (const page of [without, beside]) await page.keyboard.press(key);
    assert.deepEqual(await texts(without), await texts(beside), key);
  }
});

test("plots draw, and lead to their frames", async () => {
  for (const name of ["energy", "contacts", "residuals", "iterations"]) {
    assert.ok((await drawnShare(without, `#plot-${name} canvas`)) > 0.01, name);
  }
  const plot = await without.locator("#plot-energy canvas").boundingBox();
  await without.mouse.click(plot.x + 2, plot.y + 40);
  assert.equal(await without.locator("body").getAttribute("data-frame"), "0");
});

test("it plays, and no key or control fails", async () => {
  for (const key of ["f", "t", "1", "2", "3", "x", "c", "g", "?"]) await without.keyboard.press(key);
  await without.keyboard.press("Space");
  await without.waitForFunction(() => Number(document.body.dataset.frame) > 10);
  assert.deepEqual(problems, []);
});
