"""The view in a real browser: drag the tool, switch the method, turn a knob, stop; replay, scrub, save, open offline; block, close."""
import json
import os
import pathlib
import re
import shutil
import tempfile
import time
import unittest

from browser import MISSING, needs_browser, open_browser
from harness import GRAPHS, TACTOR, CommandTest, needs_live, needs_view, tactor
from view_client import View

if not MISSING:
    from selenium.webdriver.common.by import By

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", pathlib.Path(TACTOR).resolve().parents[1]))
WALL = str(GRAPHS / "wall/scene.yaml")
GEL = str(GRAPHS / "gel_cube/scene.yaml")


@needs_view
@needs_live
@needs_browser
class Browser(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="tactor-view-"))
        cls.addClassCleanup(shutil.rmtree, cls.made, ignore_errors=True)
        cls.browser = open_browser(cls.made / "profile", cls.made, ("--window-size=1000,700",))
        cls.browser.set_script_timeout(30)
        cls.addClassCleanup(cls.browser.quit)

    def js(self, expression, *arguments):
        return self.browser.execute_script(f"return {expression};", *arguments)

    def until(self, expression, seconds=20):
        end = time.monotonic() + seconds
        while not self.js(expression):
            self.assertLess(time.monotonic(), end, f"{expression} did not come true: {self.js('document.body.innerText.slice(0, 400)')} {self.browser.get_log('browser')}")
            time.sleep(0.05)

    def open(self, url):
        self.browser.get("about:blank")
        self.browser.get_log("browser")
        self.browser.get(url)

    def assert_no_errors(self):
        wrong = [line["message"] for line in self.browser.get_log("browser")
                 if line["level"] == "SEVERE" and "favicon" not in line["message"]]
        self.assertEqual(wrong, [])

    def latest(self, stream):
        return self.js(f"window.tactor.latest('{stream}')?.values")

    def grab(self):
        """Takes hold of the tool with the mouse."""
        self.until("window.tactor?.connected && window.tactor.latest('device.state')")
        self.browser.execute_script("document.getElementById('scene').scrollIntoView(false); window.scrollTo(0, 0);")
        x, y = self.js("window.tactor.project(...window.tactor.latest('device.state').values.slice(0, 3))")
        self.where = [round(x), round(y)]
        self.mouse("mouseMoved", 0)
        self.mouse("mousePressed")

    def mouse(self, kind, buttons=1):
        # Not by actions of WebDriver, which take 100 ms each.
        x, y = self.where
        self.browser.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, "button": "left" if buttons else "none",
                                                                  "buttons": buttons, "clickCount": 1 if kind != "mouseMoved" else 0})

    def drag(self, dx, dy, steps):
        x, y = self.where
        for step in range(1, steps + 1):
            self.where = [x + dx * step // steps, y + dy * step // steps]
            self.mouse("mouseMoved")

    def let_go(self):
        self.mouse("mouseReleased")

    def until_released(self, what, again):
        """Until the page says in words what released the force, and how to engage again."""
        told = "document.getElementById('release').innerText"
        self.until(f"window.tactor.released?.what.includes('{what}') && {told}.includes('{what}') && {told}.includes('{again}')")

    def press(self, newtons=0.5, most=220):
        """Drags the tool down until the device is given a force. As a person does, it lets go and tries again where the tool was
        released on the way: a machine that is busy may keep the page from its heartbeat."""
        for _ in range(3):
            self.grab()
            for _ in range(most // 2):
                self.drag(0, 2, 1)
                time.sleep(0.03)
                if self.latest("device.commanded")[2] > newtons:
                    return
            self.let_go()
            time.sleep(0.3)
        self.fail(f"no force came: {self.js('window.tactor.latest(`device.safety`)')}")

    def test_the_tool_is_dragged_methods_are_switched_knobs_turned_and_the_run_is_stopped(self):
        with View(TACTOR, WALL, "--over", str(GRAPHS / "methods/side_by_side.yaml")) as view:
            begun = time.monotonic()
            self.open(view.url)
            self.until("window.tactor?.counters.frames_drawn > 1")
            self.assertLess(time.monotonic() - begun, 10)
            self.assertEqual(self.js("window.tactor.without_words"), [])
            self.until_released("Nobody holds the tool", "Press on the tool")
            self.press()
            self.until("document.getElementById('release').hidden")
            self.assertGreater(self.latest("dynamics.state")[0], 0)
            self.assertEqual(self.js("window.tactor.hello.engagements[window.tactor.latest('device.safety').values[0]]"), "engaged")
            # The other methods, by their buttons.
            for button in self.browser.find_elements(By.CSS_SELECTOR, "#methods button")[1:4]:
                button.click()
                self.until(f"window.tactor.parameters['select.use'] !== 'first'")
            self.until("window.tactor.parameters['select.use'] === 'fourth'")
            # The mouse was let go for the clicks.
            self.press(0.3)
            self.until("window.tactor.status.reference?.rms >= 0")
            self.until("document.getElementById('felt').textContent.startsWith('A hand feels: ')")
            self.assertFalse(self.js("document.getElementById('felt').hidden"))
            self.let_go()
            self.until_released("You let go", "Press on the tool")
            # A knob, by its number, and what the session says of it.
            number = self.browser.find_element(By.ID, "knob-device.force_max-number")
            self.browser.execute_script("arguments[0].value = '2.5'; arguments[0].dispatchEvent(new Event('change', {bubbles: true}));", number)
            self.until("window.tactor.parameters['device.force_max'] === 2.5")
            looker = view.page()
            self.assertEqual(next(p for p in looker.hello["parameters"] if p["name"] == "device.force_max")["value"], 2.5)
            self.browser.execute_script("arguments[0].value = '-3'; arguments[0].dispatchEvent(new Event('change', {bubbles: true}));", number)
            time.sleep(1)
            self.assertEqual(self.js("window.tactor.parameters['device.force_max']"), 2.5)
            # Two clients.
            self.until("window.tactor.status.clients === 2")
            self.assert_no_errors()
            self.browser.find_element(By.ID, "stop").click()
            view.process.wait(20)
            self.assertEqual(view.process.returncode, 0)
            self.until_released("STOP was pressed", "Start the run again")
            looker.close()

    def test_a_surface_that_is_pressed_goes_down_in_the_page(self):
        with View(TACTOR, GEL, "--set", "scene.bodies.gel.tetrahedra=300", "--no-reference") as view:
            self.open(view.url)
            self.press(1.0)
            self.until("window.tactor.latest('dynamics.surfaces')")
            heights = self.latest("dynamics.surfaces")[2::3]
            top = [z for z in heights if z > 0.012]  # of 20 mm at rest
            self.assertLess(min(top), 0.0195)
            # Far from the ball it stays.
            self.assertAlmostEqual(max(heights), 0.02, delta=0.001)
            self.assertAlmostEqual(min(heights), -0.02, delta=1e-6)
            self.assert_no_errors()

    def draw_slowly(self, period):
        """From now on a frame takes so many milliseconds, in which the page does nothing else."""
        self.browser.execute_script("let end = performance.now(); const slow = () => { end = Math.max(end + arguments[0], performance.now());"
                                    "while (performance.now() < end); requestAnimationFrame(slow); }; requestAnimationFrame(slow);", period)

    def is_held_at_2_frames_a_second(self, looker):
        """Whether the page keeps its force for 3 s while it draws that slowly."""
        self.draw_slowly(500)
        looker.take_for(1)
        begin = looker.stream("commanded")[-1][0]
        looker.take_for(3)
        self.assertLess(self.js("window.tactor.counters.fps"), 2.2)
        return all(v[2] > 0.2 for t, v in looker.stream("commanded") if t > begin)

    def test_a_page_of_2_frames_a_second_keeps_the_force_until_it_is_closed(self):
        for attempt in range(3):  # a machine that is busy may keep the page from its heartbeat
            with View(TACTOR, WALL) as view:
                self.open(view.url)
                self.press()
                looker = view.page()
                held = self.is_held_at_2_frames_a_second(looker)
                self.browser.get("about:blank")
                looker.take_for(1.5)
                self.assertEqual(looker.stream("commanded")[-1][1][2], 0.0)
                self.assertEqual(looker.hello["causes"][int(looker.stream("safety")[-1][1][1])], "dead_man")
                looker.close()
            if held:
                return
        self.fail("the force was released while the page drew slowly")

    def test_a_page_whose_picture_stands_still_is_released_though_the_mouse_moves(self):
        with View(TACTOR, WALL) as view:
            self.open(view.url)
            self.press()
            looker = view.page()
            self.browser.execute_script("window.requestAnimationFrame = () => 0;")
            begin = time.monotonic()
            while time.monotonic() - begin < 2:
                self.drag(1, 0, 1)
                self.drag(-1, 0, 1)
                looker.take_for(0.05)
            forces = [(t, abs(v[2])) for t, v in looker.stream("commanded")]
            self.assertEqual(forces[-1][1], 0.0)
            looker.close()

    def test_a_page_that_was_blocked_for_8_s_is_released_and_catches_up(self):
        with View(TACTOR, WALL) as view:
            self.open(view.url)
            self.press()
            looker = view.page()
            looker.take_for(0.1)
            begin = looker.stream("commanded")[-1][0]
            self.browser.execute_script("setTimeout(() => { const end = performance.now() + 8000; while (performance.now() < end); }, 0);")
            looker.take_for(1.5)
            forces = looker.stream("commanded")
            self.assertEqual(forces[-1][1][2], 0.0, "a blocked page is a released button")
            # 0.8 s of the worker, 0.2 s of the server, 0.1 s of the gate's ramp, and the way between them.
            self.assertLess(max(t for t, force in forces if force[2] > 0) - begin, 1.3)
            looker.take_for(7)
            self.until("window.tactor.counters.frames_drawn > 0")
            time.sleep(0.5)
            lag = looker.last("status")["now"]
            looker.take_for(0.3)
            lag = looker.stream("commanded")[-1][0] - self.js("window.tactor.latest('device.commanded').time")
            self.assertLess(lag, 1.0)
            # It still holds the mouse down, and gets no force until it has let go.
            self.assertEqual(self.latest("device.commanded")[2], 0.0)
            self.until_released("did not answer in time", "Let go, then press on the tool again.")
            self.let_go()
            self.until_released("You let go", "Press on the tool")
            looker.close()
            # What the page did not get while it was blocked is no line.
            self.browser.execute_script("const s = document.getElementById('window'); s.value = '30'; s.dispatchEvent(new Event('change'));")
            self.until("window.tactor.drawn('commanded', window.tactor.time - 1, window.tactor.time) > 0")
            begin, end = max(self.js("window.tactor.gaps('device.commanded')"), key=lambda gap: gap[1] - gap[0])
            self.assertGreater(end - begin, 2)
            for curve in ("commanded", "interpolated", "physics"):
                self.assertEqual(self.js(f"window.tactor.drawn('{curve}', {begin}, {end})"), 0, curve)

    def test_the_page_says_who_is_in_control_and_that_the_connection_is_lost(self):
        with View(TACTOR, WALL, "--no-reference") as view:
            first = view.page()
            self.open(view.url)
            self.until_released("Another page is in control", "Close that page")
            first.close()
            self.until_released("was closed", "Press “Take control”")
            self.browser.find_element(By.ID, "take-control").click()
            self.until_released("was closed", "Press on the tool and hold it.")
            view.process.kill()
            self.until_released("connection is lost", "Connect again")

    def test_the_page_says_that_the_watchdog_has_ended_the_run(self):
        graph = self.write("stalled.yaml", f"extends: {WALL}\nlive: {{stall_timeout: 0.5 s}}\nnodes:\n"
                           "  stall: {type: fault.stall, at: 8 s, lasts: 1.5 s, lane: thread, thread: stalls}\n"
                           "edges:\n  - dynamics.state -> stall.in\n  - stall.out -> coupling.state\n")
        with View(TACTOR, str(graph), "--no-reference", environment={"TACTOR_NODE_PATH": str(BUILD / "tests/nodes")}) as view:
            self.open(view.url)
            self.until_released("The watchdog ended the run", "Start the run again")

    # How many names of curves are seen as a whole.
    NAMES_INSIDE = """(() => {
      const chart = document.getElementById('force-chart').getBoundingClientRect();
      const inside = (name) => { const r = name.getBoundingClientRect(); return r.width > 0 && r.right <= chart.right && r.bottom <= chart.bottom; };
      return [...document.querySelectorAll('#force-chart .u-legend th')].filter((name) => inside(name) && name.scrollWidth <= name.clientWidth).length;
    })()"""

    def sees(self, selector):
        return self.js("[...document.querySelectorAll(arguments[0])].filter(e => e.offsetParent !== null).length", selector)

    def assert_colours(self):
        """Force and tool have each one colour: arrow, curve, bar and legend."""
        style = lambda selector: "#" + "".join(f"{int(c):02x}" for c in re.findall(r"\d+", self.js(  # noqa: E731
            f"getComputedStyle(document.querySelector('{selector}')).backgroundColor"))[:3])
        colours = self.js("window.tactor.colours")
        force = {colours["arrow"], colours["curve"], style("#force-fill"), style(".swatch.commanded")}
        tool = {colours["tool"], style(".swatch.handle")}
        self.assertEqual((len(force), len(tool)), (1, 1), f"{force} {tool}")
        self.assertFalse(force & tool)
        return force | tool

    def test_the_page_fits_a_laptop_and_a_phone(self):
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"features": []})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        with View(TACTOR, WALL, "--over", str(GRAPHS / "methods/side_by_side.yaml")) as view:
            for width, height in ((1280, 800), (390, 844)):
                with self.subTest(width=width):
                    self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 700})
                    self.open(view.url)
                    # As it is while it is used: with the line on what a hand feels.
                    self.until("window.tactor?.counters.frames_drawn > 1 && !document.getElementById('felt').hidden")
                    scene = self.js("(() => { const r = document.getElementById('scene').getBoundingClientRect(); return [r.width, r.height, r.top, r.bottom]; })()")
                    if width == 1280:
                        self.assertGreaterEqual(scene[0] * scene[1], width * height / 2, scene)
                        self.assertGreaterEqual(scene[2], 0)
                        self.assertLessEqual(scene[3], height)
                    self.assertLessEqual(self.js("document.documentElement.scrollWidth - innerWidth"), 0)
                    self.browser.execute_script("document.getElementById('force-chart').scrollIntoView();")
                    self.until(f"{self.NAMES_INSIDE} === 5")
            # Five parameters, and the others when somebody asks for them.
            names = self.js("window.tactor.hello.parameters.map(p => p.name)")
            self.assertEqual(self.sees("#knobs .knob"), 5)
            self.browser.execute_script("document.getElementById('all-knobs').click()")
            self.assertEqual(self.sees("#knobs .knob"), len(names))
            light = self.assert_colours()
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
            self.until(f"!{json.dumps(sorted(light))}.includes(window.tactor.colours.arrow)")
            self.assertFalse(light & self.assert_colours())
            self.assert_no_errors()

    def test_a_recording_is_replayed_scrubbed_saved_and_opened_offline(self):
        graph = self.write("duck.yaml", f"extends: {GRAPHS / 'wall/refit.yaml'}\nrecord: [device.commanded, device.state]\n")
        result = tactor("run", graph, "--duration", "3 s", "--out", self.folder / "run")
        self.assertEqual(result.returncode, 0, result.stderr)
        recording = self.folder / "run/recording.h5"
        with View(TACTOR, str(recording)) as view:
            self.open(view.url)
            self.until("window.tactor?.complete")
            self.assertEqual(self.js("window.tactor.mode"), "replay")
            self.scrub(1.5)
            play = self.browser.find_element(By.ID, "play")
            if play.text == "Play":
                play.click()
            self.until("window.tactor.time > 1.7")
            for old in self.made.glob("*.html"):
                old.unlink()
            self.browser.find_element(By.ID, "save").click()
            end = time.monotonic() + 20
            while not list(self.made.glob("*.html")):
                self.assertLess(time.monotonic(), end)
                time.sleep(0.1)
            self.assert_no_errors()
        saved = next(self.made.glob("*.html"))
        exported = self.folder / "exported.html"
        self.assertEqual(tactor("export", recording, "--html", exported).returncode, 0)
        for page in (saved, exported):
            with self.subTest(page.name):
                self.assertNotRegex(page.read_text()[:3000], r'(src|href)="?https?:')
                self.open(f"file://{page}")
                self.until("window.tactor?.complete")
                self.assertGreater(self.js("window.tactor.counters.samples_taken['device.commanded']"), 2900)
                self.scrub(2.0)
                self.assert_no_errors()

    def scrub(self, t):
        self.browser.execute_script("const s = document.getElementById('scrub'); s.value = arguments[0];"
                                    "s.dispatchEvent(new Event('input', {bubbles: true}));", t)
        self.until(f"Math.abs(window.tactor.time - {t}) < 0.6")


if __name__ == "__main__":
    unittest.main()
