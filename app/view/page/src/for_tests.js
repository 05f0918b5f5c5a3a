// What tests and pictures ask the page, as `window.tactor`.
import { app, dark_query, shown_time } from './app.js';
import { draw_strip } from './charts.js';
import { make } from './dom.js';
import { draw_scene } from './frame.js';
import { moved } from './page_charts.js';
import { without_words } from './release.js';

/**
 * Pictures of the scene with the force below, for animations.
 * @param {number[]} times s
 * @param {number} [width] px
 * @param {number} [height] px
 * @param {string} [type] image/webp, image/jpeg or image/png
 * @returns {string[]} data URLs
 */
export function frames(times, width = 640, height = 480, type = 'image/webp') {
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
  /** What released the force and how to engage again, as it is shown, or null. */
  get released() { return app.released ?? null; },
  get without_words() { return without_words(app.hello); },
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
  /** The colours of the force and the tool, as #rrggbb: of the arrow, the curve and the body. */
  get colours() {
    const { arrows, materials } = app.scene;
    return { arrow: `#${arrows.commanded.shaft.material.color.getHexString()}`, curve: app.force_chart.curves.find((curve) => curve.role === 'commanded').colour,
      tool: `#${materials.tool.color.getHexString()}` };
  },
  /** The gaps of a stream, [from, to] in s. */
  gaps: (name) => app.store.by_name.get(name).gaps_until(app.store.now),
  /** How many pixels of the large chart have the colour of a curve between two times in s, without 2 pixels at each side. */
  drawn(label, from, to) {
    const { plot, curves } = app.force_chart;
    const [red, green, blue] = [1, 3, 5].map((i) => parseInt(curves.find((curve) => curve.label === label).colour.slice(i, i + 2), 16));
    const left = Math.ceil(plot.valToPos(from, 'x', true)) + 2;
    const width = Math.floor(plot.valToPos(to, 'x', true)) - 2 - left;
    if (!(width > 0)) return null;
    const { data } = plot.ctx.getImageData(left, plot.bbox.top, width, plot.bbox.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (Math.hypot(data[i] - red, data[i + 1] - green, data[i + 2] - blue) < 40) ++count;
    return count;
  },
  /** A point of the world in client pixels. */
  project: (x, y, z) => app.scene?.project(x, y, z),
  seek: (time) => app.replay?.seek(time),
  frames,
};
