// The methods side by side: a button for each, and what was measured while each was felt.
import { make, set_text } from './dom.js';

export class Methods {
  /** @param {HTMLElement} parent @param {object} hello @param {function(string, string): void} set */
  constructor(parent, hello, set) {
    this.told_methods = hello.methods;
    this.felt = new Set(); // the methods whose figures are known
    this.rows = new Map();
    const { parameter, choices } = hello.methods;
    const body = make('tbody');
    choices.forEach(({ value, label }, i) => {
      const button = make('button', { type: 'button', 'data-method': value, 'aria-pressed': 'false', text: label, title: `${parameter} = ${value} (key ${i + 1})`,
        on: { click: () => set(parameter, value) } });
      const error = make('td', { text: '–' });
      const delay = make('td', { text: '–' });
      const row = make('tr', {}, [make('th', { scope: 'row' }, [button]), error, delay]);
      this.rows.set(value, { row, button, error, delay });
      body.append(row);
    });
    parent.append(make('table', { id: 'method-table' }, [
      make('thead', {}, [make('tr', {}, [make('th', { text: 'felt method', scope: 'col' }),
        make('th', { text: 'error, RMS', scope: 'col', title: 'RMS of the commanded force minus the reference, while this method was felt last' }),
        make('th', { text: 'delay', scope: 'col', title: 'how late the commanded force is behind the reference' })])]), body]));
    this.note = make('p', { class: 'note' });
    parent.append(this.note);
    const now = hello.parameters.find((one) => one.name === parameter)?.value ?? choices[0]?.value;
    this.told(parameter, now);
  }

  told(name, value) {
    if (name !== this.told_methods.parameter) return false;
    this.current = value;
    for (const [choice, { row, button }] of this.rows) {
      button.setAttribute('aria-pressed', String(choice === value));
      row.classList.toggle('current', choice === value);
    }
    return true;
  }

  label(value) {
    return this.told_methods.choices.find((choice) => choice.value === value)?.label ?? value;
  }

  /** @param {{rms?: number, max?: number, delay?: number, behind?: number} | undefined} reference N, N, s, s */
  reference(reference) {
    if (!reference) {
      set_text(this.note, this.felt.size ? '' : 'No reference runs beside this run.');
      return;
    }
    const row = this.rows.get(this.current);
    if (row && reference.rms !== undefined) {
      this.felt.add(this.current);
      set_text(row.error, `${reference.rms.toFixed(3)} N`);
      if (reference.max !== undefined) row.error.title = `at most ${reference.max.toFixed(2)} N`;
      set_text(row.delay, reference.delay === undefined ? '–' : `${(1000 * reference.delay).toFixed(1)} ms`);
    }
    set_text(this.note, reference.behind > 0.5 ? `The reference is ${reference.behind.toFixed(1)} s behind.` : '');
  }

  enable(enabled) {
    for (const { button } of this.rows.values()) button.disabled = !enabled;
  }
}
