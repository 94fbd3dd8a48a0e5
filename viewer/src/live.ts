// A run that goes on: its frames come over a websocket, and commands go back.

import { Chunk, ChunkedRun } from "./data.js";
import type { About, ArrayPlace, Run, RunState, Vec3 } from "./data.js";
import type { Player } from "./player.js";

/** Frames that the page keeps: about 20 s of a run in real time. */
const KEPT_FRAMES = 1200;

/** A command; the Rust module `message` of `signorini-viewer` reads it. */
export type Command =
  | { type: "run" | "pause" | "reset" | "release" }
  | { type: "step"; count: number }
  | { type: "speed"; value: number }
  | { type: "drag"; body: number; point: Vec3; target: Vec3 };

interface Status {
  type: "status";
  running: boolean;
  speed: number;
  rate: number;
  trouble: string | null;
  note: string | null;
}

type Notice = Status | { type: "error"; message: string };

/** The latest frames of a run that goes on. */
export class LiveRun extends ChunkedRun {
  state: RunState = { text: "connecting", bad: false };
  /** the latest status; null before the first */
  status: Status | null = null;
  /** counts what arrived, so that views can see whether there is something new */
  version = 0;
  private chunks: Chunk[] = [];
  private epoch = -1;
  private readonly socket: WebSocket;

  private constructor(public about: About, address: string, private readonly ready: () => void, failed: () => void) {
    super();
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("message", ({ data }: MessageEvent<string | ArrayBuffer>) => {
      if (typeof data === "string") this.hear(JSON.parse(data));
      else this.take(data);
    });
    this.socket.addEventListener("close", () => {
      this.status = null;
      this.state = { text: "disconnected: the simulation has ended", bad: true };
      this.version++;
      failed();
    });
  }

  /** Connects to the websocket beside the page; done when the first frame is here. */
  static connect(about: About): Promise<LiveRun> {
    const address = new URL("socket", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    return new Promise((resolve, reject) => {
      const run: LiveRun = new LiveRun(
        about, address.href, () => resolve(run), () => reject(new Error("the simulation does not answer")),
      );
    });
  }

  get frames(): number { return this.chunks.length; }

  get note(): string | null { return this.status?.note ?? null; }

  protected locate(frame: number): [Chunk, number] { return [this.chunks[frame], 0]; }

  send(command: Command): void {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(command));
  }

  private hear(notice: Notice): void {
    if (notice.type === "error") {
      console.error(notice.message);
      return;
    }
    this.status = notice;
    const { running, rate, trouble } = notice;
    if (trouble !== null) this.state = { text: trouble, bad: true };
    else if (!running) this.state = { text: "paused", bad: false };
    else this.state = { text: rate > 0 ? `live, ${rate.toFixed(2)}×` : "live", bad: false };
    this.version++;
  }

  /** Adds a frame; the layout is that of the Rust type `LiveFeed`. */
  private take(message: ArrayBuffer): void {
    const length = new DataView(message).getUint32(0, true);
    const text = new TextDecoder().decode(new Uint8Array(message, 4, length));
    const { epoch, run, arrays }: { epoch: number; run: Run; arrays: ArrayPlace[] } = JSON.parse(text);
    const chunk = new Chunk(arrays, message, 4 + length);
    if (epoch !== this.epoch) this.chunks = [];
    this.epoch = epoch;
    this.about = { ...this.about, run };
    // The start, before its step was made, gives way to the same state with the contacts of that step.
    const stepOf = (other: Chunk) => other.array("step")[0];
    const last = this.chunks.at(-1);
    if (last && stepOf(last) === stepOf(chunk)) this.chunks.pop();
    this.chunks.push(chunk);
    if (this.chunks.length > KEPT_FRAMES) this.chunks.shift();
    this.version++;
    this.ready();
  }
}

/** Shows the latest frame, or an earlier one while the simulation stands. */
export class LivePlayer implements Player {
  frame = 0;
  private follows = true;
  private seen = -1;

  constructor(private readonly run: LiveRun, private readonly changed: () => void) {}

  get playing(): boolean { return this.run.status?.running ?? false; }

  get speed(): number { return this.run.status?.speed ?? 1; }
  set speed(value: number) {
    if (this.run.status) this.run.status.speed = value;
    this.run.send({ type: "speed", value });
  }

  seek(frame: number): void {
    if (this.playing) this.pause();
    this.frame = Math.min(Math.max(Math.round(frame), 0), this.last);
    this.follows = this.frame === this.last;
    this.changed();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else {
      if (this.run.status) this.run.status.running = true;
      this.run.send({ type: "run" });
      this.follows = true;
    }
    this.changed();
  }

  /** Beyond the latest frame the simulation makes steps. */
  stepBy(frames: number): void {
    if (this.playing) this.pause();
    const beyond = this.frame + frames - this.last;
    if (beyond <= 0) {
      this.seek(this.frame + frames);
      return;
    }
    this.run.send({ type: "step", count: beyond });
    this.seek(this.last);
  }

  reset(): void {
    this.run.send({ type: "reset" });
    this.follows = true;
  }

  tick(): void {
    if (this.seen === this.run.version) return;
    this.seen = this.run.version;
    this.frame = this.follows || this.playing ? this.last : Math.min(this.frame, this.last);
    this.changed();
  }

  private pause(): void {
    if (this.run.status) this.run.status.running = false;
    this.run.send({ type: "pause" });
  }

  private get last(): number {
    return Math.max(this.run.frames - 1, 0);
  }
}
