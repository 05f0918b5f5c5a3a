"""Experiments with people, here simulated: from the graph to the table, through a crash and a replay, and blind."""
import csv
import json
import os
import signal
import subprocess
import unittest

from harness import GRAPHS, TACTOR, CommandTest, Terminal, needs_hdf5, needs_live, needs_view, tactor
from view_client import Closed, View

SIMULATED = GRAPHS / "experiments/simulated.yaml"
# The local rollout alone: its force depends on nothing that is drawn.
ONE_CONDITION = ("protocol.conditions.A=select.use=fourth", "protocol.conditions.B=~")
SHORT = ("protocol.interval=0.1 s", "protocol.change=0.15 s", "observer.response_time=30 ms")
# What the page and the terminal must not tell.
TELLING = ("select", "fourth", "rollout", "local", "prediction")


def rows_of(file):
    with open(file, newline="") as table:
        return list(csv.DictReader(table))


def words(*settings):
    return [word for setting in settings for word in ("--set", setting)]


class Simulated(CommandTest):
    def setUp(self):
        super().setUp()
        self.tables = self.folder / "tables"

    def options(self, participant, *settings):
        return words(f"protocol.folder={self.tables}", f"protocol.participant={participant}", *settings)

    def study(self, participant, *settings, more=()):
        return tactor("run", SIMULATED, "--out", self.folder / f"out_{participant}", "--overwrite", *more,
                      *self.options(participant, *settings), environment=self.environment)

    def assert_done(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_neither_terminal_nor_table_tells_what_was_on(self):
        result = self.study("P01", *SHORT, "protocol.procedure=constant", "protocol.levels=[0.4]", "protocol.repeats=2")
        self.assert_done(result)
        table = (self.tables / "P01.csv").read_text()
        for word in TELLING:
            self.assertNotIn(word, result.stdout + result.stderr)
            self.assertNotIn(word, table)

    def test_a_crash_loses_no_row_and_resume_goes_on(self):
        settings = (*SHORT, "protocol.procedure=constant", "protocol.levels=[0.1, 0.2, 0.4]", "protocol.repeats=3000")
        file = self.tables / "P01.csv"
        process = subprocess.Popen([TACTOR, "run", SIMULATED, "--out", self.folder / "out", *self.options("P01", *settings)],
                                   env=dict(os.environ, **self.environment), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.wait_until(lambda: file.exists() and file.read_text().count("\n") > 15, process, "it had made 15 trials")
        process.send_signal(signal.SIGKILL)
        process.wait()
        text = file.read_text()
        complete = text[:text.rfind("\n") + 1]
        refused = self.study("P01", *settings)
        self.assertEqual(refused.returncode, 2)
        self.assertIn(f"{file} exists", refused.stderr)
        self.assertEqual(file.read_text(), text)
        # As a crash in the middle of a row would leave it.
        file.write_text(complete + "17,1,1,A")
        self.assert_done(self.study("P01", *settings, "protocol.resume=true", more=("--duration", "12 s")))
        rows = rows_of(file)
        done = complete.count("\n") - 1
        self.assertTrue(file.read_text().startswith(complete))
        self.assertGreater(len(rows), done)
        self.assertEqual([int(row["trial"]) for row in rows], list(range(1, len(rows) + 1)))
        self.assertEqual([row["run"] for row in rows], ["1"] * done + ["2"] * (len(rows) - done))
        # The graph goes on with its own table alone.
        other = self.study("P01", *settings, "protocol.levels=[0.1, 0.3]", "protocol.resume=true")
        self.assertEqual(other.returncode, 2)
        self.assertIn("another design and cannot be continued: levels differ", other.stderr)
        # What changes no trial that was made is another design too.
        other = self.study("P01", *settings, "protocol.interval=0.2 s", "protocol.resume=true")
        self.assertEqual(other.returncode, 2)
        self.assertIn("cannot be continued: interval differ", other.stderr)
        self.assertEqual(rows_of(file), rows)

    def test_only_a_run_writes_a_table(self):
        """A study that moves bodies and is judged, with a real code: no other verb leaves a table, and none touches one that is there."""
        graph = self.write("study.yaml", f"""format: 2
extends: [{GRAPHS / "wall/scene.yaml"}, {GRAPHS / "experiments/observer.yaml"}]
duration: 1 s
nodes:
  gain: {{type: interpolation.gain, factor: 0}}
  protocol:
    {{type: experiment.protocol, participant: P01, folder: {self.tables}, mute: gain.factor, level: gain.factor, procedure: constant,
     levels: [0.25], repeats: 2, interval: 0.1 s, change: 0.15 s, end_run: false}}
  observer: {{response_time: 30 ms}}
edges:
  - interpolation.segment -> device.segment: ~
  - interpolation.segment -> gain.force
  - gain.segment -> device.segment
""")
        study = self.write("grid.yaml", f"format: 2\ngraphs: [{graph}]\nvary: {{protocol.interval: [0.1 s, 0.12 s]}}\nseeds: 1\n")
        verbs = [("check", "--explain", graph), ("compare", graph, graph, "--seeds", "1", "--out", self.folder / "compare"),
                 ("lean", graph, "--budget", "0.5", "--repeats", "1", "--out", self.folder / "lean.yaml"),
                 ("study", study, "--out", self.folder / "study")]
        for there in (None, b"a table of somebody"):
            if there:
                self.tables.mkdir()
                (self.tables / "P01.csv").write_bytes(there)
            for number, verb in enumerate(verbs):
                result = tactor(*verb, *(("--overwrite",) if there and number else ()), environment=self.environment)
                self.assertEqual(result.returncode, 0, f"{verb[0]}: {result.stdout}{result.stderr}")
                self.assertNotIn("exists", result.stderr)
                if there:
                    self.assertEqual((self.tables / "P01.csv").read_bytes(), there, verb[0])
                else:
                    self.assertFalse(self.tables.exists(), verb[0])
        (self.tables / "P01.csv").unlink()
        self.run_ok("run", graph, "--out", self.folder / "run")
        self.assertGreater(len((self.tables / "P01.csv").read_text().splitlines()), 0)

    @needs_live
    def test_the_live_terminal_of_a_study_tells_no_condition(self):
        terminal = Terminal("run", SIMULATED, "--out", self.folder / "out", "--all",
                            *self.options("P01", *SHORT, "clock=real", "protocol.procedure=constant", "protocol.levels=[0.25]", "protocol.repeats=2",
                                          "live.on_missing_privilege=warn"), environment=self.environment)
        self.assertEqual(terminal.finish(), 0, terminal.text)
        self.assertIn("wake-up", terminal.text)
        self.assertIn("the run was blind", terminal.text)
        for word in (*TELLING, "sample to force", "age p50", "steps/s"):
            self.assertNotIn(word, terminal.text)

    @needs_live
    @needs_hdf5
    def test_a_live_run_is_made_again_and_writes_no_table(self):
        settings = (*SHORT, *ONE_CONDITION, "clock=real", "protocol.procedure=constant", "protocol.levels=[0.25]", "protocol.repeats=2",
                    "live.on_missing_privilege=warn")
        self.assert_done(self.study("P01", *settings))
        table = (self.tables / "P01.csv").read_bytes()
        self.assertEqual(len(rows_of(self.tables / "P01.csv")), 2)
        recording = self.folder / "out_P01/recording.h5"
        self.run_ok("replay", recording, "--out", self.folder / "again")
        self.assertEqual((self.tables / "P01.csv").read_bytes(), table)
        import h5py
        with h5py.File(recording) as first, h5py.File(self.folder / "again/recording.h5") as second:
            rows = [file["streams/protocol.row/data"][...] for file in (first, second)]
        self.assertEqual(len(rows[0]), 2)
        self.assertEqual(rows[0].tobytes(), rows[1].tobytes())


@needs_live
@needs_view
class Seen(CommandTest):
    """A page of the experiment: what it is told, and that it answers."""

    def test_a_page_answers_and_is_told_nothing(self):
        tables = self.folder / "tables"
        settings = words(f"protocol.folder={tables}", "protocol.participant=P01", "protocol.procedure=constant", "protocol.levels=[0.25]",
                         "protocol.repeats=1", "protocol.interval=0.1 s", "protocol.change=0.15 s", *ONE_CONDITION)
        with View(TACTOR, GRAPHS / "experiments/stiffness_jnd.yaml", *settings) as view:
            page = view.page()
            hello = page.hello
            self.assertEqual(hello["experiment"], {"answer": "protocol.answer"})
            self.assertEqual([one["name"] for one in hello["parameters"]], ["protocol.answer"])
            self.assertEqual({stream["role"] for stream in hello["streams"]}, {"body", "handle", "safety", "commanded", "experiment"})
            for key in ("nodes", "edges"):
                self.assertEqual(hello[key], [])
            self.assertNotIn("methods", hello)
            for word in TELLING:
                self.assertNotIn(word, json.dumps(hello))
            page.wait_for(lambda p: p.stream("experiment"))
            page.say(type="set", parameter="select.use", value="first")
            page.wait_for(lambda p: p.last("refused"))
            self.assertIn("blind", page.last("refused")["message"])

            def phase(page):
                return page.stream("experiment")[-1][1][0]
            self.assertEqual(phase(page), 0)
            page.say(type="set", parameter="protocol.answer", value="first")
            page.wait_for(lambda p: phase(p) == 5)
            page.say(type="set", parameter="protocol.answer", value="second")
            try:
                page.wait_for(lambda p: p.last("ended"))
            except Closed:
                pass  # the server ends right after its last word
            self.assertIn("ended", page.last("ended")["why"])
            page.close()
            told = [text for text in page.texts if text["type"] not in ("hello", "refused")]
            for word in TELLING:
                self.assertNotIn(word, json.dumps(told))
        row, = rows_of(tables / "P01.csv")
        self.assertEqual((row["trial"], row["response"]), ("1", "2"))

    def test_a_page_is_not_told_why_a_run_fails_and_the_terminal_is(self):
        """A force that muting does not take away: the protocol looks at that of the scene, and the tool is held in the wall."""
        graph = self.write("unmuted.yaml", f"""format: 2
extends: {GRAPHS / "experiments/stiffness_jnd.yaml"}
edges:
  - device.commanded -> protocol.felt: ~
  - coupling.force -> protocol.felt
""")
        with View(TACTOR, graph, *words("protocol.change=0.15 s")) as view:
            page = view.page()
            x, y, z = page.hello["device"]["start"][:3]
            page.cursor([x, y, z], False)
            for step in range(40):
                page.cursor([x, y, z - 0.022 * step / 40], True)
                page.take_for(0.016)
            pressing = ([x, y, z - 0.022], True)
            # Its force is felt nowhere, so that the handle gets all the way.
            page.wait_for(lambda p: p.stream("handle")[-1][1][2] < z - 0.02, cursor=pressing)
            page.say(type="set", parameter="protocol.answer", value="first")
            try:
                page.wait_for(lambda p: p.last("ended"), cursor=pressing)
            except (Closed, BrokenPipeError, ConnectionResetError):
                pass  # the server ends right after its last word
            self.assertEqual(page.last("ended")["why"], "the run has failed; call the experimenter")
            self.assertNotIn("gain", json.dumps([text for text in page.texts if text["type"] not in ("hello", "refused")]))
            page.close()
            _, said = view.process.communicate(timeout=30)
            self.assertEqual(view.process.returncode, 1)
            self.assertIn("trial 1, interval 1: gain.factor=0 does not take the force away", said)

    def test_a_button_that_holds_the_mouse_does_not_answer(self):
        """The button that takes hold of the tool on the page is the first button of device.mouse."""
        result = tactor("view", GRAPHS / "experiments/stiffness_jnd.yaml", "--no-open", *words("protocol.button_first=1", "protocol.button_second=2"),
                        environment=self.environment)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("nodes.protocol.button_first", result.stderr)
        self.assertIn("dead-man button of device.mouse (nodes.device.dead_man_button", result.stderr)


if __name__ == "__main__":
    unittest.main()
