// Takes the messages of the run, and keeps what a saved page has to show again.
import { app, have_meshes, tell } from './app.js';
import { begin, make_scene } from './begin.js';
import { by_id, set_text, show } from './dom.js';
import { decode_binary } from './messages.js';
import { no_safety, show_status } from './status.js';
import { LIVE_HISTORY } from './store.js';

export function take_text(message) {
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
      app.end = message.end ?? 'over';
      by_id('stop').disabled = true;
      no_safety('ended');
      tell(`The run has ended: ${message.why}. The charts stay.`, { plain: true });
      break;
    default: // a newer server may say more
  }
}

export function take_binary(bytes) {
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

function take_status(status) {
  app.status = status;
  const { device } = status;
  if (device && device.wakeup_p99 !== undefined && status.now !== undefined)
    app.store.wakeup.append([status.now], [device.wakeup_p50 ?? NaN, device.wakeup_p99, device.wakeup_max ?? NaN]);
  keep_told(status.now ?? app.store.now ?? 0, status);
  app.diagram?.update(status);
  app.methods?.reference(status.reference);
  show_felt(status.reference);
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

/** The line keeps its place while nothing is known for a moment: the scene over it keeps its size. @param {{felt?: string} | undefined} reference */
function show_felt(reference) {
  if (reference?.felt) show(by_id('felt'), true);
  set_text(by_id('felt'), reference?.felt ? `A hand feels: ${reference.felt}` : '');
}

/** Shows in a replay what was told until the play head: values, the method that was felt, rates of the graph. */
export function follow(time) {
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
  app.followed_status = status;
  if (status) app.diagram?.update(status);
  show_felt(status?.reference);
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
