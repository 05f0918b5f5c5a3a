// What all parts of the page share: its state, and the line across the page that tells what went wrong.
import { Timeline } from './charts.js';
import { by_id, set_text, show } from './dom.js';
import { Feel } from './feel.js';

export const params = new URLSearchParams(location.hash.slice(1));
export const picture = params.get('picture');
export const recording = by_id('recording');
export const dark_query = window.matchMedia('(prefers-color-scheme: dark)');

export const app = {
  hello: null, status: null, store: null, scene: null, cursor: null, knobs: null, methods: null, diagram: null, guide: null, replay: null,
  connection: null, feel: new Feel(), timeline: new Timeline(), charts: [], force_chart: null, meshes: [], told: [], marks: [],
  values: {}, base_values: {}, followed: -1, followed_status: null, released: null, end: null, message: null, ended: false, complete: false, quantity: 'force', axis: 'norm',
  experiment: null, counters: { frames_drawn: 0, samples_taken: {}, acks: 0, last_frame: 0, inputs: 0, chart_ms: 0 },
  fps: 0, lag: 0, drawn_times: [], offset: Infinity, peak: 0, shown_sets: new Map(), error: null,
};

/** A line across the page; `again` offers to connect again. */
export function tell(text, { plain = false, again = false } = {}) {
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

export const have_meshes = () => {
  for (let i = 0; i < (app.hello.meshes ?? 0); ++i) if (!app.meshes[i]) return false;
  return true;
};

export const in_control = () => !app.ended && app.connection?.open && app.hello.mode === 'live' && (!app.status || app.status.in_control === undefined || app.status.in_control === app.hello.client);
export const set_parameter = (parameter, value) => app.connection?.send({ type: 'set', parameter, value: String(value) });

export const force_max = () => app.hello.device?.force_max || 5;

/** The time that is shown: of the play head, or the newest. */
export const shown_time = () => (app.replay ? app.replay.time : app.store.now);
