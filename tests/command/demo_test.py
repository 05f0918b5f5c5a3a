"""`tactor demo`: the comparison of six methods, and the scene to touch behind it."""
import json
import math
import re
import unittest

from harness import CACHE, CommandTest, Terminal, needs_live, needs_meshes, needs_view, tactor
from view_client import Page

METHODS = ["off", "fixed", "refit", "lowpass", "blend", "local"]


@needs_meshes
class Demo(CommandTest):
    def setUp(self):
        super().setUp()
        # References and meshes are computed once for all tests.
        self.environment["TACTOR_CACHE"] = str(CACHE.parent / "tests/cache")

    def compared(self, scene, *options):
        """What the demo of a scene says, and what it leaves of each method."""
        result = self.run_ok("demo", "--scene", scene, "--seeds", "1", "--no-view", *options, cwd=self.folder)
        rows = json.loads((self.folder / "out/demo/compare.json").read_text())["graphs"]
        return result.stdout, {row["graph"]: row for row in rows}

    def test_it_compares_six_methods_and_says_where_the_report_is(self):
        for scene in ("bunny", "duck"):
            with self.subTest(scene=scene):
                said, rows = self.compared(scene, "--overwrite")
                self.assertEqual(list(rows), [f"{scene}_{method}" for method in METHODS])
                table = {line.split()[0]: [float(word) for word in line.split()[1:]]
                         for line in said.splitlines() if re.fullmatch(rf"  {scene}_\w+( +-?[\d.e-]+)+", line)}
                self.assertEqual(list(table), list(rows))
                for name, numbers in table.items():
                    self.assertEqual(len(numbers), 4)  # error, delay, largest step, run time
                    self.assertTrue(all(math.isfinite(number) for number in numbers))
                    error = rows[name]["metrics"]["delivered.force.rms_error_N"]["mean"]
                    self.assertAlmostEqual(numbers[0], error, delta=0.01 * error)
                # What the page of the method promises of these scenes.
                self.assertLess(table[f"{scene}_local"][0], table[f"{scene}_off"][0])
                self.assertIn("xdg-open out/demo/report.html", said)
                self.assertIn(f"tactor view {scene}/touch", said)
                self.assertIn(f"<h1>{scene}: off, fixed, refit, lowpass, blend, local</h1>", (self.folder / "out/demo/report.html").read_text())

    def test_earlier_results_stay(self):
        earlier = self.folder / "out/demo/report.html"
        earlier.parent.mkdir(parents=True)
        earlier.write_text("earlier")
        self.run_ok("demo", "--scene", "duck", "--seeds", "1", "--no-view", cwd=self.folder)
        self.assertEqual(earlier.read_text(), "earlier")
        self.assertTrue((self.folder / "out/demo_2/report.html").exists())

    def test_a_scene_that_it_does_not_have_is_bad_input(self):
        result = tactor("demo", "--scene", "peg_in_hole", cwd=self.folder, environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("--scene", result.stderr)

    @needs_view
    @needs_live
    def test_a_person_at_the_terminal_gets_the_scene_to_touch(self):
        terminal = Terminal("demo", "--scene", "duck", "--seeds", "1", "--no-open", "--out", self.folder / "out",
                            environment=self.environment)
        terminal.expect("Ctrl-C ends it")
        address = re.search(r"http://127\.0\.0\.1:(\d+)/#([0-9a-f]{32})", terminal.text)
        page = Page(int(address[1]), address[2])
        page.wait_for(lambda p: p.hello is not None)
        self.assertEqual(page.hello["graph"], "duck_touch")
        page.close()
        terminal.type("\x03")
        self.assertEqual(terminal.finish(), 0, terminal.text)
        self.assertIn("duck_local", terminal.text)


if __name__ == "__main__":
    unittest.main()
