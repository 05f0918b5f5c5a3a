// The charts of the page: which there are, what part of time they show, and when each is drawn again.
import { app, dark_query, recording } from './app.js';
import { Chart } from './charts.js';
import { colour_of, dress_page } from './colours.js';
import { by_id, make, show } from './dom.js';

const STAGES = ['reference', 'physics', 'predicted', 'interpolated', 'commanded']; // later ones are drawn over earlier ones
const CHART_GAP = 33; // ms between redraws of the large chart
const SMALL_CHART_GAP = 150; // ms

export function make_charts() {
  const { store } = app;
  const events = { zoom: (from, to) => zoom([from, to]), back: () => zoom(null), marks: () => app.marks,
    pick: (time) => app.replay && !app.timeline.zoom && app.replay.seek(time) };
  const present = STAGES.map((role) => store.role(role)).filter(Boolean);
  const curves = present.map((rows) => ({ rows, column: 'force.norm', label: rows.told.role, role: rows.told.role, colour: '', step: rows.told.role === 'physics',
    width: { reference: 3, commanded: 1.8 }[rows.told.role] ?? 1.3 }));
  app.force_chart = new Chart(document.querySelector('#force-chart .plot'), { curves, marks: true }, app.timeline, events);
  app.charts.push(app.force_chart);
  if (present.some((rows) => 'torque.norm' in rows.column)) show(by_id('quantity'), true);
  const small = (title, list, options = {}, doc = '') => {
    if (!list.length) return;
    const plot = make('div', { class: 'plot' });
    by_id('charts').append(make('div', { class: 'chart' }, [make('div', { class: 'chart-head' }, [make('h2', { text: title, title: doc })]), plot]));
    app.charts.push(new Chart(plot, { curves: list, ...options }, app.timeline, events));
  };
  const delay = store.role('delay');
  if (delay) small('Delay (ms)', [{ rows: delay, column: 'delay', label: 'delay', role: 'delay', scale: 1e3, step: true }], { from_zero: true },
    'how old the device sample behind a physics result was when the result arrived');
  const physics = store.role('physics');
  if (physics) small('Physics rate (Hz)', [{ rows: physics, column: 'rate', label: 'rate', role: 'rate', step: true }], { from_zero: true });
  const contacts = store.role('contact_count');
  if (contacts) small('Contacts', [{ rows: contacts, column: 'contacts', label: 'contacts', role: 'contacts', step: true }], { from_zero: true });
  if (app.hello.mode === 'live' || recording) {
    small('Wake-up latency of the device since the start (µs)', ['p50', 'p99', 'max'].map((column) => ({ rows: store.wakeup, column, label: column, role: column, scale: 1e6, step: true })), { from_zero: true });
  }
  dress_charts();
}

function dress_charts() {
  const dark = dark_query.matches;
  dress_page(dark);
  for (const chart of app.charts) {
    for (const curve of chart.curves) curve.colour = colour_of(curve.role, dark);
    chart.set_dark(dark);
  }
}
dark_query.addEventListener('change', () => {
  if (!app.hello) return;
  dress_charts();
  app.scene?.set_dark(dark_query.matches);
});

export function zoom(range) {
  app.timeline.zoom = range && range[1] - range[0] > 1e-4 ? range : null;
  if (!range) app.timeline.held = null;
  show(by_id('zoom-back'), Boolean(app.timeline.zoom));
  show_hold();
  moved();
}

/** Everything is to be drawn again. */
export function moved() {
  app.shown_sets.clear();
  app.shown_time = undefined;
  for (const chart of app.charts) chart.last_draw = 0;
}

export function show_hold() {
  by_id('pause').setAttribute('aria-pressed', String(app.timeline.held !== null));
}

export function draw_charts(now_ms, time) {
  const head = app.replay ? time : null;
  const right = app.replay ? app.store.now : time;
  let spent = 0;
  for (const chart of app.charts) {
    const gap = chart === app.force_chart ? CHART_GAP : SMALL_CHART_GAP;
    if (now_ms - chart.last_draw < gap || !chart.visible) continue;
    // What would look the same is not drawn again.
    const state = [time, right, ...app.timeline.range(time)].join();
    if (chart.last_draw && chart.drawn_state === state) continue;
    if (spent && now_ms - chart.last_draw < 4 * gap && chart !== app.force_chart) continue; // one small chart a frame
    chart.drawn_state = state;
    chart.draw_at(time, right, head);
    spent += chart.cost;
  }
  if (spent) app.counters.chart_ms = spent;
}
