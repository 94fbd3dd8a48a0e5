// Controls: transport, toggles with the legend, readings of the current frame, keyboard.

import { MODES, RESIDUALS } from "./data.js";
import type { RunData } from "./data.js";
import { byId, element } from "./dom.js";
import { integer, number, seconds } from "./format.js";
import type { Player } from "./player.js";
import type { Plot } from "./plots.js";
import { VIEWS } from "./scene.js";
import type { SceneOptions } from "./scene.js";

const SPEEDS = [0.01, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const ICONS = {
  play: "M7 4.5v15l13-7.5z",
  pause: "M6 4.5h4.5v15H6zM13.5 4.5H18v15h-4.5z",
  back: "M7 5h2.5v14H7zM20 5v14l-9.5-7z",
  forward: "M14.5 5H17v14h-2.5zM4 5v14l9.5-7z",
  loop: "M17 3l4 4-4 4V8H8a4 4 0 0 0-4 4H2a6 6 0 0 1 6-6h9zM7 21l-4-4 4-4v3h9a4 4 0 0 0 4-4h2a6 6 0 0 1-6 6H7z",
  reset: "M12 5V1L6 6l6 5V7a6 6 0 1 1-6 6H4a8 8 0 1 0 8-8z",
  fit: "M4 9V4h5v2H6v3zM15 4h5v5h-2V6h-3zM20 15v5h-5v-2h3v-3zM9 20H4v-5h2v3h3z",
  theme: "M12 3a9 9 0 1 0 0 18zM12 1a11 11 0 1 1 0 22 11 11 0 0 1 0-22z",
  help: "M11 17h2v2h-2zM12 4a5 5 0 0 0-5 5h2a3 3 0 1 1 4.6 2.5C12 12.6 11 13.500 11 15.500h2c0-1.200.7-1.700 1.700-2.400A5 5 0 0 0 12 4z",
};

/** The options that are switches, with label and key. */
const SWITCHES: [keyof SceneOptions & string, string, string][] = [
  ["bodies", "Bodies", "1"],
  ["points", "Contact points", "2"],
  ["forces", "Contact forces", "3"],
  ["polygons", "Friction polygons", "4"],
  ["colors", "Colour by mode", "M"],
  ["open", "Open contacts", "5"],
  ["touching", "Collision shapes", "6"],
  ["edges", "Edges", "E"],
  ["seeThrough", "See through", "X"],
  ["follow", "Follow", "C"],
];

export interface Actions {
  optionsChanged: () => void;
  fit: () => void;
  /** Looks from a place of `VIEWS`. */
  look: (view: keyof typeof VIEWS) => void;
  /** Looks through a camera of the model. */
  lookThrough: (camera: number) => void;
  toggleTheme: () => void;
}

export class Controls {
  private readonly slider = element("input", { type: "range", id: "slider", min: "0", step: "1" });
  private readonly clock = element("div", { id: "clock" });
  private readonly playButton = button("play", "Play (space)", "play");
  private readonly loopButton = button("loop", "Repeat (L)", "loop");
  private readonly help = byId("help");
  private readonly boxes = new Map<string, HTMLInputElement>();
  private readonly modeCounts = MODES.map(() => element("b", {}, "0"));
  private readonly readings = new Map<string, HTMLElement>();
  private readonly speed = element("select", { id: "speed", title: "Speed" });
  private readonly marks = element("div", { id: "marks" });

  constructor(
    private readonly run: RunData,
    private readonly player: Player,
    private readonly options: SceneOptions,
    private readonly plots: Plot[],
    private readonly actions: Actions,
  ) {
    this.buildTransport();
    this.buildShow();
    this.buildNow();
    this.buildHelp();
    addEventListener("keydown", (event) => this.key(event));
  }

  /** Takes up the player's frame. */
  update(): void {
    const { run, player } = this;
    document.body.dataset.frame = String(player.frame);
    if (run.frames === 0) return;
    const frame = player.frame;
    const { timestep, tolerance } = run.about.header;
    this.slider.max = String(run.frames - 1);
    this.slider.value = String(frame);
    const total = seconds(run.time(run.frames - 1), timestep);
    this.clock.replaceChildren(`${seconds(run.time(frame), timestep)} `, element("span", {}, `/ ${total} s`));
    setIcon(this.playButton, player.playing ? "pause" : "play");
    this.playButton.ariaLabel = player.playing ? "Pause (space)" : "Play (space)";
    this.loopButton.ariaPressed = String(player.loop ?? false);
    if (document.activeElement !== this.speed) this.speed.value = String(player.speed);
    const counts = MODES.map(() => 0);
    for (const contact of run.contacts(frame)) counts[contact.mode]++;
    this.modeCounts.forEach((count, mode) => (count.textContent = integer(counts[mode])));
    const worst = Math.max(...RESIDUALS.map((_, law) => run.residual(frame, law)));
    this.read("step", integer(run.step(frame)));
    this.read("contacts", integer(run.contactCount(frame)));
    this.read("iterations", integer(run.iterations(frame)));
    this.read("residual", number(worst, 2), !(worst <= tolerance));
  }

  /** Marks the steps that missed their tolerance; called again, takes up frames that have come since. */
  markMissed(): void {
    const { run } = this;
    const missed = Array.from({ length: run.frames }, (_, frame) => frame).filter((frame) => run.missed(frame));
    this.marks.replaceChildren(...missed.map((frame) => {
      const mark = element("i", { title: "missed its tolerance" });
      mark.style.left = `${(100 * frame) / Math.max(run.frames - 1, 1)}%`;
      return mark;
    }));
  }

  private read(name: string, text: string, bad = false): void {
    const reading = this.readings.get(name)!;
    reading.textContent = text;
    reading.className = bad ? "bad" : "";
  }

  private buildTransport(): void {
    const { player } = this;
    const back = button("back", "One frame back (←)", "back");
    const forward = button("forward", "One frame on (→)", "forward");
    const fit = button("fit", "Fit the view (F)", "fit");
    const theme = button("theme", "Light or dark (T)", "theme");
    const help = button("help-button", "Keys (?)", "help");
    const reset = button("reset", "Back to the start (R)", "reset");
    this.slider.ariaLabel = "Time";
    this.slider.addEventListener("input", () => player.seek(Number(this.slider.value)));
    this.playButton.addEventListener("click", () => player.toggle());
    this.loopButton.addEventListener("click", () => this.toggleLoop());
    back.addEventListener("click", () => player.stepBy(-1));
    forward.addEventListener("click", () => player.stepBy(1));
    reset.addEventListener("click", () => player.reset?.());
    fit.addEventListener("click", () => this.actions.fit());
    theme.addEventListener("click", () => this.actions.toggleTheme());
    help.addEventListener("click", () => (this.help.hidden = !this.help.hidden));
    for (const speed of SPEEDS) {
      this.speed.append(element("option", { value: String(speed), selected: speed === 1 }, `${speed}×`));
    }
    this.speed.addEventListener("change", () => (player.speed = Number(this.speed.value)));
    this.markMissed();
    const timeline = element("div", { id: "timeline" }, this.marks, this.slider);
    byId("transport").append(
      ...(player.reset ? [reset] : []), back, this.playButton, forward, timeline, this.clock, this.speed,
      ...(player.loop === undefined ? [] : [this.loopButton]), fit, theme, help,
    );
  }

  private buildShow(): void {
    const show = byId<HTMLDetailsElement>("show");
    show.open = innerWidth > 860;
    const ofScene = element("div", { className: "of-scene" });
    show.append(ofScene);
    for (const [name, label, key] of SWITCHES) {
      const box = element("input", { type: "checkbox", checked: Boolean(this.options[name]) });
      box.addEventListener("change", () => this.setOption(name, box.checked));
      this.boxes.set(name, box);
      const swatch = name === "forces" ? [element("i", { className: "swatch" })] : [];
      ofScene.append(element("label", {}, box, label, ...swatch, element("kbd", {}, key)));
    }
    const scale = element("input", { type: "range", id: "force-scale", min: "-1", max: "1", step: "0.01", value: "0" });
    scale.addEventListener("input", () => {
      this.options.scale = 10 ** Number(scale.value);
      this.actions.optionsChanged();
    });
    const logarithmic = element("input", { type: "checkbox", checked: this.options.logarithmic });
    logarithmic.addEventListener("change", () => this.setOption("logarithmic", logarithmic.checked));
    this.boxes.set("logarithmic", logarithmic);
    ofScene.append(
      element("hr"),
      element("label", { className: "scale" }, "Force scale", scale),
      element("label", { className: "logarithmic" }, logarithmic, "Logarithmic", element("kbd", {}, "G")),
      element("hr"),
      element("label", { className: "camera" }, "Camera", this.cameraSelect()),
      element("hr"),
    );
    for (const { spec, figure } of this.plots) {
      const box = element("input", { type: "checkbox", checked: true, id: `toggle-${spec.id}` });
      box.addEventListener("change", () => (figure.hidden = !box.checked));
      show.append(element("label", {}, box, `Plot: ${spec.title.toLowerCase()}`));
    }
    show.append(element("hr"));
    MODES.forEach((mode, k) => {
      const dot = element("i");
      dot.style.background = `var(--mode-${k})`;
      show.append(element("div", { className: "mode" }, dot, mode, this.modeCounts[k]));
    });
  }

  /** Places to look from, and bodies to go along with. */
  private cameraSelect(): HTMLSelectElement {
    const views = Object.keys(VIEWS).map((view) => element("option", { value: `view ${view}` }, `from the ${view}`));
    const bodies = this.run.about.header.bodies.slice(1).map(
      (name, i) => element("option", { value: `body ${i + 1}` }, `with ${name}`),
    );
    const cameras = (this.run.about.header.cameras ?? []).map(
      ({ name }, i) => element("option", { value: `camera ${i}` }, `camera ${name}`),
    );
    const select = element("select", { id: "camera" }, ...views, ...cameras, ...bodies);
    select.addEventListener("change", () => {
      const [sort, value] = select.value.split(" ");
      this.options.followed = sort === "body" ? Number(value) : 0;
      this.setOption("follow", sort === "body");
      if (sort === "camera") this.actions.lookThrough(Number(value));
      else if (sort === "view") this.actions.look(value as keyof typeof VIEWS);
      else this.actions.fit();
    });
    return select;
  }

  private buildNow(): void {
    for (const name of ["step", "contacts", "iterations", "residual"]) {
      const reading = element("dd");
      this.readings.set(name, reading);
      byId("now").append(element("div", {}, element("dt", {}, name), reading));
    }
  }

  private buildHelp(): void {
    const keys = [
      ["space", "play or pause"], ["← →", "one frame"], ["⇧ ← →", "ten frames"], ["home end", "start, end"],
      ["− +", "slower, faster"], this.player.reset ? ["R", "back to the start"] : ["L", "repeat"], ["F", "fit the view"], ["T", "light or dark"],
      ...SWITCHES.map(([, label, key]) => [key, label.toLowerCase()]), ["G", "logarithmic forces"],
      ["?", "this list"],
      ...(this.player.reset ? [["drag", "pull a body"], ["⇧ drag", "move the camera"]] : []),
    ];
    for (const [key, meaning] of keys) {
      this.help.append(element("div", {}, element("kbd", {}, key), meaning));
    }
  }

  private setOption(name: string, value: boolean): void {
    Object.assign(this.options, { [name]: value });
    this.boxes.get(name)!.checked = value;
    this.actions.optionsChanged();
  }

  private toggleLoop(): void {
    if (this.player.loop === undefined) return;
    this.player.loop = !this.player.loop;
    this.update();
  }

  private changeSpeed(by: number): void {
    const next = by > 0
      ? SPEEDS.find((speed) => speed > this.player.speed)
      : [...SPEEDS].reverse().find((speed) => speed < this.player.speed);
    if (next === undefined) return;
    this.player.speed = next;
    this.speed.value = String(next);
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
    const stride = event.shiftKey ? 10 : 1;
    const actions: Record<string, () => void> = {
      " ": () => this.player.toggle(),
      ArrowLeft: () => this.player.stepBy(-stride),
      ArrowRight: () => this.player.stepBy(stride),
      Home: () => this.player.seek(0),
      End: () => this.player.seek(this.run.frames - 1),
      "-": () => this.changeSpeed(-1),
      "+": () => this.changeSpeed(1),
      "=": () => this.changeSpeed(1),
      l: () => this.toggleLoop(),
      r: () => this.player.reset?.(),
      f: () => this.actions.fit(),
      t: () => this.actions.toggleTheme(),
      g: () => this.setOption("logarithmic", !this.options.logarithmic),
      "?": () => (this.help.hidden = !this.help.hidden),
    };
    for (const [name, , key] of SWITCHES) {
      actions[key.toLowerCase()] = () => this.setOption(name, !this.options[name]);
    }
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}

function button(id: string, label: string, icon: keyof typeof ICONS): HTMLButtonElement {
  const made = element("button", { id, type: "button", title: label, ariaLabel: label });
  setIcon(made, icon);
  return made;
}

function setIcon(target: HTMLElement, icon: keyof typeof ICONS): void {
  if (target.dataset.icon === icon) return;
  target.dataset.icon = icon;
  target.innerHTML = `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${ICONS[icon]}"/></svg>`;
}
