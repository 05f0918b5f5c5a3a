"""Others build on an installation: the examples, what `tactor new` writes and the node of a tutorial, out of tree, after the
installation was moved; nodes in the user's folder; libraries of another layout, which are refused before they are loaded."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from imports_test import imports, symbols
from harness import HAS_LIVE, PATIENCE, ROOT, CommandTest, needs_live

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
EXAMPLES = ROOT / "examples"
# Neither optimised nor with what a debugger reads; a user's project is optimised where it does not say otherwise.
QUICK = "None"
WARNINGS = "-Wall -Wextra -Werror"
WAVES_PROJECT = """cmake_minimum_required(VERSION 3.25)
project(waves LANGUAGES CXX)
find_package(tactor 0.2 REQUIRED)
tactor_add_nodes(waves SOURCES waves.cpp)
"""


def setUpModule():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="tactor-built-on-")).resolve()
    unittest.addModuleCleanup(shutil.rmtree, folder, ignore_errors=True)
    result = subprocess.run(["cmake", "--install", BUILD, "--prefix", folder / "first"], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise AssertionError(f"cmake --install: {result.stdout[-2000:]}{result.stderr}")
    BuiltOn.prefix = folder / "moved here"
    (folder / "first").rename(BuiltOn.prefix)
    BuiltOn.builds = folder


class BuiltOn(CommandTest):
    def setUp(self):
        super().setUp()
        self.home = self.folder / "home"
        self.home.mkdir()
        self.environment.update(PATH=f"{self.prefix / 'bin'}:{os.environ['PATH']}", HOME=str(self.home))
        for name in ("TACTOR_NODE_PATH", "XDG_DATA_HOME"):
            self.environment.pop(name, None)

    def do(self, *words, code=0, **options):
        options = {"cwd": self.folder, "env": dict(os.environ, **self.environment), **options}
        result = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=PATIENCE, check=False, **options)
        self.assertEqual(result.returncode, code, f"{words}\n{result.stdout[-4000:]}{result.stderr[-4000:]}")
        return result

    def build(self, source, name):
        """The folder of its build, of which all tests have passed."""
        build = self.builds / name
        if not build.exists():
            self.do("cmake", "-G", "Ninja", "-S", source, "-B", build, f"-DCMAKE_PREFIX_PATH={self.prefix}", f"-DCMAKE_BUILD_TYPE={QUICK}",
                    f"-DCMAKE_CXX_FLAGS={WARNINGS}")
            self.do("cmake", "--build", build)
        return build

    def write(self, name, text):
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        return super().write(name, text)

    def passes(self, build):
        said = self.do("ctest", "--test-dir", build, "--output-on-failure").stdout
        self.assertIn("100% tests passed", said)
        return said


class Examples(BuiltOn):
    def test_a_node(self):
        build = self.build(EXAMPLES / "node", "node")
        self.passes(build)
        for library in (build / "nodes").glob("*.so"):
            self.assertEqual(imports(library) & {"sin", "cos", "exp", "log", "pow", "hypot", "atan2"}, set())

    def test_a_sine_in_a_node_is_the_portable_one(self):
        self.write("waves/CMakeLists.txt", WAVES_PROJECT)
        self.write("waves/waves.cpp", "#include <cmath>\nextern \"C\" double wave(double x) { return std::sin(x) + std::hypot(x, 2.0); }\n")
        library = self.build(self.folder / "waves", "waves") / "nodes/libtactor_waves.so"
        self.assertEqual(imports(library) & {"sin", "hypot"}, set())
        self.assertIn("Sleef_cinz_hypotd1_u05purec", imports(library))
        self.assertNotIn("sin", symbols("--defined-only", library))

    def test_a_message(self):
        build = self.build(EXAMPLES / "message", "message")
        self.passes(build)
        summary = (build / "out/example_runs/summary.json").read_text()
        self.assertRegex(summary, r'"pressure_max": [1-9]')

    @needs_live
    def test_a_device(self):
        build = self.build(EXAMPLES / "device", "device")
        self.passes(build)
        self.assertRegex((build / "out/summary.json").read_text(), r'"ticks": [1-9]')

    def test_a_program(self):
        build = self.build(EXAMPLES / "embed", "embed")
        self.passes(build)
        lines = self.do(build / "embed").stdout.splitlines()
        self.assertEqual(len(lines), 11)
        heights, forces = zip(*((float(line.split()[2]), float(line.split()[4])) for line in lines))
        # The ball has a radius of 4 mm: no force above the wall. Pressed 4 mm deep, in equilibrium, the coupling of
        # 400 N/m and the contact of about 1.8 N/mm, in series, give about 4 mm / (1/400 + 1/1800) N.
        for height, force in zip(heights, forces):
            self.assertEqual(force > 0.02, height < 3.6, f"{height} mm: {force} N")
        self.assertEqual(heights[-1], 0)
        self.assertTrue(all(a <= b + 0.05 for a, b in zip(forces, forces[1:])), forces)


class New(BuiltOn):
    def new(self, *words, code=0):
        return self.do("tactor", "new", *words, code=code)

    def test_a_study(self):
        self.new("study", "mine", "--graph", "wall/scene")
        text = (self.folder / "mine/mine.yaml").read_text()
        self.assertIn('graphs: ["wall/scene"]', text)
        self.do("tactor", "study", "mine/mine.yaml", "--short")
        self.assertEqual(len((self.folder / "out/mine/study.csv").read_text().splitlines()), 1 + 2 * 2 * 2)

    def test_a_study_of_a_file_with_any_name(self):
        graph = self.write("a b, #c: [d/my graph.yaml", "extends: wall/scene\n")
        self.new("study", "odd", "--graph", graph)
        self.do("tactor", "study", self.folder / "odd/odd.yaml", "--short", "--seeds", "1", "--duration", "0.2", "--judge", "whole", "--out", self.folder / "out")

    def test_a_device_may_not_be_called_as_another_file_of_its_project(self):
        self.assertIn("two files of the project would be called machine.cpp", self.new("device", "mine.machine", code=2).stderr)
        self.assertFalse((self.folder / "mine").exists())

    def test_words_of_the_example_may_be_in_a_name(self):
        self.new("node", "my.example_parabola")
        self.assertIn('"my.example_parabola"', (self.folder / "my/example_parabola.cpp").read_text())

    def test_bad_names_are_refused(self):
        for name, words in (("Mylab", "small letters"), ("1st", "small letters"), ("a.b.c", "small letters"), ("", "small letters"),
                            ("../x", "small letters"), ("prediction", "no library of Tactor has"), ("device.mine", "no library of Tactor has")):
            with self.subTest(name=name):
                self.assertIn(words, self.new("node", name, code=2).stderr)
        self.assertEqual(list(self.folder.glob("*")), [self.home])

    def test_nothing_is_written_over(self):
        self.new("study", "mine")
        before = (self.folder / "mine/mine.yaml").read_text()
        (self.folder / "mine/mine.yaml").write_text(before + "# mine\n")
        self.assertIn("is there already", self.new("study", "mine", code=2).stderr)
        self.assertEqual((self.folder / "mine/mine.yaml").read_text(), before + "# mine\n")

    def test_a_graph_that_is_not_there_is_told(self):
        self.assertIn("nowhere", self.new("study", "mine", "--graph", "nowhere", code=2).stderr)
        self.assertFalse((self.folder / "mine").exists())


class AsPrinted(BuiltOn):
    """What `tactor new` prints is run as it is printed, beside a clone that was built and after an installation."""

    def printed(self, command, *words):
        said = self.do(command, "new", *words).stdout
        commands = said.partition("\nNext:\n")[2].splitlines()
        self.assertEqual(len(commands), 3, said)
        return commands

    def run_as_printed(self, commands):
        for command in commands:
            self.do("bash", "-c", command, env=dict(os.environ, **self.environment, CMAKE_BUILD_TYPE=QUICK, CXXFLAGS=WARNINGS))

    def test_a_node_on_an_installation_with_a_blank_in_its_path(self):
        commands = self.printed("tactor", "node", "mylab.smooth")
        self.assertEqual(sorted(p.name for p in (self.folder / "mylab").iterdir()), ["CMakeLists.txt", "README.md", "mylab.yaml", "smooth.cpp"])
        for file in (self.folder / "mylab").iterdir():
            self.assertNotIn("example", file.read_text())
            self.assertNotIn("<!--", file.read_text())
        self.assertIn(f"cmake -S mylab -B mylab/build -DCMAKE_PREFIX_PATH='{self.prefix}' && cmake --build", commands[0])
        self.run_as_printed(commands[:1])
        self.passes(self.folder / "mylab/build")
        self.do("tactor", "nodes", "mylab.smooth", code=2)
        self.run_as_printed(commands[2:])
        self.assertIn("mylab.smooth", self.do("tactor", "nodes", "mylab.smooth").stdout)
        self.do("tactor", "run", self.folder / "mylab/mylab.yaml", "--duration", "0.5")
        self.assertTrue((self.folder / "out/mylab/report.html").exists())

    def test_a_node_on_a_clone(self):
        commands = self.printed(BUILD / "bin/tactor", "node", "near")
        self.assertIn(f"-DCMAKE_PREFIX_PATH={BUILD.resolve()} ", commands[0])
        self.run_as_printed(commands)
        self.assertIn("near.predictor", self.do(BUILD / "bin/tactor", "nodes", "near.predictor").stdout)
        self.do(BUILD / "bin/tactor", "run", "near/near.yaml", "--duration", "0.5")
        self.assertTrue((self.folder / "out/near/summary.json").exists())

    @needs_live
    def test_a_device_on_a_clone_in_a_folder_with_a_blank(self):
        self.run_as_printed(self.printed(BUILD / "bin/tactor", "device", "robot", "--in", "my machines")[:1])
        build = self.folder / "my machines/robot/build"
        self.passes(build)
        said = self.do("tactor", "nodes", "robot.device", env=dict(os.environ, **self.environment, TACTOR_NODE_PATH=str(build / "nodes"))).stdout
        self.assertIn("link_timeout", said)

    def test_a_message_on_a_clone(self):
        self.run_as_printed(self.printed(BUILD / "bin/tactor", "message", "pads")[:1])
        self.passes(self.folder / "pads/build")

    @unittest.skipUnless((BUILD / "python/tactor").is_dir(), "this build has no Python package")
    def test_physics_on_a_clone(self):
        commands = self.printed(BUILD / "bin/tactor", "physics", "mine")
        self.assertEqual(sorted(p.name for p in (self.folder / "mine").iterdir()), ["README.md", "mine.yaml", "physics.py", "study.py"])
        said = [self.do("bash", "-c", command).stdout for command in commands]
        for text, method in zip(said, ("hold", "local")):
            self.assertRegex(text, rf"^{method}: 12000 forces, 0\.\d+ N on average, [0-9.]+ N at most\n$")
        shares = {row.split()[0]: float(row.split()[2]) for row in said[2].splitlines()[1:]}
        self.assertEqual(list(shares), ["hold", "paper", "blend", "local"])
        self.assertEqual(shares["hold"], 1)
        self.assertLess(shares["local"], 0.5)

    def test_no_path_is_printed_that_the_environment_names(self):
        self.environment["CMAKE_PREFIX_PATH"] = f"/opt/other:{BUILD}"
        self.assertNotIn("CMAKE_PREFIX_PATH", self.printed(BUILD / "bin/tactor", "node", "told")[0])
        self.assertIn("CMAKE_PREFIX_PATH", self.printed(self.prefix / "bin/tactor", "node", "untold")[0])


class Tutorial(BuiltOn):
    def test_its_node_is_compiled_and_found(self):
        code = [block for block in re.findall(r"```cpp\n(.*?)```", (ROOT / "docs/tutorials/own_predictor_cpp.md").read_text(), re.DOTALL) if "my.gain" in block]
        self.assertEqual(len(code), 1)
        self.write("my/gain.cpp", code[0])
        self.write("my/CMakeLists.txt", "cmake_minimum_required(VERSION 3.25)\nproject(my LANGUAGES CXX)\n"
                                        "find_package(tactor REQUIRED)\ntactor_add_nodes(my SOURCES gain.cpp)\n")
        build = self.build(self.folder / "my", "my")
        self.environment["TACTOR_NODE_PATH"] = str(build / "nodes")
        self.assertIn("Multiplies a force", self.do("tactor", "nodes", "my.gain").stdout)


class Headers(BuiltOn):
    def test_all_that_one_includes_is_there(self):
        headers = sorted(p.relative_to(self.prefix / "include/tactor") for p in (self.prefix / "include/tactor").rglob("*.hpp"))
        self.assertGreater(len(headers), 100)
        for header in headers:
            text = (self.prefix / "include/tactor" / header).read_text()
            for included in re.findall(r'#include "([^"]+)"', text):
                self.assertTrue((self.prefix / "include/tactor" / included).exists(), f"{header} includes {included}")

    def test_an_unknown_component_is_told(self):
        self.write("x/CMakeLists.txt", "cmake_minimum_required(VERSION 3.25)\nproject(x LANGUAGES CXX)\n"
                                       "find_package(tactor REQUIRED COMPONENTS haptics)\n")
        said = self.do("cmake", "-S", self.folder / "x", "-B", self.folder / "x/build", f"-DCMAKE_PREFIX_PATH={self.prefix}", code=1).stderr
        self.assertIn("none called haptics", said)


class OtherLayouts(BuiltOn):
    def library(self, change):
        """A folder with the example's library, changed."""
        folder = self.folder / "nodes"
        folder.mkdir()
        data = (self.build(EXAMPLES / "node", "node") / "nodes/libtactor_example.so").read_bytes()
        (folder / "libtactor_example.so").write_bytes(change(data))
        self.environment.update(TACTOR_NODE_PATH=str(folder), LD_DEBUG="files")
        return folder / "libtactor_example.so"

    def test_one_is_refused_with_both_hashes_and_is_never_loaded(self):
        ours = re.search(r'TACTOR_ABI "(\w{16})"', (self.prefix / "include/tactor/tactor_abi.hpp").read_text())[1]
        file = self.library(lambda data: data.replace(b"tactor abi " + ours.encode(), b"tactor abi 0123456789abcdef"))
        said = self.do("tactor", "nodes", "example.parabola", code=2).stderr
        message = [line for line in said.splitlines() if "built for the layout" in line][0]
        for part in (str(file), "0123456789abcdef", ours, "Build it again"):
            self.assertIn(part, message)
        self.assertNotIn("calling init: " + str(file), said)

    def test_listings_leave_it_out_and_say_so(self):
        self.library(lambda data: re.sub(b"tactor abi \\w{16}", b"tactor abi 0123456789abcdef", data))
        self.environment.pop("LD_DEBUG")
        result = self.do("tactor", "nodes")
        self.assertIn("sink.metrics", result.stdout)
        self.assertIn("0123456789abcdef", result.stderr)

    def test_one_that_fits_is_loaded(self):
        # What the test before looks for is there otherwise.
        file = self.library(lambda data: data)
        self.assertIn("calling init: " + str(file), self.do("tactor", "nodes", "example.parabola").stderr)

    def test_one_that_states_nothing_is_refused(self):
        self.library(lambda data: data.replace(b"tactor abi ", b"tactor abc "))
        said = self.do("tactor", "nodes", "example.parabola", code=2).stderr
        self.assertIn("states no layout", said)

    def test_what_is_no_library_is_refused(self):
        for number, data in enumerate((b"", b"tactor abi ", b"\x7fELF", b"tactor abi 0123456789abcde")):
            with self.subTest(data=data):
                folder = self.folder / f"bad{number}"
                folder.mkdir()
                (folder / "libtactor_example.so").write_bytes(data)
                self.environment["TACTOR_NODE_PATH"] = str(folder)
                self.assertIn("states no layout", self.do("tactor", "nodes", "example.parabola", code=2).stderr)

    def test_a_plugin_of_ours_too(self):
        ours = re.search(r'TACTOR_ABI "(\w{16})"', (self.prefix / "include/tactor/tactor_abi.hpp").read_text())[1].encode()
        if not HAS_LIVE:
            self.skipTest("this build has no live engine")
        file = next(self.prefix.rglob("libtactor_live.so"))
        data = file.read_bytes()
        self.addCleanup(file.write_bytes, data)
        file.write_bytes(data.replace(b"tactor abi " + ours, b"tactor abi 0123456789abcdef"))
        said = self.do("tactor", "run", "wall/refit", "--set", "clock=real", "--duration", "0.1", code=2).stderr
        self.assertIn("0123456789abcdef", said)


if __name__ == "__main__":
    unittest.main()
