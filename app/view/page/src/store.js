// The samples that the page has: of each stream the last minute of a live run, or all of a replay.

const LIVE_SECONDS = 60;

/** Rows with their times, which never fall. */
export class Rows {
  /** @param {number} width columns @param {boolean} bounded keeps the last minute alone */
  constructor(width, bounded) {
    this.width = width;
    this.bounded = bounded;
    this.begin = 0;
    this.end = 0;
    this.taken = 0;
    this.times = new Float64Array(1024);
    this.values = new Float32Array(1024 * width);
  }
  get count() { return this.end - this.begin; }
  /** @param {Float64Array} times s @param {Float32Array} values */
  add(times, values) {
    this.makeRoom(times.length);
    this.times.set(times, this.end);
    this.values.set(values, this.end * this.width);
    this.end += times.length;
    this.taken += times.length;
    if (!this.bounded || this.count === 0) return;
    const oldest = this.times[this.end - 1] - LIVE_SECONDS;
    while (this.begin < this.end && this.times[this.begin] < oldest) ++this.begin;
  }
  makeRoom(more) {
    if (this.end + more <= this.times.length) return;
    const capacity = Math.max(2 * (this.count + more), 1024);
    const times = new Float64Array(capacity);
    const values = new Float32Array(capacity * this.width);
    times.set(this.times.subarray(this.begin, this.end));
    values.set(this.values.subarray(this.begin * this.width, this.end * this.width));
    this.end = this.count;
    this.begin = 0;
    this.times = times;
    this.values = values;
  }
  /** The index of the first row that is later than t, between begin and end. */
  after(t) {
    let low = this.begin;
    let high = this.end;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= t) low = middle + 1; else high = middle;
    }
    return low;
  }
  /** The row that holds at t: the newest that is not later, or the first; null where there is none. */
  at(t) {
    if (this.count === 0) return null;
    const index = Math.max(this.after(t) - 1, this.begin);
    return {time: this.times[index], values: this.values.subarray(index * this.width, (index + 1) * this.width)};
  }
  /** As a section of a frame; null where there is none. */
  section(stream) {
    if (this.count === 0) return null;
    return {kind: 'rows', stream, rows: this.count, times: this.times.subarray(this.begin, this.end),
            values: this.values.subarray(this.begin * this.width, this.end * this.width)};
  }
}

/** Sets of rows, each of which holds until the next. */
export class Sets {
  constructor(width, bounded) {
    this.width = width;
    this.bounded = bounded;
    this.sets = [];
    this.taken = 0;
  }
  add(time, values, rows) {
    this.sets.push({time, values: values.slice(), rows});
    this.taken += 1;
    if (!this.bounded) return;
    let old = 0;
    while (this.sets[old].time < time - LIVE_SECONDS) ++old;
    if (old > 256) this.sets.splice(0, old);
  }
  at(t) {
    let low = 0;
    let high = this.sets.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.sets[middle].time <= t) low = middle + 1; else high = middle;
    }
    return this.sets[Math.max(low - 1, 0)] ?? null;
  }
}

const SET_ROLES = new Set(['contacts', 'patch']);

export class Store {
  /** @param {object} hello */
  constructor(hello) {
    this.streams = hello.streams;
    this.widths = hello.streams.map((s) => s.columns.length);
    const bounded = hello.mode === 'live';
    this.data = hello.streams.map((s) => SET_ROLES.has(s.role) ? new Sets(s.columns.length, bounded) : new Rows(s.columns.length, bounded));
    this.newest = 0;
  }
  /** @param {{end: number, sections: import('./messages.js').Section[]}[]} chunks */
  add(chunks) {
    for (const chunk of chunks) {
      this.newest = Math.max(this.newest, chunk.end);
      for (const section of chunk.sections) {
        const data = this.data[section.stream];
        if (section.kind === 'set') data.add(section.times[0], section.values, section.rows);
        else data.add(section.times, section.values);
      }
    }
  }
  /** Indices of the streams in a role, of the method in use or of none. */
  of(role, method) {
    const found = [];
    this.streams.forEach((s, i) => {
      if (s.role === role && (!s.method || method === undefined || s.method === method)) found.push(i);
    });
    return found;
  }
  /** The data of the first stream in a role, or null. */
  first(role, method) {
    const [index] = this.of(role, method);
    return index === undefined ? null : this.data[index];
  }
}
