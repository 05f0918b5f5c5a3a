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
        """`path`: the file that is too much."""
        code, errors, memory = self.tried(*arguments)
        self.assertIn(code, codes, f"{name}: {errors[-500:]}")
        self.assertLess(memory, budget(path.stat().st_size) + BESIDE, f"{name}: {memory >> 20} MiB; {errors[-500:]}")
        if code == 2:
            self.assertIn(path.name, errors, name)
            self.assertLess(len(errors), 100_000, name)

    def test_meshes(self):
        for name, make in bombs.MESHES.items():
            with self.subTest(name):
                path = self.written(name, make())
                self.check(name, path, "mesh", "check", path, codes=(0, 2))

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
                graph = self.written("table.yaml", b"duration: 10 ms\nclock: virtual\nnodes:\n  source: {type: source.recording, file: %s, "
                                     b"columns: {time: t_s, force.x: F_N}}\n" % name.encode())
                self.check(name, path, "check", graph)

    def test_a_request_to_end_is_heeded_while_a_file_is_read(self):
        """A file of 200 MB that is read for long, of each kind of reader."""
        members = {
            "long.off": b"OFF\n20000000 4 0\n" + b"0 0 0\n" * 20_000_000,
            "long.obj": b"v 0 0 0\n" * 20_000_000,
            "long.stl": b"solid a\n" + b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n" * 1_500_000,
            "long.ply": bombs.ply(f"element vertex 20000000\n{bombs.VERTEX}element face 1\n{bombs.FACE}", b"0 0 0\n" * 20_000_000),
        }
        for name, data in members.items():
            for number in (signal.SIGTERM, signal.SIGINT):
                with self.subTest(name, number=number):
                    path = self.written(name, data)
                    child = subprocess.Popen([TACTOR, "mesh", "check", path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                             cwd=self.folder, env=dict(os.environ, **self.environment))
                    # It is at the file once it has taken in that much.
                    while child.poll() is None and self.resident(child.pid) < len(data):
                        time.sleep(0.01)
                    self.assertIsNone(child.poll(), "it has ended by itself: the file is too short for this test")
                    child.send_signal(number)
                    _, errors = child.communicate(timeout=120)
                    self.assertEqual(child.returncode, 1, errors)
                    self.assertIn(f"interrupted while {path} was read", errors)
                    path.unlink()

    def resident(self, pid):
        with open(f"/proc/{pid}/statm") as pages:
            return int(pages.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


if __name__ == "__main__":
    unittest.main()
