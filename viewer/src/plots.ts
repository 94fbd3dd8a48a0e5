// Plots over time on a canvas each, with a cursor at the current frame; pressing on a plot seeks.

import { RESIDUALS, frameAt } from "./data.js";
import type { RunData } from "./data.js";
import { integer, number, power } from "./format.js";
import type { Theme } from "./theme.js";

interface Series {
  label: string;
  value: (frame: number) => number;
}

export interface PlotSpec {
  id: string;
  title: string;
  unit: string;
  series: Series[];
  logarithmic: boolean;
  /** drawn as steps from 0 upwards, integers */
  counts: boolean;
  /** a dashed line, such as a tolerance */
  limit: { label: string; value: number } | null;
}

const MARGIN = { left: 52, right: 20, top: 8, bottom: 18 };
/** Smaller values are drawn at the lower edge of a logarithmic plot. */
const SMALLEST = 1e-18;
/** A linear axis spans at least this share of its largest value, so that its labels differ. */
const LEAST_RELATIVE_SPAN = 1e-3;

export function plotsOf(run: RunData): PlotSpec[] {
  const { tolerance } = run.about.header;
  const plain = { logarithmic: false, counts: false, limit: null };
  return [
    {
      ...plain, id: "energy", title: "Energy", unit: "J",
      series: [
        { label: "kinetic", value: (i) => run.kinetic(i) },
        { label: "potential", value: (i) => run.potential(i) },
        { label: "total", value: (i) => run.kinetic(i) + run.potential(i) },
      ],
    },
    {
      ...plain, id: "contacts", title: "Contacts", unit: "", counts: true,
      series: [
        { label: "candidates", value: (i) => run.contactCount(i) },
        { label: "pressing", value: (i) => run.pressing(i) },
      ],
    },
    {
      ...plain, id: "residuals", title: "Residuals", unit: "", logarithmic: true,
      limit: tolerance > 0 ? { label: "tolerance", value: tolerance } : null,
      series: RESIDUALS.map((label, law) => ({ label, value: (i) => run.residual(i, law) })),
    },
    {
      ...plain, id: "iterations", title: "Solver iterations", unit: "", counts: true,
      series: [{ label: "per step", value: (i) => run.iterations(i) }],
    },
  ];
}

/** Range of the vertical axis, and its tick marks. */
interface Axis {
  low: number;
  high: number;
  ticks: number[];
}

export class Plot {
  readonly figure = document.createElement("figure");
  private readonly canvas = document.createElement("canvas");
  private readonly readings: HTMLElement[] = [];
  private readonly background = document.createElement("canvas");
  private axis: Axis = { low: 0, high: 1, ticks: [] };
  private theme: Theme | null = null;
  private frame = 0;

  constructor(
    parent: HTMLElement,
    readonly spec: PlotSpec,
    private readonly run: RunData,
    seek: (frame: number) => void,
  ) {
    const { figure } = this;
    figure.className = "plot";
    figure.id = `plot-${spec.id}`;
    const caption = document.createElement("figcaption");
    const title = document.createElement("span");
    title.className = "plot-title";
    title.textContent = spec.unit ? `${spec.title}, ${spec.unit}` : spec.title;
    caption.append(title);
    spec.series.forEach((series, k) => caption.append(this.legend(series, k)));
    figure.append(caption, this.canvas);
    parent.append(figure);
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(this.frameAtPixel(event.offsetX));
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) seek(this.frameAtPixel(event.offsetX));
    });
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.redraw();
  }

  /** Takes up frames that have come since. */
  refresh(): void {
    if (!this.figure.hidden) this.redraw();
  }

  show(frame: number): void {
    this.frame = frame;
    this.spec.series.forEach((series, k) => {
      const value = series.value(frame);
      this.readings[k].textContent = this.spec.counts ? integer(value) : number(value);
    });
    this.drawCursor();
  }

  private legend(series: Series, k: number): HTMLElement {
    const entry = document.createElement("span");
    entry.className = "reading";
    const dot = document.createElement("i");
    dot.style.background = `var(--series-${k})`;
    const value = document.createElement("b");
    this.readings.push(value);
    entry.append(dot, `${series.label} `, value);
    return entry;
  }

  private get width(): number { return this.canvas.clientWidth - MARGIN.left - MARGIN.right; }
  private get height(): number { return this.canvas.clientHeight - MARGIN.top - MARGIN.bottom; }

  private get times(): [number, number] {
    const [first, last] = [this.run.time(0), this.run.time(this.run.frames - 1)];
    return [first, last > first ? last : first + 1];
  }

  private x(time: number): number {
    const [first, last] = this.times;
    return MARGIN.left + (this.width * (time - first)) / (last - first);
  }

  private y(value: number): number {
    const scaled = this.spec.logarithmic ? Math.log10(Math.max(value, SMALLEST)) : value;
    const share = (scaled - this.axis.low) / (this.axis.high - this.axis.low);
    return MARGIN.top + this.height * (1 - Math.min(Math.max(share, -0.01), 1.01));
  }

  private frameAtPixel(x: number): number {
    const [first, last] = this.times;
    const time = first + ((x - MARGIN.left) / this.width) * (last - first);
    const before = frameAt(this.run, time);
    const after = Math.min(before + 1, this.run.frames - 1);
    return time - this.run.time(before) < this.run.time(after) - time ? before : after;
  }

  /** Draws everything but the cursor, once per size, theme and set of frames. */
  private redraw(): void {
    const theme = this.theme;
    if (!theme || this.canvas.clientWidth === 0 || this.run.frames === 0) return;
    this.axis = axisOf(this.spec, this.run);
    const ratio = devicePixelRatio;
    for (const canvas of [this.canvas, this.background]) {
      canvas.width = Math.round(this.canvas.clientWidth * ratio);
      canvas.height = Math.round(this.canvas.clientHeight * ratio);
    }
    const pen = this.background.getContext("2d")!;
    pen.scale(ratio, ratio);
    pen.font = "11px system-ui, sans-serif";
    this.drawAxes(pen, theme);
    this.drawMissed(pen, theme);
    if (this.spec.limit) this.drawLimit(pen, theme, this.spec.limit.value);
    this.spec.series.forEach((series, k) => this.drawSeries(pen, series, theme.series[k]));
    this.drawCursor();
  }

  private drawAxes(pen: CanvasRenderingContext2D, theme: Theme): void {
    pen.strokeStyle = theme.rule;
    pen.fillStyle = theme.faint;
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const tick of this.axis.ticks) {
      const y = Math.round(this.y(this.spec.logarithmic ? 10 ** tick : tick)) + 0.5;
      line(pen, MARGIN.left, y, MARGIN.left + this.width, y);
      const label = this.spec.logarithmic ? power(tick) : number(tick, 6);
      pen.fillText(label, MARGIN.left - 6, y);
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const [first, last] = this.times;
    for (const tick of niceTicks(first, last, Math.max(2, Math.floor(this.width / 70)))) {
      pen.fillText(`${number(tick)} s`, this.x(tick), MARGIN.top + this.height + 5);
    }
  }

  /** A red line at each step that missed its tolerance. */
  private drawMissed(pen: CanvasRenderingContext2D, theme: Theme): void {
    if (!this.spec.logarithmic) return;
    pen.fillStyle = theme.danger;
    pen.globalAlpha = 0.22;
    for (let frame = 0; frame < this.run.frames; frame++) {
      if (this.run.missed(frame)) pen.fillRect(this.x(this.run.time(frame)) - 1, MARGIN.top, 2, this.height);
    }
    pen.globalAlpha = 1;
  }

  private drawLimit(pen: CanvasRenderingContext2D, theme: Theme, value: number): void {
    pen.strokeStyle = theme.danger;
    pen.setLineDash([5, 4]);
    line(pen, MARGIN.left, this.y(value), MARGIN.left + this.width, this.y(value));
    pen.setLineDash([]);
    pen.fillStyle = theme.danger;
    pen.textAlign = "right";
    pen.textBaseline = "bottom";
    pen.fillText(this.spec.limit!.label, MARGIN.left + this.width - 2, this.y(value) - 2);
  }

  private drawSeries(pen: CanvasRenderingContext2D, series: Series, color: string): void {
    pen.strokeStyle = color;
    pen.fillStyle = color;
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    pen.beginPath();
    let down = false;
    let lastY = 0;
    for (let frame = 0; frame < this.run.frames; frame++) {
      const value = series.value(frame);
      if (!Number.isFinite(value)) {
        down = false;
        continue;
      }
      const [x, y] = [this.x(this.run.time(frame)), this.y(value)];
      if (down && this.spec.counts) pen.lineTo(x, lastY);
      if (down) pen.lineTo(x, y);
      else pen.moveTo(x, y);
      down = true;
      lastY = y;
    }
    pen.stroke();
    if (!this.spec.counts || series !== this.spec.series[0]) return;
    pen.lineTo(this.x(this.times[1]), MARGIN.top + this.height);
    pen.lineTo(this.x(this.times[0]), MARGIN.top + this.height);
    pen.globalAlpha = 0.12;
    pen.fill();
    pen.globalAlpha = 1;
  }

  private drawCursor(): void {
    const theme = this.theme;
    if (!theme || this.background.width === 0 || this.run.frames === 0) return;
    const ratio = devicePixelRatio;
    const pen = this.canvas.getContext("2d")!;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.background, 0, 0);
    pen.scale(ratio, ratio);
    const x = this.x(this.run.time(this.frame));
    pen.strokeStyle = theme.text;
    pen.lineWidth = 1;
    line(pen, x, MARGIN.top, x, MARGIN.top + this.height);
    this.spec.series.forEach((series, k) => {
      const value = series.value(this.frame);
      if (!Number.isFinite(value)) return;
      pen.fillStyle = theme.series[k];
      pen.beginPath();
      pen.arc(x, this.y(value), 3, 0, 2 * Math.PI);
      pen.fill();
    });
  }
}

function line(pen: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number): void {
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

function axisOf(spec: PlotSpec, run: RunData): Axis {
  let [low, high] = [Infinity, -Infinity];
  const include = (value: number) => {
    if (!Number.isFinite(value)) return;
    low = Math.min(low, value);
    high = Math.max(high, value);
  };
  for (const series of spec.series) {
    for (let frame = 0; frame < run.frames; frame++) include(series.value(frame));
  }
  if (spec.counts) include(0);
  if (spec.limit) include(spec.limit.value);
  if (low > high) [low, high] = [0, 1];
  return spec.logarithmic ? logarithmicAxis(low, high) : linearAxis(low, high, spec.counts);
}

function logarithmicAxis(low: number, high: number): Axis {
  const from = Math.floor(Math.log10(Math.max(low, SMALLEST)));
  const to = Math.max(Math.ceil(Math.log10(Math.max(high, SMALLEST)) + 0.2), from + 2);
  const stride = Math.max(1, Math.ceil((to - from) / 4));
  const ticks: number[] = [];
  for (let tick = to; tick >= from; tick -= stride) ticks.push(tick);
  return { low: from, high: to, ticks };
}

function linearAxis(low: number, high: number, counts: boolean): Axis {
  const narrowest = LEAST_RELATIVE_SPAN * Math.max(Math.abs(low), Math.abs(high)) || 1;
  const padding = Math.max(0.06 * (high - low), (narrowest - (high - low)) / 2);
  const axis = { low: counts ? 0 : low - padding, high: high + padding };
  const ticks = niceTicks(axis.low, axis.high, 4).filter((tick) => !counts || Number.isInteger(tick));
  return { ...axis, ticks };
}

/** About `count` round numbers between two values. */
function niceTicks(low: number, high: number, count: number): number[] {
  const raw = (high - low) / count;
  const unit = 10 ** Math.floor(Math.log10(raw));
  const step = unit * ([1, 2, 5, 10].find((factor) => factor * unit >= raw) ?? 10);
  const ticks: number[] = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) ticks.push(k * step);
  return ticks;
}
