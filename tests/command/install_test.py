"""An installation finds what it needs beside itself: nodes, meshes, graphs, profiles, emulators, the library in front of the C
library and the udev rule."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

from harness import EDGES_OF_A_SMALL_GRAPH, GRAPHS, HAS_MESHES, METRICS_OF_A_SMALL_GRAPH, PRESSED_WALL, ROOT, TACTOR, VERSION, CommandTest
from harness import needs_meshes, needs_hdf5, needs_live, tactor

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
PATIENCE = 150  # s, for what takes a few seconds on an idle machine
HAS_MODBUS = (BUILD / "bin/tactor-emulate-modbus").exists()
HAS_USB = (BUILD / "bin/tactor-emulate-usb").exists()
# Late answers of a busy machine are not what these tests are about.
EASY = "force_max: 5 N, link_timeout: 2 s, stale_after: 2 s, sample_age_max: 4 s, failure_timeout: 5 s, stuck_after: 0 s"


def is_program(path):
    with open(path, "rb") as file:
        return file.read(4) == b"\x7fELF"


def foreign_run_paths(folder):
    result = subprocess.run([ROOT / "scripts/run_paths", folder], capture_output=True, text=True, check=False)
    return "" if result.returncode == 0 else result.stdout + result.stderr


def setUpModule():
    Installed.prefix = pathlib.Path(tempfile.mkdtemp(prefix="tactor-installed-")).resolve() / "prefix"
    unittest.addModuleCleanup(shutil.rmtree, Installed.prefix.parent, ignore_errors=True)
    result = subprocess.run(["cmake", "--install", BUILD, "--prefix", Installed.prefix], capture_output=True, text=True,
                            check=False)
    if result.returncode != 0:
        raise AssertionError(f"cmake --install: {result.stdout[-2000:]}{result.stderr}")


class Installed(CommandTest):
    def setUp(self):
        super().setUp()
        self.program = self.prefix / "bin/tactor"
        self.share = self.prefix / "share/tactor"
        # A newcomer's: a folder that holds nothing of ours, and the programs on the path.
        self.elsewhere = self.folder / "elsewhere"
        self.elsewhere.mkdir()
        self.environment["PATH"] = f"{self.prefix / 'bin'}:{os.environ['PATH']}"
        self.environment["XDG_RUNTIME_DIR"] = str(self.folder)
        # Whatever test comes first prepares a mesh, for all.
        self.environment["TACTOR_CACHE"] = str(self.prefix.parent / "cache")

    def run_ok(self, *arguments, **options):
        return super().run_ok(*arguments, **{"program": "tactor", "cwd": self.elsewhere, "timeout": PATIENCE, **options})

    def pressed_wall(self, device):
        return self.write("pressed.yaml", PRESSED_WALL % {"device": f"{device}, {EASY}", "height": "2 mm", "duration": "1 s"})

    def device_part(self):
        return json.loads((self.folder / "out/summary.json").read_text())["device"]


class Built(unittest.TestCase):
    @unittest.skipUnless((BUILD / "build.ninja").exists(), "the build is not made by Ninja")
    def test_the_command_and_the_meshes_build_all_that_is_installed(self):
        # What else an installation copies would be missing half-way through it.
        commands = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", "tactor", *(["tactor_meshes"] if HAS_MESHES else [])],
                                  capture_output=True, text=True, check=True).stdout
        built = {(BUILD / word).resolve() for word in commands.split()}
        copied = set()
        for script in BUILD.rglob("cmake_install.cmake"):
            if "TYPE" not in script.read_text():
                continue
            for files in re.findall(r"file\(INSTALL DESTINATION .*?FILES(.*?)\)", script.read_text(), re.DOTALL):
                copied |= {pathlib.Path(path).resolve() for path in re.findall(r'"([^"]+)"', files)}
        # What is made while configuring, and the header with the hash, which libtactor is compiled with, are always there.
        configured = (BUILD.resolve() / "CMakeFiles/Export", BUILD.resolve() / "generated")
        made = {path for path in copied if BUILD.resolve() in path.parents and not any(folder in path.parents for folder in configured)}
        self.assertIn((BUILD / "bin/tactor").resolve(), made)
        # A folder is made by what fills it.
        built |= {folder for path in built for folder in path.parents}
        self.assertEqual(made - built, set())


    def test_programs_and_libraries_look_for_others_in_the_build_alone(self):
        self.assertEqual(foreign_run_paths(BUILD), "")


class Programs(Installed):
    def test_programs_and_libraries_look_for_others_in_the_installation_alone(self):
        self.assertEqual(foreign_run_paths(self.prefix), "")

    def test_libraries_in_the_folder_where_it_is_started_are_not_loaded(self):
        needed = set()
        for path in (self.program, *self.prefix.rglob("*.so")):
            text = subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout
            needed.update(line.split()[0] for line in text.splitlines() if "=>" in line)
        self.assertIn("libz.so.1", needed)
        for name in needed:
            (self.elsewhere / name).write_text("no library")
        # Both the build's and the installation's.
        for program in (TACTOR, "tactor"):
            self.run_ok("check", "wall/refit", program=program)
        for emulator in (self.prefix / "bin").glob("tactor-*"):
            subprocess.run([emulator, "--help"], cwd=self.elsewhere, capture_output=True, check=True, timeout=PATIENCE)

    def test_every_library_is_found_and_none_in_the_build_folder(self):
        programs = [p for p in sorted(self.prefix.rglob("*")) if p.is_file() and not p.is_symlink() and is_program(p)]
        self.assertIn(self.program, programs)
        for path in programs:
            with self.subTest(file=path.name):
                text = subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout
                self.assertNotIn("not found", text)
                self.assertNotIn(str(BUILD), text)

    def test_all_nodes_of_the_build_are_there(self):
        built = tactor("nodes").stdout
        self.assertIn("sink.metrics", built)
        self.assertEqual(self.run_ok("nodes").stdout, built)

    def test_the_reference_is_that_of_the_build(self):
        self.run_ok("reference", self.folder / "installed")
        self.assertEqual(tactor("reference", self.folder / "built").returncode, 0)
        pages = sorted(path.relative_to(self.folder / "built") for path in (self.folder / "built").rglob("*.md"))
        self.assertGreater(len(pages), 50)
        for page in pages:
            self.assertEqual((self.folder / "installed" / page).read_text(), (self.folder / "built" / page).read_text(), page)

    def test_manual_pages_and_completion_are_there(self):
        for file in ("man/man1/tactor.1", "man/man1/tactor-run.1", "bash-completion/completions/tactor",
                     "zsh/site-functions/_tactor", "fish/vendor_completions.d/tactor.fish"):
            self.assertTrue((self.prefix / "share" / file).is_file(), file)
        self.assertIn("wall/refit\t", self.run_ok("complete", "--", "run", "wall/r").stdout)

    def test_a_link_to_the_command_is_followed(self):
        link = self.elsewhere / "tactor"
        link.symlink_to(self.program)
        self.assertIn("sink.metrics", self.run_ok("nodes", program=str(link)).stdout)

    def test_devices_and_the_machine_are_looked_at(self):
        self.assertTrue(self.run_ok("devices").stdout)
        diagnosis = json.loads(self.run_ok("doctor", "--json", "--seconds", "0.1").stdout)
        self.assertEqual([finding["id"] for finding in diagnosis["devices"]], ["ports", "serial_group", "udev_rule"])

    def test_a_study_is_run(self):
        graph = self.write("graph.yaml", (EDGES_OF_A_SMALL_GRAPH + METRICS_OF_A_SMALL_GRAPH).replace(
            "nodes:", "nodes:\n  metrics: {type: sink.metrics}"))
        study = self.write("study.yaml", f"graphs: [{graph}]\nvary: {{device.force_max: [4 N, 6 N]}}\nseeds: 2\n"
                                         "duration: 0.1 s\n")
        self.run_ok("study", study, "--out", self.folder / "out")
        self.assertEqual(len((self.folder / "out/study.csv").read_text().splitlines()), 1 + 2 * 2)


class Graphs(Installed):
    def test_those_of_the_repository_are_there(self):
        def files(folder):
            return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.suffix in (".yaml", ".csv", ".md", ".svg")}
        self.assertEqual(files(self.share / "graphs"), files(GRAPHS))

    @needs_meshes
    @needs_hdf5
    def test_one_of_each_mesh_is_run(self):
        for name in ("bunny", "duck", "peg_in_hole"):
            with self.subTest(graph=name):
                # By its name, from the folders of the program.
                self.run_ok("run", f"{name}/refit", "--duration", "0.3", "--out", self.folder / name)
                summary = json.loads((self.folder / name / "summary.json").read_text())
                self.assertGreater(summary["physics"]["steps"], 0)

    @needs_meshes
    def test_a_method_is_laid_over_one(self):
        text = self.run_ok("check", "--explain", self.share / "graphs/duck/scene.yaml",
                           "--over", self.share / "graphs/methods/kalman.yaml").stdout
        self.assertIn("prediction.kalman", text)


class Demo(Installed):
    def put_aside(self, mesh):
        file = self.share / "meshes" / mesh
        aside = file.with_suffix(".aside")
        file.rename(aside)
        self.addCleanup(aside.rename, file)

    @needs_meshes
    def test_it_takes_the_scene_whose_mesh_is_there(self):
        demo = ("demo", "--seeds", "1", "--no-view")
        with subprocess.Popen([self.program, *demo, "--out", self.folder / "begun"], stdout=subprocess.PIPE, text=True, cwd=self.elsewhere,
                              env=dict(os.environ, **self.environment)) as begun:
            self.assertIn("on the scene bunny", begun.stdout.readline())
            begun.kill()
        # As in the packages.
        self.put_aside("bunny.off")
        said = self.run_ok(*demo).stdout
        self.assertIn("duck_local", said)
        self.assertNotIn("bunny", said)
        self.assertTrue((self.elsewhere / "out/demo/report.html").exists())
        self.put_aside("duck.off")
        result = tactor(*demo, program=str(self.program), environment=self.environment, cwd=self.elsewhere)
        self.assertEqual(result.returncode, 2)
        self.assertIn("expected bunny.off or duck.off", result.stderr)


class Desktop(Installed):
    """What menus and software centres read."""

    def setUp(self):
        super().setUp()
        self.entry = self.prefix / "share/applications/tactor.desktop"
        self.metainfo = self.prefix / "share/metainfo/org.tactor.tactor.metainfo.xml"

    @unittest.skipUnless(shutil.which("desktop-file-validate"), "desktop-file-utils is not installed")
    def test_the_entry_is_valid(self):
        result = subprocess.run(["desktop-file-validate", self.entry], capture_output=True, text=True, check=False)
        self.assertEqual((result.returncode, result.stdout), (0, ""))

    @unittest.skipUnless(shutil.which("appstreamcli"), "appstream is not installed")
    def test_the_metadata_are_valid(self):
        result = subprocess.run(["appstreamcli", "validate", "--no-net", self.metainfo], capture_output=True, text=True, check=False)
        # There is no home page yet, of which newer validators warn.
        faults = [line for line in result.stdout.splitlines() if line.startswith(("E:", "W:")) and not line.endswith("url-homepage-missing")]
        self.assertEqual(faults, [], result.stdout + result.stderr)
        self.assertIn("Validation", result.stdout)

    def test_the_newest_release_is_this_version(self):
        releases = xml.etree.ElementTree.parse(self.metainfo).getroot().find("releases")
        self.assertEqual(releases[0].get("version"), VERSION)
        self.assertEqual([r.get("version") for r in releases],
                         re.findall(r"^## (\S+) ", (ROOT / "docs/changelog.md").read_text(), re.MULTILINE))

    @needs_meshes
    def test_what_the_entry_names_is_there(self):
        words = dict(line.split("=", 1) for line in self.entry.read_text().splitlines() if "=" in line)
        command, verb, graph = words["Exec"].split()
        self.assertEqual((command, verb, words["TryExec"]), ("tactor", "view", "tactor"))
        self.run_ok("check", graph)
        icon = self.prefix / f"share/icons/hicolor/scalable/apps/{words['Icon']}.svg"
        self.assertTrue(xml.etree.ElementTree.parse(icon).getroot().tag.endswith("svg"))
        self.assertEqual(xml.etree.ElementTree.parse(self.metainfo).getroot().find("launchable").text, self.entry.name)


class WithoutCgal(Installed):
    """An installation without the plugin of CGAL, as one that must not be under the GPL."""

    def setUp(self):
        super().setUp()
        plugin = next(self.prefix.rglob("libtactor_cgal.so"), None)
        if plugin is not None:
            aside = plugin.with_suffix(".aside")
            plugin.rename(aside)
            self.addCleanup(aside.rename, plugin)
        self.environment["TACTOR_CACHE"] = str(self.folder / "cache")

    def run_graph_of(self, scene, *options):
        return self.run_ok("run", self.share / f"graphs/{scene}/refit.yaml", "--duration", "1.5", "--overwrite", "--out",
                           self.folder / "out", *options)

    def most_contacts(self):
        return json.loads((self.folder / "out/summary.json").read_text())["contacts"]["max"]

    def test_primitives_collide_and_move(self):
        self.assertEqual(self.run_graph_of("wall").stderr, "")
        self.assertGreater(self.most_contacts(), 0)

    @needs_meshes
    def test_meshes_are_taken_as_they_are_with_a_warning(self):
        said = self.run_graph_of("duck").stderr
        self.assertIn("it was neither checked nor repaired, because the plugin tactor_cgal is not installed", said)
        self.assertGreater(self.most_contacts(), 0)

    @needs_meshes
    def test_what_needs_it_says_so(self):
        result = tactor("check", self.share / "graphs/duck/refit.yaml", "--set", "collision.type=collision.exact",
                        program=str(self.program), environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("collision.exact needs the plugin tactor_cgal (package tactor-cgal", result.stderr)


@unittest.skipUnless(HAS_MODBUS, "this build has no Modbus")
class Modbus(Installed):
    def emulate(self, profile):
        return self.emulate_modbus(profile, "--tcp", "0", program="tactor", cwd=self.elsewhere,
                                   env=dict(os.environ, **self.environment))[1]

    def test_each_profile_is_emulated_by_its_name(self):
        names = [p.stem for p in sorted((self.share / "profiles/modbus").glob("*.yaml"))]
        self.assertEqual(names, [p.stem for p in sorted((ROOT / "devices/modbus/profiles").glob("*.yaml"))])
        for name in names:
            with self.subTest(profile=name):
                self.emulate(name)

    @needs_live
    @needs_meshes
    def test_a_live_run_drives_an_emulated_motor(self):
        text = (self.share / "profiles/modbus/iris_orca.yaml").read_text()
        text = text.replace("response_timeout: 25 ms", "response_timeout: 400 ms").replace("time: 150 ms", "time: 5 s")
        connect = self.emulate(self.write("orca.yaml", text))
        graph = self.pressed_wall(f'type: modbus.actuator, profile: orca.yaml, connect: "{connect}", origin: [0, 0, -50 mm]')
        self.run_ok("run", graph, "--no-dead-man", "--out", self.folder / "out")
        self.assertGreater(self.device_part()["ticks"], 0)

    @needs_meshes
    def test_the_graph_of_the_orca_finds_its_profile_by_name(self):
        self.run_ok("check", self.share / "graphs/bunny/orca.yaml")


@unittest.skipUnless(HAS_USB, "this build has no USB")
class Usb(Installed):
    def run_program(self, *words):
        return subprocess.run(words, capture_output=True, text=True, cwd=self.elsewhere, timeout=PATIENCE, check=False,
                              env=dict(os.environ, **self.environment))

    def test_each_profile_is_emulated_by_its_name(self):
        names = [p.stem for p in sorted((ROOT / "devices/usb/profiles").glob("*.yaml"))]
        self.assertTrue(names)
        for name in (*names, "falcon"):
            for start in (["tactor", "emulate", "usb"], ["tactor-emulate-usb"]):
                with self.subTest(profile=name, start=start[0]):
                    result = self.run_program(*start, name, "--", "tactor", "devices")
                    self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                    self.assertIn(name, result.stdout)

    @needs_live
    @needs_meshes
    def test_a_live_run_drives_an_emulated_device(self):
        graph = self.pressed_wall("type: usb.device, profile: polhem, origin: [0, 0, 10 mm]")
        result = self.run_program("tactor", "emulate", "usb", "polhem", "--",
                                  "tactor", "run", graph, "--out", self.folder / "out")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertGreater(self.device_part()["ticks"], 0)

    def test_the_rule_of_udev_and_the_unit_of_systemd_lie_where_these_look_below_the_usual_prefixes(self):
        rule = (self.prefix / "lib/udev/rules.d/70-tactor.rules").read_text()
        self.assertRegex(rule, re.compile(r'ATTR\{idVendor\}=="0403"'))
        self.assertIn("ExecStart=tactor run", (self.prefix / "lib/systemd/system/tactor@.service").read_text())


if __name__ == "__main__":
    unittest.main()
