// Puts the page together.

import { StoredRun, frameAt, readAbout } from "./data.js";
import type { RunData } from "./data.js";
import { byId, element } from "./dom.js";
import { pullBodies } from "./drag.js";
import { LivePlayer, LiveRun } from "./live.js";
import { ReplayPlayer } from "./player.js";
import { readMeshes } from "./meshes.js";
import type { Triangles } from "./meshes.js";
import { Plot, plotsOf } from "./plots.js";
import { SceneView } from "./scene.js";
import type { SceneOptions } from "./scene.js";
import { showSummary } from "./summary.js";
import { currentTheme, setTheme } from "./theme.js";
import { Controls } from "./ui.js";

const OPTIONS: SceneOptions = {
  bodies: true,
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

/** Shows a run; every view reads it through `RunData`. */
function open(run: RunData, meshes: (Triangles | null)[]): void {
  const options = { ...OPTIONS };
  const preferred = matchMedia("(prefers-color-scheme: dark)");
  let dark = preferred.matches;
  setTheme(dark);

  const player = run instanceof LiveRun ? new LivePlayer(run, () => update()) : new ReplayPlayer(run, () => update());
  const seek = (frame: number) => player.seek(frame);
  const scene = new SceneView(byId("scene"), byId("axes"), run, options, meshes);
  const plots = plotsOf(run).map((spec) => new Plot(byId("plots"), spec, run, seek));
  const applyTheme = () => {
    setTheme(dark);
    const theme = currentTheme();
    scene.setTheme(theme);
    plots.forEach((plot) => plot.setTheme(theme));
  };
  const controls = new Controls(run, player, options, plots, {
    optionsChanged: () => scene.show(player.frame),
    fit: () => scene.fit(),
    look: (view) => scene.look(view),
    toggleTheme: () => {
      dark = !dark;
      applyTheme();
    },
  });
  const update = () => {
    controls.update();
    if (run.frames === 0) return;
    scene.show(player.frame);
    plots.forEach((plot) => plot.show(player.frame));
  };

  showSummary(run, seek);
  applyTheme();
  player.seek(frameAt(run, timeInAddress()));
  showNames(scene);
  preferred.addEventListener("change", (event) => {
    dark = event.matches;
    applyTheme();
  });
  if (run instanceof LiveRun) pullBodies(byId("scene"), scene, run);
  const refresh = run instanceof LiveRun ? refresher(run, () => {
    plots.forEach((plot) => plot.refresh());
    controls.markMissed();
    scene.rescale();
    showSummary(run, seek);
  }) : () => {};
  const animate = (clock: number) => {
    player.tick(clock);
    refresh(clock);
    scene.render();
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

/** The time asked for by an address that ends in #t=1.5, in s. */
function timeInAddress(): number {
  return Number(new URLSearchParams(location.hash.slice(1)).get("t")) || 0;
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
Promise.all([loading, readMeshes(about.meshes, document)]).then(([run, meshes]) => open(run, meshes)).catch((error: unknown) => {
  const failure = byId("failure");
  failure.hidden = false;
  failure.textContent = `This run cannot be shown: ${error instanceof Error ? error.message : error}`;
  throw error;
});
