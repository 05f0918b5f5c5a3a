// The parameters as sliders, numbers, choices and flags, grouped by node.
import { make, set_text } from './dom.js';

const STEPS = 1000;
const THROTTLE = 50; // ms: at most 20 changes a second while sliding
const MOST_FIRST = 5;

const node_of = (name) => name.slice(0, Math.max(0, name.indexOf('.')));

/**
 * The parameters that are shown before somebody asks for all: of each node the one that it declares first, then the second of each and so
 * on. Nodes declare what matters most first, and come in the order of the graph.
 * @param {string[]} names `node.parameter`, as in hello
 * @param {string} [elsewhere] one that the page shows at another place
 * @returns {Set<string>}
 */
export function first_parameters(names, elsewhere) {
  const places = new Map(); // how many of a node came before
  const ranked = names.filter((name) => name !== elsewhere).map((name, i) => {
    const place = places.get(node_of(name)) ?? 0;
    places.set(node_of(name), place + 1);
    return { name, place, i };
  });
  ranked.sort((a, b) => a.place - b.place || a.i - b.i);
  return new Set(ranked.slice(0, MOST_FIRST).map(({ name }) => name));
}

/** The bounds of a slider: those of the parameter; where it has none, ten times its value. */
export function slider_bounds({ min, max, value }) {
  const reach = 10 * (Math.abs(value) || 1);
  const low = min ?? (value < 0 ? -reach : 0);
  return { min: low, max: Math.min(max ?? Infinity, Math.max(reach, 10 * Math.abs(low))) };
}

/** A value between 0 and 1 for a place on the slider. */
export function to_slider(parameter, value) {
  const { min, max } = parameter;
  const part = is_log(parameter) ? Math.log(value / min) / Math.log(max / min) : (value - min) / (max - min);
  return Math.min(1, Math.max(0, part));
}
/** And back; integers are rounded, reals have 3 digits. */
export function from_slider(parameter, part) {
  const { min, max } = parameter;
  const value = is_log(parameter) ? min * (max / min) ** part : min + part * (max - min);
  if (parameter.kind === 'integer') return Math.round(value);
  if (part <= 0) return min;
  if (part >= 1) return max;
  return Number(value.toPrecision(3));
}
/** Whether a slider goes by decades: both bounds positive and far apart. */
export function is_log({ min, max, kind }) {
  return min > 0 && max / min >= 50 && kind !== 'choice';
}

const written = (value) => (typeof value === 'number' ? String(+value.toPrecision(6)) : String(value));

export class Knobs {
  /**
   * @param {HTMLElement} parent
   * @param {object[]} parameters of hello
   * @param {function(string, string): void} set
   * @param {string} [elsewhere] the parameter that buttons of the page set
   */
  constructor(parent, parameters, set, elsewhere) {
    this.parent = parent;
    this.set = set;
    this.first = first_parameters(parameters.map(({ name }) => name), elsewhere);
    this.knobs = new Map();
    const groups = new Map();
    for (const parameter of parameters) {
      const node = node_of(parameter.name);
      if (!groups.has(node)) groups.set(node, []);
      groups.get(node).push(parameter);
    }
    for (const [node, members] of groups) {
      const group = make('fieldset', { class: 'group' }, node ? [make('legend', { text: node })] : []);
      for (const parameter of members) group.append(this.make_knob(parameter, node));
      group.classList.toggle('more', members.every(({ name }) => !this.first.has(name)));
      parent.append(group);
    }
    if (this.first.size === parameters.length) return;
    this.button = make('button', { type: 'button', class: 'plain', id: 'all-knobs', on: { click: () => this.fold(!this.folded) } });
    parent.querySelector('h2').append(this.button);
    this.count = parameters.length;
    this.fold(true);
  }

  /** Shows the first parameters alone, or all. */
  fold(folded) {
    if (!this.button) return;
    this.folded = folded;
    this.parent.classList.toggle('folded', folded);
    this.button.setAttribute('aria-expanded', String(!folded));
    set_text(this.button, folded ? `all ${this.count}` : 'fewer');
  }

  make_knob(parameter, node) {
    const { name, kind, unit, min, max, doc } = parameter;
    const label = node ? name.slice(node.length + 1) : name;
    const bounds = [min !== undefined ? `from ${min}` : '', max !== undefined ? `to ${max}` : ''].filter(Boolean).join(' ');
    const title = [doc, bounds && `${bounds} ${unit ?? ''}`.trim()].filter(Boolean).join('\n');
    const id = `knob-${name}`;
    const knob = { parameter, value: parameter.value, last: 0, timer: 0, busy: false };
    knob.message = make('div', { class: 'refused', role: 'alert' });
    const change = (value, sliding) => this.change(knob, value, sliding);
    const row = make('div', { class: this.first.has(name) ? 'knob' : 'knob more', title }, [make('label', { for: id, text: label })]);
    if (kind === 'choice') {
      knob.input = make('select', { id, on: { change: () => change(knob.input.value) } }, parameter.choices.map((choice) => make('option', { value: choice, text: choice })));
      row.append(knob.input);
    } else if (kind === 'flag') {
      knob.input = make('input', { id, type: 'checkbox', on: { change: () => change(knob.input.checked) } });
      row.append(knob.input);
    } else {
      const scale = { kind, ...slider_bounds(parameter) };
      knob.number = make('input', { id: `${id}-number`, type: 'number', step: kind === 'integer' ? 1 : 'any', min, max, 'aria-label': name,
        on: { change: () => knob.number.value !== '' && change(Number(knob.number.value)), blur: () => this.show(knob) } });
      const sliding = () => {
        const value = from_slider(scale, knob.slider.value / STEPS);
        knob.number.value = written(value);
        change(value, true);
      };
      knob.scale = scale;
      knob.slider = make('input', { id, type: 'range', min: 0, max: STEPS, step: 1, on: {
        input: sliding,
        pointerdown: () => (knob.busy = true),
        pointerup: () => (knob.busy = false),
        pointercancel: () => (knob.busy = false),
        blur: () => (knob.busy = false),
      } });
      row.append(knob.slider);
      row.append(knob.number, make('span', { class: 'unit', text: unit ?? '' }));
    }
    row.append(knob.message);
    knob.row = row;
    this.knobs.set(name, knob);
    this.show(knob);
    return row;
  }

  change(knob, value, sliding = false) {
    set_text(knob.message, '');
    const now = performance.now();
    knob.wanted = value;
    clearTimeout(knob.timer);
    const send = () => {
      knob.last = performance.now();
      this.set(knob.parameter.name, String(knob.wanted));
    };
    if (sliding && now - knob.last < THROTTLE) knob.timer = setTimeout(send, THROTTLE - (now - knob.last));
    else send();
  }

  /** The server told a value. */
  told(name, value) {
    const knob = this.knobs.get(name);
    if (!knob) return;
    knob.value = value;
    set_text(knob.message, '');
    this.show(knob);
  }

  /** The server refused a change. */
  refused(name, message) {
    const knob = this.knobs.get(name);
    if (!knob) return;
    set_text(knob.message, message);
    if (!this.first.has(name)) this.fold(false);
    this.show(knob, true);
  }

  show(knob, always = false) {
    const { value } = knob;
    const active = document.activeElement;
    if (knob.number && (always || knob.number !== active)) knob.number.value = written(value);
    if (knob.slider && !knob.busy) knob.slider.value = Math.round(to_slider(knob.scale, value) * STEPS);
    if (knob.parameter.kind === 'choice') knob.input.value = value;
    if (knob.parameter.kind === 'flag') knob.input.checked = value === true || value === 'true';
  }

  /** Only the client in control can change anything. */
  enable(enabled) {
    if (this.enabled === enabled) return;
    this.enabled = enabled;
    for (const { row } of this.knobs.values()) for (const input of row.querySelectorAll('input, select')) input.disabled = !enabled;
  }
}
