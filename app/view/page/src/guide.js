// One line that says what to try next, and goes on as things happen.
import { by_id, set_text, show } from './dom.js';

const KEY = 'tactor.guide';
const remembered = () => {
  try {
    return sessionStorage.getItem(KEY) === 'away';
  } catch {
    return false; // a file opened from a disk may have no storage
  }
};
const remember = () => {
  try {
    sessionStorage.setItem(KEY, 'away');
  } catch {
    // then it comes again
  }
};

/**
 * The steps for a graph.
 * @param {object} hello
 * @returns {{text: string, done: function(object): boolean}[]} `done` looks at {held_for (s), contacts, force (N), felt, seconds}
 */
export function steps_of(hello) {
  const steps = [];
  if (hello.mode === 'replay') {
    return [{ text: 'This is a recording. Drag the slider to another time; drag in a chart to zoom; drag in the scene to look around.', done: () => false }];
  }
  if (hello.device?.mouse) steps.push({ text: 'Press on the orange tool and drag it. While you hold it, the wheel moves it in depth.', done: (now) => now.held_for > 0.5 });
  steps.push({ text: 'Press the tool into the other body, until the bar shows a force.', done: (now) => now.force > 0.03 * (hello.device?.force_max || 5) && now.contacts !== 0 });
  steps.push({ text: 'Keep pressing and drag a short span in the chart: the blue physics curve comes in steps. A hand feels them as roughness.', done: (now) => now.seconds > 9 });
  const choices = hello.methods?.choices ?? [];
  const named = (pattern) => choices.find((choice) => pattern.test(choice.label));
  const wanted = [named(/refit/i), named(/local/i)].filter(Boolean);
  for (const choice of wanted.length ? wanted : choices.slice(1, 3)) {
    steps.push({ text: `Switch to “${choice.label}” and press again: the commanded force goes on between the steps.`,
      done: (now) => now.felt.has(choice.value) && now.seconds > 5 });
  }
  if (choices.length) steps.push({ text: 'Compare error and delay of the methods in the table.', done: (now) => now.seconds > 15 });
  if (hello.parameters.length) steps.push({ text: 'Turn a knob while you press, for example the stiffness of the coupling.', done: () => false });
  return steps;
}

export class Guide {
  constructor(hello) {
    this.steps = steps_of(hello);
    this.at = 0;
    this.since = performance.now();
    by_id('guide-next').addEventListener('click', () => this.next());
    by_id('guide-away').addEventListener('click', () => {
      show(by_id('guide'), false);
      remember();
      this.away = true;
    });
    this.away = remembered();
    show(by_id('guide'), !this.away && this.steps.length > 0);
    this.show();
  }

  next() {
    this.at = Math.min(this.at + 1, this.steps.length - 1);
    this.since = performance.now();
    this.show();
  }

  show() {
    if (!this.steps.length) return;
    set_text(by_id('guide-text'), this.steps[this.at].text);
    set_text(by_id('guide-step'), `${this.at + 1}/${this.steps.length}`);
    show(by_id('guide-next'), this.at + 1 < this.steps.length);
    show(by_id('guide-step'), this.steps.length > 1);
  }

  /** @param {{held: boolean, contacts: number, force: number, felt: Set<string>}} state */
  look(state) {
    if (this.away || !this.steps.length || this.at + 1 >= this.steps.length) return;
    const now = performance.now();
    if (!state.held) this.held_since = undefined;
    else this.held_since ??= now;
    const held_for = this.held_since === undefined ? 0 : (now - this.held_since) / 1000;
    if (this.steps[this.at].done({ ...state, held_for, seconds: (now - this.since) / 1000 })) this.next();
  }
}
