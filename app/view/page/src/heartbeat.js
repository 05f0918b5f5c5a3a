// Decides when the newest input is sent again for a page that is busy drawing.

/** How long the page's thread may send no input, in ms: a frame at 2 frames/s, and a half more. A page that is silent for longer
 * hangs: it would not notice that its user lets go. */
export const HANGS_AFTER = 800;
/** How long after an input it is sent again, in ms. The server releases the tool after 200 ms without one. */
const REPEAT_AFTER = 40;

export class Heartbeat {
  constructor() {
    this.input = null;
    this.heard = -Infinity; // ms, when the page's thread sent the input
    this.sent = -Infinity; // ms
  }

  /** The page's thread sent an input at `now`, in ms. @param {string} input @param {number} now */
  take(input, now) {
    this.input = input;
    this.heard = this.sent = now;
  }

  /** Nothing is sent again until the next input. */
  fall_silent() {
    this.input = null;
  }

  /** The input that is to be sent again at `now`, in ms, or null. @param {number} now @returns {string | null} */
  due(now) {
    if (this.input === null || now - this.heard > HANGS_AFTER || now - this.sent < REPEAT_AFTER) return null;
    this.sent = now;
    return this.input;
  }
}
