// The scene in 3-D: bodies, ground, light, camera; contacts are in contacts.ts.

import {
  BufferGeometry, Color, DirectionalLight, EdgesGeometry, Group, HemisphereLight, LineBasicMaterial, LineSegments, Mesh,
  MeshStandardMaterial, NeutralToneMapping, Object3D, PCFShadowMap, PerspectiveCamera, Ray, Raycaster, Scene,
  Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Axes } from "./axes.js";
import { ContactView } from "./contacts.js";
import type { ContactOptions } from "./contacts.js";
import type { Geom, RunData } from "./data.js";
import { extentOf } from "./extent.js";
import type { Extent } from "./extent.js";
import { Ground } from "./ground.js";
import type { Triangles } from "./meshes.js";
import { PullView } from "./pull.js";
import { geometryOf } from "./shapes.js";
import type { Theme } from "./theme.js";

export interface SceneOptions extends ContactOptions {
  bodies: boolean;
  seeThrough: boolean;
  follow: boolean;
  /** index of the body that is followed; 0 follows the middle of all that move */
  followed: number;
}

/** Where the camera stands, seen from the middle of the scene. The top is a little off the vertical, which has no up. */
export const VIEWS = {
  corner: new Vector3(0.62, -0.95, 0.5).normalize(),
  front: new Vector3(0, -1, 0.02).normalize(),
  side: new Vector3(1, 0, 0.02).normalize(),
  top: new Vector3(0, -1e-4, 1).normalize(),
};

const LIGHT_DIRECTION = new Vector3(0.35, -0.45, 1).normalize();
const FIELD_OF_VIEW = 32;
/** Edges are drawn where faces meet at more than this angle, degrees. */
const EDGE_ANGLE = 35;
/** A contact point is under the pointer within this distance. */
const PICK_PIXELS = 8;

interface Visual {
  geom: Geom;
  mesh: Mesh<any, MeshStandardMaterial>;
  edges: LineSegments<EdgesGeometry, LineBasicMaterial>;
}

export class SceneView {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(FIELD_OF_VIEW);
  private readonly controls: OrbitControls;
  private readonly bodies: Group[];
  private readonly visuals: Visual[] = [];
  private readonly grounds: Ground[] = [];
  private readonly contacts: ContactView;
  private readonly axes: Axes;
  private readonly sun = new DirectionalLight(0xffffff, 1.7);
  private readonly sky = new HemisphereLight(0xffffff, 0xb4b6c4, 2.2);
  private readonly pull: PullView;
  private readonly geometries: (BufferGeometry | null)[];
  private readonly extent: Extent;
  private view: keyof typeof VIEWS = "corner";
  private readonly followed = new Vector3();
  private frame = 0;
  private changed = true;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    corner: HTMLCanvasElement,
    private readonly run: RunData,
    private readonly options: SceneOptions,
    meshes: (Triangles | null)[],
  ) {
    this.axes = new Axes(corner, run.about.header.gravity);
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.addEventListener("change", () => (this.changed = true));

    const { header } = run.about;
    this.geometries = geometriesOf(header.geoms, meshes);
    this.extent = extentOf(run, this.geometries);
    this.bodies = header.bodies.map(() => new Group());
    header.geoms.forEach((geom, i) => {
      const geometry = this.geometries[i];
      if (geometry) this.addVisual(geom, geometry);
      else this.addGround(geom);
    });
    if (this.grounds.length === 0) this.addFloor();
    this.contacts = new ContactView(run, this.extent.unit);
    this.pull = new PullView(this.extent.unit);
    this.addLight();
    this.scene.add(...this.bodies, this.contacts, this.pull);
    this.placeBodies();
    this.followed.copy(this.middle());
    this.fit();
  }

  /** Shows a frame; called again with the same frame it takes up changed options. */
  show(frame: number): void {
    this.frame = frame;
    this.placeBodies();
    this.pull.update();
    this.contacts.show(frame, this.options);
    for (const { mesh, edges, geom } of this.visuals) {
      mesh.visible = edges.visible = this.options.bodies;
      const opacity = (geom.rgba?.[3] ?? 1) * (this.options.seeThrough ? 0.25 : 1);
      mesh.material.opacity = opacity;
      mesh.material.depthWrite = opacity > 0.99;
      if (mesh.material.transparent !== opacity < 0.99) {
        mesh.material.transparent = opacity < 0.99;
        mesh.material.needsUpdate = true;
      }
    }
    const middle = this.middle();
    if (this.options.follow) this.shift(middle.clone().sub(this.followed));
    this.followed.copy(middle);
    this.changed = true;
  }

  setTheme(theme: Theme): void {
    this.scene.background = new Color(theme.background);
    this.sky.intensity = theme.dark ? 1.5 : 2.2;
    for (const { geom, mesh, edges } of this.visuals) {
      const chosen = geom.body === 0 ? theme.neutral : theme.bodies[(geom.body - 1) % theme.bodies.length];
      if (geom.rgba) mesh.material.color.setRGB(geom.rgba[0], geom.rgba[1], geom.rgba[2], "srgb");
      else mesh.material.color.set(chosen);
      edges.material.color.copy(mesh.material.color).multiplyScalar(theme.dark ? 0.35 : 0.45);
    }
    this.grounds.forEach((ground) => ground.setTheme(theme));
    this.contacts.setTheme(theme);
    this.pull.setTheme(theme);
    this.axes.setTheme(theme);
    this.show(this.frame);
  }

  /** Looks from there, with everything in view. */
  look(view: keyof typeof VIEWS): void {
    this.view = view;
    this.fit();
  }

  /** Fits what depends on the whole run to the frames that there are now. */
  rescale(): void {
    this.contacts.rescale();
  }

  /** Brings everything into view. */
  fit(): void {
    const extent = extentOf(this.run, this.geometries);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [left, top, bottom] = this.covered();
    const perPixel = (2 * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / Math.max(height, 1);
    const free = Math.max(Math.min(width - left, height - top - bottom), 50);
    const distance = (1.08 * extent.radius) / Math.sin(Math.atan((free / 2) * perPixel));
    const centre = extent.centre.clone();
    if (this.options.follow) centre.copy(this.middle());
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(VIEWS[this.view], distance);
    this.camera.near = distance / 200;
    this.camera.far = distance * 40;
    this.camera.updateProjectionMatrix();
    this.changed = true;
  }

  /** Draws if something has changed. */
  render(): void {
    this.controls.update();
    this.resize();
    if (!this.changed) return;
    this.changed = false;
    this.renderer.render(this.scene, this.camera);
    this.axes.draw(this.camera);
  }

  /** What is at a place of the canvas, in pixels: a contact, else a body, else null. */
  describe(x: number, y: number): string | null {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const place = this.placeOf(x, y);
    const pixels = (point: Vector3) => {
      const seen = point.project(this.camera);
      return Math.hypot(((seen.x - place.x) * width) / 2, ((seen.y - place.y) * height) / 2);
    };
    return this.contacts.describe((point) => pixels(point) < PICK_PIXELS) ?? this.bodyAt(place);
  }

  /** The line of sight through a pixel. */
  ray(x: number, y: number): Ray {
    return this.caster(this.placeOf(x, y)).ray;
  }

  /** The body seen at a pixel, and the point of it. */
  hit(x: number, y: number): { body: number; point: Vector3 } | null {
    const found = this.firstVisual(this.placeOf(x, y));
    return found && { body: found.visual.geom.body, point: found.point };
  }

  /** A point of the world in a body's frame. */
  toBody(body: number, point: Vector3): Vector3 {
    this.bodies[body].updateMatrixWorld();
    return this.bodies[body].worldToLocal(point.clone());
  }

  viewDirection(): Vector3 {
    return this.camera.getWorldDirection(new Vector3());
  }

  /** Draws the spring from a point of a body to a point of the world. */
  showPull(body: number, point: Vector3, target: Vector3): void {
    this.pull.hold(this.bodies[body], point, target);
    this.changed = true;
  }

  hidePull(): void {
    this.pull.visible = false;
    this.changed = true;
  }

  private placeOf(x: number, y: number): Vector2 {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return new Vector2((2 * x) / width - 1, 1 - (2 * y) / height);
  }

  private caster(place: Vector2): Raycaster {
    const caster = new Raycaster();
    caster.setFromCamera(place, this.camera);
    return caster;
  }

  private firstVisual(place: Vector2): { visual: Visual; point: Vector3 } | null {
    if (!this.options.bodies) return null;
    const hit = this.caster(place).intersectObjects(this.visuals.map((visual) => visual.mesh), false)[0];
    const visual = this.visuals.find((candidate) => candidate.mesh === hit?.object);
    return visual ? { visual, point: hit.point } : null;
  }

  private bodyAt(place: Vector2): string | null {
    const visual = this.firstVisual(place)?.visual;
    if (!visual) return null;
    const body = this.run.about.header.bodies[visual.geom.body];
    return visual.geom.name && visual.geom.name !== body ? `${body} · ${visual.geom.name}` : body;
  }

  /** Pixels of the canvas that panels cover: at the left, the top and the bottom. */
  private covered(): [number, number, number] {
    return this.canvas.clientWidth > 700 ? [230, 90, 90] : [0, 90, 90];
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = Math.min(devicePixelRatio, 2);
    const size = this.renderer.getSize(new Vector2());
    if (size.x === width && size.y === height && this.renderer.getPixelRatio() === ratio) return;
    const firstTime = this.camera.aspect === 1;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    const [left, top, bottom] = this.covered();
    this.camera.setViewOffset(width, height, -left / 2, (bottom - top) / 2, width, height);
    if (firstTime) this.fit();
    this.changed = true;
  }

  private addVisual(geom: Geom, geometry: ReturnType<typeof geometryOf> & object): void {
    const material = new MeshStandardMaterial({ roughness: 0.62, metalness: 0.02 });
    const mesh = new Mesh(geometry, material);
    mesh.castShadow = true;
    mesh.receiveShadow = true;
    const edges = new LineSegments(
      new EdgesGeometry(geometry, EDGE_ANGLE),
      new LineBasicMaterial({ transparent: true, opacity: 0.55 }),
    );
    for (const part of [mesh, edges]) {
      place(part, geom.pose, 0);
      this.bodies[geom.body].add(part);
    }
    this.visuals.push({ geom, mesh, edges });
  }

  private addGround(geom: Geom): void {
    const holder = new Group();
    place(holder, geom.pose, 0);
    holder.updateMatrixWorld();
    const centre = holder.worldToLocal(this.extent.centre.clone());
    const ground = new Ground(this.extent.radius, [centre.x, centre.y]);
    holder.add(ground);
    this.grounds.push(ground);
    this.bodies[geom.body].add(holder);
  }

  /** A grid below a scene that has no plane of its own. */
  private addFloor(): void {
    const { centre, bottom, radius } = this.extent;
    const floor = new Ground(radius, [centre.x, centre.y]);
    floor.position.z = bottom - 0.02 * radius;
    this.grounds.push(floor);
    this.scene.add(floor);
  }

  private addLight(): void {
    const { centre, radius } = this.extent;
    const reach = 1.5 * radius;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 3;
    this.sun.shadow.normalBias = 0.004 * radius;
    Object.assign(this.sun.shadow.camera, {
      left: -reach, right: reach, bottom: -reach, top: reach, near: 0.1 * radius, far: 12 * radius,
    });
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).addScaledVector(LIGHT_DIRECTION, 5 * radius);
    this.sky.position.set(0, 0, 1);
    this.scene.add(this.sun, this.sun.target, this.sky);
  }

  private placeBodies(): void {
    if (this.run.frames === 0) return;
    const poses = this.run.poses(this.frame);
    this.bodies.forEach((body, i) => place(body, poses, 7 * i));
  }

  /** Position of the body that is followed, or the mean of all that move. */
  private middle(): Vector3 {
    if (this.options.followed > 0) return this.bodies[this.options.followed].position.clone();
    const moving = this.bodies.slice(1).filter((body) => body.children.length > 0);
    const sum = moving.reduce((total, body) => total.add(body.position), new Vector3());
    return moving.length > 0 ? sum.divideScalar(moving.length) : this.extent.centre.clone();
  }

  private shift(by: Vector3): void {
    if (!Number.isFinite(by.lengthSq())) return;
    for (const part of [this.camera, this.sun, this.sun.target]) part.position.add(by);
    this.controls.target.add(by);
  }
}

/** The geometry of each geom; those with the same mesh share it. */
function geometriesOf(geoms: Geom[], meshes: (Triangles | null)[]): (BufferGeometry | null)[] {
  const known = new Map<Triangles, BufferGeometry | null>();
  return geoms.map(({ shape }, i) => {
    const mesh = meshes[i];
    if (!mesh) return geometryOf(shape, null);
    if (!known.has(mesh)) known.set(mesh, geometryOf(shape, mesh));
    return known.get(mesh) ?? null;
  });
}

/** Puts an object at a pose x, y, z, qw, qx, qy, qz. */
function place(object: Object3D, poses: ArrayLike<number>, at: number): void {
  object.position.set(poses[at], poses[at + 1], poses[at + 2]);
  object.quaternion.set(poses[at + 4], poses[at + 5], poses[at + 6], poses[at + 3]);
}
