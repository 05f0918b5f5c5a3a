// Shapes that are drawn of a mesh: its surface, and a wire model of it.
import { Box3, BufferAttribute, BufferGeometry, DynamicDrawUsage, Vector3 } from 'three';

/** Faces of more than this many are small enough to be drawn round all over. */
const MOST_CREASED = 4000;
/** Faces that meet at more than this, in rad, meet in an edge that is drawn sharp. */
const CREASE = 0.6;

/** The normals of all faces, of the length of twice their areas, three numbers a face. */
function face_normals(positions, indices, into) {
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [3 * indices[i], 3 * indices[i + 1], 3 * indices[i + 2]];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    into[i] = uy * vz - uz * vy;
    into[i + 1] = uz * vx - ux * vz;
    into[i + 2] = ux * vy - uy * vx;
  }
  return into;
}

/**
 * For the corners of all faces: the faces there that are within CREASE of their own. Of corner i those of `faces` from `starts[i]` to
 * `starts[i + 1]`.
 */
function round_together(indices, normals) {
  const around = new Map();
  indices.forEach((v, i) => {
    if (!around.has(v)) around.set(v, []);
    around.get(v).push(Math.floor(i / 3));
  });
  const limit = Math.cos(CREASE);
  const own = new Vector3(), other = new Vector3();
  const starts = new Uint32Array(indices.length + 1), faces = [];
  indices.forEach((v, i) => {
    own.fromArray(normals, 3 * Math.floor(i / 3)).normalize();
    for (const face of around.get(v)) if (other.fromArray(normals, 3 * face).normalize().dot(own) >= limit) faces.push(face);
    starts[i + 1] = faces.length;
  });
  return { starts, faces: new Uint32Array(faces) };
}

/** The normal of each corner: the mean over the faces that are round together there. */
function corner_normals({ starts, faces }, normals, into) {
  for (let i = 0; i + 1 < starts.length; ++i) {
    let x = 0, y = 0, z = 0;
    for (let k = starts[i]; k < starts[i + 1]; ++k) {
      x += normals[3 * faces[k]];
      y += normals[3 * faces[k] + 1];
      z += normals[3 * faces[k] + 2];
    }
    const length = Math.hypot(x, y, z) || 1;
    into[3 * i] = x / length;
    into[3 * i + 1] = y / length;
    into[3 * i + 2] = z / length;
  }
  return into;
}

/** The normals of the corners of all faces, three numbers a corner: the mean over the faces there that are within CREASE of their own. */
export function creased_normals({ positions, indices }) {
  const normals = face_normals(positions, indices, new Float32Array(indices.length));
  return corner_normals(round_together(indices, normals), normals, new Float32Array(3 * indices.length));
}

/** The edges of faces, each once: of each, the places in `indices` of its two ends. */
export function edges_of(indices) {
  const ends = new Map();
  for (let i = 0; i < indices.length; ++i) {
    const j = i % 3 === 2 ? i - 2 : i + 1;
    const key = `${Math.min(indices[i], indices[j])},${Math.max(indices[i], indices[j])}`;
    if (!ends.has(key)) ends.set(key, [i, j]);
  }
  return [...ends.values()].flat();
}

/** The surface of a body that deforms, with its edges. Which faces are round together is told by its shape at rest. */
export class DeformingSurface {
  /** @param {{positions: Float32Array, indices: Uint32Array}} mesh at rest */
  constructor(mesh) {
    this.mesh = mesh;
    this.vertices = mesh.positions.length / 3;
    this.normals = new Float32Array(mesh.indices.length);
    this.round = round_together(mesh.indices, face_normals(mesh.positions, mesh.indices, this.normals));
    this.geometry = new BufferGeometry();
    for (const name of ['position', 'normal']) {
      this.geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * mesh.indices.length), 3).setUsage(DynamicDrawUsage));
    }
    // Lines over the same places, so that they need no update of their own.
    this.edges = new BufferGeometry().setAttribute('position', this.geometry.attributes.position).setIndex(edges_of(mesh.indices));
    this.show(mesh.positions);
  }

  /** @param {Float32Array} positions of the vertices, three numbers each */
  show(positions) {
    const { position, normal } = this.geometry.attributes;
    this.mesh.indices.forEach((v, i) => {
      for (let k = 0; k < 3; ++k) position.array[3 * i + k] = positions[3 * v + k];
    });
    corner_normals(this.round, face_normals(positions, this.mesh.indices, this.normals), normal.array);
    position.needsUpdate = normal.needsUpdate = true;
    this.geometry.computeBoundingBox();
    this.geometry.computeBoundingSphere();
  }
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
