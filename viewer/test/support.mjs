// What the tests of the page share. Set CHROMIUM to the browser's path where it is not /usr/bin/chromium.

import { execFileSync } from "node:child_process";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));

const BROWSER_FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
];
/** WebGL without a graphics card. */
const SOFTWARE_WEBGL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
/** What a browser is without WebGL, as on machines whose graphics card it distrusts. */
export const NO_WEBGL = ["--disable-3d-apis"];

/** A program or an example of the workspace, built if it must be. */
export function program(name) {
  const folder = execFileSync(join(ROOT, ".ci/programs"), { stdio: ["ignore", "pipe", "inherit"] }).toString().trim();
  return join(folder, name);
}

export function openBrowser(graphics = SOFTWARE_WEBGL) {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  return chromium.launch({ executablePath, headless: true, args: [...BROWSER_FLAGS, ...graphics] });
}

/** Pixels of an element as the screen has them: how many differ from the most frequent colour. */
export async function drawnShare(page, selector) {
  await page.waitForTimeout(200);
  const png = (await page.locator(selector).screenshot()).toString("base64");
  return page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    const pixels = new Uint32Array(pen.getImageData(0, 0, image.width, image.height).data.buffer);
    const counts = new Map();
    for (const pixel of pixels) counts.set(pixel, (counts.get(pixel) ?? 0) + 1);
    return 1 - Math.max(...counts.values()) / pixels.length;
  }, png);
}

/**
 * The pixels of the scene, in the page or a frame of it, whose colour is close to a colour, the name of a theme variable or one of CSS: how many, and
 * their middle in pixels of the page.
 */
export async function pixelsOfColor(page, color, closeness = 24, inside = page) {
  await page.waitForTimeout(200);
  const png = (await inside.locator("#scene").screenshot()).toString("base64");
  return inside.locator("body").evaluate(async (_, [data, name, closeness]) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const pen = canvas.getContext("2d", { willReadFrequently: true });
    pen.fillStyle = name.startsWith("--") ? getComputedStyle(document.documentElement).getPropertyValue(name) : name;
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b] = pen.getImageData(0, 0, 1, 1).data;
    pen.drawImage(image, 0, 0);
    // The legend with its swatches is on the left.
    const [left, top, width] = [320, 80, image.width - 320];
    const { data: pixels } = pen.getImageData(left, top, width, image.height - 180);
    let [count, x, y] = [0, 0, 0];
    for (let i = 0; i < pixels.length; i += 4) {
      const distance = Math.abs(pixels[i] - r) + Math.abs(pixels[i + 1] - g) + Math.abs(pixels[i + 2] - b);
      if (distance >= closeness) continue;
      count++;
      x += left + ((i / 4) % width);
      y += top + Math.floor(i / 4 / width);
    }
    return { count, x: x / count, y: y / count };
  }, [png, color, closeness]);
}

/**
 * How two PNG files of the same size differ: the mean over pixels of the largest difference of red, green and blue, of 255, and the share of the
 * pixels where it is more than `limit`.
 */
export async function pictureDifference(page, one, other, limit = 24) {
  const texts = [one, other].map((png) => Buffer.from(png).toString("base64"));
  return page.evaluate(async ([texts, limit]) => {
    const [a, b] = await Promise.all(texts.map(async (text) => {
      const image = new Image();
      image.src = `data:image/png;base64,${text}`;
      await image.decode();
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [image.width, image.height];
      const pen = canvas.getContext("2d");
      pen.drawImage(image, 0, 0);
      return pen.getImageData(0, 0, image.width, image.height).data;
    }));
    if (a.length !== b.length) throw new Error("the pictures are not of one size");
    let [sum, far] = [0, 0];
    for (let i = 0; i < a.length; i += 4) {
      const most = Math.max(...[0, 1, 2].map((k) => Math.abs(a[i + k] - b[i + k])));
      sum += most;
      far += most > limit ? 1 : 0;
    }
    return { mean: (4 * sum) / a.length, far: (4 * far) / a.length };
  }, [texts, limit]);
}
