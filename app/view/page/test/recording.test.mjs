// A saved page: messages packed and taken out again, and a store written and read again.
import assert from 'node:assert/strict';
import test from 'node:test';
import { decode_binary } from '../src/messages.js';
import { from_base64, gunzip, gzip, messages_of, pack, to_base64, unpack } from '../src/recording.js';
import { Store } from '../src/store.js';

test('parts lie at multiples of 8 and come out as they went in', () => {
  const packed = pack(['{"ü": 1}', Uint8Array.of(1, 2, 3), Uint8Array.of()]);
  assert.deepEqual([...packed.slice(0, 8)], [0, 0, 0, 0, 9, 0, 0, 0]);
  assert.deepEqual([...packed.slice(24, 35)], [1, 0, 0, 0, 3, 0, 0, 0, 1, 2, 3]);
  assert.equal(packed.length, 48);
  assert.deepEqual(unpack(packed), ['{"ü": 1}', Uint8Array.of(1, 2, 3), Uint8Array.of()]);
  assert.throws(() => unpack(packed.slice(0, 30)), /cut off|damaged/);
});

test('gzip and base64 there and back', async () => {
  const bytes = Uint8Array.from({ length: 100001 }, (_, i) => (i * i) & 255);
  assert.deepEqual(await gunzip(from_base64(to_base64(await gzip(bytes)))), bytes);
  assert.deepEqual(from_base64(' AQ\nID '), Uint8Array.of(1, 2, 3));
});

test('what a store keeps is the same after it was saved', () => {
  const hello = { type: 'hello', mode: 'live', streams: [{ role: 'commanded', name: 'f', columns: ['x', 'y', 'z'].map((axis) => ({ name: `force.${axis}` })) },
    { role: 'contacts', name: 'c', columns: [{ name: 'p.x' }, { name: 'p.y' }, { name: 'p.z' }] }] };
  const store = new Store(hello);
  for (let k = 0; k < 5000; ++k) {
    const t = k / 1000;
    const sections = [{ stream: 0, set: false, n: 1, times: [t], values: [k, 2 * k, 3 * k] }];
    if (k % 10 === 0) sections.push({ stream: 1, set: true, n: (k / 10) % 3, times: [t], values: new Float32Array(3 * ((k / 10) % 3)).fill(k) });
    store.take({ chunks: [{ end: t, sections }] });
  }
  const told = [{ time: 1.5, message: { type: 'set', parameter: 'a', value: 1 } }, { time: 0.1, message: {} }].sort((a, b) => a.time - b.time);
  const mesh = { index: 0, positions: new Float32Array(9), indices: Uint32Array.of(0, 1, 2) };
  const messages = messages_of(hello, [mesh], store, told, { from: 0.5, to: store.now });
  const again_hello = JSON.parse(messages[0]);
  assert.equal(again_hello.mode, 'replay');
  const again = new Store(again_hello);
  const texts = [];
  const frames = [];
  for (const message of messages.slice(1)) {
    if (typeof message === 'string') texts.push(JSON.parse(message));
    else {
      const decoded = decode_binary(message, hello.streams);
      if (decoded.kind === 'mesh') continue;
      frames.push(decoded.frame);
      again.take(decoded);
    }
  }
  assert.deepEqual(texts.map((text) => text.type), ['set', 'complete']);
  assert.deepEqual(frames, [1, 2, 3]);
  assert.equal(again.now, store.now);
  const [rows, sets] = again.streams;
  assert.deepEqual([rows.first_time, rows.last_time, rows.size], [0.5, 4.999, 4500]);
  for (let i = 0; i < rows.size; ++i) assert.deepEqual(rows.row(i), store.streams[0].row(i + 500));
  assert.equal(sets.size, 450);
  for (const t of [0.5, 1.234, 4.9]) assert.deepEqual(sets.row(sets.find(t)), store.streams[1].row(store.streams[1].find(t)));
});
