// Where the action is: a ball that the camera, the light and the sizes of arrows are fitted to.

import { Box3, Quaternion, Vector3 } from "three";
import type { BufferGeometry } from "three";
import type { RunData } from "./data.js";
import { isShown } from "./looks.js";

export interface Extent {
  centre: Vector3;
  radius: number;
  /** lowest height at the start */
  bottom: number;
  /** a length that suits a single body: between 0.15 and 1 times the radius */
  unit: number;
  /** diagonal of the box around what a picture is of at the start, as the renderer has it */
  length: number;
}

const SAMPLED_FRAMES = 60;
/** Bodies that leave the ball of the start by more than this factor do not widen the view. */
const WIDEST = 2.5;

/** The ball around everything that moves (or around everything, where nothing does). */
export function extentOf(run: RunData, geometries: (BufferGeometry | null)[]): Extent {
  const { geoms } = run.about.header;
  const visible = geoms.map((_, i) => i).filter((i) => geometries[i] !== null && isShown(geoms[i]));
  const moving = visible.filter((i) => geoms[i].body !== 0);
  const chosen = moving.length > 0 ? moving : visible;
  const balls = (frame: number) => chosen.map((i) => ballOf(run, i, geometries[i] as BufferGeometry, frame));
  if (chosen.length === 0 || run.frames === 0) {
    return { centre: new Vector3(), radius: 1, bottom: 0, unit: 1, length: 1 };
  }
  const start = balls(0);
  const first = enclose(start);
  const all = [...start];
  const stride = Math.max(1, Math.floor(run.frames / SAMPLED_FRAMES));
  for (let frame = stride; frame < run.frames; frame += stride) {
    all.push(...balls(frame).filter((ball) => ball.centre.distanceTo(first.centre) < WIDEST * first.radius));
  }
  const bottom = Math.min(...start.map((ball) => ball.centre.z - ball.radius));
  const whole = enclose(all);
  const sizes = start.map((ball) => ball.radius).sort((a, b) => a - b);
  const median = sizes[Math.floor(sizes.length / 2)];
  const unit = Math.min(Math.max(5 * median, 0.15 * whole.radius), whole.radius);
  return { ...whole, bottom, unit, length: lengthOf(run, geometries) };
}

/** Everything that moves, and what stands around it, but for tables and grounds that are much larger. */
function lengthOf(run: RunData, geometries: (BufferGeometry | null)[]): number {
  const { geoms } = run.about.header;
  const poses = run.poses(0);
  const corners = (i: number) => {
    const geometry = geometries[i]!;
    geometry.computeBoundingBox();
    const { min, max } = geometry.boundingBox!;
    return Array.from({ length: 8 }, (_, k) => {
      const corner = new Vector3(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z);
      return transform(poses, 7 * geoms[i].body, transform(geoms[i].pose, 0, corner));
    });
  };
  const box = new Box3();
  const bounded = geoms.map((_, i) => i).filter((i) => geometries[i] && isShown(geoms[i]));
  const moving = bounded.filter((i) => geoms[i].body !== 0);
  (moving.length > 0 ? moving : bounded).forEach((i) => corners(i).forEach((corner) => box.expandByPoint(corner)));
  const near = box.clone().expandByScalar(0.75 * box.getSize(new Vector3()).length());
  const around = moving.length > 0 ? bounded.filter((i) => geoms[i].body === 0).map(corners) : [];
  around.filter((eight) => eight.every((corner) => near.containsPoint(corner))).flat().forEach((corner) => box.expandByPoint(corner));
  const length = box.getSize(new Vector3()).length();
  return Number.isFinite(length) && length > 0 ? length : 1;
}

interface Ball {
  centre: Vector3;
  radius: number;
}

function ballOf(run: RunData, i: number, geometry: BufferGeometry, frame: number): Ball {
  geometry.computeBoundingSphere();
  const sphere = geometry.boundingSphere!;
  const geom = run.about.header.geoms[i];
  const inBody = transform(geom.pose, 0, sphere.center.clone());
  return { centre: transform(run.poses(frame), 7 * geom.body, inBody), radius: sphere.radius };
}

function transform(poses: ArrayLike<number>, at: number, point: Vector3): Vector3 {
  const [x, y, z, qw, qx, qy, qz] = Array.from({ length: 7 }, (_, k) => poses[at + k]);
  return point.applyQuaternion(new Quaternion(qx, qy, qz, qw)).add(new Vector3(x, y, z));
}

/** A ball around balls, centred at the middle of their bounding box. */
function enclose(balls: Ball[]): Ball {
  const finite = balls.filter(({ centre }) => Number.isFinite(centre.x + centre.y + centre.z));
  if (finite.length === 0) return { centre: new Vector3(), radius: 1 };
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = low.clone().negate();
  for (const { centre, radius } of finite) {
    low.min(centre.clone().subScalar(radius));
    high.max(centre.clone().addScalar(radius));
  }
  const centre = low.add(high).multiplyScalar(0.5);
  const radius = Math.max(...finite.map((ball) => ball.centre.distanceTo(centre) + ball.radius));
  return { centre, radius: Math.max(radius, 1e-6) };
}
