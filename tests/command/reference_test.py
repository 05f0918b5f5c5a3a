"""The reference in docs/reference is what the program declares; manual pages and completion come from the same declarations."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import yaml

from harness import GRAPHS, ROOT, TACTOR, CommandTest, needs_devices, needs_meshes, tactor

REFERENCE = ROOT / "docs/reference"
COMPLETION = ROOT / "scripts/completion"
MARK = "<!-- Made by `tactor reference` from declarations; do not edit. -->"


def texts(folder):
    """The pages of a folder by their paths in it."""
    return {path.relative_to(folder).as_posix(): path.read_text() for path in sorted(folder.rglob("*")) if path.is_file()}


class Pages(CommandTest):
    def setUp(self):
        super().setUp()
        self.made = self.folder / "reference"
        self.run_ok("reference", self.made)
        self.pages = texts(self.made)

    @needs_meshes
    @needs_devices
    def test_those_in_the_docs_are_up_to_date(self):
        kept = {name: text for name, text in texts(REFERENCE).items() if MARK in text or name.startswith(("nodes/", "verbs/"))}
        again = "write it again: rm -r docs/reference/{nodes,verbs}; tactor reference docs/reference"
        self.assertEqual(sorted(kept), sorted(self.pages), again)
        for name, text in self.pages.items():
            with self.subTest(page=name):
                self.assertEqual(kept[name], text, again)

    def message(self, name):
        return self.pages["message_types.md"].partition(f"\n## {name}\n")[2].partition("\n## ")[0]

    def test_every_page_has_a_title_and_its_mark(self):
        self.assertGreater(len(self.pages), 60)
        for name, text in self.pages.items():
            with self.subTest(page=name):
                self.assertTrue(text.startswith("# "), text[:40])
                self.assertEqual(text.splitlines()[2], MARK)
                self.assertEqual(len(re.findall(r"^# ", text, re.MULTILINE)), 1)

    def test_every_node_type_has_a_page_and_a_line_of_the_index(self):
        types = [line.split()[0] for line in self.run_ok("nodes").stdout.splitlines()]
        self.assertEqual(sorted(f"nodes/{one}.md" for one in types), sorted(n for n in self.pages if n.startswith("nodes/")))
        for one in types:
            self.assertEqual(self.pages["nodes.md"].count(f"| [{one}](nodes/{one}.md) |"), 1, one)

    def test_every_verb_has_a_page(self):
        shown = re.findall(r"^  ([a-z]+) +\S", self.run_ok("--help").stdout.split("Subcommands:")[1], re.MULTILINE)
        self.assertGreater(len(shown), 20)
        for verb in [*shown, "task", "reference", "complete"]:
            self.assertIn(f"verbs/{verb}.md", self.pages)
        self.assertIn("| `--judge warm\\|whole` |", self.pages["verbs/study.md"])
        self.assertIn("## tactor mesh repair", self.pages["verbs/mesh.md"])
        for page in ("verbs/run.md", "verbs/mesh.md"):
            self.assertIn("0 done, 1 failed while running, 2 bad input", self.pages[page])

    def test_prose_is_folded(self):
        for name, text in self.pages.items():
            inside = False
            for line in text.splitlines():
                inside ^= line.startswith("```")
                # A link or a word may be longer alone.
                if not inside and not line.startswith(("|", "#")) and len(line) > 120:
                    self.assertNotIn(" ", re.sub(r"\[[^\]]*\]\([^)]*\)|`[^`]*`", "x", line).strip(), f"{name}: {line}")

    def test_tables_have_as_many_cells_as_heads(self):
        for name, text in self.pages.items():
            for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
                cells = {len(re.findall(r"(?<!\\)\|", line)) for line in table.splitlines()}
                self.assertEqual(len(cells), 1, f"{name}: {table[:200]}")

    def test_examples_of_nodes_name_what_must_be_given(self):
        for name, text in self.pages.items():
            if not name.startswith("nodes/"):
                continue
            with self.subTest(page=name):
                example = yaml.safe_load(re.search(r"```yaml\n(.*?)```", text, re.DOTALL).group(1))
                (node, said), = example["nodes"].items()
                self.assertEqual(said["type"], name[len("nodes/"):-len(".md")])
                parameters = text.partition("## Parameters")[2].partition("\n## ")[0]
                required = re.findall(r"^\| `(\w+)` \| .*? \| required \|", parameters, re.MULTILINE)
                self.assertEqual(set(said) - {"type"}, set(required))
                inputs = re.findall(r"^\| `(\w+)` \| \[([\w.]+)\][^|]* \| required", text.partition("## Outputs")[0], re.MULTILINE)
                # The view alone sends the cursor of a mouse.
                inputs = [port for port, message in inputs if "\n- Sent by " in self.message(message)]
                fed = [edge.split("-> ")[1].split(".")[1] for edge in example.get("edges", [])]
                self.assertEqual(sorted(fed), sorted(inputs))

    def test_the_graphs_that_use_a_node_name_it(self):
        page = self.pages["nodes/prediction.local.md"]
        used = re.findall(r"\((\S+/graphs/\S+\.yaml)\)", page)
        self.assertTrue(used)
        for link in used:
            self.assertIn("prediction.local", (REFERENCE / "nodes" / link).resolve().read_text())

    def test_marks_of_markdown_in_texts_are_escaped(self):
        self.assertIn("`[0, 0, 0]`", self.pages["nodes/usb.device.md"])
        for name, text in self.pages.items():
            plain = re.sub(r"```.*?```|`[^`]*`|<!--.*?-->|\[[^\]]*\]\([^)]*\)", "", text, flags=re.DOTALL)
            plain = re.sub(r"\\[\\*\[\]<$|~_]", "", plain)
            self.assertIsNone(re.search(r"[*\[\]$]|~~|<[\w/!]", plain), name)

    def test_every_key_of_the_readers_is_listed(self):
        page = self.pages["graph_keys.md"]
        for key in ("duration", "scene.bodies.NAME.mass", "scene.bodies.NAME.material.patch_area", "live.pool.workers",
                    "nodes.NAME.lane", "nodes.NAME.cost.per_contact", "edges[].delay", "baseline", "run_timeout"):
            self.assertIn(f"| `{key}` |", page)
        self.assertRegex(page, r"\| `scene\.bodies\.NAME\.material\.stiffness` \| number \| N/m \| `2000` \|")
        for row in re.findall(r"^\| `.*$", page, re.MULTILINE):
            self.assertRegex(row, r" \| \S[^|]* \|$", "a key without a word about it")
        # What a study's reader takes is what the page lists.
        done = tactor("study", self.write("study.yaml", f"graphs: [{GRAPHS / 'wall/refit.yaml'}]\nno_such_key: 1\n"))
        listed = re.findall(r"^\| `(\w+)` \|", page.partition("## Study files")[2], re.MULTILINE)
        self.assertGreater(len(listed), 15)
        for key in listed:
            if key != "format":
                self.assertIn(key, done.stderr)

    def test_messages_have_fields_with_units(self):
        section = self.message("Wrench")
        self.assertIn("| `force` | f64 \\[3\\] | N | W |", section)
        self.assertRegex(section, r"layout hash `[0-9a-f]{16}`")

    def test_messages_say_what_fields_values_and_stamps_mean(self):
        contacts = " ".join(self.message("ContactSet").split())
        self.assertIn("Stamped valid for the time at which the query began", contacts)
        self.assertRegex(contacts, r"\| `contact\.n_W` \|.*\| Unit normal from the other body towards the moving body T\.")
        self.assertRegex(contacts, r"\| `pair\.other` \|.*-1 where it is fixed\. \|")
        self.assertIn("- `cause` is `stale`: No fresh segment", self.message("SafetyState"))
        for name in re.findall(r"^## (.+)$", self.pages["message_types.md"], re.MULTILINE):
            for row in re.findall(r"^\| `.*$", self.message(name), re.MULTILINE):
                self.assertRegex(row, r"\. \|$", f"{name}: a field without its meaning")


class Manual(CommandTest):
    def setUp(self):
        super().setUp()
        self.run_ok("reference", "--man", self.folder / "man")
        self.pages = sorted((self.folder / "man").glob("*"))

    def test_there_is_one_for_the_command_and_each_verb(self):
        names = [page.name for page in self.pages]
        self.assertIn("tactor.1", names)
        for verb in ("run", "study", "mesh", "view", "reference"):
            self.assertIn(f"tactor-{verb}.1", names)
        self.assertIn(".BR tactor\\-run (1)", (self.folder / "man/tactor.1").read_text())
        self.assertIn("\\fB\\-\\-judge\\fR \\fIwarm|whole\\fR", (self.folder / "man/tactor-study.1").read_text())

    @unittest.skipUnless(shutil.which("groff"), "groff-base is not installed")
    def test_groff_has_no_warning(self):
        for page in self.pages:
            done = subprocess.run(["groff", "-man", "-ww", "-z", page], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), page.name)

    @unittest.skipUnless(shutil.which("mandoc"), "mandoc is not installed")
    def test_mandoc_has_no_warning(self):
        done = subprocess.run(["mandoc", "-Tlint", "-W", "warning", *self.pages], capture_output=True, text=True, check=False)
        self.assertEqual(done.stdout + done.stderr, "")

    @unittest.skipUnless(shutil.which("groff"), "groff-base is not installed")
    def test_texts_come_through(self):
        shown = subprocess.run(["groff", "-man", "-Tascii", "-P-cbou", self.folder / "man/tactor-run.1"], capture_output=True,
                               text=True, check=True).stdout
        self.assertIn("tactor run [OPTIONS] graph", shown)
        self.assertIn("--record-costs FOLDER", shown)
        self.assertIn("the graph's", shown)


class Completion(CommandTest):
    def candidates(self, *words):
        lines = self.run_ok("complete", "--", *words).stdout.splitlines()
        return [line.split("\t")[0] for line in lines]

    def test_verbs_and_their_verbs(self):
        self.assertEqual(self.candidates("stu"), ["study"])
        self.assertIn("run", self.candidates(""))
        self.assertNotIn("task", self.candidates(""))
        self.assertEqual(self.candidates("mesh", ""), ["check", "info", "repair", "decimate"])

    def test_options_and_the_values_of_a_fixed_set(self):
        self.assertEqual(self.candidates("run", "wall/refit", "--re"), ["--record-costs", "--reference"])
        self.assertEqual(self.candidates("study", "x", "--judge", ""), ["warm", "whole"])
        self.assertEqual(self.candidates("study", "x", "--judge=wh"), ["--judge=whole"])
        self.assertEqual(self.candidates("study", "x", "--cluster", ""), ["slurm", "local", ":files"])
        self.assertIn("--max-hole", self.candidates("mesh", "repair", "--"))

    @needs_meshes
    def test_names_of_what_is_shipped(self):
        self.assertEqual([w for w in self.candidates("run", "bunny/local") if w == "bunny/local"], ["bunny/local"])
        self.assertIn("wall/refit", self.candidates("view", "--device", "mouse", "wall/"))
        self.assertNotIn("methods/kalman", self.candidates("run", ""))
        self.assertIn("kalman", self.candidates("run", "wall/scene", "--over", "ka"))
        self.assertIn("stability_shipped", self.candidates("study", "stab"))
        self.assertIn("duck.off", self.candidates("mesh", "info", "du"))
        self.assertIn("prediction.refit", self.candidates("nodes", "prediction.r"))
        self.assertIn("Wrench", self.candidates("import", "a.csv", "a.h5", "--type", "Wr"))

    def test_files_and_folders_are_asked_for(self):
        self.assertIn(":files", self.candidates("run", ""))
        self.assertEqual(self.candidates("run", "wall/refit", "--out", ""), [":folders"])
        self.assertEqual(self.candidates("run", "wall/refit", ""), [])
        self.assertIn("wall/refit", self.candidates("compare", "wall/off", "wall/"))

    def in_shell(self, *command, **more):
        environment = {**os.environ, "PATH": f"{pathlib.Path(TACTOR).resolve().parent}:{os.environ['PATH']}", **more}
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder, env=environment, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split()

    def bash(self, *words):
        listed = " ".join(f"'{word}'" for word in words)
        return self.in_shell("bash", "-c", f". '{COMPLETION}/tactor.bash'; COMP_WORDS=(tactor {listed}); COMP_CWORD={len(words)}; "
                                           "_tactor; printf '%s\\n' \"${COMPREPLY[@]}\"")

    def test_bash(self):
        (self.folder / "bunny.yaml").touch()
        (self.folder / "results").mkdir()
        self.assertEqual(self.bash("stu"), ["study"])
        self.assertIn("--judge", self.bash("study", "x", "--j"))
        self.assertEqual(self.bash("study", "x", "--judge", "=", "wa"), ["warm"])
        self.assertEqual(self.bash("study", "x", "--judge", "="), ["warm", "whole"])
        self.assertIn("wall/refit", self.bash("run", "wall/re"))
        self.assertIn("bunny.yaml", self.bash("run", "bun"))
        self.assertEqual(self.bash("run", "bunny.yaml", "--out", "re"), ["results"])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh(self):
        subprocess.run(["zsh", "-n", COMPLETION / "_tactor"], check=True)
        # What zsh's own functions would be given.
        script = f"""_describe() {{ print -l -- ${{(P)4}}; }}
                     _files() {{ print FILES $*; }}
                     source {COMPLETION}/_tactor
                     words=(tactor $@); CURRENT=$#words; _tactor"""
        shown = self.in_shell("zsh", "-f", "-c", script, "zsh", "study", "x", "--judge", "wa")
        self.assertEqual(shown, ["warm:"])
        shown = self.in_shell("zsh", "-f", "-c", script, "zsh", "run", "wall/re")
        self.assertIn("wall/refit:", shown)
        self.assertEqual(shown[-1], "FILES")

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish(self):
        subprocess.run(["fish", "--no-execute", COMPLETION / "tactor.fish"], check=True)

        def fish(line):
            return self.in_shell("fish", "--no-config", "-c", f"source {COMPLETION}/tactor.fish; complete --do-complete '{line}'",
                                 HOME=str(self.folder))

        self.assertEqual(fish("tactor study x --judge wa"), ["warm"])
        self.assertIn("wall/refit", fish("tactor run wall/re"))
        self.assertEqual(fish("tactor stu")[0], "study")


if __name__ == "__main__":
    unittest.main()
