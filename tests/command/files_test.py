"""Files that the command reads and keeps: whose they are, what kind they are, and how large."""
import gzip
import os
import resource
import subprocess
import unittest

from harness import (EDGES_OF_A_SMALL_GRAPH, IS_SANITIZED, PRESSED_WALL, ROOT, TACTOR, CommandTest, needs_meshes,
                     needs_devices, needs_hdf5, tactor)

try:
    import h5py
except ImportError:
    h5py = None

PATIENCE = 120
EMULATOR = ROOT.joinpath(TACTOR).parent / "tactor-emulate-usb"


class KeptFiles(CommandTest):
    @needs_meshes
    @needs_devices
    @unittest.skipUnless(EMULATOR.exists(), "this build has no emulated USB")
    def test_a_calibration_is_never_kept_in_the_folder_for_temporary_files(self):
        temporary, home = self.folder / "tmp", self.folder / "home"
        planted = temporary / f"tactor-{os.geteuid()}"
        planted.mkdir(parents=True)
        home.mkdir()
        environment = {key: value for key, value in os.environ.items() if not key.startswith("XDG_")}
        environment.update(self.environment, TMPDIR=str(temporary), HOME=str(home))
        graph = self.write("graph.yaml", PRESSED_WALL % {
            "device": "type: usb.device, profile: polhem", "height": "50 mm", "duration": "1 s"})
        done = subprocess.run([EMULATOR, "polhem", "--uncalibrated", "--", TACTOR, "device", "calibrate", graph, "--yes"],
                              capture_output=True, text=True, env=environment, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(list(planted.iterdir()), [])
        kept = list((home / ".local/state/tactor").glob("usb-*.zero"))
        self.assertEqual(len(kept), 1)
        self.assertEqual(kept[0].stat().st_mode & 0o7777, 0o600)
        self.assertEqual(kept[0].parent.stat().st_mode & 0o7777, 0o700)


class LinksInTheFolderOfResults(CommandTest):
    """A folder of a stranger may hold links that lead out of it."""

    @needs_hdf5
    def test_no_result_is_written_through_a_link_that_leads_nowhere(self):
        run = ("run", ROOT / "graphs/wall/refit.yaml", "--duration", "0.1 s", "--out", self.folder / "out")
        names = ("summary.json", "recording.h5", "report.html", "graph.yaml")
        (self.folder / "out").mkdir()
        for name in names:
            (self.folder / "out" / name).symlink_to(self.folder / "elsewhere" / name)
        (self.folder / "elsewhere").mkdir()
        for name in names:
            with self.subTest(name):
                result = tactor(*run, environment=self.environment)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(f"found {name}", result.stderr)
                (self.folder / "out" / name).unlink()
        for name in names:
            (self.folder / "out" / name).symlink_to(self.folder / "elsewhere" / name)
        self.run_ok(*run, "--overwrite")
        self.assertEqual(list((self.folder / "elsewhere").iterdir()), [])
        self.assertGreater((self.folder / "out/summary.json").stat().st_size, 100)

    @needs_hdf5
    def test_a_result_takes_the_place_of_a_link(self):
        """Whether the link leads to a file of the user or nowhere."""
        notes = self.folder / "notes"
        notes.mkdir()
        (notes / "kept").write_text("of the user")

        def link(*names):
            for name in names:
                place = self.folder / name
                place.parent.mkdir(exist_ok=True)
                place.unlink(missing_ok=True)
                place.symlink_to(notes / ("kept" if len(name) % 2 else place.name))

        study = self.write("small.yaml", f"graphs: [{ROOT}/graphs/wall/scene.yaml]\nseeds: 1\nduration: 0.6 s\nreference: none\n")
        link("s/study.sqlite")
        refused = tactor("study", study, "--out", self.folder / "s", environment=self.environment)
        self.assertEqual(refused.returncode, 2, refused.stderr)
        results = [f"s/{name}" for name in ("study.sqlite", "study.h5", "study.csv", "run_times.csv", "study.json", "report.html")]
        link(*results)
        self.run_ok("study", study, "--out", self.folder / "s", "--overwrite")
        self.run_ok("run", ROOT / "graphs/wall/refit.yaml", "--duration", "0.1 s", "--out", self.folder / "r")
        (notes / "times.txt").write_text("of the user")
        (self.folder / "r/costs").symlink_to(notes)
        self.run_ok("run", ROOT / "graphs/wall/refit.yaml", "--duration", "0.1 s", "--set", "record=[device.commanded, coupling.force]",
                    "--out", self.folder / "r", "--overwrite")
        results += ["page.html", "film.mcap"]
        link("page.html", "film.mcap")
        self.run_ok("export", self.folder / "r/recording.h5", "--html", self.folder / "page.html")
        self.run_ok("export", self.folder / "r/recording.h5", "--mcap", self.folder / "film.mcap")
        self.assertEqual(sorted(place.name for place in notes.iterdir()), ["kept", "times.txt"])
        self.assertEqual((notes / "kept").read_text(), "of the user")
        for name in results:
            self.assertFalse((self.folder / name).is_symlink(), name)
            self.assertGreater((self.folder / name).stat().st_size, 20, name)


class InputFiles(CommandTest):
    """What is no file, or fills the memory, ends with exit code 2 and the name of the file."""

    def refused(self, *arguments, timeout=20, memory=None):
        if memory is not None and IS_SANITIZED:
            self.skipTest("a sanitizer takes more address space than the limit")
        limit = None if memory is None else lambda: resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        done = subprocess.run([TACTOR, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, check=False,
                              stdin=subprocess.DEVNULL, env=dict(os.environ, **self.environment), preexec_fn=limit)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def small_graph(self, **replaced):
        text = EDGES_OF_A_SMALL_GRAPH
        for old, new in replaced.values():
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write("graph.yaml", text)

    def test_a_pipe_without_a_writer_is_refused_wherever_a_file_is_named(self):
        graph = self.small_graph()
        for name in ("pipe", "pipe.yaml", "pipe.csv", "pipe.off", "pipe.h5"):
            os.mkfifo(self.folder / name)
        pipe = self.folder / "pipe.yaml"
        played = self.write("played.yaml", "clock: virtual\nduration: 1 s\nnodes:\n  hand: {type: source.recording, "
                            "file: pipe.csv, columns: {time: t_s, force.x: F_N}}\n  device: {type: device.simulated}\n"
                            "edges: [hand.target -> device.target]\nrecord: [device.state]\n")
        for arguments in (("check", pipe), ("run", pipe), ("check", graph, "--over", pipe), ("study", pipe),
                          ("graph", pipe), ("export", self.folder / "pipe.h5", "device.state"),
                          ("repair", self.folder / "pipe.h5"), ("check", played), ("run", played)):
            with self.subTest(arguments=arguments):
                self.assertRegex(self.refused(*arguments), "pipe")

    def recording(self, rows):
        """A graph that plays so many rows of a CSV file, and the file."""
        return self.write("played.yaml", "clock: virtual\nduration: 1 s\nnodes:\n  hand: {type: source.recording, "
                          f"file: {rows}, columns: {{time: t_s, position.x: x_mm}}}}\n"
                          "  device: {type: device.simulated}\n"
                          "edges: [hand.target -> device.target]\nrecord: [device.state]\n")

    def test_a_table_of_too_many_lines_is_refused_in_little_memory(self):
        table = self.folder / "long.csv.gz"
        with gzip.open(table, "wb", compresslevel=1) as out:
            out.write(b"t_s,x_mm\n")
            for block in range(15):
                out.write(b"".join(b"%d,1\n" % (100_000 * block + i) for i in range(100_000)))
        text = self.refused("run", self.recording(table), timeout=120, memory=1_500_000_000)
        self.assertIn("long.csv.gz:1000002: expected at most 1000000 rows", text)

    def test_a_table_that_needs_more_memory_than_there_is_is_told_with_its_name_and_size(self):
        table = self.folder / "long.csv"
        with open(table, "wb") as out:
            out.write(b"t_s,x_mm\n")
            out.write(b"".join(b"%d,1\n" % i for i in range(990_000)))
        size = f"({table.stat().st_size / 1e6:.1f} MB)"
        text = self.refused("run", self.recording(table), timeout=120, memory=250_000_000)
        self.assertIn(f"long.csv: the file {size} needs more memory than there is", text)

    def test_the_longest_table_plays_its_motion_and_its_force_in_less_than_a_gigabyte(self):
        if IS_SANITIZED:
            self.skipTest("a sanitizer takes more memory")
        table = self.folder / "long.csv"
        with open(table, "wb") as out:
            out.write(b"t_s,F_N,x_mm\n")
            out.write(b"".join(b"%d,1,2\n" % i for i in range(1_000_000)))
        graph = self.recording(table)
        graph.write_text(graph.read_text().replace("position.x: x_mm", "position.x: x_mm, force.x: F_N"))
        limit = 1_000_000_000
        done = subprocess.run([TACTOR, "check", graph], capture_output=True, text=True, timeout=120, check=False,
                              env=dict(os.environ, **self.environment),
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_table_that_unpacks_without_end_is_refused_in_little_memory(self):
        for name, block in (("zeros.csv.gz", b"\0" * 1_000_000), ("lines.csv.gz", b"t_s,x_mm\n" + b"\n" * 999_991)):
            with self.subTest(name=name):
                table = self.folder / name
                with gzip.open(table, "wb", compresslevel=9) as out:
                    for i in range(600):
                        out.write(block if i == 0 else block[-1:] * 1_000_000)
                self.assertLess(table.stat().st_size, 1_000_000)
                self.assertIn(name, self.refused("run", self.recording(table), timeout=120, memory=1_000_000_000))

    @needs_hdf5
    @unittest.skipIf(h5py is None, "h5py is not installed")
    def test_a_recording_that_says_it_holds_more_than_its_file_is_refused_at_once(self):
        graph = self.small_graph(record=("edges:\n", "record: [trajectory.target]\nedges:\n"))
        self.run_ok("run", graph, "--out", self.folder / "out")
        recording = self.folder / "out/recording.h5"
        self.assertIn("valid_s", self.run_ok("export", recording, "trajectory.target").stdout)
        with h5py.File(recording, "r+") as file:
            data = file["streams/trajectory.target/messages"] if "messages" in file["streams/trajectory.target"] else \
                next(iter(file["streams/trajectory.target"].values()))
            data.resize((2 ** 40,))
        self.assertLess(recording.stat().st_size, 1_000_000)
        text = self.refused("export", recording, "trajectory.target")
        self.assertIn(f"says that it holds {2 ** 40} messages", text)
        played = self.write("played.yaml", "clock: virtual\nduration: 1 s\nnodes:\n  hand: {type: source.recording, "
                            f"file: {recording}, stream: trajectory.target}}\n  device: {{type: device.simulated}}\n"
                            "edges: [hand.target -> device.target]\nrecord: [device.state]\n")
        self.assertIn("recording.h5", self.refused("run", played))


if __name__ == "__main__":
    unittest.main()
