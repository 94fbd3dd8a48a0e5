// A run as the page sees it: the interface that every view reads, and the run embedded in a report.

import { fromColumns, unpack } from "./coding.js";
import type { MeshPlaces } from "./meshes.js";

export type Vec3 = [number, number, number];

export type Shape =
  | { type: "plane" }
  | { type: "sphere"; radius: number }
  | { type: "box"; half_extents: Vec3 }
  | { type: "capsule" | "cylinder"; radius: number; half_length: number }
  | { type: "cone"; radius: number; half_height: number }
  | { type: "ellipsoid"; radii: Vec3 }
  /** its triangles lie apart */
  | { type: "mesh" }
  | { type: "height_field"; half_extents: [number, number]; rows: number; cols: number; heights: number[] };

export interface Geom {
  name: string;
  body: number;
  shape: Shape;
  /** x, y, z, qw, qx, qy, qz in the body's frame */
  pose: number[];
  rgba: [number, number, number, number] | null;
  /** what else its surface looks like; grey plastic where it is not there */
  look?: Look;
}

/** What a surface looks like beside its colour; the shares are 0 to 1. */
export interface Look {
  /** 0 to 2 are shown where nothing else is asked for */
  group: number;
  specular: number;
  shininess: number;
  emission: number;
  checker?: Checker;
  texture?: { image: number; spread: Spread };
}

/** Squares in the x-y plane of a geom, one corner of four at its origin. */
export interface Checker {
  colors: [Vec3, Vec3];
  square: [number, number];
}

/** Where an image is: by the mesh, or with lengths along the axes. */
export type Spread = { corners: [] } | { plane: [number, number] } | { cube: Vec3 };

export interface Light {
  body: number;
  position: Vec3;
  direction: Vec3;
  directional: boolean;
  color: Vec3;
  shadows: boolean;
}

export interface Camera {
  name: string;
  body: number;
  /** x, y, z, qw, qx, qy, qz in the body's frame; it looks along -z */
  pose: number[];
  /** rad, from the lower to the upper edge */
  field_of_view: number;
}

export interface Header {
  model_name: string;
  model_hash: string;
  generator: string;
  nq: number;
  nv: number;
  timestep: number;
  directions: number;
  gravity: Vec3;
  method: string;
  tolerance: number;
  bodies: string[];
  geoms: Geom[];
  /** JPEG files as base64 text */
  images?: string[];
  lights?: Light[];
  cameras?: Camera[];
  /** names of the solver's stages */
  stages: string[];
}

export interface Worst {
  /** null when it is not finite */
  value: number | null;
  step: number;
}

/** What a stage of the solver did in all steps. */
export interface StageSum {
  /** index into the header's names */
  stage: number;
  asked: number;
  ended: number;
  /** 0 where times were not measured */
  nanoseconds: number;
}

/** Figures over every frame of the run, also those that the page does not hold. */
export interface Run {
  frames: number;
  first_time: number;
  last_time: number;
  missed_steps: number;
  first_missed_step: number | null;
  unsolved_steps: number;
  last_status: string;
  worst: Worst[];
  contacts_max: number;
  iterations_max: number;
  stages: StageSum[];
  energy_start: [number | null, number | null];
  energy_end: [number | null, number | null];
}

export interface About {
  header: Header;
  meshes: MeshPlaces;
  run: Run;
  ending: string | null;
  /** steps from one frame of the page to the next */
  stride: number;
  notes: [string, string][];
  /** whether the frames come over a websocket */
  live: boolean;
}

export const RESIDUALS = ["momentum", "natural map", "Signorini", "friction bound", "dissipation"];

export const MODES = ["open", "sticking", "sliding", "between directions"];

/** What a live run does now, in words. */
export interface RunState {
  text: string;
  bad: boolean;
}

/** What a view needs of a run; frames are numbered from 0. A live run may grow. */
export interface RunData {
  readonly about: About;
  readonly frames: number;
  /** of a live run */
  readonly state?: RunState;
  /** of a live run: what the user should know of its start */
  readonly note?: string | null;
  time(frame: number): number;
  step(frame: number): number;
  kinetic(frame: number): number;
  potential(frame: number): number;
  residual(frame: number, law: number): number;
  iterations(frame: number): number;
  contactCount(frame: number): number;
  /** contacts with an impulse */
  pressing(frame: number): number;
  missed(frame: number): boolean;
  /** 7 numbers per body: x, y, z, qw, qx, qy, qz */
  poses(frame: number): Float32Array;
  contacts(frame: number): Contact[];
}

const CONTACT_NUMBERS = 25;
/** Further directions of a polygon are not drawn. */
const MOST_SIDES = 256;

/** One contact; the layout is that of the Rust module `report::payload`. */
export class Contact {
  constructor(
    private readonly numbers: Float32Array,
    private readonly at: number,
    private readonly directions: Float32Array,
  ) {}

  private get(offset: number): number {
    return this.numbers[this.at + offset];
  }
  private vector(offset: number): Vec3 {
    return [this.get(offset), this.get(offset + 1), this.get(offset + 2)];
  }

  get bodyA(): number { return this.get(0); }
  get bodyB(): number { return this.get(1); }
  get geomA(): number { return this.get(2); }
  get geomB(): number { return this.get(3); }
  /** index into MODES */
  get mode(): number { return this.get(4); }
  get directionsOfMode(): [number, number] { return [this.get(5), this.get(6)]; }
  get point(): Vec3 { return this.vector(10); }
  /** from body A to body B */
  get normal(): Vec3 { return this.vector(13); }
  get tangent(): Vec3 { return this.vector(16); }
  get gap(): number { return this.get(19); }
  get friction(): number { return this.get(20); }
  /** N·s, on body B */
  get normalImpulse(): number { return this.get(21); }
  get tangentialImpulse(): [number, number] { return [this.get(22), this.get(23)]; }
  /** sliding speed, m/s */
  get slip(): number { return this.get(24); }

  /** number of directions of the friction polygon */
  get sides(): number { return Math.min(this.get(7), MOST_SIDES); }

  /** The unit directions of the friction polygon in tangent coordinates, by angle. */
  polygon(): [number, number][] {
    const [count, angle, listed] = [this.get(7), this.get(8), this.get(9)];
    const direction = (k: number): [number, number] => {
      if (listed < 0) {
        const a = angle + (2 * Math.PI * k) / count;
        return [Math.cos(a), Math.sin(a)];
      }
      return [this.directions[2 * (listed + k)], this.directions[2 * (listed + k) + 1]];
    };
    const polygon = Array.from({ length: this.sides }, (_, k) => direction(k));
    return listed < 0 ? polygon : polygon.sort((a, b) => Math.atan2(a[1], a[0]) - Math.atan2(b[1], b[0]));
  }
}

export interface ArrayPlace {
  name: string;
  type: "f64" | "f32" | "u32";
  offset: number;
  length: number;
  /** numbers of a row where the array lies column by column, else 0 */
  row: number;
}

/** Frames in one block of numbers, laid out by the Rust module `report::payload`. */
export class Chunk {
  readonly frames: number;
  readonly pressingCounts: number[];
  private readonly arrays = new Map<string, Float64Array | Float32Array | Uint32Array>();

  constructor(places: ArrayPlace[], block: ArrayBuffer, start = 0) {
    const kinds = { f64: Float64Array, f32: Float32Array, u32: Uint32Array };
    for (const { name, type, offset, length, row } of places) {
      const array = row > 0
        ? fromColumns(new Uint8Array(block, start + offset), length, row)
        : new kinds[type](block, start + offset, length);
      this.arrays.set(name, array);
    }
    this.frames = this.array("time").length;
    this.pressingCounts = Array.from(
      { length: this.frames },
      (_, frame) => this.contacts(frame).filter((contact) => contact.mode > 0).length,
    );
  }

  array(name: string): Float64Array | Float32Array | Uint32Array {
    const array = this.arrays.get(name);
    if (!array) throw new Error(`the page's data has no array "${name}"`);
    return array;
  }

  contacts(frame: number): Contact[] {
    const [ends, numbers, directions] = [this.array("contact_ends"), this.array("contacts"), this.array("directions")];
    const start = frame > 0 ? ends[frame - 1] : 0;
    return Array.from(
      { length: ends[frame] - start },
      (_, i) => new Contact(numbers as Float32Array, (start + i) * CONTACT_NUMBERS, directions as Float32Array),
    );
  }
}

/** A run whose frames lie in chunks. */
export abstract class ChunkedRun implements RunData {
  abstract readonly about: About;
  abstract readonly frames: number;
  /** The chunk that holds a frame, and the frame's number in it. */
  protected abstract locate(frame: number): [Chunk, number];

  time(frame: number): number { return this.number("time", frame); }
  step(frame: number): number { return this.number("step", frame); }
  kinetic(frame: number): number { return this.number("kinetic", frame); }
  potential(frame: number): number { return this.number("potential", frame); }
  residual(frame: number, law: number): number { return this.number("residuals", frame, RESIDUALS.length, law); }
  iterations(frame: number): number { return this.number("iterations", frame); }
  contactCount(frame: number): number { return this.number("contact_counts", frame); }
  missed(frame: number): boolean { return this.number("missed", frame) > 0; }

  pressing(frame: number): number {
    const [chunk, i] = this.locate(frame);
    return chunk.pressingCounts[i];
  }

  poses(frame: number): Float32Array {
    const [chunk, i] = this.locate(frame);
    const size = 7 * this.about.header.bodies.length;
    return (chunk.array("poses") as Float32Array).subarray(i * size, (i + 1) * size);
  }

  contacts(frame: number): Contact[] {
    const [chunk, i] = this.locate(frame);
    return chunk.contacts(i);
  }

  private number(name: string, frame: number, stride = 1, offset = 0): number {
    const [chunk, i] = this.locate(frame);
    return chunk.array(name)[i * stride + offset];
  }
}

/** What a page says about its run; the arrays are those of a stored one. */
export type PageAbout = About & { arrays: ArrayPlace[] };

/** Reads the element `about` of the page. */
export function readAbout(page: Document): PageAbout {
  return JSON.parse(page.getElementById("about")?.textContent ?? "");
}

/** The run embedded in this page. */
export class StoredRun extends ChunkedRun {
  private constructor(readonly about: About, private readonly chunk: Chunk) {
    super();
  }

  /** Reads the element `data` of the page. */
  static async load(about: PageAbout, page: Document): Promise<StoredRun> {
    const data = page.getElementById("data")?.textContent ?? "";
    return new StoredRun(about, new Chunk(about.arrays, await unpack(data)));
  }

  get frames(): number { return this.chunk.frames; }

  protected locate(frame: number): [Chunk, number] { return [this.chunk, frame]; }
}

/** The last frame whose time is not after `time`. */
export function frameAt(run: RunData, time: number): number {
  let [low, high] = [0, run.frames - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (run.time(middle) <= time + 1e-12) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** The frame that holds step number `step`. */
export function frameOfStep(run: RunData, step: number): number {
  let frame = 0;
  while (frame + 1 < run.frames && run.step(frame + 1) <= step) frame++;
  return frame;
}
