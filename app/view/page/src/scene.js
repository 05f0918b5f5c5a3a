// Draws the bodies, the handle, contacts, the local model and the forces in three dimensions.
import {
  AmbientLight, Box3, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, CircleGeometry, Color, ConeGeometry, CylinderGeometry,
  DirectionalLight, DoubleSide, DynamicDrawUsage, Group, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, PerspectiveCamera, PlaneGeometry, Quaternion, Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer, WireframeGeometry,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { colour_of } from './colours.js';
import { DeformingSurface, mesh_geometry, wires_of } from './geometry.js';

/** Colours of the scene that no curve has, light and dark. */
const THEMES = {
  light: { background: 0xf3f5f7, still: 0xa9b6c4, moving: 0x86a8c8, soft: 0xc98a80, plane: 0xdfe4e8, grid: 0xc3cad1 },
  dark: { background: 0x14181c, still: 0x7e8b99, moving: 0x5d84a8, soft: 0xa8665c, plane: 0x22282e, grid: 0x343c44 },
};

const Z = new Vector3(0, 0, 1);
const Y = new Vector3(0, 1, 0);

/** Sets an object's pose from [x, y, z, w, x, y, z]. */
function set_pose(object, pose, at = 0) {
  object.position.set(pose[at], pose[at + 1], pose[at + 2]);
  object.quaternion.set(pose[at + 4], pose[at + 5], pose[at + 6], pose[at + 3]);
}

/** An arrow along a vector: a shaft and a tip. */
class Arrow {
  constructor() {
    this.group = new Group();
    const material = new MeshBasicMaterial({ depthTest: false }); // seen through the tool
    const shaft = new CylinderGeometry(1, 1, 1, 10, 1).translate(0, 0.5, 0);
    const tip = new ConeGeometry(1, 1, 14).translate(0, -0.5, 0);
    this.shaft = new Mesh(shaft, material);
    this.tip = new Mesh(tip, material);
    this.shaft.renderOrder = this.tip.renderOrder = 3;
    this.group.add(this.shaft, this.tip);
  }
  /** @param {Vector3} vector in m @param {number} thickness of the shaft in m */
  point(vector, thickness) {
    const length = vector.length();
    this.group.visible = length > 2 * thickness;
    if (!this.group.visible) return;
    this.group.quaternion.setFromUnitVectors(Y, vector.clone().divideScalar(length));
    const tip = Math.min(7 * thickness, 0.5 * length);
    this.shaft.scale.set(thickness, length - tip, thickness);
    this.tip.scale.set(0.36 * tip, tip, 0.36 * tip);
    this.tip.position.set(0, length, 0);
  }
}

/** Many small equal shapes, as many as are needed. */
class Swarm {
  constructor(geometry, material, parent) {
    Object.assign(this, { geometry, material, parent, capacity: 0, mesh: null });
  }
  resize(n) {
    if (n > this.capacity) {
      if (this.mesh) {
        this.parent.remove(this.mesh);
        this.mesh.dispose();
      }
      this.capacity = Math.max(64, 2 * n);
      this.mesh = new InstancedMesh(this.geometry, this.material, this.capacity);
      this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      this.mesh.frustumCulled = false;
      this.parent.add(this.mesh);
    }
    if (this.mesh) {
      this.mesh.count = n;
      this.mesh.visible = n > 0;
    }
  }
}

/** The picture of the scene. All lengths in m, poses as [x, y, z, w, x, y, z]. */
export class SceneView {
  /**
   * @param {HTMLElement} parent
   * @param {object} hello
   * @param {object[]} meshes as decoded, by index
   */
  constructor(parent, hello, meshes) {
    this.parent = parent;
    this.hello = hello;
    this.renderer = new WebGLRenderer({ antialias: false, powerPreference: 'high-performance' });
    this.canvas = this.renderer.domElement;
    this.canvas.id = 'scene-canvas';
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('aria-label', 'The scene. Hold space and use the arrow keys to move the handle.');
    parent.append(this.canvas);
    this.three = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.001, 100);
    this.camera.up.fromArray(hello.scene.camera?.up ?? [0, 0, 1]).normalize();
    this.sun = new DirectionalLight(0xffffff, 2.0);
    this.fill = new DirectionalLight(0xffffff, 0.7);
    this.three.add(this.sun, this.sun.target, this.fill, this.fill.target, new AmbientLight(0xffffff, 0.85));
    this.caster = new Raycaster();
    this.pixel_ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.changed = true;

    this.materials = { still: new MeshLambertMaterial(), tool: new MeshLambertMaterial(), moving: new MeshLambertMaterial(),
      // Behind its edges, which are what shows a dent.
      soft: new MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }),
      edges: new LineBasicMaterial({ color: 0x000000, transparent: true, opacity: 0.16 }),
      plane: new MeshBasicMaterial({ side: DoubleSide }) };
    const soft = new Set(hello.scene.bodies.filter((told) => told.deforms).map((told) => told.mesh));
    const geometries = meshes.map((mesh, i) => (soft.has(i) ? null : mesh_geometry(mesh)));
    this.bodies = hello.scene.bodies.map((told) => this.make_body(told, geometries, meshes));
    this.tool = this.bodies.findIndex((body) => body.told.tool);
    this.body_group = new Group();
    for (const body of this.bodies) this.body_group.add(body.object);
    this.three.add(this.body_group);
    this.fit();
    this.make_ground();

    this.layers = {};
    const add = (name, object, shown = true) => {
      this.layers[name] = object;
      object.visible = shown;
      this.three.add(object);
      return object;
    };
    this.layers.bodies = this.body_group;
    add('handle', this.make_handle(meshes));
    const dot = this.radius * 0.012;
    const contacts = add('contacts', new Group());
    this.contact_points = new Swarm(new SphereGeometry(dot, 8, 6), new MeshBasicMaterial({ depthTest: false }), contacts);
    this.contact_normals = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ depthTest: false }));
    this.contact_normals.frustumCulled = false;
    contacts.add(this.contact_normals);
    contacts.renderOrder = 2;
    this.patch_discs = new Swarm(new CircleGeometry(this.radius * 0.022, 12),
      new MeshBasicMaterial({ side: DoubleSide, transparent: true, opacity: 0.75 }), add('patch', new Group()));
    this.arrows = { commanded: new Arrow(), physics: new Arrow() };
    add('commanded', new Group()).add(this.arrows.commanded.group);
    add('physics', new Group(), false).add(this.arrows.physics.group);
    this.spring = new Line(new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(6), 3)), new LineBasicMaterial());
    this.spring.frustumCulled = false;
    this.target_dot = new Mesh(new SphereGeometry(dot * 0.9, 10, 8), new MeshBasicMaterial());
    const spring = add('spring', new Group());
    spring.add(this.spring, this.target_dot);
    spring.visible = false;

    this.force_scale = this.radius / (hello.device?.force_max || 5); // m per N
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.target.copy(this.centre);
    this.controls.addEventListener('change', () => (this.changed = true));
    this.controls.addEventListener('start', () => (this.touched = true));
    this.set_dark(false);
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(parent);
    this.resize();
  }

  make_body(told, geometries, meshes) {
    const material = told.tool ? this.materials.tool : told.moves ? this.materials.moving : this.materials.still;
    let object;
    let surface;
    if (told.deforms) {
      if (!meshes[told.mesh]) throw new Error(`body ${told.name} names mesh ${told.mesh}, which did not come`);
      surface = new DeformingSurface(meshes[told.mesh]);
      object = new Mesh(surface.geometry, this.materials.soft);
      const edges = new LineSegments(surface.edges, this.materials.edges);
      edges.frustumCulled = false; // their bounds are those of the shape at rest
      object.add(edges);
    } else if (told.mesh !== undefined) {
      if (!geometries[told.mesh]) throw new Error(`body ${told.name} names mesh ${told.mesh}, which did not come`);
      object = new Mesh(geometries[told.mesh], material);
    } else if (told.sphere) {
      object = new Mesh(new SphereGeometry(told.sphere.radius, 32, 20), material);
    } else if (told.capsule) {
      object = new Mesh(new CapsuleGeometry(told.capsule.radius, told.capsule.length, 10, 24).rotateX(Math.PI / 2), material);
    } else if (told.box) {
      object = new Mesh(new BoxGeometry(...told.box.size), material);
    } else if (told.plane) {
      object = new Mesh(new PlaneGeometry(1, 1), this.materials.plane);
    } else {
      object = new Group();
    }
    const wires = () => {
      if (told.mesh !== undefined) return wires_of(meshes[told.mesh]);
      if (told.sphere) return new WireframeGeometry(new SphereGeometry(told.sphere.radius, 14, 9));
      if (told.capsule) return new WireframeGeometry(new CapsuleGeometry(told.capsule.radius, told.capsule.length, 4, 10).rotateX(Math.PI / 2));
      if (told.box) return new WireframeGeometry(new BoxGeometry(...told.box.size));
      return new WireframeGeometry(new SphereGeometry(0.005, 10, 6));
    };
    set_pose(object, told.pose ?? [0, 0, 0, 1, 0, 0, 0]);
    return { told, object, wires, surface };
  }

  make_handle() {
    const tool = this.bodies[this.tool];
    const geometry = tool ? tool.wires() : new WireframeGeometry(new SphereGeometry(this.radius * 0.05, 12, 8));
    this.handle = new LineSegments(geometry, new LineBasicMaterial({ transparent: true, opacity: 0.4 }));
    const start = this.hello.device?.start ?? tool?.told.pose;
    if (start) set_pose(this.handle, start);
    return this.handle;
  }

  /** Puts the camera so that all bodies but planes are seen. */
  fit() {
    const box = new Box3();
    for (const { told, object } of this.bodies) {
      object.updateMatrixWorld(true);
      if (!told.plane) box.expandByObject(object);
    }
    const start = this.hello.device?.start;
    if (start) box.expandByPoint(new Vector3(start[0], start[1], start[2]));
    if (box.isEmpty()) box.set(new Vector3(-0.1, -0.1, -0.1), new Vector3(0.1, 0.1, 0.1));
    this.box = box;
    this.outline = this.outline_of(box);
    this.centre = box.getCenter(new Vector3());
    this.radius = Math.max(box.getSize(new Vector3()).length() / 2, 1e-3);
    for (const { told, object } of this.bodies) if (told.plane) object.scale.setScalar(6 * this.radius);
    this.look();
  }

  /** Some points of all bodies, which are to be seen. */
  outline_of(box) {
    const points = [];
    const corners = (of) => {
      for (let i = 0; i < 8; ++i) points.push(new Vector3(i & 1 ? of.max.x : of.min.x, i & 2 ? of.max.y : of.min.y, i & 4 ? of.max.z : of.min.z));
    };
    for (const { told, object } of this.bodies) {
      const positions = object.geometry?.attributes.position;
      if (told.plane || !positions) continue;
      const every = Math.max(1, Math.floor(positions.count / 400));
      for (let i = 0; i < positions.count; i += every) points.push(new Vector3().fromBufferAttribute(positions, i).applyMatrix4(object.matrixWorld));
    }
    // Of a plane, the place under the handle.
    const start = this.hello.device?.start;
    for (const { told, object } of this.bodies) {
      if (!told.plane || !start) continue;
      const handle = new Vector3(start[0], start[1], start[2]);
      const height = object.worldToLocal(handle.clone()).z;
      const reach = Math.max(1.5 * Math.abs(height), 2 * this.tool_size());
      for (const [x, y] of [[-1, 0], [1, 0], [0, -1], [0, 1]]) {
        points.push(object.localToWorld(object.worldToLocal(handle.clone()).setZ(0)).add(new Vector3(x * reach, y * reach, 0)));
      }
    }
    if (!points.length) corners(box);
    return points;
  }

  /** The radius of a ball round the tool, m. */
  tool_size() {
    const geometry = this.bodies[this.tool]?.object.geometry;
    geometry?.computeBoundingSphere();
    return geometry?.boundingSphere?.radius ?? 0.005;
  }

  /** Puts the camera back to where all is seen. */
  look() {
    const direction = new Vector3().fromArray(this.hello.scene.camera?.from ?? [1, 0.5, 0.42]).normalize();
    // As near as all bodies allow.
    const up_part = 0.8 * Math.tan((this.camera.fov * Math.PI) / 360);
    const right_part = up_part * this.camera.aspect;
    const right = new Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new Vector3().crossVectors(direction, right);
    const view = new Box3();
    const seen = this.outline.map((p) => new Vector3(p.dot(right), p.dot(up), p.dot(direction)));
    view.setFromPoints(seen);
    const middle = view.getCenter(new Vector3());
    let distance = 0.1 * this.radius;
    for (const p of seen) {
      p.sub(middle);
      distance = Math.max(distance, p.z + Math.abs(p.x) / right_part, p.z + Math.abs(p.y) / up_part);
    }
    this.touched = false;
    this.centre.set(0, 0, 0).addScaledVector(right, middle.x).addScaledVector(up, middle.y).addScaledVector(direction, middle.z);
    this.camera.position.copy(this.centre).addScaledVector(direction, distance);
    this.camera.near = this.radius / 50;
    this.camera.far = this.radius * 40;
    this.camera.updateProjectionMatrix();
    this.camera.lookAt(this.centre);
    if (this.controls) {
      this.controls.target.copy(this.centre);
      this.controls.update();
    }
    this.changed = true;
  }

  make_ground() {
    const step = 10 ** Math.round(Math.log10(this.radius / 3));
    const half = Math.ceil((2.2 * this.radius) / step) * step;
    const plane = this.bodies.find((body) => body.told.plane);
    const points = [];
    for (let i = -half; i <= half + step / 2; i += step) points.push(-half, i, 0, half, i, 0, i, -half, 0, i, half, 0);
    const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
    this.ground = new LineSegments(geometry, new LineBasicMaterial());
    if (plane) {
      this.ground.position.copy(plane.object.position);
      this.ground.quaternion.copy(plane.object.quaternion);
      this.ground.position.add(new Vector3(0, 0, this.radius * 0.001).applyQuaternion(plane.object.quaternion));
    } else {
      const { up } = this.camera;
      this.ground.quaternion.setFromUnitVectors(Z, up);
      const lowest = Math.min(...this.outline.map((p) => p.dot(up)));
      const centre = this.box.getCenter(new Vector3());
      this.ground.position.copy(centre).addScaledVector(up, lowest - centre.dot(up) - 0.02 * this.radius);
    }
    this.layers ??= {};
    this.three.add(this.ground);
  }

  /** Shows or hides a layer: bodies, ground, handle, contacts, patch, commanded, physics. */
  show(name, shown) {
    const object = name === 'ground' ? this.ground : this.layers[name];
    if (object) object.visible = shown;
    this.changed = true;
  }

  set_dark(dark) {
    const theme = THEMES[dark ? 'dark' : 'light'];
    this.three.background = new Color(theme.background);
    for (const name of ['still', 'moving', 'soft', 'plane']) this.materials[name].color.set(theme[name]);
    this.materials.tool.color.set(colour_of('tool', dark));
    this.ground.material.color.set(theme.grid);
    for (const { material } of [this.handle, this.spring, this.target_dot]) material.color.set(colour_of('hand', dark));
    for (const { material } of [this.contact_points, this.contact_normals]) material.color.set(colour_of('contacts', dark));
    this.patch_discs.material.color.set(colour_of('patch', dark));
    for (const [role, arrow] of Object.entries(this.arrows)) arrow.shaft.material.color.set(colour_of(role, dark));
    this.changed = true;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (!width || !height) return;
    const aspect = width / height;
    Object.assign(this, { width, height });
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    this.renderer.setPixelRatio(this.pixel_ratio);
    this.renderer.setSize(width, height);
    if (!this.touched) this.look();
    this.changed = true;
  }

  /** Fewer pixels when the computer cannot keep up. */
  set_pixel_ratio(ratio) {
    if (ratio === this.pixel_ratio) return;
    this.pixel_ratio = ratio;
    this.resize();
  }

  /** @param {number} index of the body @param {ArrayLike<number>} pose */
  set_body(index, pose) {
    const body = this.bodies[index];
    if (body) set_pose(body.object, pose);
    this.changed = true;
  }

  set_handle(pose) {
    set_pose(this.handle, pose);
    this.changed = true;
  }

  /** The wires fade where the tool is at the handle: only what lies apart is of interest. */
  fade_handle() {
    const tool = this.bodies[this.tool]?.object;
    if (!tool) return;
    const apart = this.handle.position.distanceTo(tool.position) / this.radius + 0.5 * this.handle.quaternion.angleTo(tool.quaternion);
    this.handle.material.opacity = Math.min(0.5, 0.08 + 12 * apart);
  }

  /** @param {'commanded' | 'physics'} which @param {ArrayLike<number> | null} force in N */
  set_force(which, force) {
    const arrow = this.arrows[which];
    arrow.group.position.copy(this.handle.position);
    arrow.point(new Vector3(...(force ? [force[0], force[1], force[2]] : [0, 0, 0])).multiplyScalar(this.force_scale),
      this.radius * (which === 'commanded' ? 0.014 : 0.01));
    this.changed = true;
  }

  /** @param {Float32Array} rows p, n, distance */
  set_contacts(rows, width) {
    const n = rows ? Math.floor(rows.length / width) : 0;
    this.contact_points.resize(n);
    if (this.lines_capacity === undefined || n > this.lines_capacity) {
      this.lines_capacity = Math.max(64, 2 * n);
      this.contact_normals.geometry.dispose();
      this.contact_normals.geometry = new BufferGeometry().setAttribute('position',
        new BufferAttribute(new Float32Array(6 * this.lines_capacity), 3).setUsage(DynamicDrawUsage));
    }
    const matrix = new Matrix4();
    const lines = this.contact_normals.geometry.attributes.position;
    const long = 0.13 * this.radius;
    for (let i = 0; i < n; ++i) {
      const [x, y, z, nx, ny, nz] = rows.subarray(i * width, i * width + 6);
      this.contact_points.mesh.setMatrixAt(i, matrix.makeTranslation(x, y, z));
      lines.array.set([x, y, z, x + long * nx, y + long * ny, z + long * nz], 6 * i);
    }
    if (n) {
      this.contact_points.mesh.instanceMatrix.needsUpdate = true;
      this.contact_points.mesh.renderOrder = 2;
      this.contact_normals.renderOrder = 2;
    }
    lines.needsUpdate = true;
    this.contact_normals.geometry.setDrawRange(0, 2 * n);
    this.changed = true;
  }

  /** @param {Float32Array} rows p, n */
  set_patch(rows, width) {
    const n = rows ? Math.floor(rows.length / width) : 0;
    this.patch_discs.resize(n);
    const matrix = new Matrix4();
    const turn = new Quaternion();
    const one = new Vector3(1, 1, 1);
    const p = new Vector3();
    const normal = new Vector3();
    for (let i = 0; i < n; ++i) {
      p.fromArray(rows, i * width);
      normal.fromArray(rows, i * width + 3);
      p.addScaledVector(normal, 0.002 * this.radius);
      this.patch_discs.mesh.setMatrixAt(i, matrix.compose(p, turn.setFromUnitVectors(Z, normal), one));
    }
    if (n) this.patch_discs.mesh.instanceMatrix.needsUpdate = true;
    this.changed = true;
  }

  /** @param {Float32Array | null} rows p in W of the vertices of all bodies that deform, one body after the other; null: at rest */
  set_surfaces(rows) {
    let at = 0;
    for (const { told, object, surface } of this.bodies) {
      if (!surface) continue;
      const end = at + 3 * surface.vertices;
      const known = rows !== null && end <= rows.length;
      set_pose(object, known ? [0, 0, 0, 1, 0, 0, 0] : told.pose);
      surface.show(known ? rows.subarray(at, end) : surface.mesh.positions);
      at = end;
    }
    this.changed = true;
  }

  /** The line from where the cursor wants the handle to the tool; null hides it. */
  set_spring(from, to) {
    const shown = Boolean(from && to);
    if (!shown && !this.layers.spring.visible) return;
    this.layers.spring.visible = shown;
    this.changed = true;
    if (!shown) return;
    const position = this.spring.geometry.attributes.position;
    position.array.set([...from.toArray(), ...to.toArray()]);
    position.needsUpdate = true;
    this.target_dot.position.copy(from);
  }

  /** The tool's pose as drawn, or the handle's where no body is the tool. */
  tool_object() {
    return this.bodies[this.tool]?.object ?? this.handle;
  }

  /** What lies under the pointer: the point on the tool or on the handle's copy of it, or null. */
  pick(x, y, tolerance) {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    this.caster.setFromCamera(at, this.camera);
    const tool = this.bodies[this.tool]?.object;
    if (tool?.isMesh) {
      tool.updateMatrixWorld(true);
      const others = this.bodies.filter((body) => !body.told.tool && !body.told.plane && body.object.isMesh).map((body) => body.object);
      const hit = this.caster.intersectObject(tool, false)[0];
      const before = hit && this.caster.intersectObjects(others, false)[0];
      if (hit && !(before && before.distance < hit.distance)) return hit.point.clone();
      const ghost = new Mesh(tool.geometry, tool.material);
      ghost.position.copy(this.handle.position);
      ghost.quaternion.copy(this.handle.quaternion);
      ghost.updateMatrixWorld(true);
      const second = this.caster.intersectObject(ghost, false)[0];
      if (second && !before) return second.point.clone();
    }
    // Small tools and fingers: near is enough.
    for (const object of [this.tool_object(), this.handle]) {
      const [px, py] = this.project(object.position.x, object.position.y, object.position.z);
      if (Math.hypot(px - x, py - y) <= tolerance) return object.position.clone();
    }
    return null;
  }

  /** A point of the world in client pixels. */
  project(x, y, z) {
    this.camera.updateMatrixWorld();
    const p = new Vector3(x, y, z).project(this.camera);
    const box = this.canvas.getBoundingClientRect();
    return [box.left + ((p.x + 1) / 2) * box.width, box.top + ((1 - p.y) / 2) * box.height];
  }

  /** The camera's axes in W and what one pixel means at a point, in m. */
  view_at(point) {
    this.camera.updateMatrixWorld();
    const right = new Vector3(), up = new Vector3(), back = new Vector3();
    this.camera.matrixWorld.extractBasis(right, up, back);
    const forward = back.negate();
    const depth = point.clone().sub(this.camera.position).dot(forward);
    const pixel = (2 * Math.max(depth, this.camera.near) * Math.tan((this.camera.fov * Math.PI) / 360)) / Math.max(1, this.height);
    return { right, up, forward, pixel };
  }

  /** Draws if something has changed; says whether it did. */
  render(always = false) {
    if (!this.changed && !always) return false;
    this.changed = false;
    this.fade_handle();
    const { right, up, forward } = this.view_at(this.centre);
    this.sun.position.copy(this.camera.position).addScaledVector(up, this.radius * 1.5).addScaledVector(right, -this.radius);
    this.sun.target.position.copy(this.centre);
    this.fill.position.copy(this.camera.position).addScaledVector(right, this.radius * 3);
    this.fill.target.position.copy(this.centre).addScaledVector(forward, this.radius);
    this.renderer.render(this.three, this.camera);
    return true;
  }

  /** Draws at a size of one's own, hands the canvas over, and puts the size back. */
  picture(width, height, use) {
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render(true);
    use(this.canvas);
    this.resize();
  }
}
