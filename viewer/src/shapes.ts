// Shapes of a recording as three.js geometries, axes as the recording has them (z for round shapes).

import {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, ConeGeometry, CylinderGeometry,
  SphereGeometry,
} from "three";
import { toCreasedNormals } from "three/addons/utils/BufferGeometryUtils.js";
import type { Shape, Spread } from "./data.js";
import type { Triangles } from "./meshes.js";

const SEGMENTS = 40;
/** Neighbouring triangles of a mesh are shaded as one surface below this angle, rad. */
const CREASE = 0.6;

/** The geometry; null for a plane, which has no end. A mesh is that of its triangles. */
export function geometryOf(shape: Shape, mesh: Triangles | null): BufferGeometry | null {
  switch (shape.type) {
    case "plane":
      return null;
    case "sphere":
      return new SphereGeometry(shape.radius, SEGMENTS, SEGMENTS / 2);
    case "ellipsoid":
      return new SphereGeometry(1, SEGMENTS, SEGMENTS / 2).scale(...shape.radii);
    case "box": {
      const [x, y, z] = shape.half_extents;
      return new BoxGeometry(2 * x, 2 * y, 2 * z);
    }
    case "capsule":
      return upright(new CapsuleGeometry(shape.radius, 2 * shape.half_length, 12, SEGMENTS));
    case "cylinder":
      return upright(new CylinderGeometry(shape.radius, shape.radius, 2 * shape.half_length, SEGMENTS));
    case "cone":
      return upright(new ConeGeometry(shape.radius, 2 * shape.half_height, SEGMENTS));
    case "mesh":
      return triangles(mesh?.positions ?? new Float32Array(), mesh?.indices ?? new Uint32Array(), mesh?.places ?? null);
    case "height_field":
      return heightField(shape);
  }
}

/** From three's axis y to z. */
function upright(geometry: BufferGeometry): BufferGeometry {
  return geometry.rotateX(Math.PI / 2);
}

function triangles(positions: Float32Array, indices: Uint32Array, places: Float32Array | null = null): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  if (places) geometry.setAttribute("uv", new BufferAttribute(places, 2));
  geometry.setIndex(new BufferAttribute(indices, 1));
  return toCreasedNormals(geometry, CREASE);
}

function heightField(field: Extract<Shape, { type: "height_field" }>): BufferGeometry {
  const { rows, cols, heights, half_extents: [hx, hy] } = field;
  const along = (i: number, count: number, half: number) => half * ((2 * i) / Math.max(count - 1, 1) - 1);
  const vertices: number[] = [];
  const faces: number[] = [];
  for (let row = 0; row < rows; row++) {
    for (let col = 0; col < cols; col++) {
      const k = row * cols + col;
      vertices.push(along(col, cols, hx), along(row, rows, hy), heights[k]);
      if (row + 1 < rows && col + 1 < cols) {
        faces.push(k, k + 1, k + cols + 1, k, k + cols + 1, k + cols);
      }
    }
  }
  return triangles(new Float32Array(vertices), new Uint32Array(faces));
}

/** The geometry with the image coordinates of a spread: of a mesh its own, else by the place and the normal of its vertices. */
export function spreadOn(geometry: BufferGeometry, spread: Spread): BufferGeometry {
  if ("corners" in spread) return geometry;
  const own = geometry.index ? geometry.toNonIndexed() : geometry.clone();
  const [positions, normals] = [own.getAttribute("position"), own.getAttribute("normal")];
  const places = new Float32Array(2 * positions.count);
  for (let i = 0; i < positions.count; i++) {
    const p = [positions.getX(i), positions.getY(i), positions.getZ(i)];
    const n = [normals.getX(i), normals.getY(i), normals.getZ(i)];
    const [u, v] = "plane" in spread ? [p[0] / spread.plane[0], p[1] / spread.plane[1]] : onCube(p, n, spread.cube);
    places.set([u + 0.5, v + 0.5], 2 * i);
  }
  own.setAttribute("uv", new BufferAttribute(places, 2));
  return own;
}

/** The side of a box that a normal looks to, as the renderer of `crates/render` has it. */
function onCube(p: number[], n: number[], [x, y, z]: number[]): [number, number] {
  const m = n.map(Math.abs);
  if (m[2] >= m[0] && m[2] >= m[1]) return [(p[0] * Math.sign(n[2])) / x, p[1] / y];
  if (m[0] >= m[1]) return [(p[1] * Math.sign(n[0])) / y, p[2] / z];
  return [(-p[0] * Math.sign(n[1])) / x, p[2] / z];
}
