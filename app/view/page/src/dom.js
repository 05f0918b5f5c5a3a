// Small helpers to make and find elements.

/**
 * @param {string} tag
 * @param {Object<string, unknown>} [attributes] `text`, `class`, `on` (name to listener), else attributes
 * @param {(Node | string)[]} [children]
 * @returns {HTMLElement}
 */
export function make(tag, attributes = {}, children = []) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === 'text') element.textContent = value;
    else if (name === 'class') element.className = value;
    else if (name === 'on') for (const [event, listener] of Object.entries(value)) element.addEventListener(event, listener);
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children);
  return element;
}

const SVG = 'http://www.w3.org/2000/svg';
/** The same for SVG. */
export function make_svg(tag, attributes = {}, children = []) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === 'text') element.textContent = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

/** @returns {HTMLElement} */
export const by_id = (id) => document.getElementById(id);

/** Sets text only where it changes, which spares the browser work. */
export function set_text(element, text) {
  if (element && element.textContent !== text) element.textContent = text;
}

export const show = (element, shown) => element && (element.hidden = !shown);

/** A time span in the unit that suits it. */
export function span(seconds) {
  if (seconds === undefined || seconds === null || !Number.isFinite(seconds)) return '–';
  const s = Math.abs(seconds);
  if (s >= 1) return `${seconds.toFixed(2)} s`;
  if (s >= 1e-3) return `${(seconds * 1e3).toPrecision(3)} ms`;
  return `${(seconds * 1e6).toFixed(0)} µs`;
}

/** A rate in Hz. */
export const hertz = (rate) => (rate === undefined || rate === null ? '–' : `${rate >= 100 ? Math.round(rate) : rate.toPrecision(3)} Hz`);
