"""The package as such: types, declarations, what it imports, and its docstrings."""
import inspect
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from package_harness import BUILD, PackageTest, command, tactor

PACKAGE = BUILD / "python/tactor"


class Package(PackageTest):
    @unittest.skipUnless(shutil.which("mypy"), "mypy is not installed")
    def test_mypy_finds_nothing_in_package_and_stubs(self):
        done = subprocess.run(["mypy", "--strict", "--cache-dir", self.folder / "mypy", PACKAGE], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    @unittest.skipUnless(shutil.which("mypy"), "mypy is not installed")
    def test_stubs_say_what_the_extension_has(self):
        done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "tactor._tactor", "--ignore-missing-stub"],
                              capture_output=True, text=True, cwd=PACKAGE.parent, check=False,
                              env={"PYTHONPATH": str(PACKAGE.parent), "MYPYPATH": str(PACKAGE.parent), "PATH": "/usr/bin"})
        # A stub says neither that pybind11 makes the classes nor that some are not for users to make.
        ours = [line for line in done.stdout.splitlines() if line.startswith("error:")
                and not re.search(r"metaclass differs|(Tap|Feed|PhysicsStep|RunResult)\.__init__ is inconsistent", line)]
        self.assertEqual(ours, [], done.stdout)
        self.assertIn("checked 1 module", done.stdout, done.stderr)

    def test_importing_it_loads_none_of_what_only_some_need(self):
        done = subprocess.run([sys.executable, "-c", "import sys, tactor; print({'h5py', 'pandas', 'matplotlib'} & set(sys.modules))"],
                              capture_output=True, text=True, check=True, env={"PYTHONPATH": str(PACKAGE.parent)})
        self.assertEqual(done.stdout, "set()\n")

    def test_a_package_without_its_module_says_how_to_build_it(self):
        shutil.copytree(PACKAGE, self.folder / "bare/tactor", ignore=shutil.ignore_patterns("_tactor*.so"))
        done = subprocess.run([sys.executable, "-c", "import tactor"], capture_output=True, text=True, check=False,
                              env={"PYTHONPATH": str(self.folder / "bare")})
        self.assertIn("ImportError: tactor: its module _tactor was not built for Python 3.", done.stderr)

    def test_its_version_is_the_commands(self):
        self.assertEqual(tactor.__version__, command("--version").stdout.split()[0])
        self.assertTrue((PACKAGE / "py.typed").exists())

    def test_everything_public_is_documented_and_has_its_public_name(self):
        for name in tactor.__all__:
            thing = getattr(tactor, name)
            if name == "__version__":
                continue
            with self.subTest(name=name):
                self.assertTrue(thing.__doc__ and not thing.__doc__.startswith(f"{name}("))
                self.assertEqual(thing.__module__, "tactor")
                for part, member in inspect.getmembers(thing, lambda m: inspect.isfunction(m) or isinstance(m, property)):
                    inherited = part.startswith("_") or getattr(member, "__module__", "tactor").startswith(("collections", "typing"))
                    self.assertTrue(inherited or member.__doc__, part)

    def test_declarations_are_those_of_the_command(self):
        nodes = tactor.nodes()
        said = command("nodes").stdout
        self.assertEqual(sorted(nodes), sorted(line.split()[0] for line in said.splitlines()))
        coupling = nodes["coupling.adaptive"]
        self.assertEqual(coupling.params["k_0"].unit, "N/m")
        self.assertTrue(coupling.params["k_0"].tunable)
        self.assertEqual(coupling.outputs["force"].message, "Wrench")
        self.assertIn("k_0 [N/m]", coupling.__doc__)


if __name__ == "__main__":
    unittest.main()
