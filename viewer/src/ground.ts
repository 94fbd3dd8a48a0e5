// Planes, which have no end: as wide as one sees, with squares where they have nothing of their own.

import { Group, Mesh, PlaneGeometry } from "three";
import type { Texture } from "three";
import type { Checker, Geom } from "./data.js";
import type { Extent } from "./extent.js";
import { lookOf, materialOf } from "./looks.js";
import { spreadOn } from "./shapes.js";

/** Beyond this many radii of the scene a plane is the sky. */
const REACH = 150;

/** The plane z = 0 of its frame, drawn around a centre. */
export class Ground extends Group {
  readonly mesh: Mesh<PlaneGeometry, ReturnType<typeof materialOf>>;

  constructor(geom: Geom, images: Texture[], extent: Extent, [x, y]: [number, number]) {
    super();
    const look = lookOf(geom);
    const side = 2 * REACH * extent.radius;
    let plane = new PlaneGeometry(side, side).translate(x, y, 0) as PlaneGeometry;
    if (look.texture) plane = spreadOn(plane, look.texture.spread) as PlaneGeometry;
    const checker = look.checker ?? (look.texture ? undefined : squares(extent));
    this.mesh = new Mesh(plane, materialOf(geom, images, checker, extent));
    this.mesh.receiveShadow = true;
    this.add(this.mesh);
  }
}

/** Squares of a power of ten of metres, about ten of them along the scene. */
function squares({ length }: Extent): Checker {
  const side = 10 ** Math.floor(Math.log10(length / 3));
  return { colors: [[1, 1, 1], [0.92, 0.92, 0.92]], square: [side, side] };
}
