"""A real browser for tests: Chromium without a window, driven by Selenium."""
import shutil
import socket
import unittest

try:
    from selenium import webdriver
except ImportError:
    webdriver = None

def knows_localhost():
    try:
        return bool(socket.getaddrinfo("localhost", None))
    except OSError:
        return False


MISSING = [name for name, there in (("chromium", shutil.which("chromium")), ("chromium-driver", shutil.which("chromedriver")),
                                    ("python3-selenium", webdriver),
                                    ("the name localhost in /etc/hosts, which ChromeDriver asks for", knows_localhost())) if not there]
FLAGS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--enable-unsafe-swiftshader", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--no-first-run")
needs_browser = unittest.skipIf(MISSING, f"nothing is looked at in a browser: missing are {', '.join(MISSING)}")


def open_browser(profile, downloads=None, flags=()):
    """A browser with a profile in that folder."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in (*FLAGS, *flags):
        options.add_argument(flag)
    options.add_argument(f"--user-data-dir={profile}")
    if downloads:
        options.add_experimental_option("prefs", {"download.default_directory": str(downloads), "download.prompt_for_download": False})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=webdriver.chrome.service.Service(shutil.which("chromedriver")))
