// Bundles the page into one HTML file with markers (@@TITLE@@, @@ABOUT@@, @@MESHES@@, @@DATA@@) that the
// Rust crate `signorini-recording` fills in. `node build.mjs` writes crates/recording/assets/report.html.

import { readFile, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));

const bundle = await build({
  entryPoints: [here("src/main.ts")],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "inline",
  write: false,
});
const styles = await build({ entryPoints: [here("src/style.css")], minify: true, write: false });
const licence = await readFile(here("node_modules/three/LICENSE"), "utf8");

// Inside a script element the text must not close it.
const script = bundle.outputFiles[0].text.replaceAll("</script", "<\\/script");
const parts = {
  "<!-- licence -->": `<!--\nThis page contains three.js (https://threejs.org):\n\n${licence.trim()}\n-->`,
  "/* style */": styles.outputFiles[0].text.trim(),
  "/* script */": script.trim(),
};
let page = await readFile(here("src/page.html"), "utf8");
for (const [marker, text] of Object.entries(parts)) {
  if (page.split(marker).length !== 2) throw new Error(`page.html must hold ${marker} once`);
  page = page.replace(marker, () => text);
}
for (const marker of ["@@TITLE@@", "@@ABOUT@@", "@@MESHES@@", "@@DATA@@"]) {
  if (page.split(marker).length !== 2) throw new Error(`the page must hold ${marker} once`);
}
const target = here("../crates/recording/assets/report.html");
// A page that is the same stays untouched: cargo compiles what holds it by its time.
if ((await readFile(target, "utf8").catch(() => "")) !== page) await writeFile(target, page);
console.log(`${target}: ${(page.length / 1024).toFixed(0)} KiB`);
