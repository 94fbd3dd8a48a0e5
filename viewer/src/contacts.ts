// Contacts in the scene: points, forces as arrows, friction polygons with the force inside them.
//
// Everything is drawn twice: solid where it is in view, faint where a body hides it.

import {
  BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DoubleSide, DynamicDrawUsage,
  Group, InstancedMesh, Material, Matrix4, Mesh, MeshBasicMaterial, Quaternion, SphereGeometry, Vector3,
} from "three";
import { MODES } from "./data.js";
import type { Contact, RunData } from "./data.js";
import { number } from "./format.js";
import type { Theme } from "./theme.js";

export interface ContactOptions {
  points: boolean;
  forces: boolean;
  polygons: boolean;
  open: boolean;
  /** points and polygons in the colour of the contact's mode, or all in one */
  colors: boolean;
  /** factor on the automatic length of a force */
  scale: number;
  logarithmic: boolean;
}

const HIDDEN_OPACITY = 0.28;
const Z = new Vector3(0, 0, 1);
/** Triangles per polygon side: ring (2) and fill (1). */
const VERTICES_PER_SIDE = 9;

/** A pair of meshes with the same geometry: what is in view and what is hidden. */
class Overlay extends Group {
  constructor(make: (material: Material) => Mesh, opacity = 1, vertexColors = false) {
    super();
    const common = { side: DoubleSide, vertexColors, toneMapped: false, depthWrite: false };
    const seen = make(new MeshBasicMaterial({ ...common, transparent: true, opacity }));
    const hidden = make(new MeshBasicMaterial({
      ...common, transparent: true, opacity: opacity * HIDDEN_OPACITY, depthTest: false,
    }));
    hidden.renderOrder = 10;
    seen.renderOrder = 11;
    for (const mesh of [hidden, seen]) {
      mesh.frustumCulled = false;
      this.add(mesh);
    }
  }
}

/** Many copies of one shape; room grows as it is needed. */
class Copies extends Group {
  private meshes: InstancedMesh[] = [];
  private overlay: Overlay | null = null;
  private capacity = 0;
  private used = 0;

  constructor(private readonly geometry: BufferGeometry) {
    super();
  }

  /** Begins a new frame with room for so many copies. */
  begin(count: number): void {
    this.used = 0;
    if (count <= this.capacity) return;
    this.capacity = Math.max(count, 2 * this.capacity);
    this.overlay?.removeFromParent();
    for (const mesh of this.meshes) {
      mesh.dispose();
      (mesh.material as Material).dispose();
    }
    this.meshes = [];
    this.overlay = new Overlay((material) => {
      const mesh = new InstancedMesh(this.geometry, material, this.capacity);
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      this.meshes.push(mesh);
      return mesh;
    });
    this.add(this.overlay);
  }

  put(matrix: Matrix4, color: Color): void {
    for (const mesh of this.meshes) {
      mesh.setMatrixAt(this.used, matrix);
      mesh.setColorAt(this.used, color);
    }
    this.used++;
  }

  commit(): void {
    for (const mesh of this.meshes) {
      mesh.count = this.used;
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }
}

/** A contact's force as seen from the body that it is drawn on. */
interface Force {
  vector: Vector3;
  tangential: Vector3;
  bound: number;
}

export class ContactView extends Group {
  private readonly points = new Copies(new SphereGeometry(1, 16, 12));
  private readonly tips = new Copies(new SphereGeometry(1, 12, 8));
  private readonly shafts = new Copies(
    new CylinderGeometry(1, 1, 1, 12).rotateX(Math.PI / 2).translate(0, 0, 0.5),
  );
  private readonly heads = new Copies(new ConeGeometry(1, 1, 20).rotateX(Math.PI / 2).translate(0, 0, 0.5));
  private readonly copies = [this.shafts, this.heads, this.points, this.tips];
  private readonly polygonGeometry = new BufferGeometry();
  private readonly rings: Overlay;
  private modeColors: Color[] = [];
  private forceColor = new Color();
  private plainColor = new Color();
  private largestForce = 1;
  private shown: Contact[] = [];

  /** `unit` is the length in m to which points, arrows and polygons are sized. */
  constructor(private readonly run: RunData, private readonly unit: number) {
    super();
    this.rescale();
    this.rings = new Overlay((material) => new Mesh(this.polygonGeometry, material), 1, true);
    this.add(this.rings, ...this.copies);
  }

  /** Fits the lengths of forces to the frames that there are. */
  rescale(): void {
    this.largestForce = typicalForce(this.run);
  }

  setTheme(theme: Theme): void {
    this.modeColors = theme.modes.map((color) => new Color(color));
    this.forceColor = new Color(theme.force);
    this.plainColor = new Color(theme.text);
  }

  show(frame: number, options: ContactOptions): void {
    const contacts = this.run.contacts(frame).filter((contact) => options.open || contact.mode > 0);
    this.shown = options.points ? contacts : [];
    for (const copies of this.copies) copies.begin(contacts.length);
    const sides = contacts.reduce((sum, contact) => sum + contact.sides, 0);
    const polygons = new PolygonWriter(this.polygonGeometry, sides);
    for (const contact of contacts) {
      const force = this.forceOf(contact);
      const length = this.lengthOf(force.vector.length(), options);
      const perNewton = force.vector.length() > 0 ? length / force.vector.length() : 0;
      const color = options.colors ? this.modeColors[contact.mode] : this.plainColor;
      if (options.points) this.putPoint(contact, color);
      if (options.forces) this.putArrow(contact, force, length);
      if (options.polygons) this.putPolygon(contact, force, perNewton, color, polygons);
    }
    for (const copies of this.copies) copies.commit();
    polygons.commit();
  }

  /** What the shown contact at a place is; `near` says whether a point is at that place. */
  describe(near: (point: Vector3) => boolean): string | null {
    const contact = this.shown.find((candidate) => near(new Vector3(...candidate.point)));
    if (!contact) return null;
    const { bodies, timestep } = this.run.about.header;
    const [first, second] = contact.directionsOfMode;
    const along = ["", "", ` along direction ${first}`, ` ${first} and ${second}`][contact.mode];
    const newtons = (impulse: number) => `${number(impulse / timestep)} N`;
    const bound = contact.friction * contact.normalImpulse;
    return [
      `${bodies[contact.bodyA]} – ${bodies[contact.bodyB]}: ${MODES[contact.mode]}${along}`,
      `normal ${newtons(contact.normalImpulse)}, gap ${number(contact.gap)} m`,
      `friction ${newtons(Math.hypot(...contact.tangentialImpulse))} of ${newtons(bound)}, μ = ${number(contact.friction)}`,
      `sliding at ${number(contact.slip)} m/s`,
    ].join("\n");
  }

  /** Force in N on body B, or on body A where B is the world. */
  private forceOf(contact: Contact): Force {
    const sign = contact.bodyB === 0 ? -1 : 1;
    const perImpulse = sign / this.run.about.header.timestep;
    const normal = new Vector3(...contact.normal);
    const tangent1 = new Vector3(...contact.tangent);
    const tangent2 = new Vector3().crossVectors(normal, tangent1);
    const [first, second] = contact.tangentialImpulse;
    const tangential = tangent1.multiplyScalar(first * perImpulse).addScaledVector(tangent2, second * perImpulse);
    const vector = normal.multiplyScalar(contact.normalImpulse * perImpulse).add(tangential);
    return { vector, tangential, bound: contact.friction * contact.normalImpulse * Math.abs(perImpulse) };
  }

  /** Length in the scene of a force in N. */
  private lengthOf(force: number, options: ContactOptions): number {
    if (!(force > 0) || !Number.isFinite(force)) return 0;
    const relative = force / this.largestForce;
    const shown = options.logarithmic ? Math.max(0, 1 + Math.log10(relative) / 4) : relative;
    return Math.min(0.42 * options.scale * shown, 20) * this.unit;
  }

  private putPoint(contact: Contact, color: Color): void {
    const radius = 0.014 * this.unit;
    this.points.put(placed(new Vector3(...contact.point), Z, radius, radius), color);
  }

  private putArrow(contact: Contact, force: Force, length: number): void {
    if (length < 1e-3 * this.unit) return;
    const start = new Vector3(...contact.point);
    const direction = force.vector.clone().normalize();
    const head = Math.min(0.075 * this.unit, 0.45 * length);
    const neck = start.clone().addScaledVector(direction, length - head);
    this.shafts.put(placed(start, direction, 0.1 * head, length - head), this.forceColor);
    this.heads.put(placed(neck, direction, 0.3 * head, head), this.forceColor);
  }

  private putPolygon(
    contact: Contact, force: Force, perNewton: number, color: Color, polygons: PolygonWriter,
  ): void {
    const radius = force.bound * perNewton;
    const corners = contact.polygon();
    if (corners.length === 0 || radius < 1e-3 * this.unit) return;
    const normal = new Vector3(...contact.normal);
    const tangent1 = new Vector3(...contact.tangent);
    const tangent2 = new Vector3().crossVectors(normal, tangent1);
    const centre = new Vector3(...contact.point);
    const corner = ([x, y]: [number, number]) =>
      new Vector3().addScaledVector(tangent1, x * radius).addScaledVector(tangent2, y * radius);
    const ring = Math.min(Math.max(0.1, (0.008 * this.unit) / radius), 0.5);
    polygons.put(centre, corners.map(corner), color, ring);
    const tip = centre.clone().addScaledVector(force.tangential, perNewton);
    const size = Math.min(0.09 * radius, 0.012 * this.unit);
    this.tips.put(placed(tip, Z, size, size), color);
  }
}

/** Writes rings and fills of polygons into one geometry. */
class PolygonWriter {
  private vertex = 0;
  private readonly positions: BufferAttribute;
  private readonly colors: BufferAttribute;

  constructor(private readonly geometry: BufferGeometry, sides: number) {
    const vertices = Math.max(sides, 1) * VERTICES_PER_SIDE;
    if (!(geometry.getAttribute("position")?.count >= vertices)) {
      geometry.dispose();
      for (const [name, size] of [["position", 3], ["color", 4]] as const) {
        const values = new Float32Array(2 * vertices * size);
        geometry.setAttribute(name, new BufferAttribute(values, size).setUsage(DynamicDrawUsage));
      }
    }
    this.positions = geometry.getAttribute("position") as BufferAttribute;
    this.colors = geometry.getAttribute("color") as BufferAttribute;
  }

  /** `ring` is the ring's width as a share of the radius. */
  put(centre: Vector3, corners: Vector3[], color: Color, ring: number): void {
    corners.forEach((corner, k) => {
      const next = corners[(k + 1) % corners.length];
      const at = (point: Vector3, factor: number) => centre.clone().addScaledVector(point, factor);
      const [a, b, c, d] = [at(corner, 1 - ring), at(corner, 1), at(next, 1), at(next, 1 - ring)];
      for (const point of [a, b, c, a, c, d]) this.push(point, color, 0.95);
      for (const point of [centre, a, d]) this.push(point, color, 0.2);
    });
  }

  commit(): void {
    this.geometry.setDrawRange(0, this.vertex);
    this.positions.needsUpdate = true;
    this.colors.needsUpdate = true;
  }

  private push(point: Vector3, color: Color, opacity: number): void {
    this.positions.setXYZ(this.vertex, point.x, point.y, point.z);
    this.colors.setXYZW(this.vertex, color.r, color.g, color.b, opacity);
    this.vertex++;
  }
}

function placed(origin: Vector3, direction: Vector3, width: number, length: number): Matrix4 {
  const rotation = new Quaternion().setFromUnitVectors(Z, direction);
  return new Matrix4().compose(origin, rotation, new Vector3(width, width, length));
}

/** The force in N that gets the automatic length: the 90th percentile of the run's. */
function typicalForce(run: RunData): number {
  const forces: number[] = [];
  const stride = Math.max(1, Math.floor(run.frames / 200));
  for (let frame = 0; frame < run.frames; frame += stride) {
    for (const contact of run.contacts(frame)) {
      const force = Math.abs(contact.normalImpulse) / run.about.header.timestep;
      if (force > 0 && Number.isFinite(force)) forces.push(force);
    }
  }
  forces.sort((a, b) => a - b);
  return forces[Math.floor(0.9 * (forces.length - 1))] ?? 1;
}
