// Tells force, safety and how the run goes in words and bars.
import { app, force_max, in_control, recording, shown_time } from './app.js';
import { by_id, set_text, show, span } from './dom.js';
import { release_of } from './release.js';

export function show_force(force, now) {
  const part = Math.min(1, force / force_max());
  app.peak = force >= app.peak ? force : Math.max(force, app.peak - force_max() * 0.004);
  by_id('force-fill').style.transform = `scaleX(${part.toFixed(4)})`;
  by_id('force-peak').style.left = `${(100 * Math.min(0.995, app.peak / force_max())).toFixed(2)}%`;
  if (now - (app.force_told ?? 0) < 60) return;
  app.force_told = now;
  set_text(by_id('force-value'), `${force.toFixed(2)} of ${force_max()} N`);
  by_id('force-bar').setAttribute('aria-valuenow', force.toFixed(2));
}

/** Says why there is no force, where there is none. @param {import('./release.js').Release | null} release */
function show_release(release) {
  app.released = release;
  show(by_id('release'), Boolean(release));
  if (!release) return;
  set_text(by_id('release-what'), release.what);
  set_text(by_id('release-again'), release.again);
}

/** There is no run any more: it has ended, or the connection to it is lost. @param {string} word for the badge */
export function no_safety(word) {
  by_id('safety').dataset.state = 'unknown';
  set_text(by_id('safety'), word);
  show_release(release_of({ connected: false, end: app.end }));
}

/** The words of the enumerations of `hello` for a row of the stream `safety`. */
function safety_at(safety, time) {
  const i = app.replay ? safety.find(time) : safety.end - 1;
  if (i < safety.start || !safety.size) return null;
  const row = safety.row(i);
  return { engagement: app.hello.engagements?.[row[safety.column.engagement]] ?? 'unknown', cause: app.hello.causes?.[row[safety.column.cause]] ?? 'none',
    gain: row[safety.column.gain] };
}

export function show_safety(time) {
  if (app.hello.mode === 'live' && (app.ended || !app.connection?.open)) return;
  const safety = app.store.role('safety');
  const badge = by_id('safety');
  if (!safety) {
    show(badge, false);
    return;
  }
  const shown = safety_at(safety, time);
  if (!shown) return;
  const { engagement, cause, gain } = shown;
  badge.dataset.state = engagement;
  set_text(badge, engagement === 'ramping' && gain !== undefined ? `ramping ${Math.round(100 * gain)} %` : engagement);
  const status = app.replay ? app.followed_status : app.status;
  const leads = status?.in_control === undefined || status.in_control === app.hello.client;
  // The page knows before the server tells it that its user has let go.
  const hold = status?.hold === 'held' && app.cursor && !app.cursor.held ? 'let_go' : status?.hold;
  const release = release_of({ engagement, cause, connected: true, phase: status?.phase, hold,
    stalled: (app.hello.nodes ?? []).filter((_, i) => status?.nodes?.[i]?.stalled).map((node) => node.name),
    control: app.replay || leads ? 'me' : status.in_control ? 'other' : 'nobody' });
  show_release(release && app.replay ? { ...release, again: '' } : release);
}

export function show_status() {
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
