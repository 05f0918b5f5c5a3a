// Keeps the samples of all streams: 60 s of history of a live run, all of a recording.
import { SET_ROLES } from './messages.js';

/** How much of a live run is kept, in s. */
export const LIVE_HISTORY = 60;

/** Between samples of a stream is a gap where they are further apart than so many of its periods, and than so long, in s. Physics takes
 * as long as it takes: a result of it is late once it is older than the gate's stale_after usually is. */
const GAP_PERIODS = 5;
const LEAST_GAP = { regular: 0.02, other: 0.1 };
const REGULAR = new Set(['interpolated', 'commanded', 'reference']);

/** The last index below `end` whose time is at most t, or `start` - 1. */
export function find_last(times, start, end, t) {
  let low = start;
  let high = end;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Rows of one stream in contiguous arrays; rows `start` to `end` - 1 are kept. */
export class Rows {
  /** @param {{name: string, role: string, columns: {name: string, unit: string}[]}} told @param {number} history in s */
  constructor(told, history) {
    this.told = told;
    this.history = history;
    this.set = false;
    this.width = told.columns.length;
    /** Index of each column by its name; norms and the rate are made here. */
    this.column = Object.fromEntries(told.columns.map((column, i) => [column.name, i]));
    this.norms = ['force', 'torque'].filter((name) => `${name}.x` in this.column);
    this.stride = this.width;
    for (const name of this.norms) this.column[`${name}.norm`] = this.stride++;
    this.rate = told.role === 'physics' ? this.stride++ : -1;
    if (this.rate >= 0) this.column.rate = this.rate;
    this.start = 0;
    this.end = 0;
    this.unordered = 0; // rows that came with a time before the one before; they are left out
    this.period = 0; // s, usual time between samples
    this.least_gap = REGULAR.has(told.role) ? LEAST_GAP.regular : LEAST_GAP.other;
    this.gaps = []; // [from, to] in s, of missing samples
    this.times = new Float64Array(1024);
    this.values = new Float32Array(1024 * this.stride);
  }

  /** @param {Float64Array} times in s @param {Float32Array} values rows of the stream's columns */
  append(times, values) {
    for (let i = 0; i < times.length; ++i) {
      const t = times[i];
      if (this.end > this.start && !(t >= this.times[this.end - 1])) {
        // A forecast for an earlier time than the one before: the estimated period of physics has become shorter.
        if (this.told.role !== 'predicted') ++this.unordered;
        continue;
      }
      if (this.end === this.times.length) this.make_room();
      const to = this.end * this.stride;
      for (let c = 0; c < this.width; ++c) this.values[to + c] = values[i * this.width + c];
      for (const name of this.norms) {
        const from = to + this.column[`${name}.x`];
        this.values[to + this.column[`${name}.norm`]] = Math.hypot(this.values[from], this.values[from + 1], this.values[from + 2]);
      }
      if (this.rate >= 0) {
        const gap = this.end > this.start ? t - this.times[this.end - 1] : 0;
        this.values[to + this.rate] = gap > 0 ? 1 / gap : NaN;
      }
      if (this.end > this.start) this.look_for_gap(this.times[this.end - 1], t);
      this.times[this.end++] = t;
    }
    if (this.end === this.start) return;
    const oldest = this.times[this.end - 1] - this.history;
    while (this.times[this.start] < oldest) ++this.start;
    while (this.gaps.length && this.gaps[0][1] < oldest) this.gaps.shift();
  }

  /** From when on a sample after one is late, in s. */
  get longest_gap() {
    return Math.max(GAP_PERIODS * this.period, this.least_gap);
  }

  look_for_gap(from, to) {
    const passed = to - from;
    const longest = this.longest_gap;
    if (this.period > 0 && passed > longest) this.gaps.push([from, to]);
    // A stream that has become slower is followed, a single gap hardly counts.
    this.period = this.period > 0 ? this.period + (Math.min(passed, 2 * longest) - this.period) / 16 : passed;
  }

  /** The gaps at `now`, in s: also the one that goes on. @param {number} now s @returns {[number, number][]} */
  gaps_until(now) {
    if (!this.size || !(this.period > 0) || now - this.last_time <= this.longest_gap) return this.gaps;
    return [...this.gaps, [this.last_time, Infinity]];
  }

  make_room() {
    if (this.start > this.times.length / 2) {
      this.times.copyWithin(0, this.start, this.end);
      this.values.copyWithin(0, this.start * this.stride, this.end * this.stride);
      this.end -= this.start;
      this.start = 0;
      return;
    }
    const times = new Float64Array(2 * this.times.length);
    const values = new Float32Array(2 * this.values.length);
    times.set(this.times);
    values.set(this.values);
    this.times = times;
    this.values = values;
  }

  /** The row valid at t, or -1. */
  find(t) {
    return find_last(this.times, this.start, this.end, t);
  }

  /** The stream's own columns of row i. */
  row(i) {
    return this.values.subarray(i * this.stride, i * this.stride + this.width);
  }

  get size() {
    return this.end - this.start;
  }
  get first_time() {
    return this.size ? this.times[this.start] : undefined;
  }
  get last_time() {
    return this.size ? this.times[this.end - 1] : undefined;
  }
}

/** Sets of one stream, each valid until the next. */
export class Sets {
  constructor(told, history) {
    this.told = told;
    this.history = history;
    this.set = true;
    this.width = told.columns.length;
    this.column = Object.fromEntries(told.columns.map((column, i) => [column.name, i]));
    this.start = 0;
    this.unordered = 0;
    this.times = [];
    this.values = [];
  }

  append(times, values) {
    if (this.size && !(times[0] >= this.last_time)) {
      ++this.unordered;
      return;
    }
    this.times.push(times[0]);
    this.values.push(values.slice());
    const oldest = times[0] - this.history;
    while (this.times[this.start] < oldest) this.values[this.start++] = null;
    if (this.start > 2048 && this.start > this.times.length / 2) {
      this.times.splice(0, this.start);
      this.values.splice(0, this.start);
      this.start = 0;
    }
  }

  find(t) {
    return find_last(this.times, this.start, this.times.length, t);
  }
  row(i) {
    return this.values[i];
  }
  get end() {
    return this.times.length;
  }
  get size() {
    return this.times.length - this.start;
  }
  get first_time() {
    return this.times[this.start];
  }
  get last_time() {
    return this.times[this.times.length - 1];
  }
}

/** The samples of all streams of one run. */
export class Store {
  /** @param {{streams: object[], mode: string}} hello */
  constructor(hello) {
    const history = hello.mode === 'replay' ? Infinity : LIVE_HISTORY;
    this.streams = hello.streams.map((told) => (SET_ROLES.has(told.role) ? new Sets(told, history) : new Rows(told, history)));
    this.by_name = new Map(this.streams.map((stream) => [stream.told.name, stream]));
    this.wakeup = new Rows({ name: 'wakeup', role: 'wakeup', columns: ['p50', 'p99', 'max'].map((name) => ({ name, unit: 's' })) }, history);
    this.begin = undefined; // s, of the first sample ever
    this.now = undefined; // s, the end of the last chunk
    this.taken = Object.fromEntries(hello.streams.map((told) => [told.name, 0]));
  }

  /** @param {import('./messages.js').Samples} message */
  take(message) {
    for (const chunk of message.chunks) {
      for (const section of chunk.sections) {
        const stream = this.streams[section.stream];
        stream.append(section.times, section.values);
        this.taken[stream.told.name] += section.set ? 1 : section.n;
        if (this.begin === undefined && section.times.length) this.begin = section.times[0];
      }
      if (this.now === undefined || chunk.end > this.now) this.now = chunk.end;
    }
  }

  /** The first stream of a role, or undefined. */
  role(role) {
    return this.streams.find((stream) => stream.told.role === role);
  }

  /** The oldest time that is kept, in s. */
  get oldest() {
    let oldest = Infinity;
    for (const stream of this.streams) if (!stream.set && stream.size) oldest = Math.min(oldest, stream.first_time);
    return Number.isFinite(oldest) ? oldest : (this.now ?? 0);
  }

  get unordered() {
    return this.streams.reduce((sum, stream) => sum + stream.unordered, 0);
  }
}
