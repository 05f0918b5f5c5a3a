"""What the terminal shows at the end of a run: a few lines that fit it, and every metric on request."""
import fcntl
import json
import os
import pty
import struct
import subprocess
import termios
import unittest

from harness import GRAPHS, TACTOR, CommandTest, graph_file, needs_meshes


class Headline(CommandTest):
    def run_lines(self, *arguments):
        return self.run_ok("run", self.judged_small_graph(), "--out", self.folder / "out", "--overwrite",
                           *arguments).stdout.strip("\n").splitlines()

    def test_a_run_prints_verdict_error_delay_run_time_and_what_was_left_out(self):
        lines = self.run_lines()
        self.assertLessEqual(len(lines), 10, lines)
        names = [line[:12].strip() for line in lines]
        for name in ("verdict", "run time", "left out", "report"):
            self.assertIn(name, names)
        self.assertRegex("\n".join(lines), r"(?m)^  verdict   done, 0\.50* s")
        self.assertIn(str(self.folder / "out/report.html"), "\n".join(lines))

    @needs_meshes
    def test_error_and_delay_are_those_of_the_summary(self):
        text = self.run_ok("run", GRAPHS / "duck/off.yaml", "--duration", "1.5 s", "--out", self.folder / "out").stdout
        force = json.loads((self.folder / "out/summary.json").read_text())["delivered"]["force"]
        self.assertRegex(text, rf"(?m)^  error     force {force['rms_error_N']:.3g}")
        self.assertRegex(text, r"(?m)^  delay     \d")
        self.assertRegex(text, r"(?m)^  left out  .*torque")
        self.assertLessEqual(len(text.strip().splitlines()), 10, text)

    def test_every_figure_is_printed_on_request(self):
        metrics = json.loads(self.summary())

        def names(tree, path=""):
            for key, value in tree.items():
                yield from names(value, f"{path}{key}.") if isinstance(value, dict) else [path + key]
        text = "\n".join(self.run_lines("--all"))
        shown = {line.split()[0] for line in text.splitlines() if line.startswith("  ") and line.split()}
        some = [name for name in names({k: v for k, v in metrics.items() if k in ("device", "delivered", "drops", "refits")})]
        self.assertGreater(len(some), 5)
        self.assertLessEqual(set(some), shown)

    def summary(self):
        self.run_lines()
        return (self.folder / "out/summary.json").read_text()


class Width(CommandTest):
    """No line is wider than the terminal, but for a path that must stay whole."""

    def assert_fits(self, text, columns):
        for line in text.replace("\r", "").splitlines():
            if str(self.folder) not in line:
                self.assertLessEqual(len(line), columns, line)

    def commands(self):
        study = self.write("study.yaml", f"graphs: [{self.judged_small_graph()}]\nvary: {{device.force_max: [4 N, 6 N], "
                                         "device.encoder_step: [1 um, 10 um]}\nseeds: 2\nduration: 0.2 s\n")
        graph = GRAPHS / "recorded/scene.yaml"
        compared = ["compare", graph, graph, graph, graph, graph, "--seeds", "2", "--duration", "0.2"]
        yield ["check", "--explain", graph]
        yield ["check", "--explain", graph, "--set", "clock=real"]
        yield ["explain", graph, "--duration", "0.2 s", "--repeats", "1"]
        yield ["run", graph, "--all", "--duration", "0.5 s", "--overwrite", "--out", self.folder / "run"]
        yield ["study", study, "--overwrite", "--out", self.folder / "study"]
        yield [*compared, "--overwrite", "--out", self.folder / "cmp"]

    def test_tables_fit_80_columns_where_nobody_says_otherwise(self):
        self.environment["COLUMNS"] = ""
        for command in self.commands():
            with self.subTest(command=command[0]):
                self.assert_fits(self.run_ok(*command).stdout, 80)

    @needs_meshes
    def test_what_was_left_out_fits_too(self):
        self.environment["COLUMNS"] = ""
        for graph in ("duck_refit", "peg_free_off", "bunny_local", "bunny_live", "duck_closed_loop"):
            with self.subTest(graph=graph):
                self.assert_fits(self.run_ok("check", "--explain", graph_file(graph)).stdout, 80)

    def on_terminal(self, columns, *arguments):
        """What the command writes to a terminal of so many columns."""
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
        process = subprocess.Popen([TACTOR, *map(str, arguments)], stdout=slave, stderr=subprocess.DEVNULL,
                                   env=dict(os.environ, **self.environment))
        os.close(slave)
        data = b""
        while True:
            try:
                read = os.read(master, 65536)
            except OSError:  # the other end has been closed
                break
            if not read:
                break
            data += read
        os.close(master)
        self.assertEqual(process.wait(), 0)
        return data.decode()

    def test_a_wider_terminal_is_used(self):
        lines = {}
        for columns in (60, 80, 120, 200):
            text = self.on_terminal(columns, "explain", GRAPHS / "recorded/scene.yaml", "--duration", "0.2 s", "--repeats", "1")
            self.assert_fits(text, columns)
            lines[columns] = len(text.splitlines())
        self.assertGreater(lines[60], lines[200])
        self.assertGreater(max(len(line) for line in text.splitlines()), 100)


if __name__ == "__main__":
    unittest.main()
