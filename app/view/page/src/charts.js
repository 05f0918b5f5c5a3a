// The curves: uPlot over as many columns as there are pixels, with the smallest and the largest sample of each.
import uPlot from 'uplot';

/** Colours that stay apart for colour-blind readers (Okabe and Ito). */
export const COLORS = {
  physics: '#8a8f96', predicted: '#e69f00', interpolated: '#56b4e9', commanded: '#d55e00', reference: '#009e73',
  one: '#0072b2', two: '#e69f00', three: '#d55e00',
};

/**
 * Puts rows into pixel columns: two slots a column, for the smallest and the largest value in the order in which they come.
 * @param {import('./store.js').Rows} rows
 * @param {(values: Float32Array, offset: number) => number} get the value of the row that begins at `offset`
 * @param {number} t0 s @param {number} t1 s @param {number} columns
 * @param {'line'|'hold'|'points'} style `hold`: a value holds until the next
 * @returns {(number|null)[]} 2 x columns values; null where there is none
 */
export function decimate(rows, get, t0, t1, columns, style) {
  const slots = new Array(2 * columns).fill(null);
  if (!rows || rows.count === 0) return slots;
  const {times, values, width} = rows;
  let i = rows.after(t0);
  let held = i > rows.begin ? get(values, (i - 1) * width) : null;
  const before = held;
  const perColumn = (t1 - t0) / columns;
  for (let c = 0; c < columns; ++c) {
    const end = t0 + (c + 1) * perColumn;
    let low = Infinity;
    let high = -Infinity;
    let lowFirst = true;
    for (; i < rows.end && times[i] <= end; ++i) {
      const v = get(values, i * width);
      if (v < low) { low = v; lowFirst = false; }
      if (v > high) { high = v; lowFirst = true; }
      held = v;
    }
    if (low <= high) {
      slots[2 * c] = lowFirst ? low : high;
      slots[2 * c + 1] = lowFirst ? high : low;
      if (style === 'points') slots[2 * c + 1] = null;
    } else if (style === 'hold' && i < rows.end + 1 && held !== null && (i < rows.end || times[rows.end - 1] > end - 1)) {
      slots[2 * c] = slots[2 * c + 1] = held;
    }
  }
  // A line begins at the border where a sample lies before it.
  if (style === 'line' && slots[0] === null) slots[0] = before;
  return slots;
}

/** The window of time that all charts show. */
export class Timeline {
  constructor() {
    this.window = 5;
    this.held = null;  // [t0, t1] where it is paused or zoomed
  }
  range(now) { return this.held ?? [now - this.window, now]; }
  pause(now) { this.held = this.range(now); }
  go() { this.held = null; }
}

/**
 * @typedef {{label: string, color: string, style: 'line'|'hold'|'points', rows: () => object|null,
 *   get: (values: Float32Array, offset: number) => number, dash?: number[]}} CurveSpec
 */
export class Chart {
  /**
   * @param {HTMLElement} parent @param {string} title @param {string} unit @param {CurveSpec[]} curves
   * @param {Timeline} timeline @param {() => void} changed called when somebody zooms
   */
  constructor(parent, title, unit, curves, timeline, changed, height = 150) {
    this.parent = parent;
    this.curves = curves;
    this.timeline = timeline;
    this.height = height;
    const style = getComputedStyle(document.documentElement);
    const ink = style.getPropertyValue('--quiet').trim();
    const line = style.getPropertyValue('--line').trim();
    const axis = {stroke: ink, grid: {stroke: line, width: 1}, ticks: {stroke: line, width: 1}, font: '11px system-ui, sans-serif'};
    this.plot = new uPlot({
      title: title || undefined,
      width: Math.max(parent.clientWidth, 200),
      height,
      cursor: {drag: {x: true, y: false, setScale: false}},
      select: {show: true},
      legend: {show: curves.length > 1, live: false},
      scales: {x: {time: false, auto: false}, y: {range: (u, low, high) => padded(low, high)}},
      axes: [{...axis, size: 26}, {...axis, size: 52, label: unit, labelSize: 14, labelFont: '11px system-ui, sans-serif'}],
      series: [{label: 's'}, ...curves.map((c) => ({
        label: c.label, stroke: c.color, width: 1.4, dash: c.dash, spanGaps: c.style === 'line',
        paths: c.style === 'points' ? () => null : undefined,
        points: {show: c.style === 'points', size: 4, fill: c.color, stroke: c.color},
      }))],
      hooks: {
        setSelect: [(u) => {
          if (u.select.width < 4) return;
          timeline.held = [u.posToVal(u.select.left, 'x'), u.posToVal(u.select.left + u.select.width, 'x')];
          u.setSelect({left: 0, top: 0, width: 0, height: 0}, false);
          changed();
        }],
      },
    }, [[0, 1], ...curves.map(() => [null, null])], parent);
    this.plot.over.addEventListener('dblclick', () => { timeline.go(); changed(); });
  }
  draw(now) {
    const width = Math.max(this.parent.clientWidth, 200);
    if (width !== this.plot.width) this.plot.setSize({width, height: this.height});
    const [t0, t1] = this.timeline.range(now);
    const columns = Math.max(50, Math.round(this.plot.over.clientWidth));
    const x = new Array(2 * columns);
    for (let i = 0; i < x.length; ++i) x[i] = t0 + (i + 0.5) / x.length * (t1 - t0);
    const data = this.curves.map((c, i) => this.plot.series[i + 1].show ? decimate(c.rows(), c.get, t0, t1, columns, c.style) : new Array(2 * columns).fill(null));
    this.plot.batch(() => {
      this.plot.setData([x, ...data], false);
      this.plot.setScale('x', {min: t0, max: t1});
    });
  }
}

function padded(low, high) {
  if (low === null || high === null || !Number.isFinite(low)) return [0, 1];
  if (low >= 0 && low < 0.3 * high) low = 0;
  const pad = Math.max(0.06 * (high - low), 1e-9 + 0.02 * Math.abs(high));
  return [low === 0 ? 0 : low - pad, high + pad];
}
