// Makes the commanded force heard: a tone that rises and grows with the force.

export class Feel {
  constructor() {
    this.context = null;
  }

  /** Called by a click: browsers let no page sound before one. */
  switch(on) {
    if (on && !this.context) {
      const Context = window.AudioContext ?? window.webkitAudioContext;
      if (!Context) return false;
      this.context = new Context();
      this.tone = this.context.createOscillator();
      this.tone.type = 'triangle';
      this.gain = this.context.createGain();
      this.gain.gain.value = 0;
      this.tone.connect(this.gain).connect(this.context.destination);
      this.tone.start();
    }
    if (this.context) (on ? this.context.resume() : this.context.suspend()).catch(() => {});
    this.on = on;
    return true;
  }

  /** @param {number} part of the largest force, 0 to 1 */
  force(part) {
    if (!this.on || !this.context) return;
    const level = Math.min(1, Math.max(0, part));
    const now = this.context.currentTime;
    this.tone.frequency.setTargetAtTime(70 * 2 ** (3 * level), now, 0.015);
    this.gain.gain.setTargetAtTime(level < 0.003 ? 0 : 0.05 + 0.2 * level, now, 0.015);
  }
}
