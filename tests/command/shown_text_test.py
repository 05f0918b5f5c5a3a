"""Titles, names and messages with escape sequences reach no terminal: every verb shows them as numbers."""
import json
import os
import re
import subprocess
import unittest

from harness import GRAPHS, TACTOR, CommandTest, Terminal, needs_live

# As YAML writes them: an escape sequence that sets the title of a window, C1, DEL, a carriage return, marks that turn text round.
HOSTILE = r"\e]0;owned\a\e[2J\u009b31m\x7f\r\u202efdp\u2066x\u200b"
RAW = "\x1b]0;owned\x07\x1b[2J\u009b31m\x7f\r\u202efdp\u2066x\u200b"
SHOWN = r"\u001b]0;owned\u0007\u001b[2J\u009b31m\u007f\u000d\u202efdp\u2066x\u200b"
CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f\x80-\x9f\u200b-\u200f\u202a-\u202e\u2066-\u2069]")
# Our own, on a terminal: rows that are drawn over others, and colours.
OURS = re.compile("\x1b\\[(K|J|\\d+A|\\d*m)|\r")


class ShownText(CommandTest):
    def graph(self, name="hostile.yaml", **parts):
        lines = [f"extends: {GRAPHS}/wall/fixed.yaml", f'title: "a {HOSTILE} graph"', "duration: 50 ms"]
        return self.write(name, "\n".join(lines + [f"{key}: {value}" for key, value in parts.items()]) + "\n")

    def said(self, *arguments, codes=(0,)):
        """What a command writes to both outputs, which are no terminal."""
        done = subprocess.run([TACTOR, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=self.folder,
                              env=dict(os.environ, **self.environment), timeout=300)
        text = done.stdout.decode()
        self.assertIn(done.returncode, codes, text)
        self.assertIsNone(CONTROLS.search(text), repr(text))
        return text

    def test_titles(self):
        graph = self.graph()
        members = 0
        for arguments in (("check", graph), ("check", graph, "--explain"), ("run", graph, "--out", self.folder / "out"), ("graph", graph),
                          ("graph", graph, "--format", "dot"), ("compare", graph, graph, "--seeds", "1", "--out", self.folder / "compared")):
            with self.subTest(arguments[0]):
                members += SHOWN in self.said(*arguments)
        self.assertGreaterEqual(members, 1)

    def test_names_in_errors(self):
        for key, value in (("nodes", f'{{"a{HOSTILE}": {{type: none}}}}'), ("nodes", f'{{a: {{type: "{HOSTILE}"}}}}'),
                           ("edges", f'["{HOSTILE} -> b.c"]'), ("clock", f'"{HOSTILE}"'), (f'"{HOSTILE}"', "1"),
                           ("scene", f'{{bodies: {{"{HOSTILE}": {{mesh: none.off}}}}}}'), ("scene", f'{{bodies: {{a: {{mesh: "{HOSTILE}.off"}}}}}}')):
            with self.subTest(key, value=value):
                # Some messages have put blanks for the commonest controls already.
                text = self.said("check", self.graph(**{key: value}), codes=(2,))
                self.assertIn(r"\u009b", text)

    def test_names_of_files_and_words_of_the_command_line(self):
        told = 0
        for arguments in (("check", RAW), ("run", f"{RAW}.yaml"), (RAW,), ("check", f"--{RAW}"), ("mesh", "check", f"{RAW}.off"),
                          ("export", f"{RAW}.h5"), ("check", GRAPHS / "wall/fixed.yaml", "--set", f"{RAW}=1"),
                          ("check", GRAPHS / "wall/fixed.yaml", "--set", f"seed={RAW}"), ("nodes", RAW), ("emulate", RAW)):
            with self.subTest(arguments[0]):
                told += r"\u009b" in self.said(*arguments, codes=(1, 2))
        self.assertGreater(told, 5)

    def test_words_in_meshes(self):
        for name, text in (("a.off", f"OFF\n{RAW} 4 0\n"), ("a.obj", f"v {RAW}\n"), ("a.stl", f"solid a\n{RAW}\n"), ("a.ply", f"ply\n{RAW}\n")):
            with self.subTest(name):
                path = self.write(name, text)
                self.said("mesh", "check", path, codes=(2,))

    def test_bytes_that_are_no_text(self):
        for name in (b"\xff\xfe.yaml", b"\x9b31m.yaml", b"\xc0\x9b.yaml"):
            done = subprocess.run([TACTOR, "check", name], capture_output=True, cwd=self.folder)
            self.assertEqual(done.returncode, 2)
            self.assertIn(rb"\x", done.stderr)
            done.stderr.decode()

    def test_json_stays_the_same_json(self):
        # A name comes back as it was given, though its bytes are others.
        corner = "OFF\n4 4 6\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
        path = self.write("a\u202e\u009b.off", corner)
        done = subprocess.run([TACTOR, "mesh", "check", path, "--json"], capture_output=True, cwd=self.folder,
                              env=dict(os.environ, **self.environment))
        self.assertIsNone(CONTROLS.search(done.stdout.decode()))
        self.assertEqual(json.loads(done.stdout)["file"], str(path))

    @needs_live
    def test_a_live_run_on_a_terminal_draws_its_own_sequences_alone(self):
        graph = self.graph(clock="real")
        terminal = Terminal("run", graph, "--out", self.folder / "out", "--duration", "1 s", environment=self.environment)
        terminal.finish()
        rest = OURS.sub("", terminal.text)
        self.assertIsNone(CONTROLS.search(rest), repr(rest))
        self.assertNotEqual(rest, terminal.text)


if __name__ == "__main__":
    unittest.main()
