"""Runs the command in a folder of its own and reads what it leaves behind."""
import contextlib
import ctypes
import functools
import json
import os
import pathlib
import pty
import re
import resource
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GRAPHS = ROOT / "graphs"
sys.path[:0] = [str(GRAPHS), str(ROOT / "tests/support")]
from motor_log import motor_log  # noqa: E402, F401
from shipped import graph_file, graph_files, graph_name  # noqa: E402, F401

PATIENCE = 120  # s, for what takes a moment on an idle machine
TACTOR = os.environ.get("TACTOR", str(ROOT / "build/release/bin/tactor"))
VERSION = re.search(r"project\(tactor VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


def built(*places):
    """Whether a library is at one of these places, seen from the command's folder."""
    return any((pathlib.Path(TACTOR).resolve().parent / place).exists() for place in places)


def library_folder():
    """The folder of libtactor, which holds tactor/ with the nodes and tactor/plugins."""
    lib = pathlib.Path(TACTOR).resolve().parent.parent / "lib"
    return next((folder for folder in (lib, lib / "x86_64-linux-gnu") if (folder / "tactor").is_dir()), lib)


LIBRARIES = library_folder()


def has_plugin(name):
    return (LIBRARIES / f"tactor/plugins/libtactor_{name}.so").exists()


def columns(rows, path=""):
    """(path, numbers) of each field of a recorded stream, and of each field of a record in it."""
    for name in rows.dtype.names or ():
        if rows.dtype[name].base.names:
            yield from columns(rows[name], f"{path}{name}.")
        else:
            yield path + name, rows[name]


# The shipped graphs need the generated meshes, which a build without CGAL lacks.
HAS_MESHES = built("../meshes/bunny.off", "../share/tactor/meshes/duck.off")
HAS_DEVICES = all((LIBRARIES / f"tactor/libtactor_{kind}.so").exists() for kind in ("modbus", "usb"))
HAS_HDF5 = has_plugin("record")
HAS_LIVE = os.environ.get("TACTOR_LIVE", "1") != "0"
# Sanitizers have a heap of their own, whose calls are not counted.
CACHE = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release")) / "CMakeCache.txt"
IS_SANITIZED = CACHE.exists() and re.search(r"^TACTOR_SANITIZE:\w+=.", CACHE.read_text(), re.MULTILINE) is not None
needs_live = unittest.skipUnless(HAS_LIVE, "this build has no CAF, so no live engine")
needs_meshes = unittest.skipUnless(HAS_MESHES, "this build has no CGAL, so no generated meshes")
needs_devices = unittest.skipUnless(HAS_DEVICES, "this build lacks Modbus or USB, so their node types")
HAS_VIEW = has_plugin("view")
needs_view = unittest.skipUnless(HAS_VIEW, "this build has no view")
needs_hdf5 = unittest.skipUnless(HAS_HDF5, "this build has no HDF5, so no recordings")
# The outputs of a chain that needs no mesh: a trajectory, the simulated device, metrics.
EDGES_OF_A_SMALL_GRAPH = """
clock: virtual
duration: 0.5 s
scene: {bodies: {}}
nodes:
  trajectory:
    type: source.trajectory
    points: [{t: 0 s, x: 0 mm}, {t: 0.5 s, x: 10 mm}]
  device: {type: device.simulated}
edges:
  - trajectory.target -> device.target
"""
METRICS_OF_A_SMALL_GRAPH = """  - device.commanded -> metrics.commanded
  - device.commanded -> metrics.force
"""
# Scans, which the library of tests/scan_nodes sends and judges.
SCAN_SCENE = "format: 2\nclock: virtual\nduration: 1 s\nscene: {bodies: {tool: {sphere: {radius: 1 mm}, motion: rigid}}}\n"
SCANS = f"""{SCAN_SCENE}
nodes:
  scanner: {{type: scan.source}}
  judge: {{type: scan.judge}}
edges: [scanner.scan -> judge.scan]
record: [scanner.scan]
"""
# A ball on a wall that a device presses it into, live; both cheap, so that a busy machine is enough.
PRESSED_WALL = """clock: real
duration: %(duration)s
live: {on_missing_privilege: warn, on_stall: recover}
scene:
  gravity: [0, 0, 0]
  bodies:
    wall:
      plane: {}
      material: {stiffness: 0.4 N/mm, damping: 2 N s/m, friction: 0}
    tool:
      sphere: {radius: 4 mm}
      motion: translation
      mass: 50 g
      pose: {p: [0, 0, %(height)s]}
      material: {stiffness: 20 N/mm, damping: 2 N s/m, friction: 0}
nodes:
  device: {%(device)s}
  collision: {type: collision.primitive}
  dynamics: {type: dynamics.translation}
  coupling: {type: coupling.adaptive}
  prediction: {type: prediction.hold}
  interpolation: {type: interpolation.linear}
edges:
  - device.state -> collision.device
  - device.state -> dynamics.device
  - collision.contacts -> dynamics.contacts
  - dynamics.state -> collision.state
  - coupling.parameters -> dynamics.coupling
  - dynamics.state -> coupling.state
  - coupling.force -> prediction.force
  - prediction.forecast -> interpolation.forecast
  - interpolation.segment -> device.segment
record: [device.commanded, device.safety, device.state]
"""

LONGEST_RUN = 1500  # s, as long as ctest waits for a test


def tactor(*arguments, program=TACTOR, environment=None, cwd=None, timeout=LONGEST_RUN):
    """The finished command: returncode, stdout, stderr."""
    # Texts are looked for in whole lines, however wide; what a narrow terminal gets has tests of its own.
    env = dict(os.environ, **{"COLUMNS": "1000", **(environment or {})})
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, env=env, cwd=cwd,
                          timeout=timeout, check=False)


def give_privileges_up():
    """In the child: what real time needs is refused to it, whoever runs the test."""
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    for capability in (14, 23, 24):  # CAP_IPC_LOCK, CAP_SYS_NICE, CAP_SYS_RESOURCE, from the bounding set
        prctl(24, capability, 0, 0, 0)
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))


def without_privileges(stderr):
    """What was said, without the line on real-time privileges that a run with hardware begins with where the system refuses them."""
    return re.sub(r"^tactor: the system refuses real-time privileges \(.*\n", "", stderr, flags=re.MULTILINE)


def verbs(*before):
    """The verbs of the command, or of a verb that has some of its own, from the refusal of a word that is none."""
    said = re.search(r"expected a verb \(([^)]*)\)", tactor(*before, "no-such-verb").stderr)
    return said[1].split(", ")


def every_verb():
    """Every verb as words: `run`, `device test`. `emulate` hands its words on to programs of their own."""
    for verb in verbs():
        if verb in ("device", "mesh", "new"):
            yield from ((verb, word) for word in verbs(verb))
        elif verb != "emulate":
            yield (verb,)


def graph_verbs():
    """(words, options that it needs) of every verb that takes a graph."""
    for words in every_verb():
        shown = tactor(*words, "--help").stdout
        if re.search(r"^\s+graphs? ", shown, re.MULTILINE):
            yield words, ["--budget", "1"] if "--budget" in shown else []


# Options of a sanitizer, which else takes signals of crashes for itself.
LEFT_TO_THE_COMMAND = tuple(f"handle_{name}=0" for name in ("segv", "abort", "sigbus", "sigfpe", "sigill"))


@functools.cache
def dear_entries():
    """Where all tests keep the entries of caches that take seconds to make: distances and tetrahedra of meshes. Another build has another
    folder, so that what its libraries make is tested."""
    newest = max(file.stat().st_mtime_ns for file in (pathlib.Path(TACTOR), *LIBRARIES.rglob("libtactor*.so*"))
                 if file.name != "libtactor_build.so")  # another commit alone makes nothing else
    folder = CACHE.parent / f"tests/entries/of_{newest:x}"
    if not folder.exists():
        for other in folder.parent.glob("of_*"):
            shutil.rmtree(other, ignore_errors=True)
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def link_entries(source, target):
    """Both have the same files then; what is written is a new file."""
    for kind in ("cells", "tetrahedra"):
        for file in source.glob(f"*.{kind}"):
            with contextlib.suppress(OSError):  # it is there, or another process has removed the folder
                os.link(file, target / file.name)


def new_cache(test):
    """A folder for a cache, in which there are the dear entries alone; `test`, or its class, removes it."""
    add_cleanup = test.addClassCleanup if isinstance(test, type) else test.addCleanup
    entries = dear_entries()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="cache-", dir=entries.parent))  # on the same disk
    add_cleanup(shutil.rmtree, folder, ignore_errors=True)
    link_entries(entries, folder)
    add_cleanup(link_entries, folder, entries)
    return folder


class CommandTest(unittest.TestCase):
    cache = None  # of each test its own
    sanitizer_options = ()

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tactor-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.cache_folder = self.cache or new_cache(self)
        self.environment = {"TACTOR_CACHE": str(self.cache_folder)}
        for name in ("ASAN_OPTIONS", "TSAN_OPTIONS") if self.sanitizer_options else ():
            self.environment[name] = ":".join([os.environ.get(name, ""), *self.sanitizer_options])

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def run_ok(self, *arguments, **options):
        options.setdefault("environment", self.environment)
        result = tactor(*arguments, **options)
        self.assertEqual(result.returncode, 0, f"{arguments}\n{result.stdout}\n{result.stderr}")
        return result

    def run_graph(self, graph, *arguments, out="out", **options):
        """Runs a graph and returns its summary."""
        self.run_ok("run", graph, "--out", self.folder / out, "--overwrite", *arguments, **options)
        return json.loads((self.folder / out / "summary.json").read_text())

    def emulate_modbus(self, profile, *arguments, program=TACTOR, **options):
        """Starts an emulator, which ends with the test; its process, and the address that it serves."""
        emulator = subprocess.Popen([program, "emulate", "modbus", profile, *arguments], stdin=subprocess.PIPE,
                                    stdout=subprocess.PIPE, text=True, **options)

        def end():
            if emulator.poll() is None:
                emulator.kill()
            emulator.communicate()
        self.addCleanup(end)
        ready = emulator.stdout.readline()
        self.assertTrue(ready.startswith("ready "), ready)
        return emulator, ready.split()[1]

    def small_graph(self, extra=""):
        return self.write("small.yaml", EDGES_OF_A_SMALL_GRAPH + extra)

    def wait_until(self, condition, process, what, timeout=120):
        """Waits for something the started command does, however slow a build or a busy machine makes it."""
        end = time.monotonic() + timeout
        while not condition():
            if process.poll() is not None:
                said = [str(stream.read()) for stream in (process.stdout, process.stderr) if stream and not stream.closed]
                self.fail(f"the command ended with {process.returncode} before {what}: {''.join(said)[-2000:]}")
            if time.monotonic() > end:
                process.kill()
                self.fail(f"{timeout} s have gone by before {what}")
            time.sleep(0.05)

    def judged_small_graph(self, extra=""):
        """The small graph with metrics, which has something to run for."""
        text = (EDGES_OF_A_SMALL_GRAPH + METRICS_OF_A_SMALL_GRAPH).replace(
            "nodes:", "nodes:\n  metrics: {type: sink.metrics}")
        return self.write("judged.yaml", text + extra)


class CachedTest(CommandTest):
    """The tests of a class share a cache, so that reference runs are made once."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.cache = new_cache(cls)


class Terminal:
    """A command on a pseudo-terminal of its own."""

    def __init__(self, *arguments, environment=None):
        self.pid, self.file = pty.fork()
        if self.pid == 0:
            os.execve(TACTOR, [TACTOR, *map(str, arguments)], dict(os.environ, **(environment or {})))
        self.text = ""

    def type(self, text):
        os.write(self.file, text.encode())

    def read(self, seconds):
        if not select.select([self.file], [], [], seconds)[0]:
            return False
        try:
            piece = os.read(self.file, 4096)
        except OSError:  # the command has ended
            return False
        self.text += piece.decode(errors="replace")
        return bool(piece)

    def expect(self, text):
        end = time.monotonic() + PATIENCE
        while text not in self.text:
            if not self.read(1) and time.monotonic() > end:
                raise AssertionError(f"{text} does not come:\n{self.text}")

    def finish(self):
        """The exit code; what it said is in `text`."""
        end = time.monotonic() + PATIENCE
        while True:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid != 0:
                break
            self.read(0.05)
            if time.monotonic() > end:
                os.kill(self.pid, signal.SIGKILL)
                os.waitpid(self.pid, 0)
                raise AssertionError(f"the command does not end:\n{self.text}")
        while self.read(0.1):
            pass
        os.close(self.file)
        return os.waitstatus_to_exitcode(status)


def graphs_with_clock(clock):
    """The shipped graphs that name this clock themselves, the others extend one with a virtual clock; without those for
    hardware, which are run beside their emulators elsewhere."""
    import yaml  # most tests read no graph

    for graph in graph_files():
        tree = yaml.safe_load(graph.read_text())
        device = tree.get("nodes", {}).get("device") or {}
        if device.get("type", "").startswith(("modbus.", "usb.", "falcon.")):
            continue
        if tree.get("clock", "virtual") == clock:
            yield graph


def few_tetrahedra(graph):
    """Options that make a shipped soft body coarse, which saves minutes; none for other graphs."""
    return ("--set", "scene.bodies.bunny.tetrahedra=500") if graph.parent.name == "bunny_soft" else ()


def check_loop(test, device):
    """A device loop that allocated nothing, where that can be counted, and that tells its page faults."""
    if not IS_SANITIZED:
        test.assertEqual(device["allocations"], 0)
    test.assertGreaterEqual(device["page_faults"], 0)
