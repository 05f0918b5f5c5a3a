"""A report is written whatever gnuplot does, and its charts do not depend on the settings of who calls."""
import concurrent.futures
import json
import os
import pathlib
import shutil
import signal
import subprocess
import unittest

from harness import TACTOR, CommandTest, tactor

FAKE = {  # what a gnuplot does: what the report says of it
    "exit 3": "gnuplot could not draw it",
    "echo it is broken >&2; exit 1": "gnuplot could not draw it: it is broken",
    "exit 0": "what gnuplot has drawn is not whole",
    "cat >/dev/null; echo garbage": "what gnuplot has drawn is not whole",
    "echo '<svg><g>'": "what gnuplot has drawn is not whole",
    "head -c 100000 /dev/urandom": "what gnuplot has drawn is not whole",
    "kill -SEGV $$": "gnuplot was ended by signal 11",
    "kill -KILL $$": "gnuplot was ended by signal 9",
    "exec yes": "gnuplot printed too much and was ended",
    "exec yes >&2": "gnuplot printed too much and was ended",
    "printf '\\033[31m<b>&amp;\\n' >&2; exit 1": "gnuplot could not draw it:  [31m&lt;b&gt;&amp;amp;",
}


class Charts(CommandTest):
    def setUp(self):
        super().setUp()
        # Curves need a recording of what was commanded, which every run has for its report.
        self.graph = self.judged_small_graph()
        self.drawn = self.charts_of(self.report({}))
        self.assertIn("<polyline", self.drawn.replace("<path", "<polyline"))

    def report(self, more, code=0, without=(), cwd=None):
        self.said, page = self.said_and_report(more, code, without, cwd)
        return page

    def said_and_report(self, more, code=0, without=(), cwd=None, out="out"):
        environment = {key: value for key, value in os.environ.items() if key not in without}
        environment.update(self.environment, **more)
        shutil.rmtree(self.folder / out, ignore_errors=True)
        said = subprocess.run([TACTOR, "run", self.graph, "--out", self.folder / out], env=environment, cwd=cwd or self.folder,
                              capture_output=True, text=True, timeout=300, check=False)
        self.assertEqual(said.returncode, code, said.stdout + said.stderr)
        self.assertTrue(json.loads((self.folder / out / "summary.json").read_text()))
        return said, (self.folder / out / "report.html").read_text()

    @staticmethod
    def charts_of(page):
        return "".join(part.split("</svg>")[0] for part in page.split("<svg")[1:])

    def fake(self, script, interpreter="#!/bin/sh\n", programs="programs"):
        programs = self.folder / programs
        programs.mkdir(exist_ok=True)
        gnuplot = programs / "gnuplot"
        gnuplot.write_text(interpreter + script + "\n")
        gnuplot.chmod(0o755)
        return {"PATH": f"{programs}:{os.environ['PATH']}"}

    def temporary(self, name):
        folder = self.folder / name
        folder.mkdir()
        return {"TMPDIR": str(folder)}


class OfTheSettings(Charts):
    def test_no_setting_of_the_user_changes_a_chart(self):
        home, here = self.folder / "home", self.folder / "here"
        members = 0
        for text in ("exit", "set terminal dumb", "set output '/dev/null'", "set term qt", "system('touch traced')", "nonsense ((", "pause -1",
                     "set decimalsign ','", "set loadpath '/nowhere'"):
            for folder in (home, here):
                folder.mkdir(exist_ok=True)
                (folder / ".gnuplot").write_text(text + "\n")
                (folder / "gnuplotrc").write_text(text + "\n")
            self.assertEqual(self.charts_of(self.report({"HOME": str(home), "XDG_CONFIG_HOME": str(home)}, cwd=here)), self.drawn, text)
            self.assertFalse((here / "traced").exists())
            members += 1
        for more in ({"GNUTERM": "qt"}, {"GNUTERM": "dumb"}, {"GNUTERM": "no_such_terminal"}, {"GNUPLOT_LIB": "/nowhere"},
                     {"GDFONTPATH": "/nowhere"}, {"GNUPLOT_DEFAULT_GDFONT": "no-such-font"}, {"GNUPLOT_FONTPATH": "!false"},
                     {"GNUPLOT_DRIVER_DIR": "/nowhere"}, {"GNUHELP": "/nowhere"}, {"GNUPLOT_PS_DIR": "/nowhere"}, {"DISPLAY": ":77"},
                     {"LC_NUMERIC": "de_DE.UTF-8"}, {"LC_ALL": "de_DE.UTF-8"}, {"LANG": "tr_TR.UTF-8"}, {"LC_ALL": "C"},
                     {"LC_ALL": "POSIX"}, {"LC_ALL": "no such locale"}, {"LANG": "zh_CN.GB18030"}, {"HOME": "/nowhere"}, {"HOME": ""},
                     {"FIT_LOG": "/nowhere"}, {"PAGER": "false"}, {"SHELL": "/bin/false"}, {"TERM": ""}):
            self.assertEqual(self.charts_of(self.report(more)), self.drawn, more)
            members += 1
        for name in ("HOME", "LANG", "TERM", "USER", "TMPDIR", "SHELL"):
            self.assertEqual(self.charts_of(self.report({}, without=(name,))), self.drawn, name)
            members += 1
        self.assertEqual(members, 39)

    def test_no_folder_for_temporary_files_changes_a_chart(self):
        file = self.write("a_file", "")
        closed = self.temporary("closed")
        (self.folder / "closed").chmod(0o500)
        places = [{"TMPDIR": str(self.folder / "nowhere")}, {"TMPDIR": str(file)}, {"TMPDIR": ""}, {"TMPDIR": "/proc"}, closed,
                  self.temporary("it's mine"), self.temporary("a\nb"), self.temporary('a"b'), self.temporary("$(touch traced)"),
                  self.temporary("a b"), {"TMPDIR": "relative"}, {"TMPDIR": "/dev/full"}, {"TMPDIR": "a" * 300}]
        for place in places:
            self.assertEqual(self.charts_of(self.report(place)), self.drawn, place)
            self.assertFalse((self.folder / "traced").exists())
        self.assertEqual(len(places), 13)

    @unittest.skipUnless(os.geteuid() == 0, "only root can mount a small disk")
    def test_a_full_disk_for_temporary_files_changes_no_chart(self):
        disk = self.folder / "disk"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", disk], check=False, capture_output=True).returncode != 0:
            self.skipTest("no disk can be mounted here")
        self.addCleanup(subprocess.run, ["umount", disk], check=True)
        (disk / "filled").write_bytes(b"." * 16384)
        self.assertEqual(self.charts_of(self.report({"TMPDIR": str(disk)})), self.drawn)


class OfGnuplot(Charts):
    def test_whatever_gnuplot_does_is_a_note_in_the_report_and_on_the_terminal(self):
        for script, said in FAKE.items():
            with self.subTest(script=script):
                page = self.report(self.fake(script))
                self.assertIn(f"No chart: {said}", page)
                self.assertIn("no chart: gnuplot" if said.startswith("gnuplot") else "no chart: what gnuplot", self.said.stderr)
                self.assertEqual(self.said.stderr.count("no chart: "), len(set(page.split("No chart: ")[1:])) and 1)
                self.assertNotIn("\x1b", page + self.said.stderr)
        self.assertEqual(len(FAKE), 11)

    def test_a_gnuplot_that_cannot_be_started_is_a_note(self):
        nothing = self.folder / "nothing"
        nothing.mkdir()
        self.assertIn("No chart: gnuplot is not installed where this was written", self.report({"PATH": str(nothing)}))
        self.assertIn("no chart: gnuplot is not installed", self.said.stderr)
        for interpreter, mode in (("#!/no/such/program\n", 0o755), ("neither program nor script", 0o755), ("#!/bin/sh\n", 0o000), ("", 0o755)):
            environment = self.fake("exit 0", interpreter)
            (self.folder / "programs/gnuplot").chmod(mode)
            environment["PATH"] = str(self.folder / "programs")
            self.assertIn("No chart: gnuplot ", self.report(environment))
            self.assertIn("no chart: gnuplot ", self.said.stderr)
        shutil.rmtree(self.folder / "programs")
        (self.folder / "programs/gnuplot").mkdir(parents=True)
        self.assertIn("No chart: gnuplot ", self.report({"PATH": str(self.folder / "programs")}))

    def test_a_gnuplot_that_hangs_ends_and_so_does_all_that_it_has_started(self):
        scripts = ("sleep 1000", "trap '' TERM; sleep 1000 & sleep 1000; sleep 1000", "exec >&- 2>&-; sleep 1000")

        def mark(at):
            return self.folder / f"process_{at}"

        def reported(at):
            return self.said_and_report(self.fake(f"echo $$ > {mark(at)}\n{scripts[at]}", programs=f"programs_{at}"), out=f"out_{at}")
        # Each waits for half a minute, so all wait at once.
        with concurrent.futures.ThreadPoolExecutor(len(scripts)) as pool:
            found = list(pool.map(reported, range(len(scripts))))
        for at, (said, page) in enumerate(found):
            self.assertIn("No chart: gnuplot took longer than 30 s and was ended", page)
            self.assertIn("no chart: gnuplot took longer", said.stderr)
            self.assertEqual(self.members_of(int(mark(at).read_text())), [], scripts[at])

    @staticmethod
    def members_of(group):
        """Processes of the group that live; what has ended may wait for somebody to ask how."""
        found = []
        for file in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                state, _, its_group = file.read_text().rpartition(")")[2].split()[:3]
            except OSError:  # it has ended meanwhile
                continue
            if int(its_group) == group and state not in "ZX":
                found.append(file)
        return found

    def test_a_signal_does_not_wait_for_gnuplot(self):
        environment = dict(os.environ, **self.environment, **self.fake(f"touch {self.folder}/drawing; sleep 1000"))
        for number in (signal.SIGTERM, signal.SIGINT):
            process = subprocess.Popen([TACTOR, "run", self.graph, "--out", self.folder / "out", "--overwrite"], env=environment,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            self.wait_until((self.folder / "drawing").exists, process, "gnuplot drew")
            process.send_signal(number)
            said = process.communicate(timeout=120)[1]
            self.assertIn("no chart: gnuplot was interrupted", said)
            (self.folder / "drawing").unlink()

    def test_the_other_commands_with_charts_end_well_too(self):
        environment = {**self.environment, **self.fake("exit 3")}
        graph = self.graph
        result = tactor("compare", graph, "--out", self.folder / "compared", environment=environment)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertTrue((self.folder / "compared/report.html").exists())
        for report in ("table", "work_precision", "stability"):
            study = self.write(f"{report}.yaml", f"graphs: [{graph}]\nvary: {{device.rate: [1 kHz, 500 Hz]}}\nseeds: 1\nreference: none\n"
                                                 f"report: {report}\n")
            result = tactor("study", study, "--out", self.folder / report, environment=environment)
            if result.returncode == 2:  # what this graph has no use for
                continue
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertTrue((self.folder / report / "report.html").exists())


if __name__ == "__main__":
    unittest.main()
