"""Files that the command reads and keeps: whose they are, what kind they are, and how large."""
import os
import subprocess
import unittest

from harness import PRESSED_WALL, ROOT, TACTOR, CommandTest, needs_collision, needs_devices

PATIENCE = 120
EMULATOR = ROOT.joinpath(TACTOR).parent / "tactor-emulate-usb"


class KeptFiles(CommandTest):
    @needs_collision
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


if __name__ == "__main__":
    unittest.main()
