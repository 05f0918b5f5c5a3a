"""Runs the Python of a page: reads blocks as JSON lines, answers each with the error that it ended with, or null."""
import doctest
import json
import os
import re
import sys
import traceback

NAMES = {"__name__": "__main__"}
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


class Checker(doctest.OutputChecker):
    """Numbers may differ in their last digits: processors round differently."""

    def check_output(self, want, got, optionflags):
        if super().check_output(want, got, optionflags):
            return True
        wanted, found = (NUMBER.findall(text) for text in (want, got))
        return (len(wanted) == len(found) and NUMBER.sub("#", want).split() == NUMBER.sub("#", got).split()
                and all(abs(float(a) - float(b)) <= 1e-3 * abs(float(a)) for a, b in zip(wanted, found)))


def run(block):
    # Tracebacks then name the line of the page.
    source = "\n" * (block["line"] - 1) + block["text"]
    if block["language"] == "python":
        exec(compile(source, block["page"], "exec"), NAMES)  # pylint: disable=exec-used
        return None
    test = doctest.DocTestParser().get_doctest(source, NAMES, block["page"], block["page"], 0)
    test.globs = NAMES
    said = []
    runner = doctest.DocTestRunner(Checker(), verbose=False, optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    runner.run(test, out=said.append, clear_globs=False)
    return "".join(said) if runner.failures else None


def main():
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what the blocks print goes where errors go
    for line in sys.stdin:
        try:
            error = run(json.loads(line))
        except BaseException:  # pylint: disable=broad-exception-caught
            error = traceback.format_exc()
        sys.stdout.flush()
        answers.write(json.dumps(error) + "\n")
        answers.flush()


main()
