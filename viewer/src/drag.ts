// Pulling bodies of a live run with the pointer.

import { Plane, Vector3 } from "three";
import type { LiveRun } from "./live.js";
import type { SceneView } from "./scene.js";

/** What is held. */
interface Held {
  body: number;
  /** held point, body frame */
  point: Vector3;
  /** through the point where it was taken, facing the camera */
  plane: Plane;
}

/** A body under the pointer is pulled; everything else, and all with Shift, Ctrl or ⌘, turns the camera. */
export function pullBodies(canvas: HTMLCanvasElement, scene: SceneView, run: LiveRun): void {
  let held: Held | null = null;
  const pull = (x: number, y: number) => {
    if (!held) return;
    const target = scene.ray(x, y).intersectPlane(held.plane, new Vector3());
    if (!target) return;
    scene.showPull(held.body, held.point, target);
    run.send({ type: "drag", body: held.body, point: held.point.toArray(), target: target.toArray() });
  };
  const release = () => {
    if (!held) return;
    held = null;
    scene.hidePull();
    run.send({ type: "release" });
  };
  // Before the camera's own listener, which then hears nothing of it.
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.shiftKey || event.ctrlKey || event.metaKey || held) return;
    const hit = scene.hit(event.offsetX, event.offsetY);
    if (!hit || hit.body === 0) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    const plane = new Plane().setFromNormalAndCoplanarPoint(scene.viewDirection(), hit.point);
    held = { body: hit.body, point: scene.toBody(hit.body, hit.point), plane };
    pull(event.offsetX, event.offsetY);
  }, { capture: true });
  canvas.addEventListener("pointermove", (event) => pull(event.offsetX, event.offsetY));
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
    canvas.addEventListener(end, release);
  }
}
