"""`tactor view` without a browser: what its server lets in, what it tells, and what a page may do to a run."""
import gzip
import json
import os
import pathlib
import re
import signal
import socket
import struct
import time
import unittest

from harness import GRAPHS, TACTOR, CommandTest, needs_live, needs_meshes, needs_view, tactor
from view_client import Closed, Page, View, read_head, request, upgrade_lines

SCENE = str(GRAPHS / "wall/scene.yaml")
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", pathlib.Path(TACTOR).resolve().parents[1]))


STALLED = """extends: {scene}
{live}
nodes:
  stall: {{type: fault.stall, at: 12 s, lasts: {lasts}, lane: thread, thread: stalls}}
edges:
  - dynamics.state -> stall.in
  - stall.out -> coupling.state
"""
RAMP_DOWN = 0.1  # s, of devices unless a graph says otherwise


def get(port, lines):
    connection = request(port, lines)
    status, head = read_head(connection)
    size = re.search(r"(?i)content-length: (\d+)", head)
    body = b""
    while size and len(body) < int(size.group(1)):
        more = connection.recv(65536)
        if not more:
            break
        body += more
    connection.close()
    return status, head, body


@needs_view
@needs_live
class Security(CommandTest):
    """Each row of what a foreign program or page might try."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.view = View(TACTOR, SCENE)
        cls.port, cls.token = cls.view.port, cls.view.token

    @classmethod
    def tearDownClass(cls):
        assert cls.view.end() == 0
        super().tearDownClass()

    def lines(self, path="/", host=None, method="GET", more=()):
        return [f"{method} {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{self.port}'}", *more]

    def upgrade(self, **given):
        connection = request(self.port, upgrade_lines(self.port, self.token, **given))
        status, head = read_head(connection)
        connection.close()
        return status, head

    def test_it_listens_on_this_machine_alone(self):
        listening = set()
        for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]:
            local, state = line.split()[1], line.split()[3]
            if state == "0A" and int(local.split(":")[1], 16) == self.port:
                listening.add(local.split(":")[0])
        self.assertEqual(listening, {"0100007F"})
        six = pathlib.Path("/proc/net/tcp6")
        if six.exists():
            self.assertNotIn(f":{self.port:04X} ", six.read_text())

    def test_the_program_is_given_with_its_policies(self):
        for path, kind in (("/", "text/html"), ("/view.js", "text/javascript"), ("/socket.js", "text/javascript"), ("/view.css", "text/css"),
                           ("/saved.html", "text/html"), ("/licences.txt", "text/plain")):
            with self.subTest(path):
                status, head, body = get(self.port, self.lines(path))
                self.assertEqual(status, 200)
                self.assertIn(f"Content-Type: {kind}", head)
                self.assertIn("default-src 'none'", head)
                self.assertIn(f"ws://127.0.0.1:{self.port}", head)
                self.assertIn("X-Content-Type-Options: nosniff", head)
                self.assertTrue(gzip.decompress(body))
        for name in ("/", "/view.js", "/view.css"):
            text = gzip.decompress(get(self.port, self.lines(name))[2]).decode()
            if name == "/":
                self.assertNotRegex(text, r"(?i)(src|href)=.?https?:")
        total = sum(len(get(self.port, self.lines(p))[2]) for p in ("/", "/view.js", "/view.css"))
        self.assertLess(total, 2.5e6)

    def test_no_other_file_is_given(self):
        for path in ("/index.html", "/../view.js", "/etc/passwd", "//", "/%2e%2e/etc/passwd", "/stream", "/view.js?x=1"):
            with self.subTest(path):
                self.assertEqual(get(self.port, self.lines(path))[0], 404)
        for method in ("POST", "PUT", "DELETE", "OPTIONS"):
            with self.subTest(method):
                self.assertEqual(get(self.port, self.lines(method=method))[0], 405)

    def test_another_name_of_the_host_is_misdirected(self):
        for host in ("example.org", f"example.org:{self.port}", "127.0.0.1.example.org", "0.0.0.0"):
            with self.subTest(host):
                self.assertEqual(get(self.port, self.lines(host=host))[0], 421)
                self.assertEqual(self.upgrade(host=host)[0], 421)
        self.assertEqual(get(self.port, ["GET / HTTP/1.1"])[0], 421)
        self.assertEqual(get(self.port, self.lines(host=f"localhost:{self.port}"))[0], 200)

    def test_a_page_of_another_origin_is_forbidden(self):
        for origin in ("http://example.org", "null", f"http://127.0.0.1:{self.port + 1}", f"https://127.0.0.1:{self.port}",
                       f"http://localhost:{self.port}", ""):
            with self.subTest(origin):
                self.assertEqual(self.upgrade(origin=origin)[0], 403)

    def test_a_missing_or_wrong_token_is_unauthorized(self):
        for protocols in ("", "tactor.view", f"token.{self.token}", "tactor.view, token.", f"tactor.view, token.{'0' * 32}",
                          f"tactor.view, token.{self.token}0", f"tactor.view, token.{self.token[:-1]}"):
            with self.subTest(protocols):
                self.assertEqual(self.upgrade(protocols=protocols)[0], 401)

    def test_no_cookie_is_set(self):
        self.assertNotIn("Set-Cookie", get(self.port, self.lines())[1])
        self.assertNotIn("Set-Cookie", self.upgrade()[1])

    def test_what_is_no_message_closes_the_connection(self):
        for payload in (b"{", b"[]", b'{"type":"dance"}', b'{"type":"input","p":[0,0,NaN],"q":[1,0,0,0],"held":true}',
                        b'{"type":"input","p":[0,0,1e999],"q":[1,0,0,0],"held":true}', b'{"type":"ack","frame":1000000}'):
            with self.subTest(payload):
                page = self.view.page()
                page.send_frame(1, payload)
                self.assertEqual(self.closed(page), 1008)
        page = self.view.page()
        page.send_frame(2, b"\0\0\0\0")
        self.assertEqual(self.closed(page), 1008)

    def closed(self, page):
        with self.assertRaises(Closed) as caught:
            page.take_for(10, acknowledge=False)
        page.close()
        return caught.exception.code

    def test_a_long_message_closes_the_connection(self):
        page = self.view.page()
        page.send_frame(1, b'{"type":"set","parameter":"a","value":"' + b"x" * 5000 + b'"}')
        self.assertEqual(self.closed(page), 1009)
        # In parts it is as long.
        page = self.view.page()
        page.send_frame(1, b"x" * 3000, final=False)
        page.send_frame(0, b"x" * 3000)
        self.assertEqual(self.closed(page), 1009)

    def test_a_long_header_is_refused(self):
        status, _, _ = get(self.port, self.lines(more=("X-Long: " + "x" * 9000,)))
        self.assertEqual(status, 431)

    def test_a_header_that_dribbles_is_closed(self):
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=1)
        connection.sendall(b"GET / HTTP/1.1\r\n")
        begun = time.monotonic()
        with self.assertRaises((ConnectionError, TimeoutError)):
            while time.monotonic() - begun < 20:
                connection.sendall(b"X")
                try:
                    if not connection.recv(1):
                        raise ConnectionResetError
                except socket.timeout:
                    pass
            self.fail("the connection is still open")
        self.assertGreater(time.monotonic() - begun, 8)

    def test_eight_pages_are_let_in_and_no_more(self):
        pages = [self.view.page() for _ in range(8)]
        self.assertEqual(self.upgrade()[0], 503)
        for page in pages:
            page.close()
        time.sleep(0.5)
        self.view.page().close()


@needs_view
@needs_live
class Pages(CommandTest):
    fault_nodes = {"TACTOR_NODE_PATH": str(BUILD / "tests/nodes")}

    def start_of(self, page):
        return page.hello["device"]["start"][:3]

    def hold(self, page, p, held, seconds):
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            page.cursor(p, held)
            page.take_for(0.02)

    def press(self, page, depth=0.014, seconds=15):
        """Holds the handle and moves it down until physics answers with a force."""
        start = self.start_of(page)
        page.cursor(start, False)
        for step in range(40):
            page.cursor([start[0], start[1], start[2] - depth * step / 40], True)
            page.take_for(0.016)
        down = [start[0], start[1], start[2] - depth]
        page.wait_for(lambda p: p.stream("commanded") and abs(p.stream("commanded")[-1][1][2]) > 0.3, seconds, (down, True))
        return down

    def test_a_page_leads_the_tool_and_gets_samples_without_gaps(self):
        with View(TACTOR, SCENE) as view:
            page = view.page()
            self.assertEqual(page.hello["mode"], "live")
            self.assertTrue(page.hello["device"]["mouse"])
            down = self.press(page)
            self.assertGreater(page.stream("contact_count")[-1][1][0], 0)
            self.assertLess(max(abs(a - b) for a, b in zip(page.stream("handle")[-1][1], down)), 3e-3)
            times = [t for t, _ in page.stream("commanded")]
            self.assertEqual(times, sorted(times))
            # A later status counts every tick that was missed between these samples.
            page.wait_for(lambda p: p.last("status")["now"] > times[-1], 15, (down, True))
            status = page.last("status")
            absent = sum(round((b - a) * 1e3) - 1 for a, b in zip(times, times[1:]))
            self.assertLessEqual(absent, status["device"]["missed"])
            self.assertEqual((status["lost"], status["dropped"]), (0, 0))
            page.close()

    def stalled(self, lasts, live=""):
        """A wall whose physics does not come back for so long, once, from 12 s on."""
        return str(self.write("stalled.yaml", STALLED.format(scene=SCENE, lasts=lasts, live=live)))

    def test_the_mouse_outlasts_a_stall_with_the_force_at_zero(self):
        with View(TACTOR, self.stalled("1.5 s"), environment=self.fault_nodes) as view:
            page = view.page()
            down = self.press(page)
            stale = page.hello["causes"].index("stale")
            page.wait_for(lambda p: any(int(v[1]) == stale for _, v in p.stream("safety")), 30, (down, True))
            begin = next(t for t, v in page.stream("safety") if int(v[1]) == stale)
            page.wait_for(lambda p: p.stream("commanded")[-1][0] > begin + 0.8, 15, (down, True))
            # The gate's times are those of the graph, whatever the stall timeout is.
            during = [v[2] for t, v in page.stream("commanded") if begin + RAMP_DOWN + 0.02 < t < begin + 0.8]
            self.assertGreater(len(during), 100)
            self.assertEqual(set(during), {0.0})
            page.wait_for(lambda p: abs(p.stream("commanded")[-1][1][2]) > 0.3, 30, (down, True))
            page.close()
            self.assertIsNone(view.process.poll())

    def test_a_graph_that_names_its_stall_timeout_keeps_it(self):
        with View(TACTOR, self.stalled("1.5 s", "live: {stall_timeout: 0.5 s}"), environment=self.fault_nodes) as view:
            page = view.page()
            with self.assertRaises(Closed):
                page.take_for(60)
            self.assertEqual(page.last("ended")["end"], "stalled")
            said = view.process.communicate(timeout=60)[1]
            self.assertEqual(view.process.returncode, 1)
            self.assertRegex(said, r"node stall .*live\.stall_timeout of the graph is 500 ms")

    def test_a_closed_page_ramps_down_and_coming_back_is_disengaged(self):
        with View(TACTOR, SCENE) as view:
            page, looker = view.page(), view.page()
            down = self.press(page)
            page.close()
            looker.take_for(1.0)
            self.assertEqual(looker.stream("commanded")[-1][1][2], 0.0)
            self.assertEqual(looker.hello["causes"][int(looker.stream("safety")[-1][1][1])], "dead_man")
            self.assertEqual(looker.last("status")["hold"], "page_gone")
            # Who comes back holding gets nothing, until it lets go.
            looker.say(type="control")
            looker.wait_for(lambda p: p.last("status")["in_control"] == p.hello["client"])
            self.hold(looker, down, True, 0.5)
            self.assertEqual(looker.stream("commanded")[-1][1][2], 0.0)
            self.hold(looker, down, False, 0.1)
            looker.wait_for(lambda p: abs(p.stream("commanded")[-1][1][2]) > 0.3, 15, (down, True))
            looker.close()

    def test_a_page_that_sends_no_input_is_released_after_200_ms(self):
        with View(TACTOR, SCENE) as view:
            page = view.page()
            down = self.press(page)
            page.take_for(0.8)  # its socket is open, and it reads
            self.assertEqual(page.stream("commanded")[-1][1][2], 0.0)
            self.hold(page, down, True, 0.5)
            self.assertEqual(page.stream("commanded")[-1][1][2], 0.0, "coming back is disengaged")
            self.assertEqual(page.last("status")["hold"], "silent")
            self.hold(page, down, False, 0.1)
            page.wait_for(lambda p: abs(p.stream("commanded")[-1][1][2]) > 0.3, 15, (down, True))
            page.close()

    def test_one_page_is_in_control_and_the_others_look(self):
        with View(TACTOR, SCENE) as view:
            first, second = view.page(), view.page()
            start = self.start_of(first)
            for _ in range(30):
                second.cursor([start[0], start[1], start[2] + 0.01], True)
                second.take_for(0.02)
            second.say(type="set", parameter="device.force_max", value="3")
            second.take_for(0.5)
            self.assertIsNone(second.last("set"))
            self.assertAlmostEqual(second.stream("handle")[-1][1][2], start[2], 6)
            self.assertEqual(second.last("status")["in_control"], first.hello["client"])
            first.take_for(0.3)
            self.assertEqual(first.last("status")["clients"], 2)
            second.say(type="stop")
            with self.assertRaises(Closed):
                first.take_for(10)
            self.assertEqual(first.last("ended")["end"], "stopped")

    def test_parameters_are_set_and_refused(self):
        with View(TACTOR, SCENE) as view:
            page, other = view.page(), view.page()
            page.say(type="set", parameter="device.force_max", value="2.5 N")
            page.wait_for(lambda p: p.last("set"))
            other.wait_for(lambda p: p.last("set"))
            self.assertEqual((other.last("set")["parameter"], other.last("set")["value"]), ("device.force_max", 2.5))
            # A page that comes later knows it.
            late = view.page()
            knob = next(p for p in late.hello["parameters"] if p["name"] == "device.force_max")
            self.assertEqual(knob["value"], 2.5)
            for parameter, value, reason in (("device.force_max", "-1", "0"), ("device.force_max", "2000", "1000"),
                                             ("device.force_max", "3 kg", "kg"), ("device.force_max", "nan", "nan"),
                                             ("device.rate", "500", "cannot be set"), ("nothing.here", "1", "nothing.here")):
                with self.subTest(parameter=parameter, value=value):
                    before = len(page.texts)
                    page.say(type="set", parameter=parameter, value=value)
                    page.wait_for(lambda p: any(t["type"] == "refused" for t in p.texts[before:]))
                    self.assertIn(reason, page.last("refused")["message"])
            self.assertIsNone(other.last("refused"))
            for client in (page, other, late):
                client.close()

    def test_a_page_that_does_not_read_costs_nobody_anything(self):
        with View(TACTOR, SCENE) as view:
            stalled = [view.page(receive_buffer=4096) for _ in range(3)]
            page = view.page()
            page.take_for(4)
            times = [t for t, _ in page.stream("commanded")]
            self.assertGreater(times[-1] - times[0], 3)
            status = page.last("status")
            self.assertEqual((status["lost"], status["dropped"], status["clients"]), (0, 0, 4))
            stalled[0].take_for(0.5)
            for client in (*stalled, page):
                client.close()

    def test_a_page_that_draws_nothing_gets_eight_frames_and_then_the_newest(self):
        with View(TACTOR, SCENE) as view:
            page = view.page()
            page.take_for(3, acknowledge=False)
            self.assertEqual(page.frames, 8)
            newest = page.stream("commanded")[-1][0]
            page.say(type="ack", frame=8)
            page.take_for(0.5)
            times = [t for t, _ in page.stream("commanded")]
            self.assertGreater(times[-1], newest + 2)
            self.assertLess(page.last("status")["now"] - times[-1], 0.3)
            self.assertGreater(page.last("status")["dropped"], 0)
            page.close()

    def test_the_server_survives_any_bytes(self):
        with View(TACTOR, SCENE) as view:
            for data in (b"\0" * 100, b"GET", b"\xff" * 3000, b"GET / HTTP/1.1\r\n\r\n\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"):
                connection = socket.create_connection(("127.0.0.1", view.port), timeout=5)
                connection.sendall(data)
                connection.close()
            page = view.page()
            page.connection.sendall(b"\xff" * 200)
            with self.assertRaises((Closed, ConnectionError)):
                page.take_for(5)
            page = view.page()
            page.take_for(0.5)
            self.assertGreater(page.frames, 0)
            page.close()

    def test_a_view_that_was_recorded_is_replayed_to_the_byte_and_shown(self):
        recording = self.folder / "touched.h5"
        with View(TACTOR, SCENE, "--record", str(recording)) as view:
            page = view.page()
            self.press(page)
            page.say(type="set", parameter="coupling.k_0", value="700")
            page.take_for(0.5)
            page.say(type="stop")
            with self.assertRaises(Closed):
                page.take_for(10)
            live = dict(page.stream("commanded"))
        result = tactor("replay", recording, "--out", self.folder / "again")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual((self.folder / "again/recording.h5").read_bytes(), recording.read_bytes())
        with View(TACTOR, str(recording)) as view:
            page = view.page()
            page.wait_for(lambda p: p.last("complete"))
            self.assertEqual(page.hello["mode"], "replay")
            shown = dict(page.stream("commanded"))
            self.assertTrue(page.stream("reference"))
            for t, force in live.items():
                self.assertEqual(shown[t], force)
            page.close()

    def test_what_cannot_be_shown_is_refused(self):
        taken = socket.socket()
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        other = self.write("text.h5", "no recording")
        for arguments, reason in (((SCENE, "--port", str(taken.getsockname()[1])), "--port"), (("nothing.yaml",), "nothing.yaml"),
                                  ((str(other),), "text.h5"), ((SCENE, "--device", "hand"), "--device")):
            with self.subTest(arguments):
                result = tactor("view", *arguments, "--no-open")
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(reason, result.stderr)
        taken.close()


if __name__ == "__main__":
    unittest.main()
