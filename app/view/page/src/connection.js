// Speaks with the server: opens the WebSocket, hands messages on, acknowledges frames that were drawn.

/** @typedef {{text: function(object): void, binary: function(Uint8Array): void, closed: function(string): void}} Listener */

export class Connection {
  /** @param {string} token @param {Listener} listener */
  constructor(token, listener) {
    this.pending = 0; // the newest frame that was taken and is not drawn yet
    this.acks = 0;
    this.open = false;
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.socket = new WebSocket(`${scheme}://${location.host}/stream`, token ? ['tactor.view', `token.${token}`] : ['tactor.view']);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => (this.open = true);
    this.socket.onmessage = (event) => {
      try {
        if (typeof event.data === 'string') listener.text(JSON.parse(event.data));
        else listener.binary(new Uint8Array(event.data));
      } catch (error) {
        this.failed = true;
        listener.closed(`The page could not take a message: ${error.message}`);
        this.socket.close();
        throw error;
      }
    };
    this.socket.onclose = (event) => {
      const was_open = this.open;
      this.open = false;
      if (this.failed) return;
      const why = event.reason ? ` (${event.reason})` : '';
      listener.closed(was_open ? `Connection lost${why}.`
        : 'No connection. Is the run still going, and is the address complete, with all behind the #?');
    };
  }

  close() {
    this.socket.close();
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
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
