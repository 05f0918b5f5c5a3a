"""Debian's Firefox on a screen that nobody sees, driven by its own protocol: Debian 12 ships no geckodriver. Without a screen (--headless)
this Firefox has no WebGL where there is no graphics processor; on Xvfb it draws by Mesa's software.

The protocol is Marionette: over TCP, each message is its length in bytes, a colon, and the JSON array [0, id, command, parameters] or, as
its answer, [1, id, error, result]."""
import json
import os
import pathlib
import shutil
import socket
import subprocess
import time
import unittest

PROGRAM = shutil.which("firefox-esr")
MISSING = [name for name, there in (("firefox-esr", PROGRAM), ("xvfb", shutil.which("Xvfb"))) if not there]
needs_firefox = unittest.skipIf(MISSING, f"nothing is looked at in Firefox: missing are {', '.join(MISSING)}")
# No first page, no updates, and WebGL also without a graphics processor.
PREFERENCES = {"marionette.port": 0, "browser.shell.checkDefaultBrowser": False, "datareporting.policy.dataSubmissionEnabled": False,
               "toolkit.telemetry.reportingpolicy.firstRun": False, "app.update.enabled": False, "browser.startup.page": 0, "browser.aboutwelcome.enabled": False,
               "webgl.force-enabled": True, "network.proxy.type": 0}


class Screen:
    """An X server without a screen."""

    def __init__(self, width, height):
        reading, writing = os.pipe()
        self.process = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp"],
                                        pass_fds=[writing], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(writing)
        with open(reading) as numbers:
            number = numbers.readline().strip()
        if not number:
            raise AssertionError("Xvfb did not start")
        self.display = f":{number}"

    def quit(self):
        self.process.terminate()
        self.process.wait()


class Firefox:
    """A browser with a profile in that folder, which is made."""

    def __init__(self, profile, width, height):
        profile = pathlib.Path(profile)
        profile.mkdir()
        (profile / "user.js").write_text("".join(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in PREFERENCES.items()))
        self.screen = Screen(width, height)
        self.process = subprocess.Popen([PROGRAM, "--marionette", "--no-remote", "--profile", profile, f"--width={width}", f"--height={height}"],
                                        env=dict(os.environ, DISPLAY=self.screen.display), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port = profile / "MarionetteActivePort"
        end = time.monotonic() + 60
        while not (port.exists() and port.read_text()):
            if self.process.poll() is not None or time.monotonic() > end:
                self.process.kill()
                self.screen.quit()
                raise AssertionError("Firefox did not start")
            time.sleep(0.05)
        self.connection = socket.create_connection(("127.0.0.1", int(port.read_text())), timeout=60)
        self.data = b""
        self.last = 0
        self._receive()  # who it is
        self.command("WebDriver:NewSession")

    def _receive(self):
        while b":" not in self.data:
            self._read()
        size, _, self.data = self.data.partition(b":")
        while len(self.data) < int(size):
            self._read()
        message, self.data = self.data[:int(size)], self.data[int(size):]
        return json.loads(message)

    def _read(self):
        more = self.connection.recv(65536)
        if not more:
            raise ConnectionError("Firefox is gone")
        self.data += more

    def command(self, name, **parameters):
        """Its result; an AssertionError where Firefox refuses."""
        self.last += 1
        text = json.dumps([0, self.last, name, parameters]).encode()
        self.connection.sendall(b"%d:%s" % (len(text), text))
        _, _, error, result = self._receive()
        if error:
            raise AssertionError(f"{name}: {error['error']}: {error['message']}")
        return result.get("value") if isinstance(result, dict) else result

    def get(self, url):
        self.command("WebDriver:Navigate", url=url)

    def execute_script(self, script, *arguments):
        return self.command("WebDriver:ExecuteScript", script=script, args=list(arguments))

    def mouse(self, *actions):
        """Each: `down`, `up`, or (x, y) in px of the page."""
        told = [{"type": "pointerMove", "x": a[0], "y": a[1], "duration": 0} if isinstance(a, tuple) else {"type": f"pointer{a.title()}", "button": 0}
                for a in actions]
        self.command("WebDriver:PerformActions", actions=[{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": told}])

    def quit(self):
        try:
            self.command("Marionette:Quit", flags=["eForceQuit"])
            self.connection.close()
            self.process.wait(20)
        except (OSError, AssertionError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        self.screen.quit()
