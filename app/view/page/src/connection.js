// Speaks with the server through the worker that owns the WebSocket: hands messages on, acknowledges frames that were drawn.

/** @typedef {{text: function(object): void, binary: function(Uint8Array): void, closed: function(string): void}} Listener */

export class Connection {
  /** @param {string} token @param {Listener} listener */
  constructor(token, listener) {
    this.pending = 0; // the newest frame that was taken and is not drawn yet
    this.acks = 0;
    this.open = false;
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.worker = new Worker('/socket.js');
    this.worker.onmessage = ({ data }) => {
      if (data.opened) this.open = true;
      else if (data.closed) this.closed(data.closed, listener);
      else this.take(data, listener);
    };
    this.worker.onerror = () => {
      const was_open = this.open;
      this.close();
      listener.closed(was_open ? 'Connection lost: the worker of the page has failed.' : 'No connection: the browser did not start /socket.js.');
    };
    this.worker.postMessage({ open: { url: `${scheme}://${location.host}/stream`, protocols: token ? ['tactor.view', `token.${token}`] : ['tactor.view'] } });
  }

  take({ text, bytes }, listener) {
    try {
      if (text !== undefined) listener.text(JSON.parse(text));
      else listener.binary(new Uint8Array(bytes));
    } catch (error) {
      this.close();
      listener.closed(`The page could not take a message: ${error.message}`);
      throw error;
    }
  }

  closed({ was_open, reason }, listener) {
    this.open = false;
    const why = reason ? ` (${reason})` : '';
    listener.closed(was_open ? `Connection lost${why}.`
      : 'No connection. Is the run still going, and is the address complete, with all behind the #?');
  }

  /** At once, also while the page is left: the server releases the tool. */
  close() {
    this.open = false;
    this.worker.terminate();
  }

  send(message) {
    this.worker.postMessage({ text: JSON.stringify(message), input: message.type === 'input' });
  }

  /** The worker does not send the newest input again. */
  fall_silent() {
    this.worker.postMessage({ silent: true });
  }

  /** Remembers a frame; it is acknowledged when it was drawn. */
  taken(frame) {
    this.pending = frame;
  }

  /** Everything taken so far was drawn: the newest stands for those before it. */
  drawn() {
    if (this.pending) this.acknowledge(this.pending);
    this.pending = 0;
  }

  acknowledge(frame) {
    this.send({ type: 'ack', frame });
    ++this.acks;
  }
}
