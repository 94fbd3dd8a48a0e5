// The page shows the picture that `signorini render` takes, through the same camera of the model.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";
import { openBrowser, pictureDifference, program } from "./support.mjs";

const [WIDTH, HEIGHT] = [640, 480];

/** All simple shapes, two meshes, squares, an image on a box, what only touches, a pane to look through. */
const MODEL = `<mujoco>
  <asset>
    <texture name="squares" type="2d" builtin="checker" rgb1="0.9 0.85 0.7" rgb2="0.4 0.5 0.6"/>
    <texture name="image" type="cube" file="image.bmp"/>
    <material name="squares" texture="squares" texrepeat="1 1" texuniform="true"/>
    <material name="image" texture="image"/>
    <material name="dull" specular="0" rgba="0.8 0.3 0.2 1"/>
    <mesh name="wedge" vertex="0 0 0 0.4 0 0 0.4 0.4 0 0 0.4 0 0 0 0.3 0 0.4 0.3"
      face="0 2 1 0 3 2 0 1 4 3 5 2 0 4 5 0 5 3 1 2 5 1 5 4"/>
  </asset>
  <worldbody>
    <camera name="eye" pos="1.6 -2.4 1.5" xyaxes="0.83 0.55 0 -0.22 0.33 0.92" fovy="40"/>
    <geom type="plane" size="2 2 0.1" material="squares"/>
    <body pos="0 0 0.25"><geom type="sphere" size="0.25" rgba="0.2 0.5 0.9 1"/></body>
    <body pos="0.7 0 0.2" euler="0 0 30"><geom type="box" size="0.2 0.25 0.2" material="image"/></body>
    <body pos="-0.7 0 0.3"><geom type="capsule" size="0.12 0.18" material="dull"/></body>
    <body pos="0 0.8 0.3"><geom type="cylinder" size="0.2 0.3" rgba="0.3 0.7 0.4 1"/></body>
    <body pos="-0.5 -0.6 0.15"><geom type="ellipsoid" size="0.3 0.2 0.15" rgba="0.9 0.8 0.2 1"/></body>
    <body pos="0.3 -0.7 0"><geom type="mesh" mesh="wedge" rgba="0.6 0.4 0.7 1" contype="0" conaffinity="0"/></body>
    <body pos="0.6 0.6 0.3"><geom type="box" size="0.3 0.02 0.3" rgba="0.5 0.8 0.9 0.4"/></body>
    <geom type="box" size="0.5 0.5 0.5" pos="0 0 0.6" group="3" contype="0" conaffinity="0"/>
  </worldbody>
</mujoco>`;

/** A bitmap of 4 × 4 pixels of different colours. */
function bitmap() {
  const [header, row, rows] = [54, 12, 4];
  const bytes = Buffer.alloc(header + row * rows);
  bytes.write("BM");
  for (const [at, value] of [[2, bytes.length], [10, header], [14, 40], [18, 4], [22, rows], [34, row * rows]]) bytes.writeUInt32LE(value, at);
  bytes.writeUInt16LE(1, 26);
  bytes.writeUInt16LE(24, 28);
  for (let k = 0; k < 16; k++) [60 + 12 * k, 250 - 10 * k, k % 2 ? 230 : 40].forEach((x, i) => (bytes[header + 3 * k + i] = x));
  return bytes;
}

test("the page shows the picture that is rendered", async () => {
  const folder = mkdtempSync(join(tmpdir(), "signorini-picture-"));
  const [model, rendered, report] = ["model.xml", "rendered.png", "report.html"].map((name) => join(folder, name));
  writeFileSync(model, MODEL);
  writeFileSync(join(folder, "image.bmp"), bitmap());
  const signorini = program("signorini");
  execFileSync(signorini, ["render", model, "--camera", "eye", "--samples", "1", "--size", `${WIDTH}x${HEIGHT}`, "--out", rendered]);
  execFileSync(signorini, ["simulate", model, "--duration", "0.002", "--report", report]);
  const browser = await openBrowser();
  try {
    const page = await browser.newPage({ viewport: { width: WIDTH, height: HEIGHT }, colorScheme: "light" });
    await page.goto(`${pathToFileURL(report).href}#picture&camera=eye`);
    await page.waitForSelector("body[data-frame]");
    await page.waitForTimeout(500);
    const shown = await page.locator("#scene").screenshot();
    if (process.env.SCREENSHOTS) {
      writeFileSync(join(process.env.SCREENSHOTS, "picture-page.png"), shown);
      writeFileSync(join(process.env.SCREENSHOTS, "picture-rendered.png"), readFileSync(rendered));
    }
    const { far, mean } = await pictureDifference(page, shown, readFileSync(rendered));
    assert.ok(mean < 4 && far < 0.03, `mean ${mean} of 255, ${(100 * far).toFixed(1)} % of the pixels differ by more than 24`);
  } finally {
    await browser.close();
  }
});
