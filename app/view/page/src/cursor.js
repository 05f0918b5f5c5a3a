// The person's hand: mouse, touch, keys or gamepad lead the handle's target and say whether it is held.
import {Quaternion, Vector3} from 'three';

const HEARTBEAT_MS = 40;
const LEAST_GAP_MS = 4;
const KEY_SPEED = 0.03;      // m/s
const TURN_PER_PIXEL = 0.01; // rad
const STICK_SPEED = 0.06;    // m/s
const STICK_REST = 0.12;

const MOVES = {ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1]};

export class Cursor {
  /**
   * @param {import('./scene.js').View3D} view @param {(message: object) => void} say
   * @param {object} hello @param {() => number[]|null} handle the pose of the handle as it is drawn
   */
  constructor(view, say, hello, handle) {
    this.view = view;
    this.say = say;
    this.rotates = hello.rotates;
    this.handle = handle;
    // The target lives here: derived from drawn poses it would lose what was moved between two of them.
    this.p = new Vector3(...hello.device.start.slice(0, 3));
    this.q = new Quaternion(...hello.device.start.slice(4, 7), hello.device.start[3]);
    this.dragging = false;
    this.keys = new Set();
    this.pad = false;
    this.sent = 0;
    this.last = performance.now();
    this.listen();
  }
  get held() { return this.dragging || this.keys.has('Space') || this.pad; }

  listen() {
    const {canvas} = this.view;
    canvas.addEventListener('pointerdown', (e) => this.press(e), true);
    // On the window: a drag goes on beside the canvas.
    addEventListener('pointermove', (e) => this.move(e));
    for (const name of ['pointerup', 'pointercancel']) addEventListener(name, () => this.letGo());
    canvas.addEventListener('wheel', (e) => this.wheel(e), {capture: true, passive: false});
    canvas.addEventListener('keydown', (e) => {
      if (e.code !== 'Space' && e.code !== 'KeyR' && !MOVES[e.code]) return;
      if (e.code === 'Space' && !e.repeat) this.takeHold();
      this.keys.add(e.code);
      if (e.code !== 'KeyR') e.preventDefault();
      this.send();
    });
    const release = (e) => { if (this.keys.delete(e.code)) this.send(); };
    addEventListener('keyup', release);
    addEventListener('blur', () => { this.keys.clear(); this.letGo(); });
  }
  /** Whoever takes hold does so where the handle is. */
  takeHold() {
    const pose = this.handle();
    if (!pose) return;
    this.p.set(pose[0], pose[1], pose[2]);
    this.q.set(pose[4], pose[5], pose[6], pose[3]);
  }
  press(event) {
    if (event.button !== 0 || !this.view.isTool(event.clientX, event.clientY)) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    this.view.canvas.focus();
    this.takeHold();
    this.dragging = true;
    this.at = this.view.onPlane(event.clientX, event.clientY, this.p);
    this.x = event.clientX;
    this.y = event.clientY;
    this.send();
  }
  move(event) {
    if (!this.dragging) return;
    // The button was let go where no event came from, as beside the window.
    if (event.buttons === 0) return this.letGo();
    if (this.keys.has('KeyR') && this.rotates) {
      const turn = new Quaternion().setFromAxisAngle(this.view.up(), TURN_PER_PIXEL * (event.clientX - this.x))
        .multiply(new Quaternion().setFromAxisAngle(this.view.right(), TURN_PER_PIXEL * (event.clientY - this.y)));
      this.q.premultiply(turn).normalize();
      this.at = this.view.onPlane(event.clientX, event.clientY, this.p);
    } else {
      const to = this.view.onPlane(event.clientX, event.clientY, this.p);
      this.p.add(to.clone().sub(this.at));
      this.at = to;
    }
    this.x = event.clientX;
    this.y = event.clientY;
    if (performance.now() - this.sent >= LEAST_GAP_MS) this.send();
  }
  wheel(event) {
    if (!this.held) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.p.addScaledVector(this.view.forward(), -0.2 * event.deltaY * this.view.perPixel(this.p));
    if (this.dragging) this.at = this.view.onPlane(this.x, this.y, this.p);
    this.send();
  }
  letGo() {
    if (!this.dragging) return;
    this.dragging = false;
    this.send();
  }
  /** What keys and gamepad do in `seconds`. */
  steer(seconds) {
    const step = new Vector3();
    if (this.keys.has('Space')) {
      for (const [key, move] of Object.entries(MOVES)) if (this.keys.has(key)) step.add(new Vector3(...move));
      step.multiplyScalar(KEY_SPEED * seconds);
    }
    const pad = navigator.getGamepads?.().find((p) => p?.connected) ?? null;
    const held = Boolean(pad?.buttons[7]?.pressed || pad?.buttons[0]?.pressed);
    if (held && !this.pad) this.takeHold();
    this.pad = held;
    if (held) {
      const axis = (i) => Math.abs(pad.axes[i] ?? 0) > STICK_REST ? pad.axes[i] : 0;
      step.add(new Vector3(axis(0), -axis(1), -axis(3)).multiplyScalar(STICK_SPEED * seconds));
    }
    if (step.lengthSq() === 0) return;
    this.p.addScaledVector(this.view.right(), step.x).addScaledVector(this.view.up(), step.y).addScaledVector(this.view.forward(), step.z);
    if (this.dragging) this.at = this.view.onPlane(this.x, this.y, this.p);
    this.send();
  }
  /** Once a frame: a page that draws nothing says nothing, and counts as let go. */
  frame() {
    const now = performance.now();
    this.steer(Math.min((now - this.last) / 1000, 0.1));
    this.last = now;
    if (now - this.sent >= HEARTBEAT_MS) this.send();
  }
  send() {
    this.sent = performance.now();
    this.say({type: 'input', p: this.p.toArray(), q: [this.q.w, this.q.x, this.q.y, this.q.z], held: this.held});
  }
}
