#!/usr/bin/python3
"""The fenced code blocks of the pages, with the marks that say how they are tested.

    tests/docs/blocks.py --counts    # how many there are, and what is done with them, as JSON

A mark is an HTML comment on the lines directly before a fence:

    <!-- block: not run, REASON -->       neither run nor checked
    <!-- block: checked, REASON -->       sh: programs, options, graphs and studies are checked, nothing is run
    <!-- block: until TEXT -->            sh: a command that goes on is ended by SIGINT once it has written TEXT
    <!-- block: with VERB OPTIONS -->     sh: each `tactor VERB` gets these options, in the place of its own, so that the test costs less
    <!-- block: file NAME -->             write the block to NAME in the page's folder, for the blocks after it
    <!-- block: over SCENE -->            yaml: check it laid over that shipped scene
    <!-- block: inside FILE -->           cpp: compile it in the place of `BLOCK;` in tests/docs/inside/FILE
    <!-- block: first COMMAND -->         a command that is run before the block, and not shown
    <!-- block: then COMMAND -->          a command that is run after it, and not shown
"""
import collections
import dataclasses
import json
import pathlib
import re
import sys

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
INSIDE = pathlib.Path(__file__).resolve().parent / "inside"

# What is done with a block of each language that has no mark.
RUN = ("sh", "python", "pycon", "cpp")
PARSED = ("yaml", "json", "cmake")
SHOWN = ("text", "console", "csv", "xml", "mermaid")
MARKS = {"not run": ",", "checked": ",", "until": " ", "with": " ", "file": " ", "over": " ", "inside": " ", "first": " ", "then": " "}
# Pages that another test runs as a whole.
ELSEWHERE = {"docs/notebooks": "scripts/notebooks runs it"}


@dataclasses.dataclass
class Block:
    """A fenced block: where it is, what it says, and (kind, text) of each of its marks."""

    page: pathlib.Path
    line: int  # of its first line of text
    language: str
    text: str
    marks: list

    def __str__(self):
        return f"{name_of(self.page)}:{self.line - 1}"

    def mark(self, kind):
        """The text of the first mark of this kind, or None."""
        return next((text for found, text in self.marks if found == kind), None)

    def all_marks(self, kind):
        return [text for found, text in self.marks if found == kind]

    def fate(self):
        """What is done with it: run, checked, parsed, written, shown or not run."""
        for kind in ("not run", "checked"):
            if self.mark(kind) is not None:
                return kind
        if self.language in RUN and (self.mark("file") is None or self.language in ("sh", "cpp")):
            return "run"
        if self.language == "yaml" and (self.mark("over") is not None or self.all_marks("then") or self.kind() != "fragment"):
            return "checked"
        if self.mark("file") is not None:
            return "written"
        return "parsed" if self.language in PARSED else "shown"

    def kind(self):
        """Of a yaml block: a whole `graph`, a `study`, or a `fragment`."""
        try:
            content = yaml.safe_load(self.text)
        except yaml.YAMLError:
            return "fragment"
        keys = set(content) if isinstance(content, dict) else set()
        if "graphs" in keys:
            return "study"
        return "graph" if "extends" in keys or {"nodes", "edges", "duration"} <= keys else "fragment"


def name_of(page):
    page = pathlib.Path(page).resolve()
    return page.relative_to(ROOT).as_posix() if page.is_relative_to(ROOT) else page.name


def read_mark(comment):
    """(kind, text) of `<!-- block: ... -->`, or None where that is no mark."""
    said = re.fullmatch(r"\s*<!-- block: (.*?) -->\s*", comment)
    for kind, separator in MARKS.items():
        if said and said[1].startswith(kind + separator) and said[1][len(kind) + 1:].strip():
            return kind, said[1][len(kind) + 1:].strip()
    return None


def read(page, text=None):
    """The blocks of a page, and what is wrong with its fences and marks, as lines."""
    blocks, wrong = [], []
    fence, marks, lists, after_blank = None, [], [0], True
    for number, line in enumerate((page.read_text() if text is None else text).splitlines(), 1):
        place = f"{name_of(page)}:{number}"
        bare = line.lstrip(" ")
        indent = len(line) - len(bare)
        if fence:
            if re.fullmatch(re.escape(fence[1]) + re.escape(fence[1][0]) + r"*\s*", bare):
                blocks.append(Block(page, fence[3], fence[2], "".join(fence[4]), fence[5]))
                fence, marks = None, []
            else:
                fence[4].append(line[min(indent, fence[0]):] + "\n")
            after_blank = False
            continue
        opened = re.match(r"(```+|~~~+)\s*([^`]*)$", bare)
        if opened:
            language = opened[2].strip()
            if language not in (*RUN, *PARSED, *SHOWN):
                wrong.append(f"{place}: expected a fence with a language ({', '.join((*RUN, *PARSED, *SHOWN))}), found '{language}'")
            fence = [indent, opened[1], language, number + 1, [], marks]
            continue
        if marks and not bare.startswith("<!-- block"):
            wrong.append(f"{place}: a mark is not directly before a fence")
            marks = []
        if bare.startswith("<!-- block"):
            mark = read_mark(line)
            if mark is None:
                wrong.append(f"{place}: expected a mark ({', '.join(MARKS)}) with its text, found {bare}")
            else:
                marks.append(mark)
        elif bare:
            while after_blank and indent < lists[-1]:
                lists.pop()
            item = re.match(r"([-*+]|\d+[.)])( +)(?=\S)", bare)
            if after_blank and indent - lists[-1] >= 4 and not run_elsewhere(page):
                wrong.append(f"{place}: code that is indented; fence it")
            elif item:
                while indent < lists[-1]:
                    lists.pop()
                lists.append(indent + len(item[0]))
        after_blank = not bare
    if fence:
        wrong.append(f"{name_of(page)}:{fence[3] - 1}: the fence has no end")
    return blocks, wrong


def pages(root=ROOT):
    """Every page whose blocks are tested."""
    found = [root / "README.md", root / "CONTRIBUTING.md"]
    for folder in ("docs", "graphs", "meshes", "examples", "bench"):
        found += sorted(page for page in (root / folder).rglob("*.md")
                        if not any(part.startswith(("_", ".")) for part in page.relative_to(root).parts))
    return found


def run_elsewhere(page):
    """The reason why this test does not run the page, or None."""
    return next((reason for folder, reason in ELSEWHERE.items() if name_of(page).startswith(folder + "/")), None)


def counts():
    """How many blocks there are, by language and by what is done with them."""
    languages = collections.defaultdict(collections.Counter)
    fates, reasons, number = collections.Counter(), collections.Counter(), 0
    for page in pages():
        blocks = read(page)[0]
        number += bool(blocks)
        for block in blocks:
            fate = "run elsewhere" if run_elsewhere(page) and block.fate() == "run" else block.fate()
            languages[block.language][fate] += 1
            fates[fate] += 1
            if fate == "not run":
                reasons[block.mark("not run")] += 1
    return {"pages": number, "blocks": sum(fates.values()), "fates": dict(sorted(fates.items())),
            "languages": {name: dict(sorted(of.items())) for name, of in sorted(languages.items())},
            "not_run": dict(sorted(reasons.items()))}


if __name__ == "__main__":
    if sys.argv[1:] != ["--counts"]:
        sys.exit(__doc__)
    print(json.dumps(counts(), indent=1, ensure_ascii=False))
