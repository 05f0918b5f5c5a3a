// What a participant of an experiment sees and answers: the question, two buttons, and how much is done.
import { make, set_text } from './dom.js';

const PHASES = ['waiting', 'lift', 'changing', 'first', 'second', 'answering', 'done'];
const TEXTS = {
  waiting: 'Press 1 or 2 to begin.',
  lift: 'Lift off: let go of what you touch.',
  changing: 'Wait.',
  first: 'Feel the first.',
  second: 'Feel the second.',
  answering: '1 for the first, 2 for the second.',
  done: 'Thank you. That was all.',
};

/** What a row of the stream says. @param {number[]} row @param {Object<string, number>} column */
export function shown_of(row, column) {
  const phase = PHASES[row[column.phase]] ?? 'waiting';
  const block = row[column.blocks] > 1 ? `part ${row[column.block]} of ${row[column.blocks]}` : '';
  const trial = row[column.trial] > 0 ? `trial ${row[column.trial]}` : '';
  return { phase, text: TEXTS[phase], count: [block, trial].filter(Boolean).join(', '), progress: row[column.progress] };
}

export class Experiment {
  /** @param {HTMLElement} parent @param {object} hello @param {function(string, string): void} set */
  constructor(parent, hello, set) {
    this.parameter = hello.experiment.answer;
    this.set = set;
    this.phase = 'waiting';
    this.text = make('p', { class: 'experiment-text', role: 'status' });
    this.count = make('p', { class: 'note' });
    this.bar = make('progress', { max: 1, value: 0, 'aria-label': 'how much is done' });
    this.buttons = ['first', 'second'].map((value, i) => make('button', { type: 'button', 'data-answer': value, text: `${i + 1}  the ${value}`,
      on: { click: () => this.answer(value) } }));
    parent.append(make('h2', { text: hello.title || 'Which was more?' }), this.text, make('div', { class: 'experiment-answers' }, this.buttons), this.bar, this.count);
  }

  get asks() {
    return this.phase === 'waiting' || this.phase === 'answering';
  }

  /** Sends an answer where a question is open. @param {'first' | 'second'} value */
  answer(value) {
    if (this.asks && this.enabled) this.set(this.parameter, value);
  }

  /** @param {{row: function(number): number[], column: object, end: number, size: number} | undefined} stream @param {boolean} enabled */
  look(stream, enabled) {
    this.enabled = enabled;
    if (stream?.size) {
      const shown = shown_of(stream.row(stream.end - 1), stream.column);
      this.phase = shown.phase;
      set_text(this.text, shown.text);
      set_text(this.count, shown.count);
      this.bar.value = shown.progress;
    }
    for (const button of this.buttons) button.disabled = !enabled || !this.asks;
  }
}
