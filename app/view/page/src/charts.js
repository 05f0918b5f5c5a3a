// Charts over time with uPlot: a sliding window, pause, zoom, and curves of different rates on one axis of pixel columns.
import uPlot from 'uplot';
import { column_grid, column_times, decimate, leave_out } from './decimate.js';

/** What part of time all charts show. */
export class Timeline {
  constructor() {
    this.window = 5; // s
    this.zoom = null; // [from, to] in s
    this.held = null; // s, the right side while paused
    this.begin = 0; // s, of the first sample
    this.whole = Infinity; // s, the length of a replay: a window is no longer
    this.ahead = 0; // part of the window right of now, in a replay
  }
  /** @param {number} now s @returns {[number, number]} */
  range(now) {
    if (this.zoom) return this.zoom;
    const width = Math.min(this.window, this.whole);
    const right = Math.min(Math.max((this.held ?? now) + this.ahead * width, this.begin + width), this.begin + this.whole);
    return [right - width, right];
  }
}

/** @typedef {{rows: import('./store.js').Rows, column: string, label: string, colour: string, step?: boolean, dash?: number[], width?: number, scale?: number, shown?: boolean}} Curve */

export class Chart {
  /**
   * @param {HTMLElement} parent
   * @param {object} spec
   * @param {Curve[]} spec.curves
   * @param {boolean} [spec.from_zero] the axis begins at 0
   * @param {Timeline} timeline
   * @param {{zoom: function(number, number), back: function(), pick: function(number), marks: function(): {time: number, label: string}[]}} events
   */
  constructor(parent, spec, timeline, events) {
    Object.assign(this, { parent, spec, timeline, events, curves: spec.curves, dark: false, last_draw: 0, visible: true, cost: 0 });
    this.hidden = new Set(spec.curves.filter((curve) => curve.shown === false).map((curve) => curve.label));
    this.data = [[], ...spec.curves.map(() => [])];
    this.head = null;
    this.range = [0, 1]; // s, what is drawn
    this.last = 0; // s, the newest time
    this.observer = new ResizeObserver(() => this.fit());
    this.observer.observe(parent);
    if (typeof IntersectionObserver !== 'undefined') {
      new IntersectionObserver((entries) => (this.visible = entries.at(-1).isIntersecting)).observe(parent);
    }
  }

  size() {
    const legend = this.plot ? this.plot.root.querySelector('.u-legend').offsetHeight : 24;
    return { width: Math.max(120, this.parent.clientWidth), height: Math.max(60, this.parent.clientHeight - legend - 1) };
  }

  build() {
    const ink = this.dark ? '#aab4bf' : '#4d5761';
    const grid = { stroke: this.dark ? '#2b3238' : '#e3e7ea', width: 1 };
    const ticks = { show: false };
    const font = '11px system-ui, sans-serif';
    this.plot = new uPlot({
      ...this.size(),
      pxAlign: 0,
      cursor: {
        sync: { key: 'tactor' },
        drag: { x: true, y: false, setScale: false },
        points: { size: 5 },
        bind: { dblclick: () => () => this.events.back() },
      },
      select: { show: true },
      legend: { live: true },
      scales: {
        x: { time: false, auto: false, min: 0, max: 1 },
        y: { auto: true, range: (_, low, high) => this.y_range(low, high) },
      },
      axes: [
        { stroke: ink, grid, ticks, font, size: 22, gap: 3, space: 70, values: (_, splits) => splits.map((v) => (v == null ? '' : `${+v.toFixed(6)} s`)) },
        { stroke: ink, grid, ticks, font, size: 46, gap: 4, space: 26, values: (_, splits) => splits.map(short) },
      ],
      series: [
        { label: 't', value: (_, v) => (v == null ? '' : `${v.toFixed(3)} s`) },
        ...this.curves.map((curve) => ({
          label: curve.label, stroke: curve.colour, width: curve.width ?? 1.5, dash: curve.dash, spanGaps: false, gaps: (plot) => this.gaps_in_pixels(plot, curve), show: !this.hidden.has(curve.label),
          points: { show: false }, value: (_, v) => (v == null ? '' : v.toPrecision(3)),
        })),
      ],
      hooks: {
        setSelect: [(plot) => this.selected(plot)],
        setSeries: [(plot, index, options) => {
          if (index == null || options.show === undefined) return;
          const { label } = this.curves[index - 1];
          if (options.show) this.hidden.delete(label);
          else this.hidden.add(label);
          this.last_draw = 0;
        }],
        draw: [(plot) => this.draw_marks(plot)],
      },
    }, this.data, this.parent);
    this.plot.over.addEventListener('click', (event) => {
      if (this.dragged) {
        this.dragged = false;
        return;
      }
      const box = this.plot.over.getBoundingClientRect();
      this.events.pick(this.plot.posToVal(event.clientX - box.left, 'x'));
    });
    this.fit();
  }

  /** Where a curve has no samples. Columns without one between samples are no gap. */
  gaps_in_pixels({ bbox, valToPos }, curve) {
    const x_of = (time) => Math.min(bbox.left + bbox.width, Math.max(bbox.left, valToPos(time, 'x', true)));
    const [from, to] = this.range;
    return curve.rows.gaps_until(this.last).filter((gap) => gap[1] > from && gap[0] < to).map((gap) => [x_of(gap[0]), x_of(Math.min(gap[1], to))]);
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < 3) return;
    this.dragged = true;
    this.events.zoom(plot.posToVal(left, 'x'), plot.posToVal(left + width, 'x'));
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  y_range(low, high) {
    if (low == null || high == null || !Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
    if (this.spec.from_zero || (low >= 0 && low < 0.4 * high)) low = Math.min(0, low);
    const pad = 0.06 * (high - low) || Math.max(1e-9, 0.1 * Math.abs(high)) || 0.5;
    const want = [low === 0 ? 0 : low - pad, high + pad];
    if (want[0] === 0 && want[1] <= 2e-9) want[1] = 1;
    // A little inertia: the axis does not breathe with every sample.
    const had = this.y_had;
    if (had && had[0] <= low && had[1] >= high && had[1] - had[0] < 1.6 * (want[1] - want[0])) return had;
    return (this.y_had = want);
  }

  /** Thin lines where the method changed, and the play head. */
  draw_marks(plot) {
    const { ctx, bbox } = plot;
    const line = (time, colour, dash, label) => {
      const x = Math.round(plot.valToPos(time, 'x', true)) + 0.5;
      if (x < bbox.left || x > bbox.left + bbox.width) return;
      ctx.save();
      ctx.strokeStyle = colour;
      ctx.fillStyle = colour;
      ctx.lineWidth = 1;
      ctx.setLineDash(dash);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      if (label) {
        ctx.font = `${Math.round(10 * uPlot.pxRatio)}px system-ui, sans-serif`;
        ctx.textAlign = 'left';
        ctx.fillText(label, x + 4, bbox.top + 10 * uPlot.pxRatio);
      }
      ctx.restore();
    };
    for (const mark of this.events.marks()) line(mark.time, this.dark ? '#8b96a1' : '#6a7580', [4, 3], this.spec.marks ? mark.label : '');
    if (this.head !== null) line(this.head, this.dark ? '#e6edf3' : '#1f2429', [], '');
  }

  fit() {
    if (!this.plot || !this.parent.clientWidth) return;
    const size = this.size();
    if (size.width !== this.plot.width || size.height !== this.plot.height) this.plot.setSize(size);
    this.last_draw = 0;
  }

  set_dark(dark) {
    this.dark = dark;
    this.rebuild();
  }

  rebuild() {
    this.plot?.destroy();
    this.plot = null;
    this.y_had = null;
    this.last_draw = 0;
  }

  /** Other columns of the same streams. */
  choose(column) {
    for (const curve of this.curves) curve.column = column;
    this.y_had = null;
    this.last_draw = 0;
  }

  /**
   * @param {number} now s, what is shown: the newest time or the play head
   * @param {number} last s, the newest time
   * @param {number | null} head s, the play head, if there is one
   */
  draw_at(now, last, head) {
    if (!this.plot) this.build();
    const begin = performance.now();
    this.head = head;
    const [from, to] = this.timeline.range(now);
    this.range = [from, to];
    this.last = last;
    const grid = column_grid(from, to, Math.min(1400, Math.max(50, this.plot.over.clientWidth)));
    column_times(grid, this.data[0]);
    this.curves.forEach((curve, i) => {
      const offset = curve.rows.column[curve.column];
      const out = this.data[i + 1];
      if (offset === undefined || this.hidden.has(curve.label)) {
        out.length = this.data[0].length;
        out.fill(null);
        return;
      }
      decimate(curve.rows, offset, grid.t0, grid.dt, grid.columns, Boolean(curve.step), last, out);
      leave_out(curve.rows.gaps_until(last), grid, out);
      if (curve.scale) for (let k = 0; k < out.length; ++k) if (out[k] !== null) out[k] *= curve.scale;
    });
    this.plot.batch(() => {
      this.plot.setData(this.data, false);
      this.plot.setScale('x', { min: from, max: to });
    });
    this.cost = performance.now() - begin;
    this.last_draw = begin;
  }
}

/** A number for an axis. */
function short(v) {
  if (v == null) return '';
  if (v !== 0 && Math.abs(v) < 1e-3) return v.toExponential(0);
  return String(+v.toPrecision(4));
}

/**
 * A plain chart of the force on a canvas of one's own, for pictures.
 * @param {CanvasRenderingContext2D} context
 * @param {{x: number, y: number, width: number, height: number}} box px
 * @param {Curve[]} curves
 * @param {[number, number]} range s
 * @param {number} now s; nothing is drawn right of it
 * @param {boolean} dark
 */
export function draw_strip(context, box, curves, range, now, dark) {
  const left = box.x + 44, right = box.x + box.width - 10, top = box.y + 22, bottom = box.y + box.height - 20;
  const width = right - left;
  const grid = column_grid(range[0], range[1], width);
  const lines = curves.map((curve) => {
    const out = [];
    decimate(curve.rows, curve.rows.column[curve.column], grid.t0, grid.dt, grid.columns, Boolean(curve.step), now, out);
    leave_out(curve.rows.gaps_until(now), grid, out);
    return out;
  });
  const times = [];
  column_times(grid, times);
  let low = 0, high = 0.1;
  for (const line of lines) {
    line.forEach((v, i) => {
      if (v === null || times[i] > now + grid.dt) return;
      low = Math.min(low, v);
      high = Math.max(high, v);
    });
  }
  high *= 1.06;
  low *= 1.06;
  const x_of = (t) => left + ((t - range[0]) / (range[1] - range[0])) * width;
  const y_of = (v) => bottom - ((v - low) / (high - low)) * (bottom - top);
  context.save();
  context.fillStyle = dark ? '#1b2026' : '#ffffff';
  context.fillRect(box.x, box.y, box.width, box.height);
  context.font = '11px system-ui, sans-serif';
  context.lineWidth = 1;
  const raw = (high - low) / 4;
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = decade * [1, 2, 5, 10].find((k) => k * decade >= raw);
  for (let v = Math.ceil(low / step) * step; v <= high; v += step) {
    context.strokeStyle = dark ? '#2b3238' : '#e3e7ea';
    context.beginPath();
    context.moveTo(left, Math.round(y_of(v)) + 0.5);
    context.lineTo(right, Math.round(y_of(v)) + 0.5);
    context.stroke();
    context.fillStyle = dark ? '#aab4bf' : '#4d5761';
    context.textAlign = 'right';
    context.fillText(`${+v.toPrecision(3)} N`, left - 4, y_of(v) + 4);
  }
  context.textAlign = 'right';
  context.fillText(`${now.toFixed(2)} s`, right, bottom + 15);
  let x = left;
  context.textAlign = 'left';
  context.beginPath();
  context.rect(left, box.y, width, box.height);
  context.clip();
  lines.forEach((line, k) => {
    context.strokeStyle = curves[k].colour;
    context.fillStyle = curves[k].colour;
    context.setLineDash(curves[k].dash ?? []);
    context.lineWidth = curves[k].width ?? 1.5;
    context.beginPath();
    const gaps = curves[k].rows.gaps_until(now);
    let before = null; // s, of the point before
    for (let i = 0; i < line.length; ++i) {
      if (line[i] === null || times[i] > now + grid.dt) continue;
      const is_apart = before === null || gaps.some(([from, to]) => before <= from + grid.dt && times[i] >= to - grid.dt);
      if (is_apart) context.moveTo(x_of(times[i]), y_of(line[i]));
      else context.lineTo(x_of(times[i]), y_of(line[i]));
      before = times[i];
    }
    context.stroke();
    context.fillRect(x, box.y + 8, 12, 3);
    context.fillStyle = dark ? '#aab4bf' : '#4d5761';
    context.fillText(curves[k].label, x + 16, box.y + 14);
    x += 30 + context.measureText(curves[k].label).width;
  });
  context.restore();
}
