// Moves the handle's target by mouse, touch, keys or a gamepad, and tells it to the server.
import { Quaternion, Vector3 } from 'three';
import { HANGS_AFTER } from './heartbeat.js';

const LEAST_GAP = 4; // ms between inputs: at most 250/s
const HEARTBEAT = 25; // ms

/** The cursor keeps its own target: one derived from drawn poses would lose increments. */
export class Cursor {
  /**
   * @param {object} world
   * @param {import('./scene.js').SceneView} world.scene
   * @param {object} world.hello
   * @param {function(object): void} world.send
   * @param {function(): void} world.fall_silent ends the heartbeat until the next input
   * @param {function(): ArrayLike<number> | null} world.handle the newest pose of the handle
   * @param {function(): boolean} world.allowed whether this client is in control
   */
  constructor({ scene, hello, send, fall_silent, handle, allowed }) {
    Object.assign(this, { scene, hello, send, fall_silent, handle, allowed });
    const start = hello.device?.start ?? [0, 0, 0, 1, 0, 0, 0];
    this.p = new Vector3(start[0], start[1], start[2]);
    this.q = new Quaternion(start[4], start[5], start[6], start[3]);
    this.grip = new Vector3(); // where the tool is held, in its frame
    this.by = null; // 'pointer', 'keys', 'gamepad' while held
    this.keys = new Set();
    this.last_sent = -Infinity;
    this.last_drawn = -Infinity;
    this.last_step = performance.now();
    this.sent = 0;
    this.ever_held = false;
    if (!hello.device?.mouse) return;
    this.listen();
  }

  get held() {
    return this.by !== null;
  }

  listen() {
    const area = this.scene.parent;
    const { canvas } = this.scene;
    // In the capture phase: before the camera's controls see it.
    area.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || this.held || !this.allowed() || event.target !== canvas) return;
      const hit = this.scene.pick(event.clientX, event.clientY, event.pointerType === 'touch' ? 40 : 18);
      if (!hit) return;
      event.preventDefault();
      event.stopPropagation();
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      this.pointer = event.pointerId;
      this.last = [event.clientX, event.clientY];
      this.grab('pointer', hit);
    }, true);
    // On the window: a drag goes on beside the canvas, also where the browser has taken the capture back.
    window.addEventListener('pointermove', (event) => {
      if (this.by === null && event.pointerType === 'mouse' && event.buttons === 0) {
        if (event.target === canvas) this.hover(event);
        return;
      }
      if (this.by !== 'pointer' || event.pointerId !== this.pointer) return;
      event.stopPropagation();
      if (event.pointerType === 'mouse' && (event.buttons & 1) === 0) {
        this.release(); // the button came up where no event told it
        return;
      }
      const dx = event.clientX - this.last[0];
      const dy = event.clientY - this.last[1];
      this.last = [event.clientX, event.clientY];
      if (this.keys.has('r') && this.hello.rotates) this.turn(dx * 0.008, dy * 0.008, 0);
      else this.move(dx, -dy, 0);
      this.tell(false);
    }, true);
    const release = (event) => {
      if (this.by !== 'pointer' || event.pointerId !== this.pointer) return;
      event.stopPropagation();
      this.release();
    };
    for (const name of ['pointerup', 'pointercancel']) window.addEventListener(name, release, true);
    area.addEventListener('wheel', (event) => {
      if (!this.held) return;
      event.preventDefault();
      event.stopPropagation();
      const pixels = event.deltaMode === 1 ? event.deltaY * 16 : event.deltaY;
      this.move(0, 0, -0.15 * Math.max(-120, Math.min(120, pixels)));
      this.tell(false);
    }, { capture: true, passive: false });
    const typing = (target) => target instanceof Element && target.closest('input, select, textarea, button, [contenteditable], a, summary');
    window.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      if (key !== 'r' && typing(event.target)) return;
      const ours = [' ', 'ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown', 'PageUp', 'PageDown'];
      if (key === ' ' && !event.repeat && !this.held && this.allowed()) this.grab('keys', null);
      if (key === ' ' || (this.by === 'keys' && ours.includes(key))) event.preventDefault();
      this.keys.add(key);
      if (event.shiftKey) this.keys.add('Shift');
    });
    window.addEventListener('keyup', (event) => {
      const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      this.keys.delete(key);
      if (key === ' ' && this.by === 'keys') this.release();
    });
    const drop = () => {
      this.keys.clear();
      if (this.held) this.release();
    };
    window.addEventListener('blur', drop);
    window.addEventListener('pagehide', drop);
    document.addEventListener('visibilitychange', () => document.hidden && drop());
    // Beside drawing, however slow that is; the worker speaks for the page while it draws.
    setInterval(() => this.beat(), HEARTBEAT);
  }

  /** The pointer's shape says what can be taken; looked at now and then only. */
  hover(event) {
    const now = performance.now();
    if (now - (this.hovered ?? 0) < 120) return;
    this.hovered = now;
    const can = this.allowed() && event.target === this.scene.canvas && this.scene.pick(event.clientX, event.clientY, 18);
    this.scene.canvas.classList.toggle('can-grab', Boolean(can));
  }

  grab(by, hit) {
    const pose = this.handle();
    if (pose) {
      this.p.set(pose[0], pose[1], pose[2]);
      if (pose.length >= 7) this.q.set(pose[4], pose[5], pose[6], pose[3]);
    }
    const tool = this.scene.tool_object();
    this.grip.set(0, 0, 0);
    if (hit) this.grip.copy(hit).sub(tool.position).applyQuaternion(tool.quaternion.clone().invert());
    this.by = by;
    this.ever_held = true;
    this.scene.controls.enabled = false;
    this.scene.canvas.classList.add('grabbing');
    this.tell(true);
  }

  release() {
    this.by = null;
    this.pointer = null;
    this.scene.controls.enabled = true;
    this.scene.canvas.classList.remove('grabbing');
    this.tell(true);
  }

  /** Pixels in the view's plane and in depth. */
  move(right_pixels, up_pixels, forward_pixels) {
    const { right, up, forward, pixel } = this.scene.view_at(this.p);
    this.p.addScaledVector(right, right_pixels * pixel).addScaledVector(up, up_pixels * pixel).addScaledVector(forward, forward_pixels * pixel);
  }

  /** Turns in rad about the view's axes. */
  turn(about_up, about_right, about_forward) {
    const { right, up, forward } = this.scene.view_at(this.p);
    for (const [axis, angle] of [[up, about_up], [right, about_right], [forward, about_forward]])
      this.q.premultiply(new Quaternion().setFromAxisAngle(axis, angle));
    this.q.normalize();
  }

  /** Keys and gamepad; called at every drawn frame. */
  step(now, force_part) {
    const dt = Math.min(0.1, (now - this.last_step) / 1000);
    this.last_step = now;
    if (!this.hello.device?.mouse) return;
    if (this.by === 'keys') {
      const way = (plus, minus) => (this.keys.has(plus) ? 1 : 0) - (this.keys.has(minus) ? 1 : 0);
      const x = way('ArrowRight', 'ArrowLeft');
      const y = way('ArrowUp', 'ArrowDown');
      const z = way('PageUp', 'PageDown');
      const speed = this.keys.has('Shift') ? 0.25 : 1;
      if (this.keys.has('r') && this.hello.rotates) this.turn(x * dt * speed, -y * dt * speed, z * dt * speed);
      else this.move(x * 120 * dt * speed, y * 120 * dt * speed, z * 120 * dt * speed);
    }
    this.step_gamepad(dt, force_part, now);
    this.beat(); // timers may wait while frames follow each other
  }

  step_gamepad(dt, force_part, now) {
    const pad = navigator.getGamepads ? [...navigator.getGamepads()].find((one) => one && one.connected) : null;
    if (!pad) {
      if (this.by === 'gamepad') this.release();
      return;
    }
    const trigger = Math.max(pad.buttons[6]?.value ?? 0, pad.buttons[7]?.value ?? 0);
    if (trigger > 0.5 && !this.held && this.allowed()) this.grab('gamepad', null);
    if (trigger < 0.3 && this.by === 'gamepad') this.release();
    if (this.by !== 'gamepad') return;
    const axis = (i) => {
      const v = pad.axes[i] ?? 0;
      return Math.abs(v) < 0.12 ? 0 : v * Math.abs(v);
    };
    this.move(axis(0) * 260 * dt, -axis(1) * 260 * dt, -axis(3) * 260 * dt);
    if (force_part > 0.02 && now - (this.rumbled ?? 0) > 70) {
      this.rumbled = now;
      pad.vibrationActuator?.playEffect?.('dual-rumble', {
        duration: 110, strongMagnitude: Math.min(1, force_part), weakMagnitude: Math.min(1, 0.5 * force_part) })?.catch?.(() => {});
    }
  }

  /** The whole frame was drawn. @param {number} now ms */
  drawn(now) {
    this.last_drawn = now;
  }

  beat() {
    if (performance.now() - this.last_sent >= HEARTBEAT - 5) this.tell(false);
  }

  tell(always) {
    const now = performance.now();
    if (!always && now - this.last_drawn > HANGS_AFTER) return this.fall_silent(); // nobody holds what they cannot see
    if (!this.allowed() || (!always && now - this.last_sent < LEAST_GAP)) return;
    this.last_sent = now;
    ++this.sent;
    this.send({ type: 'input', p: this.p.toArray(), q: [this.q.w, this.q.x, this.q.y, this.q.z], held: this.held });
  }

  /** The ends of the drawn spring: the held point of the target and of the tool; null while released. */
  spring() {
    if (!this.held) return null;
    const tool = this.scene.tool_object();
    return [this.grip.clone().applyQuaternion(this.q).add(this.p), this.grip.clone().applyQuaternion(tool.quaternion).add(tool.position)];
  }
}
