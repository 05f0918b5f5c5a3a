"""Experiments with people, here simulated: from the graph to the table, through a crash and a replay, and blind."""
import csv
import json
import math
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

    def study(self, participant, *settings, graph=SIMULATED, more=()):
        return tactor("run", graph, "--out", self.folder / f"out_{participant}", "--overwrite", *more,
                      *self.options(participant, *settings), environment=self.environment)

    def assert_done(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_a_staircase_finds_the_threshold_and_its_table_tells_the_same(self):
        settings = (*SHORT, *ONE_CONDITION, "protocol.reversals=44", "protocol.averaged=40", "observer.slope=5")
        self.assert_done(self.study("P01", *settings))
        summary = json.loads((self.folder / "out_P01/summary.json").read_text())
        found = summary["experiment"]["threshold"]
        # 1 up, 3 down with these steps rests at 83.15 %: 1 - exp(-(x / 0.2)^5) = (0.8315 - 0.5) / 0.5. The spread of single
        # runs is 4 %.
        self.assertAlmostEqual(found / (0.2 * (-math.log(1 - 0.663)) ** 0.2), 1, delta=0.2)
        rows = rows_of(self.tables / "P01.csv")
        self.assertEqual(summary["experiment"]["trials"], len(rows))
        reversals, in_a_row, before = [], 0, 0
        for row in rows:
            self.assertEqual(row["correct"], "1" if row["response"] == row["comparison"] else "0")
            in_a_row = in_a_row + 1 if row["correct"] == "1" else 0
            direction = 1 if row["correct"] == "0" else -1 if in_a_row == 3 else 0
            in_a_row = 0 if direction else in_a_row
            if direction and before and direction != before:
                reversals.append(float(row["level"]))
            before = direction or before
        self.assertEqual(len(reversals), 44)
        self.assertAlmostEqual(math.exp(sum(map(math.log, reversals[-40:])) / 40), found, places=9)

    def test_what_is_felt_is_what_the_table_says(self):
        self.assert_done(self.study("P01", *ONE_CONDITION, "protocol.procedure=constant", "protocol.levels=[0.25, 1]", "protocol.repeats=2"))
        rows = rows_of(self.tables / "P01.csv")
        self.assertEqual(len(rows), 4)
        for row in rows:
            comparison, standard = (float(row[f"peak_{i}_N"]) for i in (row["comparison"], 3 - int(row["comparison"])))
            self.assertGreater(standard, 0.5)
            self.assertAlmostEqual(comparison / standard, 1 + float(row["level"]), places=4)

    def test_pairs_are_compared_and_have_no_right_answer(self):
        self.assert_done(self.study("P01", *SHORT, "observer.worths=[1, 1, 1, 1e9]", "trajectory.points=[{t: 0 s, z: 8 mm}]",
                                    "trajectory.repeat_after=0", graph=GRAPHS / "experiments/which_is_smoother.yaml",
                                    more=("--over", GRAPHS / "experiments/observer.yaml")))
        rows = rows_of(self.tables / "P01.csv")
        self.assertEqual(len(rows), 6 * 4)
        self.assertEqual({(row["level"], row["correct"], row["block"]) for row in rows}, {("0", "", "1")})
        for row in rows:
            # In a pair the comparison is the condition that the graph names first.
            self.assertLess(row["condition"], row["other"])
            if row["other"] == "D":
                self.assertNotEqual(row["response"], row["comparison"])

    @needs_hdf5
    def test_no_force_steps_while_a_hand_keeps_pressing(self):
        """A hand that never lifts off, though methods and stiffness change: what the device shows follows the ramps of the gain."""
        import h5py
        graph = self.write("pressing.yaml", f"""format: 2
extends: [{GRAPHS / "experiments/which_is_smoother.yaml"}, {GRAPHS / "experiments/observer.yaml"}]
duration: 40 s
nodes:
  trajectory: {{repeat_after: 0, tremor_amplitude: 0, points: [{{t: 0 s, z: 2 mm}}]}}
  protocol:
    conditions: {{A: select.use=first; coupling.k_0=400 N/m, B: select.use=fourth; coupling.k_0=1200 N/m, C: ~, D: ~}}
edges: [coupling.force -> protocol.force: ~]
record: [device.commanded, protocol.screen]
""")
        self.assert_done(self.study("P01", *SHORT, "protocol.interval=0.4 s", graph=graph))
        rows = rows_of(self.tables / "P01.csv")
        self.assertEqual(len(rows), 4)
        peaks = {(row["condition"] if row["comparison"] == i else row["other"]): float(row[f"peak_{i}_N"]) for row in rows for i in "12"}
        # The settings of the conditions are felt.
        self.assertGreater(peaks["B"], 1.3 * peaks["A"])
        with h5py.File(self.folder / "out_P01/recording.h5") as file:
            force = file["streams/device.commanded/data"]["force"][:, 2]
        force = force[1000:]
        steps = abs(force[1:] - force[:-1])
        # At 1 kHz: a ramp of 0.1 s is at most 1.5 F / 100 a tick. The rest is for the coupling and the change-over of select.
        self.assertGreater(max(force), 0.5)
        self.assertLess(max(steps), 0.025 * max(force))

    def test_participants_get_their_own_orders_and_the_same_code_the_same(self):
        settings = (*SHORT, "protocol.procedure=constant", "protocol.levels=[0.1, 0.4]", "protocol.repeats=2")
        for participant in ("P01", "P02", "Q01"):
            self.assert_done(self.study(participant, *settings))
        first, second, third = (rows_of(self.tables / f"{code}.csv") for code in ("P01", "P02", "Q01"))
        self.assertEqual({first[0]["condition"], second[0]["condition"]}, {"A", "B"})
        self.assertEqual([row["condition"] for row in first], [row["condition"] for row in third])
        self.assertNotEqual([(row["level"], row["comparison"]) for row in first], [(row["level"], row["comparison"]) for row in third])
        before = (self.tables / "P01.csv").read_bytes()
        (self.tables / "P01.csv").unlink()
        self.assert_done(self.study("P01", *settings))
        self.assertEqual((self.tables / "P01.csv").read_bytes(), before)

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

    def test_a_bad_study_is_refused_with_its_place(self):
        file = self.write("study.yaml", f"""format: 2
extends: {SIMULATED}
nodes:
  protocol:
    conditions:
      A: select.use=fifth
      B: select.blend_tim=1
      C: device.encoder_step=1 mm
    most: 12
    mute: gain.ramp
""")
        result = tactor("check", file)
        self.assertEqual(result.returncode, 2)
        for place, text in ((6, "fifth"), (7, 'select.blend_tim=1: the graph has no such parameter; did you mean "select.blend_time"?'),
                            (8, "device.encoder_step=1 mm: device.simulated reads it only at the start"),
                            (10, "gain.ramp=0: interpolation.gain reads it only at the start")):
            self.assertRegex(result.stderr, rf"study\.yaml:{place}:\d+: .*")
            self.assertIn(text, result.stderr)
        self.assertIn("expected a number from 0 to 10, found 13", result.stderr)
        for setting, text in (("protocol.participant=Anna", "never a name"), ("protocol.participant=Jan07", "one capital letter and then one to three digits"), ("protocol.steps=[]", "expected a list of steps"),
                              ("protocol.conditions.hold=select.use=first", "a letter and up to three digits"),
                              ("protocol.participant=P0 --set protocol.resume=true", "for practice")):
            result = tactor("check", SIMULATED, *words(*setting.split(" --set ")))
            self.assertEqual(result.returncode, 2, setting)
            self.assertIn(text, result.stderr)
        # A condition that no edge feeds is found before anything moves.
        file = self.write("unfed.yaml", f"format: 2\nextends: {SIMULATED}\nedges: [rollout.segment -> select.fourth: ~]\n")
        result = self.study("P01", graph=file)
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, r"stiffness_jnd\.yaml:\d+:\d+: nodes\.protocol\.conditions\.B: .*no edge ends at that input")

    def test_what_would_not_be_felt_as_it_is_set_is_refused_with_both_places(self):
        file = self.write("study.yaml", f"""format: 2
extends: {SIMULATED}
nodes:
  device: {{dead_man_button: 2}}
  gain: {{ramp: 0.8 s}}
  protocol:
    button_first: 1
    button_second: 2
    conditions:
      A: select.use=first; coupling.k_0=500 N/m
      B: select.use=fourth; coupling.k_0=2 N/mm
""")
        result = tactor("check", file)
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, r"study\.yaml:8:\d+: nodes\.protocol\.button_second: .*nodes\.device\.dead_man_button, .*study\.yaml:4:")
        self.assertRegex(result.stderr, r"simulated\.yaml:\d+:\d+: nodes\.protocol\.change: expected at least 800 ms, the ramp of gain .*study\.yaml:5:")
        file.write_text(file.read_text().replace("{dead_man_button: 2}", "{}").replace("0.8 s", "0.4 s"))
        for verb in (("check",), ("run", "--out", self.folder / "out")):
            result = tactor(verb[0], file, *verb[1:])
            self.assertEqual(result.returncode, 2)
            # 2000 N/m (50 g / 100 g)^0.5 = 1414 N/m.
            self.assertRegex(result.stderr, r"study\.yaml:11:\d+: nodes\.protocol\.conditions\.B: select\.use=fourth; coupling\.k_0=2 N/mm: .*k_device holds it at 1000")
        # With the limit out of the way, in the same condition, it is felt.
        file.write_text(file.read_text().replace("500 N/m", "500 N/m; coupling.k_device=1 N/mm").replace("2 N/mm", "2 N/mm; coupling.k_device=2 N/mm"))
        self.run_ok("check", file)

    def check_of(self, *lines, nodes=""):
        """`tactor check` of the simulated study with these lines of its protocol; the first two lines of conditions are A and B."""
        file = self.write("study.yaml", f"format: 2\nextends: {SIMULATED}\nnodes:\n{nodes}  protocol:\n" + "".join(f"    {line}\n" for line in lines))
        return tactor("check", file)

    def test_levels_that_a_limit_makes_alike_in_one_condition_are_refused(self):
        level = ("level: coupling.k_0", "unit: N/m", "standard: 500", "procedure: constant", "levels: [100, 700]")
        # At the tool's mass the coupling has 0.7071 k_0: 849 N/m at the largest level.
        good = self.check_of(*level, "conditions:", "  A: select.use=first; coupling.k_device=850 N/m",
                             "  B: select.use=fourth; coupling.k_device=900 N/m")
        self.assertEqual(good.returncode, 0, good.stderr)
        bad = self.check_of(*level, "conditions:", "  A: select.use=first; coupling.k_device=900 N/m",
                            "  B: select.use=fourth; coupling.k_device=840 N/m")
        self.assertEqual(bad.returncode, 2)
        self.assertRegex(bad.stderr, r"study\.yaml:12:\d+: nodes\.protocol\.conditions\.B: select\.use=fourth; coupling\.k_device=840 N/m; "
                                     r"coupling\.k_0=1200 N/m: .*k_device holds it at 840")
        self.assertNotIn("conditions.A:", bad.stderr)

    def test_settings_that_one_order_of_the_conditions_cannot_make_are_refused(self):
        low, high = ("coupling.k_min=100 N/m", "coupling.k_device=300 N/m"), ("coupling.k_device=600 N/m", "coupling.k_min=500 N/m")
        zeta = ("coupling.k_0=300 N/m", "coupling.k_0=800 N/m")

        def conditions(a, b):
            return "conditions:", f"  A: {'; '.join(a)}; {zeta[0]}", f"  B: {'; '.join(b)}; {zeta[1]}"
        good = self.check_of(*conditions(low, high))
        self.assertEqual(good.returncode, 0, good.stderr)
        # From B to A: its k_device would be below the k_min of B, which still holds.
        bad = self.check_of(*conditions(low[::-1], high))
        self.assertEqual(bad.returncode, 2)
        self.assertRegex(bad.stderr, r"study\.yaml:6:\d+: nodes\.protocol\.conditions\.A: .*k_min \(500\.0+\) is above k_device \(300\.0+\).*"
                                     r"coupling\.k_device=300 N/m is set after conditions\.B, .*another order")
        self.assertNotIn("conditions.B: coupling", bad.stderr)
        # From A to B.
        bad = self.check_of(*conditions(low, high[::-1]))
        self.assertRegex(bad.stderr, r"study\.yaml:7:\d+: nodes\.protocol\.conditions\.B: .*coupling\.k_min=500 N/m is set after conditions\.A")
        # What no order makes is refused as it is.
        bad = self.check_of(*conditions(low, ("coupling.k_device=600 N/m", "coupling.k_min=700 N/m")))
        self.assertEqual(bad.returncode, 2)
        self.assertNotIn("another order", bad.stderr)
        # And what is said to work does, whichever condition comes first.
        for participant in ("P01", "P02"):
            self.conditions_of_a_run(participant, conditions(low, high))
        first, second = (rows_of(self.tables / f"{code}.csv")[0]["condition"] for code in ("P01", "P02"))
        self.assertEqual({first, second}, {"A", "B"})

    def conditions_of_a_run(self, participant, conditions):
        self.assertEqual(self.check_of(*conditions).returncode, 0)
        self.assert_done(self.study(participant, *SHORT, "protocol.procedure=constant", "protocol.levels=[0.25]", "protocol.repeats=2",
                                    graph=self.folder / "study.yaml"))

    def test_a_limit_that_is_noted_in_the_graph_is_refused_where_the_value_it_holds_is_set(self):
        stiff = "  coupling: {k_0: 2 N/mm}\n"
        # 2 N/mm asks for 1414 N/m, which k_device holds at 1000: as 1.5 N/mm would be, which asks for 1061.
        bad = self.check_of("conditions:", "  A: coupling.k_0=2 N/mm", "  B: coupling.k_0=1 N/mm", nodes=stiff)
        self.assertEqual(bad.returncode, 2)
        self.assertRegex(bad.stderr, r"study\.yaml:7:\d+: nodes\.protocol\.conditions\.A: coupling\.k_0=2 N/mm: .*k_device holds it at 1000")
        self.assertNotIn("conditions.B:", bad.stderr)
        # The limit itself is felt as it is set.
        good = self.check_of("conditions:", "  A: coupling.k_device=0.8 N/mm", "  B: coupling.k_device=1 N/mm", nodes=stiff)
        self.assertEqual(good.returncode, 0, good.stderr)
        # And what is neither, and asks for more than the limit.
        bad = self.check_of("conditions:", "  A: coupling.m_0=1 g", "  B: coupling.m_0=100 g")
        self.assertEqual(bad.returncode, 2)
        self.assertRegex(bad.stderr, r"conditions\.A: coupling\.m_0=1 g: .*k_device holds it at 1000")

    def test_a_force_that_the_device_limits_is_in_the_table_and_told(self):
        limited = (*ONE_CONDITION, "protocol.procedure=constant", "protocol.levels=[1]", "protocol.repeats=2")
        self.assert_done(self.study("P01", *limited))
        free = rows_of(self.tables / "P01.csv")
        self.assertEqual({row[f"limited_{i}"] for row in free for i in "12"}, {"0"})
        most = max(float(row[f"peak_{row['comparison']}_N"]) for row in free)
        result = self.study("P02", *limited, f"device.force_max={0.6 * most} N")
        self.assert_done(result)
        for row in rows_of(self.tables / "P02.csv"):
            # The comparison is twice the standard, which is below the limit.
            self.assertGreater(float(row[f"limited_{row['comparison']}"]), 0)
            self.assertEqual(row[f"limited_{3 - int(row['comparison'])}"], "0")
            self.assertAlmostEqual(float(row[f"peak_{row['comparison']}_N"]) / (0.6 * most), 1, places=3)
        self.assertIn("in 2 trials the device displayed less force than was wanted", " ".join(result.stdout.split()))
        self.assertEqual(json.loads((self.folder / "out_P02/summary.json").read_text())["experiment"]["limited_trials"], 2)

    def test_a_run_under_the_virtual_clock_comes_out_the_same_however_often(self):
        settings = (*SHORT, "protocol.procedure=constant", "protocol.levels=[0.25]", "protocol.repeats=2")
        tables = []
        for _ in range(2):
            self.assert_done(self.study("P01", *settings))
            tables.append((self.tables / "P01.csv").read_bytes())
            (self.tables / "P01.csv").unlink()
        self.assertEqual(*tables)

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
