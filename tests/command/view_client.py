"""A page of the view without a browser: the decoding of its frames."""
import json
import os
import re
import socket
import struct
import subprocess
import time

from websocket_client import Closed, WebSocketClient, read_head, request, upgrade_request  # noqa: F401


def upgrade_lines(port, token, host=None, origin=None, protocols=None):
    host = f"127.0.0.1:{port}" if host is None else host
    return upgrade_request("/stream", host, f"tactor.view, token.{token}" if protocols is None else protocols,
                           f"http://{host}" if origin is None else origin)


class Page(WebSocketClient):
    """A page that was let in."""

    def __init__(self, port, token, receive_buffer=None):
        super().__init__(port, upgrade_lines(port, token), "tactor.view", receive_buffer)
        self.hello = None
        self.texts = []
        self.meshes = []
        self.frames = 0
        self.samples = {}   # by index of the stream: a list of (time, values)
        self.sets = {}
        self.binary_bytes = 0

    def say(self, **message):
        self.send_frame(1, json.dumps(message).encode())

    def cursor(self, p, held, q=(1, 0, 0, 0)):
        self.say(type="input", p=list(p), q=list(q), held=held)

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
