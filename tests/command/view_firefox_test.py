"""The view in Firefox: the scene is drawn, the tool is dragged, the force shows and is released with words; no error on the way."""
import time
import unittest

from firefox import Firefox, needs_firefox
from harness import GRAPHS, TACTOR, CommandTest, needs_live, needs_view
from view_client import View

WALL = str(GRAPHS / "wall/scene.yaml")


@needs_view
@needs_live
@needs_firefox
class InFirefox(CommandTest):
    def setUp(self):
        super().setUp()
        self.browser = Firefox(self.folder / "profile", 1000, 700)
        self.addCleanup(self.browser.quit)

    def js(self, expression):
        return self.browser.execute_script(f"return {expression};")

    def until(self, expression, seconds=20):
        end = time.monotonic() + seconds
        while not self.js(expression):
            self.assertLess(time.monotonic(), end, f"{expression} did not come true: {self.js('document.body.innerText.slice(0, 400)')}")
            time.sleep(0.05)

    def press(self):
        """Drags the tool down until the device is given a force; again where a busy machine released it on the way."""
        for _ in range(3):
            x, y = (round(v) for v in self.js("window.tactor.project(...window.tactor.latest('device.state').values.slice(0, 3))"))
            self.browser.mouse((x, y), "down")
            for step in range(80):
                self.browser.mouse((x, y + 2 * step))
                if self.js("window.tactor.latest('device.commanded').values[2]") > 0.5:
                    return
            self.browser.mouse("up")
        self.fail(f"no force came: {self.js('window.tactor.released')}")

    def test_the_tool_is_pressed_and_let_go_in_firefox(self):
        with View(TACTOR, WALL, "--no-reference") as view:
            self.browser.get(view.url)
            self.until("window.tactor?.connected && window.tactor.latest('device.state')")
            self.assertTrue(self.js("document.createElement('canvas').getContext('webgl2') !== null"), "Firefox has no WebGL here")
            self.until("document.getElementById('scene-canvas') && window.tactor.counters.frames_drawn > 1")
            self.press()
            self.until("document.getElementById('release').hidden")
            self.assertGreater(self.js("new DOMMatrix(getComputedStyle(document.getElementById('force-fill')).transform).a"), 0.01)
            looker = view.page()
            self.browser.mouse("up")
            self.until("window.tactor.released?.what.startsWith('You let go')")
            self.press()
            self.browser.get("about:blank")
            looker.take_for(1.5)
            self.assertEqual(looker.stream("commanded")[-1][1][2], 0.0)
            self.assertEqual(looker.last("status")["hold"], "page_gone")
            looker.close()
            self.browser.get(view.url)
            self.until("window.tactor?.connected")
            self.assertIsNone(self.js("window.tactor.error"))


if __name__ == "__main__":
    unittest.main()
