"""Ctrl-C in a program of Python's: it ends within a moment by KeyboardInterrupt; live, with its devices at zero."""
import os
import pathlib
import signal
import subprocess
import sys
import textwrap
import time
import unittest

import numpy

from package_harness import BUILD, WALL, PackageTest, needs_hdf5, needs_live, tactor

# Promised is about 0.1 s on a machine with nothing else to do; this is for a busy one. What ends after the whole run ends much later.
IN_TIME = 10
LIVE = f"""extends: {WALL}
clock: real
duration: 600 s
live: {{on_missing_privilege: warn, stall_timeout: 20 s}}
record: [device.commanded, device.safety]
"""
STUCK = """import tactor


class Stuck(tactor.Node):
    \"\"\"Never comes back.\"\"\"

    force = tactor.Input("Wrench", trigger=True)
    forecast = tactor.Output("Forecast")

    def step(self, step):
        while True:
            pass
"""


class Interruption(PackageTest):
    def interrupted(self, program, after=0.5):
        """Runs a program, sends Ctrl-C once it has said `begun` and so many seconds have passed; what it says then."""
        process = subprocess.Popen([sys.executable, "-W", "ignore", "-c", textwrap.dedent(program)], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, cwd=self.folder,
                                   env=dict(os.environ, PYTHONPATH=str(BUILD / "python"), **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        self.assertEqual(process.stdout.readline(), "begun\n")
        time.sleep(after)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        said, errors = process.communicate(timeout=120)
        self.assertLess(time.monotonic() - begin, IN_TIME, errors)
        return said, errors, process.returncode

    def test_a_long_run(self):
        said, errors, code = self.interrupted(f"""
            import tactor
            print("begun", flush=True)
            tactor.run({WALL!r}, duration="100000 s")
        """)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertEqual((said, code), ("", -signal.SIGINT))

    def test_a_long_advance_leaves_a_session_that_goes_on(self):
        said, _, code = self.interrupted(f"""
            import tactor
            with tactor.Session({WALL!r}, duration="100000 s") as session:
                tap = session.tap("device.commanded", queue=100)
                print("begun", flush=True)
                try:
                    session.run()
                except KeyboardInterrupt:
                    ended = session.now
                    session.advance("1 s")
                    print(0 < ended < 100000, abs(session.now - ended - 1) < 1e-6, len(tap.take()))
        """)
        self.assertEqual((said, code), ("True True 100\n", 0))

    def test_a_session_that_hardly_moves(self):
        _, errors, code = self.interrupted(f"""
            import tactor
            with tactor.Session({WALL!r}, duration="1 s", pace=1e-5) as session:
                print("begun", flush=True)
                session.run()
        """)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertEqual(code, -signal.SIGINT)

    def test_handlers_of_other_signals_run_meanwhile(self):
        said, _, code = self.interrupted(f"""
            import signal, tactor
            class Enough(Exception): pass
            def enough(*_): raise Enough
            signal.signal(signal.SIGINT, enough)
            print("begun", flush=True)
            try:
                tactor.run({WALL!r}, duration="100000 s")
            except Enough:
                print("enough")
        """)
        self.assertEqual((said, code), ("enough\n", 0))

    @needs_live
    def test_a_live_session_ends_with_its_device_at_zero(self):
        graph = self.write("live.yaml", LIVE)
        said, errors, code = self.interrupted(f"""
            import tactor
            session = tactor.Session({str(graph)!r})
            force, safety = session.tap("device.commanded"), session.tap("device.safety")
            session.start()
            print("begun", flush=True)
            try:
                session.run()
            except KeyboardInterrupt:
                forces, states = force.take(), safety.take()
                names = {{value: name for name, value in safety.type.enumerations["engagement"].items()}}
                print(len(forces) > 300, forces["force"].any(), forces["force"][-1].any(), names[states["engagement"][-1]] in ("ramping", "disengaged"),
                      states["gain"][-1], session.running)
        """, after=1.5)
        self.assertEqual((said, code), ("True True False True 0.0 False\n", 0), errors)

    @needs_live
    @needs_hdf5
    def test_a_live_run_leaves_its_files_and_ends_at_zero(self):
        graph = self.write("live.yaml", LIVE)
        said, errors, code = self.interrupted(f"""
            import tactor
            print("begun", flush=True)
            tactor.run({str(graph)!r}, out="out")
        """, after=2.5)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertTrue((self.folder / "out/summary.json").exists())
        force = tactor.Recording(self.folder / "out/recording.h5")["device.commanded"][:]["force"]
        self.assertTrue(force.any())
        self.assertFalse(force[-1].any())

    @needs_live
    def test_a_live_session_that_nobody_finishes_ends_with_the_program(self):
        graph = self.write("live.yaml", LIVE)
        begin = time.monotonic()
        done = subprocess.run([sys.executable, "-W", "ignore", "-c", textwrap.dedent(f"""
            import tactor
            session = tactor.Session({str(graph)!r})
            session.start()
            session.advance("0.2 s")
            print(session.status()["phase"], session.now > 0, sorted(session.status()["devices"]))
        """)], capture_output=True, text=True, timeout=120,
            env=dict(os.environ, PYTHONPATH=str(BUILD / "python"), **self.environment), check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("True ['device']", done.stdout)
        self.assertLess(time.monotonic() - begin, 60)


class End(PackageTest):
    """What threads have begun ends with the program."""

    def ended(self, program, timeout=120):
        """Runs a program to its end; what it says."""
        done = subprocess.run([sys.executable, "-W", "ignore", "-c", textwrap.dedent(program)], capture_output=True, text=True,
                              timeout=timeout, cwd=self.folder, check=False,
                              env=dict(os.environ, PYTHONPATH=str(BUILD / "python"), **self.environment))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    @needs_live
    @needs_hdf5
    def test_a_live_run_of_a_thread_ends_at_zero(self):
        graph = self.write("live.yaml", LIVE)
        self.ended(f"""
            import threading, time, tactor
            threading.Thread(target=lambda: tactor.run({str(graph)!r}, out="out"), daemon=True).start()
            time.sleep(3)
        """)
        self.assertTrue((self.folder / "out/summary.json").exists())
        force = tactor.Recording(self.folder / "out/recording.h5")["device.commanded"][:]["force"]
        self.assertTrue(force.any())
        self.assertFalse(force[-1].any())

    @needs_live
    def test_a_live_session_that_a_thread_advances_ends(self):
        graph = self.write("live.yaml", LIVE)
        self.assertEqual(self.ended(f"""
            import threading, time, tactor
            session = tactor.Session({str(graph)!r})
            session.start()
            threading.Thread(target=session.run, daemon=True).start()
            time.sleep(1)
            print(session.running)
        """), "True\n")

    def test_runs_and_sessions_of_threads_end(self):
        for work in (f"tactor.run({WALL!r}, duration='100000 s')",
                     f"tactor.Session({WALL!r}, duration='100000 s').run()",
                     f"tactor.Session({WALL!r}, duration='100 s', pace=1).run()",
                     f"[tactor.load({WALL!r}) for _ in range(100000)]",
                     f"[tactor.Session({WALL!r}, duration='1 ms').run() for _ in range(1000000)]"):
            with self.subTest(work=work):
                for after in (0.3, 0.31):
                    self.assertEqual(self.ended(f"""
                        import threading, time, tactor
                        for _ in range(3): threading.Thread(target=lambda: {work}, daemon=True).start()
                        time.sleep({after})
                        print("end")
                    """), "end\n")

    def test_a_step_that_never_ends_ends_with_the_program(self):
        self.write("stuck.py", STUCK)
        self.assertEqual(self.ended("""
            import threading, time, tactor
            graph = tactor.load("wall/scene", over={"nodes": {"metrics": None, "prediction": {"python": "stuck.py:Stuck"}}, "record": ["device.commanded"]})
            threading.Thread(target=lambda: tactor.run(graph), daemon=True).start()
            time.sleep(1)
            print("end")
        """), "end\n")

    def test_a_session_that_fails_keeps_no_other_from_its_end(self):
        done = subprocess.run([sys.executable, "-c", textwrap.dedent("""
            import tactor
            class Fails:
                def __init__(self): self._session = self
                def finish(self):
                    print("finish", flush=True)
                    raise tactor.RunError("this one fails")
            kept = [Fails() for _ in range(3)]
            for one in kept: tactor._session._live.add(one)
        """)], capture_output=True, text=True, env=dict(os.environ, PYTHONPATH=str(BUILD / "python")), check=False)
        self.assertEqual(done.stdout, "finish\n" * 3)
        self.assertEqual(done.stderr.count("Error: this one fails"), 3, done.stderr)


@needs_live
class Live(PackageTest):
    def test_taps_feeds_and_parameters_of_a_live_session(self):
        graph = self.write("live.yaml", LIVE.replace("600 s", "3 s"))
        with tactor.Session(graph, feeds=["device.target"]) as session:
            feed, tap = session.feed("device.target"), session.tap("device.state")
            session.start()
            for i in range(50):
                feed.send(p_WH=[0, 0, 0.05], R_WH=[1, 0, 0, 0], v_WH=[0, 0, 0], w_WH=[0, 0, 0])
                session.advance("10 ms")
            state = tap.take()
            self.assertGreater(len(state), 100)
            session.set("coupling.k_0", "700 N/m")
            self.refused(tactor.RunError, lambda: session.metrics)
            session.stop()
        self.assertTrue((numpy.diff(state["valid_ns"]) > 0).all())
        self.assertLess(abs(state["p_WD"][-1, 2] - 0.05), 1e-3)
        self.assertIn("device.faults", session.metrics)
        self.assertGreater(session.status()["nodes"]["collision"]["steps"], 5)
        self.assertNotIn("trajectory", session.status()["nodes"])  # which only fed what the program feeds


if __name__ == "__main__":
    unittest.main()
