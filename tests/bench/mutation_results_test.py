"""Which faults scripts/mutation_results puts into sources, and that none stays there."""
import importlib.machinery
import importlib.util
import itertools
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
spec = importlib.util.spec_from_loader("mutation_results", importlib.machinery.SourceFileLoader("mutation_results", str(ROOT / "scripts/mutation_results")))
mutation_results = importlib.util.module_from_spec(spec)
spec.loader.exec_module(mutation_results)

SOURCE = '''// a + b
#include "a + b.hpp"
double f(double a, double b) {
  const std::scoped_lock lock(mutex);
  const char* text = "a + b \\" - c";  /* 1e3 */
  if (a < 1e-3) return -a;
  out.send(a + b);
  return std::max(a, 1000 * b);
}
'''


class Tree(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.file = self.root / "nodes/kind/f.cpp"
        self.file.parent.mkdir(parents=True)
        self.file.write_text(SOURCE)
        self.enterContext(mock.patch.object(mutation_results, "ROOT", self.root))

    def faults(self, kind):
        """The lines that each fault of a kind leaves."""
        for file, begin, end, instead in mutation_results.places()[kind]:
            text = file.read_text()
            changed = text[:begin] + instead + text[end:]
            yield [(a, b) for a, b in itertools.zip_longest(text.splitlines(), changed.splitlines()) if a != b][0][1].strip()


class Places(Tree):
    def test_each_kind_changes_code_and_neither_comments_texts_nor_directives(self):
        self.assertEqual(sorted(self.faults("sign")), ["if (a < 1e-3) return a;", "out.send(a - b);"])
        self.assertEqual(sorted(self.faults("unit")), ["if (a < 1) return -a;", "return std::max(a, 1 * b);"])
        self.assertEqual(sorted(self.faults("bound")), ["if (a <= 1e-3) return -a;", "return std::min(a, 1000 * b);"])
        self.assertEqual(list(self.faults("lock")), [""])
        self.assertEqual(list(self.faults("message")), [""])

    def test_a_seed_draws_the_same_places_and_as_many_of_each_kind_as_is_asked(self):
        count = sum(mutation_results.COUNTS.values())
        self.assertEqual(count, 24)
        first, again, other = ([*itertools.islice(mutation_results.drawn(seed), count)] for seed in (1, 1, 2))
        self.assertEqual(first, again)
        self.assertNotEqual(first, other)
        for kind, wanted in mutation_results.COUNTS.items():
            self.assertEqual(sum(one[0] == kind for one in first), wanted)


class Tried(Tree):
    def place(self, kind):
        return kind, *mutation_results.places()[kind][0]

    def test_the_source_has_the_fault_while_tests_run_and_not_afterwards(self):
        seen = []
        with mock.patch.object(mutation_results, "caught_by", lambda file: seen.append(file.read_text()) or ("the folder's", "a_test")):
            found = mutation_results.tried(*self.place("lock"))
        self.assertNotIn("scoped_lock", seen[0])
        self.assertEqual(self.file.read_text(), SOURCE)
        self.assertEqual(found, {"kind": "lock", "file": "nodes/kind/f.cpp", "line": 4, "before": "const std::scoped_lock lock(mutex);", "after": "",
                                 "by": "the folder's", "test": "a_test"})

    def test_the_source_comes_back_whatever_happens(self):
        with mock.patch.object(mutation_results, "caught_by", side_effect=KeyboardInterrupt), self.assertRaises(KeyboardInterrupt):
            mutation_results.tried(*self.place("sign"))
        self.assertEqual(self.file.read_text(), SOURCE)

    def test_what_does_not_compile_is_no_fault(self):
        with mock.patch.object(mutation_results, "caught_by", return_value=None):
            self.assertIsNone(mutation_results.tried(*self.place("unit")))


if __name__ == "__main__":
    unittest.main()
