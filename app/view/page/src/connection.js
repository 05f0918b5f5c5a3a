// The connection to the server: what comes in, what is said, and which frames were drawn.
import {kindOf, readFrame, readMesh} from './messages.js';

export class Connection {
  /**
   * @param {{hello: (hello: object) => void, text: (message: object) => void, mesh: (mesh: object) => void,
   *          chunks: (chunks: object[], buffer: ArrayBuffer) => void, lost: (why: string) => void}} takers
   */
  constructor(takers) {
    this.takers = takers;
    this.columns = [];
    this.drawn = 0;
    this.told = 0;
    this.frames = 0;
    this.acks = 0;
    this.open = false;
  }
  connect() {
    const token = location.hash.slice(1).split('&')[0];
    this.socket = new WebSocket(`ws://${location.host}/stream`, ['tactor.view', `token.${token}`]);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => { this.open = true; };
    this.socket.onmessage = ({data}) => this.take(data);
    this.socket.onclose = ({code}) => {
      const was = this.open;
      this.open = false;
      this.takers.lost(was ? `The connection has ended (${code}). The curves stay.`
        : 'The server did not let this page in. Open the address that tactor printed, with all behind the #.');
    };
  }
  take(data) {
    try {
      this.decode(data);
    } catch (error) {
      this.takers.lost(`What the server sent cannot be read: ${error.message}`);
      this.socket?.close();
    }
  }
  decode(data) {
    if (typeof data === 'string') {
      const message = JSON.parse(data);
      if (message.type !== 'hello') return this.takers.text(message);
      this.columns = message.streams.map((s) => s.columns.length);
      return this.takers.hello(message);
    }
    if (kindOf(data) === 2) return this.takers.mesh(readMesh(data));
    const {number, chunks} = readFrame(data, this.columns);
    this.drawn = number;
    this.frames += 1;
    this.takers.chunks(chunks, data);
  }
  say(message) {
    if (this.open) this.socket.send(JSON.stringify(message));
  }
  /** To be called when what has come was drawn. */
  acknowledge() {
    if (this.drawn === this.told) return;
    this.told = this.drawn;
    this.acks += 1;
    this.say({type: 'ack', frame: this.drawn});
  }
}
