"""Nodes that are classes in Python files: the same bytes as in C++, errors with their lines, a safe end."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "command"))
from harness import IS_SANITIZED, PRESSED_WALL, ROOT, CommandTest, needs_hdf5, needs_live, tactor  # noqa: E402

if IS_SANITIZED:
    print("a Python that is not sanitized leaks by their measure")
    sys.exit(77)

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
EXAMPLE = ROOT / "examples" / "python_node"
# A predictor that holds, with a place for what goes wrong.
HOLD = '''import tactor


class Hold(tactor.Node):
    """Holds the force."""

    force = tactor.Input("Wrench", trigger=True, queue=64, doc="the physics force")
    forecast = tactor.Output("Forecast", doc="the same again")
    gain = tactor.Parameter(1.0, min=0, max=2, doc="the force is multiplied by it")

    def step(self, step):
        for sample in self.force.new():
            made = self.forecast.zeros()
            made["current_force"] = self.gain * sample["force"]
            made["predicted"]["force"][:] = made["current_force"]
            made["count"], made["horizon"] = 4, 0.01
            self.forecast.send(sample["valid_ns"], made)
'''
WALL = "extends: wall/scene.yaml\nduration: 1 s\nrecord: [%s]\nnodes:\n  metrics: ~\n  prediction: {%s}\n"
# A hand that a node in Python leads, so that the reference run depends on it.
HAND = '''import numpy as np

import tactor
%s

class Hand(tactor.Node):
    """Presses."""

    role = "source"
    rate = tactor.Rate(1000.0)
    target = tactor.Output("Target", doc="where the hand is to be")

    def step(self, step):
        made = self.target.zeros()
        made["p_WH"][2] = 0.01 - %s * min(step.now, 0.5)
        made["R_WH"][0] = 1
        self.target.send(step.now_ns, made)
'''

# A stage that reaches a new factor in two seconds, as it says.
SLOW = '''import tactor


class Slow(tactor.Node):
    """Scales the force slowly."""

    force = tactor.Input("ForceSegment", trigger=True, doc="the force")
    segment = tactor.Output("ForceSegment", doc="the same, scaled")
    factor = tactor.Parameter(1.0, min=0, max=10, tunable=True, doc="the factor")
    ramp = tactor.Parameter(2.0, unit="s", %s doc="the time in which a new factor is reached")

    def step(self, step):
        pass
'''


def streams(recording):
    """The bytes of every stream."""
    import h5py

    with h5py.File(recording) as file:
        return {name: file["streams"][name]["data"][...].tobytes() for name in file["streams"]}


class NodesInPython(CommandTest):
    def hold(self, name="hold.py", **changes):
        text = HOLD
        for old, new in changes.values():
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write(name, text)

    def wall(self, node="python: 'hold.py:Hold'", record="device.commanded"):
        return self.write("wall.yaml", WALL % (record, node))

    def refused(self, *parts, verb="check", graph=None, code=2):
        found = tactor(verb, graph or self.wall(), environment=self.environment)
        self.assertEqual(found.returncode, code, found.stdout + found.stderr)
        for part in parts:
            self.assertIn(part, found.stderr)
        return found.stderr

    @needs_hdf5
    def test_a_predictor_in_python_gives_the_bytes_of_its_twin(self):
        twin = self.write("twin.yaml", f"extends: {EXAMPLE / 'wall.yaml'}\n"
                                       "nodes: {prediction: {type: prediction.linear}}\n")
        for seed in (1, 2):
            found = {}
            for name, graph in (("python", EXAMPLE / "wall.yaml"), ("cpp", twin)):
                self.run_graph(graph, "--seed", str(seed), "--set", "nodes.metrics=~", out=f"{name}_{seed}")
                found[name] = streams(self.folder / f"{name}_{seed}" / "recording.h5")
            self.assertEqual(sorted(found["cpp"]), ["coupling.force", "device.commanded", "prediction.forecast"])
            for stream, data in found["cpp"].items():
                self.assertGreater(len(data), 10_000, stream)
                self.assertEqual(found["python"][stream], data, stream)

    def test_an_experiment_waits_for_the_ramp_that_a_node_declares(self):
        self.write("slow.py", SLOW % "ramp=True,")
        graph = self.write("study.yaml", "extends: experiments/simulated.yaml\nnodes: {gain: {python: 'slow.py:Slow'}}\n")
        self.refused("nodes.protocol.change: expected at least 2 s, the ramp of gain", graph=graph)
        self.write("slow.py", SLOW.replace('unit="s", %s', "ramp=True,"))
        self.refused('ramp is for a float with unit="s"', graph=graph)

    @needs_hdf5
    def test_a_recorded_graph_runs_again(self):
        self.hold()
        graph = self.wall()
        self.run_graph(graph, out="first")
        self.run_graph(self.folder / "first" / "graph.yaml", out="second")
        first, second = (streams(self.folder / out / "recording.h5") for out in ("first", "second"))
        self.assertEqual(first, second)

    def test_workers_of_a_comparison_run_it(self):
        twin = self.write("twin.yaml", f"extends: {EXAMPLE / 'wall.yaml'}\n"
                                       "nodes: {prediction: {type: prediction.linear}}\n")
        self.run_ok("compare", EXAMPLE / "wall.yaml", twin, "--seeds", "2", "--duration", "3", "--judge", "whole",
                    "--out", self.folder / "cmp")
        python, cpp = json.loads((self.folder / "cmp" / "compare.json").read_text())["graphs"]
        self.assertIn("delivered.force.rms_error_N", python["metrics"])
        for name in python["metrics"]:
            if not name.startswith(("cost_us", "cpu", "method_us", "fallbacks", "prediction.", "wall")):
                self.assertEqual(python["metrics"][name], cpp["metrics"][name], name)

    def test_help_and_plan_come_from_the_declaration(self):
        self.hold()
        shown = self.run_ok("nodes", f"{self.folder / 'hold.py'}:Hold").stdout
        for text in ("python.Hold: Holds the force.", "force (Wrench;", "the physics force", "forecast (Forecast)",
                     "gain (number; default 1; >= 0, <= 2)", "the force is multiplied by it"):
            self.assertIn(text, shown)
        self.assertIn("python.Hold", self.run_ok("check", self.wall(), "--explain").stdout)

    def test_a_graph_without_python_loads_none(self):
        found = tactor("check", self.wall("type: prediction.hold"), environment={**self.environment, "LD_DEBUG": "files"})
        self.assertIn("libtactor_prediction", found.stderr)
        self.assertNotIn("python", found.stderr)

    def test_what_it_prints_goes_to_the_error_output(self):
        self.hold(say=("        for sample", "        print('hello from the node')\n        for sample"))
        found = self.run_ok("run", self.wall(), "--out", self.folder / "out")
        self.assertIn("hello from the node", found.stderr)
        self.assertNotIn("hello from the node", found.stdout)

    def test_an_exception_ends_the_run_with_its_traceback(self):
        file = self.hold(fail=("        for sample", "        if step.now > 0.5:\n            1 / 0\n        for sample"))
        said = self.refused("node prediction failed at 0.5", "Traceback (most recent call last)", f'{file}", line 13',
                            "1 / 0", "ZeroDivisionError: division by zero", verb="run", code=1)
        self.assertNotIn("_node_class.py", said)

    def test_an_exception_of_init_ends_the_run_with_its_traceback(self):
        self.hold(fail=("    def step", "    def __init__(self):\n        self.missing.value\n\n    def step"))
        self.refused("node prediction", "cannot be made", "line 12", "AttributeError", verb="run", code=1)

    @needs_live
    @needs_hdf5
    def test_live_an_exception_leaves_the_device_at_zero(self):
        import h5py

        file = self.hold(fail=("        for sample", "        if step.now > 1:\n            1 / 0\n        for sample"))
        scene = PRESSED_WALL % {"duration": "3 s", "device": "type: device.simulated", "height": "2 mm"}
        scene = scene.replace("nodes:", "nodes:\n  trajectory: {type: source.trajectory, points: [{t: 0 s, z: 2 mm}]}")
        scene = scene.replace("edges:", "edges:\n  - trajectory.target -> device.target")
        scene = scene.replace("{type: prediction.hold}", "{python: 'hold.py:Hold'}")
        graph = self.write("live.yaml", scene)
        found = tactor("run", graph, "--out", self.folder / "out", environment=self.environment)
        self.assertEqual(found.returncode, 1, found.stdout + found.stderr)
        for text in ("node prediction failed at 1.", f'{file}", line 13', "ZeroDivisionError"):
            self.assertIn(text, found.stderr)
        with h5py.File(self.folder / "out" / "recording.h5") as recording:
            force = recording["streams/device.commanded/data"]["force"]
        self.assertGreater(abs(force).max(), 0.1)
        self.assertEqual(abs(force[-1]).max(), 0)

    def test_the_realtime_lane_refuses_it_and_says_why(self):
        self.hold()
        self.refused("nodes.prediction.lane: realtime expects", "found python.Hold, which runs in Python",
                     graph=self.wall("python: 'hold.py:Hold', lane: realtime"))

    def test_a_broken_file_is_named_with_its_line(self):
        for change, *parts in (
                ((":\n    \"\"\"", "\n    \"\"\""), "hold.py:4: SyntaxError"),
                (("import tactor\n", "import tactor\nimport no_such_module\n"), "hold.py:2: ", "ModuleNotFoundError"),
                (("Hold(", "Other("), "expected a class Hold", "it has Other"),
                (('    """Holds the force."""\n', ""), "hold.py:4: class Hold", "expected a docstring"),
                (("def step", "def steps"), "hold.py:4: class Hold", "expected a method step"),
                (('"Wrench"', '"Wrenches"'), "Hold.force: expected a message type, found Wrenches"),
                (("trigger=True, ", ""), "hold.py:4: class Hold", "without which it never steps"),
                (("1.0, min=0", "5.0, min=0"), "hold.py:9: ", "expected a default from 0 to 2, found 5.0"),
                (("    gain", "    cost"), "declares the parameter \"cost\""),
                (("    gain", "    context"), "context is an attribute of every node")):
            with self.subTest(change=change):
                self.hold(change=change)
                self.refused("wall.yaml:6:", *parts)

    def test_a_graph_that_names_it_wrongly_is_refused(self):
        self.hold()
        for node, *parts in (
                ("python: 'hold.py'", "nodes.prediction.python: expected FILE.py:Class"),
                ("python: 'holds.py:Hold'", "expected a Python file that exists", 'did you mean "hold.py"?'),
                ("python: 'hold.py:Hold', type: prediction.hold", "expected type or python, found both"),
                ("python: 'hold.py:Hold', gains: 1", "gains", 'did you mean "gain"?'),
                ("python: 'hold.py:Hold', gain: 3", "gain", "found 3"),
                ("python: 'hold.py:Hold', gain: 1 N", "gain")):
            with self.subTest(node=node):
                self.refused("wall.yaml:6:", *parts, graph=self.wall(node))

    def test_what_its_readers_could_not_read_is_not_sent(self):
        for change, text in ((("= 4, 0.01", "= 5, 0.01"), "ValueError: forecast: Forecast.count: expected 1 to 4, found 5"),
                             (("made)", '{"count": 1})'), "ValueError: forecast: expected the fields current_force"),
                             (("made)", "sample)"), "ValueError: forecast: expected the fields"),
                             (('sample["valid_ns"]', "step.now"), "TypeError: valid_ns: expected a time")):
            with self.subTest(change=change):
                self.hold(change=change)
                self.refused(text, "hold.py", verb="run", code=1)

    def test_a_port_works_in_a_step_and_not_in_init(self):
        self.hold(change=("    def step", "    def __init__(self):\n        self.force.latest()\n\n    def step"))
        self.refused("RuntimeError: a port works while its node is in start or step", verb="run", code=1)

    def test_a_step_that_worked_on_less_than_nothing_is_refused(self):
        self.hold(change=("        for sample", "        step.work = -1\n        for sample"))
        self.refused("step.work: expected an integer from 0", "found -1", verb="run", code=1)

    @needs_live
    @needs_hdf5
    def test_a_live_run_is_made_again(self):
        self.hold()
        scene = PRESSED_WALL % {"duration": "1 s", "device": "type: device.simulated", "height": "2 mm"}
        scene = scene.replace("nodes:", "nodes:\n  trajectory: {type: source.trajectory, points: [{t: 0 s, z: 2 mm}]}")
        scene = scene.replace("edges:", "edges:\n  - trajectory.target -> device.target")
        graph = self.write("live.yaml", scene.replace("{type: prediction.hold}", "{python: 'hold.py:Hold', lane: thread}"))
        self.run_graph(graph)
        self.run_ok("replay", self.folder / "out" / "recording.h5", "--out", self.folder / "again")

    @unittest.skipUnless(shutil.which("mypy"), "mypy is not installed")
    def test_mypy_finds_nothing_in_the_example(self):
        done = subprocess.run(["mypy", "--strict", "--cache-dir", self.folder / "mypy", EXAMPLE / "linear.py"], text=True,
                              capture_output=True, check=False, env={"MYPYPATH": str(BUILD / "python"), "PATH": "/usr/bin"})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_schema_takes_it(self):
        import jsonschema
        import yaml

        schema = json.loads(self.run_ok("schema").stdout)
        graph = yaml.safe_load((EXAMPLE / "wall.yaml").read_text())
        jsonschema.validate(graph, schema)
        graph["nodes"]["prediction"]["python"] = "linear.py"
        with self.assertRaises(jsonschema.ValidationError):
            jsonschema.validate(graph, schema)

    def test_the_reference_run_is_made_again_when_its_code_changes(self):
        graph = self.write("hand.yaml", "extends: wall/off.yaml\nduration: 1 s\n"
                                        "nodes: {trajectory: {python: 'hand.py:Hand'}}\n")
        helper = self.write("speed.py", "SPEED = 0.02\n")

        def error(text):
            self.write("hand.py", text)
            return self.run_graph(graph)["delivered"]["force"]["rms_error_N"]

        slow = error(HAND % ("", "0.02"))
        fast = error(HAND % ("", "0.03"))
        self.assertNotEqual(slow, fast)
        by_helper = HAND % ("from speed import SPEED\n", "SPEED")
        self.assertEqual(error(by_helper), slow)
        helper.write_text("SPEED = 0.03\n")
        self.assertEqual(error(by_helper), fast)

    def test_a_parameter_has_the_value_for_the_reference_run_there(self):
        graph = self.write("hand.yaml", "extends: wall/off.yaml\nduration: 1 s\n"
                                        "nodes: {trajectory: {python: 'hand.py:Hand', sway: 1 mm}}\n")

        def run(in_reference):
            parameter = f'\n    sway = tactor.Parameter(0.0, unit="m", max=0.01{in_reference}, doc="an offset of the hand")'
            text = HAND.replace("    rate = tactor.Rate(1000.0)", "    rate = tactor.Rate(1000.0)" + parameter + '''

    def start(self, step):
        print(f"sway {self.sway}")''').replace("0.01 - %s * min(step.now, 0.5)", "0.01 - 0.02 * min(step.now, 0.5) + self.sway")
            self.write("hand.py", text % "")
            done = self.run_ok("run", graph, "--out", self.folder / "out", "--overwrite")
            error = json.loads((self.folder / "out" / "summary.json").read_text())["delivered"]["force"]["rms_error_N"]
            return {line for line in done.stderr.splitlines() if line.startswith("sway ")}, error

        alike, small = run("")
        self.assertEqual(alike, {"sway 0.001"})
        apart, large = run(", in_reference=0.0")
        self.assertEqual(apart, {"sway 0.001", "sway 0.0"})
        # The truth is that of another hand.
        self.assertGreater(large, 2 * small)

    def test_a_value_for_the_reference_run_is_checked_as_one_of_a_graph(self):
        for parameter, said in (
            ('1.0, max=2, in_reference=3.0', "expected in_reference from -inf to 2, found 3.0"),
            ('1.0, in_reference=float("nan")', "expected in_reference from -inf to inf, found nan"),
            ('1.0, in_reference="fine"', "expected in_reference of the type of the parameter (real), found 'fine'"),
            ('1.0, in_reference=True', "expected in_reference of the type of the parameter (real), found True"),
            ('1, in_reference=0.5', "expected in_reference of the type of the parameter (integer), found 0.5"),
            ('True, in_reference=1', "expected in_reference of the type of the parameter (boolean), found 1"),
            ('[1.0], max=2, in_reference=[1.0, 3.0]', "expected in_reference from -inf to 2, found 3.0"),
            ('[1.0], in_reference=["a"]', "expected in_reference of the type of the parameter (reals), found ['a']"),
            ('"a", choices=("a", "b"), in_reference="c"', "expected in_reference as one of a, b, found 'c'"),
            ('"x.csv", file=True, in_reference="y.csv"', "in_reference is not for a file"),
        ):
            with self.subTest(parameter=parameter):
                self.hold(gain=("tactor.Parameter(1.0, min=0, max=2, ", f"tactor.Parameter({parameter}, "))
                self.refused("hold.py:9: ", said)
        for parameter in ('False, in_reference=True', '3, in_reference=5', '[1.0], in_reference=[2, 3]', '"a", in_reference=""',
                          '"a", choices=("a", "b"), in_reference="b"', '1.0, in_reference=2'):
            with self.subTest(parameter=parameter):
                self.hold(gain=("tactor.Parameter(1.0, min=0, max=2, ", f"tactor.Parameter({parameter}, "))
                self.run_ok("check", self.wall())

    def test_code_in_a_package_counts_and_leaves_no_compiled_files(self):
        graph = self.write("hand.yaml", "extends: wall/off.yaml\nduration: 1 s\n"
                                        "nodes: {trajectory: {python: 'hand.py:Hand'}}\n")
        self.write("hand.py", HAND % ("from lab.parts.speed import SPEED\n", "SPEED"))
        (self.folder / "lab" / "parts").mkdir(parents=True)
        (self.folder / "lab" / "__init__.py").write_text("")
        errors = []
        for speed in ("0.02", "0.03", "0.02"):  # within the second in which a .pyc file would hold
            (self.folder / "lab" / "parts" / "speed.py").write_text(f"SPEED = {speed}\n")
            errors.append(self.run_graph(graph)["delivered"]["force"]["rms_error_N"])
        self.assertNotEqual(errors[0], errors[1])
        self.assertEqual(errors[0], errors[2])
        self.assertEqual(list(self.folder.rglob("__pycache__")), [])

    def test_a_file_is_not_looked_for_in_the_current_folder(self):
        self.hold()
        (self.folder / "sub").mkdir()
        (self.folder / "sub" / "wall.yaml").write_text(self.wall("python: 'hold.py:Hold'").read_text())
        found = subprocess.run([os.environ["TACTOR"], "check", "sub/wall.yaml"], cwd=self.folder, text=True,
                               capture_output=True, check=False)
        self.assertEqual(found.returncode, 2, found.stdout + found.stderr)
        self.assertIn("expected a Python file that exists", found.stderr)

    def test_a_folder_whose_name_is_not_utf_8(self):
        folder = os.fsencode(self.folder) + b"/\xe9t\xe9"
        os.mkdir(folder)
        for name in (self.hold(), self.wall("python: 'hold.py:Hold'")):
            shutil.copy(name, os.fsdecode(folder))
        for change, code in (("", 0), ("1 / 0", 2)):
            with open(folder + b"/hold.py", "a") as file:
                file.write(change)
            found = subprocess.run([os.environ["TACTOR"], "check", folder + b"/wall.yaml"], capture_output=True, check=False)
            self.assertEqual(found.returncode, code, found.stderr)
        # Shown by the numbers of its bytes.
        self.assertIn(b"\\xe9t\\xe9/hold.py", found.stderr)
        self.assertIn(b"ZeroDivisionError", found.stderr)

    def test_a_second_ctrl_c_ends_a_step_that_does_not_come_back(self):
        self.hold(stuck=("        for sample", "        while True:\n            pass\n        for sample"))
        process = subprocess.Popen([os.environ["TACTOR"], "run", self.wall("python: 'hold.py:Hold'"), "--out", self.folder / "out"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        time.sleep(3)
        for _ in range(2):
            process.send_signal(signal.SIGINT)
            time.sleep(0.3)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, errors)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertIn("hold.py", errors)

    @needs_hdf5
    def test_its_random_numbers_come_from_the_seed(self):
        self.hold(make=("    def step", "    def __init__(self):\n        import numpy as np\n"
                                        "        self.random = np.random.default_rng(self.context.seed)\n\n    def step"),
                  use=("self.gain * ", "self.random.normal() * "))
        graph = self.wall(record="prediction.forecast")
        forecasts = []
        for n, seed in enumerate((1, 1, 2)):
            self.run_graph(graph, "--seed", str(seed), out=f"out{n}")
            forecasts.append(streams(self.folder / f"out{n}" / "recording.h5")["prediction.forecast"])
        self.assertEqual(forecasts[0], forecasts[1])
        self.assertNotEqual(forecasts[0], forecasts[2])


if __name__ == "__main__":
    unittest.main()
