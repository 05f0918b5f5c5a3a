// The worker of the page. It owns the WebSocket, so that slow drawing does not keep the heartbeat back.
import { Heartbeat } from './heartbeat.js';

const LOOK = 20; // ms

const heartbeat = new Heartbeat();
let socket = null;
let was_open = false;

function open({ url, protocols }) {
  socket = new WebSocket(url, protocols);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => {
    was_open = true;
    postMessage({ opened: true });
  };
  socket.onmessage = ({ data }) => (typeof data === 'string' ? postMessage({ text: data }) : postMessage({ bytes: data }, [data]));
  socket.onclose = ({ reason }) => postMessage({ closed: { was_open, reason } });
  setInterval(() => {
    const input = heartbeat.due(performance.now());
    if (input !== null) send(input);
  }, LOOK);
}

function send(text) {
  if (socket.readyState === WebSocket.OPEN) socket.send(text);
}

onmessage = ({ data }) => {
  if (data.open) return open(data.open);
  if (data.silent) return heartbeat.fall_silent();
  if (data.input) heartbeat.take(data.text, performance.now());
  send(data.text);
};
