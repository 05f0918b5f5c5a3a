// The shapes of meshes.
import assert from 'node:assert/strict';
import test from 'node:test';
import { DeformingSurface, creased_normals, edges_of, mesh_geometry, wires_of } from '../src/geometry.js';

/** A cube of 2 m round the origin, its vertices shared by its faces. */
function cube() {
  const positions = new Float32Array([...Array(8).keys()].flatMap((i) => [i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1]));
  const quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  return { positions, indices: new Uint32Array(quads.flatMap(([a, b, c, d]) => [a, b, c, a, c, d])) };
}

/** A ball of radius 1 m, of as many rings. */
function ball(rings) {
  const positions = [], indices = [], round = 2 * rings;
  for (let i = 0; i <= rings; ++i) {
    for (let k = 0; k < round; ++k) {
      const [a, b] = [(Math.PI * i) / rings, (Math.PI * 2 * k) / round];
      positions.push(Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a));
      if (i === rings) continue;
      const at = (row, column) => row * round + (column % round);
      if (i < rings - 1) indices.push(at(i, k), at(i + 1, k), at(i + 1, k + 1));
      if (i > 0) indices.push(at(i, k), at(i + 1, k + 1), at(i, k + 1));
    }
  }
  return { positions: new Float32Array(positions), indices: new Uint32Array(indices) };
}

test('edges of a cube are sharp: each corner has the normal of its face', () => {
  const mesh = cube(), normals = creased_normals(mesh);
  assert.equal(normals.length, 3 * mesh.indices.length);
  for (let corner = 0; corner < mesh.indices.length; ++corner) {
    const face = 3 * Math.floor(corner / 3);
    const centre = [0, 1, 2].map((axis) => [0, 1, 2].reduce((sum, k) => sum + mesh.positions[3 * mesh.indices[face + k] + axis] / 3, 0));
    // The centre of a half of a face lies in its plane, one metre out.
    const axis = centre.findIndex((x) => Math.abs(Math.abs(x) - 1) < 1e-6);
    const expected = [0, 0, 0];
    expected[axis] = Math.sign(centre[axis]);
    assert.deepEqual([...normals.subarray(3 * corner, 3 * corner + 3)].map((x) => Math.round(x * 1e6) / 1e6 + 0), expected);
  }
});

test('a ball is round: its normals point from its centre, at every corner', () => {
  const mesh = ball(16), normals = creased_normals(mesh);
  for (let corner = 0; corner < mesh.indices.length; ++corner) {
    const p = mesh.positions.subarray(3 * mesh.indices[corner]);
    const n = normals.subarray(3 * corner);
    // The poles are degenerate: their vertices lie in one place and meet no other face.
    if (Math.hypot(p[0], p[1]) < 0.3) continue;
    assert.ok(p[0] * n[0] + p[1] * n[1] + p[2] * n[2] > 0.98);
  }
});

test('small and large meshes get normals of length 1 at each vertex that is drawn', () => {
  for (const rings of [8, 64]) {
    const geometry = mesh_geometry(ball(rings));
    const { position, normal } = geometry.attributes;
    assert.equal(normal.count, position.count);
    let lengths = 0;
    for (let i = 0; i < normal.count; ++i) lengths += Math.abs(Math.hypot(normal.getX(i), normal.getY(i), normal.getZ(i)) - 1) < 1e-5;
    assert.ok(lengths >= 0.97 * normal.count);
  }
});

test('the wire model has no more edges than are seen, inside the bounds of the mesh', () => {
  const wires = wires_of(ball(64)).attributes.position;
  assert.ok(wires.count > 100 && wires.count < 6000);
  for (const x of wires.array) assert.ok(Math.abs(x) <= 1.0001);
});

test('a surface that is turned as a whole has the normals of the body, turned', () => {
  for (const mesh of [cube(), ball(16)]) {
    const surface = new DeformingSurface(mesh);
    assert.equal(surface.vertices, mesh.positions.length / 3);
    assert.deepEqual(surface.geometry.attributes.normal.array, creased_normals(mesh));
    // By a right angle about z, and one metre along x.
    const turned = Float32Array.from(mesh.positions, (_, i) => {
      const v = i - (i % 3);
      return [1 - mesh.positions[v + 1], mesh.positions[v], mesh.positions[v + 2]][i % 3];
    });
    const rest = surface.geometry.attributes.normal.array.slice();
    surface.show(turned);
    const { position, normal } = surface.geometry.attributes;
    for (let corner = 0; corner < mesh.indices.length; ++corner) {
      assert.equal(position.getX(corner), turned[3 * mesh.indices[corner]]);
      const expected = [-rest[3 * corner + 1], rest[3 * corner], rest[3 * corner + 2]];
      for (let k = 0; k < 3; ++k) assert.ok(Math.abs(normal.array[3 * corner + k] - expected[k]) < 1e-5);
    }
    assert.ok(Math.abs(surface.geometry.boundingSphere.center.x - 1) < 1e-5);
  }
});

test('an edge of the shape at rest stays an edge when the body is stretched', () => {
  const mesh = cube(), surface = new DeformingSurface(mesh);
  surface.show(Float32Array.from(mesh.positions, (x, i) => (i % 3 === 2 ? 3 * x : x)));
  const normal = surface.geometry.attributes.normal;
  for (let corner = 0; corner < normal.count; ++corner) {
    const parts = [normal.getX(corner), normal.getY(corner), normal.getZ(corner)].map(Math.abs);
    assert.ok(Math.abs(Math.max(...parts) - 1) < 1e-6);
  }
});

test('a closed surface has three edges for two faces, which follow when it deforms', () => {
  for (const { mesh, edges } of [{ mesh: cube(), edges: 18 }, { mesh: ball(16), edges: null }]) {
    const found = edges_of(mesh.indices);
    if (edges) assert.equal(found.length, 2 * edges);
    const pairs = new Set();
    for (let i = 0; i < found.length; i += 2) {
      const [a, b] = [mesh.indices[found[i]], mesh.indices[found[i + 1]]];
      assert.notEqual(a, b);
      pairs.add(`${Math.min(a, b)},${Math.max(a, b)}`);
    }
    assert.equal(pairs.size, found.length / 2);
  }
  const mesh = cube(), surface = new DeformingSurface(mesh);
  surface.show(Float32Array.from(mesh.positions, (x) => 2 * x));
  const { index, attributes: { position } } = surface.edges;
  assert.equal(index.count, 36);
  for (let i = 0; i < index.count; ++i) assert.equal(Math.abs(position.getX(index.getX(i))), 2);
});
