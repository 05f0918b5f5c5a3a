// The scene in 3-D: bodies, the handle, contacts, forces and the local model, in metres, z up.
import {
  AmbientLight, Box3, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, CircleGeometry, ConeGeometry, CylinderGeometry,
  DirectionalLight, DoubleSide, FrontSide, Group, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, PerspectiveCamera, PlaneGeometry, Quaternion, Raycaster, Scene, SphereGeometry, Vector2, Vector3,
  WebGLRenderer, WireframeGeometry,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

const MOST_POINTS = 512;
const dark = () => matchMedia('(prefers-color-scheme: dark)').matches;
const UP = new Vector3(0, 1, 0);

function geometryOf(body, meshes) {
  if (body.mesh !== undefined) return meshes[body.mesh];
  if (body.sphere) return new SphereGeometry(body.sphere.radius, 32, 20);
  if (body.capsule) return new CapsuleGeometry(body.capsule.radius, body.capsule.length, 8, 24).rotateX(Math.PI / 2);
  if (body.box) return new BoxGeometry(...body.box.size);
  return null;
}

function place(object, pose) {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
}

/** An arrow along a force: a shaft and a head. */
class Arrow extends Group {
  constructor(color) {
    super();
    const material = new MeshBasicMaterial({color});
    this.shaft = new Mesh(new CylinderGeometry(1, 1, 1, 10).translate(0, 0.5, 0), material);
    this.head = new Mesh(new ConeGeometry(1, 1, 14).translate(0, 0.5, 0), material);
    this.add(this.shaft, this.head);
    this.visible = false;
  }
  /** From `begin` along `vector`, m, with a shaft of radius `thickness`. */
  set(begin, vector, thickness) {
    const length = vector.length();
    this.visible = length > 2 * thickness;
    if (!this.visible) return;
    const head = Math.min(6 * thickness, 0.5 * length);
    this.position.copy(begin);
    this.quaternion.setFromUnitVectors(UP, vector.clone().divideScalar(length));
    this.shaft.scale.set(thickness, length - head, thickness);
    this.head.position.set(0, length - head, 0);
    this.head.scale.set(2.6 * thickness, head, 2.6 * thickness);
  }
}

export class View3D {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    // Without anti-aliasing: software rendering draws twice as many frames.
    this.renderer = new WebGLRenderer({canvas, antialias: false, alpha: true, preserveDrawingBuffer: true});
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(35, 1.6, 1e-3, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(1, -2, 3);
    this.scene.add(new AmbientLight(0xffffff, 1.1), sun);
    this.bodies = [];
    this.handle = new Group();
    this.scene.add(this.handle);
    this.force = new Arrow(0xd55e00);
    this.physics = new Arrow(0x808080);
    this.spring = new Line(new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(6), 3)),
                           new LineBasicMaterial({color: 0x009e73}));
    this.spring.visible = false;
    this.spring.frustumCulled = false;
    this.scene.add(this.force, this.physics, this.spring);
    this.caster = new Raycaster();
    this.size = 0.1;
    this.centre = new Vector3();
  }

  /** @param {object} hello @param {object[]} meshes as readMesh gives them, by index */
  build(hello, meshes) {
    this.geometries = meshes.map(({positions, triangles}) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(positions, 3));
      geometry.setIndex(new BufferAttribute(triangles, 1));
      geometry.computeVertexNormals();
      return geometry;
    });
    const colors = dark() ? [0x7d8896, 0xa0785a, 0x6f8f72, 0x88789f] : [0xb9c2cc, 0xc9b29a, 0xaec4b0, 0xbfb3cf];
    let fixed = 0;
    for (const body of hello.scene.bodies) {
      const group = new Group();
      const geometry = geometryOf(body, this.geometries);
      const color = body.tool ? (dark() ? 0x3f8fc4 : 0x5ba3d0) : colors[fixed++ % colors.length];
      const material = new MeshLambertMaterial({color, side: body.plane ? DoubleSide : FrontSide});
      if (geometry) group.add(new Mesh(geometry, material));
      place(group, body.pose);
      this.scene.add(group);
      this.bodies.push({body, group, geometry, material});
    }
    this.tool = this.bodies.find((b) => b.body.tool) ?? null;
    if (this.tool?.geometry) {
      const triangles = (this.tool.geometry.index ?? this.tool.geometry.attributes.position).count / 3;
      // A fine mesh as wires is a blot: its bounding shape says as much.
      const shape = triangles < 1500 ? this.tool.geometry : this.coarse(this.tool.geometry);
      this.handle.add(new LineSegments(new WireframeGeometry(shape), new LineBasicMaterial({color: 0x0072b2, transparent: true, opacity: 0.35})));
    }
    place(this.handle, hello.device.start);
    const start = new Vector3(...hello.device.start.slice(0, 3));
    const box = new Box3();
    for (const {body, geometry, group} of this.bodies) {
      if (!geometry) continue;
      group.updateMatrixWorld(true);
      geometry.computeBoundingBox();
      const own = geometry.boundingBox.clone();
      box.union(body.tool ? own.translate(start) : own.applyMatrix4(group.matrixWorld));
    }
    if (box.isEmpty()) box.setFromCenterAndSize(start, new Vector3(0.1, 0.1, 0.1));
    box.expandByPoint(start);
    this.size = Math.max(box.getSize(new Vector3()).length(), 1e-3);
    box.getCenter(this.centre);
    for (const {body, group, material} of this.bodies) {
      if (body.plane) group.add(new Mesh(new PlaneGeometry(1.6 * this.size, 1.6 * this.size), material));
    }
    const unit = this.size / 180;
    this.points = new InstancedMesh(new SphereGeometry(unit, 8, 6), new MeshBasicMaterial({color: 0xd55e00}), MOST_POINTS);
    this.normals = new LineSegments(new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(6 * MOST_POINTS), 3)),
                                    new LineBasicMaterial({color: 0xd55e00}));
    this.patch = new InstancedMesh(new CircleGeometry(3 * unit, 16), new MeshBasicMaterial({color: 0xcc79a7, side: DoubleSide, transparent: true, opacity: 0.55}), MOST_POINTS);
    for (const object of [this.points, this.normals, this.patch]) {
      object.frustumCulled = false;
      this.scene.add(object);
    }
    this.points.count = this.patch.count = 0;
    this.normals.geometry.setDrawRange(0, 0);
    this.fit();
  }

  coarse(geometry) {
    geometry.computeBoundingBox();
    const size = geometry.boundingBox.getSize(new Vector3());
    const centre = geometry.boundingBox.getCenter(new Vector3());
    return new SphereGeometry(0.5, 14, 10).scale(size.x, size.y, size.z).translate(centre.x, centre.y, centre.z);
  }

  fit() {
    const distance = 0.62 * this.size / Math.tan(this.camera.fov * Math.PI / 360);
    this.controls.target.copy(this.centre);
    this.camera.position.copy(this.centre).add(new Vector3(0.35, -1, 0.35).normalize().multiplyScalar(distance));
    this.camera.near = distance / 100;
    this.camera.far = distance * 20;
    this.controls.update();
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (width === 0 || height === 0) return;
    const size = this.renderer.getSize(new Vector2());
    if (size.x === width && size.y === height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /**
   * @param {object} now what holds: {bodies: [pose by scene body], handle: pose, force, physics: [x,y,z] N, contacts, patch: sets,
   *   target: [x,y,z] or null}
   * @param {object} shown which of it is drawn, and `metresPerNewton`
   */
  draw(now, shown) {
    this.resize();
    now.bodies.forEach((pose, i) => { if (pose) place(this.bodies[i].group, pose); });
    if (now.handle) place(this.handle, now.handle);
    this.handle.visible = shown.handle;
    const begin = this.handle.position;
    const thickness = this.size / 220;
    const set = (arrow, force, on) => {
      if (on && force) arrow.set(begin, new Vector3(...force).multiplyScalar(shown.metresPerNewton), thickness);
      else arrow.visible = false;
    };
    set(this.force, now.force, shown.force);
    set(this.physics, now.physics, shown.physics);
    this.setContacts(shown.contacts ? now.contacts : null);
    this.setPatch(shown.patch ? now.patch : null);
    this.setSpring(now.target);
    this.renderer.render(this.scene, this.camera);
  }

  setContacts(set) {
    const count = Math.min(set?.rows ?? 0, MOST_POINTS);
    const lines = this.normals.geometry.attributes.position;
    const length = this.size / 25;
    const matrix = new Matrix4();
    for (let i = 0; i < count; ++i) {
      const [px, py, pz, nx, ny, nz] = set.values.subarray(7 * i, 7 * i + 6);
      this.points.setMatrixAt(i, matrix.makeTranslation(px, py, pz));
      lines.setXYZ(2 * i, px, py, pz);
      lines.setXYZ(2 * i + 1, px + length * nx, py + length * ny, pz + length * nz);
    }
    this.points.count = count;
    this.points.instanceMatrix.needsUpdate = true;
    this.normals.geometry.setDrawRange(0, 2 * count);
    lines.needsUpdate = true;
  }

  setPatch(set) {
    const count = Math.min(set?.rows ?? 0, MOST_POINTS);
    const z = new Vector3(0, 0, 1);
    const one = new Vector3(1, 1, 1);
    for (let i = 0; i < count; ++i) {
      const [px, py, pz, nx, ny, nz] = set.values.subarray(6 * i, 6 * i + 6);
      const turn = new Quaternion().setFromUnitVectors(z, new Vector3(nx, ny, nz));
      this.patch.setMatrixAt(i, new Matrix4().compose(new Vector3(px, py, pz), turn, one));
    }
    this.patch.count = count;
    this.patch.instanceMatrix.needsUpdate = true;
  }

  setSpring(target) {
    this.spring.visible = Boolean(target && this.tool);
    if (!this.spring.visible) return;
    const line = this.spring.geometry.attributes.position;
    line.setXYZ(0, ...target);
    line.setXYZ(1, ...this.tool.group.position.toArray());
    line.needsUpdate = true;
  }

  /** A point of the client area in the camera's coordinates. */
  device(x, y) {
    const box = this.canvas.getBoundingClientRect();
    return new Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height);
  }
  /** Where a point of the world is in the client area. */
  project(x, y, z) {
    this.camera.updateMatrixWorld();
    const p = new Vector3(x, y, z).project(this.camera);
    const box = this.canvas.getBoundingClientRect();
    return [box.left + (p.x + 1) / 2 * box.width, box.top + (1 - p.y) / 2 * box.height];
  }
  /** Whether the tool or the handle is under that point of the client area, or its middle near it. */
  isTool(x, y) {
    if (!this.tool) return false;
    for (const {position} of [this.tool.group, this.handle]) {
      const [px, py] = this.project(position.x, position.y, position.z);
      if (Math.hypot(px - x, py - y) < 24) return true;
    }
    this.caster.setFromCamera(this.device(x, y), this.camera);
    return this.caster.intersectObject(this.tool.group, true).length > 0;
  }
  /** Where the line of sight through that point meets the plane through `p` that faces the camera. */
  onPlane(x, y, p) {
    this.caster.setFromCamera(this.device(x, y), this.camera);
    const {origin, direction} = this.caster.ray;
    const forward = this.forward();
    return origin.clone().addScaledVector(direction, p.clone().sub(origin).dot(forward) / direction.dot(forward));
  }
  forward() { return this.camera.getWorldDirection(new Vector3()); }
  right() { return new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0); }
  up() { return new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1); }
  /** The length in the world, m, of a pixel at `p`. */
  perPixel(p) {
    const depth = p.clone().sub(this.camera.position).dot(this.forward());
    return 2 * depth * Math.tan(this.camera.fov * Math.PI / 360) / this.canvas.clientHeight;
  }
}
