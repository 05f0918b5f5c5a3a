// Buttons and keys of the page.
import { app, in_control, set_parameter, shown_time, tell } from './app.js';
import { by_id, set_text } from './dom.js';
import { moved, show_hold, zoom } from './page_charts.js';

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
export const choose = () => {
  app.force_chart?.choose(`${app.quantity}.${app.axis}`);
  if (!app.force_chart) return;
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
