"""A file system without locks, as clusters have them: commands work there, and two still do not write one place."""
import errno
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from harness import TACTOR, CommandTest, needs_hdf5, tactor
from study_harness import StudyTest

# Answers every lock as such a file system does.
SHIM = r"""
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>
int flock(int file, int operation) { errno = atoi(getenv("IMPOSED_ERRNO")); return -1; }
static int answer(int file, int command, void* argument) {
  int locks = command == F_SETLK || command == F_SETLKW || command == F_OFD_SETLK || command == F_OFD_SETLKW;
  if (locks && getenv("IMPOSED_ON_FCNTL")) { errno = atoi(getenv("IMPOSED_ERRNO")); return -1; }
  return syscall(SYS_fcntl, file, command, argument);
}
int fcntl(int file, int command, ...) { va_list l; va_start(l, command); return answer(file, command, va_arg(l, void*)); }
int fcntl64(int file, int command, ...) { va_list l; va_start(l, command); return answer(file, command, va_arg(l, void*)); }
"""
ERRNOS = (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL)
STUDY = """graphs: [{graph}]
vary: {{device.rate: [1 kHz, 500 Hz]}}
seeds: 20
reference: none
"""


@unittest.skipUnless(shutil.which("cc"), "there is no C compiler here")
class WithoutLocks(StudyTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = pathlib.Path(tempfile.mkdtemp(prefix="tactor-test-"))
        cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        (folder / "shim.c").write_text(SHIM)
        cls.shim = folder / "shim.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-o", cls.shim, folder / "shim.c"], check=True)

    def imposed(self, number, on_fcntl):
        return {**self.environment, "LD_PRELOAD": str(self.shim), "IMPOSED_ERRNO": str(number), **({"IMPOSED_ON_FCNTL": "1"} if on_fcntl else {})}

    def members(self):
        return [self.imposed(number, on_fcntl) for number in ERRNOS for on_fcntl in (False, True)]

    def here(self, environment, *arguments, code=0):
        result = tactor(*arguments, environment=environment, cwd=self.folder)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout}{result.stderr}")
        return result

    def signs(self):
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*.held*"))

    @needs_hdf5
    def test_runs_records_exports_compares_and_studies_work_and_leave_no_sign(self):
        graph = self.judged_small_graph("record: [device.state]\n")
        study = self.write("study.yaml", STUDY.format(graph=graph).replace("seeds: 20", "seeds: 2"))
        members = 0
        for environment in self.members():
            for _ in range(2):
                self.here(environment, "run", graph)
            self.assertEqual(sorted(path.name for path in (self.folder / "out").iterdir()), ["judged", "judged_2"])
            said = self.here(environment, "export", "out/judged/recording.h5", "device.state").stdout
            self.assertEqual(said, tactor("export", self.folder / "out/judged/recording.h5", "device.state").stdout)
            self.here(environment, "run", graph, "--out", "out/judged", "--overwrite")
            self.here(environment, "compare", graph, "--out", "compared")
            self.here(environment, "study", study, "--out", "studied")
            self.here(environment, "study", study, "--out", "studied", "--resume")
            self.assertEqual(self.table("studied", "SELECT count(*) FROM runs"), [(4,)])
            self.assertEqual(self.signs(), [])
            for name in ("out", "compared", "studied"):
                shutil.rmtree(self.folder / name)
            members += 1
        self.assertEqual(members, 8)

    def started(self, environment, study, *options):
        process = subprocess.Popen([TACTOR, "study", study, "--out", self.folder / "studied", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, env=dict(os.environ, **environment))
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        sign = self.folder / "studied/study.sqlite.lock.held"
        self.wait_until(lambda: sign.exists() and sign.read_text().startswith(f"{process.pid} "), process, "it held its lock")
        return process

    def test_a_second_command_is_refused_with_the_process_and_one_that_was_killed_is_no_obstacle(self):
        study = self.write("study.yaml", STUDY.format(graph=self.judged_small_graph()).replace("seeds: 20", "seeds: 4000"))
        members = 0
        for environment in self.members():
            first = self.started(environment, study)
            refused = self.here(environment, "study", study, "--out", "studied", "--resume", code=2)
            self.assertIn(f"found another tactor writing it (process {first.pid})", refused.stderr)
            first.kill()
            first.wait()
            again = self.started(environment, study, "--overwrite")
            again.send_signal(signal.SIGTERM)
            self.assertEqual(again.wait(timeout=120), 1)
            self.assertEqual(self.signs(), [])
            shutil.rmtree(self.folder / "studied")
            members += 1
        self.assertEqual(members, 8)

    def test_folders_that_other_machines_hold_are_passed_over_and_a_signal_ends_that(self):
        graph = self.judged_small_graph()
        environment = self.imposed(errno.ENOSYS, True)
        for number in range(1, 200):
            folder = self.folder / "out" / ("judged" if number == 1 else f"judged_{number}")
            folder.mkdir(parents=True)
            (folder / ".tactor.lock.held").write_text("4711 12 another-boot pid:[1] node7\n")
        for number in (signal.SIGTERM, signal.SIGINT):
            process = subprocess.Popen([TACTOR, "run", graph], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                       env=dict(os.environ, **environment))
            self.wait_until((self.folder / "out/judged_2/.tactor.lock").exists, process, "it had waited for the first")
            process.send_signal(number)
            self.assertIn("interrupted", process.communicate(timeout=120)[1])
            self.assertEqual(process.returncode, 1)
            (self.folder / "out/judged_2/.tactor.lock").unlink()
        refused = self.here(environment, "run", graph, "--out", "out/judged", code=2)
        self.assertIn("(process 4711 on node7; if it has ended, remove out/judged/.tactor.lock.held)", refused.stderr)
        (self.folder / "out/judged/.tactor.lock.held").unlink()
        self.here(environment, "run", graph, "--out", "out/judged")


HOLDER = """
import sys, h5py
file = h5py.File(sys.argv[1], sys.argv[2])
print("open", flush=True)
sys.stdin.read()
"""


@needs_hdf5
class OpenElsewhere(CommandTest):
    def setUp(self):
        super().setUp()
        graph = self.judged_small_graph("record: [device.state]\n")
        self.run_ok("run", graph, "--out", self.folder / "out")
        self.graph, self.recording = graph, self.folder / "out/recording.h5"

    def held(self, mode):
        process = subprocess.Popen([sys.executable, "-c", HOLDER, self.recording, mode], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        if process.stdout.readline() != "open\n":
            self.skipTest("h5py cannot open a recording here")
        return process

    def test_a_recording_that_another_program_writes_is_said_to_be_in_use_and_not_to_be_damaged(self):
        before = self.recording.read_bytes()
        process = self.held("r+")
        questions = (("export", self.recording, "device.state"), ("export", self.recording, "?"), ("repair", self.recording),
                     ("view", self.recording, "--no-open"))
        for question in questions:
            result = tactor(*question, environment=self.environment)
            self.assertEqual(result.returncode, 2, f"{question}\n{result.stdout}{result.stderr}")
            self.assertIn("being written by another program", result.stderr)
            self.assertNotIn("damaged", result.stderr)
        process.communicate()
        self.assertEqual(len(self.recording.read_bytes()), len(before))
        self.assertEqual(tactor("export", self.recording, "device.state").returncode, 0)

    def test_a_recording_that_another_program_reads_is_read_and_not_replaced(self):
        process = self.held("r")
        self.assertEqual(tactor("export", self.recording, "device.state").returncode, 0)
        before = self.recording.read_bytes()
        process.communicate()
        self.assertEqual(self.recording.read_bytes(), before)

    def test_a_file_that_is_cut_off_is_still_called_damaged(self):
        self.recording.write_bytes(self.recording.read_bytes()[:4000])
        result = tactor("export", self.recording, "device.state")
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, "damaged")


if __name__ == "__main__":
    unittest.main()
