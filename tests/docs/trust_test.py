"""First picture, gallery, pages of trust, citation and forms: what they name exists, and what they count was read from where they say."""
import importlib.machinery
import importlib.util
import pathlib
import re
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

import numpy as np
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
import page  # noqa: E402
import worst_cases  # noqa: E402


def script(name):
    spec = importlib.util.spec_from_loader(name, importlib.machinery.SourceFileLoader(name, str(ROOT / "scripts" / name)))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


first_picture, gallery, trust, badge = script("first_picture"), script("gallery"), script("trust"), script("badge")


class FirstPicture(unittest.TestCase):
    def test_it_is_the_first_of_the_readme_in_the_colours_of_reports(self):
        images = re.findall(r"^!\[[^\]]+\]\(([^)]+)\)$", (ROOT / "README.md").read_text(), re.MULTILINE)
        self.assertEqual(ROOT / images[0], first_picture.PICTURE)
        curves = [curve.get("stroke") for curve in xml.parse(first_picture.PICTURE).iter("{http://www.w3.org/2000/svg}polyline")]
        self.assertEqual(curves[1:], list(first_picture.colors().values()))  # the first is the true force
        self.assertEqual(first_picture.colors()["local"], "#0072B2")

    def test_it_shows_the_time_in_which_every_method_errs_as_in_the_whole_run(self):
        ticks, judged_from, grows_at, small, large = 4000, 500, 2000, 0.5, 2.0
        truth = np.stack([np.zeros(ticks), np.sin(np.arange(ticks) / 50), np.zeros(ticks)], 1)
        size = np.where(np.arange(ticks) < grows_at, small, large)
        mean_square = (size[judged_from:] ** 2).mean()
        size[:judged_from] = mean_square ** 0.5  # just as large, where not all are judged
        forces = {name: truth + (scale * size)[:, None] for name, scale in (("late", 1.0), ("near", 0.01))}
        axis, begin, ratios = first_picture.typical(truth, forces, judged_from)
        share_large = (mean_square - small ** 2) / (large ** 2 - small ** 2)
        self.assertEqual(axis, 1)
        self.assertAlmostEqual(begin, grows_at - (1 - share_large) * first_picture.LENGTH, delta=1)
        for ratio in ratios.values():
            self.assertAlmostEqual(ratio, 1, delta=0.01)

    def test_a_text_stands_on_nothing_and_on_the_outer_side_of_its_curve(self):
        x = np.linspace(first_picture.LEFT, first_picture.WIDTH - first_picture.RIGHT, 150)
        outer, inner = (np.stack([x, np.full(150, y)], 1) for y in (100.0, 180.0))
        box, line = first_picture.placed(["late"], outer, inner, inner, inner)
        self.assertLess(box[3], 100)
        self.assertAlmostEqual(line[-1][1], 100)


class Gallery(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.page = (ROOT / "docs/gallery.md").read_text()

    def test_every_folder_of_graphs_is_in_it(self):
        folders = {folder.name for folder in (ROOT / "graphs").iterdir() if folder.is_dir() and not folder.name.startswith("_")}
        self.assertEqual(folders, {entry["folder"] for entry in gallery.entries() if "folder" in entry})
        for folder in folders:
            self.assertIn(f"(../graphs/{folder}", self.page)

    def test_every_graph_of_a_scene_is_run_or_passed_over_by_name(self):
        run = {word for entry in gallery.entries() for command in gallery.commands(entry) + entry.get("touch", [])
               for word in re.findall(r"[\w./]+", command)}
        for entry in gallery.entries():
            if "folder" in entry and (ROOT / "graphs" / entry["folder"] / "scene.yaml").exists():
                passed = [pattern for pattern in entry.get("skip", []) if "*" in pattern]
                for file in (ROOT / "graphs" / entry["folder"]).glob("*.yaml"):
                    with self.subTest(graph=f"{entry['folder']}/{file.stem}"):
                        self.assertTrue(f"{entry['folder']}/{file.stem}" in run or any(file.match(pattern + ".yaml") for pattern in passed))

    def test_every_command_is_in_it_and_names_graphs_that_exist(self):
        for entry in gallery.entries():
            for command in gallery.commands(entry) + entry.get("touch", []):
                with self.subTest(command=command):
                    self.assertIn(f"`{command}`", self.page)
                    for name in re.findall(r"(?:run|view|--over) ([a-z_0-9]+/[a-z_0-9]+)", command):
                        self.assertTrue((ROOT / f"graphs/{name}.yaml").exists(), name)
                    for name in re.findall(r"--over ([a-z_0-9]+)(?![a-z_0-9/])", command):
                        self.assertTrue((ROOT / f"graphs/methods/{name}.yaml").exists(), name)

    def test_every_study_has_a_row_whose_page_names_it(self):
        shown = {name: where for entry in gallery.entries() for name, where in entry.get("studies", {}).items()}
        self.assertEqual(set(shown), {file.stem for file in (ROOT / "graphs/studies").glob("*.yaml")})
        for name, where in shown.items():
            with self.subTest(study=name):
                self.assertIn(name, (ROOT / "docs" / where).read_text())
                self.assertIn(f"`tactor study {name}`", self.page)

    def test_every_picture_exists_is_small_and_is_made_by_a_script(self):
        made = {file: by for entry in gallery.entries() for file, by, _ in gallery.pictures(entry)}
        shown = {str((ROOT / "docs" / image).resolve().relative_to(ROOT)) for image in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", self.page)}
        self.assertEqual(shown, set(made))
        self.assertEqual({file.name for file in (ROOT / "docs/images/gallery").iterdir()},
                         {pathlib.Path(file).name for file, by in made.items() if by == "scripts/gallery"})
        for file, by in made.items():
            with self.subTest(picture=file):
                self.assertLess((ROOT / file).stat().st_size, 150_000)
                self.assertTrue((ROOT / by).stat().st_mode & 0o100)
        for entry in gallery.entries():
            self.assertTrue(gallery.pictures(entry))

    def test_the_index_holds_every_section_once_and_in_order_with_its_picture_and_a_line(self):
        index, sections = page.block("gallery", "INDEX"), self.page.partition("<!-- INDEX: end -->")[2].split("\n### ")[1:]
        self.assertEqual(len(sections), len(gallery.entries()))
        cells = re.findall(r"\[!\[([^\]]+)\]\(([^)]+)\)\]\(#([\w-]+)\)<br>\[([^\]]+)\]\(#([\w-]+)\): ([^|]+) \|", index)
        self.assertEqual(index.count("!["), len(cells))
        self.assertEqual([title for _, _, _, title, _, _ in cells], [section.partition("\n")[0] for section in sections])
        for (spoken, picture, link, title, same_link, line), section in zip(cells, sections):
            with self.subTest(section=title):
                self.assertEqual((spoken, same_link), (title, link))
                self.assertEqual(picture, re.search(r"!\[[^\]]*\]\(([^)]+)\)", section)[1])
                self.assertLessEqual(len(line), 40)
        self.assertEqual(index, gallery.index().strip(), "run scripts/gallery --index")

    def test_a_verdict_says_what_grew_and_what_a_live_run_missed(self):
        self.assertEqual(gallery.verdict({"clock": "virtual", "stability": {"verdict_name": "energy", "passive": 0}}), "energy growth, not passive")
        self.assertEqual(gallery.verdict({"clock": "real", "device": {"missed": 3, "ticks": 9, "faults": 2, "link": {"cycles": 7, "errors": {"crc": 1}}}}),
                         "done, not judged, faults of the gate: 2, 3 of 9 ticks missed, errors of the line: 1 in 7 cycles")


class Trust(unittest.TestCase):
    def test_every_promise_names_tests_that_exist_and_stands_in_the_page(self):
        rows = list(trust.promise_rows(trust.declared()))
        self.assertGreater(len(rows), 10)
        self.assertEqual(page.block("trust/safety", "PROMISES"),
                         trust.table(["promise", "where it is set", "the tests that hold it"], rows).strip())

    def test_a_promise_whose_test_is_gone_is_an_error(self):
        gone = {"promises": [{"promise": "", "where": "", "tests": [{"tests/docs/trust_test.py": "test_of_nothing"}]}]}
        with self.assertRaisesRegex(ValueError, "test_of_nothing"):
            list(trust.promise_rows(gone))

    def test_a_program_of_others_that_its_test_does_not_name_is_an_error(self):
        with self.assertRaisesRegex(ValueError, "fortran"):
            list(trust.peer_rows({"peers": [{"name": "", "file": "scripts/test", "word": "fortran", "package": "", "what": ""}]}))

    def test_programs_of_others_are_there_and_in_the_page(self):
        said = (ROOT / "docs/trust/how_it_is_tested.md").read_text()
        for row in trust.peer_rows(trust.declared()):
            self.assertIn(f"| {row[0]} | {row[1]} | {row[2]} |", said)

    def test_each_test_file_counts_once(self):
        found = [file for files in trust.kinds(trust.declared()).values() for file in files]
        self.assertEqual(len(found), len(set(found)))
        tests = {file for suffix in ("cpp", "py") for file in (ROOT / "tests").rglob(f"*_test.{suffix}")}
        self.assertFalse(tests - set(found))

    def test_every_fuzz_target_is_counted(self):
        rows = list(trust.fuzz_rows())
        targets = {file.stem for file in (ROOT / "tests/fuzz").glob("*.cpp")} - {"replay"}
        self.assertEqual({row[0].strip("`") for row in rows}, targets)
        self.assertTrue(all(row[2] > 0 for row in rows))

    def test_links_of_the_pages_at_the_top_lead_somewhere(self):
        for name in ("SECURITY.md", "CODE_OF_CONDUCT.md"):
            for link in re.findall(r"\]\(([^)\s#]+)", (ROOT / name).read_text()):
                with self.subTest(page=name, link=link):
                    self.assertTrue((ROOT / link).exists())


class WorstCases(unittest.TestCase):
    def test_the_page_of_limits_begins_with_what_the_pages_of_results_say(self):
        self.assertEqual(page.block("trust/limits", "WORST"), worst_cases.text().strip(), "run scripts/limits --worst")

    def test_tables_are_read_with_their_headings(self):
        text = "# A\n\n| a |  |  |\n|---|---|---|\n| 1 | 2 | 3 |\n\n## B\n\n| c |\n|---|\n| 1,234 (x) |\n| - 5 |\n"
        (first, one), (second, two) = worst_cases.tables(text)
        self.assertEqual((first, one), ("A", [{"a": "1", "": "2"}]))
        self.assertEqual((second, two), ("B", [{"c": "1,234 (x)"}, {"c": "- 5"}]))
        self.assertEqual(worst_cases.number(two[0]["c"]), 1234)

    def test_a_page_without_the_table_is_an_error(self):
        with self.assertRaisesRegex(ValueError, "no table"):
            worst_cases.under("results/transfer_results", "Nothing")


class Citation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.said = yaml.safe_load((ROOT / "CITATION.cff").read_text())

    def test_it_has_what_its_schema_requires(self):
        self.assertEqual(self.said["cff-version"], "1.2.0")
        for key in ("message", "title"):
            self.assertTrue(self.said[key])
        self.assertTrue(all(author.get("name") or author.get("family-names") for author in self.said["authors"]))
        for reference in self.said["references"]:
            self.assertTrue({"authors", "title", "type"} <= set(reference))

    def test_version_and_licence_are_those_of_the_sources(self):
        version = re.search(r"project\(tactor VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
        self.assertEqual(self.said["version"], version)
        self.assertIn(f"version = {{{version}}}", (ROOT / "docs/cite.md").read_text())
        self.assertEqual(self.said["license"], "Apache-2.0")
        self.assertIn("Apache License", (ROOT / "LICENSE").read_text())

    def test_the_paper_is_the_one_of_the_method(self):
        paper, = self.said["references"]
        self.assertIn(paper["title"], (ROOT / "docs/explanation/method.md").read_text())
        self.assertIn(paper["title"], (ROOT / "docs/cite.md").read_text())


class Forms(unittest.TestCase):
    TYPES = {"markdown", "textarea", "input", "dropdown", "checkboxes"}

    def test_forms_have_what_a_forge_requires(self):
        forms = [file for file in sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml")) if file.stem != "config"]
        self.assertEqual([file.stem for file in forms], ["bug", "feature", "force", "question"])
        for file in forms:
            with self.subTest(form=file.name):
                form = yaml.safe_load(file.read_text())
                self.assertTrue(form["name"] and form["description"])
                asked = [part for part in form["body"] if part["type"] != "markdown"]
                self.assertTrue(asked)
                self.assertEqual(len(asked), len({part["id"] for part in asked}))
                for part in form["body"]:
                    self.assertIn(part["type"], self.TYPES)
                    self.assertTrue(part["attributes"]["value" if part["type"] == "markdown" else "label"])
                    if part["type"] in ("dropdown", "checkboxes"):
                        self.assertTrue(part["attributes"]["options"])

    def test_the_workflow_runs_what_a_machine_of_ones_own_runs(self):
        flow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text())
        job, = flow["jobs"].values()
        self.assertTrue(any(".ci/run" in step.get("run", "") for step in job["steps"]))
        self.assertIn("scripts/test", (ROOT / ".ci/run").read_text())


class Badge(unittest.TestCase):
    def write(self, name, **statuses):
        file = self.folder / name
        cases = "".join(f'<testcase name="{test}" classname="{test}" time="1" status="{status}"/>' for test, status in statuses.items())
        file.write_text(f'<testsuite name="x">{cases}</testsuite>')
        return file

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_all_parts_of_a_run_are_counted_and_what_passed_when_it_was_tried_again_has_passed(self):
        parts = self.write("tests.xml", a="run", b="run", c="fail", d="notrun"), self.write("tests_live.xml", e="run", f="fail", g="fail")
        self.assertEqual(badge.counted(*parts), (3, 3, 1))
        self.assertEqual(badge.counted(*parts, self.write("tests_last.xml", f="run", g="fail", h="run")), (5, 2, 1))
        self.assertEqual(badge.words(7, 2, 1), "7 passed, 2 failed, 1 skipped")

    def test_the_picture_is_one_and_says_it(self):
        picture = xml.fromstring(badge.drawn("tests", "9 passed at abc", badge.GREEN))
        self.assertEqual([text.text for text in picture.iter("{http://www.w3.org/2000/svg}text")], ["tests", "9 passed at abc"])
        self.assertLess(len("9 passed at abc") * 6, int(picture.get("width")))


if __name__ == "__main__":
    unittest.main()
