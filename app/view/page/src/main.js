// Puts the page together: takes messages, draws, and lets every part know what has changed.
import 'uplot/dist/uPlot.min.css';
import './view.css';
import { Chart, Timeline, colour_of, draw_strip } from './charts.js';
import { Connection } from './connection.js';
import { Cursor } from './cursor.js';
import { Diagram } from './diagram.js';
import { Experiment } from './experiment.js';
import { by_id, make, set_text, show, span } from './dom.js';
import { Feel } from './feel.js';
import { Guide } from './guide.js';
import { Knobs } from './knobs.js';
import { decode_binary } from './messages.js';
import { Methods } from './methods.js';
import { Replay } from './replay.js';
import { download, read_recording, saved_frame, saved_page } from './save.js';
import { SceneView } from './scene.js';
import { LIVE_HISTORY, Store } from './store.js';

const STAGES = ['reference', 'physics', 'predicted', 'interpolated', 'commanded']; // later ones are drawn over earlier ones
const CHART_GAP = 33; // ms between redraws of the large chart
const SMALL_CHART_GAP = 150; // ms
const CAUSES = {
  none: '', not_finite: 'the force was not a number', overspeed: 'the device moved too fast', read_failed: 'the device could not be read',
  write_failed: 'the device took no force', time_reversed: 'time went back', dead_man: 'not held', stale: 'no fresh force',
  not_permitted: 'the run starts or stops', no_segment: 'no force yet', device_not_ready: 'the device is not ready', time_gap: 'a gap in time',
};

const params = new URLSearchParams(location.hash.slice(1));
const picture = params.get('picture');
const recording = by_id('recording');
const dark_query = window.matchMedia('(prefers-color-scheme: dark)');

const app = {
  hello: null, status: null, store: null, scene: null, cursor: null, knobs: null, methods: null, diagram: null, guide: null, replay: null,
  connection: null, feel: new Feel(), timeline: new Timeline(), charts: [], force_chart: null, meshes: [], told: [], marks: [],
  values: {}, base_values: {}, followed: -1, message: null, ended: false, complete: false, quantity: 'force', axis: 'norm',
  experiment: null, counters: { frames_drawn: 0, samples_taken: {}, acks: 0, last_frame: 0, inputs: 0, chart_ms: 0 },
  fps: 0, lag: 0, drawn_times: [], offset: Infinity, peak: 0, shown_sets: new Map(), error: null,
};

/** A line across the page; `again` offers to connect again. */
function tell(text, { plain = false, again = false } = {}) {
  set_text(by_id('message-text'), text);
  by_id('message').dataset.kind = plain ? 'plain' : 'bad';
  show(by_id('message-reload'), again);
  show(by_id('message'), Boolean(text));
}
by_id('message-reload').addEventListener('click', () => location.reload());
window.addEventListener('error', (event) => {
  app.error = event.message;
  if (!/ResizeObserver/.test(event.message)) tell(`The page has failed: ${event.message}`);
});
window.addEventListener('unhandledrejection', (event) => {
  app.error = String(event.reason?.message ?? event.reason);
  tell(`The page has failed: ${app.error}`);
});

// ---------------------------------------------------------------- messages

function take_text(message) {
  switch (message.type) {
    case 'hello':
      if (app.hello) throw new Error('a second hello');
      app.hello = message;
      begin();
      break;
    case 'status':
      take_status(message);
      break;
    case 'set':
      take_set(message);
      break;
    case 'refused':
      app.knobs?.refused(message.parameter, message.message);
      if (!app.knobs?.knobs.has(message.parameter)) tell(message.message, { plain: true });
      break;
    case 'complete':
      app.complete = true;
      if (app.replay) {
        app.replay.complete = true;
        app.replay.show();
      }
      break;
    case 'ended':
      app.ended = true;
      by_id('stop').disabled = true;
      no_safety('the run has ended');
      tell(`The run has ended: ${message.why}. The charts stay.`, { plain: true });
      break;
    default: // a newer server may say more
  }
}

function take_binary(bytes) {
  if (!app.hello) throw new Error('binary data before hello');
  const message = decode_binary(bytes, app.hello.streams);
  if (message.kind === 'mesh') {
    if (message.index >= (app.hello.meshes ?? 0)) throw new Error(`mesh ${message.index} of ${app.hello.meshes}`);
    app.meshes[message.index] = message;
    if (have_meshes()) make_scene();
    return;
  }
  app.store.take(message);
  app.timeline.begin = app.store.begin ?? 0;
  app.counters.last_frame = message.frame;
  if (!app.connection) return;
  // A replay is loaded as it comes, live frames are acknowledged when they were drawn.
  if (app.hello.mode === 'replay') app.connection.acknowledge(message.frame);
  else app.connection.taken(message.frame);
  if (app.store.now !== undefined) {
    // How far the page is behind the quickest frame of late.
    const offset = performance.now() / 1000 - app.store.now;
    app.offset = Math.min(offset, app.offset + 0.0005);
  }
}

const have_meshes = () => {
  for (let i = 0; i < (app.hello.meshes ?? 0); ++i) if (!app.meshes[i]) return false;
  return true;
};

function take_status(status) {
  app.status = status;
  const { device } = status;
  if (device && device.wakeup_p99 !== undefined && status.now !== undefined)
    app.store.wakeup.append([status.now], [device.wakeup_p50 ?? NaN, device.wakeup_p99, device.wakeup_max ?? NaN]);
  keep_told(status.now ?? app.store.now ?? 0, status);
  app.diagram?.update(status);
  app.methods?.reference(status.reference);
  if (status.reference) show(by_id('methods'), Boolean(app.methods));
  show_status();
}

function take_set(message) {
  app.values[message.parameter] = message.value;
  app.knobs?.told(message.parameter, message.value);
  const time = message.time ?? app.store.now ?? 0;
  if (app.methods?.told(message.parameter, message.value)) app.marks.push({ time, label: app.methods.label(message.value) });
  keep_told(time, { ...message, time });
}

/** Shows in a replay what was told until the play head: values, the method that was felt, rates of the graph. */
function follow(time) {
  let last = -1;
  while (last + 1 < app.told.length && app.told[last + 1].time <= time) ++last;
  if (last === app.followed) return;
  app.followed = last;
  const values = { ...app.base_values };
  let status = null;
  for (let i = 0; i <= last; ++i) {
    const { message } = app.told[i];
    if (message.type === 'set') values[message.parameter] = message.value;
    else status = message;
  }
  app.values = values;
  for (const [name, value] of Object.entries(values)) {
    app.knobs?.told(name, value);
    app.methods?.told(name, value);
  }
  if (status) app.diagram?.update(status);
}

/** Text messages that a saved page shows again. */
function keep_told(time, message) {
  app.told.push({ time, message });
  if (app.hello.mode === 'replay') return;
  let old = 0;
  for (; old < app.told.length && app.told[old].time < time - LIVE_HISTORY; ++old) {
    const gone = app.told[old].message;
    if (gone.type === 'set') app.base_values[gone.parameter] = gone.value;
  }
  if (old) app.told.splice(0, old);
  while (app.marks.length && app.marks[0].time < time - LIVE_HISTORY) app.marks.shift();
}

// ---------------------------------------------------------------- the parts

const in_control = () => !app.ended && app.connection?.open && app.hello.mode === 'live' && (!app.status || app.status.in_control === undefined || app.status.in_control === app.hello.client);
const set_parameter = (parameter, value) => app.connection?.send({ type: 'set', parameter, value: String(value) });

let page_text = null;
/** The page to save into; fetched early, for a server whose run has ended is soon gone. */
const fetch_page = () => (page_text ??= saved_frame().catch((error) => {
  page_text = null;
  throw error;
}));

function begin() {
  const { hello } = app;
  if (!Array.isArray(hello.streams) || !hello.scene || !Array.isArray(hello.scene.bodies)) throw new Error('hello names no streams or no scene');
  hello.parameters ??= [];
  app.store = new Store(hello);
  app.counters.samples_taken = app.store.taken;
  for (const parameter of hello.parameters) app.values[parameter.name] = parameter.value;
  app.base_values = { ...app.values };
  document.body.classList.remove('waiting');
  document.body.classList.add(hello.mode);
  if (recording) document.body.classList.add('saved');
  document.title = `${hello.graph} – Tactor`;
  set_text(by_id('title'), [hello.graph, hello.title].filter(Boolean).join(': '));
  by_id('title').title = `${hello.title ?? ''}\nTactor ${hello.version ?? ''}`;
  const live = hello.mode === 'live';
  show(by_id('stop'), live);
  by_id('force-bar').setAttribute('aria-valuemax', force_max());
  if (hello.experiment && live) {
    // Blind: neither curves nor knobs, which would tell what is felt.
    document.body.classList.add('experiment');
    show(by_id('experiment'), true);
    app.experiment = new Experiment(by_id('experiment'), hello, set_parameter);
  }
  if (hello.methods) {
    show(by_id('methods'), live); // a replay shows them as soon as it knows of figures
    app.methods = new Methods(by_id('methods'), hello, set_parameter);
  }
  if (hello.parameters.length && !app.experiment) {
    show(by_id('knobs'), true);
    app.knobs = new Knobs(by_id('knobs'), hello.parameters, set_parameter);
  }
  if (hello.nodes?.length) {
    show(by_id('graph'), true);
    app.diagram = new Diagram(by_id('diagram'), hello);
  }
  if (!live) {
    app.replay = new Replay(() => [app.store.begin ?? 0, Math.max(app.store.now ?? 0, app.store.begin ?? 0)], () => moved());
    app.replay.complete = app.complete;
    app.timeline.ahead = 0.25;
    if (hello.duration > 0) app.timeline.whole = hello.duration;
    app.knobs?.enable(false);
    app.methods?.enable(false);
  }
  make_charts();
  app.guide = new Guide(hello);
  if (app.experiment) show(by_id('guide'), false);
  if (!recording) setTimeout(() => fetch_page().catch(() => {}), 3000);
  if (have_meshes()) make_scene();
}

const force_max = () => app.hello.device?.force_max || 5;

function make_scene() {
  // A recorded force alone has nothing that could be drawn.
  if (!app.hello.scene.bodies.length && !app.hello.device?.mouse) {
    show(by_id('scene'), false);
    show(by_id('scene-bar'), false);
    app.scene_failed = true;
    return;
  }
  try {
    app.scene = new SceneView(by_id('scene'), app.hello, app.meshes);
  } catch (error) {
    by_id('scene').append(make('p', { class: 'absent', text: `No picture of the scene: ${error.message}. The charts work without it.` }));
    app.scene_failed = true;
    console.error(error);
    return;
  }
  app.scene.set_dark(dark_query.matches);
  const handle = app.store.role('handle');
  app.cursor = new Cursor({ scene: app.scene, hello: app.hello, send: (message) => app.connection?.send(message),
    handle: () => (handle?.size ? handle.row(handle.end - 1) : null), allowed: () => Boolean(in_control()) });
  const layers = [['bodies', 'bodies', true], ['ground', 'grid', true]];
  if (handle) layers.push(['handle', 'handle', true]);
  if (app.store.role('contacts')) layers.push(['contacts', 'contacts', true]);
  if (app.store.role('patch')) layers.push(['patch', 'local model', true]);
  if (app.store.role('commanded')) layers.push(['commanded', 'force', true]);
  if (app.store.role('physics')) layers.push(['physics', 'physics force', false]);
  for (const [name, label, shown] of layers) {
    const box = make('input', { type: 'checkbox', id: `show-${name}`, checked: shown, on: { change: () => app.scene.show(name, box.checked) } });
    by_id('layers').append(make('label', { class: 'inline' }, [box, ...(/commanded|contacts|physics|patch/.test(name) ? [make('span', { class: `swatch ${name}` })] : []), label]));
    app.scene.show(name, shown);
  }
  const base = app.scene.force_scale;
  by_id('arrow-scale').addEventListener('input', (event) => {
    app.scene.force_scale = base * 10 ** (event.target.value / 100);
    moved();
  });
  by_id('fit').addEventListener('click', () => app.scene.look());
  set_text(by_id('scene-hint'), app.hello.mode === 'live' && app.hello.device?.mouse
    ? `drag the tool${app.hello.rotates ? ', with R to turn' : ''}; keys: space and arrows` : 'drag to look around');
}

function make_charts() {
  const { store } = app;
  const events = { zoom: (from, to) => zoom([from, to]), back: () => zoom(null), marks: () => app.marks,
    pick: (time) => app.replay && !app.timeline.zoom && app.replay.seek(time) };
  const present = STAGES.map((role) => store.role(role)).filter(Boolean);
  const curves = present.map((rows) => ({ rows, column: 'force.norm', label: rows.told.role, role: rows.told.role, colour: '', step: rows.told.role === 'physics',
    width: { reference: 3, commanded: 1.8 }[rows.told.role] ?? 1.3 }));
  app.force_chart = new Chart(document.querySelector('#force-chart .plot'), { unit: 'N', curves, marks: true }, app.timeline, events);
  app.charts.push(app.force_chart);
  if (present.some((rows) => 'torque.norm' in rows.column)) show(by_id('quantity'), true);
  const small = (title, unit, list, options = {}, doc = '') => {
    if (!list.length) return;
    const plot = make('div', { class: 'plot' });
    by_id('charts').append(make('div', { class: 'chart' }, [make('div', { class: 'chart-head' }, [make('h2', { text: title, title: doc })]), plot]));
    app.charts.push(new Chart(plot, { unit, curves: list, ...options }, app.timeline, events));
  };
  const delay = store.role('delay');
  if (delay) small('Delay (ms)', 'ms', [{ rows: delay, column: 'delay', label: 'delay', role: 'delay', scale: 1e3, step: true }], { from_zero: true },
    'how old the device sample behind a physics result was when the result arrived');
  const physics = store.role('physics');
  if (physics) small('Physics rate (Hz)', 'Hz', [{ rows: physics, column: 'rate', label: 'rate', role: 'rate', step: true }], { from_zero: true });
  const contacts = store.role('contact_count');
  if (contacts) small('Contacts', '', [{ rows: contacts, column: 'contacts', label: 'contacts', role: 'contacts', step: true }], { from_zero: true });
  if (app.hello.mode === 'live' || recording) {
    small('Wake-up latency of the device since the start (µs)', 'µs', ['p50', 'p99', 'max'].map((column) => ({ rows: store.wakeup, column, label: column, role: column, scale: 1e6, step: true })), { from_zero: true });
  }
  dress_charts();
}

function dress_charts() {
  const dark = dark_query.matches;
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

function zoom(range) {
  app.timeline.zoom = range && range[1] - range[0] > 1e-4 ? range : null;
  if (!range) app.timeline.held = null;
  show(by_id('zoom-back'), Boolean(app.timeline.zoom));
  show_hold();
  moved();
}

/** Everything is to be drawn again. */
function moved() {
  app.shown_sets.clear();
  app.shown_time = undefined;
  for (const chart of app.charts) chart.last_draw = 0;
}

function show_hold() {
  by_id('pause').setAttribute('aria-pressed', String(app.timeline.held !== null));
}

// ---------------------------------------------------------------- drawing

/** The time that is shown: of the play head, or the newest. */
const shown_time = () => (app.replay ? app.replay.time : app.store.now);

function draw_scene(time) {
  const { scene, store } = app;
  let commanded = null;
  for (const stream of store.streams) {
    const { role } = stream.told;
    const i = app.replay ? stream.find(time) : stream.end - 1;
    if (stream.set) {
      const row = i >= stream.start ? stream.row(i) : null;
      if (app.shown_sets.get(stream) === row) continue;
      app.shown_sets.set(stream, row);
      if (role === 'contacts') scene?.set_contacts(row, stream.width);
      else if (role === 'surface') scene?.set_surfaces(row);
      else scene?.set_patch(row, stream.width);
      continue;
    }
    const known = i >= stream.start && stream.size > 0;
    if (!known && !app.replay) continue;
    const row = known ? stream.row(i) : null;
    if (role === 'body' && row) scene?.set_body(stream.told.body, row);
    else if (role === 'handle' && row) scene?.set_handle(row);
    else if (role === 'commanded') commanded = row;
  }
  if (scene) {
    scene.set_force('commanded', commanded);
    const physics = store.role('physics');
    if (physics) {
      const i = app.replay ? physics.find(time) : physics.end - 1;
      scene.set_force('physics', i >= physics.start && physics.size ? physics.row(i) : null);
    }
  }
  return commanded ? Math.hypot(commanded[0], commanded[1], commanded[2]) : 0;
}

function show_force(force, now) {
  const part = Math.min(1, force / force_max());
  app.peak = force >= app.peak ? force : Math.max(force, app.peak - force_max() * 0.004);
  by_id('force-fill').style.transform = `scaleX(${part.toFixed(4)})`;
  by_id('force-peak').style.left = `${(100 * Math.min(0.995, app.peak / force_max())).toFixed(2)}%`;
  if (now - (app.force_told ?? 0) < 60) return;
  app.force_told = now;
  set_text(by_id('force-value'), `${force.toFixed(2)} of ${force_max()} N`);
  by_id('force-bar').setAttribute('aria-valuenow', force.toFixed(2));
}

function no_safety(why) {
  by_id('safety').dataset.state = 'unknown';
  set_text(by_id('safety'), why);
}

function show_safety(time) {
  if (app.hello.mode === 'live' && (app.ended || !app.connection?.open)) return;
  const safety = app.store.role('safety');
  const badge = by_id('safety');
  if (!safety) {
    show(badge, false);
    return;
  }
  const i = app.replay ? safety.find(time) : safety.end - 1;
  if (i < safety.start || !safety.size) return;
  const row = safety.row(i);
  const state = app.hello.engagements?.[row[safety.column.engagement]] ?? 'unknown';
  const cause = app.hello.causes?.[row[safety.column.cause]] ?? '';
  const words = CAUSES[cause] ?? cause.replaceAll('_', ' ');
  const gain = row[safety.column.gain];
  badge.dataset.state = state;
  set_text(badge, `${state}${state === 'ramping' && gain !== undefined ? ` ${Math.round(100 * gain)} %` : ''}${words ? `: ${words}` : ''}`);
}

function show_status() {
  const { status, hello, store } = app;
  const time = shown_time();
  set_text(by_id('status-time'), time === undefined ? '' : `${time.toFixed(2)} s`);
  if (!status || app.replay) {
    set_text(by_id('status-phase'), app.replay ? (recording ? 'saved recording' : 'replay') : 'waiting');
  } else {
    const open = Boolean(app.connection?.open) && !app.ended;
    set_text(by_id('status-phase'), app.ended ? 'ended' : open ? (status.phase ?? '') : 'not connected');
    set_text(by_id('status-speed'), status.speed === undefined ? '' : `speed ${status.speed.toFixed(2)}`);
    const { in_control: who } = status;
    set_text(by_id('status-control'), !open ? '' : who === hello.client ? 'you are in control' : who ? `client ${who} is in control, you look` : 'nobody is in control');
    show(by_id('take-control'), !who && open);
    set_text(by_id('status-clients'), `${status.clients ?? 1} ${status.clients > 1 ? 'clients' : 'client'}`);
    const { device } = status;
    set_text(by_id('status-device'), device ? `device: ${device.missed ?? 0} of ${device.ticks ?? 0} ticks missed, wake-up p99 ${span(device.wakeup_p99)}` : '');
    app.knobs?.enable(Boolean(in_control()));
    app.methods?.enable(Boolean(in_control()));
  }
  const dropped = (status && !app.replay ? status.dropped : 0) ?? 0;
  const unordered = store?.unordered ?? 0;
  set_text(by_id('status-dropped'), [dropped ? `${dropped} frames dropped` : '', unordered ? `${unordered} samples out of order` : ''].filter(Boolean).join(', '));
  set_text(by_id('status-frames'), `${app.fps.toFixed(0)} frames/s`);
}

function draw_charts(now_ms, time) {
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

/** Fewer pixels where frames come slowly, more again where they come fast. */
function adapt(now) {
  if (!app.scene || picture || now - (app.adapted ?? 0) < 2000) return;
  const first = app.adapted === undefined;
  app.adapted = now;
  if (first || document.hidden) return;
  const most = Math.min(window.devicePixelRatio || 1, 2);
  const ratio = app.scene.pixel_ratio;
  const least = 0.7 * Math.min(1, most);
  if (app.fps < 24 && ratio > least) {
    app.scene.set_pixel_ratio(Math.max(least, ratio * 0.85));
    app.lowered = now;
    app.patience = Math.min(120000, 2 * (app.patience ?? 5000));
  } else if (app.fps > 40 && ratio < most && now - app.lowered > app.patience) {
    app.scene.set_pixel_ratio(Math.min(most, ratio / 0.85));
  }
}

function frame(now) {
  requestAnimationFrame(frame);
  if (!app.hello || (!app.scene && !app.scene_failed)) return;
  const time = app.replay ? app.replay.step(now) : app.store.now;
  if (time !== undefined) {
    const force = draw_scene(time);
    show_force(force, now);
    app.feel.force(app.replay && !app.replay.playing ? 0 : force / force_max());
    show_safety(time);
    if (app.replay) follow(time);
    app.cursor?.step(now, force / force_max());
    const counts = app.store.role('contact_count');
    app.guide.look({ held: Boolean(app.cursor?.held), contacts: counts?.size ? counts.row(counts.end - 1)[0] : undefined, force, felt: app.methods?.felt ?? new Set() });
  } else {
    app.cursor?.step(now, 0);
  }
  app.experiment?.look(app.store.role('experiment'), Boolean(in_control()));
  const spring = app.cursor?.spring();
  app.scene?.set_spring(spring?.[0], spring?.[1]);
  app.scene?.render();
  if (time !== undefined) draw_charts(performance.now(), time);
  if (app.connection) {
    app.connection.drawn();
    app.counters.acks = app.connection.acks;
  }
  ++app.counters.frames_drawn;
  app.counters.inputs = app.cursor?.sent ?? 0;
  app.drawn_times.push(now);
  while (app.drawn_times[0] < now - 1000) app.drawn_times.shift();
  const passed = now - app.drawn_times[0];
  app.fps = passed > 0 ? ((app.drawn_times.length - 1) * 1000) / passed : 0;
  if (app.store.now !== undefined && Number.isFinite(app.offset) && !app.replay) app.lag = Math.max(0, performance.now() / 1000 - app.store.now - app.offset);
  adapt(now);
  if (now - (app.status_shown ?? 0) > 250) {
    app.status_shown = now;
    show_status();
  }
}

// ---------------------------------------------------------------- controls

const stop = () => {
  app.connection?.send({ type: 'stop' });
  if (app.connection?.open && !app.ended) tell('The run is asked to stop; the device ramps down.', { plain: true });
};
by_id('stop').addEventListener('click', stop);
by_id('take-control').addEventListener('click', () => app.connection?.send({ type: 'control' }));
window.addEventListener('keydown', (event) => {
  if (event.key === 'Escape' && app.hello?.mode === 'live') stop();
  if (/^[12]$/.test(event.key) && !event.repeat) app.experiment?.answer(event.key === '1' ? 'first' : 'second');
  if (/^[1-9]$/.test(event.key) && app.methods && app.hello.mode === 'live' && !(event.target instanceof Element && event.target.closest('input, select'))) {
    const choice = app.hello.methods.choices[Number(event.key) - 1];
    if (choice && in_control()) set_parameter(app.hello.methods.parameter, choice.value);
  }
});
by_id('sound').addEventListener('change', (event) => {
  if (!app.feel.switch(event.target.checked)) event.target.checked = false;
});
by_id('window').addEventListener('change', (event) => {
  app.timeline.window = Number(event.target.value);
  zoom(null);
});
by_id('pause').addEventListener('click', () => {
  app.timeline.held = app.timeline.held === null ? (shown_time() ?? null) : null;
  show_hold();
  moved();
});
by_id('zoom-back').addEventListener('click', () => zoom(null));
const choose = () => {
  app.force_chart?.choose(`${app.quantity}.${app.axis}`);
  if (!app.force_chart) return;
  app.force_chart.spec.unit = app.quantity === 'torque' ? 'N m' : 'N';
  set_text(document.querySelector('#force-chart h2'), app.quantity === 'torque' ? 'Torque by stage (N m)' : 'Force by stage (N)');
};
by_id('quantity').addEventListener('change', (event) => {
  app.quantity = event.target.value;
  choose();
});
by_id('axis').addEventListener('click', (event) => {
  const { axis } = event.target.dataset;
  if (!axis) return;
  app.axis = axis;
  for (const button of by_id('axis').children) button.setAttribute('aria-pressed', String(button.dataset.axis === axis));
  choose();
});
by_id('save').addEventListener('click', async () => {
  if (!app.store || app.store.now === undefined || !have_meshes()) return;
  const button = by_id('save');
  button.disabled = true;
  set_text(button, 'Saving …');
  try {
    const { hello, meshes, store, told } = app;
    const from = hello.mode === 'replay' ? store.oldest : Math.max(store.oldest, store.now - LIVE_HISTORY);
    const parameters = hello.parameters.map((one) => ({ ...one, value: app.base_values[one.name] }));
    const blob = await saved_page(await fetch_page(), { hello: { ...hello, parameters, duration: store.now - from }, meshes, store, told }, { from, to: store.now });
    download(blob, `${hello.graph}.html`.replaceAll(/[^\w.-]/g, '_'));
    app.saved_bytes = blob.size;
  } catch (error) {
    tell(`Not saved: ${error.message}`);
  }
  button.disabled = false;
  set_text(button, 'Save as HTML');
});

// ---------------------------------------------------------------- for tests and pictures

/**
 * Pictures of the scene with the force below, for animations.
 * @param {number[]} times s
 * @param {number} [width] px
 * @param {number} [height] px
 * @param {string} [type] image/webp, image/jpeg or image/png
 * @returns {string[]} data URLs
 */
function frames(times, width = 640, height = 480, type = 'image/webp') {
  const canvas = make('canvas');
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext('2d');
  const strip = Math.round(Math.max(70, 0.26 * height));
  const dark = dark_query.matches;
  const replay = app.replay ?? null;
  const was = replay?.time;
  if (!replay) app.replay = { time: 0 }; // a live page looks back in the same way
  const list = times.map((time) => {
    app.shown_sets.clear();
    app.replay.time = time;
    draw_scene(time);
    app.scene?.picture(width, height - strip, (drawn) => context.drawImage(drawn, 0, 0, width, height - strip));
    draw_strip(context, { x: 0, y: height - strip, width, height: strip }, app.force_chart.curves.filter((curve) => !app.force_chart.hidden.has(curve.label)),
      [time - 2, time + 0.5], time, dark);
    return canvas.toDataURL(type, 0.6);
  });
  if (replay) replay.time = was;
  else app.replay = null;
  moved();
  return list;
}

window.tactor = {
  get connected() { return Boolean(app.connection?.open); },
  get mode() { return app.hello?.mode; },
  get hello() { return app.hello; },
  get status() { return app.status; },
  get counters() { return structuredClone({ ...app.counters, fps: app.fps, pixel_ratio: app.scene?.pixel_ratio }); },
  get parameters() { return { ...app.values }; },
  /** How many samples of each stream came too late to be shown, where any did. */
  get unordered() { return Object.fromEntries((app.store?.streams ?? []).filter((s) => s.unordered).map((s) => [s.told.name, s.unordered])); },
  get lag_s() { return app.lag; },
  get error() { return app.error; },
  get held() { return Boolean(app.cursor?.held); },
  get target() { return app.cursor ? app.cursor.p.toArray() : null; },
  get time() { return app.store ? shown_time() : undefined; },
  get complete() { return app.complete; },
  /** The newest sample of a stream, or null. */
  latest(name) {
    const stream = app.store?.by_name.get(name);
    return stream?.size ? { time: stream.last_time, values: Array.from(stream.row(stream.end - 1)) } : null;
  },
  /** A point of the world in client pixels. */
  project: (x, y, z) => app.scene?.project(x, y, z),
  seek: (time) => app.replay?.seek(time),
  frames,
};

// ---------------------------------------------------------------- start

async function open_recording() {
  let messages;
  try {
    messages = await read_recording(recording.textContent);
  } catch (error) {
    tell(`The recording in this file cannot be read; the file may be cut off. (${error.message})`);
    return;
  }
  for (const message of messages) {
    if (typeof message === 'string') take_text(JSON.parse(message));
    else take_binary(message);
  }
  take_text({ type: 'complete' });
  if (!have_meshes()) throw new Error('a mesh is missing');
  if (picture) draw_picture();
}

/** The time of the largest commanded force, s. */
function time_of_most_force() {
  const stream = app.store.role('commanded');
  let most = -1;
  let time = 0;
  for (let i = stream?.begin ?? 0; i < (stream?.end ?? 0); ++i) {
    const [x, y, z] = stream.row(i);
    const force = Math.hypot(x, y, z);
    if (force > most) [most, time] = [force, stream.times[i]];
  }
  return time;
}

/** `t=force` is the moment of the largest force. `#picture=scene&t=3.2` or `#picture=all&t=3.2`: one moment, and a title that says when it was drawn. */
function draw_picture() {
  app.replay.pause();
  app.replay.loop = false;
  const t = params.get('t') ?? '0';
  app.replay.seek(t === 'force' ? time_of_most_force() : Number(t));
  show(by_id('guide'), false);
  if (picture === 'scene') {
    document.body.classList.add('picture');
    for (const chart of app.charts) chart.visible = false;
  }
  let frames_left = 4; // sizes settle, charts are made
  const wait = () => {
    if (frames_left-- > 0) return requestAnimationFrame(wait);
    document.title += ' (drawn)';
  };
  requestAnimationFrame(wait);
}

if (recording) {
  open_recording();
} else if (location.protocol === 'file:') {
  tell('This file holds no recording.');
} else {
  const token = location.hash.slice(1);
  app.connection = new Connection(token, {
    text: take_text,
    binary: take_binary,
    closed: (why) => {
      if (!app.ended || /could not/.test(why)) tell(app.hello?.mode === 'replay' && app.complete ? 'The server is gone; the recording stays.' : why, { again: true });
      if (app.hello?.mode === 'live' && !app.ended) no_safety('no connection');
      by_id('stop').disabled = true;
      app.knobs?.enable(false);
      app.methods?.enable(false);
    },
  });
}
// A page that is left, but kept by the browser for the way back, must not stay in control.
window.addEventListener('pagehide', () => app.connection?.close());
window.addEventListener('pageshow', (event) => event.persisted && app.connection && location.reload());
choose();
requestAnimationFrame(frame);
