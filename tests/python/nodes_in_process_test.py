"""Nodes that are classes in Python files, in a process of Python's own."""
import gc
import os
import signal
import subprocess
import sys
import threading
import time
import unittest

from package_harness import ROOT, PackageTest, needs_hdf5, needs_live, tactor

EXAMPLE = ROOT / "examples" / "python_node" / "wall.yaml"
SCALE = '''import time

import tactor


class Scale(tactor.Node):
    """Multiplies a force."""

    made = 0
    force = tactor.Input("Wrench", trigger=True, queue=64, doc="what comes")
    forecast = tactor.Output("Forecast", doc="what goes")
    gain = tactor.Parameter(1.0, min=0, max=10, tunable=True, doc="the factor")

    def __init__(self):
        self.tuned = 0

    def tune(self):
        self.tuned += 1

    def step(self, step):
        for sample in self.force.new():
            made = self.forecast.zeros()
            made["current_force"] = FACTOR * self.gain * sample["force"]
            made["predicted"]["force"][:] = made["current_force"]
            made["count"], made["horizon"], made["fallback"] = 4, 0.01, self.tuned
            self.forecast.send(sample["valid_ns"], made)


FACTOR = 1
'''
OVER = {"nodes": {"metrics": None, "prediction": {"python": "scale.py:Scale"}}, "record": ["device.commanded"]}


class NodesInThisProcess(PackageTest):
    def setUp(self):
        super().setUp()
        before = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, before)

    def scale(self, old="", new=""):
        self.assertIn(old, SCALE)
        self.write("scale.py", SCALE.replace(old, new, 1) if old else SCALE)

    def forces(self, **options):
        """The forces on the device, N, and what the node has sent."""
        made = tactor.run("wall/scene", over=OVER, duration="1 s", taps=["device.commanded", "prediction.forecast"], **options)
        return made.taps["device.commanded"]["force"], made.taps["prediction.forecast"]

    @needs_hdf5
    def test_it_gives_the_bytes_of_the_command(self):
        self.run_ok("run", EXAMPLE, "--out", self.folder / "command", "--duration", "2")
        here = tactor.run(EXAMPLE, duration="2 s", out=self.folder / "here").recording
        there = tactor.Recording(self.folder / "command" / "recording.h5")
        self.assertEqual(sorted(here), ["coupling.force", "device.commanded", "prediction.forecast"])
        for name, stream in here.items():
            self.assertGreater(len(stream), 100)
            self.assertEqual(stream[:].tobytes(), there[name][:].tobytes(), name)

    def test_an_edited_file_is_run_anew(self):
        self.scale()
        once, _ = self.forces()
        self.assertGreater(abs(once).max(), 0.5)
        self.scale("FACTOR = 1\n", "FACTOR = 0\n")
        self.assertEqual(abs(self.forces()[0]).max(), 0)
        self.scale()
        self.assertEqual(self.forces()[0].tobytes(), once.tobytes())

    def test_results_are_kept_under_the_code_that_ran(self):
        hand = """import speed
import tactor


class Hand(tactor.Node):
    \"\"\"Presses.\"\"\"

    role = "source"
    rate = tactor.Rate(1000.0)
    target = tactor.Output("Target")

    def step(self, step):
        made = self.target.zeros()
        made["p_WH"][2] = 0.01 - speed.SPEED * min(step.now, 0.5)
        made["R_WH"][0] = 1
        self.target.send(step.now_ns, made)
"""
        self.write("hand.py", hand)
        over = {"nodes": {"trajectory": {"python": "hand.py:Hand"}}}

        def error(graph):
            return tactor.run(graph).metrics["delivered.force.rms_error_N"]
        self.write("speed.py", "SPEED = 0.02\n")
        loaded = tactor.load("wall/off", over=over, duration="1 s")
        self.write("speed.py", "SPEED = 0.03\n")
        slow = error(loaded)
        fast = error(tactor.load("wall/off", over=over, duration="1 s"))
        os.environ["TACTOR_CACHE"] = str(self.folder / "another_cache")
        self.assertEqual(fast, error(tactor.load("wall/off", over=over, duration="1 s")))
        self.assertNotEqual(slow, fast)

    def test_a_folder_whose_name_is_not_utf_8(self):
        self.scale()
        folder = os.fsencode(self.folder) + b"/\xe9t\xe9"
        os.mkdir(folder)
        os.rename("scale.py", folder + b"/scale.py")
        with open(folder + b"/wall.yaml", "w") as file:
            file.write("extends: wall/scene\nnodes: {metrics: ~, prediction: {python: 'scale.py:Scale'}}\n"
                       "record: [device.commanded]\nduration: 1 s\n")
        graph = tactor.load(os.fsdecode(folder + b"/wall.yaml"))
        self.assertEqual(os.fsencode(graph.file), folder + b"/wall.yaml")
        self.assertEqual(len(tactor.run(graph, taps=["device.commanded"]).taps["device.commanded"]), 1000)
        self.assertIn("\\xe9t\\xe9/other.yaml", self.refused(tactor.InputError, tactor.load, os.fsdecode(folder + b"/other.yaml")))

    def test_a_file_that_is_the_same_is_run_once(self):
        self.scale("made = 0", "made = __import__('pathlib').Path(f'ran_{time.monotonic_ns()}').touch()")
        for _ in range(3):
            tactor.load("wall/scene", over=OVER)
        self.assertEqual(len(list(self.folder.glob("ran_*"))), 1)

    def test_an_exception_is_a_run_error_with_its_traceback(self):
        self.scale("for sample", "if step.now > 0.2:\n            raise LookupError('nothing here')\n        for sample")
        text = self.refused(tactor.RunError, self.forces)
        for part in ("node prediction failed at 0.2", "Traceback", 'scale.py", line 22, in step', "LookupError: nothing here"):
            self.assertIn(part, text)
        self.scale()
        self.assertEqual(len(self.forces()[0]), 1000)

    def test_a_file_that_is_refused_is_an_input_error_with_its_line(self):
        self.scale("class Scale(tactor.Node):", "class Scale(tactor.Node)")
        self.assertIn("scale.py:6: SyntaxError", self.refused(tactor.InputError, self.forces))

    def test_a_tunable_parameter_is_set_between_two_steps(self):
        self.scale()
        with tactor.Session("wall/scene", over=OVER, duration="2 s") as session:
            sent = session.tap("prediction.forecast")
            physics = session.tap("coupling.force")
            session.advance("1 s")
            session.set("prediction.gain", "3")
            session.advance("1 s")
            refused = self.refused(tactor.InputError, session.set, "prediction.gain", "11")
            sent, physics = sent.take(), physics.take()
        self.assertIn("11", refused)
        tuned = sent["fallback"] == 1
        self.assertTrue(0 < tuned.sum() < len(sent))
        came = physics["force"][:len(sent)]
        self.assertEqual(sent["current_force"][~tuned].tobytes(), came[~tuned].tobytes())
        self.assertEqual(sent["current_force"][tuned].tobytes(), (3 * came[tuned]).tobytes())

    @needs_live
    def test_live_it_steps_in_the_pool_while_python_goes_on(self):
        self.scale()
        live = [OVER, {"clock": "real", "live": {"on_missing_privilege": "warn", "on_stall": "recover"},
                       "nodes": {"collision": {"cost": "none"}}}]
        counted = 0
        with tactor.Session("wall/scene", over=live, duration="2 s") as session:
            sent = session.tap("prediction.forecast")
            session.start()
            while session.running:
                session.advance("50 ms")
                counted += 1
            messages = sent.take()
        self.assertGreater(len(messages), 20)
        self.assertGreater(counted, 5)

    def test_ctrl_c_in_a_step_is_a_keyboard_interrupt(self):
        self.scale("for sample", "time.sleep(0.01)\n        for sample")
        timer = threading.Timer(1, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        self.addCleanup(timer.cancel)
        begun = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            tactor.run("wall/scene", over=OVER, duration="1000 s")
        self.assertLess(time.monotonic() - begun, 60)

    def test_a_call_that_would_end_the_process_is_the_failure_of_the_run(self):
        for call in ("os._exit(0)", "os.abort()", "os.execv('/bin/true', ['true'])", "sys.exit(0)"):
            with self.subTest(call):
                self.scale("for sample", f"import os, sys; {call}\n        for sample")
                said = self.refused(tactor.RunError, tactor.run, "wall/scene", over=OVER, duration="1 s")
                self.assertIn("SystemExit", said)
                self.assertIn("node prediction failed", said)
        # Elsewhere, and in a child, they are what they were.
        for code in (0, 7):
            child = os.fork()
            if child == 0:
                os._exit(code)
            self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), code)
        done = subprocess.run([sys.executable, "-c", "import tactor, os; os._exit(5)"], check=False,
                              env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)))
        self.assertEqual(done.returncode, 5)

    def test_a_child_that_a_node_forks_may_end_as_it_likes(self):
        self.scale("for sample", """import multiprocessing, os
        if self.tuned == 0:
            self.tuned = 1
            child = os.fork()
            if child == 0:
                os._exit(9)
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
            process = multiprocessing.get_context("fork").Process(target=abs, args=(1,))
            process.start()
            process.join()
            assert process.exitcode == 0
        for sample""")
        self.assertEqual(tactor.run("wall/scene", over=OVER, duration="0.2 s").failure, None)

    def test_nodes_go_with_their_sessions(self):
        self.scale()
        with tactor.Session("wall/scene", over=OVER, duration="1 s") as session:
            session.advance("0.1 s")
        for _ in range(20):
            with tactor.Session("wall/scene", over=OVER, duration="1 s") as session:
                session.advance("0.1 s")
        del session
        gc.collect()
        left = [one for one in gc.get_objects() if type(one).__name__ == "Scale"]
        self.assertEqual(left, [])


if __name__ == "__main__":
    unittest.main()
