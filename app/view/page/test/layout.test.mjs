// The drawing of the graph: layers from left to right, loops led back, nothing on top of another.
import assert from 'node:assert/strict';
import test from 'node:test';
import { layout } from '../src/layout.js';

const SIZE = { node_width: 100, node_height: 40, gap_x: 50, gap_y: 10 };
const edge = (from, to) => ({ from, to });

test('a chain with a loop', () => {
  const { nodes, routes } = layout(['device', 'collision', 'coupling'], [edge('device', 'collision'), edge('collision', 'coupling'), edge('coupling', 'device')], SIZE);
  assert.deepEqual(['device', 'collision', 'coupling'].map((name) => nodes.get(name).layer), [0, 1, 2]);
  assert.deepEqual(routes.map((route) => route.back), [false, false, true]);
  assert.equal(routes[2].points.length, 4);
});

test('edges between the same nodes share a route, and unknown ends are left out', () => {
  const { routes } = layout(['a', 'b'], [edge('a', 'b'), edge('a', 'b'), edge('a', 'gone'), edge('a', 'a')], SIZE);
  assert.deepEqual(routes.map((route) => route.edges), [[0, 1]]);
});

test('nodes do not overlap', () => {
  const names = Array.from({ length: 12 }, (_, i) => `n${i}`);
  const edges = names.flatMap((name, i) => [edge(name, names[(i * 5 + 3) % 12]), edge(name, names[(i * 7 + 1) % 12])]);
  const { nodes, width, height } = layout(names, edges, SIZE);
  const list = [...nodes.values()];
  for (const a of list) {
    assert.ok(a.x >= 0 && a.y >= -1e-9 && a.x + 100 <= width + 1e-9 && a.y + 40 <= height + 1e-9);
    for (const b of list) if (a !== b) assert.ok(a.layer !== b.layer || Math.abs(a.y - b.y) >= 40 - 1e-6);
  }
});

test('an empty graph', () => {
  assert.equal(layout([], [], SIZE).nodes.size, 0);
});
