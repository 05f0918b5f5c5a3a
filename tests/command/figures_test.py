"""Figures of reports for a paper: written by the command, and read by other programs."""
import re
import subprocess
import unittest

import pandas

from harness import GRAPHS, CommandTest, tactor

WIDTHS_MM = {"1": 84, "2": 174}


class Figures(CommandTest):
    def setUp(self):
        super().setUp()
        self.run_ok("run", GRAPHS / "wall/off.yaml", "--duration", "1.5 s", "--out", self.folder / "run")
        self.results = self.folder / "run"

    def exported(self, name, suffix, *more):
        file = self.folder / f"figure.{suffix}"
        self.run_ok("export", self.results, "--figure", name, "--to", file, *more)
        return file

    def test_every_figure_is_a_pdf_of_the_asked_width_with_its_fonts(self):
        names = self.run_ok("export", self.results, "--figure", "?").stdout.split()
        self.assertEqual(names[:3], ["error", "judged_force", "zoom"])
        for columns, width_mm in WIDTHS_MM.items():
            for name in names:
                with self.subTest(figure=name, columns=columns):
                    file = self.exported(name, "pdf", "--columns", columns)
                    info = subprocess.run(["pdfinfo", file], capture_output=True, text=True, check=True).stdout
                    self.assertRegex(info, r"Pages: +1\n")
                    self.assertAlmostEqual(float(re.search(r"Page size: +([\d.]+)", info)[1]), width_mm / 25.4 * 72, delta=1)
                    fonts = subprocess.run(["pdffonts", file], capture_output=True, text=True, check=True).stdout.splitlines()[2:]
                    self.assertTrue(fonts)
                    for font in fonts:
                        self.assertEqual(font.split()[-5], "yes", font)

    def test_svg_and_png_are_pictures_that_others_open(self):
        svg = self.exported("error", "svg")
        png = subprocess.run(["rsvg-convert", svg], capture_output=True, check=True).stdout
        self.assertTrue(png.startswith(b"\x89PNG"))
        self.assertTrue(self.exported("error", "png").read_bytes().startswith(b"\x89PNG"))

    def test_csv_holds_the_reference_and_the_error_between_the_two(self):
        zoom = pandas.read_csv(self.exported("zoom", "csv"))
        self.assertEqual(set(zoom["curve"]), {"reference", "commanded", "physics results, on arrival"})
        self.assertEqual(list(zoom.columns), ["curve", "time s", "N"])
        force = pandas.read_csv(self.exported("force", "csv"))
        error = pandas.read_csv(self.exported("error", "csv"))
        norms = force.pivot_table(index="time s", columns="curve", values="N").dropna()
        both = error[error["curve"] == "error"].set_index("time s")["N"].reindex(norms.index).dropna()
        self.assertGreater(len(both), 200)
        # Norms differ by no more than the vectors do.
        self.assertTrue(((norms["commanded"] - norms["reference"]).abs().loc[both.index] <= both + 1e-5).all())
        noticed = error[error["curve"] == "what a hand notices"]["N"]
        self.assertGreater(noticed.min(), 0)

    def test_several_figures_stand_under_each_other(self):
        alone = self.exported("force", "pdf").read_bytes()
        pages = [subprocess.run(["pdfinfo", self.exported(names, "pdf")], capture_output=True, text=True, check=True).stdout
                 for names in ("force", "force,displacement", "force, displacement,contacts")]
        heights = [float(re.search(r"Page size: +[\d.]+ x ([\d.]+)", page)[1]) for page in pages]
        self.assertLess(heights[0], heights[1])
        self.assertLess(heights[1], heights[2])
        self.assertTrue(alone)
        table = pandas.read_csv(self.exported("force,displacement", "csv"))
        self.assertEqual(set(table["chart"]), {"force", "displacement"})

    def test_the_page_alone_is_enough(self):
        page = self.folder / "sent.html"
        page.write_bytes((self.results / "report.html").read_bytes())
        self.run_ok("export", page, "--figure", "force", "--to", self.folder / "sent.csv")
        self.assertEqual((self.folder / "sent.csv").read_text(), self.exported("force", "csv").read_text())

    def test_bad_requests_are_refused_with_what_there_is(self):
        other = self.write("other.html", "<html></html>")
        for arguments, said in (
                ((self.results, "--figure", "forces", "--to", "f.pdf"), "found 'forces'\n  error\n  judged_force\n"),
                ((self.results, "--figure", "force", "--to", "f.gif"), "ends in .svg, .pdf, .png or .csv"),
                ((self.results, "--figure", "force"), "expected --to FILE"),
                ((self.results, "--to", "f.pdf"), "--figure"),
                ((self.results, "--figure", "force", "--to", "f.pdf", "--columns", "3"), "--columns"),
                ((self.results, "device.state", "--figure", "force"), "--figure"),
                ((self.folder / "nowhere", "--figure", "force", "--to", "f.pdf"), "nowhere"),
                ((self.folder, "--figure", "force", "--to", "f.pdf"), "report.html"),
                ((other, "--figure", "force", "--to", "f.pdf"), "expected a report of Tactor with figures, found none")):
            with self.subTest(arguments=arguments):
                result = tactor("export", *arguments, cwd=self.folder)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(said, result.stderr)
                self.assertFalse((self.folder / "f.pdf").exists())


if __name__ == "__main__":
    unittest.main()
