"""The site of the docs: it builds without a warning, no link in it is broken, and it works from its folder, without the network."""
import functools
import html.parser
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse

PATIENCE = 120  # s, for what takes a moment on an idle machine
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/command"))
from browser import MISSING, needs_browser, open_browser  # noqa: E402

if not MISSING:
    from selenium.webdriver.common.by import By

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
COMMANDS = ("doxygen", "sphinx-build")
SCREEN, PHONE = (1280, 900), (390, 800)
# What reaches over the right edge of the window, but for what is in a box that scrolls, or is drawn outside on purpose.
OUTSIDE = """return [...document.querySelectorAll('article *')].filter(e => !e.closest('.table-wrapper, pre, .highlight, svg, .headerlink, dt')
  && e.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map(e => e.outerHTML.slice(0, 160));"""


class Page(html.parser.HTMLParser):
    """The links, the anchors and the loaded files of a page."""

    def __init__(self, text):
        super().__init__()
        self.links, self.anchors, self.loaded = [], set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors |= {values[key] for key in ("id", "name") if values.get(key)}
        if tag in ("a", "area") and values.get("href"):
            self.links.append(values["href"])
        if tag == "link" and values.get("href") and values.get("rel") not in ("index", "search", "next", "prev", "genindex", "canonical"):
            self.loaded.append(values["href"])
        self.loaded += [values[key] for key in ("src", "data", "poster") if values.get(key) and not values[key].startswith("data:")]


@functools.cache
def built_site():
    """A folder that is removed at the end, the site in it, and what building it said."""
    made = pathlib.Path(tempfile.mkdtemp(prefix="tactor-site-"))
    unittest.addModuleCleanup(shutil.rmtree, made, ignore_errors=True)
    build = subprocess.run([ROOT / "scripts/docs", "--no-install", "--build", BUILD, "--out", made / "site", "--work", made / "work"],
                           capture_output=True, text=True, check=False)
    if build.returncode != 0:
        raise AssertionError(build.stdout + build.stderr)
    return made, made / "site", build


def setUpModule():
    missing = [command for command in COMMANDS if shutil.which(command) is None]
    if missing or not list(BUILD.glob("python/tactor/_tactor*.so")):
        print(f"the site is not built: missing are {', '.join(missing) or 'the Python package in ' + str(BUILD)}", file=sys.stderr)
        sys.exit(77)


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made, cls.out, cls.build = built_site()
        cls.pages = {file: Page(file.read_text()) for file in sorted(cls.out.rglob("*.html"))}

    def test_it_builds_without_a_warning(self):
        self.assertEqual(self.build.stderr, "")
        self.assertNotIn("warning", self.build.stdout.lower())

    def test_each_page_of_the_docs_is_in_it(self):
        pages = [file.relative_to(ROOT / "docs") for file in (ROOT / "docs").rglob("*.md")]
        self.assertGreater(len(pages), 50)
        for page in pages:
            with self.subTest(page=str(page)):
                self.assertIn(self.out / page.with_suffix(".html"), self.pages)

    def test_no_link_in_it_is_broken(self):
        broken = []
        for file, page in self.pages.items():
            for link in {*page.links, *page.loaded}:
                if re.match(r"[a-z]+:", link):
                    continue
                path, _, anchor = link.partition("#")
                path = urllib.parse.unquote(path.partition("?")[0])
                target = pathlib.Path(os.path.normpath(file.parent / path)) if path else file
                anchor = urllib.parse.unquote(anchor)
                if not target.is_file():
                    broken.append(f"{file.relative_to(self.out)}: {link}: no such file")
                elif anchor and target in self.pages and anchor not in self.pages[target].anchors:
                    broken.append(f"{file.relative_to(self.out)}: {link}: no such place")
        self.assertFalse(broken, "\n".join(sorted(broken)[:50]))

    def test_nothing_is_loaded_from_elsewhere(self):
        elsewhere = [f"{file.relative_to(self.out)}: {link}" for file, page in self.pages.items() for link in page.loaded
                     if re.match(r"([a-z]+:)?//|/", link)]
        styles = [*self.out.rglob("*.css")]
        self.assertGreater(len(styles), 3)
        for file in styles:
            for link in re.findall(r"(?:@import\s+(?:url\()?|url\()\s*['\"]?([^'\")\s]+)", file.read_text()):
                if not link.startswith(("data:", "#")) and (re.match(r"([a-z]+:)?//|/", link) or not (file.parent / link.partition("?")[0]).exists()):
                    elsewhere.append(f"{file.relative_to(self.out)}: {link}")
        self.assertFalse(elsewhere)

    def test_the_index_of_the_search_holds_words_of_the_pages(self):
        index = (self.out / "searchindex.js").read_text()
        for word in ("refit", "howto/view", "results/results"):
            self.assertIn(word, index)


@needs_browser
class InABrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        made, cls.out, _ = built_site()
        cls.browser = open_browser(made / "profile")
        cls.addClassCleanup(cls.browser.quit)

    def resize(self, size):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size == PHONE})

    def open(self, page, dark=False):
        self.resize(SCREEN)
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
        self.browser.get((self.out / page).as_uri())
        self.assertEqual(self.complaints(), [])

    def complaints(self):
        return [entry for entry in self.browser.get_log("browser") if entry["level"] != "INFO"]

    def js(self, expression):
        return self.browser.execute_script(f"return {expression};")

    def until(self, expression, seconds=PATIENCE):
        end = time.monotonic() + seconds
        while not self.js(expression):
            self.assertLess(time.monotonic(), end, f"{expression}: {self.js('document.body.innerText.slice(0, 400)')}")
            time.sleep(0.05)

    def brightness(self):
        return sum(map(int, re.findall(r"\d+", self.js("getComputedStyle(document.body).backgroundColor"))[:3])) / 3

    def test_the_doors_of_the_home_page_open(self):
        self.open("index.html")
        doors = [a.get_attribute("href") for a in self.browser.find_elements(By.CSS_SELECTOR, "#where-to-go li a")]
        self.assertGreaterEqual(len(doors), 7)
        self.assertTrue(self.js("document.querySelector('article img').naturalWidth > 0"))
        self.browser.find_element(By.CSS_SELECTOR, "#where-to-go li a").click()
        self.until("location.pathname.endsWith('/start/index.html') && document.querySelector('h1')")

    def test_a_word_is_found_and_its_page_opens(self):
        self.open("index.html")
        field = self.browser.find_element(By.CSS_SELECTOR, ".sidebar-search")
        field.send_keys("passivity")
        field.submit()
        # The page adds what it finds one by one.
        wanted = "ul.search li a[href*='explanation/passivity.html']"
        self.until(f'document.querySelector("{wanted}")')
        self.browser.find_element(By.CSS_SELECTOR, wanted).click()
        self.until("location.pathname.endsWith('/explanation/passivity.html') && document.querySelector('article .highlighted')")
        self.assertEqual(self.complaints(), [])

    def test_a_page_of_nodes_shows_their_parameters(self):
        self.open("reference/nodes.html")
        self.assertIn("prediction.refit", self.js("document.querySelector('article').innerText"))
        pages = [file for file in (self.out / "reference").rglob("*.html") if "<code" in file.read_text() and "window_time" in file.read_text()]
        self.assertTrue(pages)
        for page in pages:
            self.open(page.relative_to(self.out))
            self.assertIn("window_time", self.js("document.querySelector('article').innerText"))

    def test_it_is_dark_where_the_desktop_is_and_by_its_button(self):
        self.open("index.html", dark=True)
        self.assertLess(self.brightness(), 60)
        self.open("index.html")
        self.assertGreater(self.brightness(), 200)
        self.browser.execute_script("document.querySelector('.theme-toggle').click()")
        self.assertLess(self.brightness(), 60)
        self.browser.execute_script("localStorage.clear()")

    def test_no_page_is_wider_than_its_window(self):
        pages = ["index.html", "gallery.html", "reference/nodes.html", "reference/python_api.html", "howto/view.html", "explanation/architecture.html",
                 *(f"results/{file.stem}.html" for file in sorted((ROOT / "docs/results").glob("*.md"))), "trust/limits.html"]
        self.assertGreater(len(pages), 20)
        for page in pages:
            self.open(page)
            for size in (SCREEN, PHONE):
                with self.subTest(page=page, size=size):
                    self.resize(size)
                    self.assertEqual(self.js("innerWidth"), size[0])
                    self.assertLessEqual(self.js("document.documentElement.scrollWidth"), size[0])
                    self.assertEqual(self.browser.execute_script(OUTSIDE), [])

    def test_the_headers_have_pages_with_a_search(self):
        self.open("reference/cpp_api.html")
        self.browser.find_element(By.CSS_SELECTOR, "article a[href='../cpp/index.html']").click()
        self.until("document.title.includes('C++ API')")
        self.assertTrue((self.out / "cpp/classtactor_1_1Session.html").exists())
        self.assertEqual(self.complaints(), [])


if __name__ == "__main__":
    unittest.main()
