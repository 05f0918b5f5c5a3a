// The bytes of docs/view_protocol.md: frames of samples, meshes, and recordings packed into a page.

/**
 * @typedef {{kind: 'rows'|'set', stream: number, times: Float64Array, values: Float32Array, rows: number}} Section
 *   Rows have a time each, in s; a set has one. `values` holds `rows` rows of the stream's columns.
 */

class Reader {
  /** @param {ArrayBuffer} buffer */
  constructor(buffer) {
    this.buffer = buffer;
    this.view = new DataView(buffer);
    this.at = 0;
  }
  need(bytes) {
    if (this.at + bytes > this.buffer.byteLength) throw new Error(`a message ends after ${this.buffer.byteLength} bytes, ${this.at + bytes} were expected`);
  }
  u16() { this.need(2); this.at += 2; return this.view.getUint16(this.at - 2, true); }
  u32() { this.need(4); this.at += 4; return this.view.getUint32(this.at - 4, true); }
  u64() { this.need(8); this.at += 8; return Number(this.view.getBigUint64(this.at - 8, true)); }
  f64() { this.need(8); this.at += 8; return this.view.getFloat64(this.at - 8, true); }
  array(Type, count) {
    this.need(count * Type.BYTES_PER_ELEMENT);
    const array = new Type(this.buffer, this.at, count);
    this.at += array.byteLength;
    return array;
  }
  align() { this.at = Math.ceil(this.at / 8) * 8; }
}

/** What a binary message is: 1 samples, 2 a mesh. */
export function kindOf(buffer) {
  return new Reader(buffer).u32();
}

/**
 * @param {ArrayBuffer} buffer
 * @param {number[]} columns by stream
 * @returns {{number: number, chunks: {end: number, sections: Section[]}[]}}
 */
export function readFrame(buffer, columns) {
  const reader = new Reader(buffer);
  reader.u32();
  const count = reader.u32();
  const number = reader.u64();
  const chunks = [];
  for (let c = 0; c < count; ++c) {
    const begin = reader.at;
    const bytes = reader.u32();
    const sections = [];
    const sectionCount = reader.u32();
    const end = reader.f64();
    for (let s = 0; s < sectionCount; ++s) {
      const kind = reader.u16() === 0 ? 'rows' : 'set';
      const stream = reader.u16();
      const rows = reader.u32();
      if (stream >= columns.length) throw new Error(`a frame has stream ${stream}, of ${columns.length}`);
      const times = reader.array(Float64Array, kind === 'rows' ? rows : 1);
      const values = reader.array(Float32Array, rows * columns[stream]);
      reader.align();
      sections.push({kind, stream, times, values, rows});
    }
    if (reader.at !== begin + bytes) throw new Error(`a chunk is ${reader.at - begin} bytes long and says ${bytes}`);
    chunks.push({end, sections});
  }
  return {number, chunks};
}

/** @returns {{index: number, positions: Float32Array, triangles: Uint32Array}} positions in m, x y z by vertex */
export function readMesh(buffer) {
  const reader = new Reader(buffer);
  reader.u32();
  const index = reader.u32();
  const vertices = reader.u32();
  const triangles = reader.u32();
  return {index, positions: reader.array(Float32Array, 3 * vertices), triangles: reader.array(Uint32Array, 3 * triangles)};
}

/** Messages, texts and ArrayBuffers, as one block of bytes. */
export function pack(messages) {
  const encoder = new TextEncoder();
  const parts = messages.map((m) => typeof m === 'string' ? {kind: 0, bytes: encoder.encode(m)} : {kind: 1, bytes: new Uint8Array(m)});
  const size = parts.reduce((sum, p) => sum + 8 + Math.ceil(p.bytes.length / 8) * 8, 0);
  const packed = new Uint8Array(size);
  const view = new DataView(packed.buffer);
  let at = 0;
  for (const {kind, bytes} of parts) {
    view.setUint32(at, kind, true);
    view.setUint32(at + 4, bytes.length, true);
    packed.set(bytes, at + 8);
    at += 8 + Math.ceil(bytes.length / 8) * 8;
  }
  return packed;
}

/** The messages of such a block. @param {Uint8Array} packed */
export function unpack(packed) {
  const buffer = packed.buffer.slice(packed.byteOffset, packed.byteOffset + packed.byteLength);
  const reader = new Reader(buffer);
  const messages = [];
  while (reader.at < buffer.byteLength) {
    const kind = reader.u32();
    const size = reader.u32();
    reader.need(size);
    const bytes = buffer.slice(reader.at, reader.at + size);
    messages.push(kind === 0 ? new TextDecoder().decode(bytes) : bytes);
    reader.at += size;
    reader.align();
  }
  return messages;
}

async function through(stream, bytes) {
  const answer = new Response(new Blob([bytes]).stream().pipeThrough(stream));
  return new Uint8Array(await answer.arrayBuffer());
}

/** Base64 of gzip of the packed messages, as it stands in a saved page. */
export async function toText(messages) {
  const bytes = await through(new CompressionStream('gzip'), pack(messages));
  let text = '';
  const part = 0x8000 - 0x8000 % 3;
  for (let i = 0; i < bytes.length; i += part) text += btoa(String.fromCharCode(...bytes.subarray(i, i + part)));
  return text;
}

/** The messages of such a text. */
export async function fromText(text) {
  const binary = atob(text.trim());
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return unpack(await through(new DecompressionStream('gzip'), bytes));
}

const aligned = (bytes) => Math.ceil(bytes / 8) * 8;

/** A frame with one chunk of these sections. @param {Section[]} sections */
export function writeFrame(number, end, sections) {
  const sizes = sections.map((s) => 8 + 8 * s.times.length + aligned(4 * s.values.length));
  const size = 32 + sizes.reduce((a, b) => a + b, 0);
  const buffer = new ArrayBuffer(size);
  const view = new DataView(buffer);
  view.setUint32(0, 1, true);
  view.setUint32(4, 1, true);
  view.setBigUint64(8, BigInt(number), true);
  view.setUint32(16, size - 16, true);
  view.setUint32(20, sections.length, true);
  view.setFloat64(24, end, true);
  let at = 32;
  sections.forEach((section, i) => {
    view.setUint16(at, section.kind === 'rows' ? 0 : 1, true);
    view.setUint16(at + 2, section.stream, true);
    view.setUint32(at + 4, section.rows, true);
    new Float64Array(buffer, at + 8, section.times.length).set(section.times);
    new Float32Array(buffer, at + 8 + 8 * section.times.length, section.values.length).set(section.values);
    at += sizes[i];
  });
  return buffer;
}

/** @param {{index: number, positions: Float32Array, triangles: Uint32Array}} mesh */
export function writeMesh(mesh) {
  const buffer = new ArrayBuffer(16 + mesh.positions.byteLength + mesh.triangles.byteLength);
  new Uint32Array(buffer, 0, 4).set([2, mesh.index, mesh.positions.length / 3, mesh.triangles.length / 3]);
  new Float32Array(buffer, 16, mesh.positions.length).set(mesh.positions);
  new Uint32Array(buffer, 16 + mesh.positions.byteLength, mesh.triangles.length).set(mesh.triangles);
  return buffer;
}
