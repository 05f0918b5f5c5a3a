"""The metrics of bench/live.py: percentiles of merged histograms, what cyclictest says, and the path of the hand."""
import csv
import math
import pathlib
import random
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import live  # noqa: E402

CYCLICTEST = """# /dev/cpu_dma_latency set to 0us
# Histogram
000000 000000
000008 000002
000013 000007
001200 000001
# Total: 000000010
# Min Latencies: 00008
# Avg Latencies: 00018
# Max Latencies: 25000
# Histogram Overflows: 00002
# Histogram Overflow at cycle number:
# Thread 0: 01621 01714
"""


class Metrics(unittest.TestCase):
    def test_quantiles_of_merged_slices_are_those_of_all_samples_together(self):
        draw = random.Random(3)
        slices = [[draw.randrange(1, 300 * (k + 1)) for _ in range(1000)] for k in range(4)]
        histograms = [{us: s.count(us) for us in set(s)} for s in slices]
        together = sorted(us for s in slices for us in s)
        found = live.quantiles(live.merged(histograms), together[-1])
        for name, q in live.QUANTILES.items():
            self.assertEqual(found[name], together[math.ceil(q * len(together)) - 1], name)
        self.assertEqual(found["max"], together[-1])
        self.assertEqual(found["count"], 4000)

    def test_a_histogram_of_cyclictest_is_read_with_what_lies_beyond_it(self):
        counts, longest = live.parse_cyclictest(CYCLICTEST)
        self.assertEqual(counts, {8.5: 2, 13.5: 7, 1200.5: 1, 25000.0: 2})
        self.assertEqual(longest, 25000.0)

    def test_what_is_no_histogram_is_refused(self):
        with self.assertRaisesRegex(ValueError, "expected the histogram of cyclictest"):
            live.parse_cyclictest("# Max Latencies: 00012\n")

    def test_a_late_wake_up_skips_the_deadlines_that_it_runs_past(self):
        self.assertEqual(live.skipped({999.5: 5, 1000.5: 2, 3200.0: 1}), 2 + 3)

    def test_misses_are_laid_on_the_host_no_further_than_cyclictest_missed_around_them(self):
        def summary(missed):
            return {"duration_s": 1, "cpu_s": 0.1, "physics": {"rate_hz_median": 100},
                    "device": {"ticks": 1000, "missed": missed, "dropped": 0, "page_faults": 0, "allocations": 0,
                               "wakeup_us": {"p99": 20, "max": 30}, "body_us": {"max": 9}},
                    "end_to_end_us": {"max": 5},
                    "edges": {"interpolation.segment -> device.segment": {"drops": 0, "age_us": {"max": 9000}}}}
        names = ("device.wakeup", "device.body", "device.end_to_end", "interpolation.segment -> device.segment")
        slices = [(summary(m), {n: {10.0: 1000} for n in names}) for m in (4, 0, 9)]
        # Slices of cyclictest in front of each: 2, 0 and 6 deadlines run past.
        reference = [({8.0: 1000, 2500.0: 1}, 2500.0), ({8.0: 1000}, 8.0), ({8.0: 1000, 3100.0: 2}, 3100.0)]
        f = live.metrics(reference, slices)
        self.assertEqual(f["missed"], 13)
        self.assertEqual(f["missed_as_cyclictest"], 1 + 0 + 6)
        self.assertEqual(f["cyclictest_late"], 8)
        self.assertEqual(f["ratio_p99"], 10 / 8)
        self.assertEqual(f["force_age_goal_us"], 11500)
        self.assertEqual(f["ticks"], 3000)


class Path(unittest.TestCase):
    def test_the_path_goes_back_and_forth_without_a_leap(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "path.csv"
            live.write_path(file, 20)
            with open(file, newline="") as source:
                rows = [[float(cell) for cell in row] for row in list(csv.reader(source))[1:]]
        with open(live.PATH, newline="") as source:
            original = [[float(cell) for cell in row] for row in list(csv.reader(source))[1:]]
        steps = [max(abs(a - b) for a, b in zip(x[1:], y[1:])) for x, y in zip(original, original[1:])]
        self.assertGreaterEqual(rows[-1][0], 20)
        for x, y in zip(rows, rows[1:]):
            self.assertGreater(y[0], x[0])
            self.assertLessEqual(max(abs(a - b) for a, b in zip(x[1:], y[1:])), max(steps))


if __name__ == "__main__":
    unittest.main()
