"""`tactor view --foxglove` against whoever means it ill: what lets a page in, and what no viewer can make the run cost."""
import base64
import json
import os
import re
import resource
import socket
import struct
import threading
import time
import unittest

from harness import GRAPHS, TACTOR, CommandTest, needs_live, needs_view, tactor
from view_client import Closed, View, read_head, request

SCENE = str(GRAPHS / "wall/scene.yaml")
PROTOCOL = "foxglove.websocket.v1"
ALLOWED = "https://app.foxglove.dev"
# One bound for all that waits, and what the heap and the system's calls keep beside it.
MOST_GROWTH = 96 << 20  # bytes


def lines_for(port, origin=None, host=None, protocol=PROTOCOL):
    lines = ["GET / HTTP/1.1", f"Host: {f'127.0.0.1:{port}' if host is None else host}", "Upgrade: websocket",
             "Connection: Upgrade", "Sec-WebSocket-Version: 13",
             "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
    lines += [f"Origin: {origin}"] if origin is not None else []
    return lines + ([f"Sec-WebSocket-Protocol: {protocol}"] if protocol else [])


def frame(payload, opcode=1):
    """A frame of a client, with a mask of zeros."""
    size = len(payload)
    head = bytes([0x80 | opcode, 0x80 | size]) if size < 126 else bytes([0x80 | opcode, 0xfe]) + struct.pack(">H", size) \
        if size < 65536 else bytes([0x80 | opcode, 0xff]) + struct.pack(">Q", size)
    return head + bytes(4) + payload


def asks(**request_fields):
    return frame(json.dumps(request_fields).encode())


class Viewer:
    """A viewer of Foxglove over a raw socket. It reads only when it is told to."""

    def __init__(self, port, origin=None, receive_buffer=4096):
        self.connection = socket.socket()
        if receive_buffer:
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.connection.settimeout(20)
        self.connection.connect(("127.0.0.1", port))
        self.connection.sendall("\r\n".join(lines_for(port, origin) + ["", ""]).encode())
        status, _ = read_head(self.connection)
        if status != 101:
            raise Closed(status)

    def _take(self, size):
        data = b""
        while len(data) < size:
            more = self.connection.recv(size - len(data))
            if not more:
                raise Closed()
            data += more
        return data

    def receive(self):
        head = self._take(2)
        size = head[1] & 127
        size = struct.unpack(">H", self._take(2))[0] if size == 126 else struct.unpack(">Q", self._take(8))[0] if size == 127 else size
        return head[0] & 15, self._take(size)

    def text(self, op):
        """The next text of that kind."""
        while True:
            opcode, payload = self.receive()
            if opcode == 1 and json.loads(payload)["op"] == op:
                return json.loads(payload)

    def push(self, data):
        """Sends as much as the server takes at once; the bytes that it took."""
        self.connection.setblocking(False)
        sent = 0
        try:
            while sent < len(data):
                sent += self.connection.send(data[sent:])
        except (BlockingIOError, ConnectionError):
            pass
        finally:
            self.connection.settimeout(20)
        return sent

    def close(self):
        self.connection.close()


@needs_view
@needs_live
class Foxglove(CommandTest):
    def view(self, *arguments):
        view = View(TACTOR, SCENE, "--no-reference", "--foxglove=0", *arguments)
        self.addCleanup(view.end)
        view.viewers = int(re.search(r"ws://127\.0\.0\.1:(\d+)", view.process.stdout.readline())[1])
        return view

    def resident(self, view):
        """The most memory that the process has had, in bytes."""
        with open(f"/proc/{view.process.pid}/status") as status:
            return int(re.search(r"VmHWM:\s+(\d+) kB", status.read())[1]) << 10

    def stopped_by_a_page(self, view, page):
        """A page ends the run, whatever viewers do meanwhile."""
        page.say(type="stop")
        page.wait_for(lambda p: p.last("ended") is not None, seconds=60)

    def test_programs_and_pages_that_were_named_are_let_in_and_no_others(self):
        view = self.view("--allow-origin", ALLOWED, "--allow-origin", "file://")
        port = view.viewers
        own = f"http://127.0.0.1:{port}"
        for origin, status in [(None, 101), (own, 101), (ALLOWED, 101), ("file://", 101), ("https://example.org", 403),
                               ("null", 403), ("http://app.foxglove.dev", 403), (ALLOWED + ":444", 403), (ALLOWED + ".example.org", 403),
                               (ALLOWED + "/", 403), (ALLOWED.upper(), 403), (f"http://127.0.0.1:{view.port}", 403),
                               (f"http://localhost:{port}", 403), (f"https://127.0.0.1:{port}", 403), ("http://127.0.0.1", 403),
                               ("https://\x1b[2J", None), (f"{own} {ALLOWED}", 403)]:
            with self.subTest(origin=origin):
                connection = request(port, lines_for(port, origin))
                self.assertEqual(read_head(connection)[0], status)
                connection.close()
        for host, status in [("example.org", 421), (f"example.org:{port}", 421), ("0.0.0.0", 421), ("", 421), (f"localhost:{port}", 101)]:
            with self.subTest(host=host):
                connection = request(port, lines_for(port, host=host))
                self.assertEqual(read_head(connection)[0], status)
                connection.close()
        connection = request(port, lines_for(port, protocol="tactor.view"))
        self.assertEqual(read_head(connection)[0], 400)
        connection.close()
        self.assertEqual(view.end(), 0)

    def test_an_origin_that_is_none_is_bad_input(self):
        for origin in ("app.foxglove.dev", "https://", "https://a/b", "*", "https://*.foxglove.dev", "https://a, https://b", "https://a?b"):
            with self.subTest(origin=origin):
                refused = tactor("view", SCENE, "--no-open", "--foxglove=0", "--allow-origin", origin)
                self.assertEqual(refused.returncode, 2, refused.stdout)
                self.assertIn("--allow-origin", refused.stderr)

    def test_first_messages_come_once_for_each_subscription(self):
        view = self.view()
        viewer = Viewer(view.viewers, receive_buffer=None)
        channels = {channel["topic"]: channel["id"] for channel in viewer.text("advertise")["channels"]}
        scene = channels["/scene"]
        subscribe = [{"id": n, "channelId": scene} for n in range(1, 1001)]
        viewer.connection.sendall(asks(op="subscribe", subscriptions=subscribe) + asks(op="getParameters", parameterNames=[], id="here"))
        got = []
        while True:
            opcode, payload = viewer.receive()
            if opcode == 2 and payload[0] == 1:
                got.append(struct.unpack_from("<I", payload, 1)[0])
            elif opcode == 1 and json.loads(payload).get("id") == "here":
                break
        self.assertEqual(got, [1])
        # Whoever has let go of it gets it anew: a viewer that opens another panel needs it.
        viewer.connection.sendall(asks(op="unsubscribe", subscriptionIds=[1]) +
                                  asks(op="subscribe", subscriptions=[{"id": 7, "channelId": scene}]))
        while True:
            opcode, payload = viewer.receive()
            if opcode == 2 and payload[0] == 1:
                self.assertEqual(struct.unpack_from("<I", payload, 1)[0], 7)
                break
        viewer.close()
        self.assertEqual(view.end(), 0)

    def test_viewers_that_ask_for_ever_and_read_nothing_cost_a_few_megabytes_and_no_stop(self):
        view = self.view()
        page = view.page()
        first = Viewer(view.viewers, receive_buffer=None)
        count = len(first.text("advertise")["channels"])
        first.close()
        before = self.resident(view)
        # Each member asks 100,000 times, as far as the server takes it.
        subscriptions = [[{"id": n * count + channel, "channelId": channel} for channel in range(count)] for n in range(40)]
        members = {
            "one channel": asks(op="subscribe", subscriptions=[{"id": 1, "channelId": 0}]),
            "every channel": b"".join(asks(op="subscribe", subscriptions=s) for s in subscriptions),
            "on and off": asks(op="subscribe", subscriptions=[{"id": 1, "channelId": 0}]) + asks(op="unsubscribe", subscriptionIds=[1]),
            "no channel": asks(op="subscribe", subscriptions=[{"id": n, "channelId": 10**6 + n} for n in range(1000)]),
            "parameters": asks(op="getParameters", parameterNames=[]),
            "changes": asks(op="setParameters", parameters=[{"name": "coupling.k_0", "value": 1}], parameterNames=[]),
            "rubbish": frame(b"{"), "bytes": frame(bytes(60_000), 2), "pings": frame(bytes(100), 9),
            "deep": frame(b"[" * 60_000), "wide": asks(op="getParameters", parameterNames=["x"] * 10_000),
            "unknown": asks(op="x" * 60_000),
        }
        pushed = dict.fromkeys(members, 0)

        def flood(names, end):
            """Goes on until it is told to end, with a viewer for each member, anew if the server ends one."""
            viewers, rest = {}, {}
            while not end.is_set():
                for name in names:
                    try:
                        if name not in viewers:
                            viewers[name] = Viewer(view.viewers)
                        data = rest.get(name) or members[name] * max(1, 200_000 // len(members[name]))
                        sent = viewers[name].push(data)
                        rest[name] = data[sent:]
                        pushed[name] += sent
                    except (Closed, OSError):
                        gone = viewers.pop(name, None)
                        if gone:
                            gone.close()
                        rest.pop(name, None)
                time.sleep(0.005)
            for viewer in viewers.values():
                viewer.close()

        # As many at once as are let in, and at last a page that ends the run while they go on.
        names = list(members)
        for half in (names[:6], names[6:]):
            end = threading.Event()
            floods = [threading.Thread(target=flood, args=(half[i::2], end)) for i in range(2)]
            for thread in floods:
                thread.start()
            try:
                told = len(page.texts)
                page.take_for(5)
                page.wait_for(lambda p: len(p.texts) > told)
                if half[-1] == names[-1]:
                    self.stopped_by_a_page(view, page)
            finally:
                end.set()
                for thread in floods:
                    thread.join()
        self.assertTrue(all(sent > 50_000 for sent in pushed.values()), pushed)
        grown = self.resident(view) - before
        self.assertLess(grown, MOST_GROWTH, f"{grown >> 20} MiB, pushed {pushed}")
        page.close()
        self.assertEqual(view.end(), 0)

    def test_frames_that_end_no_request_are_limited_too(self):
        view = self.view()
        seconds = 3  # that so many bytes take at 1 MiB/s
        text_goes_on, goes_on = b"\x01\x80" + bytes(4), b"\x00\x80" + bytes(4)  # frames of nothing that are not the last
        for name, first, empty, last in [("continuations", text_goes_on, goes_on, frame(b"{", 0)),
                                         ("pings", b"", frame(b"", 9), frame(b"{")), ("pongs", b"", frame(b"", 10), frame(b"{"))]:
            with self.subTest(name):
                viewer = Viewer(view.viewers, receive_buffer=None)
                viewer.text("advertise")
                begun = time.monotonic()
                sender = threading.Thread(target=viewer.connection.sendall, args=(first + empty * ((seconds << 20) // len(empty)) + last,))
                sender.start()
                viewer.connection.settimeout(60)
                viewer.text("status")
                self.assertGreater(time.monotonic() - begun, seconds - 1)
                sender.join()
                viewer.close()
        self.assertEqual(view.end(), 0)

    def test_half_open_connections_lock_nobody_out(self):
        view = self.view()
        for port in (view.viewers, view.port):
            for beginning in (b"", b"G", b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: "):
                with self.subTest(port="viewers" if port == view.viewers else "pages", beginning=beginning):
                    silent = []
                    for _ in range(300):
                        connection = socket.create_connection(("127.0.0.1", port), timeout=20)
                        connection.sendall(beginning)
                        silent.append(connection)
                    # Both are let in while the silent ones are still there.
                    Viewer(view.viewers).close()
                    view.page().close()
                    for connection in silent:
                        connection.close()
        self.assertEqual(view.end(), 0)

    def test_without_descriptors_it_goes_on_and_lets_in_again(self):
        view = self.view()
        page = view.page()
        before = resource.prlimit(view.process.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(view.process.pid, resource.RLIMIT_NOFILE, (3, before[1]))
        waiting = [socket.create_connection(("127.0.0.1", port)) for port in (view.port, view.viewers) for _ in range(3)]
        told = len(page.texts)
        page.wait_for(lambda p: len(p.texts) > told + 3)
        resource.prlimit(view.process.pid, resource.RLIMIT_NOFILE, before)
        for connection in waiting:
            connection.close()
        Viewer(view.viewers).close()
        view.page().close()
        page.close()
        view.process.terminate()
        _, errors = view.process.communicate(timeout=60)
        # Each server says it once.
        self.assertEqual(errors.count("cannot take a connection"), 2, errors)


if __name__ == "__main__":
    unittest.main()
