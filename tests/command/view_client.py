"""A page of the view without a browser: a WebSocket over a raw socket, and the decoding of its frames."""
import base64
import json
import os
import re
import socket
import struct
import subprocess
import time


def request(port, lines, timeout=15):
    """Sends the lines of a request as they are; the socket."""
    connection = socket.create_connection(("127.0.0.1", port), timeout=timeout)
    connection.sendall("\r\n".join(lines + ["", ""]).encode())
    return connection


def read_head(connection):
    """The head of a response: its status and its text."""
    data = b""
    while b"\r\n\r\n" not in data:
        more = connection.recv(1)
        if not more:
            break
        data += more
    head = data.decode("latin-1")
    return (int(head.split()[1]) if head else None), head


def upgrade_lines(port, token, host=None, origin=None, protocols=None):
    host = f"127.0.0.1:{port}" if host is None else host
    lines = ["GET /stream HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
             "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
    origin = f"http://{host}" if origin is None else origin
    if origin:
        lines.append(f"Origin: {origin}")
    protocols = f"tactor.view, token.{token}" if protocols is None else protocols
    if protocols:
        lines.append(f"Sec-WebSocket-Protocol: {protocols}")
    return lines


class Closed(Exception):
    """The server closed the connection, with a code or without one."""

    def __init__(self, code=None):
        super().__init__(f"closed with {code}")
        self.code = code


class Page:
    """A client that was let in. `receive_buffer`: a small one makes a client that does not read felt soon."""

    def __init__(self, port, token, receive_buffer=None):
        self.connection = socket.socket()
        if receive_buffer:
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        # As browsers do it: what is small is sent at once.
        self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.connection.settimeout(15)
        self.connection.connect(("127.0.0.1", port))
        self.connection.sendall("\r\n".join(upgrade_lines(port, token) + ["", ""]).encode())
        status, head = read_head(self.connection)
        if status != 101:
            raise Closed(status)
        assert "tactor.view" in head, head
        self.data = b""
        self.hello = None
        self.texts = []
        self.meshes = []
        self.frames = 0
        self.samples = {}   # by index of the stream: a list of (time, values)
        self.sets = {}
        self.binary_bytes = 0

    def send_frame(self, opcode, payload, final=True):
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([(0x80 if final else 0) | opcode])
        head += bytes([0x80 | size]) if size < 126 else bytes([0x80 | 126]) + struct.pack(">H", size) if size < 65536 else \
            bytes([0x80 | 127]) + struct.pack(">Q", size)
        self.connection.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def say(self, **message):
        self.send_frame(1, json.dumps(message).encode())

    def cursor(self, p, held, q=(1, 0, 0, 0)):
        self.say(type="input", p=list(p), q=list(q), held=held)

    def _need(self, size):
        while len(self.data) < size:
            more = self.connection.recv(65536)
            if not more:
                raise Closed()
            self.data += more

    def receive(self):
        """The next message: its opcode and its bytes."""
        self._need(2)
        opcode, size, offset = self.data[0] & 15, self.data[1] & 127, 2
        if size == 126:
            self._need(4)
            size, offset = struct.unpack(">H", self.data[2:4])[0], 4
        elif size == 127:
            self._need(10)
            size, offset = struct.unpack(">Q", self.data[2:10])[0], 10
        self._need(offset + size)
        payload, self.data = self.data[offset:offset + size], self.data[offset + size:]
        if opcode == 8:
            raise Closed(struct.unpack(">H", payload[:2])[0] if len(payload) >= 2 else None)
        return opcode, payload

    def take(self, acknowledge=True):
        """Takes in one message."""
        opcode, payload = self.receive()
        if opcode == 1:
            text = json.loads(payload)
            self.texts.append(text)
            if text["type"] == "hello":
                self.hello = text
        elif opcode == 2:
            self.binary_bytes += len(payload)
            number = self.decode(payload)
            if number is not None and acknowledge:
                self.say(type="ack", frame=number)

    def take_for(self, seconds, acknowledge=True):
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self.connection.settimeout(max(until - time.monotonic(), 0.001))
            try:
                self.take(acknowledge)
            except (socket.timeout, BlockingIOError):
                break
        self.connection.settimeout(15)

    def wait_for(self, test, seconds=20, cursor=None):
        """Takes in what comes until test(self) is true; with `cursor` (p, held) it sends that all the time."""
        until = time.monotonic() + seconds
        while not test(self):
            assert time.monotonic() < until, "what was waited for did not come"
            if cursor:
                self.cursor(*cursor)
            self.take_for(0.02)

    def decode(self, payload):
        """Takes in a binary message, as docs/reference/view_protocol.md tells it; the number of a frame."""
        kind, count = struct.unpack_from("<II", payload)
        if kind == 2:
            index, vertices, triangles = count, *struct.unpack_from("<II", payload, 8)
            assert len(payload) == 16 + 12 * vertices + 12 * triangles
            self.meshes.append((index, vertices, triangles))
            return None
        assert kind == 1
        number, = struct.unpack_from("<Q", payload, 8)
        self.frames += 1
        at = 16
        for _ in range(count):
            size, sections, end = struct.unpack_from("<IId", payload, at)
            section = at + 16
            for _ in range(sections):
                section = self._section(payload, section)
            assert section == at + size
            at += size
        assert at == len(payload)
        return number

    def _section(self, payload, at):
        kind, stream, rows = struct.unpack_from("<HHI", payload, at)
        columns = len(self.hello["streams"][stream]["columns"])
        at += 8
        stamps = rows if kind == 0 else 1
        assert at % 8 == 0
        times = struct.unpack_from(f"<{stamps}d", payload, at)
        at += 8 * stamps
        values = struct.unpack_from(f"<{rows * columns}f", payload, at)
        at += 4 * rows * columns
        table = [values[i * columns:(i + 1) * columns] for i in range(rows)]
        if kind == 0:
            self.samples.setdefault(stream, []).extend(zip(times, table))
        else:
            self.sets[stream] = (times[0], table)
        return (at + 7) // 8 * 8

    def stream(self, role):
        """The samples of the first stream in that role."""
        for index, stream in enumerate(self.hello["streams"]):
            if stream["role"] == role:
                return self.samples.get(index, [])
        raise KeyError(role)

    def last(self, kind):
        found = [text for text in self.texts if text["type"] == kind]
        return found[-1] if found else None

    def close(self):
        self.connection.close()


class View:
    """`tactor view` as a process."""

    def __init__(self, command, *arguments, cwd=None, environment=None):
        self.process = subprocess.Popen([command, "view", *arguments, "--no-open"], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, cwd=cwd, env=dict(os.environ, **(environment or {})))
        line = self.process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)/#([0-9a-f]{32})", line)
        if not found:
            self.process.kill()
            raise AssertionError(line + self.process.stderr.read())
        self.url, self.port, self.token = found.group(0), int(found.group(1)), found.group(2)

    def page(self, **options):
        page = Page(self.port, self.token, **options)
        page.wait_for(lambda p: p.hello is not None and len(p.meshes) == p.hello["meshes"])
        return page

    def end(self):
        """Ends it as Ctrl-C does; its exit code."""
        if self.process.poll() is None:
            self.process.terminate()
        try:
            self.process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        return self.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()
