// Reduces the samples of a stream to the pixel columns of a chart, two values a column, so that no peak is lost.

/**
 * Fills `out` with two values for each of `columns` columns of `dt` seconds from `t0`: smallest and largest in the order in which they came.
 *
 * @param {{times: ArrayLike<number>, values: ArrayLike<number>, stride: number, start: number, end: number, find: function(number): number}} rows
 * @param {number} offset the column of the stream
 * @param {number} t0 s, the left side of the first column
 * @param {number} dt s a column
 * @param {number} columns
 * @param {boolean} step whether a value holds until the next
 * @param {number} until s; a value that holds is drawn as far as this
 * @param {(number | null)[]} out null where nothing is known
 */
export function decimate(rows, offset, t0, dt, columns, step, until, out) {
  const { times, values, stride, end } = rows;
  out.length = 2 * columns;
  out.fill(null);
  let i = Math.max(rows.find(t0) + 1, rows.start);
  let held = i > rows.start ? values[(i - 1) * stride + offset] : NaN;
  const first = i;
  for (let c = 0; c < columns; ++c) {
    const right = t0 + (c + 1) * dt;
    let least = Infinity;
    let most = -Infinity;
    let least_at = 0;
    let most_at = 0;
    const begin = i;
    for (; i < end && times[i] < right; ++i) {
      const v = values[i * stride + offset];
      if (v < least) {
        least = v;
        least_at = i;
      }
      if (v > most) {
        most = v;
        most_at = i;
      }
    }
    if (i > begin) {
      const last = values[(i - 1) * stride + offset];
      if (least <= most) {
        if (least_at === most_at) {
          if (step && held === held) out[2 * c] = held;
          out[2 * c + 1] = most;
        } else if (least_at < most_at) {
          out[2 * c] = least;
          out[2 * c + 1] = most;
        } else {
          out[2 * c] = most;
          out[2 * c + 1] = least;
        }
      }
      held = last;
    } else if (step && held === held && right - dt <= until) {
      out[2 * c] = held;
      out[2 * c + 1] = held;
    }
    if (i >= end && !step) break;
  }
  if (step) return;
  // A curve of few samples goes on to both sides of the chart.
  const at = (t, k) => {
    const from = values[(k - 1) * stride + offset];
    const to = values[k * stride + offset];
    const span = times[k] - times[k - 1];
    const v = span > 0 ? from + ((to - from) * (t - times[k - 1])) / span : to;
    return v === v ? v : null;
  };
  if (columns > 0 && out[0] === null && out[1] === null && first > rows.start && first < end) out[0] = at(t0 + 0.25 * dt, first);
  const c = columns - 1;
  if (columns > 1 && out[2 * c] === null && out[2 * c + 1] === null && i < end && i > rows.start) out[2 * c + 1] = at(t0 + (c + 0.75) * dt, i);
}

/**
 * Takes out what lies in gaps: a value does not hold through one.
 * @param {[number, number][]} gaps s, as Rows.gaps_until gives them
 * @param {{t0: number, dt: number, columns: number}} grid
 * @param {(number | null)[]} out as `decimate` fills it
 */
export function leave_out(gaps, { t0, dt, columns }, out) {
  for (const [from, to] of gaps) {
    const first = Math.max(0, Math.floor((from - t0) / dt) + 1);
    const last = Math.min(columns, Math.floor((to - t0) / dt));
    for (let c = first; c < last; ++c) out[2 * c] = out[2 * c + 1] = null;
  }
}

/**
 * The columns of a chart for the times t0 to t1, at multiples of their width so that a sliding chart does not flicker.
 * @returns {{t0: number, dt: number, columns: number}}
 */
export function column_grid(t0, t1, pixels) {
  const dt = (t1 - t0) / Math.max(1, pixels);
  const first = Math.floor(t0 / dt);
  return { t0: first * dt, dt, columns: Math.ceil(t1 / dt) - first + 1 };
}

/** The two times of each column. */
export function column_times(grid, out) {
  out.length = 2 * grid.columns;
  for (let c = 0; c < grid.columns; ++c) {
    out[2 * c] = grid.t0 + (c + 0.25) * grid.dt;
    out[2 * c + 1] = grid.t0 + (c + 0.75) * grid.dt;
  }
}
