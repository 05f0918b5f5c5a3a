"""A block that does not do what its page says is found, and told with its line."""
import pathlib
import unittest

import blocks
from page_runner import Failed, PageRunner, with_options

PAGE = pathlib.Path("page.md")


class PageRunnerTest(unittest.TestCase):
    def setUp(self):
        self.runner = PageRunner(PAGE)
        self.addCleanup(self.runner.close)

    def run_text(self, text):
        """Runs the blocks of a page."""
        found, wrong = blocks.read(PAGE, text)
        self.assertEqual(wrong, [])
        for block in found:
            self.runner.run(block)

    def refused(self, text, said):
        with self.assertRaises(Failed) as caught:
            self.run_text(text)
        self.assertIn(said, str(caught.exception))


class Shell(PageRunnerTest):
    def test_blocks_share_folder_and_environment(self):
        self.run_text("```sh\nmkdir a\ncd a\nexport WORD='two words'\n```\n"
                      "```sh\n[ \"$WORD\" = 'two words' ]\n[ \"$(basename \"$PWD\")\" = a ]\n[ -z \"$(ls)\" ]\n```\n")

    def test_a_command_that_fails_is_told_with_its_line(self):
        self.refused("```sh\ntrue\nls no-such-file\n```\n", "page.md, line 3: `ls no-such-file` ended with 2:")

    def test_what_fails_beside_another_command_is_seen(self):
        self.refused("```sh\nsleep 60 & false; kill %1\n```\n", "ended with 1")

    def test_a_command_that_goes_on_is_ended_at_its_text(self):
        self.run_text("<!-- block: until ready -->\n```sh\necho ready; sleep 600\n```\n")
        self.refused("<!-- block: until ready -->\n```sh\necho done\n```\n", "no command has written 'ready'")

    def test_what_a_command_leaves_in_the_background_ends_with_it(self):
        self.run_text("```sh\n(sleep 1; touch late) &\n```\n```sh\nsleep 2\n[ ! -e late ]\n```\n")

    def test_hidden_commands_run_before_and_after(self):
        self.run_text("<!-- block: first touch a -->\n<!-- block: then test -e b -->\n```sh\ncp a b\n```\n")
        self.refused("<!-- block: then test -e c -->\n```sh\ntrue\n```\n", "`test -e c` ended with 1")

    def test_options_of_a_mark_are_given_in_the_place_of_those_shown(self):
        for command, given in (('tactor run a --duration "3 s" --out b   # c', 'tactor run --duration "1 s" a --out b   # c'),
                               ("tactor emulate usb x -- tactor run a --duration=3", 'tactor emulate usb x -- tactor run --duration "1 s" a'),
                               ("tactor run a; tactor check b --duration 2", 'tactor run --duration "1 s" a; tactor check b --duration 2'),
                               ("tactor run a; tactor runs", 'tactor run --duration "1 s" a; tactor runs'),
                               ("tactor check a --duration 3 && tactor run b", 'tactor check a --duration 3 && tactor run --duration "1 s" b')):
            self.assertEqual(with_options(command, 'run --duration "1 s"'), given)
        self.run_text('<!-- block: with check --over kalman -->\n```sh\ntactor check wall/scene\n```\n')
        self.refused('<!-- block: with check --over no_such -->\n```sh\ntactor check wall/scene\n```\n', "no_such")
        self.refused('<!-- block: with run --seeds 1 -->\n```sh\ntactor check wall/scene\n```\n', "no command takes 'run --seeds 1'")

    def test_a_view_opens_and_ends(self):
        self.run_text("<!-- block: until Ctrl-C ends it -->\n```sh\ntactor view wall/scene\n```\n")


class Checked(PageRunnerTest):
    def test_commands_are_checked_without_a_run(self):
        self.run_text("<!-- block: checked, for a test -->\n```sh\n"
                      "tactor run wall/scene --over kalman --set \"coupling.k_0=800 N/m\" --out here\n"
                      "A=1 scripts/compile_times --over 20 && sudo tactor devices  # both\n"
                      "cmake --preset release && cmake --build --preset release\n"
                      "tactor study methods --short\ntactor emulate usb polhem -- tactor run duck/polhem\n```\n")
        self.assertEqual(list(self.runner.work.iterdir()), [])

    def test_what_does_not_exist_is_told(self):
        for command, said in (("tactor walk wall/scene", "no verb walk"), ("tactor run wall/scene --faster", "no option --faster"),
                              ("tactor run wall/nothing", "wall/nothing"), ("tactor run wall/scene --set coupling.k_9=1", "k_9"),
                              ("tactor study no_such_study", "no_such_study"), ("scripts/nothing", "scripts/nothing is not there"),
                              ("scripts/test --faster", "no option --faster"), ("no-such-program a", "no program no-such-program"),
                              ("cmake --preset faster", "no configurePresets faster"), ("build/release/tests/test_of_nothing", "test_of_nothing"),
                              ("scripts/compare_builds tests/nothing", "tests/nothing does not exist"),
                              ("tactor emulate usb polhem -- tactor run duck/nothing", "duck/nothing")):
            with self.subTest(command=command):
                self.refused(f"<!-- block: checked, for a test -->\n```sh\n{command}\n```\n", said)


class Languages(PageRunnerTest):
    def test_python_has_one_namespace_a_page(self):
        self.run_text("```python\na = 2\n```\n```sh\necho 3 > b\n```\n```python\nassert a + int(open('b').read()) == 5\n```\n"
                      "```pycon\n>>> a\n2\n```\n")

    def test_an_exception_is_told_with_the_line_of_the_page(self):
        self.refused("```python\na = 1\n```\n\n```python\nb = 2\n1 / 0\n```\n", 'page.md", line 7')

    def test_numbers_of_a_session_may_differ_in_their_last_digits(self):
        self.run_text("```pycon\n>>> {'a': 1 / 3}\n{'a': 0.3333}\n```\n")
        self.refused("```pycon\n>>> 1 / 3\n0.34\n```\n", "Expected:")
        self.refused("```pycon\n>>> 'b', 1\n('a', 1)\n```\n", "Expected:")

    def test_graphs_and_fragments_are_checked(self):
        self.run_text("```yaml\nextends: wall/scene.yaml\nseed: 2\n```\n<!-- block: over wall/scene -->\n```yaml\nnodes: {coupling: {k_0: 1 N/m}}\n```\n")
        self.refused("```yaml\nextends: wall/scene.yaml\nsed: 2\n```\n", "sed: expected a key")
        self.refused("<!-- block: over wall/scene -->\n```yaml\nnodes: {coupling: {k_9: 1 N/m}}\n```\n", "k_9")
        self.refused("```yaml\na: {\n```\n", "no YAML")

    def test_cpp_is_compiled(self):
        self.run_text("```cpp\n#include \"framework/core/messages.hpp\"\ntactor::Wrench force;\n```\n")
        self.refused("```cpp\n#include \"framework/core/messages.hpp\"\n\ntactor::Wrenches force;\n```\n", "page.md:4:")

    def test_cmake_and_json_are_parsed(self):
        self.run_text("```cmake\ntactor_add_nodes(a SOURCES b.cpp)\n```\n```json\n{\"a\": 1}\n```\n")
        self.refused("```cmake\ntactor_make_coffee(a)\n```\n", "no command tactor_make_coffee")
        self.refused("```cmake\nset(a\n```\n", "no CMake")
        self.refused("```json\n{a: 1}\n```\n", "no JSON")

    def test_a_block_that_is_not_run_is_not(self):
        self.run_text("<!-- block: not run, for a test -->\n```sh\nfalse\n```\n")


if __name__ == "__main__":
    unittest.main()
