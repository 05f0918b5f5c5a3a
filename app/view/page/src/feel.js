// The force as sound and as the rumble of a gamepad, since a mouse cannot push back.

export class Feel {
  constructor() {
    this.on = false;
    this.rumbled = 0;
  }
  /** To be called from a click: browsers let nothing sound before. */
  sound(on) {
    this.on = on;
    if (on && !this.context) {
      this.context = new AudioContext();
      this.tone = this.context.createOscillator();
      this.volume = this.context.createGain();
      this.tone.type = 'triangle';
      this.volume.gain.value = 0;
      this.tone.connect(this.volume).connect(this.context.destination);
      this.tone.start();
    }
    if (this.context) on ? this.context.resume() : this.context.suspend();
  }
  /** @param {number} share of the largest force, 0 to 1 */
  set(share) {
    if (this.on && this.context) {
      const now = this.context.currentTime;
      this.tone.frequency.setTargetAtTime(70 + 330 * share, now, 0.01);
      this.volume.gain.setTargetAtTime(share < 0.005 ? 0 : 0.03 + 0.3 * share, now, 0.01);
    }
    const now = performance.now();
    if (now - this.rumbled < 50) return;
    this.rumbled = now;
    const pad = navigator.getGamepads?.().find((p) => p?.vibrationActuator);
    pad?.vibrationActuator.playEffect('dual-rumble', {duration: 80, strongMagnitude: share, weakMagnitude: Math.min(1, 2 * share)}).catch(() => {});
  }
}
