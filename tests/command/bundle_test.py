"""A study as an archive: unpacked elsewhere it gives the same table, by its own libraries alone."""
import os
import re
import subprocess
import tarfile
import unittest

from harness import GRAPHS, ROOT, CommandTest, needs_meshes, tactor

# Of the machine, not of the bundle.
C_LIBRARY = re.compile(r"^(linux-vdso|/lib64/ld-linux|lib(c|m|dl|rt|pthread|resolv|util|nsl|mvec|anl)\.so)")


class Bundle(CommandTest):
    def bundle(self, *words, code=0):
        result = tactor("bundle", *words, environment=self.environment)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result.stdout + result.stderr

    def unpacked(self, archive):
        folder = self.folder / "elsewhere"
        folder.mkdir()
        with tarfile.open(archive) as files:
            files.extractall(folder)
        return folder / archive.name.removesuffix(".tar.gz")

    def run_bare(self, *words):
        """Without the environment of this user."""
        result = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=300, check=False,
                                env={"PATH": "/usr/bin:/bin", "HOME": str(self.folder)})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    @needs_meshes
    def test_a_shipped_study_runs_elsewhere_by_what_the_archive_has(self):
        archive = self.folder / "table2_refit.tar.gz"
        said = self.bundle("table2_refit", "--out", archive)
        self.assertIn("./tactor study files/studies/table2_refit.yaml --cluster slurm --partition NAME", said)
        place = self.unpacked(archive)
        words = ("--short", "--seeds", "1", "--duration", "1 s", "--judge", "whole")
        self.run_bare(place / "tactor", "study", place / "files/studies/table2_refit.yaml", *words, "--out", self.folder / "there",
                      "--cluster", "local", "--wait")
        result = tactor("study", GRAPHS / "studies/table2_refit.yaml", *words, "--out", self.folder / "here",
                        environment=self.environment)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual((self.folder / "there/study.csv").read_bytes(), (self.folder / "here/study.csv").read_bytes())
        # Every library of program, plugins and nodes but the C library is one of the archive.
        binaries = [place / "bin/tactor", *place.rglob("*.so")]
        self.assertGreater(len(binaries), 8)
        folders = f"{place}/lib:{place}/system_lib"
        for binary in binaries:
            listed = subprocess.run(["ldd", binary], capture_output=True, text=True, check=True,
                                    env=dict(os.environ, LD_LIBRARY_PATH=folders)).stdout
            for line in listed.splitlines():
                name, _, found = line.strip().partition(" => ")
                if not C_LIBRARY.match(name):
                    self.assertTrue(found.startswith(str(place)), f"{binary}: {line}")
        result = subprocess.run([ROOT / "scripts/run_paths", place], capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stdout)
        # Runs in virtual time need neither view nor live engine nor Python.
        names = {file.name for file in place.rglob("libtactor_*.so")}
        self.assertFalse(names & {"libtactor_view.so", "libtactor_live.so", "libtactor_python.so"})

    def test_own_files_keep_their_places_to_each_other(self):
        (self.folder / "work/graphs").mkdir(parents=True)
        (self.folder / "work/studies").mkdir()
        wall = (GRAPHS / "wall/scene.yaml").read_text()
        (self.folder / "work/graphs/mine.yaml").write_text(wall)
        study = self.folder / "work/studies/mine.yaml"
        study.write_text("graphs: [../graphs/mine.yaml]\nseeds: 1\nduration: 1 s\nreference: none\njudge: whole\n")
        archive = self.folder / "mine.tar.gz"
        self.bundle(study, "--out", archive)
        place = self.unpacked(archive)
        self.assertEqual((place / "files/graphs/mine.yaml").read_text(), wall)
        self.run_bare(place / "tactor", "study", place / "files/studies/mine.yaml", "--out", self.folder / "there")
        # The same bytes whenever it is made.
        before = archive.read_bytes()
        self.bundle(study, "--out", archive, "--overwrite")
        self.assertEqual(archive.read_bytes(), before)

    def test_what_cannot_be_packed_is_refused(self):
        study = self.write("mine.yaml", f"graphs: [{GRAPHS}/wall/scene.yaml]\nseeds: 1\n")
        archive = self.folder / "mine.tar.gz"
        self.assertIn(f"found {GRAPHS}/wall/scene.yaml, which does not exist on another machine", self.bundle(study, "--out", archive, code=2))
        self.assertFalse(archive.exists())
        self.assertIn("expected a name that ends in .tar.gz", self.bundle(study, "--out", self.folder / "mine.zip", code=2))
        self.assertIn("expected a folder that exists", self.bundle(study, "--out", self.folder / "no/mine.tar.gz", code=2))
        archive.touch()
        self.assertIn("--overwrite replaces it", self.bundle(study, "--out", archive, code=2))
        self.assertIn("no_such", self.bundle("no_such", "--out", self.folder / "a.tar.gz", code=2))


if __name__ == "__main__":
    unittest.main()
