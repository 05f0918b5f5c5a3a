"""What pages of results are made of: every key of a template gets its value, and every template knows its keys."""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "bench"))
import page  # noqa: E402


class Page(unittest.TestCase):
    def test_keys_are_replaced_and_ends_of_lines_are_the_templates(self):
        self.assertEqual(page.filled("a {{ONE}}, {{TWO}}; {{ONE}}\n", {"ONE": "1\n\n", "TWO": "2"}), "a 1, 2; 1\n")

    def test_a_key_without_a_value_is_an_error_that_names_it(self):
        with self.assertRaisesRegex(ValueError, r"\{\{THREE\}\}"):
            page.filled("{{ONE}} and {{THREE}}", {"ONE": "1"})

    def test_scripts_give_every_key_of_their_templates(self):
        templates = sorted((page.ROOT / "scripts").glob("*.template.md"))
        self.assertGreaterEqual(len(templates), 4)
        for template in templates:
            script = template.with_name(template.name.removesuffix(".template.md")).read_text()
            for key in set(page.KEY.findall(template.read_text())):
                self.assertIn(f'"{key}":', script, template.name)

    def test_a_block_is_found_between_its_marks_and_a_missing_one_is_an_error(self):
        text = "a\n<!-- one: begin -->\nold\n<!-- one: end -->\nb\n"
        self.assertEqual(page.around(text, "one"), ("a\n<!-- one: begin -->", "\nold\n", "<!-- one: end -->\nb\n"))
        with self.assertRaisesRegex(ValueError, "two"):
            page.around(text, "two")

    def test_versions_are_those_of_installed_packages(self):
        found = page.versions(["dpkg"])
        self.assertEqual(list(found), ["dpkg"])
        self.assertRegex(found["dpkg"], r"^\d")


if __name__ == "__main__":
    unittest.main()
