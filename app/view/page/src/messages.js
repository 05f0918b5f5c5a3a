// Decodes and encodes the binary messages of the view's protocol (docs/reference/view_protocol.md), and checks all sizes.

/** A message that does not keep to the protocol. */
export class ProtocolError extends Error {}

const SAMPLES = 1;
const MESH = 2;
/** The roles whose streams are sets: each replaces the one before. */
export const SET_ROLES = new Set(['contacts', 'patch', 'surface']);

const padded = (bytes) => (bytes + 7) & ~7;

/**
 * @typedef {{kind: 'mesh', index: number, positions: Float32Array, indices: Uint32Array}} Mesh
 *   positions in m, 3 a vertex; indices, 3 a triangle
 * @typedef {{stream: number, set: boolean, n: number, times: Float64Array, values: Float32Array}} Section
 *   times in s: n of rows, 1 of a set; values: n rows of the stream's columns
 * @typedef {{end: number, sections: Section[]}} Chunk
 * @typedef {{kind: 'samples', frame: number, chunks: Chunk[]}} Samples
 */

/**
 * @param {Uint8Array} bytes one message
 * @param {{name: string, role: string, columns: object[]}[]} streams as in hello
 * @returns {Mesh | Samples} arrays that look into the message where it is aligned
 */
export function decode_binary(bytes, streams) {
  if (bytes.byteOffset % 8 !== 0) bytes = bytes.slice();
  if (bytes.byteLength < 16) throw new ProtocolError(`a binary message of ${bytes.byteLength} bytes`);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const kind = view.getUint32(0, true);
  if (kind === MESH) return decode_mesh(bytes, view);
  if (kind === SAMPLES) return decode_samples(bytes, view, streams);
  throw new ProtocolError(`a binary message of unknown kind ${kind}`);
}

function decode_mesh(bytes, view) {
  const index = view.getUint32(4, true);
  const vertices = view.getUint32(8, true);
  const triangles = view.getUint32(12, true);
  const need = 16 + 12 * vertices + 12 * triangles;
  if (bytes.byteLength !== need && bytes.byteLength !== padded(need))
    throw new ProtocolError(`mesh ${index} has ${bytes.byteLength} bytes, its header says ${need}`);
  const positions = new Float32Array(bytes.buffer, bytes.byteOffset + 16, 3 * vertices);
  const indices = new Uint32Array(bytes.buffer, bytes.byteOffset + 16 + 12 * vertices, 3 * triangles);
  for (const i of indices) if (i >= vertices) throw new ProtocolError(`mesh ${index} names vertex ${i} of ${vertices}`);
  return { kind: 'mesh', index, positions, indices };
}

function decode_samples(bytes, view, streams) {
  const count = view.getUint32(4, true);
  const frame = Number(view.getBigUint64(8, true));
  const chunks = [];
  let at = 16;
  for (let c = 0; c < count; ++c) {
    if (at + 16 > bytes.byteLength) throw new ProtocolError(`frame ${frame}: chunk ${c} begins behind the end`);
    const size = view.getUint32(at, true);
    const sections = view.getUint32(at + 4, true);
    const chunk_end = at + size;
    if (size < 16 || size % 8 !== 0 || chunk_end > bytes.byteLength)
      throw new ProtocolError(`frame ${frame}: chunk ${c} of ${size} bytes at ${at} does not fit into ${bytes.byteLength}`);
    const chunk = { end: view.getFloat64(at + 8, true), sections: [] };
    at += 16;
    for (let s = 0; s < sections; ++s) {
      if (at + 8 > chunk_end) throw new ProtocolError(`frame ${frame}: section ${s} begins behind the end of its chunk`);
      const section_kind = view.getUint16(at, true);
      const stream = view.getUint16(at + 2, true);
      const n = view.getUint32(at + 4, true);
      const told = streams[stream];
      if (!told) throw new ProtocolError(`frame ${frame}: stream ${stream} of ${streams.length}`);
      const set = section_kind === 1;
      if (section_kind > 1 || set !== SET_ROLES.has(told.role))
        throw new ProtocolError(`frame ${frame}: a section of kind ${section_kind} for ${told.role} (${told.name})`);
      const times = set ? 1 : n;
      const need = 8 * times + padded(4 * n * told.columns.length);
      at += 8;
      if (at + need > chunk_end) throw new ProtocolError(`frame ${frame}: ${n} rows of ${told.name} do not fit into their chunk`);
      chunk.sections.push({
        stream,
        set,
        n,
        times: new Float64Array(bytes.buffer, bytes.byteOffset + at, times),
        values: new Float32Array(bytes.buffer, bytes.byteOffset + at + 8 * times, n * told.columns.length),
      });
      at += need;
    }
    if (at !== chunk_end) throw new ProtocolError(`frame ${frame}: chunk ${c} has ${chunk_end - at} bytes too many`);
    chunks.push(chunk);
  }
  if (at !== bytes.byteLength) throw new ProtocolError(`frame ${frame} has ${bytes.byteLength - at} bytes too many`);
  return { kind: 'samples', frame, chunks };
}

/** @param {Mesh} mesh @returns {Uint8Array} the message */
export function encode_mesh(mesh) {
  const bytes = new Uint8Array(16 + mesh.positions.byteLength + mesh.indices.byteLength);
  new Uint32Array(bytes.buffer, 0, 4).set([MESH, mesh.index, mesh.positions.length / 3, mesh.indices.length / 3]);
  new Float32Array(bytes.buffer, 16, mesh.positions.length).set(mesh.positions);
  new Uint32Array(bytes.buffer, 16 + mesh.positions.byteLength, mesh.indices.length).set(mesh.indices);
  return bytes;
}

/**
 * @param {number} frame
 * @param {Chunk[]} chunks
 * @returns {Uint8Array} the message
 */
export function encode_samples(frame, chunks) {
  const size_of = (section) => 8 + 8 * section.times.length + padded(4 * section.values.length);
  const chunk_sizes = chunks.map((chunk) => 16 + chunk.sections.reduce((sum, section) => sum + size_of(section), 0));
  const bytes = new Uint8Array(16 + chunk_sizes.reduce((a, b) => a + b, 0));
  const view = new DataView(bytes.buffer);
  view.setUint32(0, SAMPLES, true);
  view.setUint32(4, chunks.length, true);
  view.setBigUint64(8, BigInt(frame), true);
  let at = 16;
  chunks.forEach((chunk, c) => {
    view.setUint32(at, chunk_sizes[c], true);
    view.setUint32(at + 4, chunk.sections.length, true);
    view.setFloat64(at + 8, chunk.end, true);
    at += 16;
    for (const section of chunk.sections) {
      view.setUint16(at, section.set ? 1 : 0, true);
      view.setUint16(at + 2, section.stream, true);
      view.setUint32(at + 4, section.n, true);
      new Float64Array(bytes.buffer, at + 8, section.times.length).set(section.times);
      new Float32Array(bytes.buffer, at + 8 + 8 * section.times.length, section.values.length).set(section.values);
      at += size_of(section);
    }
  });
  return bytes;
}
