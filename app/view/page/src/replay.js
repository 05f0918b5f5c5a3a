// The clock of a replay: play, pause, scrub, speed and loop.
import { by_id, set_text, show } from './dom.js';

export class Replay {
  /** @param {function(): [number, number]} span the times of the recording in s @param {function(): void} moved */
  constructor(span, moved) {
    Object.assign(this, { span, moved, time: undefined, playing: true, speed: 1, loop: true, complete: false, last: performance.now() });
    show(by_id('player'), true);
    by_id('play').addEventListener('click', () => this.toggle());
    by_id('scrub').addEventListener('input', (event) => {
      const [from, to] = this.span();
      this.seek(from + (event.target.value / 10000) * (to - from));
    });
    by_id('replay-speed').addEventListener('change', (event) => (this.speed = Number(event.target.value)));
    by_id('loop').addEventListener('change', (event) => (this.loop = event.target.checked));
    window.addEventListener('keydown', (event) => {
      if (event.target instanceof Element && event.target.closest('input[type=number], select, button')) return;
      if (event.key === ' ') {
        event.preventDefault();
        this.toggle();
      } else if ((event.key === 'ArrowLeft' || event.key === 'ArrowRight') && !event.target.closest?.('input')) {
        this.seek(this.time + (event.key === 'ArrowLeft' ? -1 : 1) * (event.shiftKey ? 0.01 : 0.5));
      }
    });
    this.show();
  }

  toggle() {
    const [, to] = this.span();
    if (!this.playing && this.time >= to) this.time = this.span()[0];
    this.playing = !this.playing;
    this.show();
  }

  pause() {
    this.playing = false;
    this.show();
  }

  seek(time) {
    const [from, to] = this.span();
    this.time = Math.min(to, Math.max(from, time));
    this.moved();
    this.show();
  }

  /** Called at every drawn frame; returns the time shown, in s. */
  step(now) {
    const dt = Math.min(0.25, (now - this.last) / 1000);
    this.last = now;
    const [from, to] = this.span();
    this.time ??= from;
    if (this.playing) {
      this.time += dt * this.speed;
      if (this.time > to) {
        if (!this.complete) this.time = to;
        else if (this.loop) this.time = from;
        else {
          this.time = to;
          this.playing = false;
        }
      }
      this.show();
    }
    return this.time;
  }

  show() {
    const [from, to] = this.span();
    set_text(by_id('play'), this.playing ? 'Pause' : 'Play');
    if (document.activeElement !== by_id('scrub') || this.playing) by_id('scrub').value = to > from ? Math.round(((this.time - from) / (to - from)) * 10000) || 0 : 0;
    set_text(by_id('replay-time'), this.time === undefined ? '' : `${this.time.toFixed(2)} of ${to.toFixed(2)} s${this.complete ? '' : ', loading'}`);
  }
}
