"""Runs studies, and looks at their tables and processes."""
import csv
import os
import pathlib
import sqlite3
import subprocess
import time

from harness import GRAPHS, TACTOR, CommandTest, tactor

RECORDED = GRAPHS / "recorded/scene.yaml"
FAULT_NODES = pathlib.Path(os.environ.get("TACTOR_BUILD", pathlib.Path(TACTOR).resolve().parents[1])) / "tests/nodes"


class StudyTest(CommandTest):
    def study(self, text, out, *options, code=0, **more):
        file = self.folder / "study.yaml"
        if text is not None:
            file.write_text(text)
        result = tactor("study", file, "--out", self.folder / out, *options, environment=self.environment, **more)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def table(self, out, query):
        with sqlite3.connect(f"file:{self.folder / out / 'study.sqlite'}?mode=ro", uri=True) as db:
            return db.execute(query).fetchall()

    def bytes_of(self, out, name="study.csv"):
        return (self.folder / out / name).read_bytes()

    def lines(self, out, name="study.csv"):
        return list(csv.DictReader(self.bytes_of(out, name).decode().splitlines()))

    def start(self, out, *options, **more):
        """The command in the background, once its table has some runs and is not yet whole."""
        process = subprocess.Popen([TACTOR, "study", self.folder / "study.yaml", "--out", self.folder / out, *options],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=dict(os.environ, **self.environment), **more)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)

        def some():
            try:
                return self.table(out, "SELECT count(*) FROM runs")[0][0] >= 3
            except sqlite3.OperationalError:  # not made yet
                return False

        self.wait_until(some, process, "its table had three runs")
        return process

    def wait_for(self, condition, what, timeout=120):
        end = time.monotonic() + timeout
        while not condition():
            self.assertLess(time.monotonic(), end, f"{timeout} s have gone by before {what}")
            time.sleep(0.02)


def stat(pid):
    """State and parent of a process; nothing where there is none."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[:2]
    except OSError:
        return None


def is_alive(pid):
    return (stat(pid) or "Z")[0] not in "ZX"


def children(parent):
    pids = [int(folder.name) for folder in pathlib.Path("/proc").iterdir() if folder.name.isdigit()]
    return [pid for pid in pids if (stat(pid) or " ?")[1] == str(parent)]
