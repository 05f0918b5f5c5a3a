// What charts and knobs compute: rows by time, pixel columns, slider places.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Timeline } from '../src/charts.js';
import { column_grid, column_times, decimate, leave_out } from '../src/decimate.js';
import { first_parameters, from_slider, is_log, to_slider } from '../src/knobs.js';
import { Rows, Store } from '../src/store.js';

const FORCE = { role: 'physics', name: 'f', columns: ['x', 'y', 'z'].map((axis) => ({ name: `force.${axis}`, unit: 'N' })) };
const COUNT = { role: 'contact_count', name: 'c', columns: [{ name: 'contacts', unit: '' }] };

function counted(values, dt = 0.001) {
  const rows = new Rows(COUNT, Infinity);
  rows.append(values.map((_, i) => i * dt), values);
  return rows;
}

test('norms and the rate are made of the samples', () => {
  const rows = new Rows(FORCE, Infinity);
  rows.append([0, 0.01, 0.03], [3, 4, 0, 0, 0, 2, 1, 2, 2]);
  const of = (name) => [0, 1, 2].map((i) => rows.values[i * rows.stride + rows.column[name]]);
  assert.deepEqual(of('force.norm'), [5, 2, 3]);
  assert.deepEqual(of('rate').map((v) => Math.round(v)), [NaN, 100, 50]);
  assert.deepEqual([...rows.row(1)], [0, 0, 2]);
});

test('the history is bounded, and rows are found by time', () => {
  const rows = new Rows(COUNT, 1);
  for (let i = 0; i < 10000; ++i) rows.append([i / 1000], [i]);
  assert.equal(rows.size, 1001);
  assert.ok(rows.times.length <= 4096);
  assert.equal(rows.row(rows.find(9.5004))[0], 9500);
  assert.equal(rows.find(1), rows.start - 1);
  rows.append([3], [0]);
  assert.equal(rows.unordered, 1);
});

test('no peak is lost', () => {
  const values = Array.from({ length: 1000 }, (_, i) => (i === 501 ? 9 : i === 503 ? -9 : 0));
  const out = [];
  const grid = column_grid(0, 1, 100);
  decimate(counted(values), 0, grid.t0, grid.dt, grid.columns, false, 1, out);
  assert.deepEqual(out.slice(100, 102), [9, -9]);
  const times = [];
  column_times(grid, times);
  assert.equal(times.length, out.length);
  assert.ok(times.every((t, i) => i === 0 || t > times[i - 1]));
});

test('a held value fills the columns until the next', () => {
  const out = [];
  decimate(counted([1, 2], 0.5), 0, 0, 0.1, 10, true, 0.75, out);
  assert.deepEqual(out, [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, null, null, null, null]);
});

test('a curve of few samples goes on to both sides', () => {
  const out = [];
  decimate(counted([0, 10], 1), 0, 0.4, 0.02, 10, false, 1, out);
  assert.ok(Math.abs(out[0] - 4.05) < 1e-6);
  assert.ok(Math.abs(out[19] - 5.95) < 1e-6);
  assert.ok(out.slice(1, 19).every((v) => v === null));
});

test('five curves of 10 s at 1 kHz are reduced in time for a redraw', () => {
  const rows = counted(Array.from({ length: 10000 }, (_, i) => Math.sin(i)));
  const out = [];
  const begin = performance.now();
  for (let i = 0; i < 100; ++i) decimate(rows, 0, 0, 0.0125, 800, false, 10, out);
  assert.ok((performance.now() - begin) / 20 < 20, 'ms for five curves');
});

/** Rows of a role with samples at these times in s. */
function sampled(role, times) {
  const rows = new Rows({ ...FORCE, role }, Infinity);
  rows.append(times, times.flatMap(() => [1, 0, 0]));
  return rows;
}
const every = (dt, from, to) => Array.from({ length: Math.round((to - from) / dt) }, (_, i) => from + i * dt);

test('missing samples are a gap, a missed tick is none', () => {
  const rows = sampled('commanded', [...every(0.001, 0, 1), ...every(0.001, 1.004, 2), ...every(0.001, 2.5, 3)]);
  assert.deepEqual(rows.gaps.map((gap) => gap.map((t) => Number(t.toFixed(3)))), [[1.999, 2.5]]);
});

test('slow and uneven physics has no gaps', () => {
  assert.deepEqual(sampled('physics', every(0.05, 0, 5)).gaps, []);
  assert.deepEqual(sampled('physics', [...every(0.001, 0, 1), ...every(0.04, 1, 3)]).gaps, []);
});

test('a stream that has become slower is followed', () => {
  assert.ok(sampled('commanded', [...every(0.001, 0, 1), ...every(0.05, 1, 11)]).gaps.every((gap) => gap[1] < 3));
});

test('a gap goes on until the next sample', () => {
  const rows = sampled('commanded', every(0.001, 0, 1));
  assert.deepEqual(rows.gaps_until(1.01), []);
  assert.deepEqual(rows.gaps_until(1.5).map((gap) => gap[1]), [Infinity]);
});

test('no value is held through a gap', () => {
  const rows = sampled('physics', [...every(0.01, 0, 1), ...every(0.01, 2, 3)]);
  const out = [];
  const grid = column_grid(0, 3, 30);
  decimate(rows, rows.column['force.norm'], grid.t0, grid.dt, grid.columns, true, 3, out);
  leave_out(rows.gaps_until(3), grid, out);
  assert.deepEqual([5, 12, 17, 25].map((c) => out[2 * c + 1]), [1, null, null, 1]);
});

test('a store takes sections of rows and sets', () => {
  const store = new Store({ mode: 'live', streams: [COUNT, { role: 'patch', name: 'p', columns: [{ name: 'p.x' }] }] });
  store.take({ chunks: [{ end: 0.02, sections: [{ stream: 0, n: 2, set: false, times: [0.001, 0.002], values: [1, 2] },
    { stream: 1, n: 1, set: true, times: [0.01], values: Float32Array.of(7) }] }] });
  assert.deepEqual([store.now, store.begin, store.taken.c, store.taken.p], [0.02, 0.001, 2, 1]);
  assert.deepEqual([...store.role('patch').row(store.role('patch').find(1))], [7]);
  assert.equal(store.role('patch').find(0.005), -1);
});

test('the first parameters are those that nodes declare first', () => {
  const names = ['device.force_max', 'device.torque_max', 'coupling.k_0', 'coupling.m_0', 'coupling.a', 'select.use', 'select.blend_time'];
  assert.deepEqual([...first_parameters(names, 'select.use')], ['device.force_max', 'coupling.k_0', 'select.blend_time', 'device.torque_max', 'coupling.m_0']);
  assert.deepEqual([...first_parameters(['a.x', 'a.y'])], ['a.x', 'a.y']);
});

test('sliders go by decades where both bounds are positive and far apart', () => {
  const stiffness = { kind: 'real', min: 10, max: 100000 };
  assert.ok(is_log(stiffness));
  assert.equal(from_slider(stiffness, 0.5), 1000);
  assert.equal(to_slider(stiffness, 1000), 0.5);
  const order = { kind: 'integer', min: 0, max: 10 };
  assert.ok(!is_log(order));
  assert.equal(from_slider(order, 0.33), 3);
  assert.equal(from_slider(stiffness, 1), 100000);
});

test('a window ends with the samples, and is no longer than a replay', () => {
  const timeline = new Timeline();
  assert.deepEqual(timeline.range(2), [0, 5]);
  assert.deepEqual(timeline.range(12), [7, 12]);
  timeline.whole = 3;
  timeline.ahead = 0.25;
  for (const now of [0, 1, 3]) assert.deepEqual(timeline.range(now), [0, 3]);
  timeline.whole = 20;
  assert.deepEqual(timeline.range(10), [6.25, 11.25]);
  assert.deepEqual(timeline.range(20), [15, 20]);
});
