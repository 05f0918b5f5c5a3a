"""Pictures of the view, made by a real browser that the command starts: one of each shipped scene, and one that moves."""
import re
import struct
import unittest
import zlib

from browser import needs_browser
from harness import GRAPHS, CommandTest, needs_meshes, needs_view, tactor

WALL = str(GRAPHS / "wall/scene.yaml")


def png_pixels(data):
    """The rows of a PNG of 8 bits a channel, without its filters undone: enough to see that it is not blank."""
    width, height, _, color = struct.unpack(">IIBB", data[16:26])
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    return width, height, zlib.decompress(packed)


@needs_view
@needs_browser
class Pictures(CommandTest):
    @needs_meshes
    def test_pictures_show_something_of_every_shipped_scene(self):
        for scene in sorted(GRAPHS.glob("*/scene.yaml")):
            with self.subTest(scene.parent.name):
                file = self.folder / f"{scene.parent.name}.png"
                result = tactor("view", scene, "--duration", "0.5 s", "--no-reference", "--picture", file,
                                *(("--page",) if scene.parent.name in ("recorded", "virtual_wall") else ()))  # without bodies
                self.assertEqual(result.returncode, 0, result.stderr)
                width, height, pixels = png_pixels(file.read_bytes())
                self.assertGreaterEqual(width * height, 960 * 600)
                self.assertGreater(len(set(pixels)), 12)

    def test_a_picture_moves_or_is_refused(self):
        moving = self.folder / "moving.svg"
        result = tactor("view", WALL, "--duration", "1 s", "--picture", moving)
        self.assertEqual(result.returncode, 0, result.stderr)
        frames = re.findall(r'href="(data:image/[^"]+)"', moving.read_text())
        self.assertGreater(len(set(frames)), len(frames) // 2)
        self.assertEqual(tactor("view", WALL, "--picture", self.folder / "x.gif").returncode, 2)


if __name__ == "__main__":
    unittest.main()
