"""`tactor bridge` under the virtual clock: who is let in, what both sides say, and that no fault of a client harms the run."""
import contextlib
import csv
import io
import json
import pathlib
import re
import signal
import socket
import struct
import time
import unittest

from bridge_client import BINARY, EXAMPLE, STEP, TEXT, TOOL, Ball, Bridge, BridgeClient, packed, upgrade_lines
from harness import GRAPHS, ROOT, CommandTest, needs_hdf5, tactor
from websocket_client import Closed, read_head, request

GRAPH = EXAMPLE / "graph.yaml"
VIRTUAL = ("--set", "clock=virtual", "--duration", "1 s")
STREAMS = ("physics.state", "interpolation.segment", "device.commanded")


def contact(**changed):
    return {"p_WC": [0, 0, 0], "n_W": [0, 0, 1], "distance": 0.001, "weight": 1, "stiffness": 2000, "damping": 2,
            "friction": 0, **changed}


class BridgeTest(CommandTest):
    def bridge(self, *options, graph=GRAPH, out="out"):
        bridge = Bridge(graph, *VIRTUAL, "--out", self.folder / out, "--overwrite", *options, environment=self.environment)
        self.addCleanup(bridge.end)
        return bridge

    def figures(self, out="out"):
        return json.loads((self.folder / out / "bridge.json").read_text())

    def streams(self, out="out"):
        return {name: self.run_ok("export", self.folder / out / "recording.h5", name).stdout for name in STREAMS}

    def finish(self, bridge):
        self.assertEqual(bridge.wait(), 0, bridge.said + bridge.told)

    def undisturbed(self, packed=False, out="out", before=lambda: None):
        """The streams of a whole run, and the results that the client sent, by the end of their steps."""
        bridge, ball, sent = self.bridge(out=out), Ball(), {}
        client = bridge.client(packed)
        while (step := client.play(ball, until=lambda step: True)) is not None:
            before()
            result = ball.step(step)
            sent[step["end"]] = json.loads(json.dumps(result))
            client.answer(result)
        self.finish(bridge)
        return self.streams(out), sent


@needs_hdf5
class Steps(BridgeTest):
    def test_the_run_has_what_the_client_computed(self):
        streams, sent = self.undisturbed()
        rows = list(csv.DictReader(io.StringIO(streams["physics.state"])))
        self.assertGreater(len(rows), 90)
        for row in rows:
            tool = sent[round(float(row["valid_s"]) * 1e9)]
            self.assertEqual([float(row[f"p_WT_{axis} [m]"]) for axis in "xyz"], tool["tool"]["p_WT"])
            self.assertEqual(float(row["contact_force_z [N]"]), tool["contact"]["force"][2])
        self.assertGreater(max(float(row["contact_force_z [N]"]) for row in rows), 0.1)
        self.assertGreater(max(abs(float(row["force_z [N]"])) for row in csv.DictReader(io.StringIO(streams["device.commanded"]))), 0.1)
        # The results of the last period become visible after the end.
        self.assertLessEqual(len(sent) - len(rows), 1)

    def test_both_encodings_and_any_pace_give_the_same_bytes(self):
        by_text, _ = self.undisturbed()
        by_bytes, _ = self.undisturbed(packed=True, out="packed")
        slow = iter([0.5, 0.05])
        slowly, _ = self.undisturbed(out="slow", before=lambda: time.sleep(next(slow, 0)))
        self.assertEqual(by_text, by_bytes)
        self.assertEqual(by_text, slowly)
        self.assertGreater(len(by_text["interpolation.segment"]), 10_000)

    def test_a_client_may_change_its_encoding_with_each_frame(self):
        undisturbed, _ = self.undisturbed()
        bridge, ball = self.bridge(out="mixed"), Ball()
        client, last = bridge.client(), False
        with self.assertRaises((Closed, ConnectionError)):
            while True:
                message, was_packed = client.message()
                if message["type"] != "step":
                    continue
                self.assertEqual(was_packed, last)
                client.packed = last = not last
                client.answer(ball.step(message))
        self.finish(bridge)
        self.assertEqual(self.streams("mixed"), undisturbed)

    def test_steps_follow_one_another_and_hello_tells_the_scene(self):
        bridge, ball = self.bridge(), Ball()
        client = bridge.client()
        hello, _ = client.message()
        self.assertEqual((hello["type"], hello["protocol"], hello["clock"], hello["rate"], hello["tool"]), ("hello", 1, "virtual", 100, "ball"))
        self.assertEqual([(body["name"], body["mass"], body["motion"]) for body in hello["bodies"]], [("ball", 0.05, "translation")])
        before = None
        for _ in range(30):
            step = client.until("step")
            self.assertEqual(step["coupling"], hello["coupling"])
            if before:
                self.assertEqual((step["id"], step["begin"], step["from"]), (before["id"] + 1, before["end"], before["handle"]))
            self.assertGreater(step["end"], step["begin"])
            before = step
            client.answer(ball.step(step))
        client.play(ball)
        self.finish(bridge)
        self.assertIn("steps sent", bridge.said)
        self.assertIn("from result to run 50 % ", bridge.said)
        figures = self.figures()
        self.assertEqual((figures["results"], figures["refused"], figures["clients"]), (figures["steps"], 0, 1))
        self.assertLessEqual(figures["latency_us"]["p50"], figures["latency_us"]["max"])

    def test_contacts_and_bodies_reach_the_graph(self):
        graph = self.write("told.yaml", f"extends: {GRAPH}\nrecord: [physics.contacts, physics.bodies]\n")
        bridge, ball = self.bridge(graph=graph), Ball()
        client = bridge.client()
        for packed_now in (False, True):
            step = client.until("step")
            result = ball.step(step)
            client.packed = packed_now
            state = {name.replace("T", "B"): value for name, value in result["tool"].items()}
            client.answer({**result, "contacts": [contact(), contact(distance=-0.001, body=0)], "bodies": [state]})
        client.play(ball)
        self.finish(bridge)
        rows = list(csv.DictReader(io.StringIO(self.run_ok("export", self.folder / "out/recording.h5", "physics.contacts").stdout)))
        self.assertEqual([(row["count [1]"], row["penetrating [1]"]) for row in rows], [("2", "1"), ("2", "1")])


@needs_hdf5
class Faults(BridgeTest):
    def faults(self, result):
        """What a client may send in the place of that result: a name, the frame, and the field that the refusal names."""
        def changed(**fields):
            return {**result, **fields}

        def tool(**fields):
            return changed(tool={**result["tool"], **fields})

        def text(message):
            return TEXT, json.dumps(message).encode()

        def binary(message):
            return BINARY, packed(message)
        nan = float("nan")
        body = {"p_WB": [0, 0, 0], "R_WB": [1, 0, 0, 0], "v_WB": [0, 0, 0], "w_WB": [0, 0, 0]}
        yield "NaN in bytes", binary(tool(p_WT=[nan, 0, 0])), "tool.p_WT"
        yield "infinity in bytes", binary(changed(contact={"force": [0, 0, float("inf")], "torque": [0, 0, 0]})), "contact.force"
        yield "NaN in a text", text(tool(p_WT=[nan, 0, 0])), ""
        yield "a number beyond all", (TEXT, json.dumps(result).replace('"p_WT": [', '"p_WT": [1e999, ').encode()), ""
        yield "a long quaternion", text(tool(R_WT=[2, 0, 0, 0])), "tool.R_WT"
        yield "4,000 contacts", text(changed(contacts=[contact()] * 4000)), "contacts"
        yield "5,000 contacts in bytes", binary(changed(contacts=[contact()] * 5000)), "contacts"
        yield "10,000 contacts, too large a frame", binary(changed(contacts=[contact()] * 10_000)), ""
        yield "a contact of a body that is not there", text(changed(contacts=[contact(), contact(body=1)])), "contacts[1].body"
        yield "a point that is not where the contact is", binary(changed(contacts=[contact(p_TC=[0, 0, 1])])), "contacts[0].p_TC"
        yield "five of six numbers", text(changed(contacts=[contact(H_W=[0] * 5)])), "contacts[0].H_W"
        yield "NaN at the wall in bytes", binary(changed(contacts=[contact(p_WC=[nan, 0, 0])])), "contacts[0].p_WC"
        yield "an inertia below zero", text(changed(contacts=[contact(inertia=-1)])), "contacts[0].inertia"
        yield "a lift above one in bytes", binary(changed(contacts=[contact(lift=2)])), "contacts[0].lift"
        yield "a rotation without angular velocity", text(changed(tool={k: v for k, v in result["tool"].items() if k != "w_WT"})), "tool.w_WT"
        yield "a field twice", (TEXT, json.dumps(result).replace('"id"', '"id": 1, "id"').encode()), "id"
        yield "100 fields", text(changed(**{f"f{i}": 0 for i in range(100)})), ""
        yield "two bodies", text(changed(bodies=[body, body])), "bodies"
        yield "no body", binary(changed(bodies=[])), "bodies"
        yield "no tool", text({"type": "result", "id": result["id"]}), "tool"
        yield "no number", text(tool(v_WT=["fast", 0, 0])), "tool.v_WT"
        yield "an unknown field", text(changed(tol=1)), "tol"
        yield "no JSON", (TEXT, b'{"type": "result", '), ""
        yield "another type", text({"type": "shutdown"}), "type"
        yield "no message", (BINARY, b""), ""
        yield "half a result", (BINARY, packed(result)[:100]), ""
        yield "a time to come", text(changed(time=10**12)), "time"
        yield "a frame of 2 MiB", (TEXT, b" " * (2 << 20)), ""
        yield "bytes of 2 MiB", (BINARY, bytes(2 << 20)), ""

    def disturbed(self, frame_of, out):
        """A run in which every second result from the twentieth on is another frame, as long as there is one."""
        bridge, ball = self.bridge(out=out), Ball()
        client = bridge.client()
        count = 0
        step = client.play(ball, lambda message: message["id"] == 20)
        while step is not None:
            found = frame_of(ball.step(step), count)
            if found is None:
                break
            name, (opcode, payload), field = found
            with self.subTest(name):
                client.send_frame(opcode, payload)
                error, was_packed = client.message()
                self.assertEqual(error["type"], "error")
                self.assertEqual(error["field"], field, error)
                self.assertGreater(len(error["message"]), 10)
                self.assertEqual(was_packed, opcode == BINARY)
            count += 1
            # The next step comes in the kind of the refused frame.
            client.packed = opcode == BINARY
            step = client.until("step")
            client.packed = False
            client.answer(ball.step(step))
            step = client.play(ball, lambda message: True)
        if step is not None:
            client.answer(ball.step(step))
            client.play(ball)
        self.finish(bridge)
        figures = self.figures(out)
        self.assertEqual((figures["refused"], figures["steps"] - figures["results"], figures["clients"]), (count, count, 1))
        return count

    def test_a_frame_that_is_refused_is_told_and_changes_nothing(self):
        def fault(result, index):
            every = list(self.faults(result))
            return every[index] if index < len(every) else None

        count = self.disturbed(fault, "faults")
        self.assertGreater(count, 15)
        # The same steps are answered by nothing that is a message at all.
        self.disturbed(lambda result, index: ("x", (TEXT, b"x"), "") if index < count else None, "nothing")
        self.assertEqual(self.streams("faults"), self.streams("nothing"))

    def test_a_result_of_another_step_leaves_the_open_one_open(self):
        undisturbed, _ = self.undisturbed()
        bridge, ball = self.bridge(out="old"), Ball()
        client = bridge.client()
        step = client.play(ball, lambda message: message["id"] == 20)
        result = ball.step(step)
        for wrong in (19, 21, 0, 2**63):
            client.answer({**result, "id": wrong})
            error = client.until("error")
            self.assertEqual(error["field"], "id")
            self.assertIn("step 20", error["message"])
        client.answer(result)
        client.play(ball)
        self.finish(bridge)
        self.assertEqual(self.streams("old"), undisturbed)
        self.assertEqual(self.figures("old")["refused"], 4)

    def test_a_ball_that_turns_needs_its_rotation(self):
        graph = self.write("turns.yaml", f"extends: {GRAPH}\nscene: {{bodies: {{ball: {{motion: rigid}}}}}}\n")
        bridge, ball = self.bridge(graph=graph), Ball()
        client = bridge.client()
        for packed_now in (False, True):
            result = ball.step(client.until("step"))
            client.packed = packed_now
            client.answer({**result, "tool": {name: result["tool"][name] for name in ("p_WT", "v_WT")}})
            error, _ = client.message()
            self.assertEqual((error["type"], error["field"]), ("error", "tool.R_WT"))
            self.assertIn("rotation", error["message"])
        client.play(ball)
        self.finish(bridge)
        self.assertEqual(self.figures()["refused"], 2)

    def test_a_client_that_hangs_after_a_wrong_answer_gives_way(self):
        bridge, ball = self.bridge(), Ball()
        first = bridge.client()
        step = first.play(ball, lambda message: message["id"] == 10)
        first.answer({**ball.step(step), "id": 9})
        first.until("error")
        second = bridge.client_when_free()
        self.assertEqual(second.until("step")["id"], 10)
        second.ask()
        second.play(ball)
        self.finish(bridge)

    def test_a_client_that_dies_is_replaced_within_its_step(self):
        undisturbed, _ = self.undisturbed()
        for how in ("closes", "resets"):
            with self.subTest(how):
                bridge, ball = self.bridge(out=how), Ball()
                client = bridge.client()
                step = client.play(ball, lambda message: message["id"] == 40)
                if how == "resets":
                    client.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                client.close()
                client = bridge.client_when_free()
                self.assertEqual(client.message()[0]["type"], "hello")
                again, _ = client.message()
                self.assertEqual(again, step)
                client.answer(ball.step(again))
                client.play(ball)
                self.finish(bridge)
                self.assertEqual(self.streams(how), undisturbed)
                self.assertEqual(self.figures(how)["clients"], 2)

    def test_two_clients_are_one_too_many_until_the_first_is_silent(self):
        bridge, ball = self.bridge(), Ball()
        first = bridge.client()
        first.play(ball, lambda message: message["id"] == 10)
        with self.assertRaises(Closed) as refused:
            bridge.client()
        self.assertEqual(refused.exception.code, 503)
        second = bridge.client_when_free()
        self.assertEqual(second.until("step")["id"], 10)
        with self.assertRaises((Closed, ConnectionError)):
            first.message()
        second.ask()
        second.play(ball)
        self.finish(bridge)

    def test_next_repeats_the_step_in_the_other_encoding(self):
        bridge, ball = self.bridge(), Ball()
        client = bridge.client()
        step = client.until("step")
        client.packed = True
        client.ask()
        again = client.until("step")
        self.assertEqual(again, step)
        client.answer(ball.step(again))
        client.play(ball)
        self.finish(bridge)


@needs_hdf5
class Doors(BridgeTest):
    """Who is let in, while the run waits for its client."""

    def upgrade(self, bridge, lines):
        connection = request(bridge.port, lines)
        with contextlib.closing(connection), contextlib.suppress(ConnectionError):
            return read_head(connection)[0]
        return None

    def test_only_a_program_with_the_token_is_let_in(self):
        bridge = self.bridge("--token", "a-token-of-our-own")
        self.assertEqual(bridge.token, "a-token-of-our-own")
        host = f"127.0.0.1:{bridge.port}"
        for status, given in ((401, {"protocols": ""}), (401, {"protocols": "tactor.bridge"}), (401, {"protocols": f"tactor.view, token.{bridge.token}"}),
                              (401, {"protocols": "tactor.bridge, token.a-token-of-our-owm"}), (401, {"protocols": "tactor.bridge, token."}),
                              (403, {"origin": "http://example.org"}), (403, {"origin": "null"}), (403, {"origin": f"https://{host}"}),
                              (421, {"host": "example.org"}), (421, {"host": f"10.0.0.7:{bridge.port}"}), (404, {"path": "/stream"})):
            with self.subTest(given):
                self.assertEqual(self.upgrade(bridge, upgrade_lines(bridge.port, bridge.token, **given)), status)
        self.assertEqual(self.upgrade(bridge, ["GET /bridge HTTP/1.1", f"Host: {host}"]), 426)
        self.assertEqual(self.upgrade(bridge, ["GET /bridge HTTP/1.1", f"Host: {host}", "X: " + "x" * 10_000]), None)
        self.assertEqual(BridgeClient(bridge.port, bridge.token, origin=f"http://{host}").message()[0]["type"], "hello")

    def test_it_listens_on_this_machine_alone(self):
        bridge = self.bridge()
        self.assertRegex(bridge.token, "^[0-9a-f]{32}$")
        lines = [line.split() for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]]
        self.assertEqual({line[1] for line in lines if line[3] == "0A" and line[1].endswith(f":{bridge.port:04X}")}, {f"0100007F:{bridge.port:04X}"})

    def test_strangers_who_say_nothing_keep_nobody_out(self):
        bridge = self.bridge()
        strangers = [socket.create_connection(("127.0.0.1", bridge.port)) for _ in range(100)]
        self.assertEqual(bridge.client().message()[0]["type"], "hello")
        for stranger in strangers:
            stranger.close()

    def test_waiting_for_a_client_takes_no_processor(self):
        bridge = self.bridge()

        def seconds():
            fields = pathlib.Path(f"/proc/{bridge.process.pid}/stat").read_text().rpartition(")")[2].split()
            return (int(fields[11]) + int(fields[12])) / 100
        for asked in (False, True):
            with self.subTest(asked=asked):
                if asked:
                    client = bridge.client()
                    client.until("step")
                before = seconds()
                time.sleep(2)
                self.assertLess(seconds() - before, 1)

    def test_ctrl_c_ends_a_run_that_waits(self):
        bridge = self.bridge()
        bridge.process.send_signal(signal.SIGINT)
        self.assertEqual(bridge.wait(), 1)
        self.assertTrue((self.folder / "out/summary.json").exists())
        self.assertEqual(self.figures()["steps"], 0)

    def test_what_the_command_refuses(self):
        taken = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(taken.close)
        port = taken.getsockname()[1]
        (self.folder / "out").mkdir()
        self.write("out/keep", "")
        for options, says in ((("--token", "short"), "--token: expected 16 to 128 letters"), (("--token", "with a blank in it"), "--token"),
                              (("--listen", "localhost"), "--listen: expected an IPv4 address"), (("--listen", "203.0.113.1"), "203.0.113.1"),
                              (("--port", port), f"port {port} of 127.0.0.1"), (("--port", "70000"), "--port")):
            with self.subTest(options):
                done = tactor("bridge", GRAPH, *VIRTUAL, "--out", self.folder / "out", *options, environment=self.environment)
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(says, done.stderr)
        done = tactor("bridge", GRAPHS / "wall/scene.yaml", "--out", self.folder / "out", environment=self.environment)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn("physics.external", done.stderr)
        self.assertTrue((self.folder / "out/keep").exists())
        self.assertFalse((self.folder / "out/summary.json").exists())


@needs_hdf5
class Documents(BridgeTest):
    def test_the_page_lists_every_packed_number_at_its_place(self):
        client = self.bridge().client()
        layouts = client.message()[0]["layouts"]
        page = (ROOT / "docs/howto/bridge.md").read_text()
        for name, layout in layouts.items():
            with self.subTest(name):
                part = page.partition(f"### Packed: {name}\n")[2].partition("\n#")[0]
                listed = re.findall(r"^\| (\d+) \| `([\w.]+)` \| (\d+) (f64|i64|u64) \|", part, re.MULTILINE)
                self.assertEqual(listed, [(str(field["offset"]), field["name"], str(field["count"]), field["type"]) for field in layout["fields"]])
                self.assertIn(f"{layout['bytes']} bytes", part)
        self.assertEqual(layouts["step"]["bytes"], STEP.size)
        self.assertEqual(layouts["body"]["bytes"], TOOL.size)


if __name__ == "__main__":
    unittest.main()
