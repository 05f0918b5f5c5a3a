"""Runs the blocks of pages: `blocks_test.py PAGE_OR_FOLDER...`, by default all. blocks.py tells what the marks mean."""
import os
import re
import resource
import sys
import unittest

import blocks
from page_runner import BUILD, TACTOR, Failed, PageRunner


class Blocks(unittest.TestCase):
    """A test a page, added below."""

    def run_page(self, page):
        runner = PageRunner(page)
        self.addCleanup(runner.close)
        for block in blocks.read(page)[0]:
            with self.subTest(block=str(block)):
                failure = None
                try:
                    runner.run(block)
                except Failed as failed:
                    failure = f"{block}: {failed}"
                if failure:
                    self.fail(failure)


def test_of(page):
    def test(self):
        self.run_page(page)
    test.__doc__ = blocks.name_of(page)
    return test


def main():
    asked = [(blocks.ROOT / word).resolve() for word in sys.argv[1:] if not word.startswith("-")] or [blocks.ROOT]
    for path in asked:
        if not path.exists():
            sys.exit(f"no page or folder {path}")
    for page in blocks.pages():
        if any(page.is_relative_to(path) for path in asked) and not blocks.run_elsewhere(page) and blocks.read(page)[0]:
            setattr(Blocks, "test_" + re.sub(r"\W", "_", blocks.name_of(page)), test_of(page))
    if not TACTOR.exists() or not (BUILD / "python/tactor").is_dir():
        print("the pages need the command and the Python package")
        sys.exit(77)
    os.chdir(blocks.ROOT)
    program = unittest.main(argv=sys.argv[:1], exit=False, verbosity=2)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{used.ru_utime + used.ru_stime:.1f} s of processors")
    sys.exit(not program.result.wasSuccessful())


if __name__ == "__main__":
    main()
