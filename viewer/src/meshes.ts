// The meshes of a page, which lie apart from its description.

import { fromDifferences, indicesFrom, unpack } from "./coding.js";

/** Where a mesh lies in the block, and what its whole numbers mean. */
interface MeshPlace {
  offset: number;
  vertices: number;
  triangles: number;
  low: [number, number, number];
  unit: number;
  /** the same of places on an image */
  places?: [[number, number], number];
}

export interface MeshPlaces {
  /** the mesh of each geom, or null */
  of_geom: (number | null)[];
  places: MeshPlace[];
}

export interface Triangles {
  /** three coordinates per vertex */
  positions: Float32Array;
  /** two image coordinates per vertex */
  places: Float32Array | null;
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

function readMesh(block: Uint8Array, { offset, vertices, triangles, low, unit, places }: MeshPlace): Triangles {
  let at = offset;
  const read = (row: number, low: number[], unit: number) => {
    const whole = fromDifferences(block.subarray(at), row * vertices, row);
    at += 2 * row * vertices;
    return Float32Array.from(whole, (x, i) => low[i % row] + unit * x);
  };
  const positions = read(3, low, unit);
  const onImage = places ? read(2, ...places) : null;
  return { positions, places: onImage, indices: indicesFrom(block.subarray(at), 3 * triangles) };
}
