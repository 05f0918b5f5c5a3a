// One line that says what to try next; it can be put away.

function remembered() {
  try { return sessionStorage.getItem('guide') === 'away'; } catch { return false; }
}

/** The steps for a graph. Each has a text and `done(now)`, now = {held, force, rate, method}. */
export function stepsFor(hello) {
  if (!hello.device.mouse) return [];
  const steps = [
    {text: 'Press the mouse on the blue tool and hold it.', done: (now) => now.held},
    {text: 'Drag the tool into the other body until you see a force.', done: (now) => now.force > 0.2},
  ];
  const {methods} = hello;
  if (!methods) return [...steps, {text: 'Turn a knob below while you press: coupling.k_0 makes the contact stiffer or softer.', done: () => false}];
  const choice = (value) => methods.choices.find((c) => c.value === value)?.label ?? value;
  const first = methods.choices[0];
  const other = methods.choices.find((c) => /refit/.test(c.label)) ?? methods.choices[1];
  const last = methods.choices.at(-1);
  steps.push({
    text: `Keep pressing and slide. Physics answers about 60 times a second, and with "${first.label}" the force goes in steps: look at the curve.`,
    done: (now) => now.pressed > 4 || now.method !== first.value,
  });
  if (other.value !== first.value) steps.push({text: `Press and slide with "${choice(other.value)}" now: forecast and spline make the force smooth, and late.`, done: (now) => now.method === other.value && now.felt > 4});
  if (last.value !== other.value) steps.push({text: `Now "${choice(last.value)}": the tool is simulated from each result of physics to now.`, done: (now) => now.method === last.value && now.felt > 4});
  steps.push({text: 'Compare error and delay of the methods in the table. Then turn a knob below, or save the last minute as a file.', done: () => false});
  return steps;
}

export class Guide {
  constructor(hello) {
    this.steps = stepsFor(hello);
    this.step = 0;
    this.pressed = 0;
    this.felt = 0;
    this.method = null;
    this.box = document.getElementById('guide');
    this.text = document.getElementById('guide-text');
    document.getElementById('guide-close').addEventListener('click', () => {
      this.steps = [];
      this.box.hidden = true;
      try { sessionStorage.setItem('guide', 'away'); } catch { /* a page without storage asks again */ }
    });
    if (remembered()) this.steps = [];
  }
  /** @param {{held: boolean, force: number, method: string|null}} now @param {number} seconds since the last call */
  frame(now, seconds) {
    if (this.step >= this.steps.length) return;
    const touching = now.held && now.force > 0.2;
    if (now.method !== this.method) { this.method = now.method; this.felt = 0; }
    if (touching) { this.pressed += seconds; this.felt += seconds; }
    if (this.steps[this.step].done({...now, pressed: this.pressed, felt: this.felt})) {
      this.step += 1;
      this.pressed = 0;
      this.felt = 0;
    }
    this.box.hidden = false;
    this.text.textContent = this.steps[this.step]?.text ?? '';
  }
}
