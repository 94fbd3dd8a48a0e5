// Which frame is shown, and how time runs.

import { frameAt } from "./data.js";
import type { RunData } from "./data.js";

/** What the controls need, of a replay as of a live run. */
export interface Player {
  readonly frame: number;
  readonly playing: boolean;
  /** seconds of the run per second of the clock */
  speed: number;
  /** whether the run begins anew at its end; undefined where it has none */
  loop?: boolean;
  seek(frame: number): void;
  toggle(): void;
  /** Moves on by so many frames, or back, and stops there. */
  stepBy(frames: number): void;
  /** Begins anew; undefined where seeking does that. */
  reset?(): void;
  /** Moves on to what the clock (ms) asks for. */
  tick(clock: number): void;
}

export class ReplayPlayer implements Player {
  frame = 0;
  playing = false;
  loop = true;
  speed = 1;
  private time = 0;
  private lastClock: number | null = null;

  constructor(private readonly run: RunData, private readonly changed: () => void) {
    this.time = run.frames > 0 ? run.time(0) : 0;
  }

  seek(frame: number): void {
    this.frame = Math.min(Math.max(Math.round(frame), 0), this.last);
    this.time = this.run.frames > 0 ? this.run.time(this.frame) : 0;
    this.changed();
  }

  toggle(): void {
    this.playing = !this.playing && this.run.frames > 1;
    this.lastClock = null;
    if (this.playing && this.frame === this.last) this.seek(0);
    this.changed();
  }

  stepBy(frames: number): void {
    if (this.playing) this.toggle();
    this.seek(this.frame + frames);
  }

  tick(clock: number): void {
    if (!this.playing) return;
    const elapsed = this.lastClock === null ? 0 : (clock - this.lastClock) / 1000;
    this.lastClock = clock;
    this.time += this.speed * elapsed;
    if (this.time >= this.run.time(this.last)) {
      if (this.loop) this.time = this.run.time(0);
      else {
        this.playing = false;
        this.seek(this.last);
        return;
      }
    }
    const frame = frameAt(this.run, this.time);
    if (frame === this.frame) return;
    this.frame = frame;
    this.changed();
  }

  private get last(): number {
    return Math.max(this.run.frames - 1, 0);
  }
}
