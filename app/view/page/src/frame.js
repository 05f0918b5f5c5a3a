// Draws one frame of everything, as often as the screen takes one.
import { app, force_max, in_control, picture } from './app.js';
import { follow } from './intake.js';
import { draw_charts } from './page_charts.js';
import { show_force, show_safety, show_status } from './status.js';

export function draw_scene(time) {
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

export function frame(now) {
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
  app.cursor?.drawn(performance.now());
}
