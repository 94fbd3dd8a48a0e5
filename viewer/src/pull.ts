// The spring by which a body is pulled, drawn as a line with a knob at its end.

import {
  BufferAttribute, BufferGeometry, Group, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, Object3D, SphereGeometry,
  Vector3,
} from "three";
import type { Theme } from "./theme.js";

export class PullView extends Group {
  private readonly line: Line<BufferGeometry, LineBasicMaterial>;
  private readonly knob: Mesh<SphereGeometry, MeshBasicMaterial>;
  private held: { body: Object3D; point: Vector3; target: Vector3 } | null = null;

  /** `unit` is the length in m to which the knob is sized. */
  constructor(unit: number) {
    super();
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(6), 3));
    const overEverything = { depthTest: false, transparent: true, toneMapped: false };
    this.line = new Line(geometry, new LineBasicMaterial(overEverything));
    this.knob = new Mesh(new SphereGeometry(0.025 * unit, 16, 12), new MeshBasicMaterial(overEverything));
    for (const part of [this.line, this.knob]) {
      part.frustumCulled = false;
      part.renderOrder = 20;
    }
    this.visible = false;
    this.add(this.line, this.knob);
  }

  setTheme(theme: Theme): void {
    this.line.material.color.set(theme.text);
    this.knob.material.color.set(theme.text);
  }

  /** From a point in the body's frame to one in the world. */
  hold(body: Object3D, point: Vector3, target: Vector3): void {
    this.held = { body, point, target };
    this.visible = true;
    this.update();
  }

  /** Takes up where the body is now. */
  update(): void {
    if (!this.visible || !this.held) return;
    const { body, point, target } = this.held;
    body.updateMatrixWorld();
    const start = body.localToWorld(point.clone());
    this.line.geometry.setFromPoints([start, target]);
    this.knob.position.copy(target);
  }
}
