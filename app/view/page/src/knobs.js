// The knobs of the graph: a slider and a number, a choice or a switch for each tunable parameter.

const SAY_MS = 50;

/** Where a value lies on its slider, 0 to 1, and back: logarithmic where the bounds span more than two decades. */
export function scaleOf(parameter) {
  const value = Math.abs(parameter.value) || 1;
  const min = parameter.min ?? (parameter.value < 0 ? -10 * value : 0);
  const max = Math.min(parameter.max ?? Infinity, 10 * Math.max(value, Math.abs(min)));
  const low = min > 0 ? min : max / 1000;
  if (min >= 0 && max / low >= 100 && min > 0) {
    const ratio = Math.log(max / low);
    return {to: (v) => Math.log(Math.max(v, low) / low) / ratio, from: (x) => low * Math.exp(x * ratio)};
  }
  return {to: (v) => (v - min) / (max - min), from: (x) => min + x * (max - min)};
}

/** A number as a person reads it: four digits. */
export function short(value) {
  return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(4)));
}

export class Knobs {
  /** @param {HTMLElement} parent @param {object[]} parameters of hello @param {(name: string, value: string) => void} ask */
  constructor(parent, parameters, ask) {
    this.ask = ask;
    this.knobs = new Map();
    this.values = {};
    this.waiting = new Map();
    this.said = 0;
    let node = '';
    if (parameters.length === 0) parent.textContent = 'No parameter of this graph can be changed while it runs.';
    for (const parameter of parameters) {
      const [of, name] = parameter.name.split('.');
      if (of !== node) {
        node = of;
        parent.append(element('div', {className: 'knobs-node', textContent: of}));
      }
      parent.append(this.make(parameter, name));
    }
  }
  make(parameter, name) {
    const row = element('div', {className: 'knob', id: `knob-${parameter.name}`, title: `${parameter.doc}${bounds(parameter)}`});
    const label = element('label', {className: 'name', textContent: parameter.unit && parameter.unit !== '1' ? `${name}, ${parameter.unit}` : name});
    const said = element('div', {className: 'said', hidden: true});
    const knob = {said, show: () => {}};
    const ask = (value) => this.later(parameter.name, String(value));
    this.values[parameter.name] = parameter.value;
    if (parameter.kind === 'choice') {
      const select = element('select', {id: `${row.id}-value`});
      for (const choice of parameter.choices) select.append(element('option', {value: choice, textContent: choice}));
      select.addEventListener('change', () => ask(select.value));
      knob.show = (v) => { select.value = v; };
      row.append(label, element('span'), select, said);
    } else if (parameter.kind === 'flag') {
      const box = element('input', {type: 'checkbox', id: `${row.id}-value`});
      box.addEventListener('change', () => ask(box.checked));
      knob.show = (v) => { box.checked = v; };
      row.append(label, element('span'), box, said);
    } else {
      const scale = scaleOf(parameter);
      const slider = element('input', {type: 'range', min: 0, max: 1, step: 'any', id: `${row.id}-slider`});
      slider.setAttribute('aria-label', parameter.name);
      const number = element('input', {type: 'number', step: 'any', id: `${row.id}-value`});
      slider.addEventListener('input', () => {
        const value = scale.from(Number(slider.value));
        const rounded = parameter.kind === 'integer' ? Math.round(value) : Number(value.toPrecision(3));
        number.value = short(rounded);
        ask(rounded);
      });
      number.addEventListener('change', () => ask(number.value));
      knob.show = (v) => { number.value = short(v); slider.value = scale.to(v); };
      row.append(label, slider, number, said);
    }
    label.htmlFor = `${row.id}-value`;
    knob.show(parameter.value);
    this.knobs.set(parameter.name, knob);
    return row;
  }
  /** A slider that is drawn along says no more than twenty values a second. */
  later(name, value) {
    this.waiting.set(name, value);
    const wait = Math.max(0, this.said + SAY_MS - performance.now());
    if (!this.timer) this.timer = setTimeout(() => this.sayAll(), wait);
  }
  sayAll() {
    this.timer = null;
    this.said = performance.now();
    for (const [name, value] of this.waiting) this.ask(name, value);
    this.waiting.clear();
  }
  /** The server tells a value. */
  set(name, value) {
    this.values[name] = value;
    const knob = this.knobs.get(name);
    if (!knob) return;
    knob.said.hidden = true;
    if (!this.waiting.has(name)) knob.show(value);
  }
  /** The server refuses one. */
  refuse(name, message) {
    const knob = this.knobs.get(name);
    if (!knob) return;
    knob.said.hidden = false;
    knob.said.textContent = message;
    knob.show(this.values[name]);
  }
}

function bounds({min, max, unit}) {
  const of = unit && unit !== '1' ? ` ${unit}` : '';
  if (min !== undefined && max !== undefined) return `; from ${short(min)} to ${short(max)}${of}`;
  if (min !== undefined) return `; at least ${short(min)}${of}`;
  if (max !== undefined) return `; at most ${short(max)}${of}`;
  return '';
}

export function element(tag, properties = {}) {
  return Object.assign(document.createElement(tag), properties);
}
