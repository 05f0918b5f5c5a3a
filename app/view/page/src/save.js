// Saves what the page keeps as one HTML file, and reads the recording of such a file.
import { from_base64, gunzip, gzip, messages_of, pack, to_base64, unpack } from './recording.js';

const MARK = ['<!--', 'TACTOR_RECORDING', '-->'].join('');

/** @returns {Promise<string>} the page that a recording is put into */
export async function saved_frame() {
  const answer = await fetch('/saved.html');
  if (!answer.ok) throw new Error(`saved.html: ${answer.status} ${answer.statusText}`);
  return answer.text();
}

/**
 * @param {string} page of saved_frame
 * @param {object} kept
 * @param {object} kept.hello
 * @param {object[]} kept.meshes
 * @param {import('./store.js').Store} kept.store
 * @param {{time: number, message: object}[]} kept.told
 * @param {{from: number, to: number}} span s
 * @returns {Promise<Blob>} the page
 */
export async function saved_page(page, { hello, meshes, store, told }, span) {
  const at = page.indexOf(MARK);
  if (at < 0) throw new Error('saved.html has no place for a recording');
  const packed = to_base64(await gzip(pack(messages_of(hello, meshes, store, told, span))));
  return new Blob([page.slice(0, at), '<script id="recording" type="text/plain">', packed, '</script>', page.slice(at + MARK.length)], { type: 'text/html' });
}

/** @param {Blob} blob @param {string} name */
export function download(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/** @param {string} text of the element `recording` @returns {Promise<(string | Uint8Array)[]>} */
export async function read_recording(text) {
  return unpack(await gunzip(from_base64(text)));
}
