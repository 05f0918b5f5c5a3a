// Decoding against bytes made by hand, and refusal of what does not keep to the protocol.
import assert from 'node:assert/strict';
import test from 'node:test';
import { ProtocolError, decode_binary, encode_mesh, encode_samples } from '../src/messages.js';

const STREAMS = [
  { role: 'physics', name: 'coupling.force', columns: [{ name: 'force.x' }, { name: 'force.y' }, { name: 'force.z' }] },
  { role: 'contact_count', name: 'contacts', columns: [{ name: 'contacts' }] },
  { role: 'patch', name: 'patch', columns: ['p.x', 'p.y', 'p.z', 'n.x', 'n.y', 'n.z'].map((name) => ({ name })) },
];

/** Little-endian bytes of [type, value] pairs. */
function bytes_of(...fields) {
  const size = { u16: 2, u32: 4, u64: 8, f32: 4, f64: 8 };
  const bytes = new Uint8Array(fields.reduce((sum, [type]) => sum + size[type], 0));
  const view = new DataView(bytes.buffer);
  let at = 0;
  for (const [type, value] of fields) {
    if (type === 'u16') view.setUint16(at, value, true);
    else if (type === 'u32') view.setUint32(at, value, true);
    else if (type === 'u64') view.setBigUint64(at, BigInt(value), true);
    else if (type === 'f32') view.setFloat32(at, value, true);
    else view.setFloat64(at, value, true);
    at += size[type];
  }
  return bytes;
}

// One row of three columns: 8 header + 8 time + 12 values + 4 padding = 32. A set of two rows: 8 + 8 + 48 = 64.
const FRAME = bytes_of(['u32', 1], ['u32', 2], ['u64', 17],
  ['u32', 48], ['u32', 1], ['f64', 0.5],
  ['u16', 0], ['u16', 0], ['u32', 1], ['f64', 0.25], ['f32', 1], ['f32', 2], ['f32', 3], ['u32', 0],
  ['u32', 104], ['u32', 2], ['f64', 0.75],
  ['u16', 1], ['u16', 2], ['u32', 2], ['f64', 0.6], ...Array.from({ length: 12 }, (_, i) => ['f32', i]),
  ['u16', 0], ['u16', 1], ['u32', 1], ['f64', 0.7], ['f32', 4], ['u32', 0]);

test('samples are read at their offsets', () => {
  const message = decode_binary(FRAME, STREAMS);
  assert.equal(message.frame, 17);
  assert.deepEqual(message.chunks.map((chunk) => chunk.end), [0.5, 0.75]);
  const [row] = message.chunks[0].sections;
  assert.deepEqual([row.stream, row.set, row.n, [...row.times], [...row.values]], [0, false, 1, [0.25], [1, 2, 3]]);
  const [set, count] = message.chunks[1].sections;
  assert.deepEqual([set.stream, set.set, set.n, [...set.times], [...set.values]], [2, true, 2, [0.6], [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]]);
  assert.deepEqual([count.stream, [...count.times], [...count.values]], [1, [0.7], [4]]);
});

test('a message that does not begin at a multiple of 8 is read too', () => {
  const shifted = new Uint8Array(FRAME.length + 4);
  shifted.set(FRAME, 4);
  assert.equal(decode_binary(shifted.subarray(4), STREAMS).chunks.length, 2);
});

test('what is encoded is the same bytes', () => {
  const { frame, chunks } = decode_binary(FRAME, STREAMS);
  assert.deepEqual(encode_samples(frame, chunks), FRAME);
});

test('an empty set and no rows at all', () => {
  const bytes = encode_samples(1, [{ end: 1, sections: [{ stream: 2, set: true, n: 0, times: [0.5], values: new Float32Array(0) },
    { stream: 0, set: false, n: 0, times: [], values: new Float32Array(0) }] }]);
  const [set, rows] = decode_binary(bytes, STREAMS).chunks[0].sections;
  assert.deepEqual([set.n, set.times.length, rows.n, rows.times.length], [0, 1, 0, 0]);
});

test('a message of any wrong size is refused', () => {
  for (let size = 0; size < FRAME.length; ++size) assert.throws(() => decode_binary(FRAME.slice(0, size), STREAMS), ProtocolError, `${size} bytes`);
  const long = new Uint8Array(FRAME.length + 8);
  long.set(FRAME);
  assert.throws(() => decode_binary(long, STREAMS), ProtocolError);
});

test('unknown kinds, streams and a set for rows are refused', () => {
  const changed = (at, value) => {
    const bytes = FRAME.slice();
    new DataView(bytes.buffer).setUint16(at, value, true);
    return bytes;
  };
  assert.throws(() => decode_binary(changed(0, 3), STREAMS), /unknown kind 3/);
  assert.throws(() => decode_binary(changed(34, 9), STREAMS), /stream 9 of 3/);
  assert.throws(() => decode_binary(changed(32, 1), STREAMS), /kind 1 for physics/);
  assert.throws(() => decode_binary(changed(36, 2), STREAMS), /do not fit/);
});

test('a mesh', () => {
  const bytes = bytes_of(['u32', 2], ['u32', 5], ['u32', 3], ['u32', 1], ...[0, 0, 0, 1, 0, 0, 0, 1, 0].map((v) => ['f32', v]), ['u32', 0], ['u32', 1], ['u32', 2]);
  const mesh = decode_binary(bytes, []);
  assert.deepEqual([mesh.index, [...mesh.positions], [...mesh.indices]], [5, [0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2]]);
  assert.deepEqual(encode_mesh(mesh), bytes);
  assert.throws(() => decode_binary(bytes.slice(0, -4), []), ProtocolError);
  const beyond = bytes.slice();
  beyond[beyond.length - 4] = 3;
  assert.throws(() => decode_binary(beyond, []), /vertex 3 of 3/);
});
