// Shapes that are drawn of a mesh: its surface, and a wire model of it.
import { Box3, BufferAttribute, BufferGeometry, Vector3 } from 'three';

/** Faces of more than this many are small enough to be drawn round all over. */
const MOST_CREASED = 4000;
/** Faces that meet at more than this, in rad, meet in an edge that is drawn sharp. */
const CREASE = 0.6;

/** The normals of the corners of all faces, three numbers a corner: the mean over the faces there that are within CREASE of their own. */
export function creased_normals({ positions, indices }) {
  const normals = new Float32Array(3 * indices.length);
  const a = new Vector3(), b = new Vector3(), c = new Vector3();
  const faces = indices.length / 3;
  const face_normals = new Float32Array(3 * faces); // of the faces' areas
  const around = new Map();
  for (let f = 0; f < faces; ++f) {
    a.fromArray(positions, 3 * indices[3 * f]);
    b.fromArray(positions, 3 * indices[3 * f + 1]).sub(a);
    c.fromArray(positions, 3 * indices[3 * f + 2]).sub(a);
    b.cross(c).toArray(face_normals, 3 * f);
    for (let k = 0; k < 3; ++k) {
      const v = indices[3 * f + k];
      if (!around.has(v)) around.set(v, []);
      around.get(v).push(f);
    }
  }
  const limit = Math.cos(CREASE);
  const own = new Vector3(), other = new Vector3(), unit = new Vector3();
  for (let f = 0; f < faces; ++f) {
    own.fromArray(face_normals, 3 * f).normalize();
    for (let k = 0; k < 3; ++k) {
      const sum = a.set(0, 0, 0);
      for (const g of around.get(indices[3 * f + k])) {
        other.fromArray(face_normals, 3 * g);
        if (unit.copy(other).normalize().dot(own) >= limit) sum.add(other);
      }
      sum.normalize().toArray(normals, 9 * f + 3 * k);
    }
  }
  return normals;
}

/** @param {{positions: Float32Array, indices: Uint32Array}} mesh */
export function mesh_geometry(mesh) {
  const geometry = new BufferGeometry();
  if (mesh.indices.length / 3 <= MOST_CREASED) {
    const flat = new Float32Array(3 * mesh.indices.length);
    mesh.indices.forEach((v, i) => flat.set(mesh.positions.subarray(3 * v, 3 * v + 3), 3 * i));
    geometry.setAttribute('position', new BufferAttribute(flat, 3));
    geometry.setAttribute('normal', new BufferAttribute(creased_normals(mesh), 3));
  } else {
    geometry.setAttribute('position', new BufferAttribute(mesh.positions, 3));
    geometry.setIndex(new BufferAttribute(mesh.indices, 1));
    geometry.computeVertexNormals();
  }
  geometry.computeBoundingBox();
  geometry.computeBoundingSphere();
  return geometry;
}

/** A thinned wire model of a mesh: its vertices joined in cells, and the edges between the cells. */
export function wires_of(mesh) {
  const box = new Box3().setFromArray(mesh.positions);
  const extent = box.getSize(new Vector3());
  const cell = Math.max(extent.x, extent.y, extent.z, 1e-9) / 13;
  const cells = new Map();
  const cell_of = new Int32Array(mesh.positions.length / 3);
  for (let v = 0; v < cell_of.length; ++v) {
    const [x, y, z] = [0, 1, 2].map((k) => mesh.positions[3 * v + k]);
    const key = `${Math.floor((x - box.min.x) / cell)},${Math.floor((y - box.min.y) / cell)},${Math.floor((z - box.min.z) / cell)}`;
    let found = cells.get(key);
    if (!found) cells.set(key, (found = { id: cells.size, sum: [0, 0, 0], n: 0 }));
    found.sum[0] += x;
    found.sum[1] += y;
    found.sum[2] += z;
    ++found.n;
    cell_of[v] = found.id;
  }
  const centres = [...cells.values()].map((c) => c.sum.map((s) => s / c.n));
  const edges = new Set();
  for (let i = 0; i < mesh.indices.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = cell_of[mesh.indices[i + k]];
      const b = cell_of[mesh.indices[i + ((k + 1) % 3)]];
      if (a !== b) edges.add(a < b ? a * cells.size + b : b * cells.size + a);
    }
  }
  const points = [];
  for (const edge of edges) points.push(...centres[Math.floor(edge / cells.size)], ...centres[edge % cells.size]);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  return geometry;
}
