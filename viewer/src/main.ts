// Puts the page together.

import { StoredRun, frameAt } from "./data.js";
import type { RunData } from "./data.js";
import { byId } from "./dom.js";
import { Player } from "./player.js";
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
  open: false,
  scale: 1,
  logarithmic: false,
  seeThrough: false,
  follow: false,
};

/** Shows a run; every view reads it through `RunData`. */
function open(run: RunData): void {
  const options = { ...OPTIONS };
  const preferred = matchMedia("(prefers-color-scheme: dark)");
  let dark = preferred.matches;
  setTheme(dark);

  const player = new Player(run, () => update());
  const seek = (frame: number) => player.seek(frame);
  const scene = new SceneView(byId("scene"), byId("axes"), run, options);
  const plots = plotsOf(run).map((spec) => new Plot(byId("plots"), spec, run, seek));
  const applyTheme = () => {
    setTheme(dark);
    const theme = currentTheme();
    scene.setTheme(theme);
    plots.forEach((plot) => plot.setTheme(theme));
  };
  const controls = new Controls(run, player, options, {
    optionsChanged: () => scene.show(player.frame),
    fit: () => scene.fit(),
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
  const animate = (clock: number) => {
    player.tick(clock);
    scene.render();
    requestAnimationFrame(animate);
  };
  requestAnimationFrame(animate);
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

StoredRun.load(document).then(open).catch((error: unknown) => {
  const failure = byId("failure");
  failure.hidden = false;
  failure.textContent = `This report cannot be shown: ${error instanceof Error ? error.message : error}`;
  throw error;
});
