"""A client of `tactor bridge` without a library of WebSockets, and the command as a process."""
import json
import os
import re
import struct
import subprocess
import sys
import time

from harness import PATIENCE, ROOT, TACTOR
from websocket_client import Closed, WebSocketClient, upgrade_request

sys.path.insert(0, str(ROOT / "examples/bridge"))
from ball import Ball  # noqa: E402, F401

EXAMPLE = ROOT / "examples/bridge"
TEXT, BINARY = 1, 2
# The packed messages, as docs/howto/bridge.md has them.
HANDLE = "3d4d3d3dq"
STEP = struct.Struct(f"<IIQqq{HANDLE}{HANDLE}6dq")
TOOL = struct.Struct("<3d4d3d3d")
CONTACT = struct.Struct("<3d3d3d8d6dqq")
UNTOLD = {name: [float("nan")] * size for name, size in (("R_W", 4), ("w_W", 3), ("p_TC", 3))}


def upgrade_lines(port, token, **given):
    host = given.get("host", f"127.0.0.1:{port}")
    protocols = given.get("protocols", f"tactor.bridge, token.{token}")
    return upgrade_request(given.get("path", "/bridge"), host, protocols, given.get("origin", ""))


def handle_of(numbers):
    return {"p_WD": list(numbers[:3]), "R_WD": list(numbers[3:7]), "v_WD": list(numbers[7:10]), "w_WD": list(numbers[10:13]),
            "buttons": numbers[13]}


def unpacked(message):
    """A message of the server, as its text would have it."""
    kind, = struct.unpack_from("<I", message)
    if kind == 3:
        size, field, = struct.unpack_from("<II", message, 4)
        assert len(message) == 12 + size + field
        return {"type": "error", "message": message[12:12 + size].decode(), "field": message[12 + size:].decode()}
    assert kind == 1 and len(message) == STEP.size == 312
    _, given, identity, begin, end, *rest = STEP.unpack(message)
    assert given == 0
    names = ("k_t", "b_t", "k_r", "b_r", "force_max", "torque_max", "massless")
    return {"type": "step", "id": identity, "begin": begin, "end": end, "from": handle_of(rest[:14]), "handle": handle_of(rest[14:28]),
            "coupling": dict(zip(names, rest[28:]))}


def pose_and_twist(state, body):
    return TOOL.pack(*(number for name in ("p_W", "R_W", "v_W", "w_W") for number in state.get(name + body) or UNTOLD[name]))


def wrench(values):
    return struct.pack("<6d", *values["force"], *values["torque"]) if values else bytes(48)


def packed(result):
    """A result as bytes."""
    optional = ("time", "tool", "felt", "contact", "contacts", "bodies")
    given = sum(1 << bit for bit, name in enumerate(optional) if result.get(name) is not None)
    contacts, bodies = result.get("contacts") or (), result.get("bodies") or ()
    numbers = ("p_TC", "p_WC", "n_W")
    return b"".join([
        struct.pack("<IIQq", 2, given, result["id"], result.get("time") or 0),
        pose_and_twist(result["tool"], "T") if result.get("tool") else bytes(TOOL.size), wrench(result.get("felt")), wrench(result.get("contact")),
        struct.pack("<QQ", len(contacts), len(bodies)),
        *(CONTACT.pack(*(number for name in numbers for number in one.get(name) or UNTOLD[name]),
                       *(one[name] for name in ("distance", "weight", "stiffness", "damping", "friction")),
                       *(one.get(name, 0) for name in ("inertia", "creep", "lift")),
                       *one.get("H_W", [0] * 6), one.get("body", 0), one.get("other", -1)) for one in contacts),
        *(pose_and_twist(one, "B") for one in bodies)])


class BridgeClient(WebSocketClient):
    """A client that was let in, and writes as `packed` says."""

    def __init__(self, port, token, packed=False, **given):
        super().__init__(port, upgrade_lines(port, token, **given), "tactor.bridge")
        self.packed = packed
        self.errors = []
        if packed:
            self.ask()

    def ask(self):
        """Asks for the newest step."""
        if self.packed:
            self.send_frame(BINARY, struct.pack("<I", 4))
        else:
            self.send_frame(TEXT, b'{"type": "next"}')

    def message(self):
        """The next message, and whether it was packed."""
        opcode, payload = self.receive()
        return (unpacked(payload), True) if opcode == BINARY else (json.loads(payload), False)

    def until(self, kind):
        """The next message of that type; errors before it are kept."""
        while True:
            message, was_packed = self.message()
            if message["type"] == kind and (kind != "step" or was_packed == self.packed):
                return message
            if message["type"] == "error":
                self.errors.append(message)

    def answer(self, result):
        if self.packed:
            self.send_frame(BINARY, packed(result))
        else:
            self.send_frame(TEXT, json.dumps(result).encode())

    def play(self, ball, until=lambda step: False):
        """Computes steps until the run is over, when it returns nothing, or `until` is true for one, which it returns unanswered."""
        try:
            while True:
                step = self.until("step")
                if until(step):
                    return step
                self.answer(ball.step(step))
        except (Closed, ConnectionError):
            return None


class Bridge:
    """`tactor bridge` as a process."""

    def __init__(self, *arguments, environment=None, cwd=None):
        self.process = subprocess.Popen([TACTOR, "bridge", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        cwd=cwd, env=dict(os.environ, **(environment or {})))
        line = self.process.stdout.readline()
        found = re.search(r"ws://127\.0\.0\.1:(\d+)/bridge#([\w-]+)", line)
        if not found:
            self.process.kill()
            raise AssertionError(line + self.process.stderr.read())
        self.url, self.port, self.token = found[0], int(found[1]), found[2]
        self.said = self.told = ""

    def client(self, packed=False, **given):
        return BridgeClient(self.port, self.token, packed, **given)

    def client_when_free(self, seconds=20, **given):
        """A client that tries until the place is free."""
        until = time.monotonic() + seconds
        while True:
            try:
                return self.client(**given)
            except Closed as refused:
                if refused.code != 503 or time.monotonic() > until:
                    raise
                time.sleep(0.02)

    def wait(self):
        """The exit code once it has ended by itself."""
        try:
            self.said, self.told = self.process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        return self.process.returncode

    def end(self):
        """Ends it as Ctrl-C does; its exit code."""
        if self.process.poll() is None:
            self.process.terminate()
        return self.wait() if not self.process.stdout.closed else self.process.returncode
