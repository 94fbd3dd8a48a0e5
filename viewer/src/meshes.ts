// The meshes of a page, which lie apart from its description.

import { fromDifferences, indicesFrom, unpack } from "./coding.js";

/** Where a mesh lies in the block, and what its whole numbers mean. */
interface MeshPlace {
  offset: number;
  vertices: number;
  triangles: number;
  low: [number, number, number];
  unit: number;
}

export interface MeshPlaces {
  /** the mesh of each geom, or null */
  of_geom: (number | null)[];
  places: MeshPlace[];
}

export interface Triangles {
  /** three coordinates per vertex */
  positions: Float32Array;
  /** three indices per triangle */
  indices: Uint32Array;
}

/** The triangles of each geom of the page, null where it has none; equal ones are the same object. */
export async function readMeshes({ of_geom, places }: MeshPlaces, page: Document): Promise<(Triangles | null)[]> {
  if (places.length === 0) return of_geom.map(() => null);
  const block = new Uint8Array(await unpack(page.getElementById("meshes")?.textContent ?? ""));
  const meshes = places.map((place) => readMesh(block, place));
  return of_geom.map((number) => (number === null ? null : meshes[number]));
}

function readMesh(block: Uint8Array, { offset, vertices, triangles, low, unit }: MeshPlace): Triangles {
  const [coordinates, corners] = [3 * vertices, 3 * triangles];
  const whole = fromDifferences(block.subarray(offset), coordinates, 3);
  const positions = Float32Array.from(whole, (x, i) => low[i % 3] + unit * x);
  return { positions, indices: indicesFrom(block.subarray(offset + 2 * coordinates), corners) };
}
