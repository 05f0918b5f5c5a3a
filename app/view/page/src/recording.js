// Packs messages into the recording of a saved page, and takes them out again.
import { encode_mesh, encode_samples } from './messages.js';

const padded = (bytes) => (bytes + 7) & ~7;

/**
 * @param {(string | Uint8Array)[]} messages text or binary
 * @returns {Uint8Array} for each: u32 kind, u32 bytes, the bytes, filled up to a multiple of 8
 */
export function pack(messages) {
  const encoder = new TextEncoder();
  const parts = messages.map((message) => (typeof message === 'string' ? [0, encoder.encode(message)] : [1, message]));
  const bytes = new Uint8Array(parts.reduce((sum, [, part]) => sum + 8 + padded(part.length), 0));
  const view = new DataView(bytes.buffer);
  let at = 0;
  for (const [kind, part] of parts) {
    view.setUint32(at, kind, true);
    view.setUint32(at + 4, part.length, true);
    bytes.set(part, at + 8);
    at += 8 + padded(part.length);
  }
  return bytes;
}

/** @param {Uint8Array} bytes @returns {(string | Uint8Array)[]} what was packed; binary parts look into `bytes` */
export function unpack(bytes) {
  const decoder = new TextDecoder();
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const messages = [];
  let at = 0;
  while (at < bytes.length) {
    if (at + 8 > bytes.length) throw new Error('the recording is cut off');
    const kind = view.getUint32(at, true);
    const size = view.getUint32(at + 4, true);
    if (kind > 1 || at + 8 + size > bytes.length) throw new Error(`the recording is damaged at byte ${at}`);
    const part = bytes.subarray(at + 8, at + 8 + size);
    messages.push(kind === 0 ? decoder.decode(part) : part);
    at += 8 + padded(size);
  }
  return messages;
}

/** @param {Uint8Array} bytes @returns {string} */
export function to_base64(bytes) {
  let text = '';
  for (let i = 0; i < bytes.length; i += 0x6000) text += btoa(String.fromCharCode(...bytes.subarray(i, i + 0x6000)));
  return text;
}

/** @param {string} text @returns {Uint8Array} */
export function from_base64(text) {
  const binary = atob(text.replace(/\s+/g, ''));
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function through(bytes, transform) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(transform)).arrayBuffer());
}
export const gzip = (bytes) => through(bytes, new CompressionStream('gzip'));
export const gunzip = (bytes) => through(bytes, new DecompressionStream('gzip'));

/**
 * The messages that show again what a store keeps.
 * @param {object} hello
 * @param {import('./messages.js').Mesh[]} meshes
 * @param {import('./store.js').Store} store
 * @param {{time: number, message: object}[]} told the text messages that are kept with it
 * @param {{from: number, to: number}} span s
 * @returns {(string | Uint8Array)[]}
 */
export function messages_of(hello, meshes, store, told, span) {
  const messages = [JSON.stringify({ ...hello, mode: 'replay' }), ...meshes.map(encode_mesh)];
  const STEP = 2; // s of the run in a frame
  let frame = 0;
  let next_told = 0;
  const done = store.streams.map((stream) => Math.max(stream.start, stream.find(span.from)));
  for (let begin = span.from; begin < span.to || frame === 0; begin += STEP) {
    const end = Math.min(begin + STEP, span.to);
    const sections = [];
    const sets = [];
    store.streams.forEach((stream, index) => {
      const to = stream.find(end) + 1;
      const from = done[index];
      if (to <= from) return;
      done[index] = to;
      if (stream.set) {
        for (let i = from; i < to; ++i) {
          const values = stream.row(i);
          sets.push({ stream: index, set: true, n: stream.width ? values.length / stream.width : 0, times: [stream.times[i]], values });
        }
        return;
      }
      const values = new Float32Array((to - from) * stream.width);
      for (let i = from; i < to; ++i) values.set(stream.row(i), (i - from) * stream.width);
      sections.push({ stream: index, set: false, n: to - from, times: stream.times.slice(from, to), values });
    });
    messages.push(encode_samples(++frame, [{ end, sections: [...sections, ...sets] }]));
    while (next_told < told.length && told[next_told].time <= end) {
      const { time, message } = told[next_told++];
      if (time >= span.from) messages.push(JSON.stringify(message));
    }
  }
  messages.push('{"type": "complete"}');
  return messages;
}
