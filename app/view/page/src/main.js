// Starts the page: from the recording in it, or from the server that sent it.
import 'uplot/dist/uPlot.min.css';
import './view.css';
import { app, have_meshes, params, picture, recording, tell } from './app.js';
import { Connection } from './connection.js';
import { choose } from './controls.js';
import { by_id, show } from './dom.js';
import { frame } from './frame.js';
import { take_binary, take_text } from './intake.js';
import { read_recording } from './save.js';
import { no_safety } from './status.js';
import './for_tests.js';
import './saving.js';

async function open_recording() {
  let messages;
  try {
    messages = await read_recording(recording.textContent);
  } catch (error) {
    tell(`The recording in this file cannot be read; the file may be cut off. (${error.message})`);
    return;
  }
  for (const message of messages) {
    if (typeof message === 'string') take_text(JSON.parse(message));
    else take_binary(message);
  }
  take_text({ type: 'complete' });
  if (!have_meshes()) throw new Error('a mesh is missing');
  if (picture) draw_picture();
}

/** The time of the largest commanded force, s. */
function time_of_most_force() {
  const stream = app.store.role('commanded');
  let most = -1;
  let time = 0;
  for (let i = stream?.begin ?? 0; i < (stream?.end ?? 0); ++i) {
    const [x, y, z] = stream.row(i);
    const force = Math.hypot(x, y, z);
    if (force > most) [most, time] = [force, stream.times[i]];
  }
  return time;
}

/** `t=force` is the moment of the largest force. `#picture=scene&t=3.2` or `#picture=all&t=3.2`: one moment, and a title that says when it was drawn. */
function draw_picture() {
  app.replay.pause();
  app.replay.loop = false;
  const t = params.get('t') ?? '0';
  app.replay.seek(t === 'force' ? time_of_most_force() : Number(t));
  show(by_id('guide'), false);
  if (picture === 'scene') {
    document.body.classList.add('picture');
    for (const chart of app.charts) chart.visible = false;
  }
  let frames_left = 4; // sizes settle, charts are made
  const wait = () => {
    if (frames_left-- > 0) return requestAnimationFrame(wait);
    document.title += ' (drawn)';
  };
  requestAnimationFrame(wait);
}

if (recording) {
  open_recording();
} else if (location.protocol === 'file:') {
  tell('This file holds no recording.');
} else {
  const token = location.hash.slice(1);
  app.connection = new Connection(token, {
    text: take_text,
    binary: take_binary,
    closed: (why) => {
      if (!app.ended || /could not/.test(why)) tell(app.hello?.mode === 'replay' && app.complete ? 'The server is gone; the recording stays.' : why, { again: true });
      if (app.hello?.mode === 'live' && !app.ended) no_safety('not connected');
      by_id('stop').disabled = true;
      app.knobs?.enable(false);
      app.methods?.enable(false);
    },
  });
}
// A page that is left, but kept by the browser for the way back, must not stay in control.
window.addEventListener('pagehide', () => app.connection?.close());
window.addEventListener('pageshow', (event) => event.persisted && app.connection && location.reload());
choose();
requestAnimationFrame(frame);
