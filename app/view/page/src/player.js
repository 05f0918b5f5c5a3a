// The clock of a replay: play, pause, scrub, speed, loop.

export class Player {
  /** @param {number} duration s */
  constructor(duration) {
    this.duration = duration;
    this.time = 0;
    this.playing = false;
    this.last = performance.now();
    const at = (id) => document.getElementById(id);
    this.scrub = at('scrub');
    this.button = at('play');
    this.scrub.max = duration;
    this.button.addEventListener('click', () => this.play(!this.playing));
    this.scrub.addEventListener('input', () => { this.time = Number(this.scrub.value); });
    this.speed = at('speed');
    this.loop = at('loop');
    this.output = at('play-time');
  }
  play(on) {
    if (on && this.time >= this.duration) this.time = 0;
    this.playing = on;
    this.button.textContent = on ? 'Pause' : 'Play';
  }
  /** Once a frame: the time to be shown, s. */
  frame() {
    const now = performance.now();
    if (this.playing) this.time += (now - this.last) / 1000 * Number(this.speed.value);
    this.last = now;
    if (this.time >= this.duration) {
      if (this.loop.checked && this.playing) this.time = 0;
      else {
        this.time = this.duration;
        if (this.playing) this.play(false);
      }
    }
    this.scrub.value = this.time;
    this.output.textContent = `${this.time.toFixed(2)} of ${this.duration.toFixed(2)} s`;
    return this.time;
  }
}
