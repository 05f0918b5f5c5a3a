"""The pages of the site, out of those of the repository.

Pages are written for the repository: a link is a path in it. The site has a copy in which every link leads to a page, so that it
works from a folder, without the network. A link to a source file leads to a page with its text, one to a folder to a list of its files.
"""
import os
import pathlib
import re
import shutil
import sys

LANGUAGES = {".cpp": "cpp", ".hpp": "cpp", ".py": "python", ".yaml": "yaml", ".csv": "text", ".sh": "sh", ".json": "json", ".txt": "text",
             ".cmake": "cmake", ".ts": "typescript", ".dot": "dot"}
PICTURES = {".svg", ".png", ".jpg", ".webp"}
LINK = re.compile(r"\]\(([^)\s]+)\)|\b(?:src|srcset|href)=\"([^\"]+)\"")
FILE_NAME = re.compile(r"\[([\w./]+\.md)\]\($")
TOCTREE = re.compile(r"(?ms)^```\{toctree\}\n(.*?)^```\n")
# Folders in their order, with the titles of those whose page of contents nobody wrote.
FOLDERS = {"start": "Start", "tutorials": "Tutorials", "notebooks": "Notebooks", "coming_from": "Coming from", "howto": "How-to guides",
           "explanation": "Explanation", "reference": "Reference", "results": "Results", "trust": "Trust"}
# Pages in the order in which they are read, of folders whose page of contents does not name them.
ORDER = ["install", "first_minute", "first_scene", "a_graph_line_by_line", "next",
         "touch_a_bunny", "own_mesh", "soft_tissue", "own_predictor_python", "own_predictor_cpp", "own_modbus_motor", "cluster_study",
         "nodes", "graph_keys", "message_types", "metrics_list", "verbs"]
# The parts of the contents at the side; what does not exist is left out.
PARTS = {
    "Begin": ["start/index", "tutorials/index", "notebooks/index", "coming_from/index", "gallery"],
    "Use": ["howto/index", "graphs/index", "meshes", "examples/index", "troubleshooting"],
    "Understand": ["explanation/index", "glossary"],
    "Look up": ["reference/index"],
    "Judge": ["results/index", "trust/index"],
    "Project": ["contributing", "changelog", "cite", "files/LICENSE"],
}


def without_code(text):
    """The text with the characters of code and comments blanked, at the same places."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match.group(0))
    text = re.sub(r"(?ms)^([ >]*)(```+|~~~+)[^\n]*\n.*?^[ >]*\2[ ]*$", blank, text)
    text = re.sub(r"(?s)<!--.*?-->", blank, text)
    return re.sub(r"(?<!`)(`+)(?!`)(?:(?!\n\n).)+?(?<!`)\1(?!`)", blank, text, flags=re.DOTALL)


def links_of(text):
    """The places and targets of the links in a page, those of code left out."""
    for match in LINK.finditer(without_code(text)):
        group = 1 if match.group(1) else 2
        yield match.start(group), match.end(group), match.group(group)


def title_of(text, fallback):
    match = re.search(r"(?m)^# (.+)$", without_code(text)) and re.search(r"(?m)^# (.+)$", text)
    return match.group(1) if match else fallback


def first_sentence(text):
    """What a page says first under its title, without links."""
    masked = without_code(text)
    title = re.search(r"(?m)^# .*\n", masked)
    for paragraph in re.finditer(r"(?m)^.*\S.*(?:\n.*\S.*)*", masked[title.end():] if title else ""):
        words = text[title.end() + paragraph.start():title.end() + paragraph.end()]
        if re.match(r"[\w`\[(]", words):
            return re.split(r"(?<=[.:])\s", re.sub(r"\]\([^)]*\)|\[", "", " ".join(words.split())))[0].rstrip(":")
    return ""


def place_of(name):
    """Where a page stands among those that no page of contents names."""
    stem = pathlib.PurePosixPath(name).stem
    return ORDER.index(stem) if stem in ORDER else len(ORDER)


def page_name(path):
    """Where a page of the repository is in the site."""
    parts = list(pathlib.PurePosixPath(path).parts)
    if parts[0] == "docs":
        return "/".join(parts[1:])
    if parts[-1] == "README.md":
        folder = "/".join(parts[:-1])
        if not folder:
            return "readme.md"
        return f"{folder}/index.md" if folder in ("graphs", "examples") else f"{folder}.md"
    return "/".join(parts[:-1] + [parts[-1].lower()])


class Sources:
    """The pages of the repository at `root`, and those of `made` (texts by their names in the site), to be written to `target`."""

    def __init__(self, root, target, made):
        self.root, self.target = root, target
        found = [*root.glob("*.md"), *(root / "docs").rglob("*.md"), *(root / "graphs").rglob("README.md"), *(root / "meshes").glob("README.md"),
                 *(root / "examples").rglob("README.md"), *(root / "bench").rglob("README.md")]
        self.pages = {file.relative_to(root).as_posix(): page_name(file.relative_to(root).as_posix()) for file in sorted(found)}
        self.texts = dict(made)
        self.more, self.broken = [], []
        self.copied = set()

    def write(self):
        shutil.rmtree(self.target, ignore_errors=True)
        self.target.mkdir(parents=True)
        for path, name in self.pages.items():
            self.texts[name] = self.rewritten(path, name, (self.root / path).read_text())
        written = set()
        self.need_file("LICENSE")
        while self.more:
            path = self.more.pop()
            if path not in written:
                written.add(path)
                self.write_file(path)
        if self.broken:
            sys.exit("\n".join(self.broken))
        self.add_contents()
        for name, text in self.texts.items():
            file = self.target / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)

    # Links

    def rewritten(self, path, name, text):
        out, last = [], 0
        for begin, end, link in links_of(text):
            out += [self.titled(path, text[last:begin], link), self.link(path, name, link)]
            last = end
        return "".join(out) + text[last:]

    def titled(self, path, before, link):
        """The text before the target of a link. Where the link shows the name of a page's file, the site shows the page's title."""
        file = self.root / os.path.normpath(pathlib.PurePosixPath(path).parent / link.partition("#")[0])
        shown = FILE_NAME.search(before)
        if not shown or shown.group(1) not in file.as_posix() or not file.is_file():
            return before
        title = title_of(file.read_text(), shown.group(1))
        begins = re.search(r"(^|[.:]\s|\n\s*\n|[-*|]\s)$", before[:shown.start()]) or not title[1:2].islower()
        return before[:shown.start()] + "[" + (title if begins else title[0].lower() + title[1:]) + "]("

    def link(self, path, name, link):
        """The link of a page, as it is in the site."""
        if re.match(r"[a-z]+:", link) or link.startswith("#"):
            return link
        target, mark, anchor = link.partition("#")
        file = pathlib.Path(os.path.normpath(self.root / pathlib.PurePosixPath(path).parent / target))
        if not file.exists() or self.root not in (file, *file.parents):
            self.broken.append(f"{path}: no file for the link {link}")
            return link
        if file.is_dir() and (file / "index.md").exists():
            file = file / "index.md"
        elif file.is_dir() and (file / "README.md").exists():
            file = file / "README.md"
        there = file.relative_to(self.root).as_posix()
        if there in self.pages:
            there = self.pages[there]
        elif file.suffix in PICTURES:
            there = self.copy_picture(there)
        else:
            there, mark, anchor = self.need_file(there), "", ""
        return os.path.relpath(there, pathlib.PurePosixPath(name).parent) + mark + anchor

    def copy_picture(self, path):
        there = path.removeprefix("docs/")
        if path not in self.copied:
            self.copied.add(path)
            file = self.target / there
            file.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(self.root / path, file)
        return there

    # Files of the repository that pages link to

    def need_file(self, path):
        self.more.append(path)
        return f"files/{path}/index.md" if (self.root / path).is_dir() else f"files/{path}.md"

    def write_file(self, path):
        file, name = self.root / path, self.need_file(path)
        self.more.pop()
        head = "---\norphan: true\n---\n\n" if path != "LICENSE" else ""
        title = f"# {'Licence' if path == 'LICENSE' else f'`{path}`'}\n\n"
        if file.is_dir():
            lines = []
            for inner in sorted(file.iterdir()):
                if inner.name.startswith((".", "__pycache__")):
                    continue
                link = self.link(f"{path}/x", name, inner.name)
                lines.append(f"- [`{inner.name}`]({link})\n")
            self.texts[name] = head + title + "".join(lines)
            return
        text = file.read_text()
        language = LANGUAGES.get(file.suffix, "cmake" if file.name == "CMakeLists.txt" else "python" if text.startswith("#!/usr/bin/python")
                                 else "sh" if text.startswith("#!") else "text")
        fence = "`" * max(4, 1 + max((len(run) for run in re.findall("`+", text)), default=0))
        self.texts[name] = f"{head}{title}{fence}{language}\n{text.rstrip()}\n{fence}\n"

    # Contents

    def add_contents(self):
        names = sorted(self.texts)
        for folder, title in FOLDERS.items():
            if any(name.startswith(f"{folder}/") for name in names):
                self.texts.setdefault(f"{folder}/index.md", f"# {title}\n")
        for name in sorted(self.texts):
            folder, _, last = name.rpartition("/")
            if name.startswith("files/") or name == "index.md":
                continue
            if last == "index.md":
                self.list_folder(name, folder, told=True)
            elif any(other.startswith(name.removesuffix(".md") + "/") for other in names):
                self.list_folder(name, name.removesuffix(".md"), told=False)
        contents = ""
        placed = {page for pages in PARTS.values() for page in pages}
        others = [name.removesuffix(".md") for name in sorted(self.texts) if "/" not in name and name not in ("index.md", "readme.md")]
        for part, pages in PARTS.items():
            there = [page for page in pages if f"{page}.md" in self.texts]
            if part == "Project":
                there += [page for page in others if page not in placed]
            contents += f"\n```{{toctree}}\n:hidden:\n:caption: {part}\n\n" + "\n".join(f"/{page}" for page in there) + "\n```\n"
        self.texts["index.md"] += contents
        # Pages outside of the contents: the README, which the home page stands for, and those of bench/.
        for name, text in self.texts.items():
            if name == "readme.md" or name.startswith("bench/"):
                self.texts[name] = "---\norphan: true\n---\n\n" + text

    def list_folder(self, name, folder, told):
        """Adds the contents of a folder: first what the page names (in a toctree of its own, in links), then all other pages by their titles."""
        inside = [other for other in self.texts if other.startswith(f"{folder}/") and other != name
                  and self.owner(other) == name]
        linked = []
        named = [f"{line}.md" for contents in TOCTREE.findall(self.texts[name]) for line in contents.split() if not line.startswith(":")]
        self.texts[name] = TOCTREE.sub("", self.texts[name])
        for link in named + [link for _, _, link in links_of(self.texts[name])]:
            there = os.path.normpath(pathlib.PurePosixPath(name).parent / link.partition("#")[0])
            if there in inside and there not in linked:
                linked.append(there)
        rest = sorted((other for other in inside if other not in linked), key=lambda other: (place_of(other), title_of(self.texts[other], other).lower()))
        if rest and told:
            heading = "\n## More\n\n" if linked else "\n"
            self.texts[name] += heading + "".join(self.line_of(other, folder) for other in rest)
        self.texts[name] += "\n```{toctree}\n:hidden:\n\n" + "\n".join("/" + other.removesuffix(".md") for other in linked + rest) + "\n```\n"

    def line_of(self, name, folder):
        text = self.texts[name]
        said = first_sentence(text)
        return f"- [{title_of(text, name)}]({os.path.relpath(name, folder)}){': ' + said if said else ''}\n"

    def owner(self, name):
        """The page that has this one in its contents: that of its folder, or the page with the folder's name."""
        folder = pathlib.PurePosixPath(name).parent
        if name.endswith("/index.md"):
            folder = folder.parent
        for page in (f"{folder}.md", f"{folder}/index.md"):
            if page in self.texts and page != name:
                return page
        return self.owner(f"{folder}/index.md") if len(folder.parts) > 1 else ""
