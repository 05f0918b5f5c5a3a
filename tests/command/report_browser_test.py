"""Reports in a browser: the first screen shows the charts, nothing is cut off on a screen or a phone, curves hide and zoom, definitions show,
and each figure is saved as a file that other programs read."""
import base64
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import pandas

from browser import MISSING, needs_browser, open_browser
from harness import GRAPHS, PATIENCE, CommandTest, tactor

if not MISSING:
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import WebDriverWait

SCREEN, PHONE = (1280, 900), (390, 800)
# The elements that reach over the window's right edge, but for those in a frame that scrolls.
OUTSIDE = """return [...document.querySelectorAll('body *')].filter(e => !e.closest('.wide, pre, thead, .chart svg svg')
  && e.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map(e => e.outerHTML.slice(0, 200));"""
CUT = """return [...document.querySelectorAll('th, td')].filter(e => !e.closest('.wide, thead') && e.scrollWidth > e.clientWidth + 1)
  .map(e => e.outerHTML);"""


@needs_browser
class Pages(CommandTest):
    @classmethod
    def setUpClass(cls):
        cls.made = Path(tempfile.mkdtemp(prefix="tactor-pages-"))
        cls.addClassCleanup(shutil.rmtree, cls.made, ignore_errors=True)
        base = GRAPHS / "recorded/scene.yaml"
        graphs = []
        for i in range(12):
            graphs.append(cls.made / f"{i}_is_a_method_with_a_rather_long_name.yaml")
            graphs[-1].write_text(f"extends: {base}\n")
        study = cls.made / "study.yaml"
        study.write_text(f"graphs: [{base}]\nmethods: [{GRAPHS}/methods/hold.yaml, {GRAPHS}/methods/burg.yaml]\nseeds: 2\nduration: 0.6 s\njudge: whole\n")
        cls.pages = {}
        for name, arguments in (("compare", (*graphs, "--seeds", "2", "--duration", "0.6 s")), ("run", (base, "--duration", "0.6 s")),
                                ("study", (study,))):
            result = tactor(name, *arguments, "--out", cls.made / name, environment={"TACTOR_CACHE": str(cls.made / "cache")})
            if result.returncode != 0:
                raise AssertionError(result.stdout + result.stderr)
            cls.pages[name] = cls.made / name / "report.html"
        cls.downloads = cls.made / "downloads"
        cls.downloads.mkdir()
        cls.browser = open_browser(cls.made / "profile", cls.downloads)
        cls.addClassCleanup(cls.browser.quit)

    def open(self, name, size=SCREEN, dark=False):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size == PHONE})
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
        self.browser.get(self.pages[name].as_uri())
        self.assertEqual(self.browser.get_log("browser"), [])

    def script(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def chart(self, title):
        """The element of a chart, in view."""
        for element in self.browser.find_elements(By.CLASS_NAME, "chart"):
            if element.find_element(By.TAG_NAME, "b").get_attribute("textContent").startswith(title):
                self.script("const folded = arguments[0].closest('details'); if (folded) folded.open = true", element)
                self.script("arguments[0].scrollIntoView()", element)
                return element
        self.fail(f"no chart {title}")

    def ticks(self, chart):
        """The numbers below a chart."""
        texts = [t for t in chart.find_elements(By.TAG_NAME, "text") if t.get_attribute("text-anchor") == "middle"]
        return [float(t.text) for t in texts if t.text.replace(".", "").isdigit()]

    def test_nothing_is_cut_off_on_a_screen_and_on_a_phone(self):
        for name in self.pages:
            for size in (SCREEN, PHONE):
                with self.subTest(page=name, width=size[0]):
                    self.open(name, size)
                    self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), size[0])
                    self.assertEqual(self.script(OUTSIDE), [])
                    self.assertEqual(self.script(CUT), [])

    def test_twelve_methods_stand_beside_each_other_and_on_a_phone_below_each_other(self):
        tops = """return [...document.querySelector('table.even').querySelectorAll('tr:nth-child(2) td')].map(e => e.getBoundingClientRect().top);"""
        self.open("compare")
        self.assertEqual(len(self.script(tops)), 12)
        self.assertEqual(len(set(self.script(tops))), 1)
        self.open("compare", PHONE)
        self.assertEqual(len(set(self.script(tops))), 12)
        label = self.script("return getComputedStyle(document.querySelector('table.even tbody tr:nth-child(2) td'), '::before').content")
        self.assertIn("0_is_a_method_with_a_rather_long_name", label)

    def test_a_comparison_shows_error_and_cost_and_the_force_on_its_first_screen(self):
        self.open("compare", (1280, 800))
        for title in ("Error against run time", "The 150 ms"):
            bottom = "return arguments[0].querySelector('svg').getBoundingClientRect().bottom + scrollY"
            self.assertLess(self.script(bottom, self.chart(title)), 800)
        self.assertEqual(self.script("return [...document.querySelector('table').querySelectorAll('tbody th')].map(e => e.textContent.split(' ')[0])"),
                         ["RMS", "delay", "roughness", "vibration", "run", "verdict"])

    def test_a_run_shows_its_error_beside_its_force_on_its_first_screen(self):
        self.open("run", (1280, 800))
        places = [self.chart(title).rect for title in ("Error of the force", "Force on the device")]
        self.assertEqual(places[0]["y"], places[1]["y"])
        self.assertLess(places[0]["x"], places[1]["x"])
        self.assertLess(max(place["y"] + place["height"] for place in places), 800)

    def saved(self, chart, way):
        """The file that a button of a chart saves."""
        before = set(self.downloads.iterdir())
        next(button for button in chart.find_elements(By.CSS_SELECTOR, "button.file") if button.text == way).click()
        def done(_):
            new = [file for file in self.downloads.iterdir() if file not in before and file.suffix == "." + way.lower()]
            return new[0] if new and new[0].stat().st_size else None
        return WebDriverWait(self.browser, PATIENCE).until(done)

    def each_chart(self):
        """(page, chart, its name) of all charts, in view one after the other."""
        names = "return [...document.querySelectorAll('figure > script')].flatMap(e => JSON.parse(e.textContent).charts.map(c => c.name))"
        for page in self.pages:
            self.open(page)
            self.script("for (const folded of document.querySelectorAll('details')) folded.open = true")
            charts = self.browser.find_elements(By.CLASS_NAME, "chart")
            found = self.script(names)
            self.assertEqual(len(charts), len(found))
            for chart, name in zip(charts, found):
                if "/" in name and not name.startswith("3_"):
                    continue  # of the twelve runs of a comparison one will do
                self.script("arguments[0].scrollIntoView()", chart)
                with self.subTest(page=page, chart=name):
                    yield page, chart, name

    def test_each_chart_is_saved_as_svg_with_its_names(self):
        for _, chart, name in self.each_chart():
            file = self.saved(chart, "SVG")
            self.assertEqual(file.stem.split(" (")[0], re.sub(r"[^\w.-]+", "_", name))
            text = file.read_text()
            for button in chart.find_elements(By.CSS_SELECTOR, ".key button[aria-pressed]"):
                self.assertIn(f">{button.text.lstrip('○□△◇▽⬠●■▲◆▼⬟✚✱')}<", text)
            self.assertNotIn("var(--", text)
            png = subprocess.run(["rsvg-convert", file], capture_output=True, check=True).stdout
            self.assertTrue(png.startswith(b"\x89PNG"))

    def test_each_chart_is_saved_as_csv_with_the_values_that_the_command_exports(self):
        for page, chart, name in self.each_chart():
            ours = pandas.read_csv(self.saved(chart, "CSV"), keep_default_na=False, na_values=[""])
            exported = self.folder / "exported.csv"
            self.run_ok("export", self.pages[page], "--figure", name, "--to", exported)
            its = pandas.read_csv(exported, keep_default_na=False, na_values=[""])
            self.assertGreater(len(ours), 0)
            pandas.testing.assert_frame_equal(ours, its)

    def test_each_chart_is_printed_alone_as_a_pdf_of_its_size_with_its_fonts(self):
        self.addCleanup(self.browser.execute_cdp_cmd, "Page.removeScriptToEvaluateOnNewDocument", self.browser.execute_cdp_cmd(
            "Page.addScriptToEvaluateOnNewDocument", {"source": "window.print = () => { window.printed = (window.printed || 0) + 1; }"}))
        for _, chart, _ in self.each_chart():
            next(button for button in chart.find_elements(By.CSS_SELECTOR, "button.file") if button.text == "PDF").click()
            self.assertTrue(self.script("return window.printed"))
            width, height = self.script("const {width, height} = document.querySelector('.sheet > svg').viewBox.baseVal; return [width, height]")
            made = self.browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True, "printBackground": False})
            file = self.folder / "figure.pdf"
            file.write_bytes(base64.b64decode(made["data"]))
            info = subprocess.run(["pdfinfo", file], capture_output=True, text=True, check=True).stdout
            self.assertRegex(info, r"Pages: +1\n")
            size = re.search(r"Page size: +([\d.]+) x ([\d.]+) pts", info)
            for found, pixels in zip(size.groups(), (width, height)):
                self.assertAlmostEqual(float(found), 0.75 * pixels, delta=1)
            fonts = subprocess.run(["pdffonts", file], capture_output=True, text=True, check=True).stdout.splitlines()[2:]
            self.assertTrue(fonts)
            for font in fonts:
                self.assertEqual(font.split()[-5], "yes", font)
            # The page comes back.
            self.script("window.dispatchEvent(new Event('afterprint'))")
            self.assertEqual(self.browser.find_elements(By.CLASS_NAME, "sheet"), [])

    def test_what_a_dark_page_saves_is_for_a_light_one(self):
        self.open("run", dark=True)
        text = self.saved(self.chart("Force on the device"), "SVG").read_text()
        light = [sum(map(int, color)) for color in re.findall(r'<text[^>]* fill="rgb\((\d+), (\d+), (\d+)\)"', text)]
        self.assertTrue(light)
        self.assertLess(max(light), 300)

    def test_a_method_has_the_colour_and_the_mark_of_its_head_in_every_chart(self):
        self.open("compare")
        heads = self.script("""return [...document.querySelector('table').querySelectorAll('thead th')].map(
          e => [e.querySelector('i').style.getPropertyValue('--color'), ...e.textContent.split(/ (.*)/).slice(0, 2)]);""")
        self.assertEqual(len(set(map(tuple, heads))), 12)
        colors = {name: color for color, _, name in heads}
        keys = """return [...arguments[0].querySelectorAll('.key button i')].map(
          e => [e.style.getPropertyValue('--color'), e.textContent, e.parentNode.lastChild.textContent]);"""
        marks = [key for key in self.script(keys, self.chart("Error against run time")) if key[2] in colors]
        self.assertEqual(marks, heads)
        for title in ("The 150 ms", "Force on the device"):
            lines = {name: color for color, _, name in self.script(keys, self.chart(title)) if name in colors}
            self.assertEqual(lines, colors)

    def test_a_folded_chart_is_as_wide_as_the_page_when_it_is_opened(self):
        self.open("compare")
        whole = self.chart("Force on the device")
        wide = "return arguments[0].querySelector('svg').getBoundingClientRect().width"
        WebDriverWait(self.browser, PATIENCE).until(lambda _: self.script(wide, whole) > 1000)

    def test_a_name_hides_its_curve_and_shows_it_again(self):
        self.open("compare")
        chart = self.chart("Force on the device")
        button = next(b for b in chart.find_elements(By.CSS_SELECTOR, ".key button") if b.text.startswith("3_"))
        curves = len(chart.find_elements(By.CSS_SELECTOR, "path.line"))
        for pressed, left in (("false", curves - 1), ("true", curves)):
            button.click()
            self.assertEqual(button.get_attribute("aria-pressed"), pressed)
            self.assertEqual(len(chart.find_elements(By.CSS_SELECTOR, "path.line")), left)

    def test_a_drag_zooms_all_rows_of_a_run_and_two_clicks_show_the_whole(self):
        self.open("run")
        chart = self.chart("Device displacement")
        picture = chart.find_element(By.CSS_SELECTOR, ":scope > svg")
        whole = self.ticks(chart)
        self.assertEqual((whole[0], whole[-1]), (0, 0.6))
        ActionChains(self.browser).move_to_element(picture).click_and_hold().move_by_offset(150, 0).release().perform()
        rows = chart.find_elements(By.XPATH, "../*[@class='chart']")
        self.assertGreater(len(rows), 1)
        for row in rows:
            at = self.ticks(row)
            self.assertGreater(len(at), 2)
            self.assertTrue(0.28 < at[0] < at[-1] < 0.4, at)
        ActionChains(self.browser).double_click(picture).perform()
        self.assertEqual(self.ticks(chart), whole)
        picture.send_keys("+")
        self.assertNotEqual(self.ticks(chart), whole)
        picture.send_keys("0")
        self.assertEqual(self.ticks(chart), whole)

    def test_the_script_draws_the_curve_that_gnuplot_drew(self):
        def shape(points):
            """The points between 0 and 1 each way, from below."""
            (left, right), (top, bottom) = ((min(values), max(values)) for values in zip(*points))
            return [((x - left) / (right - left), (bottom - y) / (bottom - top)) for x, y in points]

        def numbers(path):
            return [tuple(map(float, pair)) for pair in re.findall(r"([\d.]+),([\d.]+)", path)]
        self.open("run")
        script = numbers(self.chart("Device displacement").find_element(By.CSS_SELECTOR, "path.line").get_attribute("d"))
        figure = next(part for part in self.pages["run"].read_text().split("<figure>") if '"title":"Device displacement"' in part)
        group = figure.split('id="gnuplot_plot_1b"')[1].split("</g>\n\t</g>")[0]
        gnuplot = numbers(re.search(r" d='([^']*)'", group)[1])
        self.assertEqual(len(script), len(gnuplot))
        self.assertGreater(len(script), 500)
        for (x, y), (its_x, its_y) in zip(shape(script), shape(gnuplot)):
            self.assertAlmostEqual(x, its_x, delta=0.001)
            self.assertAlmostEqual(y, its_y, delta=0.01)

    def test_a_definition_shows_where_the_keyboard_goes(self):
        self.open("compare")
        word = self.browser.find_element(By.CSS_SELECTOR, "table abbr")
        shown = "return getComputedStyle(arguments[0], '::after').content"
        self.assertEqual(self.script(shown, word), "none")
        # From the last button of the charts, which comes before the table.
        self.browser.find_elements(By.CSS_SELECTOR, ".pair button")[-1].send_keys(Keys.TAB)
        self.assertTrue(self.script("return document.activeElement === arguments[0]", word))
        self.assertIn(word.get_attribute("title"), self.script(shown, word))
        self.assertIn("is better", word.get_attribute("title"))

    def test_a_dark_system_gets_a_dark_page(self):
        brightness = """return ['background-color', 'color'].map(p => Math.max(...getComputedStyle(document.body)
          .getPropertyValue(p).match(/\\d+/g).map(Number)));"""
        self.open("run")
        page, ink = self.script(brightness)
        self.assertGreater(page, ink + 150)
        self.open("run", dark=True)
        page, ink = self.script(brightness)
        self.assertGreater(ink, page + 150)

    def test_without_a_script_the_pictures_stay(self):
        self.browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.setScriptExecutionDisabled", {"value": False})
        for size in (SCREEN, PHONE):
            self.open("run", size)
            self.assertEqual(self.browser.find_elements(By.CLASS_NAME, "chart"), [])
            pictures = self.browser.find_elements(By.CSS_SELECTOR, "figure > svg")
            self.assertGreater(len(pictures), 1)
            self.assertGreater(pictures[0].size["height"], 100)


if __name__ == "__main__":
    unittest.main()
