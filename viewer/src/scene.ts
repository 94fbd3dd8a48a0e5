// The scene in 3-D: bodies, ground, light, camera; contacts are in contacts.ts.

import {
  BufferGeometry, Color, DirectionalLight, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshPhongMaterial,
  Object3D, PCFShadowMap, PerspectiveCamera, Ray, Raycaster, Scene, Texture, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Axes } from "./axes.js";
import { ContactView } from "./contacts.js";
import type { ContactOptions } from "./contacts.js";
import type { Geom, RunData } from "./data.js";
import { extentOf } from "./extent.js";
import type { Extent } from "./extent.js";
import { Ground } from "./ground.js";
import { isShown, lightsOf, lookOf, materialOf, setTones, sky } from "./looks.js";
import type { Triangles } from "./meshes.js";
import { PullView } from "./pull.js";
import { geometryOf, spreadOn } from "./shapes.js";
import type { Theme } from "./theme.js";

export interface SceneOptions extends ContactOptions {
  bodies: boolean;
  /** whether shapes are shown that only touch */
  touching: boolean;
  edges: boolean;
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

/** A place to look from: x, y, z, qw, qx, qy, qz, and the angle between the lower and the upper edge, rad. */
export type Sight = [number, number, number, number, number, number, number, number];

const FIELD_OF_VIEW = 32;
/** Edges are drawn where faces meet at more than this angle, degrees. */
const EDGE_ANGLE = 35;
/** A contact point is under the pointer within this distance. */
const PICK_PIXELS = 8;

interface Visual {
  geom: Geom;
  mesh: Mesh<any, MeshPhongMaterial>;
  edges: LineSegments<EdgesGeometry, LineBasicMaterial>;
}

/** What draws on a canvas; null where the browser has no WebGL for it. */
export function rendererOn(canvas: HTMLCanvasElement): WebGLRenderer | null {
  try {
    return new WebGLRenderer({ canvas, antialias: true });
  } catch {
    return null;
  }
}

export class SceneView {
  private readonly canvas: HTMLCanvasElement;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(FIELD_OF_VIEW);
  private readonly controls: OrbitControls;
  private readonly bodies: Group[];
  private readonly visuals: Visual[] = [];
  private readonly grounds: { ground: Ground; geom: Geom }[] = [];
  private readonly contacts: ContactView;
  private readonly axes: Axes;
  private readonly suns: DirectionalLight[];
  private readonly sky = sky();
  /** where the page was asked to look from, once */
  private sight: Sight | null = null;
  private readonly pull: PullView;
  private readonly geometries: (BufferGeometry | null)[];
  private readonly extent: Extent;
  private view: keyof typeof VIEWS = "corner";
  private readonly followed = new Vector3();
  private frame = 0;
  private changed = true;

  constructor(
    private readonly renderer: WebGLRenderer,
    corner: HTMLCanvasElement,
    private readonly run: RunData,
    private readonly options: SceneOptions,
    meshes: (Triangles | null)[],
    private readonly images: Texture[],
  ) {
    this.axes = new Axes(corner, run.about.header.gravity);
    const canvas = (this.canvas = renderer.domElement);
    setTones(this.renderer);
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
    this.contacts = new ContactView(run, this.extent.unit);
    this.pull = new PullView(this.extent.unit);
    const lights = lightsOf(header, this.bodies, this.camera, this.extent);
    this.suns = lights.suns;
    this.scene.add(this.sky, ...lights.scene, ...this.bodies, this.contacts, this.pull);
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
      mesh.visible = this.options.bodies && (isShown(geom) || this.options.touching);
      edges.visible = mesh.visible && this.options.edges;
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
    this.sky.visible = !theme.dark;
    for (const { geom, mesh, edges } of this.visuals) {
      const chosen = geom.body === 0 ? theme.neutral : theme.bodies[(geom.body - 1) % theme.bodies.length];
      if (geom.rgba) mesh.material.color.setRGB(geom.rgba[0], geom.rgba[1], geom.rgba[2], "srgb");
      else mesh.material.color.set(chosen);
      mesh.material.emissive.copy(mesh.material.color).multiplyScalar(lookOf(geom).emission);
      edges.material.color.copy(mesh.material.color).multiplyScalar(theme.dark ? 0.35 : 0.45);
    }
    for (const { ground, geom } of this.grounds) {
      const { color } = ground.mesh.material;
      if (geom.rgba) color.setRGB(geom.rgba[0], geom.rgba[1], geom.rgba[2], "srgb");
      else color.set(theme.ground);
      if (theme.dark) color.multiplyScalar(0.25);
    }
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

  /** Looks from a place, with the whole canvas as the picture. */
  lookFrom(sight: Sight): void {
    this.sight = sight;
    place(this.camera, sight, 0);
    this.camera.fov = (sight[7] * 180) / Math.PI;
    this.camera.clearViewOffset();
    const ahead = this.camera.getWorldDirection(new Vector3());
    const distance = Math.max(this.extent.centre.clone().sub(this.camera.position).dot(ahead), 0.1 * this.extent.radius);
    this.controls.target.copy(this.camera.position).addScaledVector(ahead, distance);
    this.camera.near = distance / 200;
    this.camera.far = distance + 300 * this.extent.radius;
    this.camera.updateProjectionMatrix();
    this.changed = true;
  }

  /** Looks from where a camera of the model is now. */
  lookThrough(index: number): void {
    const camera = (this.run.about.header.cameras ?? [])[index];
    const eye = new Object3D();
    place(eye, camera.pose, 0);
    this.bodies[camera.body].add(eye);
    this.bodies[camera.body].updateWorldMatrix(true, true);
    const [at, turn] = [eye.getWorldPosition(new Vector3()), eye.getWorldQuaternion(this.camera.quaternion.clone())];
    this.bodies[camera.body].remove(eye);
    this.lookFrom([at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z, camera.field_of_view]);
  }

  /** Fits what depends on the whole run to the frames that there are now. */
  rescale(): void {
    this.contacts.rescale();
  }

  /** Brings everything into view. */
  fit(): void {
    if (this.sight) {
      this.sight = null;
      this.camera.fov = FIELD_OF_VIEW;
      this.offset();
    }
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
    this.camera.far = distance + 300 * extent.radius;
    this.camera.updateProjectionMatrix();
    this.changed = true;
  }

  /** Moves the picture's middle to that of what no panel covers. */
  private offset(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [left, top, bottom] = this.covered();
    this.camera.setViewOffset(width, height, -left / 2, (bottom - top) / 2, width, height);
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
    if (this.sight) this.lookFrom(this.sight);
    else {
      this.offset();
      if (firstTime) this.fit();
    }
    this.changed = true;
  }

  private addVisual(geom: Geom, geometry: ReturnType<typeof geometryOf> & object): void {
    const look = lookOf(geom);
    const spread = look.texture ? spreadOn(geometry, look.texture.spread) : geometry;
    const mesh = new Mesh(spread, materialOf(geom, this.images, look.checker, this.extent));
    mesh.castShadow = (geom.rgba?.[3] ?? 1) > 0.99;
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
    const ground = new Ground(geom, this.images, this.extent, [centre.x, centre.y]);
    ground.visible = isShown(geom);
    holder.add(ground);
    this.grounds.push({ ground, geom });
    this.bodies[geom.body].add(holder);
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
    for (const part of [this.camera, ...this.suns.flatMap((sun) => [sun, sun.target])]) part.position.add(by);
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
