// What the whole run amounts to: chips at the top, tables at the side.

import { RESIDUALS, frameOfStep } from "./data.js";
import type { RunData } from "./data.js";
import { byId, element, row } from "./dom.js";
import { integer, number } from "./format.js";

/** Shows the figures; called again, those of the frames that have come since. */
export function showSummary(run: RunData, seek: (frame: number) => void): void {
  const { header } = run.about;
  byId("title").textContent = document.title || header.model_name || "Recording";
  byId("chips").replaceChildren(...chips(run, seek));
  byId("summary").replaceChildren(
    element("h2", {}, "Run"), element("table", {}, ...runRows(run)),
    element("h2", {}, "Worst residuals"), element("table", {}, ...worstRows(run, seek)),
    ...stages(run),
    element("h2", {}, "Model"), element("table", {}, ...modelRows(run)),
  );
}

function chips(run: RunData, seek: (frame: number) => void): HTMLElement[] {
  const { run: figures, ending, stride } = run.about;
  const made = [verdict(run, seek)];
  const { state } = run;
  if (state) made.push(element("span", { className: state.bad ? "chip bad" : "chip", id: "state" }, state.text));
  else if (ending !== null) made.push(element("span", { className: "chip" }, ending));
  else made.push(element("span", { className: "chip bad" }, "the run did not end by itself"));
  if (run.note) made.push(element("span", { className: "chip bad", id: "note" }, run.note));
  if (stride > 1) {
    const text = `shows every ${stride}th of ${integer(figures.frames)} steps`;
    made.push(element("span", { className: "chip" }, text));
  }
  return made;
}

/** Whether every step reached its tolerance; if not, leads to the first that did not. */
function verdict(run: RunData, seek: (frame: number) => void): HTMLElement {
  const { run: figures, header } = run.about;
  if (figures.frames === 0) return element("span", { className: "chip" }, "no step");
  if (figures.missed_steps === 0 && figures.unsolved_steps === 0) {
    const text = `every step certified to ${number(header.tolerance)}`;
    return element("span", { className: "chip good" }, text);
  }
  if (figures.missed_steps === 0 || figures.first_missed_step === null) {
    const text = `${integer(figures.unsolved_steps)} steps not solved (${figures.last_status} at the end)`;
    return element("span", { className: "chip bad" }, text);
  }
  const step = figures.first_missed_step;
  const noun = figures.missed_steps === 1 ? "step" : "steps";
  const text = `${integer(figures.missed_steps)} ${noun} missed ${number(header.tolerance)}, the first is ${integer(step)}`;
  const chip = element("button", { className: "chip bad", title: "Go to that step" }, text);
  chip.addEventListener("click", () => seek(frameOfStep(run, step)));
  return chip;
}

function runRows(run: RunData): HTMLElement[] {
  const { header, run: figures, notes } = run.about;
  const total = ([kinetic, potential]: [number | null, number | null]) =>
    kinetic === null || potential === null ? null : kinetic + potential;
  const duration = figures.last_time - figures.first_time;
  return [
    row("Frames", integer(figures.frames)),
    row("Duration", `${number(duration)} s`),
    row("Step length", `${number(header.timestep)} s`),
    row("Method", header.method || "–"),
    row("Friction directions", integer(header.directions)),
    row("Most contacts", integer(figures.contacts_max)),
    row("Most iterations", integer(figures.iterations_max)),
    row("Energy", `${number(total(figures.energy_start), 5)} → ${number(total(figures.energy_end), 5)} J`),
    ...notes.map(([label, text]) => row(label, text)),
  ];
}

function worstRows(run: RunData, seek: (frame: number) => void): HTMLElement[] {
  return run.about.run.worst.map(({ value, step }, law) => {
    const link = element("button", { title: "Go to that step" }, `step ${integer(step)}`);
    link.addEventListener("click", () => seek(frameOfStep(run, step)));
    const name = RESIDUALS[law];
    const label = name[0].toUpperCase() + name.slice(1);
    return run.about.run.frames === 0 ? row(label, "–") : row(label, `${number(value)} at `, link);
  });
}

/** What the solver's stages did, for runs that tell. */
function stages(run: RunData): HTMLElement[] {
  const sums = run.about.run.stages;
  if (sums.length === 0) return [];
  const all = sums.reduce((sum, stage) => sum + stage.nanoseconds, 0);
  const cells = (tag: "td" | "th", texts: string[]) =>
    element("tr", {}, ...texts.slice(0, all > 0 ? 4 : 3).map((text) => element(tag, {}, text)));
  const rows = sums.map(({ stage, asked, ended, nanoseconds }) => cells("td", [
    run.about.header.stages[stage], integer(asked), integer(ended), `${number((100 * nanoseconds) / all, 3)} %`,
  ]));
  const head = cells("th", ["Stage", "asked", "ended", "of the time"]);
  const title = "How often islands came to each stage of the solver, and how often it ended them";
  return [element("h2", { title }, "Solver"), element("table", { id: "stages" }, head, ...rows)];
}

function modelRows(run: RunData): HTMLElement[] {
  const { header } = run.about;
  return [
    row("Name", header.model_name || "–"),
    row("Bodies", integer(header.bodies.length - 1)),
    row("Geoms", integer(header.geoms.length)),
    row("nq, nv", `${header.nq}, ${header.nv}`),
    row("Gravity", `(${header.gravity.map((x) => number(x)).join(", ")}) m/s²`),
    row("Fingerprint", header.model_hash),
    row("Written by", header.generator),
  ];
}
