"""A study on a cluster names commands to run, so that only what its user alone could have written is believed."""
import json
import os
import shutil
import unittest

from cluster_local_test import MANY, ClusterTest
from harness import tactor

NOBODY = 65534
QUESTIONS = (("--status",), ("--cancel",), ("--wait",), ("--resume",))


class Trust(ClusterTest):
    """A study that was handed over, and a cluster file whose commands leave a trace."""

    def setUp(self):
        super().setUp()
        self.trace = self.folder / "trace"
        systems = self.folder / "systems"
        systems.mkdir()
        self.system = systems / "traced.yaml"
        self.system.write_text(f"submit: [sh, -c, 'echo 7', '{{script}}']\nstatus: [touch, {self.trace}]\ncancel: [touch, {self.trace}]\n"
                               "index: I\nstates: {waiting: [Q], running: [R]}\n")
        self.out = self.folder / "out"
        self.study(MANY, "out", "--cluster", str(self.system))
        self.trace.unlink(missing_ok=True)
        self.options = self.out / "cluster/options.json"

    def ask(self, *options, folder=None):
        return tactor("study", folder or self.out, *options, environment=self.environment)

    def refused(self, place, word, folder=None):
        """Every question is refused with the place and a remedy, and no command of the cluster file has run."""
        for options in QUESTIONS:
            result = self.ask(*options, folder=folder)
            self.assertEqual(result.returncode, 2, f"{options}\n{result.stdout}{result.stderr}")
            self.assertIn(f"{place}: ", result.stderr)
            self.assertIn(word, result.stderr)
            self.assertRegex(result.stderr, "nothing more is done|no command of the cluster file .* was run")
            self.assertFalse(self.trace.exists(), f"{options} ran a command of the study's folder")

    def believed(self, folder=None):
        result = self.ask("--status", folder=folder)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertTrue(self.trace.exists())
        self.trace.unlink()

    def files(self):
        """What decides what is run: the folders, then the files."""
        return [self.out, self.out / "cluster", self.out / "cluster/plan.bin", self.options,
                self.out / "cluster/jobs/0000.json", self.system.parent, self.system]


class WhatOthersMayWrite(Trust):
    def test_what_group_or_others_may_write_is_refused_with_its_place(self):
        self.believed()
        members = 0
        for place in self.files():
            before = place.stat().st_mode
            for more in (0o020, 0o002):
                place.chmod(before | more)
                with self.subTest(place=place.name, mode=oct(more)):
                    # A folder that all may write without the sticky bit is found out on the way to what is in it.
                    self.refused(place, "chmod")
                place.chmod(before)
                members += 1
        self.believed()
        self.assertEqual(members, 14)

    def test_a_folder_above_in_which_all_may_replace_the_study_is_refused_and_a_sticky_one_is_not(self):
        above = self.folder / "above"
        above.mkdir()
        moved = shutil.move(self.out, above / "out")
        above.chmod(0o777)
        self.refused(above, "chmod +t", folder=moved)
        above.chmod(0o1777)
        self.believed(folder=moved)
        above.chmod(0o775)
        self.believed(folder=moved)

    def test_a_study_of_a_user_whose_group_may_write_new_files_is_believed(self):
        for mask in (0o002, 0o000, 0o077):
            before = os.umask(mask)
            try:
                self.study(MANY, f"of_{mask}", "--cluster", str(self.system))
            finally:
                os.umask(before)
            self.trace.unlink(missing_ok=True)
            for place in (self.folder / f"of_{mask}").rglob("*"):
                if place.is_dir():
                    self.assertEqual(place.stat().st_mode & 0o022, 0, place)
            self.believed(folder=self.folder / f"of_{mask}")

    def test_a_link_in_the_place_of_a_file_is_refused(self):
        for name in ("cluster/options.json", "cluster/plan.bin", "cluster/jobs/0000.json"):
            file = self.out / name
            kept = file.rename(self.folder / "kept")
            file.symlink_to(kept)
            self.refused(file, "is a link")
            file.unlink()
            kept.rename(file)
        self.believed()

    def test_what_tasks_have_made_is_read_where_nobody_else_can_have_made_it(self):
        runs = self.out / "cluster/runs"
        shard = runs / "0000000.shard"
        os.mkfifo(shard)  # nobody writes it: reading would wait for ever
        self.assertIn(f"{shard}: is not a regular file", self.ask("--resume").stderr)
        shard.unlink()
        shard.write_bytes(b"")
        shard.chmod(0o664)
        self.assertIn(f"{shard}: other users may write it", self.ask("--resume").stderr)
        shard.chmod(0o644)
        runs.chmod(0o775)
        result = self.ask("--resume")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(f"{runs}: other users may write it", result.stderr)
        runs.chmod(0o755)
        self.assertEqual(self.ask("--resume").returncode, 0)

    def test_links_of_the_user_to_a_folder_and_to_a_cluster_file_are_followed(self):
        link = self.folder / "link"
        link.symlink_to(self.out)
        self.believed(folder=link)
        kept = self.system.rename(self.system.parent / "kept.yaml")
        self.system.symlink_to(kept)
        self.believed()

    def test_the_user_that_a_file_names_says_nothing(self):
        told = json.loads(self.options.read_text())
        self.assertNotIn("user", told)

    def test_a_folder_that_others_may_write_gets_no_study(self):
        self.out.chmod(0o777)
        result = self.study(None, "out", "--cluster", str(self.system), "--overwrite", code=2)
        self.assertIn(f"{self.out}: ", result.stderr)
        self.assertFalse(self.trace.exists())
        result = self.study(None, "out", "--overwrite", code=2)
        self.assertFalse(self.trace.exists())


@unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
class WhatAnotherUserOwns(Trust):
    def test_what_another_user_owns_is_refused_with_its_place_and_that_user(self):
        for place in self.files():
            os.chown(place, NOBODY, NOBODY)
            with self.subTest(place=place.name):
                self.refused(place, "belongs to the user nobody")
            os.chown(place, 0, 0)
        self.believed()

    def test_a_whole_folder_of_another_user_that_says_it_is_ours_is_refused(self):
        """The attack: somebody makes a study whose options name his commands, and waits for root to ask."""
        told = json.loads(self.options.read_text())
        self.options.write_text(json.dumps({**told, "user": os.getuid()}))
        for place in [self.out, *self.out.rglob("*"), self.system.parent, self.system]:
            os.chown(place, NOBODY, NOBODY)
        self.refused(self.out, "run the program as nobody")
        result = tactor("study", self.folder / "study.yaml", "--out", self.out, "--overwrite", environment=self.environment)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertFalse(self.trace.exists())
        self.assertTrue(self.options.exists())

    def test_a_link_of_another_user_is_not_followed(self):
        link = self.folder / "link"
        link.symlink_to(self.out)
        os.chown(link, NOBODY, NOBODY, follow_symlinks=False)
        self.refused(link, "is a link of the user nobody", folder=link)
        kept = self.system.rename(self.system.parent / "kept.yaml")
        self.system.symlink_to(kept)
        os.chown(self.system, NOBODY, NOBODY, follow_symlinks=False)
        self.refused(self.system, "is a link of the user nobody")

    def test_a_folder_that_somebody_makes_while_the_cluster_is_asked_gets_no_study(self):
        mine = self.folder / "mine.yaml"
        made = self.folder / "made"
        mine.write_text(self.system.read_text() + "most_tasks: [sh, -c, 'mkdir -p %s; chown %d %s; echo 9']\n" % (made, NOBODY, made))
        result = self.study(None, "made", "--cluster", str(mine), code=2)
        self.assertIn(f"{made}: ", result.stderr)
        self.assertIn("nobody", result.stderr)
        self.assertEqual(list(made.iterdir()), [])

    def test_a_task_of_another_user_s_folder_does_not_run(self):
        for place in [self.out, *self.out.rglob("*")]:
            os.chown(place, NOBODY, NOBODY)
        code, errors = self.made("out", 0)
        self.assertEqual(code, 2, errors)
        self.assertIn("belongs to the user nobody", errors)


if __name__ == "__main__":
    unittest.main()
