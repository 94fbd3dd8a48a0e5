// Numbers as the Rust modules `report::coding` and `report::meshes` write them for deflating.

/** The bytes of base64 text that were deflated. */
export async function unpack(text: string): Promise<ArrayBuffer> {
  const packed = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
  const inflated = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(inflated).arrayBuffer();
}

/** `count` numbers of four bytes, of which all first bytes come first, then all second ones. */
function fromPlanes(bytes: Uint8Array, count: number): Uint32Array {
  const numbers = new Uint32Array(count);
  for (let i = 0; i < count; i++) {
    numbers[i] = bytes[i] | (bytes[count + i] << 8) | (bytes[2 * count + i] << 16) | (bytes[3 * count + i] << 24);
  }
  return numbers;
}

/** Rows of numbers that lie there column after column, as differences of their bits within a column. */
export function fromColumns(bytes: Uint8Array, count: number, row: number): Float32Array {
  const differences = fromPlanes(bytes, count);
  const numbers = new Uint32Array(count);
  const rows = count / row;
  for (let column = 0, i = 0; column < row; column++) {
    for (let k = 0, bits = 0; k < rows; k++, i++) {
      bits = (bits + differences[i]) >>> 0;
      numbers[k * row + column] = bits;
    }
  }
  return new Float32Array(numbers.buffer);
}

/** Numbers of two bytes as differences to those `row` places before, all low bytes first. */
export function fromDifferences(bytes: Uint8Array, count: number, row: number): Uint16Array {
  const numbers = new Uint16Array(count);
  for (let i = 0; i < count; i++) {
    numbers[i] = (bytes[i] | (bytes[count + i] << 8)) + (i < row ? 0 : numbers[i - row]);
  }
  return numbers;
}

/** Indices as distances from the first one not met so far. */
export function indicesFrom(bytes: Uint8Array, count: number): Uint32Array {
  const indices = fromPlanes(bytes, count);
  for (let i = 0, next = 0; i < count; i++) {
    indices[i] = next - indices[i];
    next = Math.max(next, indices[i] + 1);
  }
  return indices;
}
