"""Small files that would fill the memory or run for minutes: each is refused, or read within the budget of its size."""
import os
import re
import resource
import signal
import subprocess
import tempfile
import time
import unittest

import bombs
import h5py
from harness import GRAPHS, TACTOR, CommandTest

# The budget of a file of that size, and what the command, its libraries and the steps after the reader take beside it.
MIB = 1 << 20
BESIDE = 1 << 30
# A block of gel whose tetrahedra are in a file.
SOFT = re.sub(r" +box: .*\n", "      mesh: MESH\n", re.sub(r" +tetrahedra: .*\n", "", (GRAPHS / "gel_cube/scene.yaml").read_text()), count=1)


def budget(size):
    return max(64 * MIB, 64 * size)


class Bombs(CommandTest):
    def written(self, name, data):
        path = self.folder / name
        path.write_bytes(data)
        return path

    def tried(self, *arguments):
        """(exit code, errors, most memory) of a command that may have so much processor time and no more."""
        def limits():
            resource.setrlimit(resource.RLIMIT_CPU, (240, 240))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with tempfile.TemporaryFile("w+") as errors:
            child = subprocess.Popen([TACTOR, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=errors, preexec_fn=limits,
                                     cwd=self.folder, env=dict(os.environ, **self.environment))
            _, status, used = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
            errors.seek(0)
            return child.returncode, errors.read(), used.ru_maxrss << 10

    def check(self, name, path, *arguments, codes=(2,)):
        """The errors of the command; `path`: the file that is too much."""
        code, errors, memory = self.tried(*arguments)
        self.assertIn(code, codes, f"{name}: {errors[-500:]}")
        self.assertLess(memory, budget(path.stat().st_size) + BESIDE, f"{name}: {memory >> 20} MiB; {errors[-500:]}")
        if code == 2:
            # What is whole is refused by the graph, which cannot use it.
            self.assertRegex(errors, f"{re.escape(path.name)}|holds no node", name)
            self.assertLess(len(errors), 100_000, name)
        return errors

    def test_meshes(self):
        for name, make in bombs.MESHES.items():
            with self.subTest(name):
                path = self.written(name, make())
                errors = self.check(name, path, "mesh", "check", path, codes=(0, 2))
                if name in bombs.SLOW:
                    self.assertIn("takes too long", errors)

    def test_volumes(self):
        for name, make in bombs.VOLUMES.items():
            with self.subTest(name):
                path = self.written(name, make())
                self.check(name, path, "check", self.write("soft.yaml", SOFT.replace("MESH", name)))

    def test_graphs(self):
        for name, make in bombs.GRAPHS.items():
            with self.subTest(name):
                path = self.written(name, make())
                self.check(name, path, "check", path)

    def test_tables(self):
        for name, make in bombs.TABLES.items():
            with self.subTest(name):
                path = self.written(name, make())
                graph = self.written("table.yaml", b"duration: 10 ms\nclock: virtual\nrecord: [source.force]\nnodes:\n  source: {type: source.recording, file: %s, "
                                     b"columns: {time: t_s, force.x: F_N}}\n" % name.encode())
                self.check(name, path, "check", graph)

    def test_recordings(self):
        self.run_ok("run", GRAPHS / "wall/refit.yaml", "--duration", "0.3 s", "--set", "record=[coupling.force]", "--out", self.folder / "out")
        whole = (self.folder / "out/recording.h5").read_bytes()
        os.mkfifo(self.folder / "pipe")
        for name, change in bombs.RECORDINGS.items():
            with self.subTest(name):
                path = self.written(f"{name.replace(' ', '_')}.h5", whole)
                with h5py.File(path, "r+") as file:
                    stream = change(file, str(self.folder / "pipe"))
                self.assertLess(path.stat().st_size, len(whole) + (2 << 20))
                self.check(name, path, "export", path, stream)
        self.assertGreater(len(self.run_ok("export", self.written("whole.h5", whole), stream).stdout.splitlines()), 10)

    def test_a_request_to_end_is_heeded_while_a_file_is_read(self):
        """A file of more than 100 MB, of each kind of reader. The request comes as soon as the command listens for it."""
        members = {
            "long.off": b"OFF\n20000000 4 0\n" + b"0 0 0\n" * 20_000_000,
            "long.obj": b"v 0 0 0\n" * 20_000_000,
            "long.stl": b"solid a\n" + b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n" * 1_500_000,
            "long.ply": bombs.ply(f"element vertex 20000000\n{bombs.VERTEX}element face 1\n{bombs.FACE}", b"0 0 0\n" * 20_000_000),
        }
        for name, data in members.items():
            path = self.written(name, data)
            for number in (signal.SIGTERM, signal.SIGINT):
                with self.subTest(name, number=number):
                    child = subprocess.Popen([TACTOR, "mesh", "check", path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                             cwd=self.folder, env=dict(os.environ, **self.environment))
                    while not self.listens(child.pid, number) and child.poll() is None:
                        time.sleep(0.005)
                    child.send_signal(number)
                    _, errors = child.communicate()
                    if child.returncode == 2:
                        self.skipTest("this machine is so busy that the file was read before the request was made")
                    self.assertEqual(child.returncode, 1, errors)
                    self.assertIn(f"interrupted while {path} was read", errors)
            path.unlink()

    def test_a_request_to_end_ends_the_check_of_a_mesh(self):
        path = self.written("cone.off", bombs.off_cone(8_000))
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(number=number):
                child = subprocess.Popen([TACTOR, "mesh", "check", path], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                         cwd=self.folder, env=dict(os.environ, **self.environment))
                while not self.listens(child.pid, number) and child.poll() is None:
                    time.sleep(0.001)
                while self.listens(child.pid, number) and child.poll() is None:
                    time.sleep(0.005)
                child.send_signal(number)
                self.assertEqual(child.wait(), -number)

    def listens(self, pid, number):
        """Whether a process has a handler for that signal."""
        try:
            with open(f"/proc/{pid}/status") as status:
                return int(re.search(r"SigCgt:\s+(\w+)", status.read())[1], 16) >> (number - 1) & 1
        except (OSError, TypeError):
            return False


if __name__ == "__main__":
    unittest.main()
