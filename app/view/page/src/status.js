// Tells force, safety and how the run goes in words and bars.
import { app, force_max, in_control, recording, shown_time } from './app.js';
import { by_id, set_text, show, span } from './dom.js';

const CAUSES = {
  none: '', not_finite: 'the force was not a number', overspeed: 'the device moved too fast', read_failed: 'the device could not be read',
  write_failed: 'the device took no force', time_reversed: 'time went back', dead_man: 'not held', stale: 'no fresh force',
  not_permitted: 'the run starts or stops', no_segment: 'no force yet', device_not_ready: 'the device is not ready', time_gap: 'a gap in time',
};

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

export function no_safety(why) {
  by_id('safety').dataset.state = 'unknown';
  set_text(by_id('safety'), why);
}

export function show_safety(time) {
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
