// Puts the page together.

import type { Texture } from "three";
import { StoredRun, frameAt, readAbout } from "./data.js";
import type { RunData } from "./data.js";
import { byId, element } from "./dom.js";
import { pullBodies } from "./drag.js";
import { LivePlayer, LiveRun } from "./live.js";
import { ReplayPlayer } from "./player.js";
import { readImages } from "./looks.js";
import { readMeshes } from "./meshes.js";
import type { Triangles } from "./meshes.js";
import { Plot, plotsOf } from "./plots.js";
import { SceneView, rendererOn } from "./scene.js";
import type { SceneOptions, Sight } from "./scene.js";
import { showSummary } from "./summary.js";
import { currentTheme, setTheme } from "./theme.js";
import { Controls } from "./ui.js";

const OPTIONS: SceneOptions = {
  bodies: true,
  touching: false,
  edges: false,
  points: true,
  forces: true,
  polygons: true,
  colors: true,
  open: false,
  scale: 1,
  logarithmic: false,
  seeThrough: false,
  follow: false,
  followed: 0,
};
/** Plots and figures of a live run are brought up to date this often, ms. */
const REFRESH = 250;

/**
 * Shows a run; every view reads it through `RunData`. An address can end in #t=TIME, camera=NAME or view=x,y,z,qw,qx,qy,qz,angle, and picture, which
 * leaves the scene alone, joined by &.
 */
function open(run: RunData, meshes: (Triangles | null)[], images: Texture[]): void {
  const options = { ...OPTIONS };
  const asked = new URLSearchParams(location.hash.slice(1));
  if (asked.has("picture")) {
    document.body.classList.add("picture");
    Object.assign(options, { points: false, forces: false, polygons: false });
  }
  const preferred = matchMedia("(prefers-color-scheme: dark)");
  let dark = preferred.matches;
  setTheme(dark);

  const player = run instanceof LiveRun ? new LivePlayer(run, () => update()) : new ReplayPlayer(run, () => update());
  const seek = (frame: number) => player.seek(frame);
  const renderer = rendererOn(byId("scene"));
  const scene = renderer && new SceneView(renderer, byId("axes"), run, options, meshes, images);
  if (!scene) sayWhyNoScene();
  const plots = plotsOf(run).map((spec) => new Plot(byId("plots"), spec, run, seek));
  const applyTheme = () => {
    setTheme(dark);
    const theme = currentTheme();
    scene?.setTheme(theme);
    plots.forEach((plot) => plot.setTheme(theme));
  };
  const controls = new Controls(run, player, options, plots, {
    optionsChanged: () => scene?.show(player.frame),
    fit: () => scene?.fit(),
    look: (view) => scene?.look(view),
    lookThrough: (camera) => scene?.lookThrough(camera),
    toggleTheme: () => {
      dark = !dark;
      applyTheme();
    },
  });
  const update = () => {
    controls.update();
    if (run.frames === 0) return;
    scene?.show(player.frame);
    plots.forEach((plot) => plot.show(player.frame));
  };

  showSummary(run, seek);
  applyTheme();
  player.seek(frameAt(run, Number(asked.get("t")) || 0));
  const camera = (run.about.header.cameras ?? []).findIndex(({ name }) => name === asked.get("camera"));
  const sight = sightOf(asked.get("view"));
  if (camera >= 0) scene?.lookThrough(camera);
  else if (sight) scene?.lookFrom(sight);
  if (scene) showNames(scene);
  preferred.addEventListener("change", (event) => {
    dark = event.matches;
    applyTheme();
  });
  if (scene && run instanceof LiveRun) pullBodies(byId("scene"), scene, run);
  const refresh = run instanceof LiveRun ? refresher(run, () => {
    plots.forEach((plot) => plot.refresh());
    controls.markMissed();
    scene?.rescale();
    showSummary(run, seek);
  }) : () => {};
  const animate = (clock: number) => {
    player.tick(clock);
    refresh(clock);
    scene?.render();
    requestAnimationFrame(animate);
  };
  requestAnimationFrame(animate);
}

/** Calls `refresh` when something has come, every now and then, and at once when the run stops or goes on. */
function refresher(run: LiveRun, refresh: () => void): (clock: number) => void {
  let [seen, next, text] = [-1, 0, ""];
  return (clock) => {
    if (run.version === seen || (clock < next && run.state.text === text)) return;
    [seen, next, text] = [run.version, clock + REFRESH, run.state.text];
    refresh();
  };
}

/** A place to look from, as an address has it: x,y,z,qw,qx,qy,qz,angle. */
function sightOf(text: string | null): Sight | null {
  const numbers = (text ?? "").split(",").map(Number);
  return numbers.length === 8 && numbers.every(Number.isFinite) ? (numbers as Sight) : null;
}

/** Figures, plots and the clock need no scene: what is missing beside them is said where it would be. */
function sayWhyNoScene(): void {
  document.body.classList.add("sceneless");
  byId("no-scene").hidden = false;
}

/** Says what is under the pointer. */
function showNames(scene: SceneView): void {
  const canvas = byId("scene");
  const tooltip = byId("tooltip");
  canvas.addEventListener("pointermove", (event) => {
    const text = event.buttons === 0 ? scene.describe(event.offsetX, event.offsetY) : null;
    tooltip.hidden = text === null;
    tooltip.textContent = text;
    tooltip.style.left = `${event.offsetX}px`;
    tooltip.style.top = `${event.offsetY}px`;
  });
  canvas.addEventListener("pointerleave", () => (tooltip.hidden = true));
}

const about = readAbout(document);
// A browser asks a server for an icon unless the page has one.
if (about.live) document.head.append(element("link", { rel: "icon", href: "data:," }));
const loading: Promise<RunData> = about.live ? LiveRun.connect(about) : StoredRun.load(about, document);
const reading = Promise.all([loading, readMeshes(about.meshes, document), readImages(about.header)]);
reading.then(([run, meshes, images]) => open(run, meshes, images)).catch((error: unknown) => {
  const failure = byId("failure");
  failure.hidden = false;
  failure.textContent = `This run cannot be shown: ${error instanceof Error ? error.message : error}`;
  throw error;
});
