// The world's axes and the direction of gravity, as the camera sees them, in a corner of the scene.

import { Vector3 } from "three";
import type { Camera } from "three";
import type { Vec3 } from "./data.js";
import type { Theme } from "./theme.js";

const SIZE = 92;
const LENGTH = 30;

interface Axis {
  label: string;
  direction: Vector3;
  color: string;
}

export class Axes {
  private axes: Axis[] = [];

  constructor(private readonly canvas: HTMLCanvasElement, private readonly gravity: Vec3) {}

  setTheme(theme: Theme): void {
    const [x, y, z] = theme.axes;
    this.axes = [
      { label: "x", direction: new Vector3(1, 0, 0), color: x },
      { label: "y", direction: new Vector3(0, 1, 0), color: y },
      { label: "z", direction: new Vector3(0, 0, 1), color: z },
    ];
    const gravity = new Vector3(...this.gravity);
    if (gravity.length() > 0) this.axes.push({ label: "g", direction: gravity.normalize(), color: theme.faint });
  }

  draw(camera: Camera): void {
    const ratio = Math.min(devicePixelRatio, 2);
    this.canvas.width = this.canvas.height = SIZE * ratio;
    const pen = this.canvas.getContext("2d")!;
    pen.scale(ratio, ratio);
    pen.translate(SIZE / 2, SIZE / 2);
    pen.font = "600 11px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.lineCap = "round";
    const toCamera = camera.quaternion.clone().invert();
    const seen = this.axes.map((axis) => ({ ...axis, end: axis.direction.clone().applyQuaternion(toCamera) }));
    // The axis that points away from the eye is drawn first.
    for (const { label, color, end } of seen.sort((a, b) => a.end.z - b.end.z)) {
      pen.globalAlpha = end.z < -0.3 ? 0.55 : 1;
      pen.strokeStyle = pen.fillStyle = color;
      pen.lineWidth = label === "g" ? 1.5 : 2.5;
      pen.setLineDash(label === "g" ? [2, 4] : []);
      pen.beginPath();
      pen.moveTo(0, 0);
      pen.lineTo(LENGTH * end.x, -LENGTH * end.y);
      pen.stroke();
      pen.fillText(label, (LENGTH + 9) * end.x, -(LENGTH + 9) * end.y);
    }
  }
}
