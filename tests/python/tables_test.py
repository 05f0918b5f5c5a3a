"""Comparisons and studies from Python are those of the command, as tables of pandas."""
import csv
import os
import pathlib
import subprocess
import sys
import textwrap
import unittest
from unittest import mock

from package_harness import BUILD, WALL, PackageTest, needs_hdf5, tactor

try:
    import pandas
except ImportError:
    pandas = None

SCENE = str(pathlib.Path(WALL).parent / "scene.yaml")
STUDY = f"""format: 2
graphs: [{SCENE}]
methods: [hold, linear]
seeds: 2
duration: 0.3 s
vary:
  scene.bodies.tool.mass: [10 g, 20 g]
"""


class Without(PackageTest):
    """Packages that are not installed are asked for where they are needed, and by name."""

    def test_pandas_and_h5py(self):
        with mock.patch.dict(sys.modules, {"pandas": None, "h5py": None}):
            self.assertIn("apt install python3-pandas", self.refused(ImportError, tactor.study, "s.yaml"))
            self.assertIn("apt install python3-pandas", self.refused(ImportError, tactor.compare, [SCENE]))
            self.assertIn("apt install python3-h5py", self.refused(ImportError, tactor.Recording, "r.h5"))


@unittest.skipIf(pandas is None, "pandas is not installed")
@needs_hdf5
class Tables(PackageTest):
    def test_a_study_is_the_table_that_the_command_writes(self):
        study = self.write("study.yaml", STUDY)
        table = tactor.study(study, out=self.folder / "study", jobs=1)
        with open(self.folder / "study/study.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(table), 8)
        self.assertEqual(list(table["scene.bodies.tool.mass"]), [row["scene.bodies.tool.mass"] for row in rows])
        for row, values in zip(rows, table.to_dict("records")):
            self.assertEqual(float(row["delivered.force.rms_error_N"]), values["delivered.force.rms_error_N"])
        self.assertEqual(table.attrs["units"]["delivered.force.rms_error_N"], "N")
        self.assertEqual(table.attrs["better"]["delivered.force.rms_error_N"], "lower")
        self.assertGreater(table["cpu_ms_per_s"].min(), 0)
        self.assertEqual(table.attrs["study"]["seeds"], [1001, 1002])
        pandas.testing.assert_frame_equal(tactor.study_table(self.folder / "study"), table)
        said = self.refused(tactor.InputError, tactor.study, study, out=self.folder / "study")
        self.assertIn("study.sqlite", said)
        self.assertIn("resume=True continues them, overwrite=True starts anew", said)
        self.assertNotIn("--", said)
        again = tactor.study(study, out=self.folder / "study", resume=True)
        pandas.testing.assert_frame_equal(again, table)

    def test_a_study_that_is_refused_says_what_the_command_says(self):
        study = self.write("bad.yaml", STUDY.replace("seeds: 2", "seeds: two"))
        said = self.refused(tactor.InputError, tactor.study, study)
        self.assertIn(f"{study}:4:8: seeds: expected", said)
        self.assertIn("no study.json", self.refused(tactor.InputError, tactor.study_table, self.folder))

    def test_a_study_with_runs_that_fail_has_the_others(self):
        text = STUDY.replace("  scene.bodies.tool.mass: [10 g, 20 g]", "  dynamics.step: [1 ms, 1 us]") + "run_timeout: 1 ms\n"
        said = self.refused(tactor.Error, tactor.study, self.write("late.yaml", text.replace("1 ms\n", "0 s\n")))
        self.assertIn("run_timeout", said)

    def test_a_comparison_has_a_row_for_each_graph_and_seed(self):
        stiff = tactor.load(SCENE, "kalman", {"coupling.k_0": "500 N/m"})
        table = tactor.compare([SCENE, stiff], seeds=2, duration="0.5 s", out=self.folder / "compare")
        self.assertEqual(list(table["seed"]), [1, 2, 1, 2])
        self.assertEqual(set(table["status"]), {"done"})
        metric = "delivered.force.rms_error_N"
        self.assertEqual(table.attrs["units"][metric], "N")
        # Both are judged from when the later of them is warm, so a run alone is judged so too.
        first = tactor.run(SCENE, seed=1, duration="0.5 s")
        self.assertEqual(table[metric][0], first.metrics[metric])
        self.assertIn("kalman" if "kalman" in table.attrs["text"] else "wall", table.attrs["text"])
        self.assertTrue((self.folder / "compare/report.html").exists())

    def test_a_graph_that_is_refused(self):
        said = self.refused(tactor.InputError, tactor.compare, [SCENE], set={"coupling.k_0": "3 kg"}, seeds=1)
        self.assertIn("expected a stiffness (N/m), found 3 kg", said)

    def test_ctrl_c_ends_the_study_and_its_workers(self):
        study = self.write("long.yaml", STUDY.replace("0.3 s", "2000 s").replace("seeds: 2", "seeds: 50") + "reference: none\n")
        program = textwrap.dedent(f"""
            import signal, threading, tactor
            main = threading.main_thread().ident
            threading.Timer(1.5, lambda: signal.pthread_kill(main, signal.SIGINT)).start()
            try:
                tactor.study({str(study)!r}, out="out", jobs=2)
            except KeyboardInterrupt:
                print("interrupted")
        """)
        done = subprocess.run([sys.executable, "-c", program], cwd=self.folder, capture_output=True, text=True, timeout=120, check=False,
                              env=dict(os.environ, PYTHONPATH=str(BUILD / "python"), **self.environment))
        self.assertEqual((done.stdout, done.stderr), ("interrupted\n", ""))
        running = subprocess.run(["pgrep", "-f", str(study)], capture_output=True, text=True, check=False).stdout
        self.assertEqual(running, "")

    def test_ctrl_c_is_passed_on_until_the_command_ends(self):
        deaf = self.write("deaf", textwrap.dedent(f"""\
            #!{sys.executable}
            import pathlib, signal
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
            pathlib.Path("ready").touch()
            for heard in range(3):
                signal.sigwait([signal.SIGINT])
            pathlib.Path("heard").write_text(str(heard + 1))
        """))
        deaf.chmod(0o755)
        program = textwrap.dedent(f"""
            import pathlib, signal, threading, time, tactor
            tactor._commands.command = lambda: {str(deaf)!r}
            main = threading.main_thread().ident

            def interrupt():
                while not pathlib.Path("ready").exists():
                    time.sleep(0.01)
                signal.pthread_kill(main, signal.SIGINT)
            threading.Thread(target=interrupt).start()
            try:
                tactor.study("none.yaml", out="out")
            except KeyboardInterrupt:
                print("interrupted")
        """)
        done = subprocess.run([sys.executable, "-c", program], cwd=self.folder, capture_output=True, text=True, timeout=120, check=False,
                              env=dict(os.environ, PYTHONPATH=str(BUILD / "python"), **self.environment))
        self.assertEqual((done.stdout, done.stderr), ("interrupted\n", ""))
        self.assertEqual((self.folder / "heard").read_text(), "3")


if __name__ == "__main__":
    unittest.main()
