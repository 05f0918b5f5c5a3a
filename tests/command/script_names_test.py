"""Names of users, files and the environment reach scripts as what they are, and run nothing."""
import pathlib
import re
import shutil
import subprocess
import tarfile
import unittest

from cluster_local_test import MANY, ClusterTest
from harness import tactor

# What a shell, a comment, a scheduler or gnuplot would obey: {} is a file that none may make.
HOSTILE = ("a;touch {};", "a`touch {}`", "a$(touch {})", "a' ; touch {} ; '", 'a" ; touch {} ; "', "a|touch {}", "a&&touch {}",
           "a>{}", "a\\", "a b  c", "*", "~", "#a", "-rf", "--checkpoint-action=exec=touch {}", "a%j", "{{name}}", "!touch {}",
           "a'\\''b", "@x", "a\u2028touch {}", "é")
CONTROLS = ("\n", "\r", "\t", "\x1b", "\x07", "\x7f", "\x01", "\n#SBATCH --wrap=touch x\n")


class Names(ClusterTest):
    def setUp(self):
        super().setUp()
        self.trace = self.folder / "traced"
        self.environment["HOME"] = str(self.folder)

    def tried(self, names):
        # A file's name has no slash: commands are run in the folder of the trace.
        return [name.replace("{}", self.trace.name).replace("{{name}}", "{name}") for name in names]

    def study_named(self, name, *options, out=None, environment=None):
        file = self.folder / f"{name}.yaml"
        file.write_text(MANY.replace("seeds: 12", "seeds: 2"))
        result = tactor("study", f"./{name}.yaml", *(["--out", out] if out else []), *options, cwd=self.folder,
                        environment={**self.environment, **(environment or {})})
        file.unlink()
        return result

    def nothing_ran(self, name):
        self.assertFalse(self.trace.exists(), f"{name!r} ran a command")
        self.assertFalse((self.folder / "x").exists())


class OfAStudy(Names):
    def test_a_study_runs_on_a_cluster_whatever_its_name_is(self):
        names = self.tried(HOSTILE)
        for name in names:
            with self.subTest(name=name):
                result = self.study_named(name, "--cluster", "local", "--wait", out=f"out/{name}")
                self.nothing_ran(name)
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                self.assertTrue((self.folder / "out" / name / "study.csv").exists())
        self.assertGreaterEqual(len(names), 20)

    def test_a_control_character_in_the_name_of_study_folder_method_or_graph_is_refused(self):
        members = 0
        graph = MANY.split("[")[1].split("]")[0]
        for control in CONTROLS:
            if "/" in control:
                continue
            name = f"a{control}touch x"
            quoted = name.encode("unicode_escape").decode()
            copied = self.folder / f"{name}.yaml"
            shutil.copy(pathlib.Path(graph).parent / "scene.yaml", self.folder / "plain.yaml")
            wrong = {
                "study": lambda: self.study_named(name, "--cluster", "local", "--wait", out="out/good"),
                "folder": lambda: self.study_named("good", "--cluster", "local", "--wait", out=f"out/{name}"),
                "method": lambda: self.study_of(f'methods: [{{"{quoted}": {{}}}}]'),
                "axis": lambda: self.study_of(f'vary: {{"{quoted}": {{swap: {{one: {{}}, two: {{}}}}}}}}'),
                "swap": lambda: self.study_of(f'vary: {{axis: {{swap: {{"{quoted}": {{}}, two: {{}}}}}}}}'),
                "graph": lambda: self.study_of("", graphs=copied),
            }
            for what, ask in wrong.items():
                with self.subTest(what=what, control=control):
                    result = ask()
                    self.nothing_ran(name)
                    self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                    self.assertIn("control characters", result.stderr)
                    self.assertFalse(list(self.folder.glob("out/**/*.sh")))
                members += 1
        self.assertGreaterEqual(members, 42)

    def study_of(self, keys, graphs=None):
        graph = MANY.split("[")[1].split("]")[0]
        if graphs is not None:
            text = pathlib.Path(graph).read_text()
            graphs.write_text(text.replace("extends: ", f"extends: {pathlib.Path(graph).parent}/") if "extends: " in text else text)
        listed = '"' + str(graphs).encode("unicode_escape").decode() + '"' if graphs else graph
        file = self.write("good.yaml", f"graphs: [{listed}]\nseeds: 1\nduration: 1 s\nreference: none\n{keys}\n")
        return tactor("study", file, "--cluster", "local", "--wait", "--out", self.folder / "out/good", environment=self.environment)


class OfTheEnvironment(Names):
    def test_values_of_variables_reach_the_job_as_they_are(self):
        values = self.tried(HOSTILE)
        variables = {f"TACTOR_TRIED_{at}": value for at, value in enumerate(values)}
        result = self.study_named("good", "--cluster", "local", "--wait", out="out/good", environment=variables)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.nothing_ran("a value")
        script = (self.folder / "out/good/cluster/jobs/0000.sh").read_text()
        exports = "".join(line + "\n" for line in script.split("\n") if line.startswith("export TACTOR_TRIED_"))
        for name, value in variables.items():
            said = subprocess.run(["sh", "-c", f'{exports}printf %s "${name}"'], capture_output=True, text=True, check=True, cwd=self.folder)
            self.assertEqual(said.stdout, value)
        self.nothing_ran("a value")

    def test_a_variable_that_no_script_could_export_is_refused(self):
        names = ("TACTOR_A;touch x;B", "TACTOR_$(touch x)", "TACTOR_A\ntouch x\n", "TACTOR_A B", "TACTOR_A-B", "TACTOR_%%", "TACTOR_é")
        for name in names:
            with self.subTest(name=name):
                result = self.study_named("good", "--cluster", "local", "--wait", out="out/good", environment={name: "1"})
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertIn("environment variable", result.stderr)
                self.nothing_ran(name)
        for control in CONTROLS:
            result = self.study_named("good", "--cluster", "local", "--wait", out="out/good", environment={"TACTOR_A": f"a{control}touch x"})
            self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
            self.assertIn("the environment variable TACTOR_A: ", result.stderr)
            self.nothing_ran(control)

    def test_a_cluster_file_whose_index_is_no_variable_is_refused(self):
        for index in ("I}; touch x; ${I", "$(touch x)", "1I", "I-1", "a b"):
            file = self.write("mine.yaml", f"submit: [echo, '{{script}}']\nstatus: ['true']\ncancel: ['true']\nindex: '{index}'\n"
                                           "states: {waiting: [Q], running: [R]}\n")
            result = self.study_named("good", "--cluster", file, out="out/good")
            self.assertEqual(result.returncode, 2)
            self.assertIn("mine.yaml:4:8: index: expected the name of a variable", result.stderr)

    def test_values_in_a_word_that_a_shell_reads_are_quoted(self):
        names = self.tried(HOSTILE)
        word = 'echo 7; printf "%s\\n" {script} {name} >> said'
        shells = (("sh, -c", names), ("bash, -ec", names[:4]), ("env, sh, -xc", names[:4]), ("timeout, 9, sh, -c", names[:4]))
        for at, (shell, tried) in enumerate(shells):
            file = self.write("mine.yaml", f"submit: [{shell}, '{word}']\nstatus: ['true']\ncancel: ['true']\nindex: I\n"
                                           "states: {waiting: [Q], running: [R]}\n")
            for name in tried:
                with self.subTest(shell=shell, name=name):
                    result = self.study_named(name, "--cluster", file, out=f"out_{at}/{name}")
                    self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                    self.nothing_ran(name)
                    said = (self.folder / "said").read_text().split("\n")
                    self.assertEqual(said[0], str(self.folder / f"out_{at}" / name / "cluster/jobs/0000.sh"))
                    self.assertTrue(said[1].startswith(f"{name}-"))
                    (self.folder / "said").unlink()
        file.write_text(file.read_text().replace("{script}", '"{script}"'))
        result = self.study_named("good", "--cluster", file, out="out/good")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("no quotes round {...}", result.stderr)

    def test_a_word_that_a_shell_hands_to_another_is_refused_and_a_script_that_ends_like_one_is_not(self):
        refused = ("sh, -c, 'ssh host qsub {script}'", "bash, -c, 'cd x && sh -c {script}'", "ssh, host, 'eval {script}'",
                   "sh, -c, 'x=$(ssh host echo {script})'", "ssh, host, 'su - -c {script}'", "sh, -c, '/usr/bin/ssh host {name} {script}'",
                   "sh, -c, 'sbatch --wrap={script}'", "sh, -c, 'ssh host qsub \"$1\"', x, '{script}'", "sh, -c, 'echo {script} | at now'",
                   "sh, -c, 'echo {script} | bash'", "sh, -c, 'bash -ec {script}'", "rsh, host, 'eval {script}'")
        taken = ("sh, -c, 'echo 7 ./submit.sh {script}'", "sh, -c, 'echo 7 push finish {script}'", "sh, -c, 'echo 7', '{script}'",
                 "sh, -c, 'echo 7 -S /bin/sh {script}'", "sh, -c, 'echo 7 -l host=x {script}; true'", "sh, -c, 'cd {here} && echo 7 sh ./x {script}'",
                 "sh, -c, 'echo 7 {script} | cat'", "sh, -c, 'echo 7 -c {script}'")
        for code, members in ((2, refused), (0, taken)):
            for at, submit in enumerate(members):
                file = self.write("mine.yaml", f"submit: [{submit}]\nstatus: ['true']\ncancel: ['true']\nindex: I\n"
                                               "states: {waiting: [Q], running: [R]}\n")
                with self.subTest(submit):
                    result = self.study_named("good", "--cluster", file, out=f"inner_{code}_{at}/good")
                    self.assertEqual(result.returncode, code, result.stdout + result.stderr)
                    self.assertEqual("expected no second shell" in result.stderr, code == 2)


class OfABundle(Names):
    def test_a_bundle_is_made_and_runs_whatever_its_name_is(self):
        """The first is unpacked and run in folders of all these names; of the others the archive is looked at."""
        graph = self.judged_small_graph()
        study = self.write("good.yaml", f"graphs: [{graph.name}]\nvary: {{device.rate: [1 kHz, 500 Hz]}}\nseeds: 1\nreference: none\n")
        unpacked = None
        names = [name for name in self.tried(HOSTILE) if not name.startswith("~")]
        for name in ("first", *names[:3], "--checkpoint-action=exec=touch traced"):
            archive = f"{name}.tar.gz"
            result = tactor("bundle", study, f"--out=./{archive}", cwd=self.folder, environment=self.environment)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.nothing_ran(name)
            with tarfile.open(self.folder / archive) as packed:
                self.assertTrue(all(member.split("/")[0] == name for member in packed.getnames()))
                if unpacked is None:
                    packed.extractall(self.folder)
                    unpacked = self.folder / name
            (self.folder / archive).unlink()
        for name in (*names, "a:b"):
            unpacked = unpacked.rename(self.folder / name)
            with self.subTest(name=name):
                # Both end a name in LD_LIBRARY_PATH.
                code = 2 if ":" in name or ";" in name else 0
                link = self.folder / "links/tactor"
                link.parent.mkdir(exist_ok=True)
                link.unlink(missing_ok=True)
                link.symlink_to(unpacked / "tactor")
                for program, where, more in ((unpacked / "tactor", self.folder, {}), ("./tactor", unpacked, {"CDPATH": "/"}),
                                             (link, self.folder, {})):
                    said = subprocess.run([program, "--version"], capture_output=True, text=True, cwd=where, check=False,
                                          env={"PATH": "/usr/bin:/bin", **more})
                    self.assertEqual(said.returncode, code, said.stderr)
                    self.assertEqual("expected a folder without : and ;" in said.stderr, code == 2)
                    self.nothing_ran(name)

    def test_a_control_character_in_the_name_of_an_archive_is_refused(self):
        study = self.write("good.yaml", MANY)
        for control in CONTROLS:
            result = tactor("bundle", study, f"--out=a{control}b.tar.gz", cwd=self.folder, environment=self.environment)
            self.assertEqual(result.returncode, 2)
            self.assertIn("control characters", result.stderr)


class OfPrograms(Names):
    def test_a_graph_is_drawn_in_whatever_folder_temporary_files_go_to(self):
        if shutil.which("dot") is None:
            self.skipTest("graphviz is not installed")
        for name in self.tried(HOSTILE) + ["a\nb", "nowhere/at/all"]:
            result = tactor("graph", self.judged_small_graph(), "--format", "svg", cwd=self.folder,
                            environment={**self.environment, "TMPDIR": str(self.folder / name)})
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("</svg>", result.stdout)
            self.nothing_ran(name)

    def test_no_source_starts_a_shell(self):
        """popen and system hand a text to a shell. What the program starts gets its words as they are."""
        root = pathlib.Path(__file__).resolve().parents[2]
        shell = re.compile(r'\bpopen\(|std::system\(|[^\w.>]system\("')
        found = [file for folder in ("app", "framework", "nodes", "devices", "python") for file in (root / folder).rglob("*.[ch]pp")
                 if shell.search(file.read_text())]
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
