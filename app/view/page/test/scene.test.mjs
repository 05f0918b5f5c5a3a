// Where the surfaces of bodies that deform are drawn, without a canvas.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Object3D } from 'three';
import { DeformingSurface } from '../src/geometry.js';
import { SceneView } from '../src/scene.js';

/** A tetrahedron of that size. */
function tetrahedron(size) {
  return { positions: new Float32Array([0, 0, 0, size, 0, 0, 0, size, 0, 0, 0, size]), indices: new Uint32Array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]) };
}

/** Two bodies that deform, and a rigid one between them. */
function view() {
  const deforms = (size, pose) => ({ told: { pose, deforms: true }, object: new Object3D(), surface: new DeformingSurface(tetrahedron(size)) });
  const rigid = { told: { pose: [9, 9, 9, 1, 0, 0, 0] }, object: new Object3D() };
  return { bodies: [deforms(1, [5, 0, 0, 1, 0, 0, 0]), rigid, deforms(2, [0, 7, 0, 0, 0, 0, 1])], changed: false };
}
const show = (scene, rows) => SceneView.prototype.set_surfaces.call(scene, rows);
/** Where the corners of all faces are drawn, in the world. */
function drawn({ object, surface }) {
  object.updateMatrixWorld(true);
  const { position } = surface.geometry.attributes;
  return Array.from({ length: position.count }, (_, i) => object.localToWorld(object.position.clone().fromBufferAttribute(position, i)).toArray());
}
const corners = (indices, rows) => Array.from(indices, (v) => [...rows.subarray(3 * v, 3 * v + 3)]);

test('each body that deforms takes its own vertices of a set, which are in the world', () => {
  const scene = view();
  const rows = Float32Array.from({ length: 24 }, (_, i) => i * i);
  show(scene, rows);
  assert.ok(scene.changed);
  assert.deepEqual(drawn(scene.bodies[0]), corners(tetrahedron(1).indices, rows.subarray(0, 12)));
  assert.deepEqual(drawn(scene.bodies[2]), corners(tetrahedron(2).indices, rows.subarray(12)));
  assert.deepEqual(scene.bodies[1].object.position.toArray(), [0, 0, 0], 'a rigid body is left where it is');
});

test('without a set, bodies are drawn at rest in their pose', () => {
  const scene = view();
  show(scene, new Float32Array(24));
  show(scene, null);
  const at_rest = corners(tetrahedron(1).indices, tetrahedron(1).positions).map(([x, y, z]) => [x + 5, y, z]);
  assert.deepEqual(drawn(scene.bodies[0]), at_rest);
  // Half a turn about z.
  const turned = corners(tetrahedron(2).indices, tetrahedron(2).positions).map(([x, y, z]) => [-x, 7 - y, z]);
  drawn(scene.bodies[2]).forEach((p, i) => p.forEach((x, k) => assert.ok(Math.abs(x - turned[i][k]) < 1e-6)));
});

test('a set that is too short leaves the bodies that it does not reach at rest', () => {
  const scene = view();
  const rows = Float32Array.from({ length: 20 }, (_, i) => i);
  show(scene, rows);
  assert.deepEqual(drawn(scene.bodies[0]), corners(tetrahedron(1).indices, rows.subarray(0, 12)));
  assert.deepEqual(drawn(scene.bodies[2])[0], [0, 7, 0]);
});
