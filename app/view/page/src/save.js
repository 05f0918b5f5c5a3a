// "Save as HTML": one file with this program, the scene and the curves.
import {toText, writeFrame, writeMesh} from './messages.js';
import {Rows} from './store.js';

/** The messages that make a page replay what the store holds. */
export function recordingOf(hello, meshes, store) {
  // Times begin at zero, whatever minute of a long run they are of.
  let begin = Infinity;
  for (const data of store.data) if (data instanceof Rows && data.count > 0) begin = Math.min(begin, data.times[data.begin]);
  if (!Number.isFinite(begin)) begin = 0;
  const saved = {...hello, mode: 'replay', duration: store.newest - begin, parameters: []};
  const shifted = (section) => ({...section, times: section.times.map((t) => t - begin)});
  const frames = [];
  const sections = store.data.map((d, i) => d instanceof Rows ? d.section(i) : null).filter(Boolean).map(shifted);
  frames.push(writeFrame(1, saved.duration, sections));
  const sets = [];
  store.data.forEach((data, stream) => {
    if (data instanceof Rows) return;
    for (const set of data.sets) {
      if (set.time < begin) continue;
      sets.push(shifted({kind: 'set', stream, rows: set.rows, times: Float64Array.of(set.time), values: set.values}));
    }
  });
  if (sets.length > 0) frames.push(writeFrame(2, saved.duration, sets));
  return [JSON.stringify(saved), ...meshes.map(writeMesh), ...frames];
}

/** @param {object} hello @param {object[]} meshes @param {import('./store.js').Store} store */
export async function save(hello, meshes, store) {
  const response = await fetch('/saved.html');
  if (!response.ok) throw new Error(`the server gives no page to save (${response.status})`);
  const program = await response.text();
  const text = await toText(recordingOf(hello, meshes, store));
  const page = program.replace('<!--TACTOR_RECORDING-->', () => `<script id="recording" type="text/plain">${text}</script>`);
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([page], {type: 'text/html'}));
  link.download = `${hello.graph}.html`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
