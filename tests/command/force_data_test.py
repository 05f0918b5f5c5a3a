"""The paper's tables on recorded forces: files of numbers, against a process whose best prediction is known."""
import math
import re
import subprocess
import unittest

import numpy

from harness import ROOT, TACTOR, CommandTest

SCRIPT = ROOT / "scripts/force_data"
COLUMNS = "t_ms,x_mm,-,fx_N,fy_N,fz_N"
NOISE = 0.05  # N a axis


class ForceData(CommandTest):
    def made(self, name, seed, separator=" "):
        """Forces of a second-order process every 10 ms: no prediction errs by less than its noise."""
        noise = numpy.random.default_rng(seed).normal(0, NOISE, (3000, 3))
        force = numpy.zeros((3000, 3))
        for i in range(2, 3000):
            force[i] = 1.6 * force[i - 1] - 0.7 * force[i - 2] + noise[i]
        lines = [separator.join(f"{v:.6f}" for v in (10 * i, 3 * math.sin(i), 7, *f)) for i, f in enumerate(force)]
        self.write(name, "# a comment\ntime x skipped forces\n" + "\n".join(lines) + "\n\n")
        return numpy.round(force, 6)

    def script(self, *arguments):
        return subprocess.run([SCRIPT, *map(str, arguments), "--tactor", TACTOR], capture_output=True, text=True, check=False, timeout=300)

    def test_both_tables_are_those_of_the_process(self):
        forces = [self.made("one.traj", 1), self.made("two.traj", 2, ", ")]
        done = self.script(self.folder / "one.traj", self.folder / "two.traj", "--columns", COLUMNS)
        self.assertEqual(done.returncode, 0, done.stderr)
        first, second = done.stdout.split("Table 2")
        windows = re.findall(r"^\| (\d+) \| ([\d.]+) \|", first, re.MULTILINE)
        self.assertEqual([int(w) for w, _ in windows], [100, 200, 300, 400, 500])
        # With a long window the best prediction is found: its error is the noise, over three axes.
        self.assertAlmostEqual(float(windows[-1][1]), NOISE * math.sqrt(3), delta=0.02 * NOISE * math.sqrt(3))
        self.assertGreater(float(windows[0][1]), float(windows[-1][1]))
        rows = re.findall(r"^\| (\w+)\.traj \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|.*\| ([\d.]+) \|$", second, re.MULTILINE)
        self.assertEqual([row[0] for row in rows], ["one", "two"])
        for force, (_, hold, fixed, refit, judged) in zip(forces, rows):
            # By a computation of its own: fixed is F_t + (F_t - F_{t-1}) / 2, from when all is warm on.
            stamps = 0.01 * numpy.arange(1, len(force) - 1)
            warm = stamps >= float(judged)
            held = numpy.linalg.norm(force[2:] - force[1:-1], axis=1)[warm]
            damped = numpy.linalg.norm(force[2:] - force[1:-1] - 0.5 * (force[1:-1] - force[:-2]), axis=1)[warm]
            self.assertAlmostEqual(float(hold), numpy.sqrt(numpy.mean(held ** 2)), delta=6e-4)
            self.assertAlmostEqual(float(fixed), numpy.sqrt(numpy.mean(damped ** 2)), delta=6e-4)
            self.assertLess(float(refit), float(fixed))

    def refused(self, text, columns, *expected):
        self.write("bad.traj", text)
        done = self.script(self.folder / "bad.traj", "--columns", columns)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        for word in expected:
            self.assertIn(word, done.stderr)

    def test_what_is_wrong_is_told_with_its_place(self):
        good = "0 0 0 1 2 3\n10 0 0 1 2 3\n20 0 0 1 2 3\n"
        self.refused(good, "t_ms,x_mm", "--columns", "no fx and no fy and no fz")
        self.refused(good, "t_ms,x_mm,-,fx_N,fy_N,fz_kg", "fz_kg", "fz_N")
        self.refused(good, "t_ms,t_ms,-,fx_N,fy_N,fz_N", "found t again")
        self.refused(good, "t_ms,fx_N,fy_N,fz_N", "bad.traj:1: expected 4 numbers", "found 6")
        self.refused(good + "30 0 0 1 2\n", COLUMNS, "bad.traj:4: expected 6 numbers", "found 5")
        self.refused(good + "30 0 0 1 2 nan\n", COLUMNS, "bad.traj:4: expected a finite number", "'nan'")
        self.refused(good + "nan 0 0 1 2 3\n", COLUMNS, "bad.traj:4: expected a finite number", "'nan'")
        self.refused(good + "15 0 0 1 2 3\n", COLUMNS, "bad.traj:4: expected times that grow")
        self.refused("# nothing\n", COLUMNS, "expected three samples or more, found 0")
        # Too short for any window: that is the study's to refuse.
        self.refused(good, COLUMNS, "not warm")
        done = self.script(self.folder / "none.traj", "--columns", COLUMNS)
        self.assertEqual(done.returncode, 2)
        self.assertIn("none.traj", done.stderr)


if __name__ == "__main__":
    unittest.main()
