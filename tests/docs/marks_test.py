"""The fences and marks of all pages, and the reader of them."""
import json
import pathlib
import re
import shlex
import subprocess
import sys
import textwrap
import unittest

import blocks
from page_runner import GRAPH_VERBS, commands_of


def read(text):
    return blocks.read(blocks.ROOT / "docs/page.md", textwrap.dedent(text))


class Pages(unittest.TestCase):
    maxDiff = None

    def test_every_block_has_a_language_and_marks_that_are_known(self):
        self.assertEqual([line for page in blocks.pages() for line in blocks.read(page)[1]], [])

    def test_commands_say_what_a_reader_has(self):
        """`tactor` from the path, and shipped scenes by their names."""
        wrong = []
        for page in blocks.pages():
            for block in blocks.read(page)[0]:
                if block.language == "sh":
                    wrong += [f"{block}: {command}: {what}" for _, command in commands_of(block.text) for what in self.of_a_clone(command)]
        self.assertEqual(wrong, [])

    @staticmethod
    def of_a_clone(command):
        if re.search(r"build/release/bin/tactor\b(?!-)", command) and not command.startswith("export"):
            yield "say `tactor`"
        verbs = "|".join((*GRAPH_VERBS, "study"))
        for part in re.findall(rf"\btactor (?:{verbs}) ([^|;&\n]*)", command):
            for word in shlex.split(part, comments=True):
                if re.match(r"graphs/.*\.yaml$", word):
                    yield f"say {word.removeprefix('graphs/').removeprefix('studies/').removesuffix('.yaml')} in the place of {word}"

    def test_reasons_name_files_that_exist(self):
        for page in blocks.pages():
            for block in blocks.read(page)[0]:
                for kind in ("not run", "checked"):
                    for file in re.findall(r"\b(?:scripts|tests|bench)/[\w./-]*\w", block.mark(kind) or ""):
                        self.assertTrue((blocks.ROOT / file).exists(), f"{block}: {file}")

    def test_every_block_is_counted_once(self):
        told = json.loads(subprocess.run([sys.executable, blocks.__file__, "--counts"], capture_output=True, text=True, check=True).stdout)
        number = sum(len(blocks.read(page)[0]) for page in blocks.pages())
        self.assertEqual(told["blocks"], number)
        self.assertEqual(sum(told["fates"].values()), number)
        self.assertEqual(sum(sum(fates.values()) for fates in told["languages"].values()), number)
        self.assertEqual(sum(told["not_run"].values()), told["fates"].get("not run", 0))


class Reader(unittest.TestCase):
    def test_a_fence_is_read_with_its_marks(self):
        found, wrong = read("""\
            Text.
            <!-- block: file a.yaml -->
            <!-- block: then true -->
            ```yaml
            a: {b: 1}
              c
            ```
            """)
        self.assertEqual(wrong, [])
        self.assertEqual((found[0].line, found[0].language, found[0].text), (5, "yaml", "a: {b: 1}\n  c\n"))
        self.assertEqual(found[0].marks, [("file", "a.yaml"), ("then", "true")])
        self.assertEqual(found[0].fate(), "checked")

    def test_a_fence_in_a_list_loses_the_indentation_of_the_list(self):
        found, wrong = read("1. One:\n\n   ```sh\n   true\n     false\n   ```\n")
        self.assertEqual((found[0].text, wrong), ("true\n  false\n", []))

    def test_faults_are_told_with_their_line(self):
        for text, line, said in (("```\na\n```\n", 1, "a language"), ("a\n\n    code\n", 3, "indented"),
                                 ("1. a\n\n       code\n", 3, "indented"), ("<!-- block: nought a -->\n```sh\n```\n", 1, "expected a mark"),
                                 ("<!-- block: not run -->\n```sh\n```\n", 1, "expected a mark"),
                                 ("<!-- block: file a -->\n\n```sh\n```\n", 2, "not directly before"),
                                 ("```sh\na\n", 1, "no end"), ("```ruby\n```\n", 1, "found 'ruby'")):
            with self.subTest(text=text):
                wrong = read(text)[1]
                self.assertEqual(len(wrong), 1, wrong)
                self.assertIn(f"docs/page.md:{line}: ", wrong[0])
                self.assertIn(said, wrong[0])

    def test_text_of_a_list_is_no_code(self):
        self.assertEqual(read("1. a\n\n   b\n   - c\n\n     d\n\ne\n")[1], [])

    def test_what_belongs_together_is_one_command(self):
        text = "a   # one\n\n# a comment\nb \\\n  c\ncat <<END\nx '\nEND\nfor i in 1 2; do\n  d\ndone\ne 'x\ny'\n"
        self.assertEqual(commands_of(text), [(0, "a   # one"), (3, "b \\\n  c"), (5, "cat <<END\nx '\nEND"),
                                             (8, "for i in 1 2; do\n  d\ndone"), (11, "e 'x\ny'")])

    def test_a_whole_graph_or_study_is_told_from_a_fragment(self):
        for text, kind in (("extends: wall/scene.yaml\n", "graph"), ("graphs: [a]\n", "study"), ("nodes: {}\n", "fragment"),
                           ("duration: 1 s\nnodes: {}\nedges: []\n", "graph"), ("{\n", "fragment")):
            self.assertEqual(blocks.Block(pathlib.Path("a"), 1, "yaml", text, []).kind(), kind)


if __name__ == "__main__":
    unittest.main()
