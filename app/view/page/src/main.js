// The page of the view: what comes in is kept, drawn at each frame, and acknowledged when it was drawn.
import {Chart, COLORS, Timeline} from './charts.js';
import {Connection} from './connection.js';
import {Cursor} from './cursor.js';
import {Diagram} from './diagram.js';
import {Feel} from './feel.js';
import {Guide} from './guide.js';
import {element, Knobs, short} from './knobs.js';
import {fromText} from './messages.js';
import {Player} from './player.js';
import {save} from './save.js';
import {View3D} from './scene.js';
import {Store} from './store.js';

const at = (id) => document.getElementById(id);
const options = new URLSearchParams(location.hash.slice(1));
const picture = options.get('picture');
const state = {hello: null, meshes: [], store: null, status: null, method: null, figures: new Map(), lost: null, ended: null, complete: false};
const counters = {frames_drawn: 0, acks: 0, last_frame: 0, frames_taken: 0};
const timeline = new Timeline();
const wake = {times: [], p50: [], p99: []};
let scene, cursor, player, knobs, diagram, guide, feel, axis = 'norm';
let charts = [];
let clock = {run: 0, wall: 0};  // where the live run is, by what was seen of it
let switched = -Infinity;
let drawnAt = performance.now();
let rate = 0;

function notice(text) {
  at('notice').textContent = text;
  at('notice').hidden = !text;
}

const connection = new Connection({
  hello: begin,
  mesh(mesh) {
    state.meshes[mesh.index] = mesh;
    if (ready()) build();
  },
  chunks(chunks) {
    state.store.add(chunks);
    counters.frames_taken += 1;
    if (state.hello.mode === 'live') clock = {run: state.store.newest, wall: performance.now()};
  },
  text: takeText,
  lost(why) {
    state.lost = why;
    notice(state.ended ? `${state.ended} The curves stay.` : why);
    document.body.dataset.lost = 'true';
  },
});

const ready = () => state.hello && state.meshes.filter(Boolean).length === state.hello.meshes;

function begin(hello) {
  state.hello = hello;
  state.store = new Store(hello);
  document.body.dataset.mode = hello.mode;
  document.title = `${hello.graph} · tactor`;
  at('title').textContent = hello.title ? `${hello.graph}: ${hello.title}` : hello.graph;
  if (ready()) build();
}

function takeText(message) {
  const takers = {
    status: takeStatus,
    set({parameter, value}) {
      knobs?.set(parameter, value);
      if (parameter === state.hello.methods?.parameter) setMethod(value);
    },
    refused({parameter, message: why}) {
      knobs?.refuse(parameter, why);
      if (!knobs?.knobs.has(parameter)) notice(why);
    },
    ended({why}) {
      state.ended = `The run has ended: ${why}.`;
      notice(state.ended);
    },
    complete() { state.complete = true; },
  };
  takers[message.type]?.(message);
}

function takeStatus(status) {
  state.status = status;
  diagram?.update(status);
  if (status.device) {
    wake.times.push(status.now);
    wake.p50.push(status.device.wakeup_p50 * 1e6);
    wake.p99.push(status.device.wakeup_p99 * 1e6);
  }
  const {reference} = status;
  if (reference?.rms !== undefined && performance.now() - switched > 600) {
    state.figures.set(state.method, {rms: reference.rms, delay: reference.delay});
    showFigures();
  }
  const mine = status.in_control === state.hello.client;
  at('control').hidden = status.in_control !== 0;
  at('how').textContent = !state.hello.device.mouse ? 'The device of the graph leads the tool.'
    : mine ? `Drag the tool. Wheel: depth.${state.hello.rotates ? ' R and drag: turn.' : ''} Space with arrow and page keys moves it without a mouse. Drag beside it: turn the camera.`
      : status.in_control === 0 ? 'Nobody leads the tool.' : 'Another page leads the tool; this one looks.';
}

function setMethod(value) {
  state.method = value;
  switched = performance.now();
  for (const button of at('methods').children) button.setAttribute('aria-pressed', String(button.value === value));
  showFigures();
}

function showFigures() {
  const number = (value, scale, unit) => value === undefined ? '–' : `${short(Number((value * scale).toPrecision(3)))} ${unit}`;
  if (!state.hello.methods) {
    const f = state.figures.get(null);
    at('figure-box').hidden = !f;
    if (f) at('figure').textContent = `error ${number(f.rms, 1, 'N RMS')}, delay ${number(f.delay, 1e3, 'ms')}`;
    return;
  }
  at('figures').tBodies[0].replaceChildren(...state.hello.methods.choices.map(({value, label}) => {
    const f = state.figures.get(value) ?? {};
    const row = element('tr');
    row.dataset.now = String(value === state.method);
    for (const text of [label, number(f.rms, 1, 'N'), number(f.delay, 1e3, 'ms')]) row.append(element('td', {textContent: text}));
    return row;
  }));
}

/** What a wrench shows of itself on the chosen axis. */
function onAxis(values, offset) {
  switch (axis) {
    case 'norm': return Math.hypot(values[offset], values[offset + 1], values[offset + 2]);
    case 'torque': return Math.hypot(values[offset + 3], values[offset + 4], values[offset + 5]);
    default: return values[offset + Number(axis)];
  }
}

function forceCurves() {
  const curve = (role, label, style, extra = {}) => ({label, color: COLORS[role], style, get: onAxis, rows: () => state.store.first(role, state.method ?? undefined), ...extra});
  return [
    curve('physics', 'physics', 'hold'), curve('predicted', 'predicted', 'points'), curve('interpolated', 'interpolated', 'line'),
    curve('commanded', 'commanded', 'line'), curve('reference', 'reference', 'line', {dash: [4, 3]}),
  ].filter((c, i) => state.store.of(['physics', 'predicted', 'interpolated', 'commanded', 'reference'][i]).length > 0);
}

/** Rows made of those of another stream. */
function derived(source, value) {
  let made = null;
  let from = -1;
  return () => {
    const rows = source();
    if (!rows || rows.taken === from) return made;
    from = rows.taken;
    const times = rows.times.subarray(rows.begin, rows.end);
    made = {width: 1, times, begin: 0, end: times.length, count: times.length, values: value(rows, times), after: (t) => Math.max(0, rows.after(t) - rows.begin)};
    return made;
  };
}

function makeCharts() {
  const {store} = state;
  const changed = () => showPause();
  const parent = at('charts');
  const add = (title, unit, curves) => {
    const box = element('div', {className: 'chart'});
    parent.append(box);
    charts.push(new Chart(box, title, unit, curves, timeline, changed));
  };
  charts = [new Chart(at('chart-force'), '', 'N', forceCurves(), timeline, changed, 260)];
  const first = (role) => () => store.first(role);
  if (store.first('delay')) add('Delay of physics results', 'ms', [{label: 'delay', color: COLORS.one, style: 'points', get: (v, o) => 1e3 * v[o], rows: first('delay')}]);
  if (store.first('physics')) {
    const rates = derived(first('physics'), (rows, times) => Float32Array.from(times, (t, i) => i === 0 ? NaN : 1 / Math.max(t - times[i - 1], 1e-4)));
    add('Physics rate', 'Hz', [{label: 'rate', color: COLORS.two, style: 'hold', get: (v, o) => v[o], rows: rates}]);
  }
  if (store.first('contact_count')) add('Contacts', '', [{label: 'contacts', color: COLORS.three, style: 'hold', get: (v, o) => v[o], rows: first('contact_count')}]);
  if (state.hello.mode === 'live') {
    const of = (list) => () => {
      const times = Float64Array.from(wake.times);
      return {width: 1, times, values: Float32Array.from(list), begin: 0, end: times.length, count: times.length,
              after: (t) => { let i = 0; while (i < times.length && times[i] <= t) ++i; return i; }};
    };
    add('Wake-up latency of the device loop', 'us', [
      {label: 'p50', color: COLORS.one, style: 'hold', get: (v, o) => v[o], rows: of(wake.p50)},
      {label: 'p99', color: COLORS.three, style: 'hold', get: (v, o) => v[o], rows: of(wake.p99)}]);
  }
}

function showPause() {
  at('pause').textContent = timeline.held ? 'Go on' : 'Pause';
}

function build() {
  const {hello} = state;
  scene = new View3D(at('canvas'));
  scene.build(hello, state.meshes);
  feel = new Feel();
  for (const [value, label] of [['norm', 'norm'], ['0', 'x'], ['1', 'y'], ['2', 'z'], ...(hello.rotates ? [['torque', 'torque, N m']] : [])]) {
    at('axis').append(element('option', {value, textContent: label}));
  }
  at('axis').addEventListener('change', () => { axis = at('axis').value; });
  at('window').addEventListener('change', () => { timeline.window = Number(at('window').value); });
  at('pause').addEventListener('click', () => { timeline.held ? timeline.go() : timeline.pause(timeNow()); showPause(); });
  at('fit').addEventListener('click', () => scene.fit());
  at('sound').addEventListener('change', () => feel.sound(at('sound').checked));
  at('stop').addEventListener('click', () => connection.say({type: 'stop'}));
  at('control').addEventListener('click', () => connection.say({type: 'control'}));
  at('save').addEventListener('click', () => save(hello, state.meshes, state.store).catch((error) => notice(`This could not be saved: ${error.message}`)));
  at('save').hidden = location.protocol === 'file:';
  addEventListener('keydown', (e) => { if (e.key === 'Escape' && hello.mode === 'live') connection.say({type: 'stop'}); });
  knobs = new Knobs(at('knobs'), hello.parameters, (parameter, value) => connection.say({type: 'set', parameter, value}));
  at('knobs').parentElement.hidden = hello.mode === 'replay';
  diagram = new Diagram(at('diagram'), hello);
  if (hello.methods && hello.mode === 'live') {
    at('methods-box').hidden = false;
    for (const {value, label} of hello.methods.choices) {
      const button = element('button', {value, textContent: label});
      button.addEventListener('click', () => connection.say({type: 'set', parameter: hello.methods.parameter, value}));
      at('methods').append(button);
    }
    setMethod(hello.parameters.find((p) => p.name === hello.methods.parameter)?.value);
  }
  if (hello.mode === 'replay') {
    player = new Player(hello.duration);
    if (options.has('t')) player.time = Number(options.get('t'));
  } else {
    if (hello.device.mouse) cursor = new Cursor(scene, (m) => connection.say(m), hello, () => poseOf('handle', Infinity));
    guide = new Guide(hello);
  }
  makeCharts();
  if (picture) document.body.dataset.picture = picture;
  requestAnimationFrame(frame);
}

/** The time that the page shows, s: of a live run what has come last, moved on evenly. */
function timeNow() {
  if (player) return player.time;
  const passed = (performance.now() - clock.wall) / 1000;
  return clock.run + Math.min(passed, 0.1);
}

function poseOf(role, t, method) {
  const row = state.store.first(role, method)?.at(t);
  return row ? row.values : null;
}

function bodyPoses(t) {
  const poses = state.hello.scene.bodies.map(() => null);
  state.store.streams.forEach((s, i) => {
    if (s.role === 'body') poses[s.body] = state.store.data[i].at(t)?.values ?? null;
  });
  // Before physics has told anything the tool is at the handle.
  state.hello.scene.bodies.forEach((b, i) => { if (b.tool && !poses[i]) poses[i] = state.hello.device.start; });
  return poses;
}

const vector = (row) => row ? [row[0], row[1], row[2]] : null;

function drawScene(t) {
  const now = player ? t : Infinity;
  const shown = (id) => at(`show-${id}`).checked;
  const {store} = state;
  const most = state.hello.device.force_max ?? 8;
  scene.draw({
    bodies: bodyPoses(now),
    handle: poseOf('handle', now),
    force: vector(store.first('commanded')?.at(now)?.values),
    physics: vector(store.first('physics')?.at(now)?.values),
    contacts: store.first('contacts')?.at(now) ?? null,
    patch: store.first('patch')?.at(now) ?? null,
    target: cursor?.held ? cursor.p.toArray() : null,
  }, {
    contacts: shown('contacts'), force: shown('force'), physics: shown('physics'), handle: shown('handle'), patch: shown('patch'),
    metresPerNewton: 0.35 * scene.size / most * 10 ** Number(at('arrow-scale').value),
  });
}

function drawBar(t) {
  const now = player ? t : Infinity;
  const row = state.store.first('commanded')?.at(now)?.values;
  const force = row ? Math.hypot(row[0], row[1], row[2]) : 0;
  const most = state.hello.device.force_max ?? 8;
  at('force-fill').style.width = `${Math.min(100, 100 * force / most)}%`;
  at('force-text').textContent = `${force.toFixed(2)} N`;
  const safety = state.store.first('safety')?.at(now)?.values;
  const badge = at('safety');
  if (safety) {
    const engagement = state.hello.engagements[safety[0]] ?? 'unknown';
    const cause = state.hello.causes[safety[1]] ?? 'unknown';
    badge.dataset.state = engagement;
    badge.textContent = cause === 'none' ? engagement : `${engagement}: ${cause.replaceAll('_', ' ')}`;
  }
  feel.set(Math.min(1, force / most));
  return force;
}

function drawStatus(t) {
  const {status, hello} = state;
  if (hello.mode === 'replay') {
    at('status-text').textContent = `tactor ${hello.version} · ${rate.toFixed(0)} frames/s`;
    return;
  }
  at('phase').textContent = status ? status.phase : 'starting';
  const parts = [`tactor ${hello.version}`, `${t.toFixed(1)} s`, `${rate.toFixed(0)} frames/s`];
  if (status) {
    if (status.speed) parts.push(`real time × ${status.speed.toFixed(2)}`);
    parts.push(`${status.clients} page${status.clients === 1 ? '' : 's'}`);
    parts.push(status.in_control === hello.client ? 'this page leads' : status.in_control ? 'another page leads' : 'nobody leads');
    if (status.device) parts.push(`${status.device.missed} missed ticks`);
    if (status.dropped) parts.push(`${status.dropped} frames dropped for this page`);
  }
  at('status-text').textContent = parts.join(' · ');
}

function frame() {
  requestAnimationFrame(frame);
  const wall = performance.now();
  const seconds = (wall - drawnAt) / 1000;
  drawnAt = wall;
  rate += 0.05 * (1 / Math.max(seconds, 1e-3) - rate);
  if (player) player.frame();
  if (!state.lost) cursor?.frame();
  const t = timeNow();
  drawScene(t);
  const force = drawBar(t);
  if (picture !== 'scene') for (const chart of charts) chart.draw(t);
  drawStatus(t);
  guide?.frame({held: Boolean(cursor?.held), force, method: state.method}, seconds);
  counters.frames_drawn += 1;
  connection.acknowledge();
  counters.acks = connection.acks;
  counters.last_frame = connection.drawn;
  if (picture && counters.frames_drawn === 3) document.title += ' (drawn)';
}

/** The scene with a strip of the force below it at each of these times, as data URLs: for animations. */
function frames(times, width, height) {
  const strip = Math.round(height * 0.3);
  const canvas = element('canvas', {width, height});
  const context = canvas.getContext('2d');
  const style = getComputedStyle(document.documentElement);
  const color = (name) => style.getPropertyValue(name).trim();
  const commanded = state.store.first('commanded');
  const top = 1.1 * Math.max(...commanded.times.subarray(commanded.begin, commanded.end).map((_, i) => onAxis(commanded.values, (commanded.begin + i) * commanded.width)), 0.1);
  at('canvas').style.width = `${width}px`;
  at('canvas').style.height = `${height - strip}px`;
  at('canvas').style.aspectRatio = 'auto';
  return times.map((t) => {
    drawScene(t);
    context.fillStyle = color('--paper');
    context.fillRect(0, 0, width, height);
    context.fillStyle = color('--scene');
    context.fillRect(0, 0, width, height - strip);
    context.drawImage(at('canvas'), 0, 0, width, height - strip);
    const x = (s) => s / state.hello.duration * width;
    const y = (f) => height - 4 - f / top * (strip - 8);
    for (const [role, lineWidth, until] of [['reference', 1, Infinity], ['commanded', 1.6, t]]) {
      const rows = state.store.first(role);
      if (!rows) continue;
      context.strokeStyle = COLORS[role];
      context.lineWidth = lineWidth;
      context.beginPath();
      for (let i = rows.begin; i < rows.end && rows.times[i] <= until; i += 4) context.lineTo(x(rows.times[i]), y(onAxis(rows.values, i * rows.width)));
      context.stroke();
    }
    return canvas.toDataURL('image/jpeg', 0.72);
  });
}

window.tactor = {
  frames,
  project: (x, y, z) => scene.project(x, y, z),
  latest(name) {
    const index = state.store.streams.findIndex((s) => s.name === name || s.role === name);
    const row = index < 0 ? null : state.store.data[index].at(Infinity);
    return row ? {time: row.time, values: Array.from(row.values)} : null;
  },
  samples: () => Object.fromEntries(state.store.streams.map((s, i) => [`${s.role} ${s.name}`, state.store.data[i].taken])),
  get connected() { return connection.open; },
  get mode() { return state.hello?.mode; },
  get hello() { return state.hello; },
  get status() { return state.status; },
  get method() { return state.method; },
  get parameters() { return {...knobs?.values}; },
  get counters() { return {...counters}; },
  get rate() { return rate; },
  get time() { return scene ? timeNow() : 0; },
  get complete() { return state.complete; },
  get ended() { return state.ended; },
};

async function open() {
  const recording = at('recording');
  if (!recording) return connection.connect();
  for (const message of await fromText(recording.textContent)) connection.decode(message);
  state.complete = true;
}
open().catch((error) => notice(`This page cannot be shown: ${error.message}`));
